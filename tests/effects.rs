//! The library of effects: each effect applies to the bench, has no influence at zero amplitude and matches
//! its description.

use config::effect_library;
use diagnosis::{Hypothesis, at_start, implausibility, relaxes_within};
use dynamics::model::{Complexes, Frequencies, Reals, RodModel, matrices, undamped_modes};
use machine::{Data, Effect, Machine, Mechanism, Operating, PeriodAlong, Role};

use crate::support::{config, table_structure};

fn bench_without_hold() -> Machine {
    config::read_machine("configs/tian.toml", &[], &["rotor-hold".to_string()]).unwrap().machine
}

#[test]
fn every_effect_applies_to_the_bench_and_has_a_description() {
    let machine = bench_without_hold();
    let library = effect_library().unwrap();
    assert!(library.len() >= 32);
    // The bench has neither loops nor a support of its screw in one joint.
    let elsewhere = |e: &&machine::Effect| matches!(machine.missing_part(e), Some("drive" | "support"));
    assert_eq!(library.iter().filter(|e| e.data.contains(&Data::Frf)).filter(elsewhere).count(), 2);
    for effect in library.iter().filter(|e| e.data.contains(&Data::Frf) && !elsewhere(e)) {
        let refined = effect.refines.as_ref().map(|id| library.iter().find(|e| e.id == *id).unwrap());
        let machine = refined.map_or(machine.clone(), |refined| machine.with_effect(refined).unwrap());
        let with = machine.with_effect(effect).unwrap_or_else(|e| panic!("{}: {e}", effect.id));
        assert!(with.effects.contains(&effect.id) && effect.description.len() > 20, "{}", effect.id);
        let added = with.parameters.len() - machine.parameters.len();
        assert!((1..=6).contains(&added), "{} adds {added} parameters", effect.id);
        assert!(
            with.parameters[machine.parameters.len()..].iter().all(|p| !p.source.is_empty()),
            "{}",
            effect.id
        );
    }
}

#[test]
fn implausible_arms_exclude_table_rocking() {
    let library = effect_library().unwrap();
    let rocking = library.iter().find(|e| e.id == "table-rocking").unwrap();
    let hypothesis = Hypothesis::nominal(bench_without_hold()).with(rocking).unwrap();
    for (sensor, hammer, plausible) in
        [(0.0, 0.0, false), (0.1, -0.2, false), (0.1, 0.5, true), (-1.2, 0.0, true), (-10.0, 0.1, false)]
    {
        let mut fitted = at_start(&hypothesis);
        for (parameter, unit) in hypothesis.machine.parameters.iter().zip(&mut fitted.units) {
            match parameter.id.as_str() {
                "r_sensor" => *unit = parameter.to_unit(sensor),
                "r_hammer" => *unit = parameter.to_unit(hammer),
                _ => {}
            }
        }
        assert_eq!(implausibility(&hypothesis, &fitted).is_none(), plausible, "{sensor} {hammer}");
    }
}

#[test]
fn a_stage_heavier_than_its_rotor_excludes_an_elastic_drive() {
    let library = effect_library().unwrap();
    let with_rotor =
        library.iter().find(|e| e.id == "drive-flexibility" && e.patch.points.len() == 1).unwrap();
    let hypothesis = Hypothesis::nominal(bench_without_hold()).with(with_rotor).unwrap();
    let stage = hypothesis.machine.parameters.iter().position(|p| p.id == "j_stage").unwrap();
    // The rotor has 1e-3 kg m².
    for (inertia, plausible) in [(1e-4, true), (9e-4, true), (2e-3, false), (5e-2, false)] {
        let mut fitted = at_start(&hypothesis);
        fitted.units[stage] = hypothesis.machine.parameters[stage].to_unit(inertia);
        assert_eq!(implausibility(&hypothesis, &fitted).is_none(), plausible, "{inertia}");
    }
}

/// A loss factor that ends at its largest value takes up another effect's change.
#[test]
fn the_largest_loss_factor_excludes_an_effect() {
    let library = effect_library().unwrap();
    let guide = library.iter().find(|e| e.id == "guide-stiffness").unwrap();
    let hypothesis = Hypothesis::nominal(bench_without_hold()).with(guide).unwrap();
    let at = hypothesis.machine.parameters.iter().position(|p| p.id == "eta_guide").unwrap();
    let loss = &hypothesis.machine.parameters[at];
    for (value, plausible) in
        [(loss.lower, true), (loss.start, true), (0.9 * loss.upper, true), (loss.upper, false)]
    {
        let mut fitted = at_start(&hypothesis);
        fitted.units[at] = loss.to_unit(value);
        assert_eq!(implausibility(&hypothesis, &fitted).is_none(), plausible, "{value}");
    }
}

/// Below its corner, stiffness over damping, a relaxation is a damper, above it a spring: where the data show
/// one alone, it is another effect.
#[test]
fn a_corner_outside_the_band_excludes_a_relaxation() {
    let library = effect_library().unwrap();
    let hypothesis = |id: &str| {
        Hypothesis::nominal(bench_without_hold()).with(library.iter().find(|e| e.id == id).unwrap()).unwrap()
    };
    let relaxing = hypothesis("table-relaxation");
    for (corner_hz, shown) in
        [(0.5, false), (9.9, false), (10.1, true), (60.0, true), (799.0, true), (801.0, false), (8e3, false)]
    {
        let mut fitted = at_start(&relaxing);
        for (parameter, unit) in relaxing.machine.parameters.iter().zip(&mut fitted.units) {
            match parameter.id.as_str() {
                "k_relax" => *unit = parameter.to_unit(1e6),
                "c_relax" => *unit = parameter.to_unit(1e6 / (std::f64::consts::TAU * corner_hz)),
                _ => {}
            }
        }
        assert_eq!(relaxes_within(&relaxing, &fitted, (10.0, 800.0)), shown, "{corner_hz} Hz");
    }
    let spring = hypothesis("guide-stiffness");
    assert!(relaxes_within(&spring, &at_start(&spring), (10.0, 800.0)));
}

