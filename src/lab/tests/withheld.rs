//! The blind check on given diagnoses: right and wrong answers, refused input.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use dynamics::model::{RodModel, Structure};
use lab::withheld::{
    Answer, Confusion, Generator, Judgement, Proportion, Run, Seal, SealedCase, WithheldError,
    confusion_text, files_of, folder_digest, judge, scores, scores_text,
};
use machine::Operating;
use num_complex::Complex64;
use reference_simulator::draw::Draw;
use reference_simulator::effect::Place;
use reference_simulator::machine::assembly::Assembly;
use reference_simulator::machine::catalogue::{any_size, bench};
use reference_simulator::machine::point::{Channel, Point};
use reference_simulator::{Counts, Gap, Imitation, Kind, Label, Layout, Strength, labels_json};
use report::document::Input;
use report::{digest, to_json};
use serde_json::{Value, json};

use crate::lab;

fn label(kind: Kind, effects: &[&str], place: &[&str]) -> Label {
    let planted = !effects.is_empty();
    Label {
        case: "case-0001".into(),
        index: 0,
        kind,
        effects: effects.iter().map(|e| e.to_string()).collect(),
        alternatives: Vec::new(),
        strength: planted.then_some(Strength::Clear),
        noncentrality: effects.iter().map(|_| 100.0).collect(),
        fitted_noncentrality: Vec::new(),
        imitation: None,
        layout: None,
        values: Vec::new(),
        places: place
            .iter()
            .map(|name| Place {
                interface: name.to_string(),
                accepted: vec![name.to_string(), "another-name".into()],
            })
            .collect(),
        band_hz: planted.then_some([100.0, 200.0]),
        phases: Vec::new(),
        gap: Gap { closed: planted.then_some(0.9), ..Gap::default() },
        joints: BTreeMap::new(),
        wrong_parameter: None,
        frozen: Vec::new(),
        fault: None,
        faulty_records: Vec::new(),
        hammer: None,
        refused: 0,
    }
}

/// Returns a diagnosis with a given verdict; its ranked list has the effects of the verdict, then two others.
fn diagnosis(kind: &str, effects: &[&str]) -> Value {
    let ranked: Vec<Value> = effects
        .iter()
        .chain(&["screw-diameter", "frf-gain"])
        .map(|id| {
            json!({"id": id, "status": "tried", "gap_held_out_before": 0.2, "gap_held_out_after": 0.1, "closed": 0.93,
            "closed95": [0.85, 0.97], "p_value": 0.001, "parameters": {}, "selected": true})
        })
        .collect();
    json!({"schema": "jointid/diagnosis/1", "tool_version": "0.1.0", "seed": 1, "complete": true, "inputs": [], "warnings": [],
        "domain": "frf", "noise_floor": 0.02, "gap": {"fit": 0.1, "held_out": 0.2},
        "where": [{"interface": "table", "gap_held_out": 0.1, "shape": "mass"}], "effects": ranked,
        "verdict": {"kind": kind, "effects": effects, "reason": "given", "next_measurement": null}})
}

fn run_of(document: Value) -> Run {
    Run {
        schema: Run::SCHEMA.into(),
        program_sha256: String::new(),
        case_sha256: String::new(),
        arguments: Vec::new(),
        exit_code: Some(0),
        seconds: 2.0,
        said: String::new(),
        diagnosis: Some(document),
    }
}

fn answer(kind: &str, effects: &[&str]) -> Answer {
    run_of(diagnosis(kind, effects)).answer(&[])
}

fn judged(label: &Label, kind: &str, effects: &[&str]) -> Judgement {
    judge(label, false, &answer(kind, effects))
}

fn failed() -> Answer {
    Run {
        exit_code: Some(2),
        said: "warning: this\njointid: that is missing\n  more\n".into(),
        ..run_of(Value::Null)
    }
    .answer(&[])
}

#[test]
fn a_right_name_counts_as_exact_and_a_set_containing_it_as_class() {
    let single = label(Kind::Single, &["table-mass"], &["table"]);
    let right = judged(&single, "effect", &["table-mass"]);
    assert!(right.right && right.exact && right.class && right.top3 && right.claims && right.place_right);
    assert_eq!(
        (right.closed, right.closed95, right.single_right),
        (Some(0.93), Some([0.85, 0.97]), Some(true))
    );
    let set = judged(&single, "ambiguous", &["frf-gain", "table-mass"]);
    assert!(!set.exact && set.class && !set.right);
    assert_eq!(set.single_right, None);
    let combined = judged(&single, "effect", &["table-mass+screw-diameter"]);
    assert!(!combined.exact && combined.class && combined.names == 2);
    let wrong = judged(&single, "effect", &["guide-viscous"]);
    assert!(wrong.claims && !wrong.exact && !wrong.class && !wrong.top3);
    assert_eq!(wrong.single_right, Some(false));
    let silent = judged(&single, "none", &[]);
    assert!(!silent.claims && !silent.class && silent.answered);
    // Effects listed with a verdict that names none do not count.
    assert!(!judged(&single, "unknown", &["table-mass"]).class);
}

