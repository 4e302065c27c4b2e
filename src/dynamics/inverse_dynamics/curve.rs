//! The friction curve from the constant-speed phases of a motion.

use super::phase::Phase;
use super::preprocessing::{MotionSignal, phases};
use numeric::statistics::median;

/// One interval of constant speed.
#[derive(Debug, Clone, PartialEq)]
pub struct CurvePoint {
    /// Name of the record.
    pub record: String,
    /// Mean velocity (m/s).
    pub velocity_m_s: f64,
    /// Mean force (N) or torque (N·m), less that of the mean acceleration.
    pub load: f64,
    /// Standard deviation of the load, from the halves of the interval.
    pub sd: f64,
    /// Start (s from the record's first sample).
    pub from_s: f64,
    /// Duration (s).
    pub lasts_s: f64,
}

/// Shortest interval (s); and the share of its start that is omitted while the loop settles.
const MIN_STRETCH_S: f64 = 0.1;
const SETTLING_SHARE: f64 = 0.2;

/// Computes mean force over velocity, one point for each constant-speed interval of a motion. `inertia` (N
/// per m/s²) corrects for the remaining acceleration.
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
        let begin = (SETTLING_SHARE * stretch.len() as f64).ceil() as usize;
        let used = &stretch[begin.min(stretch.len())..];
        if used.len() as f64 * motion.decimated_step_s() >= MIN_STRETCH_S && used.len() >= 4 {
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
                lasts_s: used.len() as f64 * motion.decimated_step_s(),
            });
        }
        stretch.clear();
    }
    points.sort_by(|a, b| a.velocity_m_s.total_cmp(&b.velocity_m_s));
    points
}