/// Effects are located at the parts that they change, by the machine's names.
#[test]
fn effects_are_located_at_the_parts_they_change() {
    let library = effect_library().unwrap();
    let machine = bench_without_hold();
    let expected = [
        ("rotor-hold", "rotor"),
        ("guide-stiffness", "table"),
        ("table-mass", "table"),
        ("bed-compliance", "bearing-left"),
        ("nut-flange-compliance", "nut"),
        ("bearing-stiffness-position", "bearing-left"),
        ("coupling-inertia", "left-angle"),
        ("screw-diameter", "screw"),
        ("screw-lead", "nut"),
        ("nut-position-offset", "screw"),
        ("screw-youngs-modulus", "screw"),
        ("table-rocking", "table"),
        ("screw-bending", "screw"),
        ("frf-gain", "measurement"),
    ];
    for (id, place) in expected {
        let effect = library.iter().find(|e| e.id == id).unwrap();
        assert_eq!(effect.location().as_deref(), Some(place), "{id}");
    }
    let parts: Vec<&str> = (machine.points.iter().map(|p| &p.name))
        .chain(machine.joints.iter().map(|j| &j.name))
        .chain(machine.shafts.iter().map(|s| &s.name))
        .map(String::as_str)
        .chain(["measurement"])
        .collect();
    for effect in library.iter().filter(|e| e.data.contains(&Data::Frf) && machine.missing_part(e).is_none())
    {
        let places = effect.places();
        assert!(
            !places.is_empty() && places.iter().all(|(place, _)| parts.contains(&place.as_str())),
            "{}: {places:?}",
            effect.id
        );
    }
    // Each of the two bearings has its own parameter.
    let bearings = library.iter().find(|e| e.id == "bearing-stiffness-position").unwrap().places();
    assert_eq!(bearings[1], ("bearing-right".into(), Some("bearing_slope_right".into())));
    // An effect located at a part that the machine lacks does not apply.
    let mut rocking = library.iter().find(|e| e.id == "table-rocking").unwrap().clone();
    assert_eq!(machine.missing_part(&rocking), None);
    rocking.at = Some("saddle".into());
    assert_eq!(machine.missing_part(&rocking), Some("saddle"));
}

/// Returns the fitter of a diagnosis of modes.
fn fitter_of_modes<'s>(fit: &measurement::FitSet<'s>) -> diagnosis::Fitter<'s> {
    diagnosis::fitter(
        fit,
        diagnosis::Domain::Modes(identification::objective::ModeSettings::default()),
        &[],
        &[],
    )
}

/// Effects that only motion reveals apply to an axis with guide, nut and drive, add their own parameters and
/// leave every FRF unchanged.
#[test]
fn every_effect_of_motion_applies_to_a_driven_axis_and_leaves_frfs_unchanged() {
    let text = std::fs::read_to_string("configs/tian.toml").unwrap()
        + r#"
[[joint]]
name = "guide"
between = ["table", "ground"]
friction = { coulomb = 10.0 }

[drive]
on = "rotor"
constant = 1.0

[drive.position]
lead_m = 0.04
gain_per_s = 100.0
period_s = 1e-3

[drive.velocity]
gain = 20.0
period_s = 1e-3
"#;
    let machine =
        config::read_machine_text("axis.toml", &text, &[], &["rotor-hold".to_string()]).unwrap().machine;
    let before = receptance(&bench_without_hold(), &[], 117.0);
    assert_eq!(receptance(&machine, &[], 117.0), before);
    let library = effect_library().unwrap();
    let motion: Vec<_> = library
        .iter()
        .filter(|e| {
            let is_of_frfs = ["drive-flexibility", "measurement-delay"].contains(&e.id.as_str());
            (e.data == [Data::Motion] && !is_of_frfs) || e.id == "control-delay"
        })
        .collect();
    assert_eq!(motion.len(), 14);
    let (bench, nominal) = (bench_without_hold(), Hypothesis::nominal(bench_without_hold()));
    let set = measurement::read_set(measurement::BENCH).unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let fitter = fitter_of_modes(&fit);
    for effect in motion {
        let with = machine.with_effect(effect).unwrap_or_else(|e| panic!("{}: {e}", effect.id));
        let added = &with.parameters[machine.parameters.len()..];
        assert!(
            (1..=3).contains(&added.len()) && added.iter().all(|p| !p.source.is_empty()),
            "{}",
            effect.id
        );
        let linear = with.linear_parameters();
        let shows_in_frfs = added.iter().any(|p| linear[with.parameter(&p.id).unwrap()]);
        assert_eq!(
            shows_in_frfs,
            ["viscous-friction", "moving-mass", "lead-growth"].contains(&effect.id.as_str()),
            "{}",
            effect.id
        );
        assert_eq!(receptance(&with, &[], 117.0), before, "{}", effect.id);
        // They are no candidates of a diagnosis of FRFs.
        let (apply, _) = diagnosis::hypotheses(&fitter, &bench, &nominal, &library, &[]);
        assert!(apply.iter().all(|h| h.id() != effect.id));
    }
    // The delay of the control shows in closed-loop FRFs of a driven axis.
    let delay = library.iter().find(|e| e.id == "control-delay").unwrap().clone();
    assert_eq!(
        diagnosis::hypotheses(&fitter, &machine, &Hypothesis::nominal(machine.clone()), &[delay], &[])
            .0
            .len(),
        1
    );
}

