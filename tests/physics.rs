//! Properties that hold for every machine, on random ones: a screw with bearings and nut, rotor and coupling,
//! bodies on springs and dampers.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::sync::Arc;

use config::read_machine_text;
use dynamics::model::{AssembledModel, RodModel, Structure, Workspace, undamped_modes};
use machine::{Machine, Operating};
use nalgebra::DMatrix;
use num_complex::Complex64;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A spring and damper between two points, given by name, or between a point and the ground.
#[derive(Debug, Clone)]
struct Spring {
    ends: [String; 2],
    stiffness: f64,
    damping: f64,
    /// Rotational, N·m/rad.
    rotational: bool,
}

/// A machine as numbers, which can be scaled, mirrored and written as a configuration.
#[derive(Debug, Clone)]
struct MachineSpec {
    length_m: f64,
    diameter_m: f64,
    lead_m: f64,
    nut_m: f64,
    youngs_pa: f64,
    shear_pa: f64,
    density: f64,
    loss: f64,
    /// Name, mass (kg) or inertia (kg·m²) of points with inertia, and whether they rotate.
    bodies: Vec<(String, f64, bool)>,
    springs: Vec<Spring>,
    /// Stiffness and damping between table and screw.
    nut: (f64, f64),
    mirrored: bool,
}

/// Massless points of the screw, and whether they rotate.
const SCREW: [(&str, bool); 6] = [
    ("left", false),
    ("screw", false),
    ("right", false),
    ("left-angle", true),
    ("angle", true),
    ("right-angle", true),
];

impl MachineSpec {
    /// Returns the machine read from its configuration.
    fn machine(&self) -> Machine {
        let mut text = String::from("title = \"random\"\n");
        for (name, rotational) in SCREW {
            let motion = if rotational { "rotation" } else { "translation" };
            let _ = writeln!(text, "[[point]]\nname = \"{name}\"\nmotion = \"{motion}\"");
        }
        for (name, inertia, rotational) in &self.bodies {
            let (motion, key) =
                if *rotational { ("rotation", "inertia_kg_m2") } else { ("translation", "mass_kg") };
            let _ =
                writeln!(text, "[[point]]\nname = \"{name}\"\nmotion = \"{motion}\"\n{key} = {inertia:e}");
        }
        let (first, last) = if self.mirrored { ("right", "left") } else { ("left", "right") };
        let _ = writeln!(
            text,
            "[[shaft]]\nname = \"screw\"\nlength_m = {:e}\ndiameter_m = {:e}\nyoungs_modulus_pa = {:e}\nshear_modulus_pa = {:e}\n\
             density_kg_m3 = {:e}\nloss_factor = {:e}\nstation = [{{ at = \"start\", axial = \"{first}\", torsion = \"{first}-angle\" }}, \
             {{ at = \"nut\", axial = \"screw\", torsion = \"angle\" }}, {{ at = \"end\", axial = \"{last}\", torsion = \"{last}-angle\" }}]",
            self.length_m, self.diameter_m, self.youngs_pa, self.shear_pa, self.density, self.loss
        );
        let joint = |text: &mut String, name: String, [a, b]: [&str; 2], k: f64, c: f64, screw: &str| {
            let _ = writeln!(
                text,
                "[[joint]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nstiffness = {k:e}\ndamping = {c:e}\n{screw}"
            );
        };
        let screw = format!("screw = {{ angle = \"angle\", lead_m = {:e} }}", self.lead_m);
        joint(&mut text, "nut".into(), ["table", "screw"], self.nut.0, self.nut.1, &screw);
        for (at, s) in self.springs.iter().enumerate() {
            joint(&mut text, format!("s{at}"), [&s.ends[0], &s.ends[1]], s.stiffness, s.damping, "");
        }
        read_machine_text("random.toml", &text, &[], &[]).unwrap_or_else(|e| panic!("{e}\n{text}")).machine
    }

    fn operating(&self) -> Operating {
        Operating::at_nut(if self.mirrored { self.length_m - self.nut_m } else { self.nut_m })
    }

    fn network(&self, response: &str, excitation: &str, rods: RodModel) -> (AssembledModel, Workspace) {
        let machine = self.machine();
        let point = |name: &str| machine.point(name).unwrap();
        let structure = Arc::new(Structure::new(&machine, point(response), point(excitation), rods).unwrap());
        let mut network = structure.empty_model();
        network.update(&machine, &machine.start(), &self.operating());
        (network, structure.workspace())
    }

