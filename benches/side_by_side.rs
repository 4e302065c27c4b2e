//! The jointid side of `benches/side_by_side.py`: repeats one task and prints its results and times as one
//! line of JSON.
//!
//! Without a task, as called by `cargo bench`, it prints how it is used.

#[path = "../tests/support/coupling.rs"]
mod coupling;
mod support;

use std::fs::File;
use std::hint::black_box;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use clap::{Parser, Subcommand};
use config::{read_machine, read_machine_text};
use dynamics::model::{AssembledModel, RodModel, Structure, matrices};
use identification::objective::{FrfObjective, FrfSettings, ModeObjective, ModeSettings};
use identification::{IdentificationSettings, Place, identify};
use long_work::{Control, Progress};
use machine::{Machine, Operating};
use measurement::{MeasurementSet, read_set};
use num_complex::Complex64;
use numeric::unit::omega_rad_s;
use optimizer::{Cost, LeastSquares, SearchSettings, search};
use report::document::Input;
use serde_json::{Value, json};
use study::{Study, simulation};
use support::simulated_frfs;
use universal_files::{
    Abscissa, ByteOrder, Encoding, NodeLocation, Ordinate, RecordAxis, UniversalRecord, UniversalWriter, read,
};

/// Nut positions l1, l3 and l5 of the bench (m).
const FITTED_M: [f64; 3] = [0.6, 1.0, 1.6];

/// A screw between two bearings: the smallest coupling problem.
const SCREW: &str = r#"
title = "a screw between its bearings"
point = [{ name = "left", motion = "translation" }, { name = "table", motion = "translation" }, { name = "right", motion = "translation" }]
joint = [
    { name = "left", between = ["left", "ground"], stiffness = 5e7, damping = 1e3 },
    { name = "right", between = ["right", "ground"], stiffness = 5e7, damping = 1e3 },
]
[[shaft]]
name = "screw"
length_m = 2.6
diameter_m = 0.040
youngs_modulus_pa = 2e11
shear_modulus_pa = 7.75e10
density_kg_m3 = 7850.0
station = [{ at = "start", axial = "left" }, { at = "nut", axial = "table" }, { at = "end", axial = "right" }]
"#;

