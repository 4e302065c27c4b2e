//! The drive of a machine, its unstable poles, and the response point.

use crate::{Study, StudyError, StudyResult};
use dynamics::motion::Pole;
use machine::{Drive, Machine, PointMotion};

/// Returns the drive of a machine.
///
/// # Errors  the machine has none.
pub fn find_drive(study: &Study) -> StudyResult<&Drive> {
    let none = || StudyError::input(&study.config.path, "the machine has no drive; describe one as [drive]");
    study.machine().drive.as_ref().ok_or_else(none)
}

/// Describes an unstable pole, and how to make the loops stable.
pub fn describe_pole(pole: &Pole) -> String {
    let e_fold_s = 1.0 / pole.growth_per_s;
    // A frequency below 1 mHz counts as zero.
    let frequency = if pole.frequency_hz < 1e-3 {
        "a real pole".into()
    } else {
        format!("the pole at {:.1} Hz", pole.frequency_hz)
    };
    format!(
        "{frequency} grows e-fold every {e_fold_s:.3e} s (damping ratio {:.3}), with the largest share of kinetic energy \
         at «{}»; lower the gains, the delay or the sampling periods of the loops",
        pole.damping_ratio(),
        pole.point
    )
}

/// Returns the index of the point with this name, whose displacement is the response.
///
/// # Errors  the machine has no such point.
pub fn find_response(machine: &Machine, name: &str) -> StudyResult<usize> {
    machine.point(name).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        StudyError::setting("response", name, format!("no such point; the machine has {}", known.join(", ")))
    })
}

/// Returns the factor from the displacement of a point to travel: 1, or for a rotation that of the position
/// encoder (m/rad).
pub fn travel_factor(machine: &Machine, drive: &Drive, point: usize) -> f64 {
    if machine.points[point].motion == PointMotion::Rotation { drive.position.encoder.travel } else { 1.0 }
}