    fn receptance(&self, response: &str, excitation: &str, f: f64, rods: RodModel) -> Complex64 {
        let (network, mut work) = self.network(response, excitation, rods);
        network.receptance(TAU * f, &mut work)
    }

    /// Returns the undamped natural frequencies up to 1500 Hz.
    fn frequencies_hz(&self, rods: RodModel) -> Vec<f64> {
        let (network, mut work) = self.network("table", "table", rods);
        undamped_modes(&network, 1500.0, &mut work).iter().map(|m| m.frequency_hz).collect()
    }

    fn names(&self) -> Vec<&str> {
        SCREW.iter().map(|(name, _)| *name).chain(self.bodies.iter().map(|b| b.0.as_str())).collect()
    }

    fn is_rotational(&self, name: &str) -> bool {
        SCREW.iter().any(|(n, rotational)| *n == name && *rotational)
            || self.bodies.iter().any(|(n, _, rotational)| n == name && *rotational)
    }

    /// Multiplies all stiffnesses by `k`, all dampings by `c` and all inertias by `m`.
    fn scaled(&self, k: f64, c: f64, m: f64) -> Self {
        let mut spec = self.clone();
        spec.youngs_pa *= k;
        spec.shear_pa *= k;
        spec.density *= m;
        spec.bodies.iter_mut().for_each(|b| b.1 *= m);
        spec.nut = (spec.nut.0 * k, spec.nut.1 * c);
        spec.springs.iter_mut().for_each(|s| (s.stiffness, s.damping) = (s.stiffness * k, s.damping * c));
        spec
    }

    /// Converts to a unit of length of which `per_m` make a metre. Units of force, time and angle are
    /// unchanged.
    fn in_length(&self, per_m: f64) -> Self {
        let mut spec = self.clone();
        (spec.length_m, spec.diameter_m, spec.lead_m, spec.nut_m) =
            (spec.length_m * per_m, spec.diameter_m * per_m, spec.lead_m * per_m, spec.nut_m * per_m);
        (spec.youngs_pa, spec.shear_pa) = (spec.youngs_pa / per_m.powi(2), spec.shear_pa / per_m.powi(2));
        spec.density /= per_m.powi(4);
        spec.bodies.iter_mut().for_each(|b| b.1 *= if b.2 { per_m } else { 1.0 / per_m });
        spec.nut = (spec.nut.0 / per_m, spec.nut.1 / per_m);
        for s in &mut spec.springs {
            let by = if s.rotational { per_m } else { 1.0 / per_m };
            (s.stiffness, s.damping) = (s.stiffness * by, s.damping * by);
        }
        spec
    }
}

fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.log10()..to.log10()).prop_map(|x| 10_f64.powf(x))
}

/// Generates a random machine; if `held`, bearings and rotor are connected to the ground.
fn random_machine(held: bool) -> impl Strategy<Value = MachineSpec> {
    let screw = (
        0.3..3.0_f64,
        0.016..0.08_f64,
        0.005..0.05_f64,
        0.1..0.9_f64,
        prop_oneof![Just(0.0), 1e-4..0.02_f64],
    );
    let body = (decades(0.1, 500.0), decades(1e6, 1e9), decades(1e-6, 1e-3), any::<prop::sample::Index>());
    let joints = (
        decades(1e7, 1e9),
        decades(1e7, 1e9),
        decades(1e7, 1e9),
        decades(1e2, 1e5),
        decades(1e3, 1e6),
        decades(1e-6, 1e-3),
    );
    (screw, decades(20.0, 2000.0), decades(1e-4, 1e-1), prop::collection::vec(body, 0..4), joints).prop_map(
        move |(
            (length_m, diameter_m, lead_m, share, loss),
            table,
            rotor,
            bodies,
            (left, right, nut, coupling, hold, per_s),
        )| {
            let spring = |a: &str, b: &str, stiffness: f64, rotational: bool| Spring {
                ends: [a.into(), b.into()],
                stiffness,
                damping: stiffness * per_s,
                rotational,
            };
            let mut spec = MachineSpec {
                length_m,
                diameter_m,
                lead_m,
                nut_m: share * length_m,
                youngs_pa: 2.1e11,
                shear_pa: 8e10,
                density: 7850.0,
                loss,
                bodies: vec![("table".into(), table, false), ("rotor".into(), rotor, true)],
                springs: vec![spring("rotor", "left-angle", coupling, true)],
                nut: (nut, nut * per_s),
                mirrored: false,
            };
            if held {
                spec.springs.push(spring("left", "ground", left, false));
                spec.springs.push(spring("right", "ground", right, false));
                spec.springs.push(spring("rotor", "ground", hold, true));
            }
            for (at, (mass, stiffness, own_per_s, on)) in bodies.into_iter().enumerate() {
                let mut supports: Vec<String> =
                    ["left", "screw", "right", "table"].map(String::from).to_vec();
                supports.extend((0..at).map(|i| format!("body-{i}")));
                let (name, on) = (format!("body-{at}"), &supports[on.index(supports.len())]);
                spec.springs
                    .push(Spring { damping: stiffness * own_per_s, ..spring(&name, on, stiffness, false) });
                spec.bodies.push((name, mass, false));
            }
            spec
        },
    )
}

