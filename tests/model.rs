//! The receptance model against closed forms, the paper's equations, receptance coupling and finite elements.

use config::effect_library;
use dynamics::model::{
    Complexes, Frequencies, FrequencyGrid, LANES, Reals, RodModel, Structure, matrices, undamped_modes,
};
use machine::{Machine, Operating};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;
use std::sync::Arc;

use crate::support::bench_equations::{TAB_3, h_all};
use crate::support::coupling::coupled_receptances;
use crate::support::finite_elements::Bench;
use crate::support::{POSITIONS, config, table_structure};

fn omega(f: f64) -> f64 {
    std::f64::consts::TAU * f
}

/// Modes with the published values at l1, against the roots of the corrected equations to ten figures.
#[test]
fn published_undamped_modes_at_l1() {
    let config = config("configs/tian-as-published.toml");
    let structure = table_structure(&config.machine, RodModel::Exact);
    let mut network = structure.empty_model();
    network.update(&config.machine, &config.machine.start(), &Operating::at_nut(0.6));
    let modes = undamped_modes(&network, 1000.0, &mut structure.workspace());
    let expected = [0.0, 109.2223235, 354.4007986, 531.5772765, 739.2526774];
    assert_eq!(modes.len(), expected.len());
    for (mode, expected) in modes.iter().zip(expected) {
        assert!(
            (mode.frequency_hz - expected).abs() <= 1e-6 * expected,
            "{} against {expected}",
            mode.frequency_hz
        );
    }
}

/// After a first evaluation, updates, receptances, mode counts and derivatives allocate nothing.
#[test]
fn limit_an_evaluation_allocates_nothing() {
    let config = config("configs/tian.toml");
    let machine = &config.machine;
    let (values, here) = (machine.start(), Operating::at_nut(0.6));
    let structure = table_structure(machine, RodModel::Exact);
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    let columns: Vec<Option<usize>> = (0..values.len()).map(Some).collect();
    network.update(machine, &values, &here);
    let sensitivity = network.sensitivity(machine, &values, &here, &columns, None);
    let omegas =
        [[20.0, 90.0, 400.0, 700.0], [30.0, 95.0, 410.0, 710.0]].map(|some| Reals::from(some.map(omega)));
    let mut slopes = vec![Complexes::ZERO; values.len() * omegas.len()];
    let mut all = || {
        network.update(machine, &values, &here);
        let receptance = network.receptances(&omegas, &mut work)[1];
        let below = network.modes_below(omega(400.0), &mut work);
        let same = network.gradient(Frequencies::any(&omegas), &sensitivity, &mut work, &mut slopes)[1];
        assert!(
            below > 0 && (receptance - same).norm_sqr().to_array()[0] < 1e-20 * same.norm_sqr().to_array()[0]
        );
    };
    // The first evaluation allocates the rods' entries.
    all();
    let counted = allocation_counter::measure(all);
    assert_eq!(counted.count_total, 0, "{counted:?}");
}

/// Rod entries stored on a frequency grid change no receptance, and are not used after a rod has changed.
#[test]
fn limit_a_frequency_grid_with_stored_rods_gives_the_same_receptances() {
    let config = config("configs/tian.toml");
    let (machine, values) = (&config.machine, config.machine.start());
    for names in [("table", "table"), ("rotor", "table")] {
        let [response, excitation] = [names.0, names.1].map(|name| machine.point(name).unwrap());
        let structure = Arc::new(Structure::new(machine, response, excitation, RodModel::Exact).unwrap());
        let (mut network, mut work) = (structure.empty_model(), structure.workspace());
        let omegas: Vec<f64> = (1..=70).map(|i| omega(12.7 * f64::from(i))).collect();
        network.update(machine, &values, &Operating::at_nut(0.6));
        let mut lines = FrequencyGrid::new(&omegas);
        lines.keep_rods(&network, |rod| rod != 1);
        for nut_m in [0.6, 1.3] {
            network.update(machine, &values, &Operating::at_nut(nut_m));
            let direct = network.sweep(&omegas, &mut work);
            for groups in [0..5, 10..lines.omega_rad_s().len()] {
                let stored = network.receptances_on(&lines, groups.clone(), &mut work);
                let each = stored.iter().flat_map(|h| h.lanes()).zip(&direct[groups.start * LANES..]);
                each.for_each(|(a, b)| assert!((a - b).norm() < 1e-12 * b.norm(), "{a} against {b}"));
            }
        }
    }
}

