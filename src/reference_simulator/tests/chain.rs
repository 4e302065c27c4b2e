//! Tests of the published bench without effects and nuisance parameters against its closed form.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::subject;
use crate::machine::assembly::Assembly;
use crate::machine::number::Machine;
use crate::machine::point::{Channel, Point};

/// Assembles the dynamic stiffness of the chain from the wave solutions of its four rods. The degrees of
/// freedom are table, rotor, and screw (axial, angle) at left bearing, nut and right bearing. Source: Tian et
/// al., Eq. 1–24, with cot for the printed cos, v = (1, −1, −i).
fn closed_form(machine: &Machine, nut_m: f64, hz: f64) -> DMatrix<Complex64> {
    let omega = 2.0 * std::f64::consts::PI * hz;
    let i = Complex64::I;
    let mut z = DMatrix::<Complex64>::zeros(8, 8);
    let mut branch = |form: &[(usize, f64)], value: Complex64| {
        for &(row, a) in form {
            for &(column, b) in form {
                z[(row, column)] += value * (a * b);
            }
        }
    };
    let mass = |value: f64| Complex64::new(-omega * omega * value, 0.0);
    let joint = |stiffness: f64, damping: f64| stiffness + i * omega * damping;
    branch(&[(0, 1.0)], mass(machine.table_mass_kg));
    branch(&[(1, 1.0)], mass(machine.rotor_inertia_kg_m2));
    branch(&[(3, 1.0)], mass(machine.hub_inertia_kg_m2));
    branch(&[(4, 1.0)], mass(machine.nut.screw_mass_kg));
    branch(&[(5, 1.0)], mass(machine.nut.screw_inertia_kg_m2));
    branch(&[(2, 1.0)], joint(machine.bearing_left.stiffness, machine.bearing_left.damping));
    branch(&[(6, 1.0)], joint(machine.bearing_right.stiffness, machine.bearing_right.damping));
    branch(&[(1, 1.0), (3, -1.0)], joint(machine.coupling.stiffness, machine.coupling.damping));
    branch(
        &[(0, 1.0), (4, -1.0), (5, -machine.ratio_m())],
        joint(machine.nut.joint.stiffness, machine.nut.joint.damping),
    );
    if let Some(hold) = machine.hold {
        branch(&[(1, 1.0)], joint(hold.stiffness, hold.damping));
    }
    let screw = &machine.screw;
    let area = std::f64::consts::PI / 4.0 * screw.diameter_m.powi(2);
    let polar = std::f64::consts::PI / 32.0 * screw.diameter_m.powi(4);
    let axial =
        (screw.youngs_modulus_pa * area, omega * (screw.density_kg_m3 / screw.youngs_modulus_pa).sqrt());
    let torsion =
        (screw.shear_modulus_pa * polar, omega * (screw.density_kg_m3 / screw.shear_modulus_pa).sqrt());
    for (start, end, length) in [(2, 4, nut_m), (4, 6, screw.length_m - nut_m)] {
        for (shift, (stiffness, lambda)) in [(0, axial), (1, torsion)] {
            let own = Complex64::new(stiffness * lambda / (lambda * length).tan(), 0.0);
            let cross = Complex64::new(-stiffness * lambda / (lambda * length).sin(), 0.0);
            let (a, b) = (start + shift, end + shift);
            z[(a, a)] += own;
            z[(b, b)] += own;
            z[(a, b)] += cross;
            z[(b, a)] += cross;
        }
    }
    z
}

fn solved(z: &DMatrix<Complex64>, excitation: usize) -> DVector<Complex64> {
    let mut right = DVector::<Complex64>::zeros(8);
    right[excitation] = Complex64::ONE;
    z.clone().lu().solve(&right).unwrap()
}

/// Returns the largest deviation up to 1 kHz, relative to the closed form; near antiresonances relative to
/// `below_peak` times the largest value.
fn deviation(
    machine: &Machine,
    nut_m: f64,
    channel: Channel,
    indices: (usize, usize),
    below_peak: f64,
) -> f64 {
    let lines: Vec<f64> = (1..=333).map(|k| 3.0 * f64::from(k)).collect();
    let points: Vec<Complex64> =
        lines.iter().map(|hz| Complex64::new(0.0, 2.0 * std::f64::consts::PI * hz)).collect();
    let assembly = Assembly::new(machine, &[], nut_m, 1.0);
    let found = assembly.structure.receptances(&[assembly.port(channel)], &points).unwrap().remove(0);
    let expected: Vec<Complex64> =
        lines.iter().map(|&hz| solved(&closed_form(machine, nut_m, hz), indices.1)[indices.0]).collect();
    let smallest = below_peak * expected.iter().map(|value| value.norm()).fold(0.0, f64::max);
    found.iter().zip(&expected).map(|(a, b)| (a - b).norm() / b.norm().max(smallest)).fold(0.0, f64::max)
}

/// Returns the machine of a subject without nuisance parameters, with the true joint values, and its nut
/// positions.
fn bare(seed: u64, elements: usize) -> (Machine, Vec<f64>) {
    let subject = subject(seed);
    let mut machine = crate::machine::nuisance::Nuisance::none(6).applied(subject.drawn.with_true_joints());
    machine.screw.elements = elements;
    (machine, subject.drawn.nut_m)
}

#[test]
fn limit_fine_mesh_is_the_closed_form() {
    let channels = [
        (Channel::direct(Point::Table), (0, 0)),
        (Channel::direct(Point::Rotor), (1, 1)),
        (Channel::new(Point::Rotor, Point::Table), (1, 0)),
        (Channel::new(Point::Right, Point::Table), (6, 0)),
    ];
    for seed in 0..4 {
        let (machine, nut_m) = bare(seed, 2000);
        for (position, nut_m) in nut_m.into_iter().enumerate() {
            for (channel, indices) in channels {
                let worst = deviation(&machine, nut_m, channel, indices, 0.0);
                assert!(worst < 1e-3, "machine {seed}, l{}, {channel:?}: {worst}", position + 1);
            }
        }
    }
}

#[test]
fn usual_mesh_is_within_a_thousandth_at_the_table() {
    for seed in 0..6 {
        let (machine, nut_m) = bare(seed, 200);
        let worst = deviation(&machine, nut_m[1], Channel::direct(Point::Table), (0, 0), 0.0);
        assert!(worst < 1e-3, "machine {seed}: {worst}");
        let assembly = Assembly::new(&machine, &[], nut_m[1], 1.0);
        assert!(assembly.structure.rod_elements() >= 2 * 80);
    }
}

#[test]
fn tapered_journals_and_a_long_nut_stay_on_the_screw() {
    let subject = subject(1);
    let machine = subject.nuisance.applied(subject.drawn.with_true_joints());
    for (offset, _) in machine.nut.shares() {
        for nut_m in &subject.drawn.nut_m {
            assert!((0.0..machine.screw.length_m).contains(&(nut_m + offset)));
        }
    }
    let shares: f64 = machine.nut.shares().iter().map(|(_, share)| share).sum();
    assert!((shares - 1.0).abs() < 1e-12);
    assert!(machine.screw.diameter_at(0.0) < 0.96 * machine.screw.diameter_m);
    assert_eq!(machine.screw.diameter_at(0.5 * machine.screw.length_m), machine.screw.diameter_m);
}
