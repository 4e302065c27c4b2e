//! Tests of layouts: sizes, descriptions, refused effects, and the strength of effects as the fitted data
//! show it.

use super::setting;
use crate::case::{ChannelSet, Counts, FittedGauge, Kind, Plan, Slot, Strength, Subject, Survey, imitation};
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::machine::layout::Layout;
use crate::machine::leeway::Leeway;
use crate::machine::nuisance::Nuisance;
use crate::machine::point::{Channel, Point};
use crate::{SimulatorError, generate_one};

/// A machine of a layout, with nuisance parameters.
fn machine(layout: Layout, seed: u64) -> Subject {
    let mut draw = Draw::new(seed);
    let drawn = layout.machine(true, layout == Layout::Vertical || draw.chance(0.5), &mut draw);
    let nuisance = Nuisance::of_layout(&drawn, &mut draw);
    Subject { drawn, nuisance, effects: Vec::new() }
}

fn gauge(subject: &Subject, given: Vec<usize>) -> FittedGauge {
    let channels = [Channel::direct(Point::Table)];
    let survey =
        Survey::new(subject, &setting(subject.drawn.band_hz), &channels, &[1.0], 1.0 / 150.0).unwrap();
    FittedGauge::new(subject, &survey.thinned(), given)
}

#[test]
fn layouts_cover_their_sizes_and_describe_themselves() {
    let (mut shortest, mut longest, mut lightest, mut heaviest) = (f64::INFINITY, 0.0, f64::INFINITY, 0.0);
    let mut counts = std::collections::BTreeSet::new();
    for layout in Layout::ALL {
        assert_eq!(Layout::named(layout.name()), Some(layout));
        for seed in 0..60 {
            let subject = machine(layout, seed);
            let description = &subject.drawn.description;
            shortest = description.length_m.min(shortest);
            longest = description.length_m.max(longest);
            lightest = description.table_mass_kg.min(lightest);
            heaviest = description.table_mass_kg.max(heaviest);
            counts.insert(subject.drawn.nut_m.len());
            assert!(subject.drawn.nut_m.windows(2).all(|pair| pair[0] < pair[1]), "{layout:?} {seed}");
            let built = subject.nuisance.applied(subject.drawn.with_true_joints());
            let ends = [built.screw.left.length_m, built.screw.length_m - built.screw.right.length_m];
            for (offset, _) in built.nut.shares() {
                for nut_m in &subject.drawn.nut_m {
                    assert!(
                        ends[0] < nut_m + offset && nut_m + offset < ends[1],
                        "{layout:?} {seed}: the nut reaches a journal"
                    );
                }
            }
            assert!(
                built.nut.joint.stiffness > 0.0
                    && subject.nuisance.joint_losses.iter().all(|loss| (1e-3..=0.07).contains(loss))
            );
            for (name, value) in &subject.drawn.joints {
                let stated = description.parameter(name).unwrap();
                assert!(
                    stated.lower < *value && *value < stated.upper,
                    "{layout:?} {seed}: {name} is {value}"
                );
            }
            let text = description.to_toml();
            assert_eq!(text.contains("name = \"bearing-right\""), layout != Layout::FixedFloating);
            assert_eq!(text.contains("on = { rotor = 1.0, left-angle = -"), layout == Layout::BeltDriven);
            assert_eq!(text.contains("name = \"guide\""), subject.drawn.joints.contains_key("c_g"));
            assert_eq!(text.contains("[tolerance]"), description.states_tolerances);
            assert!(
                layout != Layout::Vertical
                    || description.holds_rotor && subject.drawn.joints.contains_key("c_g")
            );
        }
    }
    assert!(
        shortest < 0.65 && longest > 4.5 && lightest < 25.0 && heaviest > 2500.0,
        "{shortest} {longest} {lightest} {heaviest}"
    );
    assert_eq!(counts, [3, 4, 5, 6].into());
}

/// Median and limits of the loss factors that Beards gives for assembled joints.
#[test]
fn losses_of_joints_are_about_one_per_cent() {
    let mut losses: Vec<f64> =
        (0..200).map(|seed| machine(Layout::Gantry, seed).nuisance.joint_losses[0]).collect();
    losses.sort_by(f64::total_cmp);
    assert!((0.007..0.014).contains(&losses[100]) && losses[195] > 0.04, "{} {}", losses[100], losses[195]);
}

