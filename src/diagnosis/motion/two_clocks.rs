//! Forces and positions of motion records from two recorders, whose clocks differ.

use super::candidate::start_of;
use super::context::{CLOCKS, Context, MotionFit};
use crate::facts::FaultFacts;
use dynamics::inverse_dynamics::free_parameters;
use identification::motion::Tolerances;
use machine::Data;

/// Number of starts of a shift in time over its range: a motion of 50 Hz has one minimum about each.
const CLOCK_STARTS: usize = 4;

/// The machine as described with the positions of all records shifted in time against their forces.
pub(super) struct TwoClocks {
    /// The machine and its fit.
    pub shifted: MotionFit,
    /// What it states as a fault.
    pub fault: FaultFacts,
}

impl TwoClocks {
    /// Fits it beside tolerances, from the fit without a shift.
    pub fn new(context: &Context<'_>, (nominal, fit): &MotionFit, tolerances: &Tolerances) -> Option<Self> {
        let effect = context.effects.iter().find(|e| e.id == CLOCKS && e.data.contains(&Data::Motion))?;
        let hypothesis = nominal.with(effect).ok()?;
        let (machine, at) = (&hypothesis.machine, *hypothesis.added.last()?);
        let free = free_parameters(machine, context.frozen).ok()?;
        let fitted = |k: usize| {
            let mut start = start_of(machine, &fit.values);
            start[at] = machine.parameters[at].from_unit((k as f64 + 0.5) / CLOCK_STARTS as f64);
            context.fitted(machine, &start, &free, &hypothesis.added, Some(tolerances))
        };
        let fits = (0..CLOCK_STARTS).filter_map(fitted);
        let best = fits.min_by(|a, b| a.squares.total_cmp(&b.squares))?;
        let lag_ms = 1e3 * best.values[at];
        let what = if lag_ms > 0.0 {
            format!("the positions of all records lag their forces by {lag_ms:.2} ms")
        } else {
            let lag_ms = -lag_ms;
            format!(
                "the forces of all records lag the motions that they cause by {lag_ms:.2} ms, as no drive's do"
            )
        };
        let fault = FaultFacts {
            ids: vec![CLOCKS.into()],
            reason: format!("{what}, and nothing else is missing"),
            next_measurement: effect.discriminating_test.clone().unwrap_or_default(),
            is_insufficient: false,
        };
        Some(TwoClocks { shifted: (hypothesis, best), fault })
    }
}
