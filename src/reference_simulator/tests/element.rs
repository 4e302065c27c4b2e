//! Tests of elements against closed forms.

use num_complex::Complex64;

use crate::element::beam::Beam;
use crate::element::dense::Dense;
use crate::element::law::{LaplacePoint, Law};
use crate::element::rod::{Rod, Stretch};
use crate::element::structure::{Port, Structure};

const LENGTH: f64 = 2.6;
const STIFFNESS: f64 = 2e11 * 1.2566e-3;
const MASS_PER_LENGTH: f64 = 7850.0 * 1.2566e-3;

fn uniform(doublings: u32) -> Rod {
    let element = LENGTH / f64::from(1u32 << doublings);
    Rod {
        stretches: vec![Stretch {
            stiffness: STIFFNESS / element,
            inertia: MASS_PER_LENGTH * element,
            doublings,
        }],
    }
}

/// Returns λ of the rod at s, complex so that the test needs no damping.
fn wave_number(s: Complex64) -> Complex64 {
    Complex64::new(0.0, -1.0) * s * (MASS_PER_LENGTH / STIFFNESS).sqrt()
}

#[test]
fn limit_free_rod_is_the_cotangent() {
    let rod = uniform(9);
    for hz in [20.0, 300.0, 700.0, 1300.0, 2000.0] {
        let s = Complex64::new(3.0, 2.0 * std::f64::consts::PI * hz);
        let ends = rod.ends(s * s, Complex64::ONE);
        let (lambda, phase) = (wave_number(s), wave_number(s) * LENGTH);
        let own = STIFFNESS * lambda / phase.tan();
        let cross = -STIFFNESS * lambda / phase.sin();
        assert!((ends.first / own - 1.0).norm() < 1e-3, "{hz} Hz: {} against {own}", ends.first);
        assert!((ends.cross / cross - 1.0).norm() < 1e-3, "{hz} Hz: {} against {cross}", ends.cross);
        assert_eq!(ends.first, ends.last);
    }
}

#[test]
fn limit_clamped_rod_resonates_at_odd_quarter_waves() {
    // Clamped–free: resonances at (2n − 1) c / 4L. There the receptance of the free end is largest.
    let rod = uniform(8);
    let speed = (STIFFNESS / MASS_PER_LENGTH).sqrt();
    for order in 1..=4 {
        let expected = f64::from(2 * order - 1) * speed / (4.0 * LENGTH);
        let stiffness = |hz: f64| {
            rod.ends(Complex64::new(-(2.0 * std::f64::consts::PI * hz).powi(2), 0.0), Complex64::ONE).last.re
        };
        let (mut low, mut high) = (0.98 * expected, 1.02 * expected);
        assert!(stiffness(low) * stiffness(high) < 0.0, "no root near {expected} Hz");
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if stiffness(low) * stiffness(middle) <= 0.0 { high = middle } else { low = middle }
        }
        assert!(
            (low / expected - 1.0).abs() < 3e-5 * f64::from(order * order),
            "order {order}: {low} against {expected} Hz"
        );
    }
}

#[test]
fn doubling_equals_element_by_element() {
    let s = Complex64::new(1.0, 4000.0);
    let modulus = LaplacePoint::new(s, 1.0).modulus(0.01);
    let [at_once, one_by_one] =
        [uniform(5), Rod { stretches: vec![Stretch { doublings: 0, ..uniform(5).stretches[0] }; 32] }]
            .map(|rod| rod.ends(s * s, modulus));
    assert!((at_once.first / one_by_one.first - 1.0).norm() < 1e-11);
    assert!((at_once.cross / one_by_one.cross - 1.0).norm() < 1e-11);
}

#[test]
fn limit_pinned_beam_has_its_first_frequency() {
    // π²/2π · sqrt(EI/ρA) / L²
    let (rigidity, mass_per_length) = (2.5e4, 9.9);
    let mut structure = Structure::default();
    structure.loss_dispersion = 1.0;
    let freedoms: [usize; 6] = std::array::from_fn(|_| structure.freedom());
    let half = Beam { rigidity, mass_per_length, element_m: LENGTH / 64.0, doublings: 5 };
    structure.beam([freedoms[0], freedoms[1], freedoms[2], freedoms[3]], half);
    structure.beam([freedoms[2], freedoms[3], freedoms[4], freedoms[5]], half);
    for end in [freedoms[0], freedoms[4]] {
        structure.branch(vec![(end, 1.0)], Law::spring(1e13, 0.0));
    }
    let expected = 0.5 * std::f64::consts::PI * f64::sqrt(rigidity / mass_per_length) / LENGTH.powi(2);
    let port = Port { response: vec![(freedoms[2], 1.0)], excitation: vec![(freedoms[2], 1.0)] };
    let sizes: Vec<f64> = (-20..=20)
        .map(|step| {
            let s =
                Complex64::new(0.01, 2.0 * std::f64::consts::PI * expected * (1.0 + 1e-4 * f64::from(step)));
            structure.receptances(std::slice::from_ref(&port), &[s]).unwrap()[0][0].norm()
        })
        .collect();
    let peak = (0..sizes.len()).max_by(|a, b| sizes[*a].total_cmp(&sizes[*b])).unwrap() as i32 - 20;
    assert!(peak.abs() <= 2, "first frequency is off by {peak} parts in ten thousand");
}

#[test]
fn loss_is_the_factor_at_every_frequency() {
    for hz in [10.0, 200.0, 1500.0] {
        let point = LaplacePoint::new(Complex64::new(0.0, 2.0 * std::f64::consts::PI * hz), 1.0);
        assert!((point.modulus(0.02).im - 0.02).abs() < 1e-12);
    }
    let at_reference = Law::spring(5.0, 0.1)
        .at(&LaplacePoint::new(Complex64::new(0.0, 2.0 * std::f64::consts::PI * 200.0), 1.0));
    assert!((at_reference - Complex64::new(5.0, 0.5)).norm() < 1e-12);
}

#[test]
fn solver_solves_and_rejects_singular_matrices() {
    let entries = [[0.0, 2.0, 1.0], [1.0, 0.0, 3.0], [4.0, 1.0, 0.0]];
    let mut matrix = Dense::zeros(3);
    for (row, values) in entries.iter().enumerate() {
        for (column, value) in values.iter().enumerate() {
            matrix.add(row, column, Complex64::new(*value, 0.1 * *value));
        }
    }
    let copy = matrix.clone();
    matrix.factor().unwrap();
    let right = [Complex64::new(1.0, 0.0), Complex64::new(0.0, 2.0), Complex64::new(-1.0, 1.0)];
    let mut solution = right;
    matrix.solve(&mut solution);
    for (row, right) in right.iter().enumerate() {
        let product: Complex64 = (0..3).map(|column| copy.entry(row, column) * solution[column]).sum();
        assert!((product - right).norm() < 1e-13);
    }
    assert!(Dense::zeros(2).factor().is_err());
}
