//! Scaling of computing time with problem size: `cargo bench --bench growth [-- [WORD] [--threads N]]`.
//!
//! Each row of the table is one kind of work in increasing sizes. All sizes run in turn, several times. The
//! time of a size is the least of its runs, which other load on the machine disturbs least. The exponent is d
//! ln t / d ln n, by least squares over all sizes, and between the two largest; 1 is linear. A WORD selects
//! the rows whose name contains it. The default is one thread, so that the time scales with the work.

mod support;

use std::hint::black_box;
use std::io::Cursor;
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Parser;
use config::{effect_library, read_machine, read_machine_text};
use diagnosis::{DiagnosisSettings, Domain, NullDistribution, closed_interval, diagnose, fitter};
use dynamics::model::{PeakSearch, RodModel, Structure, peaks};
use dynamics::motion::{Sine, simulate};
use identification::objective::{FrfObjective, FrfSettings, ModeObjective, ModeSettings};
use identification::{IdentificationSettings, identify};
use long_work::Control;
use machine::{Machine, Operating};
use measurement::{Gain, MeasurementSet, ModeObservation, ModeTable, Quantity, read_set};
use num_complex::Complex64;
use numeric::random::normal;
use numeric::unit::omega_rad_s;
use optimizer::{Cost, LeastSquares, SearchSettings, search};
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use support::simulated_frfs;
use universal_files::{
    Abscissa, ByteOrder, Encoding, NodeLocation, RecordAxis, UniversalRecord, UniversalWriter, read,
};

/// Limits of the runs of a size: total time, and number of runs.
const RUN_LIMITS: (Duration, usize) = (Duration::from_millis(100), 1000);
/// Limits of the rounds over all sizes of a row: number of rounds, and total time.
const ROUND_LIMITS: (usize, Duration) = (4, Duration::from_secs(3));
/// Null simulations of a diagnosis, as many as the command's default.
const NULL_SIMULATIONS: usize = 60;

/// Measures the least time of one run (s).
fn least_seconds<T>(mut work: impl FnMut() -> T) -> f64 {
    let begin = Instant::now();
    let mut least = f64::INFINITY;
    for _ in 0..RUN_LIMITS.1 {
        let run = Instant::now();
        black_box(work());
        least = least.min(run.elapsed().as_secs_f64());
        if begin.elapsed() > RUN_LIMITS.0 {
            break;
        }
    }
    least
}

/// Computes the slope of ln(seconds) over ln(size) by least squares.
fn exponent(times: &[(usize, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = times.iter().map(|(n, t)| ((*n as f64).ln(), t.ln())).collect();
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(|l| l.0), mean(|l| l.1));
    logs.iter().map(|l| (l.0 - x) * (l.1 - y)).sum::<f64>()
        / logs.iter().map(|l| (l.0 - x).powi(2)).sum::<f64>()
}

/// Table of the selected rows, printed as they are measured.
struct Table {
    word: String,
}

impl Table {
    /// Measures and prints one row; `seconds` measures the time of a size.
    fn row(&self, name: &str, unit: &str, sizes: &[usize], mut seconds: impl FnMut(usize) -> f64) {
        if !name.contains(&self.word) {
            return;
        }
        let mut times: Vec<(usize, f64)> = sizes.iter().map(|n| (*n, f64::INFINITY)).collect();
        let begin = Instant::now();
        for _ in 0..ROUND_LIMITS.0 {
            times.iter_mut().for_each(|(n, least)| *least = least.min(seconds(*n)));
            if begin.elapsed() > ROUND_LIMITS.1 {
                break;
            }
        }
        let durations: Vec<String> = times.iter().map(|(n, t)| format!("{n}: {}", duration(*t))).collect();
        let all = exponent(&times);
        let last = exponent(&times[times.len().saturating_sub(2)..]);
        println!("| {name} | {unit} | {} | {all:.2} | {last:.2} |", durations.join(", "));
    }
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.1} µs", s * 1e6),
        s if s < 1.0 => format!("{:.1} ms", s * 1e3),
        s => format!("{s:.1} s"),
    }
}

fn bench() -> Machine {
    read_machine("configs/tian.toml", &[], &[]).expect("the bench's machine is valid").machine
}

/// Returns nut positions spread over the stroke of the bench (m).
fn nuts_m(count: usize) -> Vec<Option<f64>> {
    (0..count).map(|i| Some(0.6 + 1.3 * (i as f64 + 0.5) / count as f64)).collect()
}

