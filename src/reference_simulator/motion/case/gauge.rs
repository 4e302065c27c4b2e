//! Strength of an effect by non-centrality: what is left of it after parameters and nuisances are projected out, in units of noise.
//!
//! The rows are those of the inverse dynamics of every record. Their noise is that of the test and, in quadrature, 1.5 per cent of the
//! force: what a careful test reproduces. Neighbouring rows share noise; a filter of first order takes it out.

use nalgebra::DVector;
use rayon::prelude::*;

use super::fit::{Blocks, Fitted, fitted};
use super::rows::{Rows, rms, rows};
use crate::TruthError;
use crate::draw::Draw;
use crate::motion::belief::{Belief, IDS};
use crate::motion::catalogue::{Use, directions};
use crate::motion::effect::Effect;
use crate::motion::path::Path;
use crate::motion::phase::Phase;
use crate::motion::run::{COARSE_S, Log, Machine, Sensors};
use crate::projection::Projection;
use crate::sizing::Sizing;

/// Relative error of the force that a careful test reproduces.
const REPRODUCED: f64 = 0.015;

/// One standard deviation of a weighed mass, relative.
const WEIGHED: f64 = 0.01;

/// How the size of an effect is looked for. A stop more or less makes its strength leap: the nearest side of the leap will do.
const SIZING: Sizing = Sizing { start: 0.3, trials: 25, close: 0.05, steps: [2.5, 2.0], narrow: 1e-3, leap: 0.7 };

/// A test: motions, sensors, what the engineer believes.
#[derive(Clone, Debug)]
pub struct Test {
    /// Motions by name.
    pub paths: Vec<(&'static str, Path)>,
    /// Which of them are held out.
    pub held_out: Vec<bool>,
    /// Sensors.
    pub sensors: Sensors,
    /// Belief.
    pub belief: Belief,
}

/// Standard deviation of the rows of one kind, and what neighbours share of it.
#[derive(Clone, Copy, Debug)]
struct Noise {
    sd_n: f64,
    shared: f64,
}

/// A test of one machine without effects.
pub struct Gauge {
    /// The test.
    pub test: Test,
    /// Rows of the machine without effects.
    pub base: Blocks,
    /// Its own best parameters.
    pub best: Fitted,
    /// What parameters and nuisances explain.
    pub explained: Projection,
    noise: Vec<Noise>,
}

/// What an effect leaves.
pub struct Left {
    /// Non-centrality of the whole test.
    pub noncentrality: f64,
    /// Whitened squares with the phase of their row.
    pub by_row: Vec<(Phase, f64)>,
}

impl Test {
    /// Exact records of a machine whose encoder is perfect.
    pub fn logs(&self, machine: &Machine) -> Vec<Log> {
        let mut perfect = machine.clone();
        perfect.drive.quantum_m = 0.0;
        self.paths.par_iter().map(|(_, path)| self.sensors.exact(&perfect.run(path, COARSE_S, None))).collect()
    }

    /// Their rows.
    pub fn blocks(&self, machine: &Machine) -> Blocks {
        self.logs(machine).iter().map(|log| rows(log, &self.belief)).collect()
    }

    /// Noise of each kind of rows, by one draw: records with it less records without.
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

    /// Chooses noise such that ordinary nuisances make the held-out gap `ratio` times its floor, the force's first, then the scale's.
    pub fn quieted(&mut self, machine: &Machine, ratio: f64, draw: &Draw) {
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

    /// Gap that the noise alone leaves on the held-out records.
    pub fn floor(&self, logs: &[Log], parameters: &[f64; 4], draw: &Draw) -> f64 {
        super::fit::gap(&self.noise_rows(logs, parameters, draw), &[0.0; 4], &self.held_out, true)
    }
}

impl Gauge {
    /// Prepares the gauge for a machine without effects.
    pub fn new(test: Test, machine: &Machine, usage: &Use, draw: &Draw) -> Result<Self, TruthError> {
        let logs = test.logs(machine);
        let base: Blocks = logs.iter().map(|log| rows(log, &test.belief)).collect();
        let rough = fitted(&base, &vec![1.0; base[0].len()], &test.held_out, &test.belief, None);
        let noise = noise(&base, &test.noise_rows(&logs, &rough.parameters, draw));
        let best = fitted(&base, &sd_of(&noise), &test.held_out, &test.belief, None);
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (k, id) in IDS.into_iter().enumerate().filter(|(_, id)| test.belief.has(id)) {
            let sd = match id {
                "moving_mass" if test.belief.is_weighed => WEIGHED * best.parameters[0],
                "moving_mass" => best.parameters[0],
                // Whole ranges: many times the forces in play.
                "viscous_friction" => 100.0 * best.parameters[1].abs().max(1.0),
                _ => 100.0 * best.parameters[2].abs().max(best.parameters[3].abs()).max(10.0),
            };
            let of = |rows: &Rows| {
                rows.columns.iter().zip(&rows.moves).map(|(columns, moves)| if *moves { sd * columns[k] } else { 0.0 }).collect()
            };
            columns.push(whitened(base.iter().map(|record| record.iter().map(of).collect()), &noise));
        }
        let untouched = residuals(&base, &best.parameters);
        for moved in directions(machine, usage.stroke_m) {
            let there = residuals(&test.blocks(&moved), &best.parameters);
            columns.push(whitened(differences(there, &untouched), &noise));
        }
        let explained = Projection::new(&columns)?;
        Ok(Self { test, base, best, noise, explained })
    }

    /// Standard deviation of each kind of rows.
    pub fn noise_n(&self) -> Vec<f64> {
        sd_of(&self.noise)
    }

    /// What stands in the rows of a machine beside those of the one without effects, whitened.
    pub fn change(&self, machine: &Machine) -> DVector<f64> {
        let there = residuals(&self.test.blocks(machine), &self.best.parameters);
        DVector::from_vec(whitened(differences(there, &residuals(&self.base, &self.best.parameters)), &self.noise))
    }

    /// What the effects of a machine leave.
    pub fn left(&self, machine: &Machine) -> Left {
        let change = self.change(machine);
        let residual = self.explained.residual(&change);
        let phases = self.base.iter().flatten().flat_map(|rows| rows.phases.iter().copied());
        let by_row = phases.zip(residual.iter().map(|value| value * value)).collect();
        Left { noncentrality: change.dot(&residual).max(0.0), by_row }
    }

    /// Size at which an effect has a non-centrality.
    pub fn size_for(&self, effect: &Effect, machine: &Machine, usage: &Use, wanted: f64) -> Result<f64, TruthError> {
        SIZING.size_for(effect.kind.id(), effect.kind.largest(), wanted, |size| {
            let mut with = machine.clone();
            effect.sized(size).put_into(&mut with, usage);
            Ok(self.left(&with).noncentrality)
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

/// Differences of rows in motion both times; 0 for the others.
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
        Noise { sd_n, shared: (neighbours / (sd_n * sd_n)).clamp(0.0, 0.95) }
    };
    (0..base[0].len()).map(of_kind).collect()
}

/// Values by record and kind over their noise, without what each shares with the one before it.
fn whitened(values: impl Iterator<Item = Vec<Vec<f64>>>, noise: &[Noise]) -> Vec<f64> {
    let mut out = Vec::new();
    for record in values {
        for (values, noise) in record.iter().zip(noise) {
            let sd = noise.sd_n * (1.0 - noise.shared * noise.shared).sqrt();
            out.extend((0..values.len()).map(|k| match k {
                0 => values[0] / noise.sd_n,
                _ => (values[k] - noise.shared * values[k - 1]) / sd,
            }));
        }
    }
    out
}
