//! Rules judge facts without a fit: each row of the table changes the facts of a plain case.

use super::case::Need;
use super::data_kind::DataKind;
use super::facts::{
    Answer, Beside, CandidateFacts, ChainFacts, ContradictingHeldOut, ContradictionFacts, ExchangedFacts,
    Facts, Farthest, FaultFacts, ImpedanceFacts, Model, Of, OnePosition, Remark,
};
use super::judgement::{Judgement, judge};
use super::null_distribution::NullDistribution;
use super::policy::Policy;
use super::probability::{explanations, places, verdict_by_evidence};
use super::verdict::VerdictKind;

/// An effect that adds one parameter.
fn effect(id: &str, before: f64, chi_square: f64) -> CandidateFacts {
    CandidateFacts {
        id: id.into(),
        effects: vec![id.into()],
        names: vec![id.into()],
        places: Vec::new(),
        released: None,
        number: None,
        at_end: Vec::new(),
        resembles: Vec::new(),
        discriminating_test: None,
        added: 1,
        chi_square: Some(chi_square),
        gain: before - chi_square,
        is_limit: false,
        chi_square_in_detail: None,
        impedances: None,
    }
}

/// 1000 numbers whose misfit is five times that of null simulations; one effect closes it, at held-out data,
/// too.
fn plain() -> Facts {
    let of = |model, value| Of { model, value };
    let of_left_out = |model, value| Of { model, value: Some(value) };
    let first = Model::Candidate(0);
    let of_remains = |model| Of { model, value: true };
    Facts {
        data: DataKind::Frf,
        count: 1000.0,
        unknowns: 8,
        in_sample: false,
        holds_out: true,
        chi_square: 5000.0,
        candidates: vec![effect("screw-lead", 5000.0, 1000.0)],
        impedances: Vec::new(),
        impedances_tried: 0,
        null: NullDistribution {
            scales: Vec::new(),
            largest: (0..2000).map(|at| f64::from(at) * 1e-3).collect(),
            fitted: Vec::new(),
            misfit: vec![0.9, 1.0, 1.1],
            seen_from: Vec::new(),
        },
        left_out: vec![of_left_out(Model::Nominal, 5000.0), of_left_out(first, 1000.0)],
        beside: Vec::new(),
        held_out_loss: vec![of(Model::Nominal, 3000.0), of(first, 600.0)],
        closed: vec![of_left_out(first, 0.9)],
        log_occam: Vec::new(),
        farthest: Vec::new(),
        fault_in_records: None,
        fault_held_out: None,
        fault_held_out_remains: vec![of_remains(first)],
        contradicting_held_out: Vec::new(),
        one_position: None,
        chain: None,
        exchanged: None,
        contradiction: None,
        mismatch: None,
    }
}

/// Judges facts; whatever a rule asks for was not found.
fn judged(mut facts: Facts) -> Judgement {
    loop {
        match judge(&facts, Policy::of(facts.data)) {
            Ok(judgement) => return judgement,
            Err(Need::OnePosition) => facts.one_position = Some(Answer { found: None }),
            Err(Need::Chain) => facts.chain = Some(Answer { found: None }),
            Err(Need::Exchanged) => facts.exchanged = Some(Vec::new()),
            Err(Need::Contradiction) => facts.contradiction = Some(Answer { found: None }),
            Err(Need::Mismatch) => facts.mismatch = Some(Answer { found: None }),
            Err(Need::ContradictingHeldOut(model)) => {
                let value = ContradictingHeldOut { fault: None, beyond_effects: None };
                facts.contradicting_held_out.push(Of { model, value });
            }
            Err(Need::Farthest(model)) => facts.farthest.push(Of { model, value: None }),
            Err(Need::Closed(model)) => facts.closed.push(Of { model, value: None }),
            Err(Need::LeftOut(models)) => {
                facts.left_out.extend(models.into_iter().map(|model| Of { model, value: None }));
            }
            Err(Need::HeldOut(models)) => {
                facts.held_out_loss.extend(models.into_iter().map(|model| Of { model, value: 3000.0 }));
            }
            Err(Need::Beside(of)) => {
                let chi_square = facts.candidates[0].chi_square.unwrap();
                facts.beside.push(Beside { of, chi_square, is_deeper: false, candidates: Vec::new() });
            }
            Err(need) => panic!("{need:?}"),
        }
    }
}

