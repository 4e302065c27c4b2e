//! A small network on what a model leaves: the share of a gap that can be learnt at all.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use optimizer::{LeastSquares, NormalEquations, least_squares_within};

/// Neurons of the hidden layer.
pub const HIDDEN: usize = 10;
/// Weights and thresholds: two inputs and a threshold to each neuron, each neuron and a threshold to the output.
pub const WEIGHTS: usize = 4 * HIDDEN + 1;

/// Ends of the weights, on inputs and outputs of unit variance.
const LARGEST: f64 = 30.0;
/// Weights of a beginning, at most.
const BEGINNING: f64 = 2.0;
/// Share of the output's variance that the squares of the weights count as, all together of size one.
const DECAY: f64 = 1e-7;
/// Most iterations of a training.
const ITERATIONS: u64 = 300;

/// One sample to learn from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// Command (m).
    pub command: f64,
    /// Position as the model has it (m).
    pub modelled: f64,
    /// Measured less modelled position (m).
    pub deviation: f64,
}

/// The network 2–10–1 of the paper: sigmoid neurons, a linear output.
///
/// ```text
/// d = Σ v_j·f(w_1j·x₁ + w_2j·x₂ − a_j) − b,     f(x) = 1/(1 + e^{−x})
/// ```
///
/// The inputs x₁, x₂ are command and modelled position, turned so that they are uncorrelated and of unit variance: a linear change of the first layer's
/// weights, without which their difference, which is what matters, hardly shows.
///
/// # Units      m in, m out
/// # Source     hybrid multi-domain, Eq. 21–25
/// # Deviation  trained by Levenberg–Marquardt from several beginnings, where the paper descends the gradient 2,000 times; a slight decay of weights
#[derive(Debug, Clone, PartialEq)]
pub struct NeuralResidual {
    mean: [f64; 2],
    /// Rows that take centred inputs to x₁, x₂.
    whitening: [[f64; 2]; 2],
    scale: f64,
    weights: Vec<f64>,
}

/// A network and how its training went.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The network.
    pub network: NeuralResidual,
    /// Root mean square of what it leaves of its examples (m).
    pub left_m: f64,
    /// Evaluations of all trainings.
    pub evaluations: u64,
}

/// Why nothing can be learnt.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Too few examples.
    #[error("{0} examples are fewer than the {WEIGHTS} weights of the network; record longer")]
    TooFew(usize),
    /// Inputs or deviations that do not vary.
    #[error("{0} does not vary in the examples; there is nothing to learn from")]
    Constant(&'static str),
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Output of the second layer, and its derivatives with all weights where there is room for them.
fn output(weights: &[f64], x: [f64; 2], slopes: Option<&mut [f64; WEIGHTS]>) -> f64 {
    let mut sum = -weights[WEIGHTS - 1];
    let mut h = [0.0; HIDDEN];
    for (j, w) in weights[..4 * HIDDEN].chunks_exact(4).enumerate() {
        h[j] = sigmoid(w[0] * x[0] + w[1] * x[1] - w[2]);
        sum += w[3] * h[j];
    }
    if let Some(slopes) = slopes {
        for (j, w) in weights[..4 * HIDDEN].chunks_exact(4).enumerate() {
            let inner = w[3] * h[j] * (1.0 - h[j]);
            slopes[4 * j..4 * j + 4].copy_from_slice(&[inner * x[0], inner * x[1], -inner, h[j]]);
        }
        slopes[WEIGHTS - 1] = -1.0;
    }
    sum
}

struct Lesson<'e> {
    inputs: &'e [[f64; 2]],
    wanted: &'e [f64],
}

impl Lesson<'_> {
    fn weights(place: &[f64]) -> Vec<f64> {
        place.iter().map(|u| LARGEST * (2.0 * u - 1.0)).collect()
    }
}

impl LeastSquares for Lesson<'_> {
    fn dimension(&self) -> usize {
        WEIGHTS
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let weights = Self::weights(place);
        let misfit: f64 = self.inputs.iter().zip(self.wanted).map(|(x, d)| (output(&weights, *x, None) - d).powi(2)).sum();
        misfit + DECAY * self.wanted.len() as f64 * weights.iter().map(|w| w * w).sum::<f64>()
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let weights = Self::weights(place);
        let mut normal = NormalEquations::zero(WEIGHTS);
        let mut row = [0.0; WEIGHTS];
        for (x, d) in self.inputs.iter().zip(self.wanted) {
            let residual = output(&weights, *x, Some(&mut row)) - d;
            row.iter_mut().for_each(|s| *s *= 2.0 * LARGEST);
            normal.add(1.0, residual, &row);
        }
        let decay = DECAY * self.wanted.len() as f64;
        for (i, w) in weights.iter().enumerate() {
            row.fill(0.0);
            row[i] = 2.0 * LARGEST;
            normal.add(decay, *w, &row);
        }
        normal.mirror();
        normal
    }
}

