//! Fit of the machine as described.

use dynamics::inverse_dynamics::{InverseError, MotionSignal, Rigid};
use identification::motion::{ForceFit, best_anywhere, estimate_identifiable};
use long_work::Control;
use machine::Machine;

/// Squared misfit of a fit near the description, as a multiple of the least, above which it is a minimum of
/// its own and not the described machine.
const OTHER_MINIMUM: f64 = 2.0;

/// Fits the machine near its description. Its best fit anywhere is used only where it leaves far less:
/// elsewhere in their ranges parameters in which the force is not linear may imitate a missing effect.
pub(super) fn nominal_fit(
    rigid: &Rigid,
    machine: &Machine,
    free: &[usize],
    motions: &[&MotionSignal],
    spring: impl Fn(usize) -> bool,
    control: &Control,
) -> Result<ForceFit, InverseError> {
    let near = estimate_identifiable((rigid, machine), &machine.start(), free, motions, None, spring)?;
    let anywhere = best_anywhere(rigid, machine, near.clone(), motions, control);
    Ok(if near.squares > OTHER_MINIMUM * anywhere.squares { anywhere } else { near })
}