#[test]
fn look_alikes_doubles_and_unknowns_have_their_own_right_answers() {
    let alike = label(Kind::LookAlike, &["table-mass"], &["table"]);
    assert!(judged(&alike, "ambiguous", &["frf-gain", "table-mass"]).right);
    assert!(!judged(&alike, "effect", &["frf-gain"]).right);
    let both = label(Kind::Double, &["table-mass", "rotor-hold"], &["table", "rotor"]);
    let all = judged(&both, "effect", &["rotor-hold+table-mass"]);
    assert!(all.right && all.class && !all.exact && all.single_right.is_none());
    let first = judged(&both, "effect", &["table-mass"]);
    assert!(!first.right && first.class && first.single_right == Some(true));
    // Alternatives do not combine.
    assert!(!judged(&both, "ambiguous", &["rotor-hold", "table-mass"]).all_named);
    assert!(judged(&both, "ambiguous", &["rotor-hold", "table-mass+rotor-hold"]).all_named);
    let unknown = label(Kind::Unknown, &["hose-resonator"], &["table"]);
    assert!(judged(&unknown, "unknown", &[]).right);
    assert!(judged(&unknown, "effect", &["table-mass"]).names == 1);
}

#[test]
fn a_failure_is_never_a_right_none() {
    let failure = failed();
    assert_eq!(
        failure.diagnosis,
        Err(WithheldError::Diagnosis("exit code 2: jointid: that is missing".into()))
    );
    for kind in [Kind::Null, Kind::HardNullWrongParameter, Kind::HardNullBadChannel] {
        let judged = judge(&label(kind, &[], &[]), false, &failure);
        assert!(!judged.right && !judged.answered && !judged.claims, "{kind:?}");
        assert_eq!(judged.verdict.kind, "failed");
    }
    let counted = scores(&[
        judge(&label(Kind::Null, &[], &[]), false, &failure),
        judged(&label(Kind::Null, &[], &[]), "none", &[]),
        judged(&label(Kind::Null, &[], &[]), "effect", &["table-mass"]),
    ]);
    assert_eq!(counted.failed, Proportion::new(1, 3));
    assert_eq!(counted.false_alarm_ordinary, Proportion::new(1, 2));
    assert_eq!(counted.right_by_kind["null"], Proportion::new(1, 3));
    assert_eq!(counted.selective, Proportion::new(0, 1));
    assert_eq!(
        counted.confusion.rows["(null)"],
        BTreeMap::from([("failed".into(), 1), ("none".into(), 1), ("table-mass".into(), 1)])
    );
}

#[test]
fn refuse_to_count_invalid_answers() {
    let fault = |run: Run| run.answer(&[]).diagnosis.unwrap_err().to_string();
    assert!(fault(Run { exit_code: None, ..run_of(Value::Null) }).contains("did not end by itself"));
    assert!(fault(Run { diagnosis: None, ..run_of(Value::Null) }).contains("no JSON"));
    assert!(fault(run_of(json!({"schema": "jointid/diagnosis/1"}))).contains("cannot be read"));
    let mut other = diagnosis("none", &[]);
    other["schema"] = json!("jointid/modes/1");
    assert!(fault(run_of(other)).contains("not a diagnosis"));
    let mut half = diagnosis("none", &[]);
    half["complete"] = json!(false);
    assert!(fault(run_of(half)).contains("not complete"));
    let file = Input { path: "frf/l1.csv".into(), sha256: "a1".into() };
    let mut document = diagnosis("none", &[]);
    assert!(
        run_of(document.clone())
            .answer(std::slice::from_ref(&file))
            .diagnosis
            .unwrap_err()
            .to_string()
            .contains("frf/l1.csv")
    );
    document["inputs"] = json!([{"path": "anywhere", "sha256": "a1"}]);
    assert!(run_of(document).answer(&[file]).diagnosis.is_ok());
}

#[test]
fn hard_nulls_may_be_named_as_such() {
    let wrong = Label { frozen: vec!["k_n".into()], ..label(Kind::HardNullWrongParameter, &[], &[]) };
    let bad = label(Kind::HardNullBadChannel, &[], &[]);
    let counted = scores(&[
        judged(&wrong, "wrong-parameter", &[]),
        judged(&wrong, "none", &[]),
        judged(&wrong, "effect", &["table-mass"]),
        judged(&bad, "measurement", &[]),
        judged(&bad, "none", &[]),
        judged(&bad, "ambiguous", &["table-mass", "frf-gain"]),
    ]);
    assert_eq!(counted.wrong_parameter, Proportion::new(2, 3));
    assert_eq!(counted.wrong_parameter_frozen, Proportion::new(1, 3));
    assert_eq!(counted.bad_channel, Proportion::new(1, 3));
    assert_eq!(counted.false_alarm_hard, Proportion::new(2, 6));
}

#[test]
fn location_band_and_closed_share_are_compared_with_the_truth() {
    let single = label(Kind::Single, &["table-mass"], &["nut"]);
    let mut document = diagnosis("effect", &["table-mass"]);
    assert!(!judge(&single, false, &run_of(document.clone()).answer(&[])).place_right);
    // The verdict's location precedes the list of locations; a band without upper limit does not count.
    document["verdict"]["where"] = json!("Another-Name");
    document["verdict"]["band_hz"] = json!([100.0, null]);
    let found = judge(&single, false, &run_of(document.clone()).answer(&[]));
    assert!(found.place_right && found.band_overlap.is_none());
    document["verdict"]["band_hz"] = json!([100.0, 400.0]);
    document["effects"][0]["closed95"] = json!([0.91, 0.97]);
    let found = judge(&single, false, &run_of(document).answer(&[]));
    assert!((found.band_overlap.unwrap() - 0.5).abs() < 1e-12);
    let counted = scores(&[
        found,
        judged(&label(Kind::Single, &["table-mass"], &["table"]), "effect", &["table-mass"]),
    ]);
    assert_eq!(counted.closing.covered, Proportion::new(1, 2));
    assert_eq!(counted.closing.closed.median, Some(0.93));
    assert!((counted.closing.error.median.unwrap() - 0.03).abs() < 1e-12);
    assert_eq!(counted.location.interface, Proportion::new(2, 2));
    assert_eq!(counted.seconds.max, Some(2.0));
}