impl NeuralResidual {
    /// Trains on examples from several beginnings, and keeps the best.
    ///
    /// # Errors  fewer examples than weights; command, modelled position or deviation that does not vary.
    pub fn train(examples: &[Example], seed: u64, beginnings: usize, stop: &Arc<AtomicBool>) -> Result<Trained, NetworkError> {
        let count = examples.len();
        if count < WEIGHTS {
            return Err(NetworkError::TooFew(count));
        }
        let mean_of = |of: &dyn Fn(&Example) -> f64| examples.iter().map(of).sum::<f64>() / count as f64;
        let mean = [mean_of(&|e| e.command), mean_of(&|e| e.modelled)];
        let moment = |a: &dyn Fn(&Example) -> f64, b: &dyn Fn(&Example) -> f64| mean_of(&|e| a(e) * b(e));
        let (x, lag) = (|e: &Example| e.command - mean[0], |e: &Example| (e.modelled - mean[1]) - (e.command - mean[0]));
        // Gram–Schmidt on the command and on what the model lags behind it.
        let along = moment(&x, &x);
        let share = moment(&x, &lag) / along;
        let rest = moment(&lag, &lag) - share * share * along;
        let scale = mean_of(&|e| e.deviation * e.deviation).sqrt();
        for (what, size) in [("the command", along), ("the modelled lag", rest), ("the deviation", scale)] {
            if !(size > 0.0 && size.is_finite()) {
                return Err(NetworkError::Constant(what));
            }
        }
        let (a, b) = (1.0 / along.sqrt(), 1.0 / rest.sqrt());
        let mut network = NeuralResidual { mean, whitening: [[a, 0.0], [-(1.0 + share) * b, b]], scale, weights: vec![0.0; WEIGHTS] };
        let inputs: Vec<[f64; 2]> = examples.iter().map(|e| network.inputs(e.command, e.modelled)).collect();
        let wanted: Vec<f64> = examples.iter().map(|e| e.deviation / scale).collect();
        let lesson = Lesson { inputs: &inputs, wanted: &wanted };
        let train = |at: usize| {
            let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(at as u64));
            let place: Vec<f64> = (0..WEIGHTS).map(|_| 0.5 + 0.5 * BEGINNING / LARGEST * (2.0 * generator.random::<f64>() - 1.0)).collect();
            least_squares_within(&lesson, &place, &[], (ITERATIONS, 1e-5), stop)
        };
        let trained: Vec<_> = (0..beginnings.max(1)).into_par_iter().map(train).collect();
        let evaluations = trained.iter().map(|t| t.evaluations).sum();
        let best = trained.iter().min_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
        if let Some(best) = best {
            network.weights = Lesson::weights(&best.place);
        }
        let left: f64 = examples.iter().map(|e| (network.deviation(e.command, e.modelled) - e.deviation).powi(2)).sum();
        Ok(Trained { left_m: (left / count as f64).sqrt(), network, evaluations })
    }

    fn inputs(&self, command: f64, modelled: f64) -> [f64; 2] {
        let centred = [command - self.mean[0], modelled - self.mean[1]];
        self.whitening.map(|row| row[0] * centred[0] + row[1] * centred[1])
    }

    /// Measured less modelled position (m) as it has learnt it.
    pub fn deviation(&self, command: f64, modelled: f64) -> f64 {
        self.scale * output(&self.weights, self.inputs(command, modelled), None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn examples(period_s: f64, of: impl Fn(f64, f64) -> f64) -> Vec<Example> {
        (0..2000)
            .map(|i| {
                let t = i as f64 * 2.0 * period_s / 2000.0;
                let (sin, cos) = (std::f64::consts::TAU * t / period_s).sin_cos();
                let (command, speed) = (0.1 * sin, 0.1 * cos * std::f64::consts::TAU / period_s);
                Example { command, modelled: command - speed / 120.0, deviation: of(command, speed) }
            })
            .collect()
    }

    /// Learns at two speeds what depends on place and direction, and foretells it at a third; the same twice.
    #[test]
    fn recover_a_deviation_at_a_speed_that_was_not_shown() {
        let truth = |x: f64, v: f64| 4e-5 * x + 3e-6 * (v / 0.02).tanh();
        let mut shown = examples(30.0, truth);
        shown.extend(examples(6.0, truth));
        let stop = Arc::default();
        let trained = NeuralResidual::train(&shown, 1, 3, &stop).unwrap();
        assert_eq!(trained, NeuralResidual::train(&shown, 1, 3, &stop).unwrap());
        let other = examples(12.0, truth);
        let rms = |of: &dyn Fn(&Example) -> f64| (other.iter().map(|e| of(e).powi(2)).sum::<f64>() / other.len() as f64).sqrt();
        let (before, after) = (rms(&|e| e.deviation), rms(&|e| e.deviation - trained.network.deviation(e.command, e.modelled)));
        assert!(after < 0.1 * before && trained.left_m < 0.05 * before, "{before:e} {after:e} {:e}", trained.left_m);
    }

    /// Derivatives by differences.
    #[test]
    fn limit_slopes_are_those_of_differences() {
        let weights: Vec<f64> = (0..WEIGHTS).map(|i| ((i * 37 % 23) as f64 - 11.0) / 7.0).collect();
        let mut slopes = [0.0; WEIGHTS];
        let x = [0.3, -1.1];
        output(&weights, x, Some(&mut slopes));
        for i in 0..WEIGHTS {
            let moved = |by: f64| {
                let mut w = weights.clone();
                w[i] += by;
                output(&w, x, None)
            };
            assert!(((moved(1e-6) - moved(-1e-6)) / 2e-6 - slopes[i]).abs() < 1e-8, "{i}");
        }
    }

    #[test]
    fn refuse_what_nothing_can_be_learnt_from() {
        let stop = Arc::default();
        let all = examples(6.0, |x, _| x);
        assert_eq!(NeuralResidual::train(&all[..40], 0, 1, &stop).unwrap_err(), NetworkError::TooFew(40));
        let flat = examples(6.0, |_, _| 0.0);
        assert_eq!(NeuralResidual::train(&flat, 0, 1, &stop).unwrap_err(), NetworkError::Constant("the deviation"));
    }
}