#[test]
fn emps_has_the_parameters_of_its_model_and_loses_them_with_its_effects() {
    let ids = |without: &[&str]| -> Vec<String> {
        let without: Vec<String> = without.iter().map(ToString::to_string).collect();
        let read = config::read_machine("configs/emps.toml", &[], &without).unwrap();
        assert!(read.warnings.is_empty(), "{:?}", read.warnings);
        read.machine.parameters.iter().map(|p| p.id.clone()).collect()
    };
    assert_eq!(ids(&[]), ["coulomb_friction", "friction_offset", "moving_mass", "viscous_friction"]);
    assert_eq!(ids(&["coulomb-friction"]), ["friction_offset", "moving_mass", "viscous_friction"]);
    assert_eq!(ids(&["coulomb-friction", "viscous-friction"]), ["friction_offset", "moving_mass"]);
}

/// Returns the table's receptance with some parameters set.
fn receptance(machine: &Machine, set: &[(&str, f64)], hz: f64) -> num_complex::Complex64 {
    let mut values = machine.start();
    for (id, value) in set {
        values[machine.parameter(id).unwrap()] = *value;
    }
    let structure = table_structure(machine, RodModel::Exact);
    let mut network = structure.empty_model();
    network.update(machine, &values, &Operating::at_nut(1.0));
    network.receptance(std::f64::consts::TAU * hz, &mut structure.workspace())
}

/// A nut that supports its screw at two points equals two springs of half its stiffness, in series with the
/// screw's compliance there. The mass is unchanged.
#[test]
fn limit_a_nut_over_a_length_is_two_springs_side_by_side() {
    let machine = bench_without_hold()
        .with_effect(effect_library().unwrap().iter().find(|e| e.id == "rotor-hold").unwrap())
        .unwrap();
    let nut_m = 1.0;
    let held = machine.with_tolerances(&[nut_m]).unwrap();
    let (length_m, axial_n) = (2.6, 2e11 * std::f64::consts::FRAC_PI_4 * 0.04_f64.powi(2));
    let torsion_n_m2 = 7.75e10 * std::f64::consts::PI / 32.0 * 0.04_f64.powi(4);
    let (k_a, k_n, k_m, k_s) = (5e8, 1e9, 1e5, 1e6);
    let joints = [("k_al", k_a), ("k_ar", k_a), ("k_n", k_n), ("k_m", k_m), ("k_s", k_s), ("c_n", 1e3)];
    // No journals and no losses.
    let journals = ["~journal at left", "~journal at right"].map(|id| (id, 0.0));
    let losses = held
        .parameters
        .iter()
        .filter(|p| p.id.starts_with("~loss"))
        .map(|p| (p.id.as_str(), 0.0))
        .collect::<Vec<_>>();
    let compliance =
        |machine: &Machine, by: &[(&str, f64)]| receptance(machine, &[&joints[..], by].concat(), 0.05).re;
    // Displacement at a per force at b: two bearings with the screw between them, and the screw's torsion
    // from its driven end.
    let at = |a: f64, b: f64| {
        let (low, high) = (1.0 / k_a + a.min(b) / axial_n, 1.0 / k_a + (length_m - a.max(b)) / axial_n);
        let lead = (0.04 / std::f64::consts::TAU).powi(2);
        low * high / (2.0 / k_a + length_m / axial_n)
            + lead * (1.0 / k_m + 1.0 / k_s + a.min(b) / torsion_n_m2)
    };
    let mut before = f64::INFINITY;
    for (factor, aside) in [(0.3, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.5)] {
        // 0.9 leads of 40 mm on either side.
        let half_m = 0.9 * 0.04;
        let (a, b) = (nut_m + half_m * (aside - factor), nut_m + half_m * (aside + factor));
        // Both springs have the same displacement at the table: 1/(1ᵀ·(A + 2/k)⁻¹·1).
        let (aa, bb, ab) = (at(a, a) + 2.0 / k_n, at(b, b) + 2.0 / k_n, at(a, b));
        let expected = (aa * bb - ab * ab) / (aa + bb - 2.0 * ab);
        let by = [&journals[..], &losses, &[("~nut length on screw", factor), ("~nut load on screw", aside)]]
            .concat();
        let found = compliance(&held, &by);
        assert!((found / expected - 1.0).abs() < 1e-4, "{factor} {aside}: {found:e} against {expected:e}");
        if aside == 0.0 {
            assert!(found < before && found < compliance(&machine, &[]), "{factor}");
            before = found;
        }
    }
}

/// Tolerances apply to a screw as short as eight diameters and to a nut at the end of its stroke.
#[test]
fn tolerances_apply_to_a_short_screw() {
    let text =
        std::fs::read_to_string("configs/tian.toml").unwrap().replace("length_m = 2.6", "length_m = 0.32");
    let machine = config::read_machine_text("test", &text, &[], &[]).unwrap().machine;
    for nuts_m in [&[0.1, 0.2][..], &[0.003, 0.317], &[]] {
        let held = machine.with_tolerances(nuts_m).unwrap();
        let structure = table_structure(&held, RodModel::Exact);
        let mut network = structure.empty_model();
        network.update(&held, &held.start(), &Operating::at_nut(*nuts_m.first().unwrap_or(&0.16)));
        let found = network.receptance(std::f64::consts::TAU * 100.0, &mut structure.workspace());
        assert!(found.norm().is_finite() && found.im < 0.0, "{nuts_m:?}: {found}");
    }
}

/// Returns a table held by its nut alone, with the effect `table-rocking`.
fn rocking_table() -> Machine {
    let text = r#"
title = "a table and its nut"
[tolerance]
loss_dispersion = 0.0
[[point]]
name = "table"
motion = "translation"
mass_kg = 300.0
[[joint]]
name = "nut"
between = ["table", "ground"]
stiffness = 2e8
damping = 4e3
"#;
    let table = config::read_machine_text("table.toml", text, &[], &[]).unwrap().machine;
    let library = effect_library().unwrap();
    table.with_effect(library.iter().find(|e| e.id == "table-rocking").unwrap()).unwrap()
}

