//! Wrong orders, spurious and missed modes are found; sound tables are not accused.

use super::*;
use crate::Position;

/// Returns a set with the modes (order, frequency in Hz) of positions spread evenly over a stroke.
fn set(positions: &[&[(u32, f64)]]) -> MeasurementSet {
    let named = |at: usize| Position {
        name: format!("p{}", at + 1),
        nut_m: Some(0.2 + 0.8 * at as f64 / (positions.len() - 1).max(1) as f64),
    };
    let row = |(order, f): &(u32, f64)| ModeObservation {
        order: *order,
        frequency_hz: Some(*f),
        frequency_sd_hz: None,
        amplitude: None,
    };
    MeasurementSet {
        positions: (0..positions.len()).map(named).collect(),
        modes: Some(ModeTable {
            positions: positions.iter().map(|p| p.iter().map(row).collect()).collect(),
            ..ModeTable::default()
        }),
        ..MeasurementSet::none()
    }
}

/// Returns position (from 1), order and fitting order of the misplaced modes.
fn found(positions: &[&[(u32, f64)]]) -> Vec<(usize, u32, Option<u32>)> {
    misplaced_modes(&set(positions)).iter().map(|m| (m.position + 1, m.order, m.fits)).collect()
}

const P1: &[(u32, f64)] = &[(1, 99.0), (2, 400.0), (3, 1472.0)];
const P2: &[(u32, f64)] = &[(1, 93.0), (2, 401.0)];
const P4: &[(u32, f64)] = &[(1, 88.0), (2, 403.0)];
const P5: &[(u32, f64)] = &[(1, 87.0), (2, 404.0)];

#[test]
fn a_mode_under_another_order_is_found() {
    let wrong: &[(u32, f64)] = &[(1, 402.0)];
    assert_eq!(found(&[P1, P2, wrong, P4, P5]), [(3, 1, Some(2))]);
    assert_eq!(found(&[P1, wrong, P5]), [(2, 1, Some(2))]);
    let set = set(&[P1, P2, wrong, P4, P5]);
    let mended = with_fitting_orders(&set, &misplaced_modes(&set));
    assert_eq!(mended.modes.as_ref().unwrap().positions[2][0].order, 2);
    assert!(misplaced_modes(&mended).is_empty());
}

#[test]
fn a_missed_mode_that_shifts_all_above_is_found() {
    let wrong: &[(u32, f64)] = &[(1, 402.0), (2, 1480.0), (3, 2300.0)];
    let full = |f1: f64| vec![(1, f1), (2, 402.0), (3, 1475.0), (4, 2290.0)];
    let (a, b, c) = (full(95.0), full(90.0), full(87.0));
    assert_eq!(found(&[&a, wrong, &b, &c]), [(2, 1, Some(2)), (2, 2, Some(3)), (2, 3, Some(4))]);
    // Two positions cannot tell a missed from a spurious mode by their courses; a missed one is the more
    // probable.
    assert_eq!(found(&[&a, wrong]), [(2, 1, Some(2)), (2, 2, Some(3)), (2, 3, Some(4))]);
}

#[test]
fn a_spurious_mode_that_shifts_all_above_is_found() {
    let wrong: &[(u32, f64)] = &[(1, 92.0), (2, 250.0), (3, 402.0), (4, 1480.0)];
    let full = |f1: f64| vec![(1, f1), (2, 402.0), (3, 1475.0)];
    let (a, b, c) = (full(95.0), full(90.0), full(87.0));
    assert_eq!(found(&[&a, wrong, &b, &c]), [(2, 2, None), (2, 3, Some(2)), (2, 4, Some(3))]);
}

/// Two courses that come within 2 % of each other and part again, a mode at a node, a mode seen once, few
/// positions, strong changes along the stroke: all are sound.
#[test]
fn sound_tables_are_not_accused() {
    let bench: [&[(u32, f64)]; 6] = [
        &[(1, 24.0), (2, 118.0), (3, 523.0), (4, 716.0)],
        &[(1, 24.0), (2, 117.0), (3, 536.0), (4, 713.0)],
        &[(1, 24.0), (2, 116.0), (3, 565.0), (4, 721.0)],
        &[(1, 24.0), (2, 116.0), (4, 717.0)],
        &[(1, 23.0), (2, 113.0), (3, 561.0), (4, 728.0)],
        &[(1, 23.0), (2, 112.0), (3, 528.0), (4, 712.0)],
    ];
    assert_eq!(found(&bench), []);
    for count in 2..6 {
        assert_eq!(found(&bench[..count]), [], "{count}");
    }
    let veering: [&[(u32, f64)]; 5] = [
        &[(1, 60.0), (2, 400.0), (3, 500.0)],
        &[(1, 60.0), (2, 425.0), (3, 475.0)],
        &[(1, 60.0), (2, 446.0), (3, 454.0)],
        &[(1, 60.0), (2, 426.0), (3, 476.0)],
        &[(1, 60.0), (2, 401.0), (3, 499.0)],
    ];
    assert_eq!(found(&veering), []);
    let strong: [&[(u32, f64)]; 3] =
        [&[(1, 60.0), (2, 300.0)], &[(1, 55.0), (2, 390.0), (3, 700.0)], &[(1, 50.0), (2, 500.0)]];
    assert_eq!(found(&strong), []);
    assert_eq!(found(&[&[(1, 60.0)], &[(1, 80.0)]]), []);
    assert_eq!(found(&[P1]), []);
}
