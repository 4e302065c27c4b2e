//! Descriptions with a wrong number, or with a joint that the machine does not have: `diagnose` names it, with an
//! interval that holds.

use std::path::Path;

use jointid::document::VerdictKind;
use jointid::{DiagnosisRequest, FactsDocument, Study, read_machine};
use measurement::read_set;
use numeric::distribution::clopper_pearson;
use reference_simulator::{Counts, Kind, Layout, Plan, generate_one, ordinary, write_case};
use report::diagnosis::DiagnosisDocument;
use test_data::{draws, shared};

use crate::certainty::{ParameterResult, WRONG_NUMBERS, compare_with_truth, identified};

fn diagnosed(folder: &Path, machine: &str) -> (DiagnosisDocument, FactsDocument) {
    let file = folder.join("described.toml");
    std::fs::write(&file, machine).unwrap();
    let set = read_set(&folder.display().to_string()).unwrap();
    let study = Study::new(read_machine(&file.display().to_string()).unwrap(), set);
    let request = DiagnosisRequest { nulls: 20, ..DiagnosisRequest::default() };
    let (document, facts) = study.diagnose_with_facts(&request).unwrap();
    (document, facts.unwrap())
}

/// How a diagnosis answers a wrong number.
struct Answered {
    /// Reduction of χ² by the right candidate.
    size: f64,
    named_alone: bool,
    in_set: bool,
    /// Whether its interval holds the truth; `None` where none is stated.
    holds: Option<bool>,
}

/// Compares a verdict with the candidate that is the wrong number, by its id and the true value of its parameter.
fn answered(
    (found, facts): &(DiagnosisDocument, FactsDocument),
    (id, parameter): (&str, &str),
    truth: f64,
) -> Answered {
    let row = found.effects.iter().find(|row| row.id == id);
    let interval = row.and_then(|row| row.parameters95.get(parameter));
    Answered {
        size: row.map_or(0.0, |row| row.misfit_reduction * facts.facts.chi_square),
        named_alone: found.verdict.effects == [id],
        in_set: found.verdict.effects.iter().any(|named| named == id),
        holds: interval.map(|[low, high]| (*low..=*high).contains(&truth)),
    }
}

/// Candidates that are the numbers of [`WRONG_NUMBERS`], in their order, with the parameter that states them.
const CANDIDATES: [(&str, &str); 5] = [
    ("table-mass", "table_mass_change"),
    ("inertia of rotor", "inertia_of_rotor_change"),
    ("screw-lead", "lead_change"),
    ("screw-diameter", "diameter_change"),
    ("screw-youngs-modulus", "youngs_change"),
];

/// Bearing that a machine with a free end does not have.
const BEARING: &str = r#"
[[joint]]
name = "bearing-right"
between = ["right", "ground"]
stiffness = "k_ar"
damping = "c_ar"

[parameter.k_ar]
unit = "N/m"
start = 1e8
lower = 5e6
upper = 5e9
source = "a catalogue"

[parameter.c_ar]
unit = "N*s/m"
start = 3e3
lower = 10.0
upper = 1e5
source = "a catalogue"
"#;

