//! A case is tried with one machine after another until one can carry it.

use super::TruthError;
use super::draw::Draw;

/// Machines drawn for one case before it is given up.
const ATTEMPTS: usize = 20;

/// What the first attempt that is not refused makes; each is given its number and a branch of `draw` of its own.
pub fn first_accepted<T>(
    index: usize,
    draw: &Draw,
    attempted: impl Fn(usize, &mut Draw) -> Result<T, TruthError>,
) -> Result<T, TruthError> {
    let mut last = String::new();
    for attempt in 0..ATTEMPTS {
        match attempted(attempt, &mut draw.branch(attempt as u64)) {
            Ok(made) => return Ok(made),
            Err(refusal) => last = refusal.to_string(),
        }
    }
    Err(TruthError::NoMachine { index, attempts: ATTEMPTS, last })
}
