//! The machine under the hammer: numbers, nuisances and effects, and its noise-free responses.

use num_complex::Complex64;

use crate::TruthError;
use crate::effect::{Effect, EffectKind};
use crate::machine::assembly::Assembly;
use crate::machine::catalogue::Drawn;
use crate::machine::nuisance::Nuisance;
use crate::machine::point::Channel;

/// A machine with all that is true of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Description, true joints, nominal positions.
    pub drawn: Drawn,
    /// Nuisances.
    pub nuisance: Nuisance,
    /// Effects.
    pub effects: Vec<Effect>,
}

impl Subject {
    /// The same without its effects.
    pub fn without_effects(&self) -> Self {
        Self { effects: Vec::new(), ..self.clone() }
    }

    /// The same with losses that follow their cause.
    pub fn causal(&self) -> Self {
        let mut causal = self.clone();
        causal.nuisance.loss_dispersion = 1.0;
        causal
    }

    /// Power of s by which the file's numbers differ from what its manifest states: +1 where a mobility is called a receptance.
    pub fn misread_power(&self) -> f64 {
        self.effects.iter().filter(|effect| effect.kind == EffectKind::FrfQuantity).map(|effect| effect.sign).sum()
    }

    /// Receptances of some channels at a position, gain and delay of each channel included.
    pub fn receptances(
        &self,
        position: usize,
        level: f64,
        channels: &[Channel],
        lines: &[Complex64],
    ) -> Result<Vec<Vec<Complex64>>, TruthError> {
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
            }
        }
        Ok(out)
    }
}

/// Points of the imaginary axis.
pub fn axis(lines_hz: &[f64]) -> Vec<Complex64> {
    lines_hz.iter().map(|hz| Complex64::new(0.0, 2.0 * std::f64::consts::PI * hz)).collect()
}
