//! Simulated motion against closed forms, exact event times, energy balance and the records of a real axis.

use std::f64::consts::{PI, TAU};

use config::read_machine_text;
use dynamics::motion::{
    Course, Event, EventKind, MotionError, SCurve, SimulationSettings, Sine, Trace, simulate, simulate_record,
};
use machine::{Machine, Operating};
use measurement::read_motion;
use nalgebra::{DMatrix, DVector};

/// A drive whose loops have zero gain: its force (N) equals the signal that the course adds.
const OPEN_LOOP: &str = "constant = 1.0\nposition = { gain_per_s = 0.0, period_s = 1e-3 }\nvelocity = { gain = 0.0, period_s = 1e-3 }\n";

fn machine(text: &str) -> Machine {
    read_machine_text("axis.toml", text, &[], &[]).unwrap_or_else(|e| panic!("{e}")).machine
}

fn run_with(machine: &Machine, course: &Course, settings: &SimulationSettings) -> Trace {
    simulate(machine, &machine.start(), course, settings, &|| true).unwrap_or_else(|e| panic!("{e}"))
}

fn run(machine: &Machine, course: &Course) -> Trace {
    run_with(
        machine,
        course,
        &SimulationSettings { bound: Some(f64::INFINITY), ..SimulationSettings::default() },
    )
}

/// Returns a course with zero command and an added signal (V).
fn added_signal(added: Vec<f64>) -> Course {
    Course { added: added.clone(), ..Course::new(1e-3, vec![0.0; added.len()]) }
}

fn times(trace: &Trace, kind: EventKind) -> Vec<f64> {
    trace.events.iter().filter(|e| e.kind == kind).map(|e| e.time_s).collect()
}

/// A motor drives a table through a spring and a damper. The PI velocity loop has both feed-forwards; the
/// loops have two sampling rates.
const TWO_MASSES: &str = r#"
title = "two masses"
[[point]]
name = "motor"
motion = "rotation"
inertia_kg_m2 = 2e-3
[[point]]
name = "table"
motion = "translation"
mass_kg = 150.0
[[joint]]
name = "nut"
on = { table = 1.0, motor = -3.183098861837907e-3 }
stiffness = 4e7
damping = 3e3
[[joint]]
name = "guide"
between = ["table", "ground"]
damping = 120.0
[drive]
on = "motor"
constant = 0.6
[drive.position]
at = "table"
gain_per_s = 60.0
feed_forward = 0.8
period_s = 1e-3
[drive.velocity]
at = "motor"
lead_m = 0.02
gain = 150.0
integral_time_s = 0.02
acceleration_feed_forward = 2.0
period_s = 2.5e-4
"#;

#[test]
fn limit_a_linear_machine_follows_its_matrix_exponential() {
    let machine = machine(TWO_MASSES);
    let curve = SCurve { from: 0.0, to: 0.05, velocity: 0.4, acceleration: 8.0, jerk: 400.0 };
    let course = curve.course(1e-3, 0.01, false).unwrap();
    let trace = run(&machine, &course);
    // Reference: nalgebra's matrix exponential and an explicit implementation of the loops.
    let (j, m, k, d, g, i) = (2e-3, 150.0, 4e7, 3e3, 120.0, 0.02 / TAU);
    let a = DMatrix::from_row_slice(
        5,
        5,
        &[
            0.0,
            0.0,
            1.0,
            0.0,
            0.0, //
            0.0,
            0.0,
            0.0,
            1.0,
            0.0, //
            -k * i * i / j,
            k * i / j,
            -d * i * i / j,
            d * i / j,
            1.0 / j, //
            k * i / m,
            -k / m,
            d * i / m,
            -(d + g) / m,
            0.0, //
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        ],
    );
    let step = (a * 2.5e-4).exp();
    let mut y: DVector<f64> = DVector::zeros(5);
    let (mut integral, mut reference, mut acceleration, mut rate, mut before) = (0.0, 0.0, 0.0, 0.0, 0.0);
    let largest = course.command.last().unwrap().abs();
    for (tick, sample) in trace.samples.iter().enumerate() {
        assert!(
            (sample.points[1] - y[1]).abs() < 1e-8 * largest,
            "{tick}: {} against {}",
            sample.points[1],
            y[1]
        );
        assert!((sample.points[0] * i - y[0] * i).abs() < 1e-8 * largest);
        if tick % 4 == 0 {
            let at = tick / 4;
            let last = if at == 0 { 0.0 } else { course.command[at - 1] };
            let now = (course.command[at] - last) / 1e-3;
            acceleration = if tick == 0 { 0.0 } else { (now - rate) / 1e-3 };
            rate = now;
            reference = 60.0 * (course.command[at] - y[1]) + 0.8 * rate;
        }
        let error = reference - (y[0] * i - before) / 2.5e-4;
        before = y[0] * i;
        y[4] = 0.6 * (150.0 * (error + integral) + 2.0 * acceleration);
        assert!((sample.force - y[4]).abs() < 1e-8 * 0.6 * 150.0 * 0.4, "{tick}");
        integral += error * 2.5e-4 / 0.02;
        y = &step * y;
    }
    assert!(trace.complete && trace.energy.imbalance() < 1e-6, "{}", trace.energy.imbalance());
}

