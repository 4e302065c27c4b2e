//! Plans, strength, labels and files.

use std::collections::BTreeSet;

use nalgebra::{Matrix4, Vector4};

use crate::Result;
use crate::case::{Kind, Label, Strength};
use crate::draw::Draw;
use crate::motion::case::{Case, Choice, FULL, Gauge, Plan, QUICK, Slot, generate_one, write_case};
use crate::motion::effect::{Effect, EffectKind};
use crate::motion::phase::{Phase, phases};
use crate::motion::run::{RECORD_S, Side};
use crate::tests::{check_folder, check_label};

fn generate(seed: u64, plan: &Plan) -> impl Iterator<Item = Result<(Case, Label)>> {
    (0..plan.slots.len()).map(move |index| generate_one(seed, plan, index))
}

fn small() -> Plan {
    let single = |effect, side| Slot::single(effect, Strength::Strong, side);
    let double = Slot {
        kind: Kind::Double,
        effects: vec![EffectKind::TorqueRipple, EffectKind::FrictionAsymmetry],
        ..Slot::single(EffectKind::TorqueRipple, Strength::Clear, Side::Motor)
    };
    Plan {
        slots: vec![
            Slot::plain(Kind::Null, Side::Motor),
            Slot::plain(Kind::Null, Side::Table),
            Slot::plain(Kind::HardNullWrongParameter, Side::Motor),
            Slot::plain(Kind::HardNullBadChannel, Side::Motor),
            single(EffectKind::CoulombFriction, Side::Motor),
            single(EffectKind::LeadError, Side::Motor),
            Slot::look_alike(EffectKind::Backlash, EffectKind::DriveFlexibility, Strength::Clear),
            double,
            Slot { kind: Kind::Unknown, ..single(EffectKind::CableChain, Side::Motor) },
        ],
    }
}

#[test]
fn cases_do_not_depend_on_threads_or_order() {
    let plan = small();
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let alone = pool(1).install(|| generate_one(11, &plan, 4)).unwrap();
    let several = pool(3).install(|| generate_one(11, &plan, 4)).unwrap();
    assert!(alone == several);
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
        assert_eq!(label.phases.is_empty(), slot.effects.is_empty());
        assert_eq!(case.belief.has("coulomb_friction"), !slot.effects.contains(&EffectKind::CoulombFriction));
        assert_eq!(case.fit.len() + 1, case.records.len());
        if slot.strength == Some(Strength::Strong) {
            assert!(label.noncentrality[0] > 90.0, "{}: {:?}", label.case, label.noncentrality);
        }
        let ratio = label.gap.without_held_out.hypot(label.gap.floor_held_out) / label.gap.floor_held_out;
        let least = if slot.kind == Kind::LookAlike { 1.0 } else { 1.1 };
        assert!((least..2.0).contains(&ratio), "{ratio}");
        if let Some(more) = &case.follow_up {
            assert!(more.records.len() > case.records.len() && more.belief == case.belief);
            assert!(
                more.records[0].log != case.records[0].log,
                "the follow-up is a new test of the same axis"
            );
        }
    }
}

/// Applies two moving averages in sequence: a filter independent of the gauge's.
fn smooth(values: &[f64], half: usize) -> Vec<f64> {
    let mean = |values: &[f64]| -> Vec<f64> {
        let near = |k: usize| &values[k.saturating_sub(half)..(k + half + 1).min(values.len())];
        (0..values.len()).map(|k| near(k).iter().sum::<f64>() / near(k).len() as f64).collect()
    };
    mean(&mean(values))
}