/// Returns frequencies spread over the band of the bench (Hz).
fn frequencies_hz(count: usize) -> Vec<f64> {
    (0..count).map(|i| 6.0 + 1000.0 * i as f64 / count as f64).collect()
}

/// Builds a chain of masses, each joined to the next, and every fourth to the table at the end.
///
/// The joints share `parameters` stiffnesses and dampings in turn.
fn chain_of_masses(points: usize, parameters: usize) -> Machine {
    use std::fmt::Write;
    let mut text = "title = \"a chain of masses\"\n".to_string();
    for i in 0..points {
        let name = if i + 1 == points { "table".into() } else { format!("p{i}") };
        writeln!(
            text,
            "[[point]]\nname = \"{name}\"\nmotion = \"translation\"\nmass_kg = {}",
            2.0 + i as f64 / 8.0
        )
        .expect("a string accepts text");
    }
    let name = |i: usize| if i + 1 == points { "table".into() } else { format!("p{i}") };
    let springs = parameters / 2;
    let mut joint = |at: usize, from: String, to: String| {
        let of = at % springs;
        writeln!(text, "[[joint]]\nname = \"j{at}\"\nbetween = [\"{from}\", \"{to}\"]\nstiffness = \"k{of}\"\ndamping = \"c{of}\"")
            .expect("a string accepts text");
    };
    joint(0, "p0".into(), "ground".into());
    (1..points).for_each(|i| joint(i, name(i - 1), name(i)));
    (0..points.saturating_sub(2)).step_by(4).for_each(|i| joint(points + i, name(i), name(points - 1)));
    for i in 0..springs {
        writeln!(
            text,
            "[parameter.k{i}]\nunit = \"N/m\"\nstart = {}\nlower = 1e6\nupper = 1e9\nsource = \"bench\"",
            2e7 * (1.0 + i as f64)
        )
        .expect("a string accepts text");
        writeln!(
            text,
            "[parameter.c{i}]\nunit = \"N*s/m\"\nstart = {}\nlower = 10\nupper = 1e5\nsource = \"bench\"",
            4e2 * (1.0 + i as f64)
        )
        .expect("a string accepts text");
    }
    read_machine_text("a chain of masses", &text, &[], &[]).expect("the chain is valid").machine
}

/// Computes the modes of a machine at its start values, at nut positions of the bench.
fn simulated_modes(machine: &Machine, count: usize) -> MeasurementSet {
    let table = machine.point("table").expect("the machine has a table");
    let structure =
        Arc::new(Structure::new(machine, table, table, RodModel::Exact).expect("the table can move"));
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    let mut set = simulated_frfs(machine, ("table", "table"), &nuts_m(count), &[100.0]);
    set.frfs.clear();
    set.quantity = Some(Quantity::Mobility);
    set.gain = Gain::Unknown;
    (set.response, set.excitation) = (Some("table".into()), Some("table".into()));
    let band =
        PeakSearch { from_hz: 10.0, to_hz: 1000.0, precision: 1e-7, omega_power: Quantity::Mobility.power() };
    let observed = |position: usize| -> Vec<ModeObservation> {
        network.update(machine, &machine.start(), &Operating::at(set.positions[position].nut_m));
        let peaks = peaks(&network, band, &mut work);
        let observation = |(at, peak): (usize, &dynamics::model::Peak)| ModeObservation {
            order: at as u32 + 1,
            frequency_hz: Some(peak.frequency_hz),
            frequency_sd_hz: None,
            amplitude: Some(peak.amplitude),
        };
        peaks.iter().enumerate().map(observation).collect()
    };
    set.modes = Some(ModeTable {
        positions: (0..count).map(observed).collect(),
        resolution_hz: Some(1.0),
        ..ModeTable::default()
    });
    set
}

/// Computes the FRF of a machine without a nut.
fn one_frf(machine: &Machine, lines: usize) -> MeasurementSet {
    simulated_frfs(machine, ("table", "table"), &[None], &frequencies_hz(lines))
}

/// Measures the time of one generation of the default differential evolution (s).
fn generation_seconds(cost: &impl Cost) -> f64 {
    const GENERATIONS: u64 = 4;
    let settings = SearchSettings {
        generations: GENERATIONS,
        spread: 0.0,
        ..SearchSettings::for_dimension(cost.dimension(), 1)
    };
    // The initial population counts as a generation.
    least_seconds(|| search(cost, settings, &Control::default())) / (GENERATIONS + 1) as f64
}

