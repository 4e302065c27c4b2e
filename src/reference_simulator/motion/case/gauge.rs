//! Strength of an effect by non-centrality: its whitened change after projection of parameters and nuisance
//! parameters.
//!
//! The rows are those of the inverse dynamics of every record. Their noise is the noise of the test and, in
//! quadrature, the 1.5 per cent of the force that a careful test reproduces. Neighbouring rows are
//! correlated; a first-order filter whitens them.

use nalgebra::DVector;
use rayon::prelude::*;

use super::fit::{Fitted, fitted, gap};
use super::rows::{Blocks, Row, rms, rows, scales};
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

/// Settings of the search for the size of an effect. One standstill more or less makes the strength jump; the
/// nearest value at the jump is accepted.
const SIZING: Sizing =
    Sizing { start: 0.3, trials: 25, close: 0.05, steps: [2.5, 2.0], narrow: 1e-3, leap: 0.7 };

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
        self.paths
            .par_iter()
            .map(|(_, path)| self.sensors.exact(&perfect.run(path, COARSE_S, None)))
            .collect()
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
            let less = |(a, b): (Row, Row)| Row { value: differ(&a, &b, parameters), columns: [0.0; 4], ..a };
            with.into_iter().zip(without).map(|(a, b)| a.into_iter().zip(b).map(less).collect()).collect()
        };
        logs.iter().enumerate().map(one).collect()
    }

    /// Sets the noise such that nuisance parameters make the held-out gap `ratio` times its floor: first the
    /// force noise, then the scale noise.
    pub fn set_noise(&mut self, machine: &Machine, ratio: f64, draw: &Draw) {
        let logs = self.logs(machine);
        let base: Blocks = logs.iter().map(|log| rows(log, &self.belief)).collect();
        let kinds = base[0].len();
        for kind in 0..kinds {
            let only: Blocks = base.iter().map(|record| vec![record[kind].clone()]).collect();
            let null = fitted(&only, &[1.0], &self.held_out, &self.belief, None);
            let wanted = null.held_out / (ratio * ratio - 1.0).sqrt();
            let force = rms(&base.iter().flat_map(|record| scales(&record[0])).collect::<Vec<f64>>());
            for _ in 0..3 {
                let noise = self.noise_rows(&logs, &null.parameters, draw);
                let only: Blocks =
                    noise.into_iter().map(|mut record| vec![record.swap_remove(kind)]).collect();
                let factor = wanted / gap(&only, &[0.0; 4], &self.held_out, true);
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
        gap(&self.noise_rows(logs, parameters, draw), &[0.0; 4], &self.held_out, true)
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
            let of = |rows: &Vec<Row>| {
                rows.iter().map(|row| if row.moves { sd * row.columns[k] } else { 0.0 }).collect()
            };
            columns.push(whitened(base.iter().map(|record| record.iter().map(of).collect()), &noise));
        }
        for moved in directions(machine, limits.stroke_m) {
            columns.push(whitened(differences(&test.blocks(&moved), &base, &best.parameters), &noise));
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
        DVector::from_vec(whitened(
            differences(&self.test.blocks(machine), &self.base, &self.best.parameters),
            &self.noise,
        ))
    }

    /// Returns the part of a machine's effects that parameters and nuisance parameters cannot explain.
    pub fn unexplained(&self, machine: &Machine) -> Unexplained {
        let change = self.change(machine);
        let residual = self.explained.residual(&change);
        let phases = self.base.iter().flatten().flatten().map(|row| row.phase);
        let by_row = phases.zip(residual.iter().map(|value| value * value)).collect();
        Unexplained { noncentrality: change.dot(&residual).max(0.0), by_row }
    }

    /// Finds the size at which an effect has a given non-centrality.
    pub fn size_for(
        &self,
        effect: &Effect,
        machine: &Machine,
        limits: &MotionLimits,
        wanted: f64,
    ) -> Result<f64> {
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

/// Returns the differences of the residuals of two sets of records, by record and kind.
fn differences(there: &Blocks, here: &Blocks, parameters: &[f64; 4]) -> impl Iterator<Item = Vec<Vec<f64>>> {
    let of_kind =
        |(a, b): (&Vec<Row>, &Vec<Row>)| a.iter().zip(b).map(|(a, b)| differ(a, b, parameters)).collect();
    there.iter().zip(here).map(move |(a, b)| a.iter().zip(b).map(of_kind).collect())
}

/// Returns the difference of the residuals of a row that is in motion in both records; else 0.
fn differ(there: &Row, here: &Row, parameters: &[f64; 4]) -> f64 {
    there.residual(parameters).zip(here.residual(parameters)).map_or(0.0, |(a, b)| a - b)
}

fn noise(base: &Blocks, drawn: &Blocks) -> Vec<Noise> {
    let of_kind = |kind: usize| {
        let all = |blocks: &Blocks| -> Vec<f64> {
            blocks.iter().flat_map(|record| &record[kind]).map(|row| row.value).collect()
        };
        let values = all(drawn);
        let model = REPRODUCED * rms(&all(base));
        let (sd, neighbours) = (
            rms(&values),
            values.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / values.len() as f64,
        );
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
