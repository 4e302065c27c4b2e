//! The drive of a machine, its unstable poles, and the response point.

use crate::sources::Loaded;
use dynamics::motion::Pole;
use machine::{Drive, Machine};

/// Returns the drive of a machine; an error where it has none.
pub fn find_drive(loaded: &Loaded) -> Result<&Drive, String> {
    let path = &loaded.config.path;
    loaded.config.machine.drive.as_ref().ok_or_else(|| format!("{path}: the machine has no drive; describe one as [drive]"))
}

/// Describes an unstable pole, and how to make the loops stable.
pub fn describe_pole(pole: &Pole) -> String {
    let every = 1.0 / pole.growth_per_s;
    let frequency = if pole.frequency_hz < 1e-3 { "a real pole".into() } else { format!("the pole at {:.1} Hz", pole.frequency_hz) };
    format!(
        "{frequency} grows e-fold every {every:.3e} s (damping ratio {:.3}), most at «{}»; lower the gains, the delay or the periods of its loops",
        pole.damping_ratio(),
        pole.point
    )
}

/// Returns the point of this name, whose travel is the response.
pub fn find_response<'m>(machine: &'m Machine, name: &str) -> Result<&'m str, String> {
    machine.point(name).map(|at| machine.points[at].name.as_str()).ok_or_else(|| {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        format!("--response {name}: no such point; the machine has {}", known.join(", "))
    })
}
