//! A small neural network on the residual of a model: the share of a gap that can be learnt from command and
//! model output.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

use optimizer::{LeastSquares, NormalEquations, least_squares_within};

/// Number of neurons in the hidden layer.
pub const HIDDEN: usize = 10;
/// Number of weights and thresholds: two inputs and a threshold per neuron, one output weight per neuron, and
/// an output threshold.
pub const WEIGHTS: usize = 4 * HIDDEN + 1;

/// Largest magnitude of a weight, for inputs and outputs of unit variance (1).
const MAX_WEIGHT: f64 = 30.0;
/// Largest magnitude of an initial weight (1).
const MAX_INITIAL_WEIGHT: f64 = 2.0;
/// Weight decay: penalty of a unit sum of squared weights, as a share of the output's variance (1).
const DECAY: f64 = 1e-7;
/// Largest number of iterations of a training.
const ITERATIONS: u64 = 300;

/// One training sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Example {
    /// Command (m).
    pub command: f64,
    /// Position predicted by the model (m).
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
/// The inputs x₁, x₂ are command and modelled position, whitened: uncorrelated and of unit variance. This is
/// a linear transformation of the first layer's weights. Without it the difference of the inputs, which
/// carries the information, is too small to be learnt.
///
/// # Units      m in, m out
/// # Source     hybrid multi-domain, Eq. 21–25
/// # Deviation  trained by Levenberg–Marquardt from several initial weights, where the paper uses 2,000 steps
///   of gradient descent; weight decay
#[derive(Debug, Clone, PartialEq)]
pub struct NeuralResidual {
    mean: [f64; 2],
    /// Matrix from centred inputs to x₁, x₂, row by row.
    whitening: [[f64; 2]; 2],
    scale: f64,
    weights: Vec<f64>,
}

/// A trained network and its training error.
#[derive(Debug, Clone, PartialEq)]
pub struct Trained {
    /// The network.
    pub network: NeuralResidual,
    /// Root mean square of the residual over its examples (m).
    pub residual_m: f64,
    /// Number of evaluations of all trainings.
    pub evaluations: u64,
}

/// Why a network cannot be trained.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NetworkError {
    /// Too few examples.
    #[error("{0} examples are fewer than the {WEIGHTS} weights of the network; record longer")]
    TooFew(usize),
    /// An input or the deviation does not vary.
    #[error(
        "{0} does not vary in the examples, so there is nothing to learn; record a motion in which it varies"
    )]
    Constant(&'static str),
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

/// Computes the output of the network and, if `slopes` is given, its derivatives with respect to all weights.
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

/// Least-squares problem of a training.
struct Training<'e> {
    inputs: &'e [[f64; 2]],
    targets: &'e [f64],
}

impl Training<'_> {
    fn weights(place: &[f64]) -> Vec<f64> {
        place.iter().map(|u| MAX_WEIGHT * (2.0 * u - 1.0)).collect()
    }
}

impl LeastSquares for Training<'_> {
    fn dimension(&self) -> usize {
        WEIGHTS
    }

    fn chi_square(&self, place: &[f64]) -> f64 {
        let weights = Self::weights(place);
        let misfit: f64 =
            self.inputs.iter().zip(self.targets).map(|(x, d)| (output(&weights, *x, None) - d).powi(2)).sum();
        misfit + DECAY * self.targets.len() as f64 * weights.iter().map(|w| w * w).sum::<f64>()
    }

    fn normal(&self, place: &[f64]) -> NormalEquations {
        let weights = Self::weights(place);
        let mut normal = NormalEquations::zero(WEIGHTS);
        let mut row = [0.0; WEIGHTS];
        for (x, d) in self.inputs.iter().zip(self.targets) {
            let residual = output(&weights, *x, Some(&mut row)) - d;
            row.iter_mut().for_each(|s| *s *= 2.0 * MAX_WEIGHT);
            normal.add(1.0, residual, &row);
        }
        let decay = DECAY * self.targets.len() as f64;
        for (i, w) in weights.iter().enumerate() {
            row.fill(0.0);
            row[i] = 2.0 * MAX_WEIGHT;
            normal.add(decay, *w, &row);
        }
        normal.mirror();
        normal
    }
}