#[test]
fn an_effect_that_a_layout_cannot_have_is_refused_and_none_other_takes_its_place() {
    let slot = Slot {
        layout: Some(Layout::Vertical),
        ..Slot::single(EffectKind::GuideViscous, Strength::Clear, ChannelSet::Table)
    };
    let refused = generate_one(1, &Plan { slots: vec![slot] }, 0).unwrap_err();
    assert!(
        matches!(refused, SimulatorError::NotOnLayout { layout: "vertical", effect: "guide-viscous", .. }),
        "{refused}"
    );
    let one = Plan::on_layouts(&Counts::QUICK, 3, Some(Layout::FixedFloating));
    assert!(one.slots.iter().all(|slot| slot.layout == Some(Layout::FixedFloating)));
    assert!(one.slots.iter().any(|slot| slot.effects == [EffectKind::BedCompliance]));
    let all = Plan::on_layouts(&Counts::QUICK, 3, None);
    for slot in &all.slots {
        let layout = slot.layout.unwrap();
        assert!(
            slot.effects.iter().chain(&slot.partner).all(|effect| layout.refusal(*effect).is_none()),
            "{slot:?}"
        );
    }
    for layout in Layout::ALL {
        let count = all.slots.iter().filter(|slot| slot.layout == Some(layout)).count();
        assert!((12..30).contains(&count), "{layout:?}: {count} of {}", all.slots.len());
    }
    let kinds = all.slots.iter().filter(|slot| slot.kind == Kind::Unknown).count();
    assert_eq!(kinds, EffectKind::UNLISTED.len() + 1);
}

#[test]
fn a_bearing_that_floats_has_no_wrong_stiffness() {
    let slot = Slot {
        layout: Some(Layout::FixedFloating),
        ..Slot::plain(Kind::HardNullWrongParameter, ChannelSet::Table)
    };
    let plan = Plan { slots: vec![slot; 8] };
    for index in 0..plan.slots.len() {
        let (_, label) = generate_one(5, &plan, index).unwrap();
        let (name, _) = label.wrong_parameter.unwrap();
        assert!(label.joints.contains_key(&name), "{name}");
    }
}

#[test]
fn fitted_joints_and_tolerances_leave_no_misfit_without_an_effect() {
    let subject = machine(Layout::FixedFloating, 4);
    let gauge = gauge(&subject, vec![0, 2]);
    assert!(gauge.noncentrality(&subject).unwrap() < 1e-9);
    // Two tolerances and a joint, each off by one standard deviation: the fit returns to them at their
    // prior's cost, or less.
    let by: Vec<f64> = gauge
        .leeway
        .iter()
        .map(|leeway| f64::from(u8::from(matches!(leeway, Leeway::Youngs | Leeway::TableMass))))
        .collect();
    let shifted = gauge.shifted(&subject, &by);
    let left = gauge.noncentrality(&shifted).unwrap();
    assert!(left > 0.0 && left < 2.0, "{left}");
    let mut stiffer = subject.clone();
    *stiffer.drawn.joints.get_mut("k_n").unwrap() *= 1.5;
    let left = gauge.noncentrality(&stiffer).unwrap();
    assert!(left < 1.0, "{left}");
}

#[test]
fn fewer_positions_show_less_of_an_effect() {
    let subject = machine(Layout::MediumAxis, 1);
    let count = subject.drawn.nut_m.len();
    let mut effect = Effect::random(EffectKind::TableRelaxation, &subject.drawn, &mut Draw::new(2));
    effect.size = 6.0;
    let with = Subject { effects: vec![effect], ..subject.clone() };
    let all = gauge(&subject, (0..count).collect()).noncentrality(&with).unwrap();
    let few = gauge(&subject, vec![0, 2]).noncentrality(&with).unwrap();
    assert!(few > 1.0 && few < all, "{few} of {all}");
}

/// An effect of the library in the place of an outside cause is recognised as imitated by itself; its misfit
/// without it is large.
#[test]
fn a_library_effect_imitates_itself() {
    let subject = machine(Layout::ShortAxis, 3);
    let gauge = gauge(&subject, vec![0, 2]);
    let mut effect = Effect::random(EffectKind::FrfGain, &subject.drawn, &mut Draw::new(5));
    effect.size = 3.0;
    let with = Subject { effects: vec![effect], ..subject.clone() };
    let alone = gauge.noncentrality(&with).unwrap();
    let possible = |kind: EffectKind| {
        matches!(kind, EffectKind::FrfGain | EffectKind::MeasurementDelay | EffectKind::TableMass)
    };
    let closest = imitation(&gauge, &with, possible, &Draw::new(1)).unwrap().unwrap();
    assert!(alone > 60.0 && closest.noncentrality < 1.0, "{alone}: {closest:?}");
    assert_eq!(closest.effect, "frf-gain");
}

/// A bed on its mounts brings two resonances of its own, which a search must meet among its drawn shapes.
#[test]
fn a_resonating_library_effect_imitates_itself() {
    let subject = machine(Layout::MediumAxis, 6);
    let gauge = gauge(&subject, vec![0, 2]);
    let mut effect = Effect::random(EffectKind::BedCompliance, &subject.drawn, &mut Draw::new(8));
    effect.size = 1.0;
    let with = Subject { effects: vec![effect], ..subject.clone() };
    let alone = gauge.noncentrality(&with).unwrap();
    let possible = |kind: EffectKind| matches!(kind, EffectKind::BedCompliance | EffectKind::TableMass);
    let closest = imitation(&gauge, &with, possible, &Draw::new(1)).unwrap().unwrap();
    assert_eq!(closest.effect, "bed-compliance");
    assert!(alone > 1000.0 && closest.noncentrality < 20.0, "{alone}: {closest:?}");
}
