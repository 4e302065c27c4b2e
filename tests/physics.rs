//! What holds for every machine, on random ones: a screw between bearings and a nut, rotor and coupling, bodies on springs and dampers.

use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::sync::Arc;

use jointid::config::read_machine_text;
use jointid::machine::{Machine, Operating};
use jointid::model::{AssembledModel, Rods, Structure, Workspace, undamped_modes};
use nalgebra::DMatrix;
use num_complex::Complex64;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A spring and damper between two points, by name, or a point and the ground.
#[derive(Debug, Clone)]
struct Spring {
    ends: [String; 2],
    stiffness: f64,
    damping: f64,
    /// Rotational, N·m/rad.
    turns: bool,
}

/// A machine in numbers, so that it can be scaled, mirrored, and written as a configuration.
#[derive(Debug, Clone)]
struct Made {
    length_m: f64,
    diameter_m: f64,
    lead_m: f64,
    nut_m: f64,
    youngs_pa: f64,
    shear_pa: f64,
    density: f64,
    loss: f64,
    /// Mass (kg) or inertia (kg·m²) of points with one, by name; whether it turns.
    bodies: Vec<(String, f64, bool)>,
    springs: Vec<Spring>,
    /// Stiffness and damping between table and screw.
    nut: (f64, f64),
    mirrored: bool,
}

/// Points of the screw without a mass of their own.
const SCREW: [(&str, bool); 6] =
    [("left", false), ("screw", false), ("right", false), ("left-angle", true), ("angle", true), ("right-angle", true)];

impl Made {
    /// Its configuration.
    fn machine(&self) -> Machine {
        let mut text = String::from("title = \"random\"\n");
        for (name, turns) in SCREW {
            let motion = if turns { "rotation" } else { "translation" };
            let _ = writeln!(text, "[[point]]\nname = \"{name}\"\nmotion = \"{motion}\"");
        }
        for (name, inertia, turns) in &self.bodies {
            let (motion, key) = if *turns { ("rotation", "inertia_kg_m2") } else { ("translation", "mass_kg") };
            let _ = writeln!(text, "[[point]]\nname = \"{name}\"\nmotion = \"{motion}\"\n{key} = {inertia:e}");
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
            let _ =
                writeln!(text, "[[joint]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nstiffness = {k:e}\ndamping = {c:e}\n{screw}");
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

    fn network(&self, response: &str, excitation: &str, rods: Rods) -> (AssembledModel, Workspace) {
        let machine = self.machine();
        let point = |name: &str| machine.point(name).unwrap();
        let structure = Arc::new(Structure::new(&machine, point(response), point(excitation), rods).unwrap());
        let mut network = structure.network();
        network.update(&machine, &machine.start(), &self.operating());
        (network, structure.workspace())
    }

    fn receptance(&self, response: &str, excitation: &str, f: f64, rods: Rods) -> Complex64 {
        let (network, mut work) = self.network(response, excitation, rods);
        network.receptance(TAU * f, &mut work)
    }

    /// Undamped natural frequencies up to 1500 Hz.
    fn frequencies_hz(&self, rods: Rods) -> Vec<f64> {
        let (network, mut work) = self.network("table", "table", rods);
        undamped_modes(&network, 1500.0, &mut work).iter().map(|m| m.frequency_hz).collect()
    }

    fn names(&self) -> Vec<&str> {
        SCREW.iter().map(|(name, _)| *name).chain(self.bodies.iter().map(|b| b.0.as_str())).collect()
    }

    fn turns(&self, name: &str) -> bool {
        SCREW.iter().any(|(n, turns)| *n == name && *turns) || self.bodies.iter().any(|(n, _, turns)| n == name && *turns)
    }

    /// All stiffnesses and dampings times `k`, `c`, all inertias times `m`.
    fn scaled(&self, k: f64, c: f64, m: f64) -> Self {
        let mut made = self.clone();
        made.youngs_pa *= k;
        made.shear_pa *= k;
        made.density *= m;
        made.bodies.iter_mut().for_each(|b| b.1 *= m);
        made.nut = (made.nut.0 * k, made.nut.1 * c);
        made.springs.iter_mut().for_each(|s| (s.stiffness, s.damping) = (s.stiffness * k, s.damping * c));
        made
    }

    /// In another unit of length, of which `per_m` make a metre; force, time and angle keep theirs.
    fn in_length(&self, per_m: f64) -> Self {
        let mut made = self.clone();
        (made.length_m, made.diameter_m, made.lead_m, made.nut_m) =
            (made.length_m * per_m, made.diameter_m * per_m, made.lead_m * per_m, made.nut_m * per_m);
        (made.youngs_pa, made.shear_pa) = (made.youngs_pa / per_m.powi(2), made.shear_pa / per_m.powi(2));
        made.density /= per_m.powi(4);
        made.bodies.iter_mut().for_each(|b| b.1 *= if b.2 { per_m } else { 1.0 / per_m });
        made.nut = (made.nut.0 / per_m, made.nut.1 / per_m);
        for s in &mut made.springs {
            let by = if s.turns { per_m } else { 1.0 / per_m };
            (s.stiffness, s.damping) = (s.stiffness * by, s.damping * by);
        }
        made
    }
}

fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from.log10()..to.log10()).prop_map(|x| 10_f64.powf(x))
}

