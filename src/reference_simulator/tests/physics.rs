//! Tests of reciprocity, passivity and the influence of effects.

use num_complex::Complex64;

use super::subject;
use crate::case::{Subject, axis};
use crate::draw::Draw;
use crate::effect::{Effect, EffectKind};
use crate::machine::point::{Channel, Point};

fn lines() -> Vec<Complex64> {
    axis(&(1..200).map(|k| 5.0 * f64::from(k)).collect::<Vec<_>>())
}

/// Returns a subject whose drive suits the effect, with the effect at a given size.
fn with(kind: EffectKind, seed: u64, size: f64) -> Subject {
    let mut subject = subject(seed);
    if !kind.fits(true) {
        subject.drawn = crate::machine::catalogue::any_size(false, &mut Draw::new(seed));
    }
    let effect = Effect::random(kind, &subject.drawn, &mut Draw::new(seed).branch(1)).sized(size);
    subject.nuisance.channels.clear();
    Subject { effects: vec![effect], ..subject }
}

fn all() -> impl Iterator<Item = EffectKind> {
    EffectKind::LISTED.into_iter().chain(EffectKind::UNLISTED).chain([EffectKind::ContactLevel])
}

#[test]
fn mechanical_responses_are_reciprocal() {
    let channels = [Channel::new(Point::Rotor, Point::Table), Channel::new(Point::Table, Point::Rotor)];
    // Rocking has sensor and hammer at different heights, and feedback of the table scale is not mechanical.
    let one_way = [EffectKind::TableRocking, EffectKind::ScaleFeedback];
    for kind in all() {
        let subject = with(kind, 3, 1.0_f64.min(kind.largest()));
        let values = subject.receptances(1, 1.0, &channels, &lines()).unwrap();
        let worst = values[0].iter().zip(&values[1]).map(|(a, b)| (a / b - 1.0).norm()).fold(0.0, f64::max);
        assert_eq!(worst < 1e-7, !one_way.contains(&kind), "{}: {worst}", kind.name());
    }
}

#[test]
fn driving_points_of_passive_machines_absorb_power() {
    for kind in all().filter(|kind| {
        !matches!(
            kind,
            EffectKind::MeasurementDelay
                | EffectKind::ServoLag
                | EffectKind::ScaleFeedback
                | EffectKind::TableRocking
        )
    }) {
        for seed in [2, 5] {
            let mut subject = with(kind, seed, 1.0);
            // Lag and integral action of the drive are not passive either.
            (subject.nuisance.lag_share, subject.nuisance.integral_per_s) = (0.0, 0.0);
            if kind == EffectKind::RotorHold {
                subject.effects[0].shape = [0.0; 6];
            }
            for values in subject
                .receptances(
                    2,
                    1.0,
                    &[Channel::direct(Point::Table), Channel::direct(Point::Rotor)],
                    &lines(),
                )
                .unwrap()
            {
                let worst =
                    values.iter().map(|value| value.im / value.norm()).fold(f64::NEG_INFINITY, f64::max);
                assert!(worst <= 1e-9, "{} of machine {seed}: Im H / |H| = {worst}", kind.name());
            }
        }
    }
}

#[test]
fn effects_vanish_at_size_zero() {
    let channels = [
        Channel::direct(Point::Table),
        Channel::direct(Point::Rotor),
        Channel::new(Point::Left, Point::Table),
    ];
    for kind in all().filter(|kind| *kind != EffectKind::FrfQuantity) {
        let change = |size: f64| -> f64 {
            let subject = with(kind, 7, size);
            let there = subject.receptances(0, 1.5, &channels, &lines()).unwrap();
            let base = subject.without_effects().receptances(0, 1.5, &channels, &lines()).unwrap();
            let pairs = there.iter().flatten().zip(base.iter().flatten());
            pairs.map(|(a, b)| (a / b).ln().norm_sqr()).sum::<f64>().sqrt()
        };
        let (clear, tiny) = (change(1.0), change(1e-9));
        assert!(clear > 1e-3, "{} of size 1 changes the response by {clear} only", kind.name());
        assert!(tiny < 1e-2 * clear, "{} of size 1e-9 changes {tiny}, of size 1 {clear}", kind.name());
    }
}

#[test]
fn locations_are_names_of_the_engineers_model() {
    let known = [
        "table",
        "rotor",
        "left",
        "left-angle",
        "screw",
        "screw-angle",
        "right",
        "right-angle",
        "bearing-left",
        "bearing-right",
        "nut",
        "coupling",
        "measurement",
    ];
    for kind in all() {
        let place = with(kind, 4, 1.0).effects[0].place();
        assert_eq!(place.accepted[0], place.interface);
        assert!(
            place.accepted.iter().all(|name| known.contains(&name.as_str())),
            "{}: {place:?}",
            kind.name()
        );
    }
}

#[test]
fn machines_are_within_their_ranges() {
    for seed in 0..200 {
        let mut draw = Draw::new(seed);
        let drawn = crate::machine::catalogue::any_size(seed % 3 > 0, &mut draw);
        let description = &drawn.description;
        assert!(
            (0.4..=3.0).contains(&description.length_m) && (0.016..=0.063).contains(&description.diameter_m)
        );
        assert!(
            (0.005..=0.040).contains(&description.lead_m)
                && (20.0..=1500.0).contains(&description.table_mass_kg)
        );
        assert!((800.0..=1600.0).contains(&drawn.band_hz));
        assert_eq!(drawn.joints.len(), description.parameters.len());
        for parameter in &description.parameters {
            let truth = drawn.joints[parameter.name];
            assert!(
                (parameter.lower..=parameter.upper).contains(&truth),
                "{} of machine {seed}: {truth} not in its range",
                parameter.name
            );
            assert!((parameter.lower..=parameter.upper).contains(&parameter.start));
        }
        assert!(
            drawn.nut_m.windows(2).all(|pair| pair[0] < pair[1])
                && drawn.nut_m[5] < 0.8 * description.length_m
        );
    }
}