#[test]
fn the_phase_of_a_motion_is_judged_if_the_case_has_one() {
    let moved = Label {
        phases: vec!["reversal".into(), "constant-speed".into()],
        ..label(Kind::Single, &["backlash"], &["nut"])
    };
    let mut document = diagnosis("effect", &["backlash"]);
    let phase = |document: &Value| judge(&moved, false, &run_of(document.clone()).answer(&[])).phase_right;
    assert_eq!(phase(&document), Some(false), "no phase is stated");
    document["gap"]["by_phase"] = json!({"reversal": 0.2, "dwell": 0.1, "settling": null});
    assert_eq!(phase(&document), Some(true), "the phase of the largest gap counts");
    document["where"][0]["phase"] = json!("dwell");
    assert_eq!(phase(&document), Some(false), "the location precedes the gaps");
    document["verdict"]["phase"] = json!("constant_speed");
    assert_eq!(phase(&document), Some(true), "the verdict precedes the location");
    let without_motion = judged(&label(Kind::Single, &["table-mass"], &["table"]), "effect", &["table-mass"]);
    assert_eq!(without_motion.phase_right, None);
    let failure = judge(&moved, false, &failed());
    assert_eq!(failure.phase_right, Some(false));
    let found = judge(&moved, false, &run_of(document).answer(&[]));
    assert_eq!(scores(&[found, failure, without_motion]).location.phase, Proportion::new(1, 2));
}

#[test]
fn second_measurements_count_separately() {
    let alike = label(Kind::LookAlike, &["table-mass"], &["table"]);
    let counted = scores(&[
        judged(&alike, "ambiguous", &["frf-gain", "table-mass"]),
        judge(&alike, true, &answer("effect", &["table-mass"])),
    ]);
    assert_eq!(counted.look_alike_class, Proportion::new(1, 1));
    assert_eq!(counted.look_alike_exact, Proportion::new(0, 1));
    assert_eq!(counted.look_alike_resolved, Proportion::new(1, 1));
    assert_eq!(counted.confusion.rows["table-mass"], BTreeMap::from([("frf-gain".into(), 1)]));
}

