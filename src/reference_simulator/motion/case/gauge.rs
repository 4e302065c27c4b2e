//! Strength of an effect by non-centrality: its whitened change after projection of parameters and nuisance parameters.
//!
//! The rows are those of the inverse dynamics of every record. Their noise is the noise of the test and, in quadrature, the 1.5 per cent
//! of the force that a careful test reproduces. Neighbouring rows are correlated; a first-order filter whitens them.

use nalgebra::DVector;
use rayon::prelude::*;

use super::fit::{Blocks, Fitted, fitted};
use super::rows::{Rows, rms, rows};
use crate::Result;
use crate::draw::Draw;
use crate::motion::belief::{Belief, IDS};
use crate::motion::catalogue::{MotionLimits, directions};
use crate::motion::effect::Effect;
use crate::motion::path::Path;
use crate::motion::phase::Phase;
use crate::motion::run::{COARSE_S, Log, Machine, Sensors};
use crate::projection::Projection;
use crate::sizing::Sizing;

/// Relative error of the force that a careful test reproduces.
const REPRODUCED: f64 = 0.015;

/// Relative standard deviation of a weighed mass.
const WEIGHING_SD: f64 = 0.01;

/// Settings of the search for the size of an effect. One standstill more or less makes the strength jump; the nearest value at the jump
/// is accepted.
const SIZING: Sizing = Sizing { start: 0.3, trials: 25, close: 0.05, steps: [2.5, 2.0], narrow: 1e-3, leap: 0.7 };

/// A test: motions, sensors, description.
#[derive(Clone, Debug)]
pub struct Test {
    /// Motions with their names.
    pub paths: Vec<(&'static str, Path)>,
    /// Whether each motion is held out.
    pub held_out: Vec<bool>,
    /// Sensors.
    pub sensors: Sensors,
    /// The engineer's description.
    pub belief: Belief,
}

/// Standard deviation of the rows of one kind, and correlation of neighbours.
#[derive(Clone, Copy, Debug)]
struct Noise {
    sd_n: f64,
    correlation: f64,
}

/// Strength of effects in a test of one machine.
pub struct Gauge {
    /// The test.
    pub test: Test,
    /// Rows of the machine without effects.
    pub base: Blocks,
    /// Best parameters of the machine without effects.
    pub best: Fitted,
    /// Projection of parameters and nuisance parameters.
    pub explained: Projection,
    noise: Vec<Noise>,
}

/// Part of an effect that parameters and nuisance parameters cannot explain.
pub struct Unexplained {
    /// Non-centrality of the whole test.
    pub noncentrality: f64,
    /// Squares of the whitened residual, with the phase of each row.
    pub by_row: Vec<(Phase, f64)>,
}

impl Test {
    /// Simulates exact records of a machine with a perfect encoder.
    pub fn logs(&self, machine: &Machine) -> Vec<Log> {
        let mut perfect = machine.clone();
        perfect.drive.set.quantum_m = 0.0;
        self.paths.par_iter().map(|(_, path)| self.sensors.exact(&perfect.run(path, COARSE_S, None))).collect()
    }

    /// Returns the rows of these records.
    pub fn blocks(&self, machine: &Machine) -> Blocks {
        self.logs(machine).iter().map(|log| rows(log, &self.belief)).collect()
    }

    /// Returns the noise of each kind of rows from one random draw: records with noise minus records without.
    fn noise_rows(&self, logs: &[Log], parameters: &[f64; 4], draw: &Draw) -> Blocks {
        let one = |(k, log): (usize, &Log)| {
            let mut noisy = log.clone();
            self.sensors.disturb(&mut noisy, &mut draw.branch(k as u64));
            let (with, without) = (rows(&noisy, &self.belief), rows(log, &self.belief));
            let less = |(a, b): (Rows, &Rows)| Rows {
                values: differ(&a.residual(parameters), &b.residual(parameters)),
                columns: vec![[0.0; 4]; a.values.len()],
                ..a
            };
            with.into_iter().zip(&without).map(less).collect()
        };
        logs.iter().enumerate().map(one).collect()
    }

    /// Sets the noise such that nuisance parameters make the held-out gap `ratio` times its floor: first the force noise, then the scale
    /// noise.
    pub fn set_noise(&mut self, machine: &Machine, ratio: f64, draw: &Draw) {
        let logs = self.logs(machine);
        let base: Blocks = logs.iter().map(|log| rows(log, &self.belief)).collect();
        let kinds = base[0].len();
        for kind in 0..kinds {
            let only: Blocks = base.iter().map(|record| vec![record[kind].clone()]).collect();
            let null = fitted(&only, &[1.0], &self.held_out, &self.belief, None);
            let wanted = null.held_out / (ratio * ratio - 1.0).sqrt();
            let force = rms(&base.iter().flat_map(|record| record[0].scales()).collect::<Vec<f64>>());
            for _ in 0..3 {
                let noise = self.noise_rows(&logs, &null.parameters, draw);
                let only: Blocks = noise.into_iter().map(|mut record| vec![record.swap_remove(kind)]).collect();
                let factor = wanted / super::fit::gap(&only, &[0.0; 4], &self.held_out, true);
                if kind == 0 {
                    self.sensors.noise_n = (self.sensors.noise_n * factor).clamp(0.005 * force, 0.3 * force);
                } else {
                    self.sensors.noise_m = (self.sensors.noise_m * factor).clamp(5e-7, 2e-5);
                }
            }
        }
    }

