use std::time::Instant;

use num_complex::Complex64;

use super::planted::{Draw, PlantedMode, even, mode, receptance};
use crate::modal::{
    Amplitude, AmplitudeKind, CurveOptions, FittedMode, FrfCurve, ModalFit, Stability, TrackRecord,
    TrackedMode, fit_curve, track,
};

const POSITIONS_M: [f64; 6] = [0.6, 0.5, 0.4, 0.3, 0.2, 0.1];
const NAMES: [&str; 6] = ["l1", "l2", "l3", "l4", "l5", "l6"];

/// Bench with modes like those of Tian et al. at a position u over its travel (0 to 1).
struct Bench {
    damping: [f64; 4],
    shift: [f64; 4],
    node: bool,
}

impl Bench {
    fn of(draw: &mut Draw, node: bool) -> Self {
        let mut log_uniform = |low: f64, high: f64| draw.uniform(low.ln(), high.ln()).exp();
        let damping = [
            log_uniform(0.02, 0.08),
            log_uniform(0.01, 0.08),
            log_uniform(0.005, 0.03),
            log_uniform(0.005, 0.03),
        ];
        Self {
            damping,
            shift: [
                draw.uniform(0.0, 1.0),
                draw.uniform(0.0, 1.0),
                draw.uniform(0.0, 1.0),
                draw.uniform(0.0, 1.0),
            ],
            node,
        }
    }

    fn modes(&self, u: f64) -> [PlantedMode; 4] {
        let s = self.shift;
        let bend = 1.0 - (2.0 * u - 1.0).powi(2);
        let third = if self.node { 4e-7 * (u - 0.6) / 0.4 } else { 4e-7 * (1.0 - 0.3 * u) };
        [
            mode(24.0 - s[0] * u, self.damping[0], 3e-4 * (1.0 + 0.3 * u)),
            mode(112.0 + 6.0 * s[1] + 10.0 * (1.0 - u), self.damping[1], 2.6e-5 * (1.0 + 0.4 * u)),
            mode(532.0 + (10.0 + 18.0 * s[2]) * bend, self.damping[2] * (1.0 + 0.2 * u), third),
            mode(695.0 + 30.0 * s[3] * u, self.damping[3], 2.4e-7 * (1.0 + 0.3 * bend)),
        ]
    }
}

