//! The library as its callers see it: one study for modes, FRFs and motion records, from files or from
//! arrays, with the documents of the command.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use assert_cmd::Command;
use jointid::document::Role;
use jointid::measurement::{DriveEffort, FrfArrays, MeasurementSet, MotionArrays, Quantity, SetArrays};
use jointid::simulation::{FrfRequest, MotionRequest, Place, Reference, TravelProfile, frf, motion};
use jointid::{Control, ObjectiveKind, Settings, Sources, Study, read_machine};
use num_complex::Complex64;
use serde_json::Value;

const BENCH: [&str; 2] = ["configs/tian.toml", "measurements/tian"];

fn bench() -> Study {
    Study::load(BENCH[0], BENCH[1]).unwrap().fit(["l1", "l3", "l5"]).unwrap()
}

fn command(arguments: &[&str]) -> Value {
    let output = Command::cargo_bin("jointid").unwrap().args(arguments).output().unwrap();
    serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|e| panic!("{e}: {}", String::from_utf8_lossy(&output.stderr)))
}

#[test]
fn library_and_command_give_the_same_documents() {
    let study = bench();
    let found = study.identify().unwrap();
    assert_eq!(
        serde_json::to_value(&found).unwrap(),
        command(&["identify", "--positions", "l1,l3,l5", "--json"])
    );
    let compared = study.compare().unwrap();
    assert_eq!(
        serde_json::to_value(&compared).unwrap(),
        command(&["compare", "--positions", "l1,l3,l5", "--json"])
    );
    assert_eq!(serde_json::to_value(study.plan().unwrap()).unwrap(), command(&["plan", "--json"]));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("identification.json");
    std::fs::write(&file, serde_json::to_string_pretty(&found).unwrap()).unwrap();
    // The command names the file of the result among its inputs.
    let mut validated = command(&["validate", "--json", "--result", file.to_str().unwrap()]);
    validated["inputs"].as_array_mut().unwrap().pop();
    assert_eq!(serde_json::to_value(study.validate(&found).unwrap()).unwrap(), validated);
}

/// FRFs of the bench as arrays, with one percent of noise from a fixed sequence.
fn simulated(study: &Study) -> SetArrays {
    let places = ["l1", "l3", "l5"].map(|name| Place::Position(name.into()));
    let request = FrfRequest {
        places: places.to_vec(),
        from_hz: 10.0,
        to_hz: 900.0,
        step_hz: 4.0,
        ..FrfRequest::default()
    };
    let simulated = frf(study, &request).unwrap();
    let mut state = 1_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        0.01 * ((state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0)
    };
    let mut frf_of = |name: &String, values: &Vec<[f64; 2]>| FrfArrays {
        position: Some(name.clone()),
        frequency_hz: simulated.frequency_hz.clone(),
        value: values
            .iter()
            .map(|[re, im]| Complex64::new(*re, *im) * Complex64::new(noise(), noise()).exp())
            .collect(),
        relative_sd: Some(vec![0.01; values.len()]),
        ..FrfArrays::default()
    };
    let frfs = simulated.positions.iter().map(|(name, values)| frf_of(name, values)).collect();
    let nuts = study
        .measurements()
        .positions
        .iter()
        .map(|p| (p.name.clone(), p.nut_m))
        .filter(|(name, _)| "l1 l3 l5".contains(name.as_str()));
    SetArrays {
        title: "arrays".into(),
        quantity: Some(Quantity::Receptance),
        response: Some("table".into()),
        excitation: Some("table".into()),
        nut_m: nuts.collect(),
        frfs,
        ..SetArrays::default()
    }
}

/// Writes arrays as a measurement set in files.
fn write(arrays: &SetArrays, folder: &std::path::Path) {
    let mut manifest = String::from(
        "title = \"arrays\"\nquantity = \"receptance\"\nresponse = \"table\"\nexcitation = \"table\"\n",
    );
    for (name, nut_m) in &arrays.nut_m {
        manifest += &format!("[[position]]\nname = \"{name}\"\nnut_m = {:?}\n", nut_m.unwrap());
    }
    for frf in &arrays.frfs {
        let name = frf.position.as_ref().unwrap();
        manifest += &format!("[[frf]]\nposition = \"{name}\"\nfile = \"{name}.csv\"\n");
        let mut table = String::from("frequency_hz,real,imag,relative_sd\n");
        for (frequency_hz, value) in frf.frequency_hz.iter().zip(&frf.value) {
            table += &format!("{frequency_hz:?},{:?},{:?},0.01\n", value.re, value.im);
        }
        std::fs::write(folder.join(format!("{name}.csv")), table).unwrap();
    }
    std::fs::write(folder.join("manifest.toml"), manifest).unwrap();
}