/// Machines of which one number is described wrongly by more than ten times its tolerance or more, and machines
/// with a free end whose description has a bearing there.
///
/// Required of those whose number reduces χ² by at least 50: it is named, alone or in a set, in at least 80 %, and
/// stated intervals hold the truth in at least 85 %, each by a one-sided test at 5 %.
///
/// ```text
/// JOINTID_STUDY=full cargo test --test main recover_wrong_numbers -- --ignored --nocapture
/// ```
#[test]
#[ignore = "long"]
fn recover_wrong_numbers() {
    let mut all: Vec<Answered> = Vec::new();
    let mut note = |what: &str, found: &(DiagnosisDocument, FactsDocument), answer: Answered| {
        let (verdict, names) = (&found.0.verdict.kind, found.0.verdict.effects.join(", "));
        println!("{what}: size {:.0}, {verdict} {names}, holds {:?}", answer.size, answer.holds);
        all.push(answer);
    };
    for number in 0..draws(1, 12) as usize {
        let folder = tempfile::tempdir().unwrap();
        write_case(folder.path(), &ordinary(70_117, number).unwrap().case).unwrap();
        let text = std::fs::read_to_string(folder.path().join("machine.toml")).unwrap();
        for ((name, entry_of, factor), candidate) in WRONG_NUMBERS.into_iter().zip(CANDIDATES) {
            let mut file: toml::Table = text.parse().unwrap();
            let stated = entry_of(&mut file);
            *stated = toml::Value::Float(stated.as_float().unwrap() * factor);
            let found = diagnosed(folder.path(), &file.to_string());
            let answer = answered(&found, candidate, 1.0 / factor - 1.0);
            note(&format!("{number} {name}"), &found, answer);
        }
    }
    let plan = Plan::on_layouts(&Counts::QUICK, 70_117, Some(Layout::FixedFloating));
    let nulls = (0..plan.slots.len()).filter(|at| plan.slots[*at].kind == Kind::Null);
    for index in nulls.take(draws(1, 8) as usize) {
        let Ok((case, _)) = generate_one(70_117, &plan, index) else { continue };
        let folder = tempfile::tempdir().unwrap();
        write_case(folder.path(), &case).unwrap();
        let text = std::fs::read_to_string(folder.path().join("machine.toml")).unwrap();
        let found = diagnosed(folder.path(), &format!("{text}{BEARING}"));
        let answer = answered(&found, ("k_ar", "k_ar"), 0.0);
        let answer = Answered { holds: None, ..answer };
        note(&format!("{index} free end"), &found, answer);
    }
    let visible: Vec<&Answered> = all.iter().filter(|answer| answer.size >= 50.0).collect();
    let of = |what: fn(&Answered) -> bool| visible.iter().filter(|answer| what(answer)).count();
    let (alone, set) = (of(|a| a.named_alone), of(|a| a.in_set));
    let (held, stated) = (of(|a| a.holds == Some(true)), of(|a| a.holds.is_some()));
    println!(
        "of {} from size 50: named alone {alone}, in a set {set}; intervals hold {held} of {stated}",
        visible.len()
    );
    let upper = |k: usize, n: usize| clopper_pearson(k, n, 0.9).map_or(1.0, |[_, high]| high);
    assert!(upper(set, visible.len()) >= 0.8 && upper(held, stated) >= 0.85);
}

/// Values reported as identifiable of machines with an effect that the description lacks, and of the same with that
/// effect in the machine.
///
/// Required of effects that reduce χ² by at least 50: without the effect at most 7 %, and with it at most 5 % of these
/// values miss the truth, each by a one-sided test at 5 %. Fainter effects, which no fit shows, shift values by as
/// much as their intervals; they are counted beside.
///
/// ```text
/// JOINTID_STUDY=full cargo test --test main recover_nothing_false_where_an_effect_is_missing -- --ignored --nocapture
/// ```
#[test]
#[ignore = "long"]
fn recover_nothing_false_where_an_effect_is_missing() {
    let plan = Plan::on_layouts(&Counts { singles_per_effect: 4, ..Counts::QUICK }, 83_021, None);
    let singles = (0..plan.slots.len()).filter(|at| plan.slots[*at].kind == Kind::Single);
    // Misses and values called identifiable, by visibility of the effect, without and with it.
    let mut counted = [[(0, 0); 2]; 2];
    for index in singles.take(draws(4, 40) as usize) {
        let Ok((case, label)) = generate_one(83_021, &plan, index) else { continue };
        let folder = tempfile::tempdir().unwrap();
        write_case(folder.path(), &case).unwrap();
        let set = read_set(&folder.path().display().to_string()).unwrap();
        let described = read_machine(&folder.path().join("machine.toml").display().to_string()).unwrap();
        let effect = described.effects.iter().find(|effect| Some(&effect.id) == label.effects.first());
        let with = effect.and_then(|effect| described.machine.with_effect(effect).ok());
        let machines = [Some(described.machine.clone()), with];
        let size = label.fitted_noncentrality.first().copied().unwrap_or(f64::NAN);
        let counted = &mut counted[usize::from(size >= 50.0)];
        for ((machine, (missed, called)), which) in machines.into_iter().zip(counted).zip(["without", "with"])
        {
            let Some(machine) = machine else { continue };
            let rows = compare_with_truth(&label.joints, &machine, &identified(&machine, &set));
            let claimed: Vec<&ParameterResult> = rows.iter().filter(|row| row.identifiable).collect();
            let misses: Vec<String> = claimed
                .iter()
                .filter(|row| row.missed)
                .map(|row| format!("{} {:+.1} %", row.id, 100.0 * row.log_error))
                .collect();
            *called += claimed.len();
            *missed += misses.len();
            println!(
                "{index} {} size {size:.0}, {which}, {missed} of {called}: {}",
                label.effects[0],
                misses.join(", ")
            );
        }
    }
    println!(
        "misses and identifiable values, without and with the effect: faint {:?}, visible {:?}",
        counted[0], counted[1]
    );
    for ((missed, called), most) in counted[1].into_iter().zip([0.07, 0.05]) {
        let lower = clopper_pearson(missed, called, 0.9).map_or(0.0, |[low, _]| low);
        assert!(lower <= most, "{missed} of {called} values miss");
    }
}