/// A belt drags a mass against a spring: the mass sticks, is held up to the static friction and slips back.
/// Event times have a closed form.
#[test]
fn limit_stick_and_slip_on_a_belt_at_its_exact_events() {
    let (m, k, kinetic, static_force, belt): (f64, f64, f64, f64, f64) = (2.0, 800.0, 6.0, 9.0, 0.1);
    let machine = machine(&format!(
        r#"
title = "mass on a belt"
point = [
    {{ name = "table", motion = "translation", mass_kg = {m} }},
    {{ name = "belt", motion = "translation", mass_kg = 1e12 }},
]
[[joint]]
name = "spring"
between = ["table", "ground"]
stiffness = {k}
[[joint]]
name = "felt"
between = ["table", "belt"]
friction = {{ coulomb = {kinetic}, stribeck = {}, stribeck_velocity = 1e-9, stribeck_exponent = 1.0 }}
[drive]
on = "belt"
{OPEN_LOOP}"#,
        static_force - kinetic
    ));
    let course = Course { start_velocity: Some(belt), ..Course::new(1e-3, vec![0.0; 2001]) };
    let trace = run(&machine, &course);
    let omega = (k / m).sqrt();
    // From standstill the kinetic friction accelerates the mass to the belt's velocity.
    let capture_s = (belt * k / (kinetic * omega)).asin() / omega;
    let at_capture = kinetic / k * (1.0 - (omega * capture_s).cos());
    let mut slip_s = capture_s + (static_force / k - at_capture) / belt;
    let mut expected = vec![(capture_s, EventKind::Sticks), (slip_s, EventKind::Slides)];
    let excess = static_force - kinetic;
    while slip_s < 2.0 {
        let stick_s = slip_s + 2.0 / omega * (PI - (excess * omega / (k * belt)).atan());
        slip_s = stick_s + 2.0 * excess / (k * belt);
        expected.extend([(stick_s, EventKind::Sticks), (slip_s, EventKind::Slides)]);
    }
    expected.retain(|(t, _)| *t < 2.0);
    assert!(expected.len() > 10);
    let found: Vec<&Event> = trace.events.iter().collect();
    assert_eq!(found.len(), expected.len(), "{found:?}\n{expected:?}");
    for (found, (time_s, kind)) in found.iter().zip(expected) {
        assert_eq!(found.kind, kind);
        assert!((found.time_s - time_s).abs() < 1e-7, "{} against {time_s}", found.time_s);
    }
}