    /// Returns the gap due to noise alone on the held-out records.
    pub fn floor(&self, logs: &[Log], parameters: &[f64; 4], draw: &Draw) -> f64 {
        super::fit::gap(&self.noise_rows(logs, parameters, draw), &[0.0; 4], &self.held_out, true)
    }
}

impl Gauge {
    /// Prepares the gauge for a machine without effects.
    pub fn new(test: Test, machine: &Machine, limits: &MotionLimits, draw: &Draw) -> Result<Self> {
        let logs = test.logs(machine);
        let base: Blocks = logs.iter().map(|log| rows(log, &test.belief)).collect();
        let rough = fitted(&base, &vec![1.0; base[0].len()], &test.held_out, &test.belief, None);
        let noise = noise(&base, &test.noise_rows(&logs, &rough.parameters, draw));
        let best = fitted(&base, &sd_of(&noise), &test.held_out, &test.belief, None);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, id) in IDS.into_iter().enumerate().filter(|(_, id)| test.belief.has(id)) {
            let sd = match id {
                "moving_mass" if test.belief.is_weighed => WEIGHING_SD * best.parameters[0],
                "moving_mass" => best.parameters[0],
                // A practically flat prior: many times the forces of the test.
                "viscous_friction" => 100.0 * best.parameters[1].abs().max(1.0),
                _ => 100.0 * best.parameters[2].abs().max(best.parameters[3].abs()).max(10.0),
            };
            let of = |rows: &Rows| {
                rows.columns.iter().zip(&rows.moves).map(|(columns, moves)| if *moves { sd * columns[k] } else { 0.0 }).collect()
            };
            columns.push(whitened(base.iter().map(|record| record.iter().map(of).collect()), &noise));
        }
        let untouched = residuals(&base, &best.parameters);
        for moved in directions(machine, limits.stroke_m) {
            let there = residuals(&test.blocks(&moved), &best.parameters);
            columns.push(whitened(differences(there, &untouched), &noise));
        }
        let explained = Projection::new(&columns)?;
        Ok(Self { test, base, best, noise, explained })
    }

    /// Returns the standard deviation of each kind of rows.
    pub fn noise_n(&self) -> Vec<f64> {
        sd_of(&self.noise)
    }

    /// Returns the whitened change of the rows from the machine without effects to the given machine.
    pub fn change(&self, machine: &Machine) -> DVector<f64> {
        let there = residuals(&self.test.blocks(machine), &self.best.parameters);
        DVector::from_vec(whitened(differences(there, &residuals(&self.base, &self.best.parameters)), &self.noise))
    }

    /// Returns the part of a machine's effects that parameters and nuisance parameters cannot explain.
    pub fn unexplained(&self, machine: &Machine) -> Unexplained {
        let change = self.change(machine);
        let residual = self.explained.residual(&change);
        let phases = self.base.iter().flatten().flat_map(|rows| rows.phases.iter().copied());
        let by_row = phases.zip(residual.iter().map(|value| value * value)).collect();
        Unexplained { noncentrality: change.dot(&residual).max(0.0), by_row }
    }

    /// Finds the size at which an effect has a given non-centrality.
    pub fn size_for(&self, effect: &Effect, machine: &Machine, limits: &MotionLimits, wanted: f64) -> Result<f64> {
        SIZING.size_for(effect.kind.name(), effect.kind.largest(), wanted, |size| {
            let mut with = machine.clone();
            effect.sized(size).apply_to(&mut with, limits);
            Ok(self.unexplained(&with).noncentrality)
        })
    }
}

fn sd_of(noise: &[Noise]) -> Vec<f64> {
    noise.iter().map(|noise| noise.sd_n).collect()
}

/// Residuals by record and kind.
type Values = Vec<Vec<Vec<Option<f64>>>>;

fn residuals(blocks: &Blocks, parameters: &[f64; 4]) -> Values {
    blocks.iter().map(|record| record.iter().map(|rows| rows.residual(parameters)).collect()).collect()
}

fn differences(there: Values, here: &Values) -> impl Iterator<Item = Vec<Vec<f64>>> {
    there.into_iter().zip(here).map(|(a, b)| a.iter().zip(b).map(|(a, b)| differ(a, b)).collect())
}

/// Returns the differences of rows that are in motion in both records; 0 for the others.
fn differ(there: &[Option<f64>], here: &[Option<f64>]) -> Vec<f64> {
    there.iter().zip(here).map(|(a, b)| a.zip(*b).map_or(0.0, |(a, b)| a - b)).collect()
}

fn noise(base: &Blocks, drawn: &Blocks) -> Vec<Noise> {
    let of_kind = |kind: usize| {
        let all = |blocks: &Blocks| -> Vec<f64> { blocks.iter().flat_map(|record| record[kind].values.iter().copied()).collect() };
        let values = all(drawn);
        let model = REPRODUCED * rms(&all(base));
        let (sd, neighbours) = (rms(&values), values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / values.len() as f64);
        let sd_n = sd.hypot(model);
        Noise { sd_n, correlation: (neighbours / (sd_n * sd_n)).clamp(0.0, 0.95) }
    };
    (0..base[0].len()).map(of_kind).collect()
}

/// Divides values by their noise and removes the correlation of neighbours, by record and kind.
fn whitened(values: impl Iterator<Item = Vec<Vec<f64>>>, noise: &[Noise]) -> Vec<f64> {
    let mut out = Vec::new();
    for record in values {
        for (values, noise) in record.iter().zip(noise) {
            let sd = noise.sd_n * (1.0 - noise.correlation * noise.correlation).sqrt();
            out.extend((0..values.len()).map(|k| match k {
                0 => values[0] / noise.sd_n,
                _ => (values[k] - noise.correlation * values[k - 1]) / sd,
            }));
        }
    }
    out
}