/// Draws spurious peaks: anywhere in the band, damping 0.5 to 8 %, as strong as the real ones around them.
fn spurious(draw: &mut Draw, count: usize) -> Vec<PlantedMode> {
    (0..count)
        .map(|_| {
            let f = draw.uniform(15.0, 990.0);
            let level = 3e-4 * (24.0 / f).powf(2.1);
            let sign = if draw.uniform(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
            mode(
                f,
                draw.uniform(0.005_f64.ln(), 0.08_f64.ln()).exp(),
                sign * level * draw.uniform(-0.7, 0.7).exp(),
            )
        })
        .collect()
}

struct Set {
    bench: Bench,
    fits: Vec<ModalFit>,
}

fn set(seed: u64, spurious_peaks: usize, node: bool) -> Set {
    let mut draw = Draw::new(seed);
    let bench = Bench::of(&mut draw, node);
    let f = even(5.0, 1.0, 996);
    let fits = (0..6)
        .map(|at| {
            let mut modes = bench.modes(at as f64 / 5.0).to_vec();
            modes.extend(spurious(&mut draw, spurious_peaks));
            let clean: Vec<Complex64> = f.iter().map(|f| receptance(&modes, 3e-3, 4e-8, *f)).collect();
            let h = draw.noisy(&clean, 0.02);
            let curve = FrfCurve { frequency_hz: &f, receptance: &h, component_sd: None, omega_power: 0 };
            fit_curve(&curve, &CurveOptions::default()).unwrap()
        })
        .collect();
    Set { bench, fits }
}

fn tracked(set: &Set) -> Vec<TrackedMode> {
    let records: Vec<TrackRecord> = (0..6)
        .map(|at| TrackRecord {
            nut_m: Some(POSITIONS_M[at]),
            series: "table/table",
            band_hz: (5.0, 1000.0),
            modes: &set.fits[at].modes,
        })
        .collect();
    track(&records)
}

/// Counts the true modes kept (correct at 4 or more positions) and the other tracks kept.
fn kept(set: &Set, tracks: &[TrackedMode]) -> (usize, usize) {
    let mut taken = [false; 4];
    let mut wrong = 0;
    for track in tracks.iter().filter(|t| t.regular) {
        let hits = |order: usize| {
            let right = |(record, index): &&(usize, usize)| {
                let truth = set.bench.modes(*record as f64 / 5.0)[order].frequency_hz;
                (set.fits[*record].modes[*index].frequency_hz / truth - 1.0).abs() < 0.015
            };
            track.sightings.iter().filter(right).count()
        };
        match (0..4).find(|order| !taken[*order] && hits(*order) >= 4) {
            Some(order) => taken[order] = true,
            None => wrong += 1,
        }
    }
    (taken.iter().filter(|t| **t).count(), wrong)
}

fn describe(set: &Set, track: &TrackedMode) -> String {
    let seen: Vec<String> = track
        .sightings
        .iter()
        .map(|(r, m)| format!("{}:{:.1}", NAMES[*r], set.fits[*r].modes[*m].frequency_hz))
        .collect();
    format!(
        "{} {:.1} Hz [{}] {:?}",
        track.regular,
        track.frequency_hz,
        seen.join(" "),
        track.evidence.reasons
    )
}

#[test]
fn recover_four_modes_among_six_spurious_peaks_per_position() {
    let (mut lost, mut most_wrong, mut all_wrong) = (0, 0, 0);
    let mut worst = (4, 0, 0);
    let draws = test_data::draws(10, 100);
    for seed in 0..draws {
        let set = set(1000 + seed, 6, false);
        let tracks = tracked(&set);
        let (right, wrong) = kept(&set, &tracks);
        lost += 4 - right;
        all_wrong += wrong;
        most_wrong = most_wrong.max(wrong);
        if right < worst.0 || (right == worst.0 && wrong > worst.1) {
            worst = (right, wrong, seed);
        }
        if right < 4 || wrong > 1 {
            println!("draw {seed}: {right} kept, {wrong} wrong");
            for t in tracks.iter().filter(|t| t.regular || t.sightings.len() > 3) {
                println!("   {}", describe(&set, t));
            }
            println!(
                "   truth {:?}",
                (0..6)
                    .map(|p| set.bench.modes(f64::from(p) / 5.0).map(|m| m.frequency_hz.round()))
                    .collect::<Vec<_>>()
            );
        }
    }
    println!(
        "{draws} draws: {lost} of {} modes lost, {all_wrong} spurious kept in all, most in a draw {most_wrong}; worst draw {} ({} kept, {} spurious)",
        4 * draws,
        worst.2,
        worst.0,
        worst.1
    );
    assert_eq!(lost, 0);
    assert!(most_wrong <= 1);
}

/// Returns a mode as a fit reports it.
fn reported(frequency_hz: f64, sd_hz: f64, damping_ratio: f64, value: f64) -> FittedMode {
    FittedMode {
        frequency_hz,
        frequency_sd_hz: sd_hz,
        damping_ratio,
        damping_sd: 0.05 * damping_ratio,
        amplitude: Amplitude { value, sd: 0.01 * value, frequency_hz, kind: AmplitudeKind::Peak },
        residue: Complex64::ONE,
        stability: Stability { stable: 9, orders: 10 },
        prominence: 5.0,
        signal_to_noise: 100.0,
    }
}

fn of_modes(positions_m: &[f64], modes: &[Vec<FittedMode>]) -> Vec<TrackedMode> {
    let records: Vec<TrackRecord> = positions_m
        .iter()
        .zip(modes)
        .map(|(nut_m, modes)| TrackRecord {
            nut_m: Some(*nut_m),
            series: "table",
            band_hz: (5.0, 1000.0),
            modes,
        })
        .collect();
    track(&records)
}

/// Tian et al., Tables 1 and 2 (positions l1, l3, l5): the third mode moves from 523 to 565 and 561 Hz.
#[test]
fn published_modes_of_three_positions_are_regular() {
    let hz = [[24.0, 118.0, 523.0, 716.0], [24.0, 116.0, 565.0, 721.0], [23.0, 113.0, 561.0, 728.0]];
    let m = [
        [2.44e-4, 2.62e-5, 4.13e-7, 2.24e-7],
        [3.70e-4, 3.06e-5, 4.06e-7, 2.91e-7],
        [3.54e-4, 3.61e-5, 3.71e-7, 2.51e-7],
    ];
    let modes: Vec<Vec<FittedMode>> =
        (0..3).map(|p| (0..4).map(|k| reported(hz[p][k], 0.3, 0.03, m[p][k])).collect()).collect();
    let tracks = of_modes(&[0.6, 0.4, 0.2], &modes);
    for t in &tracks {
        println!("{} {:.1} {:?}", t.regular, t.frequency_hz, t.evidence.reasons);
    }
    assert_eq!(tracks.len(), 4);
    assert!(tracks.iter().all(|t| t.regular && t.sightings.len() == 3));
}

/// Sets of spurious peaks have few regular tracks: the option allows 0.03 per set, the test twice as many.
#[test]
#[ignore = "second tier"]
fn limit_chance_makes_few_regular_tracks() {
    for (positions, peaks) in [(6_u32, 6_u32), (6, 12), (12, 8)] {
        let mut draw = Draw::new(u64::from(peaks));
        let mut regular = 0;
        let sets = test_data::draws(100, 200);
        for _ in 0..sets {
            let mut one = |_| {
                let f = draw.uniform(15.0, 990.0);
                reported(f, 1e-4 * f, 0.02, 1e-4 * (24.0 / f).powi(2) * draw.uniform(-0.7, 0.7).exp())
            };
            let modes: Vec<Vec<FittedMode>> =
                (0..positions).map(|_| (0..peaks).map(&mut one).collect()).collect();
            let positions_m: Vec<f64> = (0..positions).map(f64::from).collect();
            regular += of_modes(&positions_m, &modes).iter().filter(|t| t.regular).count();
        }
        println!(
            "{positions} positions, {peaks} chance peaks each: {:.3} regular tracks per set",
            regular as f64 / sets as f64
        );
        assert!(50 * regular as u64 <= 3 * sets, "{regular} in {sets}");
    }
}

#[test]
fn recover_a_mode_with_a_node_at_one_position() {
    let set = set(7, 0, true);
    let tracks = tracked(&set);
    for t in &tracks {
        println!("{}", describe(&set, t));
    }
    assert_eq!(kept(&set, &tracks), (4, 0));
    assert_eq!(
        tracks
            .iter()
            .find(|t| t.regular && t.frequency_hz > 500.0 && t.frequency_hz < 600.0)
            .unwrap()
            .evidence
            .expected,
        6
    );
}

#[test]
fn limit_order_of_records_does_not_matter() {
    let set = set(21, 6, false);
    let record = |at: usize| TrackRecord {
        nut_m: Some(POSITIONS_M[at]),
        series: "table",
        band_hz: (5.0, 1000.0),
        modes: &set.fits[at].modes,
    };
    let forward = track(&(0..6).map(record).collect::<Vec<_>>());
    let backward = track(&(0..6).rev().map(record).collect::<Vec<_>>());
    let seen = |tracks: &[TrackedMode]| -> Vec<(bool, u64)> {
        tracks.iter().map(|t| (t.regular, t.frequency_hz.to_bits())).collect()
    };
    assert_eq!(seen(&forward), seen(&backward));
}

#[test]
fn limit_single_and_unplaced_records() {
    let set = set(5, 0, false);
    let record = |at: usize, nut_m: Option<f64>| TrackRecord {
        nut_m,
        series: "table",
        band_hz: (5.0, 1000.0),
        modes: &set.fits[at].modes,
    };
    let single = track(&[record(0, None)]);
    assert_eq!(single.iter().filter(|t| t.regular).count(), 4);
    assert!(single[0].evidence.reasons[0].starts_with("one record"), "{:?}", single[0].evidence.reasons);
    let repeats = track(&[record(0, None), record(0, None), record(0, None)]);
    assert_eq!(repeats.iter().filter(|t| t.regular).count(), 4);
}

#[test]
fn speed_of_six_curves() {
    let start = Instant::now();
    let set = set(1, 6, false);
    let fits = start.elapsed();
    let start = Instant::now();
    let tracks = tracked(&set);
    assert!(!tracks.is_empty());
    println!(
        "six curves of 996 lines, 10 peaks each: {fits:?}; {} tracks in {:?}",
        tracks.len(),
        start.elapsed()
    );
}

/// The time of the search grows with the third power of the records; 400 of them would take half an hour.
#[test]
fn limit_modes_of_hundreds_of_positions_are_followed() {
    let positions_m: Vec<f64> = (0..400).map(|at| 0.2 + 0.004 * f64::from(at)).collect();
    let at = |u: f64| {
        vec![reported(100.0 + 6.0 * u, 0.02, 0.02, 1e-6), reported(300.0 - 9.0 * u * u, 0.05, 0.03, 2e-7)]
    };
    let mut modes: Vec<Vec<FittedMode>> = (0..400).map(|k| at(f64::from(k) / 399.0)).collect();
    // Hidden at some positions, and a peak of one record alone.
    modes[7].remove(0);
    modes[210].remove(1);
    modes[123].push(reported(700.0, 0.01, 0.01, 1e-7));
    let tracks = of_modes(&positions_m, &modes);
    let regular: Vec<_> = tracks.iter().filter(|track| track.regular).collect();
    assert_eq!(regular.iter().map(|track| track.sightings.len()).collect::<Vec<_>>(), [399, 399]);
    assert!(regular.iter().all(|track| track.sightings.is_sorted_by_key(|(record, _)| *record)));
    assert_eq!(
        tracks.iter().filter(|track| !track.regular).map(|track| track.sightings.len()).sum::<usize>(),
        1
    );
}
