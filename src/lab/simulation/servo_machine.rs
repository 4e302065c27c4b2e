//! Records of the independent reference simulator of a servo axis.

use std::path::PathBuf;

use reference_simulator::servo::{Axis, Circle, Feed, Missing, Sensors, write_circles, write_sines};
use report::OutputFolder;
use study::{StudyError, StudyResult};

/// Effects that the reference simulator has and the model of `configs/hybrid-axis.toml` lacks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum MissingEffect {
    /// Thermal expansion of the screw.
    #[value(name = "growth")]
    ThermalExpansion,
    /// Lead error, periodic with the revolution of the screw.
    LeadError,
    /// Torque ripple of the motor.
    Ripple,
    /// Presliding: friction that is elastic before it slides.
    Presliding,
    /// Mass on the table.
    Inertia,
    /// Lag between position and velocity loop.
    ServoLag,
}

impl MissingEffect {
    /// The effects of screw, motor and guide, simulated by default.
    pub const COMMON: [MissingEffect; 4] = [
        MissingEffect::ThermalExpansion,
        MissingEffect::LeadError,
        MissingEffect::Ripple,
        MissingEffect::Presliding,
    ];
}

/// Mass on the table (kg), such as a workpiece with its fixture: 18 % of the inertia at the motor, which
/// equals 1,350 kg. Its force error is in proportion to acceleration.
const EXTRA_KG: f64 = 240.0;
/// First-order lag τ between position and velocity loop (s). In samples of 1 ms its mean age is T/(e^{T/τ} − 1) = 4.2 ms,
/// which moves the table by 4.2 ms·a/k_v: with k_v = 120 1/s by 35 µm per m/s², as in Tab. 3 and 4 of the
/// paper.
const LAG_S: f64 = 4.7e-3;

/// What [`write_servo_machine`] simulates and writes.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoMachineRequest {
    /// Folder for the sets.
    pub out: PathBuf,
    /// Effects that the model lacks.
    pub effects: Vec<MissingEffect>,
    /// Seed of the measurement noise.
    pub seed: u64,
}

impl ServoMachineRequest {
    /// Simulates the effects of screw, motor and guide with the first seed.
    pub fn new(out: impl Into<PathBuf>) -> Self {
        ServoMachineRequest { out: out.into(), effects: MissingEffect::COMMON.to_vec(), seed: 1 }
    }
}

/// Folders of the sets written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ServoMachineSets {
    /// Set of sines of one axis.
    pub sines: PathBuf,
    /// Folder of the sets `x` and `y` of circles of two axes.
    pub circles: PathBuf,
}

/// Simulates records of two independent axes and writes them as measurement sets.
///
/// # Errors  a folder already exists or cannot be written.
pub fn write_servo_machine(request: &ServoMachineRequest) -> StudyResult<ServoMachineSets> {
    let has = |effect: MissingEffect| request.effects.contains(&effect);
    let with_effects = |axis: Axis| {
        let (usual, none) = (axis.missing, Missing::none());
        let missing = Missing {
            growth: if has(MissingEffect::ThermalExpansion) { usual.growth } else { none.growth },
            lead_error_m: if has(MissingEffect::LeadError) { usual.lead_error_m } else { none.lead_error_m },
            ripple_nm: if has(MissingEffect::Ripple) { usual.ripple_nm } else { none.ripple_nm },
            extra_kg: if has(MissingEffect::Inertia) { EXTRA_KG } else { none.extra_kg },
            lag_s: if has(MissingEffect::ServoLag) { LAG_S } else { none.lag_s },
            presliding_m: if has(MissingEffect::Presliding) { usual.presliding_m } else { none.presliding_m },
            ..usual
        };
        Axis { missing, ..axis }
    };
    let (x, y) = (with_effects(Axis::x()), with_effects(Axis::y()));
    let sets = ServoMachineSets { sines: request.out.join("sines"), circles: request.out.join("circles") };
    for folder in [&sets.sines, &sets.circles] {
        if folder.exists() || folder.is_symlink() {
            return Err(StudyError::input(folder.display(), "already exists; name another folder"));
        }
    }
    // Checked before the simulations, which take long.
    OutputFolder::prepare(&request.out)?;
    let sensors = Sensors::default();
    write_sines(&sets.sines, &x, &sensors, &Feed::standard(), request.seed)
        .map_err(StudyError::impossible)?;
    write_circles(&sets.circles, [&x, &y], &sensors, &Circle::standard(), request.seed)
        .map_err(StudyError::impossible)?;
    Ok(sets)
}