/// What a diagnosis names beside the effects of the library belongs to the machine again from its id and the values
/// of the chosen model: pages and plans draw it.
#[test]
fn named_numbers_belong_to_the_machine_again() {
    let study = Study::load("configs/tian.toml", "measurements/tian").unwrap();
    let machine = &study.config().machine;
    let range = |machine: &machine::Machine, id: &str| {
        let parameter = &machine.parameters[machine.parameter(id).unwrap()];
        (parameter.lower, parameter.upper)
    };
    let (lower, upper) = range(machine, "k_ar");
    for (value, end) in [(0.1 * lower, lower), (10.0 * upper, upper)] {
        let all = study.candidates(&[("~k_ar".to_string(), value)].into());
        let with = machine.with_chosen(["inertia of rotor", "k_ar"], &all).unwrap();
        assert_eq!(range(&with, "inertia_of_rotor_change"), (-0.9, 4.0));
        let (low, high) = range(&with, "~k_ar");
        assert!((low..=high).contains(&value) && [low, high].contains(&end), "{low} to {high}");
        let joint = with.joints.iter().find(|joint| joint.name == "bearing-right").unwrap();
        let at = with.parameter("~k_ar");
        assert_eq!(joint.stiffness.depends_on().collect::<Vec<_>>(), at.into_iter().collect::<Vec<_>>());
    }
    // Numbers that an effect of the library is have its name alone.
    let ids: Vec<String> =
        study.candidates(&Default::default()).into_iter().map(|effect| effect.id).collect();
    assert!(ids.contains(&"table-mass".into()) && !ids.contains(&"mass of table".into()), "{ids:?}");
}

/// A machine of another hand on a bed, with another lead, with a load and with a free end, each of which its
/// description lacks.
#[test]
#[ignore = "second tier"]
fn recover_what_is_wrong_with_a_machine_of_another_hand() {
    let Some(cases) = shared("cases/claims-wrong-machine") else { return };
    let names = |case: &str| {
        let folder = cases.join(case);
        let machine = folder.join("machine.toml").display().to_string();
        let study =
            Study::new(read_machine(&machine).unwrap(), read_set(&folder.display().to_string()).unwrap());
        let study = study.fit(["p1", "p3", "p5"]).unwrap();
        let found =
            study.diagnose_with(&DiagnosisRequest { nulls: 20, ..DiagnosisRequest::default() }).unwrap();
        let of = |row: &str, id: &str| {
            found.effects.iter().find(|e| e.id == row).and_then(|e| e.parameters95.get(id)).copied()
        };
        (
            found.verdict.kind,
            found.verdict.effects.clone(),
            of(
                &found.verdict.effects[0],
                match case {
                    "bed" => "m_bed",
                    "mass" => "table_mass_change",
                    "lead" => "lead_change",
                    _ => "k_ar",
                },
            ),
        )
    };
    let holds = |interval: Option<[f64; 2]>, truth: f64| {
        let [low, high] = interval.unwrap();
        assert!((low..=high).contains(&truth), "{low} to {high} for {truth}");
    };
    let (kind, effects, interval) = names("bed");
    assert_eq!((kind, &effects[..]), (VerdictKind::Effect, &["bed-compliance".to_string()][..]));
    holds(interval, 2200.0);
    let (kind, effects, interval) = names("mass");
    assert_eq!((kind, &effects[..]), (VerdictKind::Effect, &["table-mass".to_string()][..]));
    holds(interval, 31.0 / 424.0);
    let (kind, effects, _) = names("float");
    assert_eq!((kind, &effects[..]), (VerdictKind::WrongParameter, &["k_ar".to_string()][..]));
    let (_, effects, interval) = names("lead");
    assert_eq!(effects[0], "screw-lead");
    holds(interval, 0.2);
}
