//! Tests of plans, strength, labels and files.

use std::collections::BTreeSet;

use super::{check_folder, check_label, setting, subject};
use crate::case::{
    ChannelSet, Counts, Fit, Gauge, Kind, LOOK_ALIKES, Plan, Quantity, Slot, Strength, Subject, Survey,
};
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::{Case, Label, Result, generate_one, write_case};

fn generate(seed: u64, plan: &Plan) -> impl Iterator<Item = Result<(Case, Label)>> {
    (0..plan.slots.len()).map(move |index| generate_one(seed, plan, index))
}

fn small() -> Plan {
    let unknown = Slot {
        kind: Kind::Unknown,
        ..Slot::single(EffectKind::HoseResonator, Strength::Strong, ChannelSet::Table)
    };
    let pair = Slot {
        kind: Kind::LookAlike,
        partner: Some(EffectKind::TableRocking),
        ..Slot::single(EffectKind::BedCompliance, Strength::Strong, ChannelSet::Table)
    };
    let double = Slot {
        kind: Kind::Double,
        effects: vec![EffectKind::GuideViscous, EffectKind::TableMass],
        ..Slot::single(EffectKind::GuideViscous, Strength::Clear, ChannelSet::Table)
    };
    Plan {
        slots: vec![
            Slot::plain(Kind::Null, ChannelSet::Cross),
            Slot::plain(Kind::HardNullWrongParameter, ChannelSet::Table),
            Slot::plain(Kind::HardNullBadChannel, ChannelSet::Rotor),
            Slot::single(EffectKind::TableMass, Strength::Strong, ChannelSet::Table),
            Slot::single(EffectKind::FrfQuantity, Strength::Strong, ChannelSet::Table),
            Slot::single(EffectKind::ContactLevel, Strength::Strong, ChannelSet::Table),
            pair,
            double,
            unknown,
        ],
    }
}

#[test]
fn cases_do_not_depend_on_threads_or_order() {
    let plan = small();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    for index in [0, 3] {
        let alone = pool(1).install(|| generate_one(11, &plan, index)).unwrap();
        let several = pool(3).install(|| generate_one(11, &plan, index)).unwrap();
        assert!(alone == several, "case {index}");
    }
    let first = generate(11, &plan).next().unwrap().unwrap();
    assert!(first == generate_one(11, &plan, 0).unwrap());
    assert!(first.0.records != generate_one(12, &plan, 0).unwrap().0.records);
}

#[test]
#[ignore = "second tier"]
fn cases_match_their_labels() {
    let plan = small();
    for (index, made) in generate(5, &plan).enumerate() {
        let (case, label) = made.unwrap();
        let slot = &plan.slots[index];
        assert_eq!((label.index, &label.case), (index, &case.name));
        check_label(&label, slot.kind, slot.effects.len(), case.follow_up.is_some());
        assert_eq!(label.band_hz.is_some(), !slot.effects.is_empty());
        assert_eq!(label.exact.len(), case.records.len());
        assert!(label.hammer.unwrap().estimator_bias < 0.01);
        assert!(!label.effects.contains(&"rotor-hold".to_owned()) || !case.description.holds_rotor);
        if slot.strength == Some(Strength::Strong) {
            assert!(label.noncentrality[0] > 60.0, "{}: {:?}", label.case, label.noncentrality);
        }
        for (record, exact) in case.records.iter().zip(&label.exact) {
            assert_eq!((&record.position, record.channel), (&exact.position, exact.channel));
            let accepted: Vec<_> =
                record.lines.iter().zip(&exact.with).filter(|(line, _)| line.coherence >= 0.8).collect();
            assert!((250..1200).contains(&accepted.len()), "{} lines in {}", accepted.len(), record.file());
            let squares: f64 =
                accepted.iter().map(|(line, exact)| (line.response / **exact).ln().norm_sqr() / 2.0).sum();
            let noise = (squares / accepted.len() as f64).sqrt();
            let is_bad = label.faulty_records.contains(&record.file());
            assert!(
                is_bad || noise < 0.12,
                "{} of {}: {noise} rms from its exact curve",
                record.file(),
                label.case
            );
        }
    }
}

