//! The lumped models of the papers: matrices, contacts in a machine, operating condition, strain energy,
//! convergence.

use config::{read_machine, read_machine_text};
use dynamics::model::{
    Complexes, Frequencies, Matrices, Reals, RodModel, Structure, elastic_frequencies_hz, matrices,
    undamped_modes,
};
use machine::contact::{Rule, published};
use machine::{Machine, Operating};
use nalgebra::{Cholesky, DMatrix, SymmetricEigen};
use proptest::prelude::*;
use std::sync::Arc;

const SHIPPED: [&str; 8] = [
    "configs/tian.toml",
    "configs/tian-as-published.toml",
    "configs/two-inertia.toml",
    "configs/twin-ball-screw.toml",
    "configs/servo-axis.toml",
    "configs/vertical-axis.toml",
    "configs/tian-as-computed.toml",
    "configs/twin-ball-screw-as-computed.toml",
];

fn shipped(path: &str) -> Machine {
    read_machine(path, &[], &[]).unwrap().machine
}

fn with(path: &str, overrides: &[&str]) -> Machine {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_string()).collect();
    read_machine(path, &overrides, &[]).unwrap().machine
}

fn middle(machine: &Machine) -> Operating {
    Operating::at(machine.stroke_m().map(|s| 0.5 * s))
}

/// Computes natural frequencies (Hz) by Cholesky factorisation and the symmetric eigenvalue problem,
/// independently of the program's method.
fn eigen_hz(m: &Matrices) -> Vec<f64> {
    let root = Cholesky::new(m.mass.clone()).expect("M is positive definite").l();
    let inverse = root.clone().try_inverse().unwrap();
    let a = &inverse * &m.stiffness * inverse.transpose();
    let mut hz: Vec<f64> = SymmetricEigen::new((&a + a.transpose()) * 0.5)
        .eigenvalues
        .iter()
        .map(|x| x.max(0.0).sqrt() / std::f64::consts::TAU)
        .collect();
    hz.sort_by(f64::total_cmp);
    hz
}

/// Asserts that M is symmetric positive definite, C and K symmetric positive semi-definite (scaled to a unit
/// diagonal).
fn check_matrices(m: &Matrices) {
    for (name, matrix) in [("M", &m.mass), ("C", &m.damping), ("K", &m.stiffness)] {
        assert!((matrix - matrix.transpose()).amax() <= 1e-12 * matrix.amax(), "{name} is not symmetric");
        let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            let size = (matrix[(i, i)] * matrix[(j, j)]).sqrt();
            if size > 0.0 { matrix[(i, j)] / size } else { matrix[(i, j)] }
        });
        let least = SymmetricEigen::new(scaled).eigenvalues.min();
        assert!(least > if name == "M" { 1e-9 } else { -1e-10 }, "{name}: least eigenvalue {least:e}");
    }
}

#[test]
fn limit_shipped_machines_have_valid_matrices_and_the_described_rigid_body_modes() {
    // Rigid-body modes of each description: rotor with table and screw; motor with load; screws with table.
    let free = [0, 1, 1, 0, 1, 0, 0, 1];
    for (path, free) in SHIPPED.iter().zip(free) {
        let machine = shipped(path);
        for lumps in [1, 4] {
            let full = matrices(&machine, &machine.start(), &middle(&machine), lumps).unwrap();
            assert_eq!(full.free_parts().len(), free, "{path}");
            let m = full.condensed().unwrap();
            check_matrices(&m);
            let hz = eigen_hz(&m);
            let elastic: Vec<f64> = hz.iter().copied().filter(|f| *f > 0.01).collect();
            assert_eq!(hz.len() - elastic.len(), free, "{path}: {hz:?}");
            // The program's mode count and frequencies of the same chain.
            let first = machine.points.iter().position(|p| !p.fixed).unwrap();
            let structure =
                Arc::new(Structure::new(&machine, first, first, RodModel::Lumped(lumps)).unwrap());
            let mut network = structure.empty_model();
            network.update(&machine, &machine.start(), &middle(&machine));
            let modes = undamped_modes(&network, 3000.0, &mut structure.workspace());
            assert_eq!(
                modes.iter().filter(|m| m.frequency_hz == 0.0).count(),
                free,
                "{path}: rigid-body modes at exactly 0 Hz"
            );
            let ours: Vec<f64> = modes.iter().map(|m| m.frequency_hz).filter(|f| *f > 0.0).collect();
            assert!(!ours.is_empty() || elastic.iter().all(|f| *f > 3000.0));
            for (a, b) in ours.iter().zip(&elastic) {
                assert!((a / b - 1.0).abs() < 1e-6, "{path}, {lumps} lumps: {ours:?} against {elastic:?}");
            }
        }
    }
}

