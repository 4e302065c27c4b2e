//! Natural frequencies and amplitudes, position by position.

use super::table::Table;
use super::{MeasurementError, Position};

/// Observation of one order at one position; `None` where not observed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeObservation {
    /// Order, as numbered in the table.
    pub order: u32,
    /// Natural frequency (Hz).
    pub frequency_hz: Option<f64>,
    /// Standard deviation of this frequency over repeated tests (Hz); `None` where not stated.
    pub frequency_sd_hz: Option<f64>,
    /// Amplitude of the peak, in the unit of the set's quantity times its gain.
    pub amplitude: Option<f64>,
}

/// Standard deviation of a number rounded to steps of 1: 1/√12.
const ROUNDING_SD: f64 = 0.29;

impl ModeObservation {
    /// Returns the relative standard deviation of its frequency by the measurement: stated scatter, and
    /// rounding to steps of `resolution_hz`. 0 where the frequency was not observed.
    pub fn frequency_scatter(&self, resolution_hz: Option<f64>) -> f64 {
        let rounding_hz = ROUNDING_SD * resolution_hz.unwrap_or(0.0);
        self.frequency_hz.map_or(0.0, |hz| rounding_hz.hypot(self.frequency_sd_hz.unwrap_or(0.0)) / hz)
    }
}

/// Observed modes of every position of a set.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModeTable {
    /// Modes in the order of the set's positions, by rising order.
    pub positions: Vec<Vec<ModeObservation>>,
    /// Rounding step of the frequencies (Hz); `None` where they are not rounded.
    pub resolution_hz: Option<f64>,
    /// Smallest prominence of a peak that was read: ratio of its height to the higher adjacent valley (1);
    /// `None` where not stated.
    pub least_prominence: Option<f64>,
}

/// Reads `position,order,frequency_hz,amplitude,frequency_sd_hz`; an empty cell means «not observed», or «not
/// stated».
pub(super) fn read_modes(
    path: &str,
    text: &str,
    positions: &[Position],
) -> Result<Vec<Vec<ModeObservation>>, MeasurementError> {
    let table =
        Table::read(path, text, &["position", "order", "frequency_hz"], &["amplitude", "frequency_sd_hz"])?;
    let mut modes: Vec<Vec<ModeObservation>> = vec![Vec::new(); positions.len()];
    for row in table.rows() {
        let row = row?;
        let name = row.text("position")?;
        let at = positions.iter().position(|p| p.name == name).ok_or_else(|| {
            let known: Vec<&str> = positions.iter().map(|p| p.name.as_str()).collect();
            row.fault(format!("no position is called «{name}»; manifest.toml has {}", known.join(", ")))
        })?;
        let order = row.text("order")?.parse::<u32>().ok().filter(|o| *o > 0);
        let order = order.ok_or_else(|| {
            row.fault(format!("order «{}» is not a whole number from 1", row.text("order").unwrap_or("")))
        })?;
        if modes[at].iter().any(|m| m.order == order) {
            return Err(row.fault(format!("order {order} of position {name} appears twice; keep one")));
        }
        let positive = |column: &str| match row.optional_number(column)? {
            Some(x) if x <= 0.0 => {
                Err(row.fault(format!("{column} is {x}; write a number above 0, or leave the cell empty")))
            }
            other => Ok(other),
        };
        if let Some(f) = positive("frequency_hz")?.filter(|f| !(1e-2..=1e5).contains(f)) {
            return Err(
                row.fault(format!("frequency_hz is {f}; write a frequency in Hz, from 0.01 to 100000"))
            );
        }
        let observation = ModeObservation {
            order,
            frequency_hz: positive("frequency_hz")?,
            frequency_sd_hz: positive("frequency_sd_hz")?,
            amplitude: positive("amplitude")?,
        };
        if observation.frequency_hz.is_none() && observation.amplitude.is_some() {
            return Err(row.fault("has an amplitude without a frequency; write both or neither".into()));
        }
        if let Some(sd) =
            observation.frequency_sd_hz.filter(|sd| !observation.frequency_hz.is_some_and(|f| *sd < f))
        {
            let remedy =
                "write the standard deviation of frequency_hz in Hz, below it, or leave the cell empty";
            return Err(row.fault(format!("frequency_sd_hz is {sd}; {remedy}")));
        }
        modes[at].push(observation);
    }
    for (list, position) in modes.iter_mut().zip(positions) {
        list.sort_by_key(|m| m.order);
        let seen: Vec<f64> = list.iter().filter_map(|m| m.frequency_hz).collect();
        if seen.windows(2).any(|w| w[0] >= w[1]) {
            let fault = format!(
                "position {}: the frequencies do not rise with the order; renumber the orders",
                position.name
            );
            return Err(MeasurementError::file(path, fault));
        }
    }
    if modes.iter().flatten().all(|m| m.frequency_hz.is_none()) {
        return Err(MeasurementError::file(
            path,
            "holds no observation at all; write at least one frequency_hz",
        ));
    }
    Ok(modes)
}
