//! Repeated attempts to make a case until a machine is admissible.

use super::draw::Draw;
use super::{Result, SimulatorError};

/// Largest number of machines drawn for one case.
const ATTEMPTS: usize = 20;

/// Returns the result of the first successful attempt. Each attempt gets its number and its own branch of
/// `draw`.
pub fn first_accepted<T>(
    index: usize,
    draw: &Draw,
    make: impl Fn(usize, &mut Draw) -> Result<T>,
) -> Result<T> {
    let mut last = String::new();
    for attempt in 0..ATTEMPTS {
        match make(attempt, &mut draw.branch(attempt as u64)) {
            Ok(made) => return Ok(made),
            Err(refusal) => last = refusal.to_string(),
        }
    }
    Err(SimulatorError::NoMachine { index, attempts: ATTEMPTS, last })
}