fn fault(id: &str) -> FaultFacts {
    FaultFacts {
        ids: vec![id.into()],
        reason: id.into(),
        next_measurement: "measure again".into(),
        is_insufficient: false,
    }
}

fn impedance(parameters: usize, before: f64, chi_square: f64) -> ImpedanceFacts {
    let gain = before - chi_square;
    ImpedanceFacts { interface: "nut".into(), shape: "mass".into(), parameters, chi_square, gain }
}

/// Replaces the misfit of the machine and of its one effect.
fn fits(facts: &mut Facts, before: f64, after: f64) {
    facts.chi_square = before;
    facts.candidates[0] = effect("screw-lead", before, after);
}

/// Releases a parameter instead of the effect.
fn releases(facts: &mut Facts, before: f64, after: f64) {
    fits(facts, before, after);
    facts.candidates[0].released = Some("k_m was frozen".into());
}

type Row = (&'static str, VerdictKind, fn(&mut Facts));

const ROWS: [Row; 19] = [
    ("too-few-numbers", VerdictKind::Insufficient, |facts| facts.unknowns = 1000),
    ("fault-in-records", VerdictKind::Measurement, |facts| facts.fault_in_records = Some(fault("noise"))),
    ("one-position", VerdictKind::Measurement, |facts| {
        let found = OnePosition { fault: fault("copied"), chi_square: 990.0, chi_square_at_own: 5000.0 };
        facts.one_position = Some(Answer { found: Some(found) });
    }),
    ("fault-held-out", VerdictKind::Measurement, |facts| facts.fault_held_out = Some(fault("scale@l4"))),
    ("fault-of-all", VerdictKind::Measurement, |facts| {
        let id = "low-pass".to_string();
        let found = ChainFacts { fault: fault(&id), id, parameters: 1, chi_square: 900.0 };
        facts.chain = Some(Answer { found: Some(found) });
    }),
    ("exchanged-records", VerdictKind::Measurement, |facts| {
        fits(facts, 5000.0, 4000.0);
        facts.exchanged = Some(vec![ExchangedFacts { fault: fault("swapped"), chi_square: 900.0 }]);
    }),
    ("contradicting-record", VerdictKind::Measurement, |facts| {
        fits(facts, 5000.0, 4000.0);
        let found = ContradictionFacts { fault: fault("scale@l1"), rest: 1.2 };
        facts.contradiction = Some(Answer { found: Some(found) });
    }),
    ("unexplained", VerdictKind::Unknown, |facts| {
        fits(facts, 5000.0, 5000.0);
        facts.impedances = vec![impedance(3, 5000.0, 1000.0)];
    }),
    ("implausible-tolerance", VerdictKind::Unknown, |facts| {
        fits(facts, 1000.0, 999.0);
        facts.data = DataKind::Motion;
        let value = Some(Farthest { name: "synchrony".into(), deviation: 5.0 });
        facts.farthest = vec![Of { model: Model::Nominal, value }];
    }),
    ("agrees", VerdictKind::None, |facts| fits(facts, 1000.0, 999.0)),
    ("released-parameter", VerdictKind::WrongParameter, |facts| releases(facts, 5000.0, 1000.0)),
    ("released-with-effects", VerdictKind::WrongParameter, |facts| releases(facts, 20000.0, 8000.0)),
    ("impossible-number", VerdictKind::Unknown, |facts| {
        fits(facts, 20000.0, 6000.0);
        let value = Some(Farthest { name: "mass of table".into(), deviation: -12.0 });
        facts.farthest = vec![Of { model: Model::Candidate(0), value }];
    }),
    ("impedance-predicts", VerdictKind::Unknown, |facts| {
        facts.impedances = vec![impedance(3, 5000.0, 900.0)];
        facts.left_out.push(Of { model: Model::Impedance(0), value: Some(500.0) });
    }),
    ("explained", VerdictKind::Effect, |_| {}),
    ("held-out-disagrees", VerdictKind::Unknown, |facts| facts.held_out_loss[1].value = 2999.0),
    ("half-unexplained", VerdictKind::Unknown, |facts| {
        fits(facts, 5000.0, 2200.0);
        facts.closed[0].value = Some(0.3);
    }),
    ("contradicting-held-out", VerdictKind::Effect, |facts| {
        facts.data = DataKind::Motion;
        let late = Some(fault("measurement-delay@stroke"));
        let value = ContradictingHeldOut { fault: late.clone(), beyond_effects: late };
        facts.contradicting_held_out = vec![Of { model: Model::Candidate(0), value }];
    }),
    ("other-cause", VerdictKind::Unknown, |facts| {
        fits(facts, 5000.0, 5000.0);
        facts.impedances = vec![impedance(3, 5000.0, 1000.0)];
        let (reason, next_measurement) = ("several machines".to_string(), "look".to_string());
        facts.mismatch = Some(Answer { found: Some(Remark { reason, next_measurement }) });
    }),
];

/// Each rule gives the verdict of the facts that it is for, and is listed as the last that held.
#[test]
fn each_rule_decides_its_case() {
    for (rule, kind, change) in ROWS {
        let mut facts = plain();
        change(&mut facts);
        let found = judged(facts);
        assert_eq!((found.rule, found.verdict.kind), (rule, kind), "{}", found.verdict.reason);
        let last = found.trials.iter().rev().find(|trial| trial.held == Some(true));
        assert_eq!(last.map(|trial| trial.rule.as_str()), Some(rule));
    }
    let tested: Vec<&str> = ROWS.iter().map(|row| row.0).collect();
    let all = judged(plain()).trials;
    assert_eq!(tested, all.iter().map(|trial| trial.rule.as_str()).collect::<Vec<_>>());
}

/// Two effects that fit alike are named together; held-out data that do not speak for them leave none.
#[test]
fn effects_that_fit_alike_are_named_together() {
    let mut facts = plain();
    facts.candidates.push(effect("frf-gain", 5000.0, 1003.0));
    facts.left_out.push(Of { model: Model::Candidate(1), value: Some(1005.0) });
    facts.held_out_loss.push(Of { model: Model::Candidate(1), value: 601.0 });
    let found = judged(facts.clone()).verdict;
    let names: Vec<String> = found.effects.iter().map(ToString::to_string).collect();
    assert_eq!((found.kind, found.confirmed), (VerdictKind::Ambiguous, Some(true)));
    assert_eq!(names, ["screw-lead", "frf-gain"]);
    facts.held_out_loss.iter_mut().for_each(|of| of.value = 3000.0);
    let found = judged(facts).verdict;
    assert_eq!((found.kind, found.effects.len(), found.confirmed), (VerdictKind::Unknown, 0, Some(false)));
    assert!(found.reason.contains("the named effects"), "{}", found.reason);
}

/// A number that alone explains the data is a wrong parameter, beside an effect it is one of the set, and what
/// is not confirmed is withdrawn like an effect.
#[test]
fn a_stated_number_is_named_like_an_effect() {
    let mut facts = plain();
    facts.candidates[0].id = "inertia of rotor".into();
    facts.candidates[0].number = Some("the inertia of rotor differs from the stated one (by -23.0 %)".into());
    let found = judged(facts.clone()).verdict;
    assert_eq!((found.kind, found.effects.len()), (VerdictKind::WrongParameter, 1));
    assert!(found.reason.starts_with("the inertia of rotor differs"), "{}", found.reason);
    let mut unconfirmed = facts.clone();
    unconfirmed.held_out_loss[1].value = 2999.0;
    assert_eq!(judged(unconfirmed).verdict.kind, VerdictKind::Unknown);
    facts.candidates.push(effect("coupling-inertia", 5000.0, 1003.0));
    facts.left_out.push(Of { model: Model::Candidate(1), value: Some(1005.0) });
    facts.held_out_loss.push(Of { model: Model::Candidate(1), value: 601.0 });
    let found = judged(facts).verdict;
    assert_eq!((found.kind, found.effects.len()), (VerdictKind::Ambiguous, 2));
}

/// Of explanations that fit alike, those that leave a joint at an end of its range are dropped where another one
/// moves it beyond: they need both.
#[test]
fn what_leaves_a_joint_at_its_end_is_no_rival_of_that_joint() {
    let mut facts = plain();
    facts.candidates[0].at_end = vec!["k_ar".into()];
    let joint =
        CandidateFacts { number: Some("k_ar lies below its range".into()), ..effect("k_ar", 5000.0, 1003.0) };
    facts.candidates.push(joint);
    facts.left_out.push(Of { model: Model::Candidate(1), value: Some(1005.0) });
    facts.held_out_loss.push(Of { model: Model::Candidate(1), value: 601.0 });
    let found = judged(facts.clone()).verdict;
    assert_eq!((found.kind, found.effects[0].to_string()), (VerdictKind::WrongParameter, "k_ar".into()));
    facts.candidates[0].at_end.clear();
    assert_eq!(judged(facts).verdict.kind, VerdictKind::Ambiguous);
}

/// An effect with more parameters is in the set where it fits better by what they cost (9 in χ² each), or fits as
/// well as the best and predicts held-out data decisively better; what predicts much worse is dropped.
#[test]
fn equal_fits_are_told_apart_by_what_they_predict() {
    let names = |chi_square: f64, left_out: f64, held_out: f64| {
        let mut facts = plain();
        facts.candidates.push(CandidateFacts { added: 4, ..effect("table-rocking", 5000.0, chi_square) });
        facts.null.scales = vec![("screw-lead".into(), 3.0), ("table-rocking".into(), 10.0)];
        facts.left_out.push(Of { model: Model::Candidate(1), value: Some(left_out) });
        facts.held_out_loss.push(Of { model: Model::Candidate(1), value: held_out });
        let found = judged(facts).verdict;
        found.effects.iter().map(ToString::to_string).collect::<Vec<String>>()
    };
    assert_eq!(names(999.0, 1000.0, 600.0), ["screw-lead"]);
    assert_eq!(names(972.0, 1000.0, 600.0), ["table-rocking", "screw-lead"]);
    assert_eq!(names(960.0, 1000.0, 600.0), ["table-rocking"]);
    assert_eq!(names(999.0, 1000.0, 590.0), ["screw-lead", "table-rocking"]);
    assert_eq!(names(972.0, 1000.0, 1700.0), ["table-rocking", "screw-lead"]);
    assert_eq!(names(972.0, 1000.0, 2200.0), ["screw-lead"]);
}

/// Effects that fit alike are withdrawn together where they leave much, as one is.
#[test]
fn a_set_that_leaves_much_is_not_named() {
    let mut facts = plain();
    fits(&mut facts, 5000.0, 2200.0);
    facts.candidates.push(effect("frf-gain", 5000.0, 2205.0));
    facts.left_out.push(Of { model: Model::Candidate(1), value: Some(1005.0) });
    facts.held_out_loss.push(Of { model: Model::Candidate(1), value: 601.0 });
    assert_eq!(judged(facts.clone()).verdict.kind, VerdictKind::Ambiguous);
    facts.closed[0].value = Some(0.3);
    let found = judged(facts);
    assert_eq!((found.rule, found.verdict.kind), ("half-unexplained", VerdictKind::Unknown));
}

/// A fault of the chain of all records that explains as much as an effect of a machine that agrees nearly as
/// it is stands beside its name.
#[test]
fn a_fault_as_likely_stands_beside_the_effect() {
    let mut facts = plain();
    fits(&mut facts, 1500.0, 1000.0);
    facts.candidates[0].added = 2;
    let id = "low-pass".to_string();
    let found = ChainFacts { fault: fault(&id), id, parameters: 1, chi_square: 1003.0 };
    facts.chain = Some(Answer { found: Some(found) });
    let found = judged(facts);
    let names: Vec<String> = found.verdict.effects.iter().map(ToString::to_string).collect();
    assert_eq!((found.rule, found.verdict.kind), ("other-cause", VerdictKind::Ambiguous));
    assert_eq!(names, ["screw-lead", "low-pass"]);
}

/// Facts keep every bit in a document, and rules ask for what is not there.
#[test]
fn limit_facts_survive_a_document_and_open_ones_are_asked_for() {
    let facts = plain();
    assert_eq!(judge(&facts, Policy::of(DataKind::Frf)).unwrap_err(), Need::OnePosition);
    let text = serde_json::to_string(&facts).unwrap();
    assert_eq!(serde_json::from_str::<Facts>(&text).unwrap(), facts);
    let cut = text.replace("\"unknowns\":8,", "");
    assert!(serde_json::from_str::<Facts>(&cut).is_err_and(|error| error.to_string().contains("unknowns")));
}

/// Facts of an effect and of an impedance at the nut, with their χ² and Occam factors.
fn weighed(effect_fits: f64, impedance_fits: f64) -> Facts {
    let mut facts = plain();
    fits(&mut facts, 1050.0, effect_fits);
    facts.candidates[0].places = vec!["screw".into()];
    facts.impedances = vec![impedance(1, 1050.0, impedance_fits)];
    facts.impedances_tried = 10;
    facts.holds_out = false;
    let models = [Model::Nominal, Model::Candidate(0), Model::Impedance(0)];
    facts.log_occam = models.map(|model| Of { model, value: -100.0 }).into();
    facts
}

/// What fits alike has the ratio of the prior probabilities, and the places of both are stated; all sum to 1.
#[test]
fn equal_evidence_leaves_the_prior_odds() {
    let found = explanations(&weighed(950.0, 950.0)).unwrap();
    let of = |id: &str| found.iter().find(|e| e.id == id).map_or(0.0, |e| e.probability);
    let odds = of("screw-lead") / of("unknown:nut");
    assert!((odds - 0.3 / (0.08 / 10.0)).abs() < 1e-9, "{odds}");
    assert!((found.iter().map(|e| e.probability).sum::<f64>() - 1.0).abs() < 1e-12);
    assert_eq!(places(&found), ["screw"]);
    assert_eq!(places(&explanations(&weighed(956.0, 943.0)).unwrap()), ["screw", "nut"]);
}

/// An effect that fits no better than the machine as described leaves all probability to this one, however little its
/// parameters are determined; more evidence makes it the verdict.
#[test]
fn an_effect_too_small_to_be_seen_counts_for_none() {
    for (fits, kind) in
        [(1050.0, VerdictKind::None), (1040.0, VerdictKind::None), (950.0, VerdictKind::Effect)]
    {
        assert_eq!(verdict_by_evidence(&weighed(fits, 1050.0)).unwrap().kind, kind, "{fits}");
    }
    assert_eq!(verdict_by_evidence(&weighed(1050.0, 930.0)).unwrap().kind, VerdictKind::Unknown);
    let mut lacking = weighed(950.0, 950.0);
    lacking.log_occam.clear();
    assert_eq!(explanations(&lacking), None);
}

/// A prior density that the data narrow less counts more: an Occam factor of e costs as much as 2 of χ².
#[test]
fn a_determined_parameter_costs_its_occam_factor() {
    let mut dearer = weighed(950.0, 1050.0);
    dearer.log_occam[1].value -= 10.0;
    let of = |facts: &Facts| explanations(facts).unwrap()[0].clone();
    let cheaper = of(&weighed(970.0, 1050.0));
    assert_eq!(cheaper.id, of(&dearer).id);
    assert!((of(&dearer).probability - cheaper.probability).abs() < 1e-9);
}