/// A mass on a spring with Coulomb friction loses 2·F/k of amplitude per half period, and stops where the
/// spring force is below the friction.
#[test]
fn limit_coulomb_friction_stops_an_oscillation_at_exact_times() {
    let (m, k, level): (f64, f64, f64) = (3.0, 1200.0, 5.0);
    let machine = machine(&format!(
        "title = \"oscillator\"\n[[point]]\nname = \"table\"\nmotion = \"translation\"\nmass_kg = {m}\n[[joint]]\nname = \"guide\"\nbetween = [\"table\", \"ground\"]\nstiffness = {k}\nfriction = {{ coulomb = {level} }}\n[drive]\non = \"table\"\n{OPEN_LOOP}"
    ));
    let begin = 0.05;
    let course = Course { start_position: Some(begin), ..Course::new(1e-3, vec![0.0; 1500]) };
    let trace = run(&machine, &course);
    let half_period = PI / (k / m).sqrt();
    let half_periods = ((begin - level / k) / (2.0 * level / k)).ceil() as usize;
    let reversals = times(&trace, EventKind::Reverses);
    assert_eq!(reversals.len(), half_periods - 1);
    for (at, time) in reversals.iter().chain(&times(&trace, EventKind::Sticks)).enumerate() {
        assert!((time - (at + 1) as f64 * half_period).abs() < 1e-9, "{time}");
    }
    let rest = begin - 2.0 * level / k * half_periods as f64;
    let sign = if half_periods.is_multiple_of(2) { 1.0 } else { -1.0 };
    assert!((trace.samples.last().unwrap().position - sign * rest).abs() < 1e-10);
    assert!(trace.energy.imbalance() < 1e-9);
}

/// Crosses the backlash without contact, then two masses collide under a constant force.
#[test]
fn limit_backlash_is_crossed_in_closed_form() {
    let (m1, m2, k, gap, push): (f64, f64, f64, f64, f64) = (20.0, 60.0, 3e6, 4e-4, 50.0);
    let machine = machine(&format!(
        r#"
title = "backlash"
point = [
    {{ name = "motor", motion = "translation", mass_kg = {m1} }},
    {{ name = "table", motion = "translation", mass_kg = {m2} }},
]
[[joint]]
name = "nut"
between = ["motor", "table"]
stiffness = {k}
gap = {gap}
[drive]
on = "motor"
{OPEN_LOOP}"#
    ));
    let trace = run(&machine, &added_signal(vec![push; 60]));
    let contact_s = (gap * m1 / push).sqrt();
    let speed = push / m1 * contact_s;
    // Contact deflection p: p̈ = push/m1 − k·p/µ.
    let reduced = m1 * m2 / (m1 + m2);
    let (omega, rest) = ((k / reduced).sqrt(), push / m1 * reduced / k);
    let deflection = |t: f64| rest * (1.0 - (omega * t).cos()) + speed / omega * (omega * t).sin();
    // First return of the deflection to 0, by bisection on the closed form.
    let (mut low, mut high) = (0.5 * PI / omega, 1.5 * PI / omega);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if deflection(middle) > 0.0 { low = middle } else { high = middle }
    }
    let separation_s = contact_s + low;
    let (closes, opens) = (times(&trace, EventKind::Closes), times(&trace, EventKind::Opens));
    assert!((closes[0] - contact_s).abs() < 1e-10, "{} against {contact_s}", closes[0]);
    assert!((opens[0] - separation_s).abs() < 1e-10, "{} against {separation_s}", opens[0]);
    assert!(trace.energy.imbalance() < 1e-9);
}

/// With all effects combined, the supplied energy is stored or dissipated.
#[test]
fn limit_energy_is_stored_or_dissipated() {
    let text = TWO_MASSES
        .replace("damping = 120.0", "damping = 120.0\nfriction = { coulomb = 40.0, stribeck = 20.0, stribeck_velocity = 2e-3, offset = 3.0, viscous_asymmetry = 20.0, position = { sine = 5.0, period = 0.01 }, load_share = 0.02, load_of = \"nut\" }")
        .replace("stiffness = 4e7", "stiffness = 4e7\ngap = 1e-5");
    let sine = Sine { centre: 0.0, amplitude: 0.01, frequency_hz: 2.0, periods: 2.0 }.course(1e-3).unwrap();
    let trace = run(&machine(&text), &sine);
    assert!(trace.energy.imbalance() < 1e-6, "{:e}", trace.energy.imbalance());
    let kinds = [EventKind::Sticks, EventKind::Slides, EventKind::Closes, EventKind::Opens];
    assert!(kinds.iter().all(|k| !times(&trace, *k).is_empty()), "{:?}", trace.events.len());
    // With presliding and lead error instead of sticking and backlash.
    let text = text
        .replace("coulomb = 40.0,", "coulomb = 40.0, presliding_stiffness = 2e7, presliding_damping = 2e3,")
        .replace(
            "gap = 1e-5",
            "lead_error = { growth = 1e-4, wave = { cosine = 5e-6, sine = 3e-6, period = 0.01 } }",
        )
        .replace("constant = 0.6", "constant = 0.6\nripple = { cosine = 0.05, sine = 0.02, period = 0.5 }");
    let trace = run(&machine(&text), &sine);
    assert!(trace.energy.imbalance() < 1e-6, "{:e}", trace.energy.imbalance());
}