fn with_modes<T>(machine: &Machine, set: &MeasurementSet, work: impl FnOnce(&ModeObjective<'_>) -> T) -> T {
    let (fit, _) = set.split(None, &[]).expect("the set can be fitted as a whole");
    work(&ModeObjective::new(machine, &fit, ModeSettings::default(), &[]).expect("the objective is valid"))
}

fn with_frfs<T>(machine: &Machine, set: &MeasurementSet, work: impl FnOnce(&FrfObjective<'_>) -> T) -> T {
    let (fit, _) = set.split(None, &[]).expect("the set can be fitted as a whole");
    work(&FrfObjective::new(machine, &fit, FrfSettings::default(), &[]).expect("the objective is valid"))
}

fn chi_square_seconds(machine: &Machine, set: &MeasurementSet) -> f64 {
    with_frfs(machine, set, |objective| {
        let place = vec![0.4; LeastSquares::dimension(objective)];
        least_seconds(|| objective.chi_square(black_box(&place)))
    })
}

fn normal_seconds(machine: &Machine, set: &MeasurementSet) -> f64 {
    with_frfs(machine, set, |objective| {
        let place = vec![0.4; LeastSquares::dimension(objective)];
        least_seconds(|| objective.normal(black_box(&place)))
    })
}

/// Measures the time of one search (s), without profile intervals, whose cost scales differently.
fn identify_seconds(machine: &Machine, set: &MeasurementSet, frf: bool) -> f64 {
    let (fit, held_out) = set.split(None, &[]).expect("the split is valid");
    let plan = IdentificationSettings {
        repeats: 1,
        profile: false,
        frf: frf.then(FrfSettings::default),
        ..IdentificationSettings::default()
    };
    let begin = Instant::now();
    let found = identify(machine, &fit, &held_out, &plan, &Control::default());
    black_box(&found).as_ref().expect("the identification succeeds");
    begin.elapsed().as_secs_f64()
}

/// Writes FRFs as a universal file in memory.
fn universal(records: usize, lines: usize, encoding: Encoding) -> Vec<u8> {
    let mut writer = UniversalWriter::new(Cursor::new(Vec::new()));
    for node in 1..=records as i64 {
        let place = NodeLocation { node, direction: 3, ..NodeLocation::default() };
        let values = (0..lines).map(|i| Complex64::new(1e-7 / (1.0 + i as f64), -1e-9 * i as f64)).collect();
        let abscissa = Abscissa::Even { first: 0.0, step: 0.25, count: lines };
        let record = UniversalRecord::frequency_response(
            place.clone(),
            place,
            RecordAxis::new(8, "Displacement", "m"),
            abscissa,
            values,
        );
        writer.record(&record, encoding).expect("the record can be written");
    }
    writer.finish().expect("the file can be finished").into_inner()
}

fn receptances(table: &Table) {
    let per_line = |machine: &Machine, nut_m: Option<f64>, lines: usize| {
        let at = machine.point("table").expect("the machine has a table");
        let structure =
            Arc::new(Structure::new(machine, at, at, RodModel::Exact).expect("the table can move"));
        let (mut network, mut work) = (structure.empty_model(), structure.workspace());
        network.update(machine, &machine.start(), &Operating::at(nut_m));
        let omegas: Vec<f64> = frequencies_hz(lines).into_iter().map(omega_rad_s).collect();
        least_seconds(|| {
            black_box(network.sweep(black_box(&omegas), &mut work));
        })
    };
    table.row("receptance", "lines of the bench", &[100, 1000, 10_000, 100_000], |n| {
        per_line(&bench(), Some(1.0), n)
    });
    table.row("receptance, 1,000 lines", "points", &[4, 8, 16, 32, 64], |n| {
        per_line(&chain_of_masses(n, 4), None, 1000)
    });
}

fn objectives(table: &Table) {
    let machine = bench();
    let positions = [1, 3, 6, 12, 24];
    table.row("objective, modes", "positions", &positions, |n| {
        with_modes(&machine, &simulated_modes(&machine, n), |objective| {
            let place = vec![0.4; objective.free.len()];
            least_seconds(|| objective.at(black_box(&place)))
        })
    });
    table.row("objective, FRFs of 1,000 lines", "positions", &positions, |n| {
        chi_square_seconds(
            &machine,
            &simulated_frfs(&machine, ("table", "table"), &nuts_m(n), &frequencies_hz(1000)),
        )
    });
    let of_lines = |n: usize| simulated_frfs(&machine, ("table", "table"), &[Some(1.0)], &frequencies_hz(n));
    let lines = [100, 1000, 10_000, 100_000];
    table.row("objective, one FRF", "lines", &lines, |n| chi_square_seconds(&machine, &of_lines(n)));
    table.row("normal equations, one FRF", "lines", &lines, |n| normal_seconds(&machine, &of_lines(n)));
    let points = [4, 8, 16, 32, 64];
    table.row("objective, one FRF of 1,000 lines", "points", &points, |n| {
        let machine = chain_of_masses(n, 4);
        chi_square_seconds(&machine, &one_frf(&machine, 1000))
    });
    table.row("normal equations, one FRF of 1,000 lines", "points", &points, |n| {
        let machine = chain_of_masses(n, 4);
        normal_seconds(&machine, &one_frf(&machine, 1000))
    });
    table.row(
        "normal equations, one FRF of 1,000 lines, 16 points",
        "free parameters",
        &[4, 8, 12, 16],
        |n| {
            let machine = chain_of_masses(16, n);
            normal_seconds(&machine, &one_frf(&machine, 1000))
        },
    );
}

fn generations(table: &Table) {
    let machine = bench();
    table.row("generation, modes", "positions", &[1, 3, 6, 12, 24], |n| {
        with_modes(&machine, &simulated_modes(&machine, n), |objective| generation_seconds(objective))
    });
}

fn identifications(table: &Table) {
    let machine = bench();
    table.row("identification, modes", "positions", &[3, 8, 24], |n| {
        let mut set = simulated_modes(&machine, n + 1);
        // The last position is held out, to be predicted.
        set.split = Some(set.positions[..n].iter().map(|p| p.name.clone()).collect());
        identify_seconds(&machine, &set, false)
    });
    table.row("identification, FRFs at three positions", "lines", &[100, 1000, 10_000], |n| {
        let mut set = simulated_frfs(&machine, ("table", "table"), &nuts_m(4), &frequencies_hz(n));
        set.split = Some(set.positions[..3].iter().map(|p| p.name.clone()).collect());
        identify_seconds(&machine, &set, true)
    });
    table.row("identification, one FRF of 1,000 lines, 16 points", "free parameters", &[4, 8, 12, 16], |n| {
        let machine = chain_of_masses(16, n);
        let mut set = simulated_frfs(&machine, ("table", "table"), &[None, None], &frequencies_hz(1000));
        set.split = Some(vec!["p0".into()]);
        identify_seconds(&machine, &set, true)
    });
}

/// Times diagnoses of the bench described without its rotor hold. The null distribution is simulated
/// beforehand, as the command caches it.
fn diagnoses(table: &Table) {
    let without = ["rotor-hold".to_string()];
    let machine =
        read_machine("configs/tian.toml", &[], &without).expect("the bench's machine is valid").machine;
    let set = read_set("measurements/tian").expect("the bench's measurements are valid");
    let (fit, held_out) = set.split(None, &[]).expect("the split is valid");
    let library = effect_library().expect("the library is valid");
    let fitter = fitter(&fit, Domain::Modes(ModeSettings::default()), &[], &[]);
    let run = |effects: usize, settings: &DiagnosisSettings| {
        let begin = Instant::now();
        let found =
            diagnose(&machine, &library[..effects], &fitter, &held_out, settings, &Control::default())
                .expect("the diagnosis succeeds");
        (begin.elapsed().as_secs_f64(), found.facts.null)
    };
    // The null distribution of all effects, once: the row shows the cost of a diagnosis that reuses it.
    let mut null = None;
    table.row("diagnosis, modes, null distribution known", "effects", &[1, 4, 12], |n| {
        let known = null.get_or_insert_with(|| {
            run(
                12,
                &DiagnosisSettings { seed: 1, draws: 2, null: None, all_facts: false, library: Vec::new() },
            )
            .1
        });
        run(
            n,
            &DiagnosisSettings {
                seed: 1,
                draws: 2,
                null: Some(known.clone()),
                all_facts: false,
                library: Vec::new(),
            },
        )
        .0
    });
    for held in [false, true] {
        let title =
            format!("diagnosis, six FRFs, {}", if held { "none missing" } else { "the rotor hold missing" });
        let mut nulls = std::collections::BTreeMap::new();
        table.row(&format!("{title}, null distribution simulated"), "lines", &[250, 1000], |n| {
            let (seconds, null) = frf_diagnosis_seconds(n, held, None);
            nulls.insert(n, null);
            seconds
        });
        table.row(&format!("{title}, null distribution known"), "lines", &[250, 1000], |n| {
            let known = nulls.entry(n).or_insert_with(|| frf_diagnosis_seconds(n, held, None).1);
            frf_diagnosis_seconds(n, held, Some(known.clone())).0
        });
    }
}

/// Measures a diagnosis of six FRFs of the bench with 1.4 % noise, three of them fitted, with every effect of
/// the library.
///
/// If an effect is named, the interval of its gap reduction is included. Returns the time (s) and the null
/// distribution. The rotor of the described machine is held by the drive, as in the simulated measurement, or
/// free.
fn frf_diagnosis_seconds(
    lines: usize,
    held: bool,
    null: Option<NullDistribution>,
) -> (f64, NullDistribution) {
    let read = |without: &[String]| {
        read_machine("configs/tian.toml", &[], without).expect("the bench's machine is valid").machine
    };
    let without = ["rotor-hold".to_string()];
    let machine = read(if held { &[] } else { &without });
    let bench = read_set("measurements/tian").expect("the bench's measurements are valid");
    let nuts_m: Vec<Option<f64>> = bench.positions.iter().map(|p| p.nut_m).collect();
    let frequencies_hz: Vec<f64> = (0..lines).map(|at| 5.0 + 1000.0 * at as f64 / lines as f64).collect();
    let mut set = simulated_frfs(&read(&[]), ("table", "table"), &nuts_m, &frequencies_hz);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
    for line in set.frfs.iter_mut().flat_map(|frf| &mut frf.lines) {
        line.value *= 1.0 + 0.014 * Complex64::new(normal(&mut random), normal(&mut random));
    }
    set.split = Some(set.positions.iter().step_by(2).map(|p| p.name.clone()).collect());
    let (fit, held_out) = set.split(None, &[]).expect("the split is valid");
    let (library, control) = (effect_library().expect("the library is valid"), Control::default());
    let fitter = fitter(&fit, Domain::Frf(FrfSettings::default()), &[], &[]);
    let begin = Instant::now();
    let found = diagnose(
        &machine,
        &library,
        &fitter,
        &held_out,
        &DiagnosisSettings { seed: 1, draws: NULL_SIMULATIONS, null, all_facts: false, library: Vec::new() },
        &control,
    )
    .expect("the diagnosis succeeds");
    black_box(closed_interval(&fitter, &held_out, &found, 1, &control));
    (begin.elapsed().as_secs_f64(), found.facts.null)
}

fn files(table: &Table) {
    for (name, encoding) in [("text", Encoding::Ascii), ("binary", Encoding::Binary(ByteOrder::Little))] {
        let reading = |records, lines| {
            let bytes = universal(records, lines, encoding);
            least_seconds(|| read(Cursor::new(black_box(&bytes))).expect("the universal file is valid"))
        };
        table.row(&format!("universal file, {name}, 1,000 lines"), "records", &[1, 4, 16, 64], |n| {
            reading(n, 1000)
        });
        table.row(
            &format!("universal file, {name}, one record"),
            "lines",
            &[100, 1000, 10_000, 100_000],
            |n| reading(1, n),
        );
    }
}

#[derive(Parser)]
struct Arguments {
    /// Word that the names of the measured rows contain.
    #[arg(default_value = "")]
    word: String,
    /// Number of threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Flag that cargo passes to every bench.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Times a sine motion of the hybrid axis: synchronous motor, current loop of 31.25 µs, backlash and
/// friction.
fn motions(table: &Table) {
    let axis =
        read_machine("configs/hybrid-axis.toml", &[], &[]).expect("the shipped machine is valid").machine;
    table.row("motion of the hybrid axis", "ms", &[1000, 2500, 5000, 10_000], |milliseconds| {
        let sine = Sine {
            centre: 0.0,
            amplitude: 0.1,
            frequency_hz: 0.159_15,
            periods: milliseconds as f64 * 0.159_15e-3,
        };
        let course = sine.course(1e-3).expect("the sine is valid");
        least_seconds(|| {
            simulate(&axis, &axis.start(), &course, &dynamics::motion::SimulationSettings::default(), &|| {
                true
            })
            .expect("the simulation succeeds")
        })
    });
}

fn main() {
    let arguments = Arguments::parse();
    let table = Table { word: arguments.word };
    println!("threads: {}\n", arguments.threads);
    println!(
        "| work | size n | least time | exponent | exponent of the two largest |\n|---|---|---|---|---|"
    );
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build()
        .expect("the thread pool can be built");
    pool.install(|| {
        receptances(&table);
        objectives(&table);
        generations(&table);
        identifications(&table);
        diagnoses(&table);
        files(&table);
        motions(&table);
    });
}