#[test]
fn the_matrix_and_the_scores_fit_eighty_columns() {
    use reference_simulator::effect::EffectKind;
    let mut confusion = Confusion { rows: BTreeMap::new() };
    let kinds = ["none", "unknown", "wrong-parameter", "measurement", "insufficient", "failed"];
    let answers: Vec<&str> =
        EffectKind::LISTED.iter().map(|e| e.name()).chain(kinds).chain(["nut-load-stiffness"]).collect();
    for truth in EffectKind::LISTED.iter().map(|e| e.name()).chain(["(null)", "(hard-null-wrong-parameter)"])
    {
        confusion.rows.insert(truth.into(), answers.iter().map(|a| (a.to_string(), 123)).collect());
    }
    let text = confusion_text(&confusion);
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    assert_eq!(text.matches("(null)").count(), 3, "not three blocks:\n{text}");
    assert_eq!(text.matches("123").count(), 20 * 25, "{text}");
    assert!(text.contains("19 nut-load-stiffness"), "{text}");
    let single = label(Kind::Single, &["bearing-stiffness-position"], &["table"]);
    let mut document = diagnosis("effect", &["bearing-stiffness-position"]);
    document["verdict"]["band_hz"] = json!([100.0, 400.0]);
    let all: Vec<Judgement> =
        (0..1000).map(|_| judge(&single, false, &run_of(document.clone()).answer(&[]))).collect();
    let text = scores_text(&scores(&all));
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

#[test]
fn an_effect_below_the_visible_size_may_be_none() {
    let sized = |size: f64| Label {
        fitted_noncentrality: vec![size],
        ..label(Kind::Single, &["table-mass"], &["table"])
    };
    let (small, large) = (sized(12.0), sized(60.0));
    assert!(judged(&small, "none", &[]).right && judged(&small, "effect", &["table-mass"]).right);
    assert!(!judged(&small, "effect", &["frf-gain"]).right && !judged(&large, "none", &[]).right);
    let counted = scores(&[
        judged(&small, "none", &[]),
        judged(&small, "effect", &["frf-gain"]),
        judged(&large, "ambiguous", &["frf-gain", "table-mass"]),
        judged(&large, "none", &[]),
    ]);
    assert_eq!(counted.by_size.keys().collect::<Vec<_>>(), ["0-20", "50-200"]);
    assert_eq!(
        (counted.by_size["0-20"].right, counted.by_size["0-20"].misnamed),
        (Proportion::new(1, 2), Proportion::new(1, 2))
    );
    let large = &counted.by_size["50-200"];
    assert_eq!(
        (large.class, large.exact, large.right),
        (Proportion::new(1, 2), Proportion::new(0, 2), Proportion::new(0, 2))
    );
}

#[test]
fn each_visible_case_counts_once_by_effect() {
    let sized = |kind: Kind, effects: &[&str], size: f64| Label {
        fitted_noncentrality: vec![size],
        ..label(kind, effects, &["table"])
    };
    let mass = sized(Kind::Single, &["table-mass"], 30.0);
    let counted = scores(&[
        judged(&mass, "effect", &["table-mass"]),
        judged(&mass, "ambiguous", &["table-mass", "frf-gain"]),
        judged(&mass, "effect", &["frf-gain"]),
        judged(&mass, "none", &[]),
        judged(&sized(Kind::Single, &["table-mass"], 19.0), "none", &[]),
        judged(&sized(Kind::Double, &["table-mass", "frf-gain"], 30.0), "effect", &["table-mass"]),
        judge(&mass, true, &answer("effect", &["table-mass"])),
        judged(&sized(Kind::Single, &["frf-gain"], 20.0), "effect", &["frf-gain"]),
        judged(&sized(Kind::LookAlike, &["frf-gain"], 20.0), "ambiguous", &["frf-gain", "table-mass"]),
    ]);
    let counts = |effect: &str| {
        let row = &counted.by_effect[effect];
        [row.exact, row.class, row.misnamed, row.reported].map(|share| (share.count, share.of))
    };
    assert_eq!(counts("table-mass"), [(1, 4), (2, 4), (1, 4), (3, 4)]);
    assert_eq!(counts("frf-gain"), [(1, 2), (2, 2), (0, 2), (2, 2)]);
}

#[test]
fn layouts_are_scored_apart_and_outside_causes_by_kind() {
    let on = |layout: &str, label: Label| Label { layout: Some(layout.into()), ..label };
    let outside = |kind: &str| label(Kind::Unknown, &[kind], &["table"]);
    let imitated = Imitation { effect: "guide-stiffness".into(), noncentrality: 3.0 };
    let counted = scores(&[
        judged(&on("gantry", label(Kind::Null, &[], &[])), "effect", &["table-mass"]),
        judged(&on("gantry", label(Kind::Single, &["table-mass"], &["table"])), "effect", &["table-mass"]),
        judged(&on("vertical", label(Kind::Null, &[], &[])), "none", &[]),
        judged(&on("vertical", outside("ring-absorber")), "unknown", &[]),
        judged(&on("vertical", outside("ring-absorber")), "effect", &["coupling-inertia"]),
        judged(&on("vertical", outside("nut-yaw")), "unknown", &[]),
        judged(
            &Label { imitation: Some(imitated), ..outside("friction-damper") },
            "effect",
            &["guide-stiffness"],
        ),
    ]);
    assert_eq!(
        (counted.by_layout.len(), counted.by_layout["gantry"].cases, counted.by_layout["vertical"].cases),
        (2, 2, 4)
    );
    assert_eq!(counted.by_layout["gantry"].false_name, Proportion::new(1, 1));
    assert_eq!(counted.by_layout["vertical"].false_name, Proportion::new(0, 1));
    assert_eq!(counted.by_layout["gantry"].exact, Proportion::new(1, 1));
    assert_eq!(counted.by_layout["vertical"].outside_misnamed, Proportion::new(1, 3));
    // Of three kinds one is imitated by a library's effect, and one of the others is never misnamed.
    assert_eq!(counted.outside.kinds_never_misnamed, Proportion::new(1, 2));
    assert_eq!(counted.outside.by_kind["friction-damper"].imitated, Proportion::new(1, 1));
    assert_eq!(counted.outside.by_kind["friction-damper"].misnamed, Proportion::new(0, 0));
    assert_eq!(counted.outside.by_kind["ring-absorber"].unknown, Proportion::new(1, 2));
    let text = scores_text(&counted);
    assert!(
        text.contains("gantry: nulls, named") && text.contains("ring-absorber: verdict unknown"),
        "{text}"
    );
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
}

/// Writes a sealed folder of one case.
fn sealed() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let case = folder.path().join("cases/case-0001");
    fs::create_dir_all(case.join("frf")).unwrap();
    fs::write(case.join("manifest.toml"), "title = \"\"").unwrap();
    fs::write(case.join("frf/l1.csv"), "1,2,3").unwrap();
    let labels = labels_json(&[label(Kind::Null, &[], &[])]).unwrap();
    let generator = Generator {
        version: "0".into(),
        arm: "frf".into(),
        truth: "independent".into(),
        seed: 1,
        counts: Counts::QUICK,
        layout: None,
        cases: 1,
    };
    let cases = vec![SealedCase {
        name: "case-0001".into(),
        sha256: folder_digest(&case).unwrap(),
        freeze: Vec::new(),
        quiet_sha256: None,
    }];
    let seal = Seal::new(generator, &labels, cases, Vec::new()).unwrap();
    fs::write(folder.path().join("labels.json"), labels).unwrap();
    fs::write(folder.path().join("seal.json"), to_json(&seal).unwrap()).unwrap();
    folder
}