/// Receptances and derivatives on a grid, which keeps the rods with losses that were computed last, are those
/// at frequencies of no grid, whatever was evaluated there before.
#[test]
fn limit_recent_rods_of_a_frequency_grid_are_those_of_the_model() {
    let mut config = config("configs/tian.toml");
    config.machine.shafts[0].loss_factor = machine::Value::number(0.02);
    let (machine, values) = (&config.machine, config.machine.start());
    let structure = table_structure(machine, RodModel::Exact);
    let (mut network, mut work) = (structure.empty_model(), structure.workspace());
    let lines = FrequencyGrid::new(&(1..=60).map(|i| omega(13.1 * f64::from(i))).collect::<Vec<f64>>());
    let columns: Vec<Option<usize>> = (0..values.len()).map(Some).collect();
    for nut_m in [0.6, 0.6, 1.3, 0.6] {
        let here = Operating::at_nut(nut_m);
        network.update(machine, &values, &here);
        let sensitivity = network.sensitivity(machine, &values, &here, &columns, Some(values.len()));
        for groups in [0..5, 3..8, 8..15] {
            let omegas = &lines.omega_rad_s()[groups.clone()];
            let mut both = [Frequencies::of(&lines, groups.clone()), Frequencies::any(omegas)].map(|at| {
                let mut slopes = vec![Complexes::ZERO; (values.len() + 1) * omegas.len()];
                let mut all = network.gradient(at, &sensitivity, &mut work, &mut slopes).to_vec();
                all.extend(slopes);
                all
            });
            both[0].extend(network.receptances_on(&lines, groups, &mut work));
            both[1].extend(network.receptances(omegas, &mut work));
            let lanes = both.map(|all| all.iter().flat_map(|group| group.lanes()).collect::<Vec<_>>());
            assert_eq!(lanes[0], lanes[1], "nut at {nut_m} m");
        }
    }
}

/// The transform of x(t)·e^(−σt) is that of x(t) at s = iω + σ: H = f_rᵀ·(K + s·C + s²·M)⁻¹·f_e with the
/// matrices of the chain; the exact rods' limit.
#[test]
fn limit_an_exponential_window_shifts_the_receptance_to_a_complex_frequency() {
    let config = config("configs/tian.toml");
    let (machine, values) = (&config.machine, config.machine.start());
    let here = Operating { window_per_s: 6.0, ..Operating::at_nut(0.6) };
    let of = matrices(machine, &values, &here, 64).unwrap();
    let at = |name: &str| of.names.iter().position(|own| own == name).unwrap();
    for (response, excitation) in [("table", "table"), ("rotor", "table")] {
        let points = [response, excitation].map(|name| machine.point(name).unwrap());
        for (rods, within) in [(RodModel::Lumped(64), 1e-9), (RodModel::Exact, 2e-3)] {
            let structure = Arc::new(Structure::new(machine, points[0], points[1], rods).unwrap());
            let mut network = structure.empty_model();
            network.update(machine, &values, &here);
            for hz in [2.0, 35.0, 109.0, 354.0, 700.0] {
                let s = Complex64::new(6.0, omega(hz));
                let complex = |m: &DMatrix<f64>, factor: Complex64| m.map(|x| factor * x);
                let stiffness =
                    complex(&of.stiffness, 1.0.into()) + complex(&of.damping, s) + complex(&of.mass, s * s);
                let mut force = DVector::<Complex64>::zeros(of.names.len());
                force[at(excitation)] = 1.0.into();
                let expected = stiffness.lu().solve(&force).unwrap()[at(response)];
                let found = network.receptance(omega(hz), &mut structure.workspace());
                assert!(
                    (found - expected).norm() < within * expected.norm(),
                    "{response} at {hz} Hz, {rods:?}: {found} for {expected}"
                );
            }
        }
    }
}