/// `held`: bearings and rotor stand on the ground.
fn made(held: bool) -> impl Strategy<Value = Made> {
    let screw = (0.3..3.0_f64, 0.016..0.08_f64, 0.005..0.05_f64, 0.1..0.9_f64, prop_oneof![Just(0.0), 1e-4..0.02_f64]);
    let body = (decades(0.1, 500.0), decades(1e6, 1e9), decades(1e-6, 1e-3), any::<prop::sample::Index>());
    let joints = (decades(1e7, 1e9), decades(1e7, 1e9), decades(1e7, 1e9), decades(1e2, 1e5), decades(1e3, 1e6), decades(1e-6, 1e-3));
    (screw, decades(20.0, 2000.0), decades(1e-4, 1e-1), prop::collection::vec(body, 0..4), joints).prop_map(
        move |((length_m, diameter_m, lead_m, share, loss), table, rotor, bodies, (left, right, nut, coupling, hold, per_s))| {
            let spring = |a: &str, b: &str, stiffness: f64, turns: bool| Spring {
                ends: [a.into(), b.into()],
                stiffness,
                damping: stiffness * per_s,
                turns,
            };
            let mut made = Made {
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
                made.springs.push(spring("left", "ground", left, false));
                made.springs.push(spring("right", "ground", right, false));
                made.springs.push(spring("rotor", "ground", hold, true));
            }
            for (at, (mass, stiffness, own_per_s, on)) in bodies.into_iter().enumerate() {
                let mut there: Vec<String> = ["left", "screw", "right", "table"].map(String::from).to_vec();
                there.extend((0..at).map(|i| format!("body-{i}")));
                let (name, on) = (format!("body-{at}"), &there[on.index(there.len())]);
                made.springs.push(Spring { damping: stiffness * own_per_s, ..spring(&name, on, stiffness, false) });
                made.bodies.push((name, mass, false));
            }
            made
        },
    )
}

fn rods() -> impl Strategy<Value = Rods> {
    prop_oneof![Just(Rods::Exact), (1..12_usize).prop_map(Rods::Lumped)]
}

/// Whether two receptances are the same, seen beside what the driving points of their machine are.
fn same(a: Complex64, b: Complex64, scale: f64) -> bool {
    (a - b).norm() <= 1e-8 * a.norm().max(1e-3 * scale)
}

/// Static stiffness by springs alone, and inertia, of coordinates in the order of `names`: another way than the model's.
fn by_hand(made: &Made) -> (DMatrix<f64>, DMatrix<f64>) {
    let names = made.names();
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
    let area = PI / 4.0 * made.diameter_m.powi(2);
    let polar = PI / 32.0 * made.diameter_m.powi(4);
    for (a, b, length) in [("left", "screw", made.nut_m), ("screw", "right", made.length_m - made.nut_m)] {
        add(&[(a, 1.0), (b, -1.0)], made.youngs_pa * area / length);
        let (a, b) = if a == "left" { ("left-angle", "angle") } else { ("angle", "right-angle") };
        add(&[(a, 1.0), (b, -1.0)], made.shear_pa * polar / length);
    }
    add(&[("table", 1.0), ("screw", -1.0), ("angle", -made.lead_m / TAU)], made.nut.0);
    made.springs.iter().for_each(|s| add(&[(&s.ends[0], 1.0), (&s.ends[1], -1.0)], s.stiffness));
    for (name, inertia, _) in &made.bodies {
        m[(index(name).unwrap(), index(name).unwrap())] = *inertia;
    }
    // A rod that moves as one: half at each end.
    for (a, b, of) in [("left", "right", area), ("left-angle", "right-angle", polar)] {
        for end in [a, b] {
            m[(index(end).unwrap(), index(end).unwrap())] += 0.5 * made.density * of * made.length_m;
        }
    }
    (k, m)
}