#[test]
fn refuse_cases_changed_after_sealing() {
    assert_eq!(Seal::verified(sealed().path()).unwrap().1.len(), 1);
    let change = |how: &dyn Fn(&Path)| {
        let folder = sealed();
        how(folder.path());
        Seal::verified(folder.path()).unwrap_err().to_string()
    };
    let edit = |path: &Path, from: &str, to: &str| {
        let text = fs::read_to_string(path).unwrap();
        assert!(text.contains(from));
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    };
    type Change<'a> = (&'a dyn Fn(&Path), &'a str, &'a str);
    let changes: [Change; 8] = [
        (&|f| fs::remove_file(f.join("labels.json")).unwrap(), "labels.json", "is missing"),
        (&|f| fs::remove_file(f.join("seal.json")).unwrap(), "seal.json", "is missing"),
        (&|f| edit(&f.join("labels.json"), "\"null\"", "\"single\""), "labels.json", "digest"),
        (&|f| edit(&f.join("cases/case-0001/frf/l1.csv"), "2", "4"), "case-0001", "digest"),
        (&|f| fs::write(f.join("cases/case-0001/hint.txt"), "").unwrap(), "case-0001", "digest"),
        (&|f| fs::remove_dir_all(f.join("cases/case-0001")).unwrap(), "case-0001", "missing"),
        (&|f| edit(&f.join("seal.json"), "\"seed\": 1", "\"seed\": 2"), "seal.json", "changed"),
        (&|f| edit(&f.join("seal.json"), "\"freeze\": []", "\"freeze\": [\"k_n\"]"), "seal.json", "changed"),
    ];
    for (how, file, fault) in changes {
        let message = change(how);
        assert!(
            message.contains(file) && message.contains(fault) && message.contains("into a new folder"),
            "{message}"
        );
    }
}

fn refused(arguments: &[&str]) -> String {
    let output = lab().arg("withheld").args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stderr).unwrap()
}

/// Stores one answer to all cases, as this program stores its own.
fn store_answers(out: &str, seal: &Seal, seed: &str, document: &Value) {
    let program = digest(&fs::read(assert_cmd::cargo::cargo_bin!("jointid-lab")).unwrap());
    fs::create_dir_all(format!("{out}/diagnoses")).unwrap();
    for case in &seal.cases {
        let mut document = document.clone();
        document["inputs"] =
            serde_json::to_value(files_of(&Path::new(out).join("cases").join(&case.name)).unwrap()).unwrap();
        let mut arguments = vec!["diagnose", "--config"];
        let (machine, frozen) = (format!("{}/machine.toml", case.name), case.freeze.join(","));
        arguments.extend([&machine, "--measurements", &case.name]);
        if !frozen.is_empty() {
            arguments.extend(["--freeze", &frozen]);
        }
        arguments.extend(["--seed", seed, "--json"]);
        let arguments = arguments.into_iter().map(str::to_string).collect();
        let run = Run {
            program_sha256: program.clone(),
            case_sha256: case.sha256.clone(),
            arguments,
            ..run_of(document)
        };
        fs::write(format!("{out}/diagnoses/{}.json", case.name), to_json(&run).unwrap()).unwrap();
    }
}

/// Stored answers of this program are scored without running the diagnosis again.
#[test]
fn the_command_scores_stored_answers_and_refuses_changed_cases() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("blind");
    let out = out.to_str().unwrap();
    let generated = lab()
        .args(["withheld", "--out", out, "--cases", "3", "--seed", "4", "--cases-only"])
        .output()
        .unwrap();
    let stdout = String::from_utf8(generated.stdout).unwrap();
    assert!(generated.status.success() && stdout.contains("labels"), "{stdout}");
    let (seal, labels) = Seal::verified(Path::new(out)).unwrap();
    assert!(
        stdout.contains(&seal.labels_sha256)
            && stdout.contains(&seal.cases_sha256)
            && stdout.contains(&seal.generator_sha256)
    );
    store_answers(out, &seal, "4", &diagnosis("none", &[]));
    let output = lab().args(["withheld", "--out", out, "--json"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stderr).contains(&seal.labels_sha256));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (document["schema"].as_str(), document["complete"].as_bool()),
        (Some("jointid/withheld/1"), Some(true))
    );
    assert_eq!(document["cases"].as_array().unwrap().len(), seal.cases.len());
    assert_eq!(document["cases"][0]["name"], labels[0].case);
    assert_eq!(document["cases"][0]["truth"], json!(labels[0].effects));
    assert_eq!(document["cases"][0]["verdict"]["kind"], "none");
    assert_eq!(document["scores"]["failed"]["count"], 0);
    let written: Value =
        serde_json::from_str(&fs::read_to_string(format!("{out}/withheld.json")).unwrap()).unwrap();
    assert_eq!(written, document);
    let schema = lab().args(["schema", "withheld"]).output().unwrap().stdout;
    let schema = jsonschema::validator_for(&serde_json::from_slice(&schema).unwrap()).unwrap();
    let faults: Vec<String> =
        schema.iter_errors(&document).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(faults.is_empty(), "{faults:#?}");

    let page = lab().args(["withheld", "--page", &format!("{out},{out}")]).output().unwrap();
    let page = String::from_utf8(page.stdout).unwrap();
    let summary: Vec<&str> = page.lines().filter(|line| line.starts_with('|')).take(12).collect();
    let title = format!("frf, seed 4, {} folders |", seal.cases.len());
    assert!(
        summary[0].contains(&format!("{title} {title}")) && summary[11].starts_with("| location right"),
        "{page}"
    );
    let counts = &document["scores"]["false_name_ordinary"];
    let nulls = counts["of"].as_u64().unwrap();
    let cell = if nulls == 0 { "| – | – |".to_string() } else { format!("| 0 of {nulls} (0–") };
    assert!(summary[2].contains(&cell), "{page}");
    assert!(page.contains("Truth by row"), "{page}");
    assert!(refused(&["--page", &format!("{out}/cases")]).contains("a blind check writes it at its end"));

    assert!(refused(&["--out", out, "--layout", "all"]).contains("holds other cases"));
    assert!(refused(&["--out", out, "--seed", "5"]).contains("holds other cases"));
    fs::write(format!("{out}/cases/case-0002/manifest.toml"), "").unwrap();
    let message = refused(&["--out", out]);
    assert!(message.contains("case-0002") && message.lines().count() == 1, "{message}");
    fs::remove_file(format!("{out}/labels.json")).unwrap();
    assert!(refused(&["--out", out]).contains("labels.json: is missing"));
}