/// With a window, too, derivatives are those of the receptance: with losses of shaft and joints, a damper
/// that relaxes, integral action, a bending shaft.
#[test]
fn gradients_with_an_exponential_window_match_finite_differences() {
    let here = Operating { window_per_s: 6.0, ..Operating::at_nut(0.6) };
    let library = effect_library().unwrap();
    let with = |machine: Machine, id: &str| {
        machine.with_effect(library.iter().find(|effect| effect.id == id).unwrap()).unwrap()
    };
    let machine = with(with(config("configs/tian.toml").machine, "table-relaxation"), "screw-bending");
    let machine = &machine.with_tolerances(&[0.6]).unwrap();
    let mut values = machine.start();
    for (id, value) in [
        ("e_bend", 0.01),
        ("a_bend", 0.03),
        ("k_lateral", 1e6),
        ("k_relax", 1e7),
        ("c_relax", 1e4),
        ("k_s", 2e3),
    ] {
        values[machine.parameter(id).unwrap_or_else(|| panic!("no parameter {id}"))] = value;
    }
    let integral = machine.parameters.iter().position(|p| p.id.contains("integral")).unwrap();
    values[integral] = 2.0;
    for (response, excitation) in [("table", "table"), ("rotor", "table")] {
        let points = [response, excitation].map(|name| machine.point(name).unwrap());
        let structure = Arc::new(Structure::new(machine, points[0], points[1], RodModel::Exact).unwrap());
        let (mut network, mut work) = (structure.empty_model(), structure.workspace());
        let columns: Vec<Option<usize>> = (0..values.len()).map(Some).collect();
        for hz in [12.0, 109.0, 354.0] {
            network.update(machine, &values, &here);
            let sensitivity = network.sensitivity(machine, &values, &here, &columns, None);
            let mut slopes = vec![Complexes::ZERO; values.len()];
            let size = network.gradient(
                Frequencies::any(&[Reals::splat(omega(hz))]),
                &sensitivity,
                &mut work,
                &mut slopes,
            )[0]
            .lanes()[0]
                .norm();
            let exact: Vec<Complex64> = slopes.iter().map(|slope| slope.lanes()[0]).collect();
            for index in 0..values.len() {
                let step = 1e-5 * if values[index] == 0.0 { 1.0 } else { values[index].abs() };
                let mut at = |by: f64| {
                    let mut near = values.clone();
                    near[index] += by;
                    network.update(machine, &near, &here);
                    network.receptance(omega(hz), &mut work)
                };
                let difference = (at(step) - at(-step)) / (2.0 * step);
                let id = &machine.parameters[index].id;
                let error = (exact[index] - difference).norm() * step;
                assert!(
                    error < 1e-5 * difference.norm() * step + 1e-10 * size,
                    "{response} {id} at {hz} Hz: {} for {difference}",
                    exact[index]
                );
            }
        }
    }
}

/// Direct assembly, receptance coupling and the paper's equations give the same receptances.
#[test]
fn published_equations_and_both_routes_agree() {
    let config = config("configs/tian-as-published.toml");
    let machine = &config.machine;
    let names = ["table", "screw", "screw-angle"];
    for damped in [true, false] {
        let mut values = machine.start();
        let mut joints = TAB_3;
        if !damped {
            for id in ["c_al", "c_ar", "c_n", "c_m"] {
                values[machine.parameter(id).unwrap()] = 0.0;
            }
            (joints.c_al, joints.c_ar, joints.c_n, joints.c_m) = (0.0, 0.0, 0.0, 0.0);
        }
        for (_, nut) in POSITIONS {
            for f in (1..=2000).step_by(7).map(f64::from) {
                let paper = h_all(&joints, nut, omega(f));
                let mut coupled = None;
                for (i, response) in names.iter().enumerate() {
                    for (j, excitation) in names.iter().enumerate() {
                        let (r, e) = (machine.point(response).unwrap(), machine.point(excitation).unwrap());
                        let structure = Arc::new(Structure::new(machine, r, e, RodModel::Exact).unwrap());
                        let mut network = structure.empty_model();
                        network.update(machine, &values, &Operating::at_nut(nut));
                        let direct = network.at(omega(f), &mut structure.workspace()).receptance;
                        let coupled = coupled.get_or_insert_with(|| {
                            coupled_receptances(machine, &values, &Operating::at_nut(nut), omega(f))
                        });
                        let by_coupling = coupled[(r, e)];
                        // Relative to the entry, or near its zeros to the geometric mean of its driving
                        // points.
                        let scale =
                            by_coupling.norm().max(1e-3 * (coupled[(r, r)] * coupled[(e, e)]).norm().sqrt());
                        let context = format!("{response}/{excitation} nut {nut} m, {f} Hz, damped {damped}");
                        assert!(
                            (direct - by_coupling).norm() <= 1e-9 * scale,
                            "{context}: {direct} against {by_coupling}"
                        );
                        assert!(
                            (direct - paper[(i, j)]).norm() <= 1e-9 * scale,
                            "{context}: {direct} against paper {}",
                            paper[(i, j)]
                        );
                    }
                }
            }
        }
    }
}