fn config(cases: u32, seed: u64) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, rng_seed: RngSeed::Fixed(seed), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(100, 41))]

    /// H_ij = H_ji for every pair of points; at a driving point Im H ≤ 0, and with it the real part of the mobility, −ω·Im H, is not negative.
    #[test]
    fn limit_every_machine_is_reciprocal_and_passive(made in prop_oneof![made(true), made(false)], rods in rods(), f in 1.0..1500.0_f64) {
        let names = made.names();
        let driving: Vec<f64> = names.iter().map(|n| {
            let h = made.receptance(n, n, f, rods);
            assert!(h.im <= 1e-12 * h.norm(), "{n}: {h}");
            h.norm()
        }).collect();
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names[..i].iter().enumerate() {
                let (there, back) = (made.receptance(a, b, f, rods), made.receptance(b, a, f, rods));
                prop_assert!(same(there, back, (driving[i] * driving[j]).sqrt()), "{a}/{b}: {there} and {back}");
            }
        }
    }

    /// Mirrored end for end, nut and all, a machine answers alike at every pair of points.
    #[test]
    fn limit_a_mirrored_machine_answers_alike(made in made(true), rods in rods(), f in 1.0..1500.0_f64) {
        let mirrored = Made { mirrored: true, ..made.clone() };
        let scale = |n: &str| made.receptance(n, n, f, rods).norm();
        for (a, b) in [("table", "table"), ("rotor", "rotor"), ("left", "left"), ("table", "rotor"), ("left", "right"), ("right-angle", "table")] {
            let (here, there) = (made.receptance(a, b, f, rods), mirrored.receptance(a, b, f, rods));
            prop_assert!(same(here, there, (scale(a) * scale(b)).sqrt()), "{a}/{b}: {here} and {there}");
        }
    }

    /// Units: all stiffnesses, dampings and inertias times s give 1/s; a clock that runs a times faster; millimetres for metres.
    #[test]
    fn limit_units_do_not_matter(made in made(true), rods in rods(), f in 1.0..1500.0_f64, s in decades(0.01, 100.0), a in 0.2..5.0_f64) {
        // A material's loss is stated at 100 Hz, and so knows the clock.
        let lossless = Made { loss: 0.0, ..made.clone() };
        let (heavier, faster, millimetres) = (made.scaled(s, s, s), lossless.scaled(a * a, a, 1.0), made.in_length(1000.0));
        for (x, y) in [("table", "table"), ("rotor", "rotor"), ("table", "rotor"), ("screw", "table")] {
            let h = made.receptance(x, y, f, rods);
            let scale = (made.receptance(x, x, f, rods).norm() * made.receptance(y, y, f, rods).norm()).sqrt();
            prop_assert!(same(h, heavier.receptance(x, y, f, rods) * s, scale), "times {s}: {x}/{y}");
            let slow = lossless.receptance(x, y, f, rods);
            prop_assert!(same(slow, faster.receptance(x, y, f * a, rods) * a * a, scale), "time {a}: {x}/{y}");
            let unit = match (made.turns(x), made.turns(y)) {
                (false, false) => 1000.0,
                (true, true) => 1e-3,
                _ => 1.0,
            };
            prop_assert!(same(h, millimetres.receptance(x, y, f, rods) / unit, scale), "mm: {x}/{y}");
        }
        let hz = made.frequencies_hz(rods);
        for (other, by) in [(heavier, 1.0), (millimetres, 1.0)] {
            let other = other.frequencies_hz(rods);
            prop_assert_eq!(hz.len(), other.len());
            prop_assert!(hz.iter().zip(&other).all(|(x, y)| (x * by - y).abs() <= 1e-8 * y), "{:?} {:?}", hz, other);
        }
    }

    /// One spring more lifts every undamped frequency up to the next one at most, one mass more lowers it to the one before at most.
    #[test]
    fn limit_frequencies_rise_with_a_spring_and_fall_with_a_mass(
        made in prop_oneof![made(true), made(false)],
        rods in rods(),
        (a, b) in (any::<prop::sample::Index>(), any::<prop::sample::Index>()),
        stiffness in decades(1e5, 1e10),
        mass in decades(0.1, 1000.0),
    ) {
        let hz = made.frequencies_hz(rods);
        let along: Vec<&str> = made.names().into_iter().filter(|n| !made.turns(n)).chain(["ground"]).collect();
        let (a, b) = (along[a.index(along.len() - 1)], along[b.index(along.len())]);
        if a != b {
            let mut stiffer = made.clone();
            stiffer.springs.push(Spring { ends: [a.into(), b.into()], stiffness, damping: 0.0, turns: false });
            let higher = stiffer.frequencies_hz(rods);
            prop_assert!(higher.len() <= hz.len() && higher.len() + 1 >= hz.len(), "{:?} {:?}", hz, higher);
            prop_assert!(hz.iter().zip(&higher).all(|(x, y)| *y >= x * (1.0 - 1e-9)), "{}-{}: {:?} {:?}", a, b, hz, higher);
            prop_assert!(hz.iter().skip(1).zip(&higher).all(|(x, y)| *y <= x * (1.0 + 1e-9)), "{}-{}: {:?} {:?}", a, b, hz, higher);
        }
        let mut heavier = made.clone();
        let at = made.bodies.iter().position(|body| body.0 == a).unwrap_or(0);
        heavier.bodies[at].1 += mass;
        let lower = heavier.frequencies_hz(rods);
        prop_assert!(lower.len() >= hz.len() && lower.len() <= hz.len() + 1, "{:?} {:?}", hz, lower);
        prop_assert!(hz.iter().zip(&lower).all(|(x, y)| *y <= x * (1.0 + 1e-9)), "{:?} {:?}", hz, lower);
        prop_assert!(hz.iter().zip(lower.iter().skip(1)).all(|(x, y)| *y >= x * (1.0 - 1e-9)), "{:?} {:?}", hz, lower);
    }

    /// Far below its first frequency a held machine is its springs, which are written out by hand: the static compliance.
    #[test]
    fn limit_a_held_machine_is_its_springs_at_rest(made in made(true), rods in rods()) {
        let made = Made { loss: 0.0, ..made };
        let compliance = by_hand(&made).0.try_inverse().unwrap();
        let first = made.frequencies_hz(rods).first().copied().unwrap_or(1500.0);
        let names = made.names();
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate() {
                let h = made.receptance(a, b, 1e-4 * first, rods).re;
                let scale = (compliance[(i, i)] * compliance[(j, j)]).sqrt();
                prop_assert!((h - compliance[(i, j)]).abs() <= 1e-6 * scale, "{a}/{b}: {h} and {}", compliance[(i, j)]);
            }
        }
    }

    /// Free, it moves as two rigid bodies, all along and the screw's turn, which the lead couples: H → −φᵀ(ΦᵀMΦ)⁻¹φ/ω².
    #[test]
    fn limit_a_free_machine_is_two_rigid_bodies(made in made(false), rods in rods()) {
        let made = Made { loss: 0.0, ..made };
        let hz = made.frequencies_hz(rods);
        prop_assert!(hz.len() >= 2 && hz[..2] == [0.0, 0.0] && hz.get(2).is_none_or(|f| *f > 0.0), "{:?}", hz);
        let names = made.names();
        // Columns: a unit of travel of all; a unit of the screw's angle, which takes what hangs on the table along by the lead.
        let travels = |name: &str| on_table(&made, name);
        let shapes = DMatrix::from_fn(names.len(), 2, |i, j| match (made.turns(names[i]), j) {
            (false, 0) | (true, 1) => 1.0,
            (false, _) if travels(names[i]) => made.lead_m / TAU,
            _ => 0.0,
        });
        let mass = by_hand(&made).1;
        let rigid = &shapes * (shapes.transpose() * mass * &shapes).try_inverse().unwrap() * shapes.transpose();
        // What bends grows with ω², and is taken off by a second frequency; what cancels of stiffnesses much larger than ω²·M is left.
        let omega = TAU * 3e-3 * hz.get(2).copied().unwrap_or(1500.0);
        for (i, a) in names.iter().enumerate() {
            for (j, b) in names.iter().enumerate() {
                let at = |omega: f64| made.receptance(a, b, omega / TAU, rods).re * (-omega * omega);
                let h = (4.0 * at(omega) - at(2.0 * omega)) / 3.0;
                let scale = (rigid[(i, i)] * rigid[(j, j)]).sqrt();
                prop_assert!((h - rigid[(i, j)]).abs() <= 1e-5 * scale, "{a}/{b}: {h} and {}", rigid[(i, j)]);
            }
        }
    }
}

/// Whether a body hangs on the table, itself or through others.
fn on_table(made: &Made, name: &str) -> bool {
    let below = made.springs.iter().find(|s| s.ends[0] == name && name.starts_with("body"));
    name == "table" || below.is_some_and(|s| on_table(made, &s.ends[1]))
}
