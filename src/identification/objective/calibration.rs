//! What belongs to the measurement rather than to the machine: gain and delay of channels, nut positions.

use super::FrfObjective;
use super::frf::SPAN;

/// Gain and delay of one measuring channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Channel {
    /// Point of the response.
    pub response: usize,
    /// Point of the excitation.
    pub excitation: usize,
    /// ln(gain).
    pub log_gain: f64,
    /// Delay (s).
    pub delay_s: f64,
}

impl FrfObjective<'_> {
    /// The same with channels of a known gain and delay: response and excitation, ln(gain) and delay (s).
    #[must_use]
    pub fn calibrated(mut self, known: &[Channel]) -> Self {
        for ((response, excitation), own) in self.channels.iter().zip(&mut self.calibration) {
            if let Some(channel) = known.iter().find(|c| (c.response, c.excitation) == (*response, *excitation)) {
                *own = (channel.log_gain, channel.delay_s);
            }
        }
        self
    }

    /// Gain and delay of each channel at a place.
    pub fn channels_at(&self, place: &[f64]) -> Vec<Channel> {
        let of = |((response, excitation), (log_gain, delay_s)): (&(usize, usize), (f64, f64))| Channel {
            response: *response,
            excitation: *excitation,
            log_gain,
            delay_s,
        };
        self.channels.iter().zip(self.here(place).channels).map(of).collect()
    }

    /// Standard deviations from one end of the coordinate of a nut position, gain or delay to the other.
    pub fn span(&self) -> f64 {
        SPAN
    }

    /// Nut positions that are fitted along: as stated (m) and by how much each is shifted at a place.
    pub fn nuts_at(&self, place: &[f64]) -> Vec<(f64, f64)> {
        let stated = |at: usize| self.records.iter().find(|r| r.nut == at).and_then(|r| r.operating.nut_m);
        self.here(place).nut_shift_m.into_iter().enumerate().filter_map(|(at, shift_m)| Some((stated(at)?, shift_m))).collect()
    }

    /// Whether anything is known of its coordinates before they are fitted.
    pub fn has_priors(&self) -> bool {
        self.nuts + self.free_channels() > 0 || self.free.iter().any(|i| self.machine.parameters[*i].prior.is_some())
    }
}