/// A rigid table pitches and heaves on unequal carriages with a loss factor. The nut pushes below its centre,
/// sensor and hammer are above it. Its two modes are those of the effect: the receptance is that of the
/// equations of the rigid body.
#[test]
fn published_rigid_table_on_unequal_carriages() {
    let library = effect_library().unwrap();
    let machine =
        rocking_table().with_effect(library.iter().find(|e| e.id == "rocking-second-mode").unwrap()).unwrap();
    let (mass_kg, inertia, loss): (f64, f64, f64) = (300.0, 9.0, 0.02);
    let [sensor_m, hammer_m, nut_m] = [0.12, -0.05, 0.08];
    // Heave, pitch about the centre, and both together (N/m, N·m/rad, N/rad).
    let [heave, pitch, both] = [9e8, 3e7, 6e7];
    let scaled = nalgebra::Matrix2::new(
        heave / mass_kg,
        both / (mass_kg * inertia).sqrt(),
        both / (mass_kg * inertia).sqrt(),
        pitch / inertia,
    );
    let modes = scaled.symmetric_eigen();
    // Motion of the nut by each mode of unit modal mass.
    let moved = [0, 1].map(|mode| nut_m * modes.eigenvectors[(1, mode)] / inertia.sqrt());
    let [mass, stiffness] = [
        [0, 1].map(|mode| moved[mode].powi(-2)),
        [0, 1].map(|mode| modes.eigenvalues[mode] * moved[mode].powi(-2)),
    ];
    let values: Vec<(&str, f64)> =
        ["m_rock", "m_rock_2", "k_rock", "k_rock_2", "c_rock", "eta_rock_2", "r_sensor", "r_hammer"]
            .into_iter()
            .zip([
                mass[0],
                mass[1],
                stiffness[0],
                stiffness[1],
                0.0,
                loss,
                -sensor_m / nut_m,
                -hammer_m / nut_m,
            ])
            .collect();
    for hz in [20.0, 118.0, 290.0, 700.0] {
        let (omega, i) = (std::f64::consts::TAU * hz, num_complex::Complex64::i());
        let (nut, lossy) = (2e8 + i * omega * 4e3, 1.0 + i * loss);
        // Displacement along the travel, heave and pitch.
        let matrix = nalgebra::Matrix3::new(
            nut - omega * omega * mass_kg,
            0.0.into(),
            -nut * nut_m,
            0.0.into(),
            heave * lossy - omega * omega * mass_kg,
            both * lossy,
            -nut * nut_m,
            both * lossy,
            nut * nut_m * nut_m + pitch * lossy - omega * omega * inertia,
        );
        let [read, struck] = [sensor_m, hammer_m]
            .map(|arm| nalgebra::Vector3::new(1.0, 0.0, arm).map(num_complex::Complex64::from));
        let expected = read.dot(&matrix.lu().solve(&struck).unwrap());
        let found = receptance(&machine, &values, hz);
        assert!((found - expected).norm() < 1e-12 * expected.norm(), "{hz} Hz: {found} against {expected}");
    }
}

/// A rigid table rotates about its centre, supported by the nut below it, with hammer and sensor at two other
/// heights. The effect is compared with the equations of the rigid body, its derivatives with finite
/// differences.
#[test]
fn published_rigid_table_on_arms() {
    let machine = rocking_table();
    // Inertia, stiffness and damping about the centre; heights of sensor and hammer over it, depth of the nut
    // below it.
    let (mass_kg, inertia, stiffness, damping) = (300.0, 9.0, 3e7, 2e3);
    let (nut_k, nut_c) = (2e8, 4e3);
    for (sensor_m, hammer_m, nut_m) in [(0.12, 0.12, 0.08), (0.12, -0.05, 0.08), (-0.2, 0.03, 0.15)] {
        let rocking = [
            ("m_rock", inertia / (nut_m * nut_m)),
            ("k_rock", stiffness / (nut_m * nut_m)),
            ("c_rock", damping / (nut_m * nut_m)),
            ("r_sensor", -sensor_m / nut_m),
            ("r_hammer", -hammer_m / nut_m),
        ];
        for hz in [20.0, 130.0, 290.0, 700.0] {
            let omega = std::f64::consts::TAU * hz;
            let i = num_complex::Complex64::i();
            let nut = nut_k + i * omega * nut_c;
            // Displacement x and rotation φ of the centre; the nut moves by x − nut_m·φ.
            let (xx, xt) = (nut - omega * omega * mass_kg, -nut * nut_m);
            let tt = nut * nut_m * nut_m + stiffness + i * omega * damping - omega * omega * inertia;
            let determinant = xx * tt - xt * xt;
            let [x, rotation] = [(tt - xt * hammer_m) / determinant, (xx * hammer_m - xt) / determinant];
            let expected = x + sensor_m * rotation;
            let found = receptance(&machine, &rocking, hz);
            assert!(
                (found - expected).norm() < 1e-12 * expected.norm(),
                "{hz} Hz: {found} against {expected}"
            );
            let mut values = machine.start();
            rocking.iter().for_each(|(id, x)| values[machine.parameter(id).unwrap()] = *x);
            let structure = table_structure(&machine, RodModel::Exact);
            let mut network = structure.empty_model();
            network.update(&machine, &values, &Operating::default());
            let columns: Vec<Option<usize>> = (0..values.len()).map(Some).collect();
            let sensitivity = network.sensitivity(&machine, &values, &Operating::default(), &columns, None);
            let mut slopes = vec![Complexes::ZERO; values.len()];
            network.gradient(
                Frequencies::any(&[Reals::splat(omega)]),
                &sensitivity,
                &mut structure.workspace(),
                &mut slopes,
            );
            for (id, x) in rocking {
                let at = machine.parameter(id).unwrap();
                let step = 1e-5 * x;
                let [low, high] = [-step, step].map(|by| {
                    receptance(
                        &machine,
                        &rocking.map(|(other, y)| (other, if other == id { y + by } else { y })),
                        hz,
                    )
                });
                let (exact, difference) = (slopes[at].lanes()[0] * x, (high - low) / (2.0 * step) * x);
                assert!(
                    (exact - difference).norm() < 1e-6 * expected.norm(),
                    "{hz} Hz, {id}: {exact} against {difference}"
                );
            }
        }
    }
}