/// Fits mass, viscous and dry friction and offset by least squares to the fitted records; returns residual
/// over force of the held-out one.
fn simple_gap(case: &Case) -> f64 {
    let motor_kg = case.belief.motor_kg.unwrap_or(0.0);
    let rows = |name: &str| -> Vec<(Vector4<f64>, f64, f64)> {
        let log = &case.records.iter().find(|record| record.name == name).unwrap().log;
        let speed = |x: &[f64]| -> Vec<f64> {
            (0..x.len())
                .map(|k| (x[(k + 1).min(x.len() - 1)] - x[k.saturating_sub(1)]) / (2.0 * RECORD_S))
                .collect()
        };
        let v = smooth(&speed(&log.position_m), 4);
        let a = speed(&v);
        let s = smooth(&v.iter().map(|v| v.signum()).collect::<Vec<f64>>(), 4);
        let (v, a, s, f) = (smooth(&v, 0), smooth(&a, 4), s, smooth(&log.force_n, 4));
        let top = v.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        (60..f.len() - 60)
            .step_by(10)
            .filter(|&k| v[k].abs() > 0.005 * top)
            .map(|k| (Vector4::new(a[k], v[k], s[k], 1.0), f[k] - motor_kg * a[k], f[k]))
            .collect()
    };
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (columns, value, _) in case.fit.iter().flat_map(|name| rows(name)) {
        normal += columns * columns.transpose();
        right += columns * value;
    }
    let found = normal.cholesky().unwrap().solve(&right);
    let held: Vec<_> = case
        .records
        .iter()
        .filter(|record| !case.fit.contains(&record.name))
        .flat_map(|record| rows(&record.name))
        .collect();
    let (residual, all) = held.iter().fold((0.0, 0.0), |(residual, all), (columns, value, force)| {
        (residual + (value - columns.dot(&found)).powi(2), all + force * force)
    });
    f64::sqrt(residual / all)
}

/// Returns the gap due to the noise of a case with the same filter.
fn simple_floor(choice: &Choice, case: &Case) -> f64 {
    let held = case.records.iter().find(|record| !case.fit.contains(&record.name)).unwrap();
    let noise = smooth(&choice.test.sensors.noise(held.log.force_n.len(), &mut Draw::new(9)), 4);
    let force = smooth(&held.log.force_n, 4);
    let power = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
    (power(&noise) / power(&force)).sqrt()
}

#[test]
fn nulls_give_a_simple_model_a_gap_slightly_above_noise() {
    let slot = Slot::plain(Kind::Null, Side::Motor);
    let plan = Plan { slots: vec![slot.clone(); 6] };
    for (index, made) in generate(21, &plan).enumerate() {
        let (case, label) = made.unwrap();
        let mut draw = Draw::new(21).branch(0x6178_6973).branch(index as u64).branch(label.refused as u64);
        let mut choice = Choice::random(&slot, label.refused, &mut draw);
        let wanted = draw.between(1.15, 1.6);
        choice.test.set_noise(&choice.drawn.machine.clone(), wanted, &draw.branch(11));
        let ratio = simple_gap(&case) / simple_floor(&choice, &case);
        println!("null {index}: the gap of a simple model is {ratio:.2} times the noise floor");
        assert!((1.1..2.0).contains(&ratio), "null {index}: {ratio}");
    }
}

#[test]
fn nulls_have_no_strength_and_effects_reach_the_requested_strength() {
    let slot = Slot::plain(Kind::Null, Side::Table);
    let mut choice = Choice::random(&slot, 0, &mut Draw::new(2));
    let (machine, limits) = (choice.drawn.machine.clone(), choice.drawn.limits);
    choice.test.set_noise(&machine, 1.5, &Draw::new(3));
    let gauge = Gauge::new(choice.test.clone(), &machine, &limits, &Draw::new(3)).unwrap();
    assert!(gauge.unexplained(&machine).noncentrality < 1e-12);
    // Parameters that the engineer fits are no effects.
    let mut other = machine.clone();
    other.axis.masses_kg[2] *= 1.005;
    other.axis.guide.viscous_n_s_m *= 1.03;
    other.axis.pull_n += 0.5;
    let unexplained = gauge.unexplained(&other).noncentrality;
    assert!(unexplained < 5.0, "{unexplained}");
    for kind in [EffectKind::FrictionAsymmetry, EffectKind::TorqueRipple, EffectKind::LeadError] {
        let effect = Effect::random(kind, &mut Draw::new(1));
        for wanted in [25.0, 100.0] {
            let size = gauge.size_for(&effect, &machine, &limits, wanted).unwrap();
            let reached = gauge.unexplained(&choice.with([&effect.sized(size)])).noncentrality;
            assert!((reached / wanted - 1.0).abs() < 0.06, "{}: {reached} for {wanted}", kind.name());
        }
    }
}