fn rods() -> impl Strategy<Value = RodModel> {
    prop_oneof![Just(RodModel::Exact), (1..12_usize).prop_map(RodModel::Lumped)]
}

/// Whether two receptances are equal, relative to themselves or to the scale of their driving points.
fn same(a: Complex64, b: Complex64, scale: f64) -> bool {
    (a - b).norm() <= 1e-8 * a.norm().max(1e-3 * scale)
}

/// Assembles static stiffness and inertia, in the order of `names`, from springs and bodies, independently of
/// the model.
fn reference_matrices(spec: &MachineSpec) -> (DMatrix<f64>, DMatrix<f64>) {
    let names = spec.names();
    let index = |name: &str| names.iter().position(|n| *n == name);
    let (mut k, mut m) = (DMatrix::zeros(names.len(), names.len()), DMatrix::zeros(names.len(), names.len()));
    let mut add = |on: &[(&str, f64)], stiffness: f64| {
        for (a, x) in on {
            for (b, y) in on {
                if let (Some(i), Some(j)) = (index(a), index(b)) {
                    k[(i, j)] += stiffness * x * y;
                }
            }
        }
    };
    let area = PI / 4.0 * spec.diameter_m.powi(2);
    let polar = PI / 32.0 * spec.diameter_m.powi(4);
    for (a, b, length) in [("left", "screw", spec.nut_m), ("screw", "right", spec.length_m - spec.nut_m)] {
        add(&[(a, 1.0), (b, -1.0)], spec.youngs_pa * area / length);
        let (a, b) = if a == "left" { ("left-angle", "angle") } else { ("angle", "right-angle") };
        add(&[(a, 1.0), (b, -1.0)], spec.shear_pa * polar / length);
    }
    add(&[("table", 1.0), ("screw", -1.0), ("angle", -spec.lead_m / TAU)], spec.nut.0);
    spec.springs.iter().for_each(|s| add(&[(&s.ends[0], 1.0), (&s.ends[1], -1.0)], s.stiffness));
    for (name, inertia, _) in &spec.bodies {
        m[(index(name).unwrap(), index(name).unwrap())] = *inertia;
    }
    // A rigid rod has half its inertia at each end.
    for (a, b, of) in [("left", "right", area), ("left-angle", "right-angle", polar)] {
        for end in [a, b] {
            m[(index(end).unwrap(), index(end).unwrap())] += 0.5 * spec.density * of * spec.length_m;
        }
    }
    (k, m)
}