/// An arm refers to two different moving points of the machine.
#[test]
fn arms_on_missing_points_are_refused() {
    let refused = |lever: &str| {
        let text = std::fs::read_to_string("configs/tian.toml").unwrap()
            + &format!(
                r#"
[[effect]]
id = "arm"
description = "the sensor sits on an arm"
lever = [{lever}]
[effect.parameter.r_arm]
unit = "1"
start = 0.0
lower = -1.0
upper = 1.0
source = "drawing"
"#
            );
        let set = ["effects=[\"rotor-hold\", \"arm\"]".to_string()];
        config::read_machine_text("arm.toml", &text, &set, &[]).unwrap_err().to_string()
    };
    for (lever, expected) in [
        (r#"{ at = "table", with = "saddle", read = "r_arm", struck = 0.0 }"#, "no point is called «saddle»"),
        (
            r#"{ at = "table", with = "table", read = "r_arm", struck = 0.0 }"#,
            "«table» cannot be its own lever",
        ),
        (r#"{ at = "table", with = "screw", read = "r", struck = 0.0 }"#, "no parameter is called «r»"),
    ] {
        let message = refused(lever);
        assert!(message.contains(expected) && message.contains("arm"), "{message}");
    }
}

/// An effect describes another effect in more detail, neither an unknown one nor itself.
#[test]
fn effects_that_refine_no_other_are_refused() {
    for id in ["bed-complaince", "heavy"] {
        let effect = format!(
            r#"
[[effect]]
id = "heavy"
description = "the table is heavier"
refines = "{id}"
rescale = [{{ part = "point-inertia", name = "table", modifier = "added", by = "m_more" }}]
[effect.parameter.m_more]
unit = "kg"
start = 0.0
lower = 0.0
upper = 100.0
scale = "linear"
source = "drawing"
"#
        );
        let text = std::fs::read_to_string("configs/tian.toml").unwrap() + &effect;
        let message = config::read_machine_text("heavy.toml", &text, &[], &[]).unwrap_err().to_string();
        assert!(
            message.contains("«heavy», refines")
                && message.contains(&format!("no other effect is called «{id}»")),
            "{message}"
        );
        assert!(
            config::read_machine_text(
                "heavy.toml",
                &text.replace(&format!("refines = \"{id}\""), "refines = \"table-mass\""),
                &[],
                &[]
            )
            .is_ok()
        );
    }
}

/// An effect that describes another one in more detail belongs to it: it applies only beside it, is withheld
/// with it, and bears its name.
#[test]
fn the_second_mode_of_a_bed_belongs_to_its_compliance() {
    let library = effect_library().unwrap();
    let text = std::fs::read_to_string("configs/tian.toml").unwrap();
    let read = |effects: &str, without: &[&str]| {
        let without: Vec<String> = without.iter().map(|id| id.to_string()).collect();
        config::read_machine_text("bed.toml", &text, &[format!("effects={effects}")], &without)
    };
    let both = read(r#"["rotor-hold", "bed-compliance", "bed-second-mode"]"#, &[]).unwrap().machine;
    let ids = both.effects.iter().fold(machine::EffectIds::default(), |all, id| all.with(id));
    assert_eq!(Effect::unrefined(&library, &ids).to_string(), "rotor-hold+bed-compliance");
    let withheld =
        read(r#"["rotor-hold", "bed-compliance", "bed-second-mode"]"#, &["bed-compliance"]).unwrap().machine;
    assert_eq!(withheld.effects, ["rotor-hold"]);
    let alone = read(r#"["rotor-hold", "bed-second-mode"]"#, &[]).unwrap_err().to_string();
    assert!(alone.contains("bed-second-mode") && alone.contains("the machine has no «bed"), "{alone}");
    // A bed that the file itself describes: the effect would take its bearings the wrong way round.
    let own = text.replace("between = [\"left\", \"ground\"]", "between = [\"left\", \"bed\"]")
        + "\n[[point]]\nname = \"bed\"\nmotion = \"translation\"\nmass_kg = 400.0\n\n[[joint]]\nname = \"bed-foundation\"\nbetween = [\"bed\", \"ground\"]\nstiffness = 1.9e8\n";
    let described = config::read_machine_text("bed.toml", &own, &[], &[]).unwrap().machine;
    assert!(described.point("bed").is_some());
    let refused = described
        .with_effect(library.iter().find(|e| e.id == "bed-second-mode").unwrap())
        .unwrap_err()
        .to_string();
    assert!(refused.contains("the machine has no «bed-compliance»"), "{refused}");
}

/// Of an effect with several variants, a machine gets the variant whose parts it has most completely.
#[test]
fn the_variant_of_an_effect_that_fits_the_machine_applies() {
    let added = |machine: &Machine, effects: &[Effect]| {
        let effect = effects.iter().find(|e| e.id == "drive-flexibility").unwrap();
        let with = machine.with_effect(effect).unwrap();
        with.parameters[machine.parameters.len()..]
            .iter()
            .map(|p| (p.id.clone(), p.unit.clone()))
            .collect::<Vec<_>>()
    };
    let names =
        |some: &[(&str, &str)]| some.iter().map(|(a, b)| (a.to_string(), b.to_string())).collect::<Vec<_>>();
    let bench = config("configs/tian.toml");
    let stage = names(&[("eta_stage", "1"), ("j_stage", "kg*m^2"), ("k_stage", "N*m/rad")]);
    assert_eq!(added(&bench.machine, &bench.effects), stage);
    // The configuration's effects select the same variant.
    let text = std::fs::read_to_string("configs/tian.toml").unwrap();
    let text =
        text.replace(r#"effects = ["rotor-hold"]"#, r#"effects = ["rotor-hold", "drive-flexibility"]"#);
    let with = config::read_machine_text("bench", &text, &[], &[]).unwrap().machine;
    assert!(with.points.iter().any(|p| p.name == "drive-stage"));
    // A rigid drive without a coupling has its spring at the nut.
    let text = r#"
title = "a drive at its nut"
[[point]]
name = "motor"
motion = "rotation"
inertia_kg_m2 = 0.01
[[point]]
name = "table"
motion = "translation"
mass_kg = 100.0
[[joint]]
name = "nut"
between = ["table", "ground"]
screw = { angle = "motor", lead_m = 0.01 }
stiffness = 1e8
"#;
    let drive = config::read_machine_text("drive", text, &[], &[]).unwrap();
    assert_eq!(added(&drive.machine, &drive.effects), names(&[("k_drive", "N/m")]));
}

/// The mechanism of each parameter follows from its use and agrees with its unit.
#[test]
fn mechanisms_agree_with_uses_and_units() {
    let mut seen = 0;
    for path in
        ["tian", "hybrid-axis", "servo-axis", "emps", "two-inertia", "twin-ball-screw", "vertical-axis"]
    {
        let config = config(&format!("configs/{path}.toml"));
        let effects = config.effects.iter().flat_map(|e| &e.patch.parameters);
        for p in config.machine.parameters.iter().chain(effects) {
            let of_unit = match p.unit.as_str() {
                "N/m" | "N*m/rad" => vec![Mechanism::Stiffness],
                "N*s/m" | "N*m*s/rad" => vec![Mechanism::Damping],
                "kg" | "kg*m^2" => vec![Mechanism::Inertia],
                "N" | "N*m" | "N or N*m" => vec![Mechanism::Force],
                "m or rad" => vec![Mechanism::Period(PeriodAlong::Motor)],
                "m" => vec![Mechanism::Length, Mechanism::Period(PeriodAlong::Travel)],
                "s" => vec![Mechanism::Delay],
                "1" => vec![Mechanism::Ratio, Mechanism::LossFactor, Mechanism::LeadExpansion],
                _ => vec![Mechanism::Velocity, Mechanism::Other],
            };
            assert!(of_unit.contains(&p.mechanism), "{path}, {}: {:?} in {}", p.id, p.mechanism, p.unit);
            assert_eq!(p.mechanism.is_period(), p.id.ends_with("period"), "{}", p.id);
            assert!(p.role == Role::Described);
            seen += 1;
        }
    }
    assert!(seen > 200, "{seen}");
}

/// A parameter that a description names like a tolerance is no tolerance.
#[test]
fn the_first_letter_of_an_id_decides_nothing() {
    let text = std::fs::read_to_string("configs/tian.toml").unwrap();
    let text = text.replace("[parameter.k_al]", "[parameter.\"~k_al\"]").replace("= \"k_al\"", "= \"~k_al\"");
    let machine = config::read_machine_text("bench", &text, &[], &[]).unwrap().machine;
    let own = &machine.parameters[machine.parameter("~k_al").unwrap()];
    assert!(!own.is_tolerance() && own.name() == "~k_al");
    let tolerances = machine.with_tolerances(&[]).unwrap().parameters;
    assert!(
        tolerances[machine.parameters.len()..].iter().all(|p| p.is_tolerance() && !p.name().starts_with('~'))
    );
}

/// Each effect at zero amplitude equals the machine without the effect.
#[test]
fn limit_an_effect_of_zero_amplitude_changes_nothing() {
    let machine = config("configs/tian.toml").machine;
    let zero_amplitudes: [(&str, &[(&str, f64)]); 22] = [
        ("guide-stiffness", &[("k_guide", 1e-3)]),
        ("guide-viscous", &[("c_guide", 1e-6)]),
        ("table-mass", &[("table_mass_change", 0.0)]),
        ("bed-compliance", &[("k_bed", 1e18)]),
        ("bed-second-mode", &[("k_bed", 2e8), ("k_bed_2", 1e18)]),
        ("nut-flange-compliance", &[("k_flange", 1e18), ("m_nut", 1e-6)]),
        ("nut-stiffness-position", &[("nut_slope", 0.0)]),
        ("bearing-stiffness-position", &[("bearing_slope_left", 0.0), ("bearing_slope_right", 0.0)]),
        ("coupling-inertia", &[("hub_factor", 1.0)]),
        ("drive-flexibility", &[("k_drive", 1e18)]),
        ("screw-diameter", &[("diameter_change", 0.0)]),
        ("screw-lead", &[("lead_change", 0.0)]),
        ("nut-position-offset", &[("nut_offset", 0.0)]),
        ("nut-position-scale", &[("nut_scale", 0.0)]),
        ("screw-youngs-modulus", &[("youngs_change", 0.0)]),
        ("screw-shear-modulus", &[("shear_change", 0.0)]),
        ("table-rocking", &[("k_rock", 1e18)]),
        ("rocking-second-mode", &[("k_rock", 2e9), ("k_rock_2", 1e18)]),
        ("screw-bending", &[("e_bend", 1e-9), ("a_bend", 0.0)]),
        ("table-relaxation", &[("c_relax", 1e-6)]),
        ("frf-gain", &[]),
        ("measurement-delay", &[]),
    ];
    let library = effect_library().unwrap();
    for (id, set) in zero_amplitudes {
        let of = |id: &str| library.iter().find(|e| e.id == id).unwrap();
        // What describes another effect in more detail applies beside it.
        let without = of(id)
            .refines
            .as_deref()
            .map_or(machine.clone(), |refined| machine.with_effect(of(refined)).unwrap());
        let with = without.with_effect(of(id)).unwrap();
        let (own, others): (Vec<_>, Vec<_>) =
            set.iter().partition(|(parameter, _)| without.parameter(parameter).is_none());
        for hz in [11.0, 117.0, 530.0, 890.0] {
            let (a, b) =
                (receptance(&without, &others, hz), receptance(&with, &[&own[..], &others].concat(), hz));
            assert!((a - b).norm() < 1e-5 * a.norm(), "{id} at {hz} Hz: {a} against {b}");
            // At the start values the effect is small.
            let start = receptance(&with, &others, hz);
            assert!(
                (a - start).norm() < 1e-2 * a.norm(),
                "{id} at {hz} Hz: {a} against {start} at its start"
            );
        }
    }
}

/// Wrong data of the screw as effects equal a description with other data.
#[test]
fn changed_data_of_the_screw_are_those_of_another_description() {
    let text = std::fs::read_to_string("configs/tian.toml").unwrap();
    let machine = config::read_machine_text("bench", &text, &[], &[]).unwrap().machine;
    let library = effect_library().unwrap();
    for (id, parameter, change, described, other) in [
        ("screw-lead", "lead_change", 0.25, "lead_m = 0.040", "lead_m = 0.050"),
        (
            "screw-youngs-modulus",
            "youngs_change",
            -0.5,
            "youngs_modulus_pa = 2e11",
            "youngs_modulus_pa = 1e11",
        ),
        (
            "screw-shear-modulus",
            "shear_change",
            0.5,
            "shear_modulus_pa = 7.75e10",
            "shear_modulus_pa = 11.625e10",
        ),
    ] {
        let with = machine.with_effect(library.iter().find(|e| e.id == id).unwrap()).unwrap();
        let edited = text.replace(described, other);
        assert_ne!(edited, text, "{id}");
        let edited = config::read_machine_text("bench", &edited, &[], &[]).unwrap().machine;
        for hz in [11.0, 117.0, 530.0, 890.0] {
            let (a, b) = (receptance(&edited, &[], hz), receptance(&with, &[(parameter, change)], hz));
            assert!((a - b).norm() < 1e-10 * a.norm(), "{id} at {hz} Hz: {b} for {a}");
            let before = receptance(&machine, &[], hz);
            assert!((before - b).norm() > 1e-6 * before.norm(), "{id} at {hz} Hz");
        }
    }
}

/// Wrong nut positions as effects equal other nut positions, and the nut stays between the ends of its screw.
#[test]
fn changed_nut_positions_are_other_nut_positions() {
    let machine = config("configs/tian.toml").machine;
    let library = effect_library().unwrap();
    let at = |machine: &Machine, nut_m: f64, set: &[(&str, f64)]| {
        let mut values = machine.start();
        set.iter().for_each(|(id, value)| values[machine.parameter(id).unwrap()] = *value);
        let structure = table_structure(machine, RodModel::Exact);
        let mut network = structure.empty_model();
        network.update(machine, &values, &Operating::at_nut(nut_m));
        network.receptance(std::f64::consts::TAU * 530.0, &mut structure.workspace())
    };
    for (id, parameter, change, true_m) in [
        ("nut-position-offset", "nut_offset", 0.1, 0.9),
        ("nut-position-scale", "nut_scale", -0.25, 0.6),
        ("nut-position-offset", "nut_offset", -5.0, 0.01 * machine.stroke_m().unwrap()),
        ("nut-position-scale", "nut_scale", 9.0, 0.99 * machine.stroke_m().unwrap()),
    ] {
        let with = machine.with_effect(library.iter().find(|e| e.id == id).unwrap()).unwrap();
        let (a, b) = (at(&machine, true_m, &[]), at(&with, 0.8, &[(parameter, change)]));
        assert!((a - b).norm() < 1e-10 * a.norm(), "{id}: {b} for {a}");
        assert!((at(&with, 0.8, &[]) - b).norm() > 1e-3 * b.norm(), "{id}");
    }
}

/// A nut at the last station of its screw, whose free end is not described, moves like any other.
#[test]
fn the_nut_of_a_screw_with_a_free_end_moves() {
    let text = r#"
[[point]]
name = "table"
motion = "translation"
mass_kg = 300.0
[[point]]
name = "left"
motion = "translation"
[[point]]
name = "screw"
motion = "translation"
[[shaft]]
name = "screw"
length_m = 2.0
diameter_m = 0.04
youngs_modulus_pa = 2e11
shear_modulus_pa = 7.75e10
density_kg_m3 = 7850.0
station = [{ at_m = 0.0, axial = "left" }, { at = "nut", axial = "screw" }]
[[joint]]
name = "bearing-left"
between = ["left", "ground"]
stiffness = 1e8
damping = 1e3
[[joint]]
name = "nut"
between = ["table", "screw"]
stiffness = 1e8
damping = 1e3
"#;
    let text = format!("title = \"free end\"\n{text}");
    let machine = config::read_machine_text("free", &text, &[], &[]).unwrap().machine;
    let library = effect_library().unwrap();
    let with = machine.with_effect(library.iter().find(|e| e.id == "nut-position-offset").unwrap()).unwrap();
    let (a, b) = (receptance(&machine, &[], 117.0), receptance(&with, &[("nut_offset", 0.0)], 117.0));
    assert!(a.norm() > 0.0 && (a - b).norm() < 1e-12 * a.norm(), "{b} for {a}");
    let moved = receptance(&with, &[("nut_offset", 0.3)], 117.0);
    assert!(moved.is_finite() && (moved - a).norm() > 1e-3 * a.norm(), "{moved}");
    // A nut that does not rotate has no lead: the effect is no candidate, alone or beside another one.
    let lead = library.iter().find(|e| e.id == "screw-lead").unwrap().clone();
    let set = measurement::read_set(measurement::BENCH).unwrap();
    let (fit, _) = set.split(None, &[]).unwrap();
    let fitter = fitter_of_modes(&fit);
    let alone = Hypothesis::nominal(machine.clone());
    let moved = library.iter().find(|e| e.id == "nut-position-offset").unwrap();
    for nominal in [alone.with(moved).unwrap(), alone] {
        let (apply, others) =
            diagnosis::hypotheses(&fitter, &machine, &nominal, std::slice::from_ref(&lead), &[]);
        assert!(
            apply.is_empty() && matches!(others[0].status, diagnosis::Status::NotApplicable(_)),
            "{others:?}"
        );
    }
}

/// The journals at the ends of a screw are of its material.
#[test]
fn another_modulus_is_that_of_the_journals_too() {
    let machine = config("configs/tian.toml").machine.with_tolerances(&[0.5, 1.0]).unwrap();
    let library = effect_library().unwrap();
    for id in ["screw-youngs-modulus", "screw-shear-modulus"] {
        let with = machine.with_effect(library.iter().find(|e| e.id == id).unwrap()).unwrap();
        let changed = with
            .shafts
            .iter()
            .zip(&machine.shafts)
            .filter(|(a, b)| a.youngs_modulus != b.youngs_modulus || a.shear_modulus != b.shear_modulus);
        assert_eq!(changed.count(), 3, "{id}");
    }
}

/// Journals are parts of the screw that bends, not further beams: whatever comes first, the effect or the
/// tolerances.
#[test]
fn a_screw_with_journals_bends_once() {
    let machine = config("configs/tian.toml").machine;
    let library = effect_library().unwrap();
    let bending = library.iter().find(|e| e.id == "screw-bending").unwrap();
    let first = machine.with_effect(bending).unwrap().with_tolerances(&[0.6]).unwrap();
    let last = machine.with_tolerances(&[0.6]).unwrap().with_effect(bending).unwrap();
    for machine in [first, last] {
        let bent: Vec<&str> = machine
            .shafts
            .iter()
            .filter(|shaft| shaft.bending.is_some())
            .map(|shaft| shaft.name.as_str())
            .collect();
        assert_eq!((bent, machine.shafts.len()), (vec!["screw"], 3));
    }
}

/// A screw that bends has its static stiffness in the matrices of the machine.
#[test]
fn limit_the_matrices_of_a_bending_screw_are_those_of_its_receptance_at_rest() {
    let machine = config("configs/tian.toml").machine;
    let library = effect_library().unwrap();
    let with = machine.with_effect(library.iter().find(|e| e.id == "screw-bending").unwrap()).unwrap();
    let mut values = with.start();
    for (id, value) in [("e_bend", 0.02), ("a_bend", 0.05), ("k_lateral", 1e5), ("eta_bend", 0.0)] {
        values[with.parameter(id).unwrap()] = value;
    }
    let at_rest =
        matrices(&with, &values, &Operating::at_nut(0.6), 1).unwrap().static_stiffness("table").unwrap();
    let structure = table_structure(&with, RodModel::Exact);
    let mut network = structure.empty_model();
    network.update(&with, &values, &Operating::at_nut(0.6));
    let receptance = network.receptance(std::f64::consts::TAU * 0.05, &mut structure.workspace());
    assert!((at_rest * receptance.re - 1.0).abs() < 1e-4, "{at_rest:e} for {:e}", receptance.re.recip());
}

/// A nut off the axis bends the screw statically by e²/(3·E·I/a + 3·E·I/b) in series with the nut's
/// stiffness, where it holds the screw laterally and the bearings are hinges.
#[test]
fn limit_an_eccentric_nut_bends_the_screw_like_a_static_beam() {
    let machine = config("configs/tian.toml").machine;
    let library = effect_library().unwrap();
    let with = machine.with_effect(library.iter().find(|e| e.id == "screw-bending").unwrap()).unwrap();
    let (start, operating) = (machine.start(), Operating::at_nut(1.0));
    let screw = machine.shafts.iter().find(|shaft| shaft.name == "screw").unwrap();
    let at = |value: &machine::Value| value.at(&start, &operating);
    let (length_m, rigidity) =
        (at(&screw.length), at(&screw.youngs_modulus) * 0.5 * screw.section(&start, &operating).1);
    let eccentricity_m = 0.005;
    let hinges = [
        ("e_bend", eccentricity_m),
        ("k_lateral", 1e13),
        ("clamping_left", 1e-9),
        ("clamping_right", 1e-9),
        ("eta_bend", 0.0),
    ];
    let added = receptance(&with, &hinges, 0.5) - receptance(&machine, &[], 0.5);
    let expected =
        eccentricity_m * eccentricity_m / (3.0 * rigidity / 1.0 + 3.0 * rigidity / (length_m - 1.0));
    assert!((added.re / expected - 1.0).abs() < 1e-3, "{added} for {expected}");
}

/// A bed on a foundation without stiffness gives the machine one more rigid-body mode than a fixed bed.
#[test]
fn limit_a_bed_without_foundation_adds_a_rigid_body_mode() {
    let machine = config("configs/tian-as-published.toml").machine;
    let library = effect_library().unwrap();
    let bed = library.iter().find(|e| e.id == "bed-compliance").unwrap();
    let with = machine.with_effect(bed).unwrap();
    let structure = table_structure(&with, RodModel::Exact);
    let mut values = with.start();
    values[with.parameter("k_bed").unwrap()] = 0.0;
    let mut network = structure.empty_model();
    network.update(&with, &values, &Operating::at_nut(1.0));
    let modes = undamped_modes(&network, 200.0, &mut structure.workspace());
    // The rotor turns freely, together with the table, and the bed drifts.
    assert_eq!(
        modes.iter().filter(|m| m.frequency_hz == 0.0).count(),
        2,
        "{:?}",
        modes.iter().map(|m| m.frequency_hz).collect::<Vec<_>>()
    );
}