/// Every entry of every point agrees by both routes, with held rotor, with and without material damping.
#[test]
fn limit_every_entry_by_both_routes() {
    let mut config = config("configs/tian.toml");
    for loss in [0.0, 0.01] {
        config.machine.shafts[0].loss_factor = machine::Value::number(loss);
        let machine = &config.machine;
        for (_, nut) in POSITIONS {
            for f in [1.0, 13.0, 24.0, 117.0, 333.0, 545.0, 721.0, 1024.0, 1700.0, 2000.0] {
                let mut coupled = None;
                for r in 0..machine.points.len() {
                    for e in 0..machine.points.len() {
                        let structure = Arc::new(Structure::new(machine, r, e, RodModel::Exact).unwrap());
                        let mut network = structure.empty_model();
                        network.update(machine, &machine.start(), &Operating::at_nut(nut));
                        let direct = network.at(omega(f), &mut structure.workspace()).receptance;
                        let coupled = coupled.get_or_insert_with(|| {
                            coupled_receptances(machine, &machine.start(), &Operating::at_nut(nut), omega(f))
                        });
                        let scale = coupled[(r, e)]
                            .norm()
                            .max(1e-3 * (coupled[(r, r)] * coupled[(e, e)]).norm().sqrt());
                        let error = (direct - coupled[(r, e)]).norm() / scale;
                        assert!(
                            error <= 1e-9,
                            "{}/{} at {f} Hz: {error:e}",
                            machine.points[r].name,
                            machine.points[e].name
                        );
                    }
                }
            }
        }
    }
}

/// A hollow screw with a matching core fixed in its bore equals the solid screw.
#[test]
fn limit_a_hollow_screw_with_its_core_is_the_solid_one() {
    let solid = config("configs/tian.toml").machine;
    let mut nested = solid.clone();
    let mut core = nested.shafts[0].clone();
    nested.shafts[0].bore_ratio = machine::Value::number(0.6);
    core.name = "core".into();
    core.diameter = machine::Value::number(0.6 * core.diameter.at(&solid.start(), &Operating::default()));
    nested.shafts.push(core);
    let at = |machine: &machine::Machine, f: f64| {
        let [r, e] = ["table", "rotor"].map(|name| machine.point(name).unwrap());
        let structure = Arc::new(Structure::new(machine, r, e, RodModel::Exact).unwrap());
        let mut network = structure.empty_model();
        network.update(machine, &machine.start(), &Operating::at_nut(0.6));
        network.at(omega(f), &mut structure.workspace()).receptance
    };
    for f in [3.0, 24.0, 117.0, 545.0, 1700.0] {
        let (ours, expected) = (at(&nested, f), at(&solid, f));
        assert!((ours - expected).norm() <= 1e-10 * expected.norm(), "{f} Hz: {ours} against {expected}");
    }
}

/// Consistent and lumped elements converge to the exact roots at second order.
#[test]
fn limit_finite_elements_and_lumps_converge_at_second_order() {
    let config = config("configs/tian-as-published.toml");
    let machine = &config.machine;
    let exact = undamped(machine, RodModel::Exact, 0.8);
    for method in ["consistent", "lumped"] {
        let errors = |n: usize| -> Vec<f64> {
            let hz = if method == "consistent" {
                Bench::new(n, 0.8, TAB_3, (0.0, 0.0)).undamped_hz()
            } else {
                undamped(machine, RodModel::Lumped(n), 0.8)
            };
            (1..5).map(|i| (hz[i] / exact[i] - 1.0).abs()).collect()
        };
        let (coarse, fine) = (errors(15), errors(30));
        for (mode, (c, f)) in coarse.iter().zip(&fine).enumerate() {
            let order = (c / f).log2();
            assert!((1.9..2.1).contains(&order), "{method}, mode {}: order {order}", mode + 1);
        }
        assert!(fine.iter().all(|e| *e < 1e-3), "{method}: {fine:?}");
    }
}

fn undamped(machine: &machine::Machine, rods: RodModel, nut: f64) -> Vec<f64> {
    let structure = table_structure(machine, rods);
    let mut network = structure.empty_model();
    network.update(machine, &machine.start(), &Operating::at_nut(nut));
    undamped_modes(&network, 1000.0, &mut structure.workspace()).iter().map(|m| m.frequency_hz).collect()
}

/// The damped receptance against a converged mesh.
#[test]
fn limit_damped_receptance_of_a_fine_mesh() {
    let config = config("configs/tian-as-published.toml");
    let structure = table_structure(&config.machine, RodModel::Exact);
    let mut network = structure.empty_model();
    let mut work = structure.workspace();
    for (_, nut) in POSITIONS {
        network.update(&config.machine, &config.machine.start(), &Operating::at_nut(nut));
        let mesh = Bench::new(800, nut, TAB_3, (0.0, 0.0));
        for f in [5.0, 110.0, 300.0, 532.0, 740.0, 1000.0] {
            let (ours, theirs) = (network.at(omega(f), &mut work).receptance, mesh.receptance(omega(f)));
            assert!(
                (ours - theirs).norm() < 3e-5 * theirs.norm(),
                "nut {nut}, {f} Hz: {ours} against {theirs}"
            );
        }
    }
}