/// Cases of axes in motion are generated and sealed like the others, and scored on a stored answer.
#[test]
fn cases_in_motion_are_sealed_and_scored() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("moved");
    let out = out.to_str().unwrap();
    lab()
        .args([
            "withheld",
            "--arm",
            "motion",
            "--out",
            out,
            "--cases",
            "4",
            "--seed",
            "3",
            "--cases-only",
            "-q",
        ])
        .assert()
        .success();
    let (seal, labels) = Seal::verified(Path::new(out)).unwrap();
    assert_eq!((seal.generator.arm.as_str(), labels.len()), ("motion", 4));
    for case in &seal.cases {
        let set = measurement::read_set(&format!("{out}/cases/{}", case.name)).unwrap();
        assert!(set.motions.len() >= 3 && set.frfs.is_empty(), "{}", case.name);
    }
    let mut document = diagnosis("effect", &["backlash"]);
    (document["domain"], document["verdict"]["phase"]) = (json!("motion"), json!("reversal"));
    store_answers(out, &seal, "3", &document);
    let output = lab().args(["withheld", "--out", out, "--json", "-q"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["seal"]["generator"]["arm"], "motion");
    assert_eq!(document["scores"]["failed"]["count"], 0);
    for (row, label) in document["cases"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|row| Some((row, labels.iter().find(|l| row["name"] == l.case)?)))
    {
        let phase = (!label.effects.is_empty()).then(|| label.phases.iter().any(|phase| phase == "reversal"));
        assert_eq!(row["phase_right"], json!(phase), "{row}");
        assert_eq!(row["right"], json!(label.effects == ["backlash"] && label.kind == Kind::Single), "{row}");
    }
    share_closed_of_quiet_records(out, &seal, &labels);
    assert!(refused(&["--out", out, "--arm", "frf"]).contains("arm motion"));
    assert!(refused(&["--arm", "motion", "--truth", "own"]).contains("--truth own"));
}