/// Returns the share of an effect that the other effect, scaled freely, cannot explain.
fn unexplained_share(gauge: &Gauge, choice: &Choice, truth: EffectKind, partner: EffectKind) -> f64 {
    let (machine, limits) = (&choice.drawn.machine, &choice.drawn.limits);
    let change = |kind| {
        let effect = Effect::random(kind, &mut Draw::new(4));
        let size = gauge.size_for(&effect, machine, limits, 25.0).unwrap();
        gauge.explained.residual(&gauge.change(&choice.with([&effect.sized(size)])))
    };
    let (truth, partner) = (change(truth), change(partner));
    1.0 - truth.dot(&partner).powi(2) / (truth.norm_squared() * partner.norm_squared())
}

#[test]
#[ignore = "second tier"]
fn follow_up_distinguishes_look_alikes() {
    for (truth, partner) in EffectKind::LOOK_ALIKES {
        let slot = Slot::look_alike(truth, partner, Strength::Clear);
        let mut draw = Draw::new(6);
        let mut choice = Choice::random(&slot, 0, &mut draw);
        let (machine, limits) = (choice.drawn.machine.clone(), choice.drawn.limits);
        choice.test.set_noise(&machine, 1.5, &draw);
        let first = Gauge::new(choice.test.clone(), &machine, &limits, &draw).unwrap();
        let more = Gauge::new(choice.test.with_more(&limits, &mut draw.branch(8)), &machine, &limits, &draw)
            .unwrap();
        let (few, all) = (
            unexplained_share(&first, &choice, truth, partner),
            unexplained_share(&more, &choice, truth, partner),
        );
        println!(
            "{} after {}: share not explained {few:.2}, {all:.2} with the follow-up",
            truth.name(),
            partner.name()
        );
        assert!(few < 0.5 && all > few + 0.25, "{} / {}: {few} then {all}", truth.name(), partner.name());
    }
}

#[test]
fn effects_vanish_at_size_zero_and_have_a_location() {
    use crate::motion::path::{Path, Piece};
    use crate::motion::run::STEP_S;
    let mut draw = Draw::new(8);
    let choice = Choice::random(&Slot::plain(Kind::Null, Side::Table), 0, &mut draw);
    let limits = choice.drawn.limits;
    let stroke = |to: f64| Piece::Stroke {
        to_m: to * limits.stroke_m,
        speed_m_s: limits.speed_m_s,
        acceleration_m_s2: limits.acceleration_m_s2,
    };
    let path = Path { start_m: 0.1 * limits.stroke_m, pieces: vec![stroke(0.6), stroke(0.3)] };
    let base = choice.drawn.machine.run(&path, STEP_S, None);
    for kind in EffectKind::LISTED.into_iter().chain(EffectKind::UNLISTED) {
        let effect = Effect::random(kind, &mut draw);
        let moved = |size: f64| {
            let there = choice.with([&effect.sized(size)]).run(&path, STEP_S, None);
            let forces = there.force_n.iter().zip(&base.force_n).map(|(a, b)| (a - b).abs());
            let tables = there.table_m.iter().zip(&base.table_m).map(|(a, b)| (a - b).abs() * 1e6);
            forces.chain(tables).fold(0.0, f64::max)
        };
        let (hardly, usual) = (moved(1e-4), moved(1.0));
        assert!(usual > 0.5 && hardly < 0.1 * usual, "{}: {hardly} then {usual}", kind.name());
        assert_eq!(kind.place().accepted[0], kind.place().interface);
        assert!(effect.values(&choice.drawn.machine, &limits)["size"] == 1.0);
    }
}

