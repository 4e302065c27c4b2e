//! The machine under test: numbers, nuisance parameters, effects, and its noise-free responses.

use num_complex::Complex64;
use rayon::prelude::*;

use crate::Result;
use crate::effect::{Effect, EffectKind};
use crate::machine::assembly::Assembly;
use crate::machine::catalogue::DrawnMachine;
use crate::machine::nuisance::Nuisance;
use crate::machine::point::Channel;
use crate::parallel::in_order;

/// Complex values by station, channel and line.
pub type Curves = Vec<Vec<Vec<Complex64>>>;

/// A machine with its true parameters, nuisance parameters and effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Description, true joint values, nominal positions.
    pub drawn: DrawnMachine,
    /// Nuisance parameters.
    pub nuisance: Nuisance,
    /// Effects.
    pub effects: Vec<Effect>,
}

impl Subject {
    /// Returns the same subject without its effects.
    pub fn without_effects(&self) -> Self {
        Self { effects: Vec::new(), ..self.clone() }
    }

    /// Returns the same subject with causal losses.
    pub fn causal(&self) -> Self {
        let mut causal = self.clone();
        causal.nuisance.loss_dispersion = 1.0;
        causal
    }

    /// Returns the power of s between the values in the file and the stated quantity: +1 where a mobility is
    /// declared a receptance.
    pub fn misread_power(&self) -> f64 {
        self.effects
            .iter()
            .filter(|effect| effect.kind == EffectKind::FrfQuantity)
            .map(|effect| effect.sign)
            .sum()
    }

    /// Computes the receptances of some channels at stations, each a position and a force level.
    pub fn at_stations(
        &self,
        stations: &[(usize, f64)],
        channels: &[Channel],
        lines: &[Complex64],
    ) -> Result<Curves> {
        in_order(
            stations.par_iter().map(|&(position, level)| self.receptances(position, level, channels, lines)),
        )
    }

    /// Computes the receptances of some channels at a position, including gain and delay of each channel.
    pub fn receptances(
        &self,
        position: usize,
        level: f64,
        channels: &[Channel],
        lines: &[Complex64],
    ) -> Result<Vec<Vec<Complex64>>> {
        let machine = self.nuisance.applied(self.drawn.with_true_joints());
        let nut_m = self.drawn.nut_m[position] + self.nuisance.offsets_m[position];
        let assembly = Assembly::new(&machine, &self.effects, nut_m, level);
        let ports: Vec<_> = channels.iter().map(|&channel| assembly.port(channel)).collect();
        let mut out = assembly.structure.receptances(&ports, lines)?;
        let gain: f64 = self.effects.iter().map(Effect::gain).product();
        let delay_s: f64 = self.effects.iter().map(Effect::delay_s).sum();
        for (values, &channel) in out.iter_mut().zip(channels) {
            let (own_gain, own_delay_s) = self.nuisance.channel(channel);
            let factor = gain * (1.0 + own_gain);
            let delay_s = delay_s + own_delay_s;
            for (value, &s) in values.iter_mut().zip(lines) {
                *value *= (-s * delay_s).exp() * factor;
                if let Some(sensor) = self.nuisance.sensor {
                    *value *= sensor.at(s);
                }
            }
        }
        Ok(out)
    }
}

/// Returns points of the imaginary axis.
pub fn axis(lines_hz: &[f64]) -> Vec<Complex64> {
    lines_hz.iter().map(|hz| Complex64::new(0.0, 2.0 * std::f64::consts::PI * hz)).collect()
}