/// The noise-free held-out records, stored separately, give the share of the gap that an answer's parameters
/// close.
///
/// The true parameters close most of the force's gap, zero parameters nothing.
fn share_closed_of_quiet_records(out: &str, seal: &Seal, labels: &[Label]) {
    let mut judged = 0;
    for case in &seal.cases {
        let label = labels.iter().find(|label| label.case == case.name.trim_end_matches("-more")).unwrap();
        assert!(case.quiet_sha256.is_some(), "{}", case.name);
        let sets = ["cases", "quiet"]
            .map(|part| measurement::read_set(&format!("{out}/{part}/{}", case.name)).unwrap());
        let (fitted, held_out) = sets[0].split_motions(None, &[]).unwrap();
        assert_eq!(sets[1].motions.len(), held_out.len());
        for quiet in &sets[1].motions {
            let noisy = held_out
                .iter()
                .map(|i| &sets[0].motions[*i])
                .find(|record| record.name == quiet.name)
                .unwrap();
            assert!(fitted.iter().all(|i| sets[0].motions[*i].name != quiet.name));
            assert_ne!(quiet.load.samples(), noisy.load.samples());
            // The force of the noise-free record is close to that of the noisy one.
            let difference: f64 =
                quiet.load.samples().iter().zip(noisy.load.samples()).map(|(a, b)| (a - b).powi(2)).sum();
            let total: f64 = noisy.load.samples().iter().map(|x| x * x).sum();
            assert!(difference < 0.25 * total, "{}: {difference} of {total}", case.name);
        }
        let kept = format!("{out}/diagnoses/{}.json", case.name);
        let mut run: Value = serde_json::from_str(&fs::read_to_string(&kept).unwrap()).unwrap();
        let zeros: serde_json::Map<String, Value> =
            label.joints.keys().map(|id| (id.clone(), json!(0.0))).collect();
        let document = &mut run["diagnosis"];
        (document["described"], document["chosen"]) =
            (json!(zeros), json!({"id": "nominal", "parameters": label.joints}));
        (document["effects"][0]["closed"], document["effects"][0]["closed95"]) =
            (json!(0.9), json!([0.8, 1.0]));
        fs::write(&kept, run.to_string()).unwrap();
        judged += 1;
    }
    assert!(judged > 0);
    let output = lab().args(["withheld", "--out", out, "--json", "-q"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    for row in document["cases"].as_array().unwrap().iter().filter(|row| row["closed"].is_number()) {
        let closed = row["closed_truth"].as_f64();
        assert!(closed.is_some_and(|closed| (0.8..1.0).contains(&closed)), "{row}");
    }
    let changed = &seal.cases[0];
    let manifest = format!("{out}/quiet/{}/manifest.toml", changed.name);
    let kept = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, format!("{kept}\n")).unwrap();
    assert!(refused(&["--out", out]).contains("its digest is not the sealed one"));
    fs::write(&manifest, kept).unwrap();
}

/// End-to-end check in motion: a case whose diagnosis fails counts as failed, never as right.
#[test]
#[ignore = "second tier"]
fn a_case_in_motion_from_end_to_end() {
    let output = lab()
        .args(["withheld", "--arm", "motion", "--cases", "2", "--time-limit-s", "600", "--json", "-q"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let cases = document["cases"].as_array().unwrap();
    let failed: Vec<&Value> = cases.iter().filter(|row| row["verdict"]["kind"] == "failed").collect();
    assert!(cases.len() >= 2);
    assert_eq!(document["scores"]["failed"]["count"], failed.len());
    assert!(failed.iter().all(|row| row["right"] == false), "{failed:#?}");
    if let Some(row) = failed.first() {
        println!("a_case_in_motion_from_end_to_end: failed: {}", row["verdict"]["reason"]);
    }
}

/// Cases simulated by the models themselves are nulls and single effects of the wanted strength, in files
/// that the commands read.
#[test]
fn cases_of_the_models_are_nulls_and_single_effects() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    lab()
        .args(["withheld", "--out", out, "--cases", "5", "--truth", "own", "--cases-only", "-q"])
        .assert()
        .success();
    let (seal, labels) = Seal::verified(folder.path()).unwrap();
    assert_eq!((seal.generator.truth.as_str(), labels.len(), seal.cases.len()), ("own", 5, 5));
    assert!(labels.iter().any(|l| l.kind == Kind::Single) && labels.iter().any(|l| l.kind == Kind::Null));
    for label in &labels {
        let case = folder.path().join("cases").join(&label.case);
        let machine =
            config::read_machine(case.join("machine.toml").to_str().unwrap(), &[], &[]).unwrap().machine;
        assert_eq!(measurement::read_set(case.to_str().unwrap()).unwrap().positions.len(), 6);
        assert_eq!(label.effects.len(), usize::from(label.kind == Kind::Single));
        if let (Some(id), Some(reached)) = (label.effects.first(), label.noncentrality.first()) {
            assert!(
                !machine.effects.contains(id) && !label.values[0].is_empty() && label.gap.closed == Some(1.0)
            );
            let wanted = if label.strength == Some(Strength::Strong) { 400.0 } else { *reached };
            assert!(
                (reached / wanted).ln().abs() < 0.06 || id == "frf-quantity",
                "{id}: {reached} for {wanted}"
            );
        }
    }
}

/// Cases of layouts are sealed in files that the commands read, with what the plan could not make counted.
#[test]
fn cases_of_layouts_are_sealed_and_what_cannot_be_made_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("blind");
    let out = out.to_str().unwrap();
    let arguments =
        ["withheld", "--out", out, "--cases", "6", "--seed", "2", "--layout", "all", "--cases-only"];
    let generated = lab().args(arguments).output().unwrap();
    let stdout = String::from_utf8(generated.stdout).unwrap();
    assert!(generated.status.success() && stdout.contains("layout all"), "{stdout}");
    let (seal, labels) = Seal::verified(Path::new(out)).unwrap();
    assert_eq!((seal.generator.layout.as_deref(), labels.len() + seal.not_made.len()), (Some("all"), 6));
    for label in &labels {
        let case = format!("{out}/cases/{}", label.case);
        let set = measurement::read_set(&case).unwrap();
        let hammer = label.hammer.unwrap();
        assert_eq!(
            (set.positions.len(), set.frfs.len() % set.positions.len()),
            (hammer.positions, 0),
            "{case}"
        );
        assert!((1..=4).contains(&hammer.channels) && label.layout.is_some());
        config::read_machine(&format!("{case}/machine.toml"), &[], &[]).unwrap();
        assert_eq!(label.fitted_noncentrality.len(), label.effects.len());
        assert_eq!(label.imitation.is_some(), label.kind == Kind::Unknown);
        for (fitted, all) in label.fitted_noncentrality.iter().zip(&label.noncentrality) {
            assert!(*fitted >= 0.0 && *fitted < 1.5 * all, "{case}: {fitted} of {all}");
        }
    }
}

/// Driven axes of all layouts are sealed with the loops of each stated, in files that the commands read.
#[test]
fn cases_of_motion_layouts_state_their_loops() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("blind");
    let out = out.to_str().unwrap();
    let arguments = [
        "withheld",
        "--arm",
        "motion",
        "--out",
        out,
        "--cases",
        "5",
        "--seed",
        "2",
        "--layout",
        "all",
        "--cases-only",
    ];
    assert!(lab().args(arguments).output().unwrap().status.success());
    let (seal, labels) = Seal::verified(Path::new(out)).unwrap();
    assert_eq!((seal.generator.layout.as_deref(), labels.len() + seal.not_made.len()), (Some("all"), 5));
    assert!(labels.len() >= 4, "{:?}", seal.not_made);
    for label in &labels {
        let case = format!("{out}/cases/{}", label.case);
        let set = measurement::read_set(&case).unwrap();
        let machine = config::read_machine(&format!("{case}/machine.toml"), &[], &[]).unwrap().machine;
        let drive = machine.drive.unwrap();
        let number = |value: &machine::Value| {
            value.at(&machine.parameters.iter().map(|p| p.start).collect::<Vec<f64>>(), &Operating::default())
        };
        let (feed_forward, integral_time_s) =
            (number(&drive.position.feed_forward), number(&drive.velocity.integral_time_s));
        assert!(set.motions.len() >= 3);
        match label.layout.as_deref().unwrap() {
            "indirect-encoder" | "belt-driven" => {
                assert!(feed_forward == 0.0 && integral_time_s.is_infinite())
            }
            "feed-forward" => assert!(feed_forward > 0.0 && integral_time_s.is_infinite()),
            "pid-loop" => assert!(feed_forward == 1.0 && integral_time_s < 1.0),
            "direct-encoder" => assert!(feed_forward == 0.0 && integral_time_s < 1.0),
            other => panic!("{other}"),
        }
    }
}

