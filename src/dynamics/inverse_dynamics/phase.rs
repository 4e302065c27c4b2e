//! Phases of a motion.

/// Phase of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Phase {
    /// At rest.
    Dwell,
    /// The first 50 ms after a rest.
    Breakaway,
    /// Within 50 ms of a change of direction.
    Reversal,
    /// Changing speed.
    Acceleration,
    /// At constant speed.
    ConstantSpeed,
    /// The command rests, the axis still moves.
    Settling,
}

impl Phase {
    /// All phases in their order.
    pub const ALL: [Phase; 6] = [
        Phase::Dwell,
        Phase::Breakaway,
        Phase::Reversal,
        Phase::Acceleration,
        Phase::ConstantSpeed,
        Phase::Settling,
    ];

    /// Name of the phase.
    pub fn word(self) -> &'static str {
        match self {
            Phase::Dwell => "dwell",
            Phase::Breakaway => "breakaway",
            Phase::Reversal => "reversal",
            Phase::Acceleration => "acceleration",
            Phase::ConstantSpeed => "constant-speed",
            Phase::Settling => "settling",
        }
    }
}

/// Time around a reversal and after a rest (s).
const AROUND_S: f64 = 0.05;
/// Share of the largest speed below which the axis rests; and share of the largest acceleration below which
/// the speed is constant.
const REST_SHARE: f64 = 0.005;
const STEADY_SHARE: f64 = 0.05;
/// Shortest duration of a rest (s).
const REST_S: f64 = 0.05;

/// Classifies each sample of a motion with these velocities (m/s), accelerations (m/s²) and commands (m).
pub(super) fn phases_along((v, a): (&[f64], &[f64]), command_m: &[f64], step_s: f64) -> Vec<Phase> {
    let largest = |x: &[f64]| x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let (rest, steady) = (REST_SHARE * largest(v), STEADY_SHARE * largest(a));
    let around = (AROUND_S / step_s).round().max(1.0) as usize;
    let mut phases: Vec<Phase> =
        a.iter().map(|a| if a.abs() > steady { Phase::Acceleration } else { Phase::ConstantSpeed }).collect();
    let commanded = numeric::filter::central_differences(command_m);
    for i in 0..v.len() {
        if commanded[i].abs() / step_s <= rest && v[i].abs() > rest {
            phases[i] = Phase::Settling;
        }
    }
    for i in 1..v.len() {
        if v[i] * v[i - 1] < 0.0 || (v[i] == 0.0 && v[i - 1] != 0.0) {
            let last = (i + around).min(v.len());
            phases[i.saturating_sub(around)..last].fill(Phase::Reversal);
        }
    }
    let shortest = (REST_S / step_s).round().max(1.0) as usize;
    let mut from = 0;
    for i in 0..=v.len() {
        if i == v.len() || v[i].abs() > rest {
            if i - from >= shortest {
                phases[from..i].fill(Phase::Dwell);
                let last = (i + around).min(v.len());
                phases[i..last].fill(Phase::Breakaway);
            }
            from = i + 1;
        }
    }
    phases
}