/// A relative deviation of the lead is another lead.
#[test]
fn limit_a_deviation_of_the_lead_is_another_lead() {
    let sine = Sine { centre: 0.0, amplitude: 0.01, frequency_hz: 2.0, periods: 1.0 }.course(1e-3).unwrap();
    let deviating = run(
        &machine(&TWO_MASSES.replace("damping = 3e3", "damping = 3e3\nlead_error = { growth = 0.25 }")),
        &sine,
    );
    let other = run(&machine(&TWO_MASSES.replace("-3.183098861837907e-3", "-3.978873577297384e-3")), &sine);
    let described = run(&machine(TWO_MASSES), &sine);
    let last = |trace: &Trace| trace.samples.iter().map(|sample| sample.position).fold(0.0, f64::max);
    assert!((last(&deviating) - last(&other)).abs() < 1e-12, "{} against {}", last(&deviating), last(&other));
    assert!((last(&described) - last(&other)).abs() > 1e-6);
}

const ONE_MASS: &str = r#"
title = "one mass"
[[point]]
name = "table"
motion = "translation"
mass_kg = 10.0
[drive]
on = "table"
"#;

/// Halving the step divides the error of presliding friction by 2⁴.
#[test]
fn limit_presliding_converges_at_fourth_order() {
    let text = format!(
        "{ONE_MASS}{OPEN_LOOP}\n[[joint]]\nname = \"guide\"\nbetween = [\"table\", \"ground\"]\ndamping = 30.0\nfriction = {{ coulomb = 8.0, stribeck = 4.0, stribeck_velocity = 0.05, presliding_stiffness = 1e4, presliding_damping = 20.0 }}"
    );
    let machine = machine(&text);
    let end = |step_s: f64, tolerance: f64| {
        let settings = SimulationSettings {
            step_s: Some(step_s),
            tolerance,
            bound: Some(f64::INFINITY),
            ..SimulationSettings::default()
        };
        let sample = run_with(&machine, &added_signal(vec![30.0; 201]), &settings).samples.pop().unwrap();
        sample.position
    };
    let exact = end(1.5625e-5, 1e-9);
    let errors: Vec<f64> =
        [1e-3, 5e-4, 2.5e-4].iter().map(|h| (end(*h, f64::INFINITY) - exact).abs()).collect();
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(order > 3.6, "order {order}: {errors:?}");
    }
}

/// Presliding friction of very high stiffness approaches Coulomb friction.
#[test]
fn limit_stiff_presliding_approaches_coulomb_friction() {
    let guide = |more: &str| {
        machine(&format!(
            "{ONE_MASS}{OPEN_LOOP}\n[[joint]]\nname = \"guide\"\nbetween = [\"table\", \"ground\"]\nfriction = {{ coulomb = 8.0{more} }}"
        ))
    };
    let push: Vec<f64> = (0..500).map(|i| 20.0 * (0.02 * f64::from(i)).sin()).collect();
    let rigid = run(&guide(""), &added_signal(push.clone()));
    let largest = rigid.samples.iter().fold(0.0_f64, |m, s| m.max(s.position.abs()));
    let deviations: Vec<f64> = [(1e6, 6e3), (1e9, 2e5)]
        .iter()
        .map(|(stiffness, damping)| {
            let more = format!(", presliding_stiffness = {stiffness:e}, presliding_damping = {damping:e}");
            let elastic = run(&guide(&more), &added_signal(push.clone()));
            rigid
                .samples
                .iter()
                .zip(&elastic.samples)
                .fold(0.0_f64, |m, (a, b)| m.max((a.position - b.position).abs()))
                / largest
        })
        .collect();
    // Sliding begins after the time that a linearly increasing force takes to deflect the bristles. This time
    // falls with their stiffness^(−1/3).
    assert!(deviations[0] < 0.1 && deviations[1] < 0.05 * deviations[0], "{deviations:?}");
}