/// The Wittrick–Williams count against the eigenvalues of a mesh.
#[test]
fn limit_count_of_modes_is_that_of_a_fine_mesh() {
    let config = config("configs/tian-as-published.toml");
    let structure = table_structure(&config.machine, RodModel::Exact);
    let mut network = structure.empty_model();
    let mut work = structure.workspace();
    for (_, nut) in POSITIONS {
        network.update(&config.machine, &config.machine.start(), &Operating::at_nut(nut));
        let hz = Bench::new(120, nut, TAB_3, (0.0, 0.0)).undamped_hz();
        for f in (1..=300).map(|i| 7.3 * f64::from(i)) {
            if hz.iter().any(|m| (m / f - 1.0).abs() < 2e-3) {
                continue;
            }
            let expected = hz.iter().filter(|m| **m < f).count();
            assert_eq!(network.modes_below(omega(f), &mut work), expected, "nut {nut} m, {f} Hz");
        }
    }
}

/// The slope dH/dω against central differences.
#[test]
fn limit_slope_of_the_receptance() {
    let config = config("configs/tian.toml");
    let structure = table_structure(&config.machine, RodModel::Exact);
    let mut network = structure.empty_model();
    let mut work = structure.workspace();
    network.update(&config.machine, &config.machine.start(), &Operating::at_nut(1.0));
    for f in (1..200).map(|i| 5.03 * f64::from(i)) {
        let w = omega(f);
        let h = 1e-5 * w;
        let difference =
            (network.at(w + h, &mut work).receptance - network.at(w - h, &mut work).receptance) / (2.0 * h);
        let slope = network.at(w, &mut work).slope;
        assert!(
            (difference - slope).norm() <= 1e-5 * slope.norm() + 1e-12 / w,
            "{f} Hz: {slope} against {difference}"
        );
    }
}

/// Below its first mode a free machine moves as one mass: table, with rotor and screw reflected through the
/// lead.
#[test]
fn limit_rigid_body() {
    let config = config("configs/tian-as-published.toml");
    let structure = table_structure(&config.machine, RodModel::Exact);
    let mut network = structure.empty_model();
    network.update(&config.machine, &config.machine.start(), &Operating::at_nut(1.3));
    let w = omega(0.5);
    let h = network.at(w, &mut structure.workspace()).receptance;
    let polar = std::f64::consts::PI * 0.04_f64.powi(4) / 32.0 * 7850.0 * 2.6;
    let i_b = 0.04 / std::f64::consts::TAU;
    let mass = 272.0 + (1e-3 + 2e-4 + polar) / (i_b * i_b);
    let rigid = -1.0 / (mass * w * w);
    assert!((h.re / rigid - 1.0).abs() < 1e-3, "{h} against {rigid}");
}

/// At the end of a rod its shape equals that of the point; in between it satisfies the wave equation u'' =
/// −λ²u.
#[test]
fn limit_shapes_along_the_screw_meet_their_points_and_the_wave_equation() {
    let config = config("configs/tian.toml");
    let machine = &config.machine;
    let structure = table_structure(machine, RodModel::Exact);
    let (mut network, operating) = (structure.empty_model(), Operating::at_nut(1.0));
    network.update(machine, &machine.start(), &operating);
    for mode in undamped_modes(&network, 1500.0, &mut structure.workspace()) {
        let along = network.shaft_deflections(
            machine,
            &machine.start(),
            &operating,
            (mode.frequency_hz, &mode.shape),
            50,
        );
        assert_eq!(along.len(), 2);
        for shaft in &along {
            let modulus = if shaft.torsional { 7.75e10 } else { 2e11 };
            let lambda = omega(mode.frequency_hz) * (7850.0_f64 / modulus).sqrt();
            let step = shaft.points[1].0 - shaft.points[0].0;
            let expected = -lambda * lambda * shaft.points[25].1;
            let found = (shaft.points[24].1 - 2.0 * shaft.points[25].1 + shaft.points[26].1) / (step * step);
            let largest = shaft.points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
            assert!((found - expected).abs() < 2e-3 * lambda * lambda * largest, "{found} {expected}");
            let right = machine.point(if shaft.torsional { "right-angle" } else { "right" }).unwrap();
            let end = mode.shape[structure.coordinate_of(right).unwrap()];
            assert!((shaft.points[100].1 - end).abs() < 1e-6 * largest);
        }
    }
}
