//! The friction curve from the constant speeds of a motion.

use super::phase::Phase;
use super::preprocessing::{MotionSignal, phases};
use numeric::statistics::median;

/// One stretch at constant speed.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Record.
    pub record: String,
    /// Mean velocity (m/s).
    pub velocity_m_s: f64,
    /// Mean force (N) or torque (N·m) less that of the mean acceleration.
    pub load: f64,
    /// Its standard deviation, from halves of the stretch.
    pub sd: f64,
    /// Where it begins (s from the record's first sample), and how long it lasts.
    pub from_s: f64,
    /// Duration (s).
    pub lasts_s: f64,
}

/// Shortest stretch (s), and the share of its beginning that is left out: the loop settles.
const SHORTEST_S: f64 = 0.1;
const SETTLES: f64 = 0.2;

/// Mean force over velocity, one point for each stretch at constant speed of a motion; `inertia` (N per m/s²) takes out what its remaining
/// acceleration needs.
pub fn friction_curve(motion: &MotionSignal, inertia: f64) -> Vec<CurvePoint> {
    let all = phases(motion);
    let kept: Vec<usize> = motion.kept().collect();
    let mut points = Vec::new();
    let mut stretch: Vec<usize> = Vec::new();
    for at in 0..=kept.len() {
        if at < kept.len() && all[kept[at]] == Phase::ConstantSpeed {
            stretch.push(at);
            continue;
        }
        let begin = (SETTLES * stretch.len() as f64).ceil() as usize;
        let used = &stretch[begin.min(stretch.len())..];
        if used.len() as f64 * motion.thinned_step_s() >= SHORTEST_S && used.len() >= 4 {
            let force = |i: &usize| motion.load[*i] - inertia * motion.acceleration_m_s2[kept[*i]];
            let mean = |part: &[usize]| part.iter().map(force).sum::<f64>() / part.len() as f64;
            let speeds = median(used.iter().map(|i| motion.velocity_m_s[kept[*i]])).unwrap_or(0.0);
            let (first, second) = used.split_at(used.len() / 2);
            points.push(CurvePoint {
                record: motion.name.clone(),
                velocity_m_s: speeds,
                load: mean(used),
                sd: 0.5 * (mean(first) - mean(second)).abs(),
                from_s: kept[used[0]] as f64 * motion.step_s,
                lasts_s: used.len() as f64 * motion.thinned_step_s(),
            });
        }
        stretch.clear();
    }
    points.sort_by(|a, b| a.velocity_m_s.total_cmp(&b.velocity_m_s));
    points
}