#[test]
fn phases_match_the_pieces_of_a_motion() {
    use crate::motion::path::{Path, Piece};
    let pieces = vec![
        Piece::Dwell(0.3),
        Piece::Stroke { to_m: 0.3, speed_m_s: 0.2, acceleration_m_s2: 1.0 },
        Piece::Stroke { to_m: 0.1, speed_m_s: 0.2, acceleration_m_s2: 1.0 },
        Piece::Dwell(0.5),
    ];
    let path = Path { start_m: 0.0, pieces };
    let found = phases(&path.sampled(RECORD_S, (path.duration_s() / RECORD_S) as usize), RECORD_S);
    // Ramps of 0.3 s, strokes of 1.8 and 1.3 s.
    let at = |time_s: f64| found[(time_s / RECORD_S) as usize];
    for (time_s, phase) in [
        (0.1, Phase::Dwell),
        (0.32, Phase::Breakaway),
        (0.5, Phase::Acceleration),
        (1.0, Phase::ConstantSpeed),
        (1.95, Phase::Acceleration),
        (2.12, Phase::Reversal),
        (2.7, Phase::ConstantSpeed),
        (3.45, Phase::Settling),
        (3.7, Phase::Dwell),
    ] {
        assert_eq!(at(time_s), phase, "{time_s}");
    }
    let names: BTreeSet<&str> = Phase::ALL.iter().map(|phase| phase.name()).collect();
    assert_eq!(names.len(), 6);
}

#[test]
fn folders_contain_nothing_of_labels() {
    let plan = small();
    let folder = std::env::temp_dir().join(format!("simulator-motion-{}", std::process::id()));
    for index in [4, 6] {
        let (case, label) = generate_one(5, &plan, index).unwrap();
        let place = folder.join(&case.name);
        write_case(&place, &case).unwrap();
        let [manifest, machine] = check_folder(&place, "motion", &label);
        assert_eq!(manifest.matches("[[motion]]").count(), case.records.len());
        assert_eq!(machine.matches("[parameter.").count(), case.belief.parameters.len());
        assert_eq!(manifest.contains("response = \"table\""), case.belief.side == Side::Table);
        let text = std::fs::read_to_string(place.join(case.records[0].file())).unwrap();
        assert!(text.starts_with("time_s,command_m,position_m,force_n\n0.000,"));
        assert_eq!(text.lines().count(), case.records[0].log.command_m.len() + 1);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn plans_contain_every_case_in_shuffled_order() {
    for counts in [QUICK, FULL] {
        let plan = Plan::from_counts(&counts, 1);
        let count = |kind| plan.slots.iter().filter(|slot| slot.kind == kind).count();
        assert_eq!(count(Kind::Null), counts.nulls);
        assert_eq!(count(Kind::LookAlike), 2 * EffectKind::LOOK_ALIKES.len() * counts.look_alikes_per_truth);
        assert_eq!(count(Kind::Unknown), EffectKind::UNLISTED.len() * counts.unknowns_per_effect);
        for effect in EffectKind::LISTED {
            let singles: Vec<_> = plan
                .slots
                .iter()
                .filter(|slot| slot.kind == Kind::Single && slot.effects == [effect])
                .collect();
            assert_eq!(singles.len(), counts.singles_per_effect);
            let strengths: BTreeSet<_> = singles.iter().map(|slot| slot.strength).collect();
            assert_eq!(strengths.len(), counts.singles_per_effect.min(3));
            assert!(effect.side().is_none_or(|side| singles.iter().all(|slot| slot.side == side)));
        }
        assert!(plan != Plan::from_counts(&counts, 2));
        assert!(plan == Plan::from_counts(&counts, 1));
    }
    assert!(generate_one(1, &Plan { slots: Vec::new() }, 0).is_err());
}