impl NeuralResidual {
    /// Trains on examples from several initial weights and keeps the best network.
    ///
    /// # Errors  fewer examples than weights; command, modelled position or deviation that does not vary.
    pub fn train(
        examples: &[Example],
        seed: u64,
        starts: usize,
        stop: &Arc<AtomicBool>,
    ) -> Result<Trained, NetworkError> {
        let count = examples.len();
        if count < WEIGHTS {
            return Err(NetworkError::TooFew(count));
        }
        let mean_of = |of: &dyn Fn(&Example) -> f64| examples.iter().map(of).sum::<f64>() / count as f64;
        let mean = [mean_of(&|e| e.command), mean_of(&|e| e.modelled)];
        let moment = |a: &dyn Fn(&Example) -> f64, b: &dyn Fn(&Example) -> f64| mean_of(&|e| a(e) * b(e));
        let (x, lag) =
            (|e: &Example| e.command - mean[0], |e: &Example| (e.modelled - mean[1]) - (e.command - mean[0]));
        // Gram–Schmidt on the command and on the lag of the model behind it.
        let variance = moment(&x, &x);
        let share = moment(&x, &lag) / variance;
        let rest = moment(&lag, &lag) - share * share * variance;
        let scale = mean_of(&|e| e.deviation * e.deviation).sqrt();
        for (name, size) in [("the command", variance), ("the modelled lag", rest), ("the deviation", scale)]
        {
            if !(size > 0.0 && size.is_finite()) {
                return Err(NetworkError::Constant(name));
            }
        }
        let (a, b) = (1.0 / variance.sqrt(), 1.0 / rest.sqrt());
        let mut network = NeuralResidual {
            mean,
            whitening: [[a, 0.0], [-(1.0 + share) * b, b]],
            scale,
            weights: vec![0.0; WEIGHTS],
        };
        let inputs: Vec<[f64; 2]> = examples.iter().map(|e| network.inputs(e.command, e.modelled)).collect();
        let targets: Vec<f64> = examples.iter().map(|e| e.deviation / scale).collect();
        let training = Training { inputs: &inputs, targets: &targets };
        let train = |at: usize| {
            let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add(at as u64));
            let place: Vec<f64> = (0..WEIGHTS)
                .map(|_| {
                    0.5 + 0.5 * MAX_INITIAL_WEIGHT / MAX_WEIGHT * (2.0 * generator.random::<f64>() - 1.0)
                })
                .collect();
            least_squares_within(&training, &place, &[], (ITERATIONS, 1e-5), stop)
        };
        let trained: Vec<_> = (0..starts.max(1)).into_par_iter().map(train).collect();
        let evaluations = trained.iter().map(|t| t.evaluations).sum();
        let best = trained.iter().min_by(|a, b| a.normal.chi_square.total_cmp(&b.normal.chi_square));
        if let Some(best) = best {
            network.weights = Training::weights(&best.place);
        }
        let squares: f64 =
            examples.iter().map(|e| (network.deviation(e.command, e.modelled) - e.deviation).powi(2)).sum();
        Ok(Trained { residual_m: (squares / count as f64).sqrt(), network, evaluations })
    }

    fn inputs(&self, command: f64, modelled: f64) -> [f64; 2] {
        let centred = [command - self.mean[0], modelled - self.mean[1]];
        self.whitening.map(|row| row[0] * centred[0] + row[1] * centred[1])
    }

    /// Returns the learnt measured less modelled position (m).
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

    /// Learns at two speeds a deviation that depends on position and direction, and predicts it at a third.
    /// Training is reproducible.
    #[test]
    fn recover_a_deviation_at_a_speed_without_training_data() {
        let truth = |x: f64, v: f64| 4e-5 * x + 3e-6 * (v / 0.02).tanh();
        let mut training = examples(30.0, truth);
        training.extend(examples(6.0, truth));
        let stop = Arc::default();
        let trained = NeuralResidual::train(&training, 1, 3, &stop).unwrap();
        assert_eq!(trained, NeuralResidual::train(&training, 1, 3, &stop).unwrap());
        let other = examples(12.0, truth);
        let rms = |of: &dyn Fn(&Example) -> f64| {
            (other.iter().map(|e| of(e).powi(2)).sum::<f64>() / other.len() as f64).sqrt()
        };
        let (before, after) =
            (rms(&|e| e.deviation), rms(&|e| e.deviation - trained.network.deviation(e.command, e.modelled)));
        assert!(
            after < 0.1 * before && trained.residual_m < 0.05 * before,
            "{before:e} {after:e} {:e}",
            trained.residual_m
        );
    }

    #[test]
    fn limit_derivatives_agree_with_differences() {
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
    fn refuse_too_few_or_constant_examples() {
        let stop = Arc::default();
        let all = examples(6.0, |x, _| x);
        assert_eq!(NeuralResidual::train(&all[..40], 0, 1, &stop).unwrap_err(), NetworkError::TooFew(40));
        let flat = examples(6.0, |_, _| 0.0);
        assert_eq!(
            NeuralResidual::train(&flat, 0, 1, &stop).unwrap_err(),
            NetworkError::Constant("the deviation")
        );
    }
}