#[test]
fn limit_saturation_delay_and_encoder_steps() {
    let loops = |drive: &str, position: &str, velocity: &str| {
        machine(&format!(
            "{ONE_MASS}constant = 5.0\n{drive}\nposition = {{ gain_per_s = 10.0, period_s = 1e-3{position} }}\nvelocity = {{ gain = 100.0, period_s = 1e-3{velocity} }}\n"
        ))
    };
    // A distant command saturates the drive: x = ½·a·t².
    let trace = run(
        &loops("saturation = 2.0", "", ""),
        &Course { start_position: Some(0.0), ..Course::new(1e-3, vec![1e3; 101]) },
    );
    for sample in &trace.samples {
        assert_eq!(sample.force, 10.0);
        assert!((sample.position - 0.5 * sample.time_s.powi(2)).abs() < 1e-12);
    }
    // A force commanded at 10 ms acts 2.3 ms later.
    let mut push = vec![0.0; 30];
    push[10..].fill(4.0);
    let open = machine(&format!("{ONE_MASS}delay_s = 2.3e-3\n{OPEN_LOOP}"));
    for sample in run(&open, &added_signal(push)).samples {
        let on = (sample.time_s - 12.3e-3).max(0.0);
        assert!((sample.position - 0.5 * 0.4 * on * on).abs() < 1e-13, "{} s", sample.time_s);
    }
    // Encoder readings are multiples of the step, and the loop's force has steps, too.
    let trace =
        run(&loops("", ", encoder_step = 1e-4", ""), &Course::new(1e-3, vec![0.0, 0.01]).stretched(200));
    assert!(trace.samples.iter().all(|s| ((s.position / 1e-4) - (s.position / 1e-4).round()).abs() < 1e-9));
    assert!(trace.samples.iter().any(|s| (s.points[0] - s.position).abs() > 3e-5));
    let step = 100.0 * 5.0 * 1e-4 / 1e-3;
    assert!(trace.samples.windows(2).any(|w| (w[1].force - w[0].force).abs() > 0.9 * step));
}

trait Stretched {
    /// Extends the command to `samples` by its last value.
    fn stretched(self, samples: usize) -> Self;
}

impl Stretched for Course {
    fn stretched(mut self, samples: usize) -> Self {
        let last = *self.command.last().unwrap();
        self.command.resize(samples, last);
        self
    }
}

#[test]
fn limit_an_unstable_loop_stops_and_reports_its_time() {
    let machine = machine(&format!(
        "{ONE_MASS}constant = 5.0\nposition = {{ gain_per_s = 10.0, period_s = 1e-3 }}\nvelocity = {{ gain = 1e4, period_s = 1e-3 }}\n"
    ));
    let course = Course::new(1e-3, vec![0.0, 1e-3]).stretched(2000);
    let trace = run_with(&machine, &course, &SimulationSettings::default());
    let (time_s, error) = trace.unstable.unwrap();
    assert!(!trace.complete && time_s < 1.0 && error > 1e-2);
    assert_eq!(trace.samples.last().unwrap().time_s, time_s);
}