#[test]
fn arrays_and_files_give_the_same_result() {
    let arrays = simulated(&bench());
    let settings = Settings { repeats: 1, fit_tolerances: false, ..Settings::default() };
    let own = Study::new(read_machine(BENCH[0]).unwrap(), MeasurementSet::from_arrays(&arrays).unwrap());
    let own = own.fit(["l1", "l5"]).unwrap().with_settings(settings.clone());
    let folder = tempfile::tempdir().unwrap();
    write(&arrays, folder.path());
    let files = Study::load(BENCH[0], folder.path().to_str().unwrap())
        .unwrap()
        .fit(["l1", "l5"])
        .unwrap()
        .with_settings(settings);
    let (own_found, found) = (own.identify().unwrap(), files.identify().unwrap());
    assert_eq!(own_found.parameters, found.parameters);
    assert_eq!(own_found.positions, found.positions);
    assert_eq!(own_found.held_out_positions, ["l3"]);
    assert!(own_found.manifest.is_none() && found.manifest.is_some());
    let nut = &own_found.parameters["k_n"];
    let described = own.machine().parameters.iter().find(|p| p.id == "k_n").unwrap();
    assert!((nut.value / described.start - 1.0).abs() < 0.05, "{} against {}", nut.value, described.start);
    assert_eq!(own.validate(&own_found).unwrap().positions, files.validate(&found).unwrap().positions);
}

/// A driven axis: its simulated motion becomes a measurement set, from which the moving mass returns.
#[test]
fn motion_records_are_identified_from_arrays() {
    let emps =
        Study::open_machine(&Sources { config: Some("configs/emps.toml".into()), ..Sources::default() })
            .unwrap();
    let record = |name: &str, travel_m: f64| {
        let travel = TravelProfile {
            travel_m,
            velocity_m_s: 0.2,
            acceleration_m_s2: 2.0,
            jerk_m_s3: 50.0,
            rest_s: 0.2,
        };
        let request = MotionRequest {
            reference: Reference::SCurve { travel, and_back: true },
            ..MotionRequest::default()
        };
        let simulated = motion(&emps, &request).unwrap();
        let column = |name: &str| simulated.columns[name].clone();
        MotionArrays {
            name: name.into(),
            time_s: column("time_s"),
            command_m: column("command_m"),
            position_m: column("position_m"),
            load: DriveEffort::Force(column("force_n")),
            others: Default::default(),
        }
    };
    let set = SetArrays {
        title: "moves".into(),
        motions: vec![record("long", 0.2), record("short", 0.1)],
        ..SetArrays::default()
    };
    let study =
        Study::new(read_machine("configs/emps.toml").unwrap(), MeasurementSet::from_arrays(&set).unwrap())
            .fit(["long"])
            .unwrap();
    let found = study.identify().unwrap();
    let truth = emps.machine().parameters.iter().find(|p| p.id == "moving_mass").unwrap().start;
    assert!(
        (found.parameters["moving_mass"].value / truth - 1.0).abs() < 0.02,
        "{:?}",
        found.parameters["moving_mass"]
    );
    assert_eq!(found.records["short"].role, Role::HeldOut);
    assert_eq!(study.validate(&found).unwrap().records.keys().collect::<Vec<_>>(), ["short"]);
    let wrong = study
        .with_settings(Settings { objective: Some(ObjectiveKind::Frf), ..Settings::default() })
        .identify();
    let message = wrong.unwrap_err().to_string();
    assert!(
        message.starts_with("objective: moves (") && message.contains("holds only motion records"),
        "{message}"
    );
}

#[test]
fn a_study_reports_progress_and_stops() {
    let (stop, reports) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicUsize::new(0)));
    let (flag, count) = (Arc::clone(&stop), Arc::clone(&reports));
    // The first report requests the stop.
    let watcher = move |_: jointid::Progress<'_>| {
        count.fetch_add(1, Ordering::Relaxed);
        flag.store(true, Ordering::Relaxed);
    };
    let found = bench().with_control(Control::new(stop, Some(Arc::new(watcher)))).identify().unwrap();
    assert!(!found.stamp.complete && reports.load(Ordering::Relaxed) > 0);
}

/// A result needs neither the file of its machine nor the bench.
#[test]
fn a_result_reopens_its_own_study() {
    let study = bench().with_settings(Settings { repeats: 1, ..Settings::default() });
    let mut found = study.identify().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("identification.json");
    found.settings.config = "nowhere.toml".into();
    found.machine.as_mut().unwrap().path = "nowhere.toml".into();
    found.content_sha256 = Some(report::digest_of(&found).unwrap());
    std::fs::write(&file, report::to_json(&found).unwrap()).unwrap();
    let (again, same, input) = Study::open_with_result(&Sources::default(), &file).unwrap();
    assert_eq!(again.machine(), study.machine());
    let stated = Settings { objective: Some(ObjectiveKind::LeastSquares), ..study.settings().clone() };
    assert_eq!(again.settings(), &stated);
    assert_eq!(same.parameters, found.parameters);
    assert_eq!(input.path, file.display().to_string());
    assert_eq!(again.identify().unwrap().parameters, found.parameters);
}
