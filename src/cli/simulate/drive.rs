//! The drive of a machine, its unstable poles, and the response point.

use crate::sources::Loaded;
use dynamics::motion::Pole;
use machine::{Drive, Machine};

/// Returns the drive of a machine.
///
/// # Errors  the machine has none.
pub fn find_drive(loaded: &Loaded) -> Result<&Drive, String> {
    let path = &loaded.config.path;
    loaded.config.machine.drive.as_ref().ok_or_else(|| format!("{path}: the machine has no drive; describe one as [drive]"))
}

/// Describes an unstable pole, and how to make the loops stable.
pub fn describe_pole(pole: &Pole) -> String {
    let e_fold_s = 1.0 / pole.growth_per_s;
    // A frequency below 1 mHz counts as zero.
    let frequency = if pole.frequency_hz < 1e-3 { "a real pole".into() } else { format!("the pole at {:.1} Hz", pole.frequency_hz) };
    format!(
        "{frequency} grows e-fold every {e_fold_s:.3e} s (damping ratio {:.3}), with the largest share of kinetic energy \
         at «{}»; lower the gains, the delay or the sampling periods of the loops",
        pole.damping_ratio(),
        pole.point
    )
}

/// Returns the point with this name, whose displacement is the response.
///
/// # Errors  the machine has no such point.
pub fn find_response<'m>(machine: &'m Machine, name: &str) -> Result<&'m str, String> {
    machine.point(name).map(|at| machine.points[at].name.as_str()).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        format!("--response {name}: no such point; the machine has {}", known.join(", "))
    })
}