#[test]
fn refuse_unsuitable_steps_and_strokes() {
    let refused = |machine: &Machine, course: &Course, settings: &SimulationSettings, expected: &str| {
        let error = simulate(machine, &machine.start(), course, settings, &|| true).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let axis = machine(TWO_MASSES);
    let course = Course::new(1e-3, vec![0.0, 1e-3]);
    let step = |step_s| SimulationSettings { step_s: Some(step_s), ..SimulationSettings::default() };
    refused(&axis, &course, &step(1e-3), "too long");
    refused(&axis, &course, &step(2e-4), "not an integer fraction");
    refused(&axis, &Course::new(1e-3, vec![0.0, f64::NAN]), &SimulationSettings::default(), "finite");
    let bench = config::read_machine("configs/tian.toml", &[], &[]).unwrap().machine;
    assert_eq!(
        simulate(&bench, &bench.start(), &course, &SimulationSettings::default(), &|| true),
        Err(MotionError::NoDrive)
    );
    let text =
        std::fs::read_to_string("configs/tian.toml").unwrap() + "\n[drive]\non = \"rotor\"\n" + OPEN_LOOP;
    let text = text.replace("effects = [\"rotor-hold\"]", "");
    let at_end = SimulationSettings { operating: Operating::at_nut(2.5), ..SimulationSettings::default() };
    refused(&machine(&text), &Course::new(1e-3, vec![0.0, 0.2]), &at_end, "beyond the screw of 2.6 m");
    for (from, to, part) in [
        ("period_s = 1e-3\n[drive.velocity]", "period_s = 3e-4\n[drive.velocity]", "drive.position.period_s"),
        ("damping = 120.0", "damping = 120.0\ngap = 1e-5", "no stiffness"),
        ("constant = 0.6", "constant = 0.6\nripple = { cosine = 1.0 }", "ripple.period"),
        ("lead_m = 0.02\n", "lead_m = 0.02\nover_s = 3e-4\n", "over_s"),
    ] {
        let text = TWO_MASSES.replace(from, to);
        assert_ne!(text, TWO_MASSES);
        let error = read_machine_text("axis.toml", &text, &[], &[]).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// At standstill the integral action creeps up to the friction limit and stays there within rounding; this
/// must not generate endless events.
#[test]
fn regress_an_axis_at_standstill_at_the_limit_of_its_friction() {
    let text = std::fs::read_to_string("configs/servo-axis.toml").unwrap()
        + "\n[[joint]]\nname = \"guide\"\nbetween = [\"slide\", \"ground\"]\ndamping = 200.0\nfriction = { coulomb = 60.0 }\n";
    let curve = SCurve { from: 0.0, to: 0.5, velocity: 0.3, acceleration: 3.0, jerk: 100.0 };
    let trace = run(&machine(&text), &curve.course(1e-3, 3.1, true).unwrap());
    assert!(trace.complete && trace.events.len() < 500, "{}", trace.events.len());
    assert!(trace.energy.imbalance() < 1e-6, "{:e}", trace.energy.imbalance());
}

/// Simulations share no state: concurrent runs give the same bits as a single one.
#[test]
fn the_same_bits_alone_and_concurrently() {
    let text = TWO_MASSES.replace(
        "damping = 120.0",
        "damping = 120.0\nfriction = { coulomb = 40.0, stribeck = 20.0, stribeck_velocity = 2e-3 }",
    );
    let machine = machine(&text);
    let sine = Sine { centre: 0.0, amplitude: 0.01, frequency_hz: 5.0, periods: 2.0 }.course(1e-3).unwrap();
    let alone = run(&machine, &sine);
    std::thread::scope(|scope| {
        let both: Vec<_> = (0..2).map(|_| scope.spawn(|| run(&machine, &sine))).collect();
        both.into_iter().for_each(|one| assert_eq!(one.join().unwrap(), alone));
    });
}

/// On the bench with lumped rods each effect of motion has little influence at its start values and a visible
/// one at a common size.
#[test]
fn every_effect_of_motion_acts_on_a_flexible_axis() {
    let text = std::fs::read_to_string("configs/tian-as-published.toml").unwrap()
        + r#"
[[joint]]
name = "guide"
between = ["table", "ground"]
friction = { coulomb = 30.0 }
[drive]
on = "rotor"
constant = 1.0
[drive.position]
lead_m = 0.04
gain_per_s = 40.0
period_s = 1e-3
[drive.velocity]
gain = 60.0
period_s = 5e-4
"#;
    let frictionless = machine(&text.replace("coulomb = 30.0", ""));
    let with_friction = machine(&text);
    let sine = Sine { centre: 0.0, amplitude: 0.02, frequency_hz: 1.0, periods: 1.5 }.course(1e-3).unwrap();
    let settings =
        SimulationSettings { operating: Operating::at_nut(1.3), lumps: 2, ..SimulationSettings::default() };
    let forces = |machine: &Machine, values: &[f64]| -> Vec<f64> {
        let trace = simulate(machine, values, &sine, &settings, &|| true).unwrap_or_else(|e| panic!("{e}"));
        assert!(trace.complete && trace.energy.imbalance() < 1e-5, "{:e}", trace.energy.imbalance());
        let table = trace.points.iter().position(|p| p == "table").unwrap();
        // The table's lag reveals effects that the force does not show, because the loop is closed by an
        // encoder at the rotor.
        trace.samples.iter().flat_map(|s| [s.force, 1e4 * (s.position - s.points[table])]).collect()
    };
    let sizes: [(&str, &[(&str, f64)]); 15] = [
        ("coulomb-friction", &[("coulomb_friction", 50.0)]),
        ("viscous-friction", &[("viscous_friction", 2000.0)]),
        ("stribeck-friction", &[("stribeck_friction", 30.0), ("stribeck_velocity", 0.05)]),
        ("friction-asymmetry", &[("viscous_asymmetry", 300.0)]),
        ("presliding-friction", &[("presliding_stiffness", 1e5), ("presliding_damping", 100.0)]),
        ("position-friction", &[("position_friction_cosine", 20.0)]),
        ("load-friction", &[("load_friction_share", 0.2)]),
        ("backlash", &[("backlash_width", 5e-5)]),
        ("drive-flexibility", &[("k_drive", 300.0)]),
        ("control-delay", &[("control_delay", 1.3e-3)]),
        ("force-gain", &[("force_gain_change", 0.2)]),
        ("torque-ripple", &[("ripple_cosine", 0.3), ("ripple_period", 1.0)]),
        ("lead-error", &[("lead_error_cosine", 3e-5), ("lead_error_period", 0.04)]),
        ("lead-growth", &[("lead_growth", 1e-3)]),
        ("moving-mass", &[("moving_mass_change", 0.2)]),
    ];
    let library = config::effect_library().unwrap();
    let motion = library.iter().filter(|e| e.data.contains(&machine::Data::Motion)).map(|e| e.id.as_str());
    // Some effects have two variants, for differently described machines; one is of the recorders.
    let motion: std::collections::BTreeSet<&str> = motion.filter(|id| *id != "measurement-delay").collect();
    assert_eq!(motion.len(), sizes.len());
    for (id, size) in sizes {
        // Presliding needs friction.
        let base = if id == "presliding-friction" { &with_friction } else { &frictionless };
        let began = std::time::Instant::now();
        let before = forces(base, &base.start());
        let with = base.with_effect(library.iter().find(|e| e.id == id).unwrap()).unwrap();
        let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
        let change = |values: &[f64]| {
            let after = forces(&with, values);
            norm(&after.iter().zip(&before).map(|(a, b)| a - b).collect::<Vec<_>>()) / norm(&before)
        };
        let mut values = with.start();
        let at_start = change(&values);
        size.iter().for_each(|(parameter, x)| values[with.parameter(parameter).unwrap()] = *x);
        let at_size = change(&values);
        println!(
            "{id}: {at_start:.1e} at its start values, {at_size:.1e} at a common size, {:?}",
            began.elapsed()
        );
        assert!(
            at_start < 2e-2 && at_size > 5e-3 && at_size > 5.0 * at_start,
            "{id}: {at_start:e}, {at_size:e}"
        );
    }
}

/// EMPS in closed loop, with the parameters published by its authors.
#[test]
fn published_force_errors_of_emps_in_closed_loop() {
    let Some(folder) = test_data::shared("realdata/emps/motion") else { return };
    let text = std::fs::read_to_string("configs/emps.toml").unwrap();
    let library = config::effect_library().unwrap();
    let symmetric = machine(&text);
    let asymmetric =
        symmetric.with_effect(library.iter().find(|e| e.id == "friction-asymmetry").unwrap()).unwrap();
    let published = [
        ("moving_mass", 95.1089),
        ("viscous_friction", 0.5 * (166.71 + 240.42)),
        ("viscous_asymmetry", 0.5 * (166.71 - 240.42)),
        ("coulomb_friction", 0.5 * (20.144 + 20.628)),
        ("friction_offset", 0.5 * (20.144 - 20.628)),
    ];
    let values = |machine: &Machine| -> Vec<f64> {
        let asymmetric = machine.parameters.len() == 5;
        let of = |id: &str| match id {
            "viscous_friction" if !asymmetric => 203.5034,
            "coulomb_friction" if !asymmetric => 20.3935,
            "friction_offset" if !asymmetric => -3.1648,
            id => published.iter().find(|(p, _)| *p == id).unwrap().1,
        };
        machine.parameters.iter().map(|p| of(&p.id)).collect()
    };
    for (record, limits) in [("sweep", [0.046, 0.038]), ("pulses", [0.055, 0.048])] {
        let text = std::fs::read_to_string(folder.join(format!("{record}.csv"))).unwrap();
        let read = read_motion(record, record, &text).unwrap();
        for (machine, limit) in [&symmetric, &asymmetric].into_iter().zip(limits) {
            let began = std::time::Instant::now();
            let (trace, gap) =
                simulate_record(machine, &values(machine), &read, &SimulationSettings::default(), &|| true)
                    .unwrap();
            let gap = gap.unwrap();
            println!(
                "{record}: force {:.3} %, tracking {:.3} %, {} events, {:?}",
                100.0 * gap.force,
                100.0 * gap.tracking,
                trace.events.len(),
                began.elapsed()
            );
            assert!(gap.force < limit, "{record}: {gap:?}");
            assert!(trace.energy.imbalance() < 1e-6, "{}", trace.energy.imbalance());
        }
    }
}

/// A nut with backlash and lead error: the table rests against a flank whose position varies with the lead
/// error, and the energy balance holds.
#[test]
fn the_energy_balance_holds_for_backlash_with_lead_error() {
    let lead = "lead_error = { wave = { cosine = 4e-6, sine = 3e-6, period = 5e-3 } }\n";
    // Friction presses the table against one flank over the whole stroke.
    let text = TWO_MASSES
        .replace("stiffness = 4e7\n", &format!("stiffness = 4e7\ngap = 2e-5\n{lead}"))
        .replace("damping = 120.0\n", "damping = 120.0\nfriction = { coulomb = 300.0 }\n");
    let sine = Sine { centre: 0.0, amplitude: 0.01, frequency_hz: 1.0, periods: 2.0 }.course(1e-3).unwrap();
    let simulated = |text: &str| {
        run(
            &machine(&text.replace(
                "[drive.position]\nat = \"table\"",
                "[drive.position]\nat = \"motor\"\nlead_m = 0.02",
            )),
            &sine,
        )
    };
    let (with, without) = (simulated(&text), simulated(&text.replace(lead, "")));
    assert!(
        with.energy.imbalance() < 1e-6 && times(&with, EventKind::Closes).len() >= 2,
        "{:e}",
        with.energy.imbalance()
    );
    // Table position relative to the motor's, because the motor's motion depends on the flank's slope, too.
    let relative = |s: &dynamics::motion::TraceSample| s.points[1] - 0.02 / TAU * s.points[0];
    // Between reversals, with both in contact on one side, the table positions differ by the lead error.
    let difference = with
        .samples
        .iter()
        .zip(&without.samples)
        .skip(5400)
        .take(1200)
        .map(|(a, b)| relative(a) - relative(b));
    let (low, high) = difference.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
    assert!((high / 5e-6 - 1.0).abs() < 0.1 && (low / 5e-6 + 1.0).abs() < 0.1, "{low:e} {high:e}");
}