#[derive(Parser)]
#[command(about = "Tasks that benches/side_by_side.py compares with other programs")]
struct Arguments {
    #[command(subcommand)]
    task: Option<Task>,
    /// Number of threads.
    #[arg(long, global = true, default_value_t = 1)]
    threads: usize,
    /// Number of repetitions of the task.
    #[arg(long, global = true, default_value_t = 1)]
    repeats: usize,
    /// Flag that cargo passes to every bench.
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Subcommand)]
enum Task {
    /// Receptances of the bench's table at the three fitted positions, 1–2000 Hz, for given values of its ten
    /// free parameters.
    Receptances {
        /// JSON list of unit-cube coordinates.
        places: PathBuf,
    },
    /// Objective on modes of three positions, for given values of its eight free parameters.
    Modes {
        /// JSON list of unit-cube coordinates.
        places: PathBuf,
        /// Print the peaks, too.
        #[arg(long)]
        peaks: bool,
    },
    /// Differential evolution on the objective on modes.
    Search {
        /// Number of members.
        #[arg(long, default_value_t = 120)]
        population: usize,
        /// Number of generations after the first.
        #[arg(long, default_value_t = 200)]
        generations: u64,
        /// Seed.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// χ² of whole FRFs, three positions × 1,000 lines, for given values of ten free parameters.
    Frfs {
        /// JSON list of unit-cube coordinates.
        places: PathBuf,
    },
    /// Substructure coupling at 1,000 lines, of the bench or the bare screw.
    Coupling {
        /// `bench` or `screw`.
        machine: String,
        /// Compute all receptances by receptance coupling instead of one by elimination.
        #[arg(long)]
        all: bool,
    },
    /// Receptances of the bench with lumped rods, 1,000 lines.
    Lumped {
        /// Number of springs per rod.
        lumps: usize,
        /// Print the matrices, too, so that another program can compute the same.
        #[arg(long)]
        matrices: bool,
    },
    /// Writes 60 FRFs of 6,401 lines as a universal file.
    WriteUniversal {
        /// Path of the file.
        file: PathBuf,
        /// Write dataset 58b.
        #[arg(long)]
        binary: bool,
    },
    /// Reads a universal file.
    ReadUniversal {
        /// Path of the file.
        file: PathBuf,
    },
    /// Default identification of the bench.
    Identify,
    /// FRF of the identified bench, 1,000 lines at one nut position, as the Python package calls it.
    IdentifiedFrf,
    /// One identification of the bench from whole FRFs with noise, three positions × 1,000 lines, with the
    /// covariance of the estimates.
    IdentifyFrfs {
        /// Seed.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Compute intervals by profile likelihood, too.
        #[arg(long)]
        profile: bool,
    },
}

fn main() {
    let arguments = Arguments::parse();
    let Some(task) = arguments.task else {
        println!(
            "side_by_side: run by benches/side_by_side.py, which compares it with other programs; --help lists its tasks"
        );
        return;
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build()
        .expect("the thread pool can be built");
    println!("{}", pool.install(|| run(&task, arguments.repeats)));
}

/// Measures wall time and, on Linux, the processor time of this thread, which other load on the machine
/// disturbs little.
struct Clock {
    begin: Instant,
    processor_ns: Option<u64>,
}

impl Clock {
    fn start() -> Self {
        Clock { begin: Instant::now(), processor_ns: Self::processor_ns() }
    }

    /// Reads the processor time of this thread (ns). Source: proc(5), schedstat.
    fn processor_ns() -> Option<u64> {
        std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse().ok()
    }

    /// Returns the wall time (s).
    fn wall(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }

    /// Returns the processor time of this thread (s), or the wall time if the system does not state it or
    /// several threads work.
    fn work(&self) -> f64 {
        let alone = rayon::current_num_threads() == 1;
        let spent =
            self.processor_ns.filter(|_| alone).and_then(|before| Some(Self::processor_ns()? - before));
        spent.map_or_else(|| self.wall(), |ns| ns as f64 * 1e-9)
    }
}

/// Repeats `work` and measures its time; `evaluations` are those of one repetition.
fn timed(repeats: usize, evaluations: usize, mut work: impl FnMut()) -> Value {
    let clock = Clock::start();
    (0..repeats).for_each(|_| work());
    json!({ "seconds": clock.work(), "wall": clock.wall(), "evaluations": repeats * evaluations })
}

/// Adds the times to a JSON object.
fn with(mut result: Value, timing: Value) -> Value {
    if let (Value::Object(result), Value::Object(timing)) = (&mut result, timing) {
        result.extend(timing);
    }
    result
}

fn bench() -> (Machine, MeasurementSet) {
    (
        read_machine("configs/tian.toml", &[], &[]).expect("the bench's machine is valid").machine,
        read_set("measurements/tian").expect("the bench's measurements are valid"),
    )
}

fn places(file: &Path) -> Vec<Vec<f64>> {
    serde_json::from_reader(File::open(file).expect("the file of coordinates can be read"))
        .expect("the file is a JSON list of lists of numbers")
}

fn pairs(values: &[Complex64]) -> Vec<[f64; 2]> {
    values.iter().map(|z| [z.re, z.im]).collect()
}

/// Builds the model of the table's driving-point receptance, at the start values and a nut position.
fn table_model(machine: &Machine, nut_m: f64, rods: RodModel) -> (Arc<Structure>, AssembledModel) {
    let table = machine.point("table").expect("the machine has a table");
    let structure = Arc::new(Structure::new(machine, table, table, rods).expect("the table can move"));
    let mut network = structure.empty_model();
    network.update(machine, &machine.start(), &Operating::at_nut(nut_m));
    (structure, network)
}

/// Returns 1,000 lines, 6–1005 Hz, as angular frequencies (rad/s).
fn thousand_lines() -> Vec<f64> {
    (6..1006).map(|f| omega_rad_s(f64::from(f))).collect()
}

fn run(task: &Task, repeats: usize) -> Value {
    match task {
        Task::Receptances { places: file } => receptances(&places(file)),
        Task::Modes { places: file, peaks } => modes(&places(file), *peaks, repeats),
        Task::Search { population, generations, seed } => searched(*population, *generations, *seed),
        Task::Frfs { places: file } => frfs(&places(file), repeats),
        Task::Coupling { machine, all } => coupling(machine, *all, repeats),
        Task::Lumped { lumps, matrices } => lumped(*lumps, *matrices, repeats),
        Task::WriteUniversal { file, binary } => write_universal(file, *binary),
        Task::ReadUniversal { file } => read_universal(file, repeats),
        Task::Identify => identified(repeats),
        Task::IdentifiedFrf => identified_frf(repeats),
        Task::IdentifyFrfs { seed, profile } => identified_from_frfs(*seed, *profile),
    }
}

fn receptances(places: &[Vec<f64>]) -> Value {
    let (machine, _) = bench();
    let (structure, mut network) = table_model(&machine, FITTED_M[0], RodModel::Exact);
    let mut work = structure.workspace();
    let mut all = Vec::new();
    for place in places {
        let parameters: Vec<f64> =
            machine.parameters.iter().zip(place).map(|(p, u)| p.from_unit(*u)).collect();
        for nut_m in FITTED_M {
            network.update(&machine, &parameters, &Operating::at_nut(nut_m));
            all.extend((1..=2000).map(|f| network.receptance(omega_rad_s(f64::from(f)), &mut work)));
        }
    }
    json!({ "receptances": pairs(&all), "parameters": machine.parameters.iter().map(|p| &p.id).collect::<Vec<_>>() })
}

fn modes(places: &[Vec<f64>], with_peaks: bool, repeats: usize) -> Value {
    let (machine, set) = bench();
    let (fit, _) = set.split(None, &[]).expect("the split is valid");
    let objective =
        ModeObjective::new(&machine, &fit, ModeSettings::default(), &[]).expect("the objective is valid");
    let mut costs = vec![0.0; places.len()];
    let timing = timed(repeats, places.len(), || {
        costs.iter_mut().zip(places).for_each(|(cost, place)| *cost = objective.at(black_box(place)));
    });
    let peaks = |place: &Vec<f64>| -> Vec<Vec<[f64; 3]>> {
        let predictions = objective.predict(&objective.parameters(&Place(place.clone())));
        predictions
            .iter()
            .map(|p| p.peaks.iter().map(|p| [p.frequency_hz, p.amplitude, p.prominence]).collect())
            .collect()
    };
    let peaks: Vec<_> = places.iter().filter(|_| with_peaks).map(peaks).collect();
    with(json!({ "costs": costs, "peaks": peaks }), timing)
}

fn searched(population: usize, generations: u64, seed: u64) -> Value {
    let (machine, set) = bench();
    let (fit, _) = set.split(None, &[]).expect("the split is valid");
    let objective =
        ModeObjective::new(&machine, &fit, ModeSettings::default(), &[]).expect("the objective is valid");
    let settings = SearchSettings {
        population,
        generations,
        spread: 0.0,
        ..SearchSettings::for_dimension(objective.dimension(), seed)
    };
    let trace = Arc::new(Mutex::new(Vec::new()));
    let clock = Arc::new(Clock::start());
    let watcher = {
        let (trace, clock) = (Arc::clone(&trace), Arc::clone(&clock));
        Arc::new(move |progressed: Progress<'_>| {
            if let Progress::Generation { best, .. } = progressed {
                trace.lock().expect("no thread has failed").push((clock.work(), best));
            }
        })
    };
    let found = search(&objective, settings, &Control::new(Arc::default(), Some(watcher)));
    let (seconds, wall) = (clock.work(), clock.wall());
    let trace = trace.lock().expect("no thread has failed").clone();
    json!({ "seconds": seconds, "wall": wall, "evaluations": found.evaluations, "cost": found.cost, "place": found.place, "trace": trace })
}

/// Computes the table's FRFs at three positions, 6–1005 Hz, at the start values.
fn table_frfs(machine: &Machine) -> MeasurementSet {
    let lines: Vec<f64> = (6..1006).map(f64::from).collect();
    simulated_frfs(machine, ("table", "table"), &FITTED_M.map(Some), &lines)
}

fn frfs(places: &[Vec<f64>], repeats: usize) -> Value {
    let (machine, _) = bench();
    let set = table_frfs(&machine);
    let (fit, _) = set.split(None, &[]).expect("the set can be fitted as a whole");
    let objective =
        FrfObjective::new(&machine, &fit, FrfSettings::default(), &[]).expect("the objective is valid");
    let mut costs = vec![0.0; places.len()];
    let timing = timed(repeats, places.len(), || {
        costs.iter_mut().zip(places).for_each(|(cost, place)| *cost = objective.chi_square(black_box(place)));
    });
    with(json!({ "costs": costs }), timing)
}

fn coupling(name: &str, all: bool, repeats: usize) -> Value {
    let machine = if name == "screw" {
        read_machine_text("screw", SCREW, &[], &[]).expect("the screw is valid").machine
    } else {
        bench().0
    };
    let (structure, network) = table_model(&machine, FITTED_M[1], RodModel::Exact);
    let mut work = structure.workspace();
    let omegas = thousand_lines();
    let table = machine.point("table").expect("the machine has a table");
    let (start, operating) = (machine.start(), Operating::at_nut(FITTED_M[1]));
    let mut values = vec![Complex64::default(); omegas.len()];
    let timing = timed(repeats, omegas.len(), || {
        if !all {
            values = network.sweep(black_box(&omegas), &mut work);
            return;
        }
        for (value, &omega) in values.iter_mut().zip(&omegas) {
            *value =
                coupling::coupled_receptances(&machine, &start, &operating, black_box(omega))[(table, table)];
        }
    });
    with(json!({ "receptances": pairs(&values) }), timing)
}

fn lumped(lumps: usize, with_matrices: bool, repeats: usize) -> Value {
    let (machine, _) = bench();
    let (structure, mut network) = table_model(&machine, FITTED_M[1], RodModel::Lumped(lumps));
    let mut work = structure.workspace();
    let omegas = thousand_lines();
    let (start, operating) = (machine.start(), Operating::at_nut(FITTED_M[1]));
    let mut values = vec![Complex64::default(); omegas.len()];
    let timing = timed(repeats, omegas.len(), || {
        network.update(&machine, black_box(&start), &operating);
        values = network.sweep(black_box(&omegas), &mut work);
    });
    let rows = |m: &nalgebra::DMatrix<f64>| -> Vec<Vec<f64>> {
        m.row_iter().map(|r| r.iter().copied().collect()).collect()
    };
    let described = with_matrices.then(|| {
        let m = matrices(&machine, &start, &operating, lumps).expect("the matrices can be built");
        let table = m.names.iter().position(|n| n == "table");
        json!({ "mass": rows(&m.mass), "damping": rows(&m.damping), "stiffness": rows(&m.stiffness), "table": table })
    });
    with(json!({ "receptances": pairs(&values), "matrices": described }), timing)
}

fn write_universal(file: &Path, binary: bool) -> Value {
    let mut writer =
        UniversalWriter::new(BufWriter::new(File::create(file).expect("the file can be created")));
    let encoding = if binary { Encoding::Binary(ByteOrder::Little) } else { Encoding::Ascii };
    for node in 1..=60_i32 {
        // A resonance that shifts from record to record.
        let value = |i: usize| {
            let share = i as f64 / (3000.0 + 10.0 * f64::from(node));
            Complex64::new(1e-7, 0.0) / Complex64::new(1.0 - share * share, 0.02 * share)
        };
        let place = |node: i32| NodeLocation { node: node.into(), direction: 3, ..NodeLocation::default() };
        let abscissa = Abscissa::Even { first: 0.0, step: 0.25, count: 6401 };
        let record = UniversalRecord::frequency_response(
            place(node),
            place(1),
            RecordAxis::new(8, "Displacement", "m"),
            abscissa,
            (0..6401).map(value).collect(),
        );
        writer.record(&record, encoding).expect("the record can be written");
    }
    writer.finish().expect("the file can be finished");
    json!({ "bytes": std::fs::metadata(file).expect("the file exists").len() })
}

fn read_universal(file: &Path, repeats: usize) -> Value {
    let mut found = None;
    let open = || File::open(black_box(file)).expect("the universal file can be opened");
    let timing = timed(repeats, 1, || found = Some(read(open()).expect("the universal file is valid")));
    let functions = found.map(|r| r.functions).unwrap_or_default();
    let sum_of = |ordinate: &Ordinate| match ordinate {
        Ordinate::Complex(values) => values.iter().sum::<Complex64>(),
        Ordinate::Real(values) => values.iter().sum::<f64>().into(),
    };
    let sum: Complex64 = functions.iter().map(|f| sum_of(&f.ordinate)).sum();
    with(json!({ "records": functions.len(), "sum": [sum.re, sum.im] }), timing)
}

/// The call behind `Identification.frf` of the Python package.
fn identified_frf(repeats: usize) -> Value {
    let bench = Study::load("configs/tian.toml", "measurements/tian").expect("the bench can be read");
    let study = bench.fit(["l1", "l3", "l5"]).expect("the bench has these positions");
    let found = study.identify().expect("the identification succeeds");
    let input = Input { path: String::new(), sha256: String::new() };
    let point = Some("table".to_string());
    let request = simulation::FrfRequest {
        places: vec![simulation::Place::Nut(0.6)],
        lines_hz: Some((6..1006).map(f64::from).collect()),
        response: point.clone(),
        excitation: point,
        ..simulation::FrfRequest::default()
    };
    timed(repeats, 1, || {
        black_box(
            simulation::identified_frf(&study, Path::new(""), (&found, &input), &request)
                .expect("the bench has this position"),
        );
    })
}

fn identified(repeats: usize) -> Value {
    let (machine, set) = bench();
    let (fit, held_out) = set.split(None, &[]).expect("the split is valid");
    let (mut cost, mut evaluations) = (f64::NAN, 0);
    let timing = timed(repeats, 0, || {
        let found =
            identify(&machine, &fit, &held_out, &IdentificationSettings::default(), &Control::default())
                .expect("the identification succeeds");
        cost = found.cost;
        evaluations += found.evaluations;
    });
    with(timing, json!({ "evaluations": evaluations, "cost": cost }))
}

fn identified_from_frfs(seed: u64, profile: bool) -> Value {
    let (machine, _) = bench();
    let mut set = table_frfs(&machine);
    // A deterministic substitute for noise of 2 %, identical in benches/peers/bench_model.py.
    for (at, line) in set.frfs.iter_mut().flat_map(|frf| &mut frf.lines).enumerate() {
        let phase = (at * at) as f64;
        line.value *= Complex64::new(1.0 + 0.02 * phase.cos(), 0.02 * (1.1 * phase).sin());
    }
    let (fit, held_out) = set.split(None, &[]).expect("the set can be fitted as a whole");
    // SciPy fits the parameters only, so that tolerances are held here, too.
    let plan = IdentificationSettings {
        seed,
        repeats: 1,
        profile,
        tolerances: false,
        frf: Some(FrfSettings::default()),
        ..IdentificationSettings::default()
    };
    let mut found = None;
    let timing = timed(1, 0, || found = identify(&machine, &fit, &held_out, &plan, &Control::default()).ok());
    let found = found.expect("the identification succeeds");
    let values: serde_json::Map<_, _> =
        machine.parameters.iter().zip(&found.values).map(|(p, value)| (p.id.clone(), json!(value))).collect();
    with(timing, json!({ "evaluations": found.evaluations, "values": values }))
}