#[test]
fn nulls_have_no_strength_and_effects_reach_the_requested_strength() {
    let subject = subject(2);
    let setting = setting(subject.drawn.band_hz);
    let survey = Survey::new(&subject, &setting, &ChannelSet::Cross.channels(), &[1.0], 1.0 / 150.0).unwrap();
    let gauge = Gauge::new(&subject, survey.clone()).unwrap();
    assert!(gauge.unexplained(&subject).unwrap().noncentrality < 1e-12);
    // A changed joint is no effect.
    let mut stiffer = subject.clone();
    *stiffer.drawn.joints.get_mut("k_n").unwrap() *= 1.02;
    let mut heavier = subject.clone();
    heavier.nuisance.masses[0] += 0.02;
    let (joint, mass) = (
        gauge.unexplained(&stiffer).unwrap().noncentrality,
        gauge.unexplained(&heavier).unwrap().noncentrality,
    );
    assert!(joint < 1.0, "{joint}");
    assert!(mass > 5.0, "{mass}");
    for kind in [EffectKind::GuideViscous, EffectKind::CouplingInertia, EffectKind::FrfGain] {
        let effect = Effect::random(kind, &subject.drawn, &mut Draw::new(1));
        let alone = Subject { effects: vec![effect], ..subject.clone() };
        for wanted in [9.0, 25.0] {
            let size = gauge.size_for(&alone, wanted).unwrap();
            let reached = gauge
                .unexplained(&Subject { effects: vec![alone.effects[0].sized(size)], ..alone.clone() })
                .unwrap()
                .noncentrality;
            assert!((reached / wanted - 1.0).abs() < 0.03, "{}: {reached} for {wanted}", kind.name());
        }
    }
}

#[test]
fn refit_of_the_chain_recovers_its_joints() {
    let mut subject = subject(1);
    subject.nuisance = crate::machine::nuisance::Nuisance::none(6);
    let survey = Survey::new(
        &subject,
        &setting(subject.drawn.band_hz),
        &ChannelSet::Cross.channels(),
        &[1.0],
        1.0 / 100.0,
    )
    .unwrap();
    let fit = Fit::of_chain(&subject.drawn, &survey);
    let start: Vec<f64> = fit.true_point().iter().map(|value| value + 0.05).collect();
    let found = fit.run(&survey.base, &start).unwrap();
    assert!(found.held_out < 2e-4 && found.fit < 2e-4, "{found:?}");
}

#[test]
fn folders_contain_nothing_of_labels() {
    let plan = small();
    let folder = std::env::temp_dir().join(format!("simulator-case-{}", std::process::id()));
    for index in [4, 5] {
        let (case, label) = generate_one(5, &plan, index).unwrap();
        let place = folder.join(&case.name);
        write_case(&place, &case).unwrap();
        let [manifest, machine] = check_folder(&place, "frf", &label);
        assert_eq!(manifest.matches("[[frf]]").count(), case.records.len());
        assert_eq!(machine.matches("[parameter.").count(), case.description.parameters.len());
        let text = std::fs::read_to_string(place.join(case.records[0].file())).unwrap();
        assert!(text.starts_with("frequency_hz,real,imag,coherence\n"));
        assert_eq!(text.lines().count(), case.records[0].lines.len() + 1);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn plans_contain_every_case_in_shuffled_order() {
    let plan = Plan::from_counts(&Counts::FULL, 1);
    let count = |kind| plan.slots.iter().filter(|slot| slot.kind == kind).count();
    assert_eq!(count(Kind::Null), Counts::FULL.nulls);
    assert_eq!(count(Kind::LookAlike), 2 * LOOK_ALIKES.len() * Counts::FULL.look_alikes_per_truth);
    assert_eq!(count(Kind::Unknown), EffectKind::UNLISTED.len() * Counts::FULL.unknowns_per_effect);
    for effect in EffectKind::LISTED {
        let singles: Vec<_> =
            plan.slots.iter().filter(|slot| slot.kind == Kind::Single && slot.effects == [effect]).collect();
        assert_eq!(singles.len(), Counts::FULL.singles_per_effect);
        let strengths: BTreeSet<_> = singles.iter().map(|slot| slot.strength).collect();
        let channel_sets: BTreeSet<_> = singles.iter().map(|slot| slot.channel_set).collect();
        assert!(channel_sets.len() == 4 && (strengths.len() == 4 || effect == EffectKind::FrfQuantity));
    }
    assert!(plan != Plan::from_counts(&Counts::FULL, 2));
    assert!(plan == Plan::from_counts(&Counts::FULL, 1));
    assert!(generate_one(1, &Plan { slots: Vec::new() }, 0).is_err());
    assert_eq!(Quantity::Accelerance.name(), "accelerance");
}