/// Ctrl-C during the generation of cases ends with exit code 3; the same command resumes with the cases
/// generated so far.
#[cfg(unix)]
#[test]
fn an_interrupted_check_resumes() {
    use std::process::{Command as Process, Stdio};
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["withheld", "--cases", "8", "--jobs", "1", "--cases-only", "--out"];
    let mut child = Process::new(assert_cmd::cargo::cargo_bin!("jointid-lab"))
        .args(arguments)
        .arg(folder.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let generated = folder.path().join("cases.partial/made");
    let begun = std::time::Instant::now();
    while fs::read_dir(&generated)
        .map_or(0, |list| list.filter(|e| e.as_ref().unwrap().path().extension().is_some()).count())
        == 0
    {
        assert!(begun.elapsed().as_secs() < 60, "no case was generated");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert!(Process::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(3));
    assert!(!folder.path().join("seal.json").exists());
    let first = fs::read_dir(&generated).unwrap().count();
    assert!((1..8).contains(&first), "{first} of 8 generated");
    lab().args(arguments).arg(folder.path()).assert().success();
    assert_eq!(Seal::verified(folder.path()).unwrap().1.len(), 8);
    assert!(!folder.path().join("cases.partial").exists());
}

#[test]
fn refuse_invalid_arguments() {
    assert!(refused(&["--cases-only"]).contains("--out"));
    assert!(refused(&["--cases", "some"]).contains("quick, full or a number"));
    assert!(refused(&["--cases", "100000"]).contains("the full plan has"));
    assert!(refused(&["--layout", "lathe"]).contains("short-axis, medium-axis, gantry"));
    let other_arm = refused(&["--layout", "gantry", "--arm", "motion"]);
    assert!(other_arm.contains("gantry") && other_arm.contains("direct-encoder"), "{other_arm}");
    assert!(refused(&["--ablation", "--seed 3"]).contains("--seed is given by the case"));
}

/// End-to-end check on a case, with the real diagnosis; the README's command is run on another.
#[test]
#[ignore = "second tier"]
fn a_case_from_end_to_end() {
    let output = lab().args(["withheld", "--cases", "1", "--json", "-q"]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(document["scores"]["failed"]["count"], 0, "{:#}", document["cases"]);
}

/// Without effects and nuisances the reference simulator, on a fine mesh, agrees with the exact model.
#[test]
fn limit_the_reference_simulator_agrees_with_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("machine.toml");
    let of_layout = |layout: &Layout| layout.machine(true, *layout == Layout::Vertical, &mut Draw::new(9));
    let of_catalogue = (0..4).map(|seed| {
        let mut draw = Draw::new(seed);
        if seed == 0 { bench(true, &mut draw) } else { any_size(seed % 2 == 0, &mut draw) }
    });
    for (number, drawn) in of_catalogue.chain(Layout::ALL.iter().map(of_layout)).enumerate() {
        let mut truth = drawn.description.as_believed();
        truth.screw.elements = 2000;
        std::fs::write(&file, drawn.description.to_toml()).unwrap();
        let machine = config::read_machine(file.to_str().unwrap(), &[], &[]).unwrap().machine;
        for (response, excitation) in
            [(Point::Table, Point::Table), (Point::Rotor, Point::Rotor), (Point::Right, Point::Table)]
        {
            let index = |point: Point| machine.points.iter().position(|p| p.name == point.name()).unwrap();
            let structure = Arc::new(
                Structure::new(&machine, index(response), index(excitation), RodModel::Exact).unwrap(),
            );
            let (mut network, mut work) = (structure.empty_model(), structure.workspace());
            for nut_m in drawn.nut_m.iter().copied() {
                network.update(
                    &machine,
                    &machine.start(),
                    &Operating { nut_m: Some(nut_m), ..Operating::default() },
                );
                let assembly = Assembly::new(&truth, &[], nut_m, 1.0);
                let omegas: Vec<f64> =
                    (1..=200).map(|k| 5.0 * f64::from(k) * std::f64::consts::TAU).collect();
                let laplace: Vec<Complex64> =
                    omegas.iter().map(|omega| Complex64::new(0.0, *omega)).collect();
                let port = assembly.port(Channel::new(response, excitation));
                let found = assembly.structure.receptances(&[port], &laplace).unwrap().remove(0);
                for (omega, truth) in omegas.iter().zip(found) {
                    let model = network.receptance(*omega, &mut work);
                    let error = (truth / model - 1.0).norm();
                    assert!(
                        error < 1e-3,
                        "machine {number}, {response:?}/{excitation:?}, nut at {nut_m} m, {omega} rad/s: {error:.1e}"
                    );
                }
            }
        }
    }
}