/// Generates a random machine: translations in a chain with springs between neighbours, a screw–nut joint,
/// and a rotation, held or free.
fn random_machine() -> impl Strategy<Value = (Machine, bool)> {
    let spring = 5.0..9.0_f64;
    (2..7_usize, prop::collection::vec((-1.0..2.0_f64, spring), 7), any::<bool>(), 3.0..6.0_f64, -2.5..-1.5_f64).prop_map(
        |(count, numbers, held, screw, lead)| {
            let mut text = String::from("title = \"random\"\nstiffness_proportional_damping_s = 1e-4\n");
            for (i, (mass, _)) in numbers.iter().take(count).enumerate() {
                text += &format!("[[point]]\nname = \"x{i}\"\nmotion = \"translation\"\nmass_kg = {}\n", 10.0_f64.powf(*mass));
            }
            text += "[[point]]\nname = \"angle\"\nmotion = \"rotation\"\ninertia_kg_m2 = 1e-3\n";
            for (i, (_, k)) in numbers.iter().take(count - 1).enumerate() {
                let k = 10.0_f64.powf(*k);
                text += &format!("[[joint]]\nname = \"j{i}\"\nbetween = [\"x{i}\", \"x{}\"]\nstiffness = {k}\n", i + 1);
            }
            let (k, lead) = (10.0_f64.powf(screw), 10.0_f64.powf(lead));
            text += &format!(
                "[[joint]]\nname = \"screw\"\nbetween = [\"x0\", \"ground\"]\nscrew = {{ angle = \"angle\", lead_m = {lead} }}\nstiffness = {k}\n"
            );
            if held {
                text += "[[joint]]\nname = \"hold\"\nbetween = [\"angle\", \"ground\"]\nstiffness = 1e3\n";
            }
            (read_machine_text("random.toml", &text, &[], &[]).unwrap().machine, held)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn limit_random_machines_have_valid_matrices((machine, held) in random_machine()) {
        let m = matrices(&machine, &machine.start(), &Operating::default(), 1).unwrap();
        check_matrices(&m);
        // Translations and the screw's angle form one rigid-body mode unless the angle is held.
        prop_assert_eq!(m.free_parts().len(), usize::from(!held));
        let hz = eigen_hz(&m);
        let ours = elastic_frequencies_hz(&machine, 20, &machine.start(), &Operating::default());
        let elastic: Vec<f64> = hz.into_iter().skip(usize::from(!held)).collect();
        prop_assert_eq!(ours.len(), elastic.len());
        for (a, b) in ours.iter().zip(&elastic) {
            prop_assert!((a / b - 1.0).abs() < 1e-5, "{:?} against {:?}", ours, elastic);
        }
        if held {
            prop_assert!(m.static_stiffness("x0").unwrap() > 0.0);
        } else {
            prop_assert!(m.static_stiffness("x0").unwrap_err().to_string().contains("angle"));
        }
    }
}

/// Duan, Eq. 2 and 6, with the coupling term (lead/2π)·θ.
#[test]
fn published_six_coordinates_of_the_twin_ball_screw() {
    let machine = with("configs/twin-ball-screw.toml", &["parameter.k_mount.start=7e7"]);
    let here = Operating { velocity_m_s: Some(0.1), ..Operating::at_nut(0.2) };
    let m = matrices(&machine, &machine.start(), &here, 1).unwrap();
    let p = 5e-3 / std::f64::consts::TAU;
    let ka: Vec<f64> = (1..=2)
        .map(|axis| {
            let contact = |name: String| {
                machine.contacts.iter().find(|c| c.name == name).unwrap().at(&here).unwrap().stiffness_n_per_m
            };
            let segment = std::f64::consts::PI * 20e-3 * 20e-3 * 2.06e11 / (4.0 * 0.2);
            1.0 / (1.0 / contact(format!("bearing-{axis}"))
                + 1.0 / segment
                + 1.0 / contact(format!("screw-nut-{axis}")))
        })
        .collect();
    assert!(ka[0] > ka[1], "axis 2 has more friction, so its contacts are softer");
    let kn = 7e7;
    #[rustfmt::skip]
    let k = DMatrix::from_row_slice(6, 6, &[
        kn + ka[0], 0.0, -kn, -p * ka[0], 0.0, 0.0,
        0.0, kn + ka[1], -kn, 0.0, -p * ka[1], 0.0,
        -kn, -kn, 2.0 * kn, 0.0, 0.0, 0.0,
        -p * ka[0], 0.0, 0.0, p * p * ka[0] + 1e3, 0.0, 0.0,
        0.0, -p * ka[1], 0.0, 0.0, p * p * ka[1] + 1e3, 0.0,
        0.0, 0.0, 0.0, 0.0, 0.0, 5e6,
    ]);
    let mass = DMatrix::from_diagonal(&nalgebra::DVector::from_vec(vec![
        0.575, 0.575, 24.43, 2.545e-4, 2.545e-4, 0.505,
    ]));
    assert_eq!(m.mass, mass);
    for (ours, theirs) in [(&m.stiffness, k.clone()), (&m.damping, k * 1.9e-4)] {
        for i in 0..6 {
            for j in 0..6 {
                let scale = (theirs[(i, i)] * theirs[(j, j)]).sqrt();
                assert!(
                    (ours[(i, j)] - theirs[(i, j)]).abs() < 1e-12 * scale,
                    "({i}, {j}): {} against {}",
                    ours[(i, j)],
                    theirs[(i, j)]
                );
            }
        }
    }
}

/// Duan, Eq. 6 without servos: the screws turn against each other on bearing and screw, f = √(K_L/[(J_m +
/// J_b)·(2π/p)²])/2π. The closed form holds where nut brackets and yawing are rigid.
#[test]
fn limit_screws_of_a_twin_ball_screw_turn_against_each_other() {
    let machine = with("configs/twin-ball-screw-as-computed.toml", &["joint.yaw.stiffness=1e12"]);
    let reflected_kg = 2.545e-4 * (std::f64::consts::TAU / 5e-3).powi(2);
    for (nut_m, printed_hz) in [(1e-6, 51.4), (0.155, 48.9)] {
        let screw = std::f64::consts::PI * 20e-3 * 20e-3 * 2.06e11 / (4.0 * nut_m);
        let k = 1.0 / (1.0 / 4.2e7 + 1.0 / screw);
        let closed_form = (k / reflected_kg).sqrt() / std::f64::consts::TAU;
        let ours = elastic_frequencies_hz(&machine, 1, &machine.start(), &Operating::at_nut(nut_m))[0];
        assert!((ours / closed_form - 1.0).abs() < 3e-4, "{nut_m}: {ours} against {closed_form}");
        assert!((ours / printed_hz - 1.0).abs() < 0.004, "{nut_m}: {ours} against {printed_hz}");
    }
}

/// Both ends of the vertical screw: equilibrium, equal displacements at the nut, the nearer end carries more;
/// halves as printed.
#[test]
fn limit_screw_ends_share_a_load_by_compatibility() {
    let machine = shipped("configs/vertical-axis.toml");
    let find =
        |machine: &Machine, name: &str| machine.contacts.iter().find(|c| c.name == name).unwrap().clone();
    let (upper, lower) = (find(&machine, "bearing-upper"), find(&machine, "bearing-lower"));
    for (a, nut_m) in [(0.0, 0.2), (0.0, 0.05), (10.0, 0.05), (-30.0, 0.7)] {
        let here = Operating { acceleration_m_s2: Some(a), ..Operating::at_nut(nut_m) };
        let state = |contact: &machine::LoadedPair| contact.at(&here).unwrap();
        let (u, l) = (state(&upper), state(&lower));
        let whole_n = 150.0 * (9.80665 + a);
        assert!(((u.force_n + l.force_n) / whole_n - 1.0).abs() < 1e-9);
        let segment =
            |name: &str| machine.segments.iter().find(|s| s.name == name).unwrap().stiffness_n_per_m(&here);
        let displacement = [
            u.force_n / segment("upper") + u.share.displacement_m,
            l.force_n / segment("lower") + l.share.displacement_m,
        ];
        assert!((displacement[0] / displacement[1] - 1.0).abs() < 1e-6, "{displacement:?}");
        let share = l.force_n / whole_n;
        match nut_m {
            // An estimate with constant bearing stiffness gives 0.69.
            0.2 => assert!((share - 0.696).abs() < 0.005, "{share}"),
            0.05 if a == 0.0 => assert!((share - 0.80).abs() < 0.005, "{share}"),
            0.7 => assert!(share < 0.5, "{share}"),
            _ => {}
        }
    }
    let near = Operating { acceleration_m_s2: Some(10.0), ..Operating::at_nut(0.05) };
    let hz = elastic_frequencies_hz(&machine, 1, &machine.start(), &near)[0];
    assert!((hz - 213.9).abs() < 0.1, "{hz}");
    let printed = with("configs/vertical-axis.toml", &["contact_rule=as-printed"]);
    let (u, l) =
        (find(&printed, "bearing-upper").force_n(&near), find(&printed, "bearing-lower").force_n(&near));
    assert!(u == l && (u - 0.5 * 150.0 * 19.80665).abs() < 1e-9);
}

/// Velocities at which nut B unloads, by Eq. 12–17 with Tab. 2 as printed and by equilibrium, evaluated in
/// the machine.
#[test]
fn published_velocities_at_which_nut_b_unloads_in_the_machine() {
    let m_min = |machine: &Machine, name: &str, x: f64| {
        let contact = machine.contacts.iter().find(|c| c.name == name).unwrap();
        contact
            .at(&Operating { velocity_m_s: Some(x / 60.0), ..Operating::default() })
            .unwrap()
            .share
            .load_b_n
    };
    for (rule, axis, unloads) in
        [("as-printed", 1, 30.22), ("as-printed", 2, 18.91), ("physics", 1, 49.39), ("physics", 2, 32.03)]
    {
        let machine = with("configs/twin-ball-screw.toml", &[&format!("contact_rule={rule}")]);
        let name = format!("screw-nut-{axis}");
        assert!(m_min(&machine, &name, unloads - 0.02) > 0.0, "{rule} {axis}");
        assert_eq!(m_min(&machine, &name, unloads + 0.02), 0.0, "{rule} {axis}");
    }
}

/// Behaviour at, just below and just above the load at which a side separates, and at load reversal.
#[test]
fn limit_separation_kink_and_reversal_in_a_machine() {
    let machine = shipped("configs/vertical-axis.toml");
    let nut = machine.contacts.iter().find(|c| c.name == "nut").unwrap();
    let at = |a: f64| Operating { acceleration_m_s2: Some(a), ..Operating::at_nut(0.45) };
    let (mass, g) = (150.0, 9.80665);
    let (low, high) = nut.pair.unloading_forces_n(Rule::Physics);
    let hz = |a: f64| elastic_frequencies_hz(&machine, 1, &machine.start(), &at(a))[0];
    for (force, side_b) in [(high, true), (low, false)] {
        let kink = force / mass - g;
        let load = |a: f64| {
            let share = nut.at(&at(a)).unwrap().share;
            if side_b { share.load_b_n } else { share.load_a_n }
        };
        let (inward, outward) = if side_b { (-1.0, 1.0) } else { (1.0, -1.0) };
        assert!(load(kink + inward * 1e-6) > 0.0 && load(kink + outward * 1e-6) == 0.0);
        // The frequency is continuous at the kink, falls towards it and rises beyond it.
        let (before, here, after) = (hz(kink + inward * 1e-9), hz(kink), hz(kink + outward * 1e-9));
        assert!((before / here - 1.0).abs() < 1e-4 && (after / here - 1.0).abs() < 1e-6);
        let (before, after) = (hz(kink + inward * 0.1), hz(kink + outward * 0.1));
        assert!(before > here && after > here, "{before} {here} {after}");
        // The stiffness of the separating side goes with the cube root of its load: a square root in the
        // distance, steeper than beyond the kink.
        assert!(before - here > 10.0 * (after - here));
        let nearer = hz(kink + inward * 0.001);
        let order = ((before - here) / (nearer - here)).log10() / 2.0;
        assert!((0.4..0.6).contains(&order), "expected a square-root kink, found exponent {order}");
    }
    // In free fall only the preload acts. The load reverses there, so the frequency is symmetric about it.
    let (fall, mirror) = (hz(-g), |x: f64| (hz(-g + x), hz(-g - x)));
    for x in [1e-3, 1.0, 5.0, 18.0, 30.0] {
        let (up, down) = mirror(x);
        assert!((up / down - 1.0).abs() < 1e-9 && up <= fall * (1.0 + 1e-12), "{x}");
    }
}

/// Friction reverses with the velocity: the nut's stiffness is even in velocity, its load odd with a jump of
/// 2·F_s.
#[test]
fn limit_reversal_of_the_velocity() {
    let machine = shipped("configs/twin-ball-screw.toml");
    let nut = machine.contacts.iter().find(|c| c.name == "screw-nut-1").unwrap();
    let at = |v: f64| nut.at(&Operating { velocity_m_s: Some(v), ..Operating::default() }).unwrap();
    let (up, down) = (at(1e-12), at(-1e-12));
    let jump = 2.0 * published::friction_axis_1().static_n;
    assert!((up.force_n - down.force_n - jump).abs() < 1e-6);
    for v in [1e-6, 1e-3, 0.3, 1.2] {
        let (up, down) = (at(v), at(-v));
        assert!((up.stiffness_n_per_m / down.stiffness_n_per_m - 1.0).abs() < 1e-12);
        assert!((up.share.load_a_n - down.share.load_b_n).abs() < 1e-9 * up.share.load_a_n);
    }
    assert_eq!(at(0.0).force_n, 0.0);
}

/// The derivatives used by a fit are exact with contacts, segments, series and factors.
#[test]
fn limit_derivatives_through_a_series_of_contacts() {
    let text = std::fs::read_to_string("configs/twin-ball-screw.toml").unwrap();
    let text =
        text.replace("{ contact = \"bearing-1\" }", "{ contact = \"bearing-1\", times = \"soft\" }").replace(
            "[parameter.k_mount]",
            "[parameter.soft]\nunit = \"1\"\nstart = 0.7\nlower = 0.1\nupper = 3.0\n\n[parameter.k_mount]",
        );
    let machine = read_machine_text("twin.toml", &text, &[], &[]).unwrap().machine;
    let table = machine.point("table").unwrap();
    let structure = Arc::new(Structure::new(&machine, table, table, RodModel::Exact).unwrap());
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    let here = Operating { velocity_m_s: Some(0.2), ..Operating::at_nut(0.3) };
    let column: Vec<Option<usize>> = (0..machine.parameters.len()).map(Some).collect();
    let omega = std::f64::consts::TAU * 180.0;
    let mut found = vec![Complexes::ZERO; column.len()];
    network.update(&machine, &machine.start(), &here);
    let sensitivity = network.sensitivity(&machine, &machine.start(), &here, &column, None);
    network.gradient(Frequencies::any(&[Reals::splat(omega)]), &sensitivity, &mut work, &mut found);
    let exact: Vec<_> = found.iter().map(|d| d.lanes()[0]).collect();
    for index in 0..column.len() {
        let mut at = |factor: f64| {
            let mut values = machine.start();
            values[index] *= factor;
            network.update(&machine, &values, &here);
            network.receptance(omega, &mut work)
        };
        let slope = (at(1.0 + 1e-6) - at(1.0 - 1e-6)) / (2e-6 * machine.start()[index]);
        let id = &machine.parameters[index].id;
        assert!(
            (exact[index] - slope).norm() < 1e-6 * slope.norm() && slope.norm() > 0.0,
            "{id}: {} against {slope}",
            exact[index]
        );
    }
}

/// Half the strain-energy share is the sensitivity of the frequency. Shares sum to one, those of the parts of
/// a series to their joint's.
#[test]
fn limit_strain_energy_is_the_sensitivity() {
    for path in SHIPPED {
        let machine = shipped(path);
        let here = middle(&machine);
        let first = machine.points.iter().position(|p| !p.fixed).unwrap();
        let structure = Arc::new(Structure::new(&machine, first, first, RodModel::Exact).unwrap());
        let mut network = structure.empty_model();
        network.update(&machine, &machine.start(), &here);
        let modes = undamped_modes(&network, 900.0, &mut structure.workspace());
        for mode in modes.iter().filter(|m| m.frequency_hz > 0.0) {
            let omega = std::f64::consts::TAU * mode.frequency_hz;
            let rows = network.strain_energy(&machine, &machine.start(), &here, omega, &mode.shape);
            let total: f64 = rows.iter().filter(|r| !r.name.contains('/')).map(|r| r.share).sum();
            assert!((total - 1.0).abs() < 1e-9 && rows.iter().all(|r| r.share >= -1e-9), "{path}: {rows:?}");
            for joint in &machine.joints {
                let own = rows.iter().find(|r| r.name == joint.name).unwrap().share;
                let parts: Vec<f64> = rows
                    .iter()
                    .filter(|r| r.name.starts_with(&format!("{}/", joint.name)))
                    .map(|r| r.share)
                    .collect();
                assert!(parts.is_empty() || (parts.iter().sum::<f64>() - own).abs() < 1e-9);
            }
        }
    }
    // Against finite differences of the frequency.
    let machine = shipped("configs/servo-axis.toml");
    let here = Operating::default();
    let moved = |id: &str, factor: f64| {
        let mut values = machine.start();
        values[machine.parameter(id).unwrap()] *= factor;
        elastic_frequencies_hz(&machine, 1, &values, &here)[0]
    };
    let structure = Arc::new(Structure::new(&machine, 0, 0, RodModel::Exact).unwrap());
    let mut network = structure.empty_model();
    network.update(&machine, &machine.start(), &here);
    let modes = undamped_modes(&network, 300.0, &mut structure.workspace());
    let mode = modes.iter().find(|m| m.frequency_hz > 0.0).unwrap();
    assert!(
        (mode.frequency_hz / 152.0 - 1.0).abs() < 1e-4
            && (mode.damping_ratio.unwrap() / 0.03 - 1.0).abs() < 1e-3
    );
    let rows = network.strain_energy(
        &machine,
        &machine.start(),
        &here,
        std::f64::consts::TAU * mode.frequency_hz,
        &mode.shape,
    );
    for (joint, id) in [
        ("coupling", "k_12t"),
        ("screw-torsion", "k_23t"),
        ("support", "k_support"),
        ("nut", "k_12a"),
        ("flange", "k_23a"),
    ] {
        let slope = (moved(id, 1.001).ln() - moved(id, 0.999).ln()) / (1.001_f64.ln() - 0.999_f64.ln());
        // The support is in series with the screw: its spring takes the part of the energy that its
        // compliance has.
        let part = if joint == "support" { series_share(&machine, joint, id) } else { 1.0 };
        let share = rows.iter().find(|r| r.name == joint).unwrap().share * part;
        assert!((slope - 0.5 * share).abs() < 1e-6, "{joint}: {slope} against {}", 0.5 * share);
    }
}

/// Returns the compliance of a spring over that of the joint in whose series it is.
fn series_share(machine: &Machine, joint: &str, id: &str) -> f64 {
    let values = machine.start();
    let whole =
        machine.joints.iter().find(|j| j.name == joint).unwrap().stiffness.at(&values, &Operating::default());
    whole / values[machine.parameter(id).unwrap()]
}

/// Each frequency of the lumped bench converges to the exact one at second order.
#[test]
fn limit_lumped_bench_converges_at_second_order() {
    let machine = shipped("configs/tian.toml");
    let table = machine.point("table").unwrap();
    for nut in [0.6, 1.3, 1.9] {
        let hz = |rods: RodModel| -> Vec<f64> {
            let structure = Arc::new(Structure::new(&machine, table, table, rods).unwrap());
            let mut network = structure.empty_model();
            network.update(&machine, &machine.start(), &Operating::at_nut(nut));
            undamped_modes(&network, 1000.0, &mut structure.workspace())
                .iter()
                .map(|m| m.frequency_hz)
                .take(4)
                .collect()
        };
        let exact = hz(RodModel::Exact);
        let error = |n: usize, mode: usize| (hz(RodModel::Lumped(n))[mode] / exact[mode] - 1.0).abs();
        for mode in 0..4 {
            let order = (error(10, mode) / error(20, mode)).log2();
            assert!((1.9..2.1).contains(&order), "nut {nut}, mode {}: order {order}", mode + 1);
        }
    }
}

/// The condensed chain has the frequencies of the chain with all its masses.
#[test]
fn limit_condensed_chain_has_the_frequencies_of_the_full_one() {
    let machine = shipped("configs/tian.toml");
    let here = Operating::at_nut(0.7);
    for lumps in [2, 7, 40] {
        let hz = eigen_hz(&matrices(&machine, &machine.start(), &here, lumps).unwrap().condensed().unwrap());
        let structure = Arc::new(Structure::new(&machine, 0, 0, RodModel::Lumped(lumps)).unwrap());
        let mut network = structure.empty_model();
        network.update(&machine, &machine.start(), &here);
        let ours: Vec<f64> = undamped_modes(&network, 2500.0, &mut structure.workspace())
            .iter()
            .map(|m| m.frequency_hz)
            .collect();
        assert_eq!(ours.len(), hz.iter().filter(|f| **f < 2500.0).count(), "{lumps}: {ours:?} {hz:?}");
        for (a, b) in ours.iter().zip(&hz) {
            assert!((a / b - 1.0).abs() < 1e-6, "{lumps} lumps: {a} against {b}");
        }
    }
}