fn config(cases: u32, seed: u64) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(seed),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(100, 41))]

    /// H_ij = H_ji for every pair of points. At driving points Im H ≤ 0, so the real part of the mobility,
    /// −ω·Im H, is not negative.
    #[test]
    fn limit_every_machine_is_reciprocal_and_passive(
        spec in prop_oneof![random_machine(true), random_machine(false)],
        rods in rods(),
        f in 1.0..1500.0_f64,
    ) {
        let names = spec.names();
        let driving: Vec<f64> = names.iter().map(|n| {
            let h = spec.receptance(n, n, f, rods);
            assert!(h.im <= 1e-12 * h.norm(), "{n}: {h}");
            h.norm()
        }).collect();
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names[..i].iter().enumerate() {
                let (forward, reverse) = (spec.receptance(a, b, f, rods), spec.receptance(b, a, f, rods));
                prop_assert!(same(forward, reverse, (driving[i] * driving[j]).sqrt()), "{a}/{b}: {forward} and {reverse}");
            }
        }
    }

    /// A machine mirrored end for end, with its nut, has the same receptances at every pair of points.
    #[test]
    fn limit_a_mirrored_machine_has_the_same_receptances(spec in random_machine(true), rods in rods(), f in 1.0..1500.0_f64) {
        let mirrored = MachineSpec { mirrored: true, ..spec.clone() };
        let scale = |n: &str| spec.receptance(n, n, f, rods).norm();
        for (a, b) in [("table", "table"), ("rotor", "rotor"), ("left", "left"), ("table", "rotor"), ("left", "right"), ("right-angle", "table")] {
            let (original, image) = (spec.receptance(a, b, f, rods), mirrored.receptance(a, b, f, rods));
            prop_assert!(same(original, image, (scale(a) * scale(b)).sqrt()), "{a}/{b}: {original} and {image}");
        }
    }

    /// Receptances scale with units: all stiffnesses, dampings and inertias times s give 1/s; time scaled by
    /// a; millimetres for metres.
    #[test]
    fn limit_receptances_scale_with_units(
        spec in random_machine(true),
        rods in rods(),
        f in 1.0..1500.0_f64,
        s in decades(0.01, 100.0),
        a in 0.2..5.0_f64,
    ) {
        // The loss of a material is defined at 100 Hz, so it does not scale with time.
        let lossless = MachineSpec { loss: 0.0, ..spec.clone() };
        let (heavier, faster, millimetres) = (spec.scaled(s, s, s), lossless.scaled(a * a, a, 1.0), spec.in_length(1000.0));
        for (x, y) in [("table", "table"), ("rotor", "rotor"), ("table", "rotor"), ("screw", "table")] {
            let h = spec.receptance(x, y, f, rods);
            let scale = (spec.receptance(x, x, f, rods).norm() * spec.receptance(y, y, f, rods).norm()).sqrt();
            prop_assert!(same(h, heavier.receptance(x, y, f, rods) * s, scale), "times {s}: {x}/{y}");
            let slow = lossless.receptance(x, y, f, rods);
            prop_assert!(same(slow, faster.receptance(x, y, f * a, rods) * a * a, scale), "time {a}: {x}/{y}");
            let unit = match (spec.is_rotational(x), spec.is_rotational(y)) {
                (false, false) => 1000.0,
                (true, true) => 1e-3,
                _ => 1.0,
            };
            prop_assert!(same(h, millimetres.receptance(x, y, f, rods) / unit, scale), "mm: {x}/{y}");
        }
        let hz = spec.frequencies_hz(rods);
        for (other, by) in [(heavier, 1.0), (millimetres, 1.0)] {
            let other = other.frequencies_hz(rods);
            prop_assert_eq!(hz.len(), other.len());
            prop_assert!(hz.iter().zip(&other).all(|(x, y)| (x * by - y).abs() <= 1e-8 * y), "{:?} {:?}", hz, other);
        }
    }

    /// An added spring raises each undamped frequency at most to the next one; an added mass lowers it at
    /// most to the previous one.
    #[test]
    fn limit_frequencies_rise_with_a_spring_and_fall_with_a_mass(
        spec in prop_oneof![random_machine(true), random_machine(false)],
        rods in rods(),
        (a, b) in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
        stiffness in decades(1e5, 1e10),
        mass in decades(0.1, 1000.0),
    ) {
        let hz = spec.frequencies_hz(rods);
        let translations: Vec<&str> = spec.names().into_iter().filter(|n| !spec.is_rotational(n)).chain(["ground"]).collect();
        let (a, b) = (translations[a.index(translations.len() - 1)], translations[b.index(translations.len())]);
        if a != b {
            let mut stiffer = spec.clone();
            stiffer.springs.push(Spring { ends: [a.into(), b.into()], stiffness, damping: 0.0, rotational: false });
            let higher = stiffer.frequencies_hz(rods);
            prop_assert!(higher.len() <= hz.len() && higher.len() + 1 >= hz.len(), "{:?} {:?}", hz, higher);
            prop_assert!(hz.iter().zip(&higher).all(|(x, y)| *y >= x * (1.0 - 1e-9)), "{}-{}: {:?} {:?}", a, b, hz, higher);
            prop_assert!(hz.iter().skip(1).zip(&higher).all(|(x, y)| *y <= x * (1.0 + 1e-9)), "{}-{}: {:?} {:?}", a, b, hz, higher);
        }
        let mut heavier = spec.clone();
        let at = spec.bodies.iter().position(|body| body.0 == a).unwrap_or(0);
        heavier.bodies[at].1 += mass;
        let lower = heavier.frequencies_hz(rods);
        prop_assert!(lower.len() >= hz.len() && lower.len() <= hz.len() + 1, "{:?} {:?}", hz, lower);
        prop_assert!(hz.iter().zip(&lower).all(|(x, y)| *y <= x * (1.0 + 1e-9)), "{:?} {:?}", hz, lower);
        prop_assert!(hz.iter().zip(lower.iter().skip(1)).all(|(x, y)| *y >= x * (1.0 - 1e-9)), "{:?} {:?}", hz, lower);
    }

    /// Far below its first frequency a held machine has the static compliance of its springs.
    #[test]
    fn limit_a_held_machine_has_its_static_compliance(spec in random_machine(true), rods in rods()) {
        let spec = MachineSpec { loss: 0.0, ..spec };
        let compliance = reference_matrices(&spec).0.try_inverse().unwrap();
        let first = spec.frequencies_hz(rods).first().copied().unwrap_or(1500.0);
        let names = spec.names();
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate() {
                let h = spec.receptance(a, b, 1e-4 * first, rods).re;
                let scale = (compliance[(i, i)] * compliance[(j, j)]).sqrt();
                prop_assert!((h - compliance[(i, j)]).abs() <= 1e-6 * scale, "{a}/{b}: {h} and {}", compliance[(i, j)]);
            }
        }
    }

    /// A free machine has two rigid-body modes, common travel and screw rotation, coupled by the lead: H →
    /// −φᵀ(ΦᵀMΦ)⁻¹φ/ω².
    #[test]
    fn limit_a_free_machine_has_two_rigid_body_modes(spec in random_machine(false), rods in rods()) {
        let spec = MachineSpec { loss: 0.0, ..spec };
        let hz = spec.frequencies_hz(rods);
        prop_assert!(hz.len() >= 2 && hz[..2] == [0.0, 0.0] && hz.get(2).is_none_or(|f| *f > 0.0), "{:?}", hz);
        let names = spec.names();
        // Columns: unit travel of all translations; unit angle of the screw, which moves the table and the
        // bodies on it by the lead.
        let travels = |name: &str| on_table(&spec, name);
        let shapes = DMatrix::from_fn(names.len(), 2, |i, j| match (spec.is_rotational(names[i]), j) {
            (false, 0) | (true, 1) => 1.0,
            (false, _) if travels(names[i]) => spec.lead_m / TAU,
            _ => 0.0,
        });
        let mass = reference_matrices(&spec).1;
        let rigid = &shapes * (shapes.transpose() * mass * &shapes).try_inverse().unwrap() * shapes.transpose();
        // The elastic part goes with ω² and is eliminated by a second frequency. Cancellation of stiffnesses
        // much larger than ω²·M limits the accuracy.
        let omega = TAU * 3e-3 * hz.get(2).copied().unwrap_or(1500.0);
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate() {
                let at = |omega: f64| spec.receptance(a, b, omega / TAU, rods).re * (-omega * omega);
                let h = (4.0 * at(omega) - at(2.0 * omega)) / 3.0;
                let scale = (rigid[(i, i)] * rigid[(j, j)]).sqrt();
                prop_assert!((h - rigid[(i, j)]).abs() <= 1e-5 * scale, "{a}/{b}: {h} and {}", rigid[(i, j)]);
            }
        }
    }
}

/// Whether a body is the table or attached to it, directly or through others.
fn on_table(spec: &MachineSpec, name: &str) -> bool {
    let below = spec.springs.iter().find(|s| s.ends[0] == name && name.starts_with("body"));
    name == "table" || below.is_some_and(|s| on_table(spec, &s.ends[1]))
}
