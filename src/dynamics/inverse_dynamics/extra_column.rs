//! Columns of further points of a machine, beside that of the position loop's encoder.

use std::collections::BTreeMap;

use super::error::InverseError;
use super::extra_channel::ExtraChannel;
use super::preprocessing::{CARRIED_S, MotionSignal};
use super::rigid::Rigid;
use machine::{Machine, PointMotion as Kind};
use measurement::MotionRecord;
use numeric::statistics::{extremes, root_mean_square};

/// Periods of the filter's cut-off around a turn that count for nothing.
const BLURRED: f64 = 2.0;
/// Share of the fastest speed below which a direction is none.
const RESTS: f64 = 0.005;
/// Share of a play by which it lies aside of its ends while it is crossed.
const ASIDE: f64 = 1e-6;
/// Largest share of the travel that is left out after a turn.
const MOST: f64 = 0.2;

impl ExtraChannel {
    /// A column of the record's rate, thinned, weighed, without what says nothing of the transmission; 0 where it does not count.
    ///
    /// Two scales do not begin at one zero, drift apart with time, and are not read at one instant: a constant, what grows with time and what is in
    /// proportion to the velocity are taken out of what is recorded and of what is predicted alike, as least squares with all three free.
    pub fn thinned(&self, motion: &MotionSignal, column: &[f64]) -> Option<Vec<f64>> {
        Some(self.weighed(&motion.decimated(column)?))
    }
}

/// A column, the point it names, and what is said of one that names none.
enum ColumnName {
    Point(usize),
    Nothing(String),
    Other,
}

fn named(machine: &Machine, record: &MotionRecord, column: &str) -> Result<ColumnName, InverseError> {
    let Some((name, suffix)) = column.rsplit_once('_').filter(|(_, suffix)| ["m", "rad"].contains(suffix)) else {
        return Ok(ColumnName::Other);
    };
    let Some(point) = machine.point(name) else {
        let known: Vec<&str> = machine.points.iter().filter(|p| !p.fixed).map(|p| p.name.as_str()).collect();
        let told = format!("{}: column {column} names no point of the machine ({}) and is not used", record.source, known.join(", "));
        return Ok(ColumnName::Nothing(told));
    };
    let (wanted, moves) = match machine.points[point].motion {
        Kind::Translation => ("m", "moves along"),
        Kind::Rotation => ("rad", "turns"),
    };
    if suffix != wanted {
        let fault = format!("{}: column {column}: point «{name}» {moves}; write it as {name}_{wanted}", record.source);
        return Err(InverseError::Data(fault));
    }
    Ok(ColumnName::Point(point))
}

impl MotionSignal {
    /// With the columns of a record that name further points of a machine (`<point>_m`, `<point>_rad`), and what is to be said of others.
    ///
    /// About a turn or a rest, where play and wind-up go over to the other side, neither they nor the force are those of the rigid motion: these samples
    /// count for nothing.
    ///
    /// # Errors  a column has the unit of the other kind of point, or is constant; the machine's springs leave something loose.
    pub fn with_points(mut self, record: &MotionRecord, machine: &Machine, rigid: &Rigid) -> Result<(Self, Vec<String>), InverseError> {
        let (mut found, mut warnings) = (Vec::new(), Vec::new());
        let encoder = machine.drive.as_ref().ok_or(InverseError::NoDrive)?.position.encoder.at;
        for (column, samples) in &record.others {
            let point = match named(machine, record, column)? {
                ColumnName::Point(point) => point,
                ColumnName::Nothing(told) => {
                    warnings.push(told);
                    continue;
                }
                ColumnName::Other => continue,
            };
            let ratio = rigid.point_ratio(point);
            if point == encoder || ratio.abs() < 1e-12 {
                continue;
            }
            if samples.iter().all(|x| *x == samples[0]) {
                let fault = format!(
                    "{}: {column} is constant ({}); record the channel while the axis moves, or leave it out",
                    record.source, samples[0]
                );
                return Err(InverseError::Data(fault));
            }
            found.push((point, column.clone(), self.filtered(column, samples)?, ratio));
        }
        if found.is_empty() {
            return Ok((self, warnings));
        }
        if !Rigid::holds(machine, &machine.start()) {
            let fault = "the machine's springs leave a part of it loose, so that the error of its transmission does not follow";
            return Err(InverseError::NotRigid { fault: fault.into() });
        }
        let mut turning = vec![false; self.position_m.len()];
        for (_, _, reading, ratio) in &found {
            let error: Vec<f64> = reading.iter().zip(&self.position_m).map(|(y, x)| y / ratio - x).collect();
            let (low, high) = extremes(&error);
            turning.iter_mut().zip(self.turning(high - low)).for_each(|(all, own)| *all |= own);
        }
        self.silent.iter_mut().zip(&turning).for_each(|(silent, turning)| *silent |= turning);
        self.moves = self.kept().zip(&self.moves).map(|(at, moves)| *moves && !turning[at]).collect();
        let short = || InverseError::Data(format!("{}: is shorter than its filters need; record for longer", self.source));
        self.load = self.thinned(record.load.samples()).ok_or_else(short)?;
        for (point, column, reading, ratio) in found {
            let further = self.read(point, column, &reading, (&self.position_m, ratio), machine).ok_or_else(short)?;
            self.further.push(further);
        }
        Ok((self, warnings))
    }

    fn filtered(&self, column: &str, samples: &[f64]) -> Result<Vec<f64>, InverseError> {
        let short = || InverseError::Data(format!("{}: {column} is shorter than its filters need; record for longer", self.source));
        self.recipe.low_pass(self.step_s).forward_backward(samples).ok_or_else(short)
    }

    /// A further point's reading beside that of the loop's encoder, by which the point moves in a ratio.
    pub(super) fn read(
        &self,
        point: usize,
        column: String,
        reading: &[f64],
        (encoder, ratio): (&[f64], f64),
        machine: &Machine,
    ) -> Option<ExtraChannel> {
        // Two scales do not begin at one zero: it is taken out here, too, lest it drown the rest.
        let level = reading[0] - ratio * encoder[0];
        let error: Vec<f64> = reading.iter().zip(encoder).map(|(y, x)| y - ratio * x - level).collect();
        let tracking: Vec<f64> = reading.iter().zip(&self.command_m).map(|(y, r)| ratio * r - y).collect();
        let count = self.position_m.len();
        let time: Vec<f64> = (0..count).map(|i| i as f64 / count as f64).collect();
        let mut further = ExtraChannel {
            point,
            column,
            unit: if machine.points[point].motion == Kind::Translation { "m" } else { "rad" },
            error: self.decimated(&error)?,
            tracking: self.kept().map(|at| tracking[at]).collect(),
            beside: vec![self.decimated(&vec![1.0; count])?, self.decimated(&time)?, self.decimated(&self.velocity_m_s)?],
            counts: self.moves.clone(),
            weight: 1.0,
            told: None,
        };
        let (force, own) = (root_mean_square(self.load.iter().copied()), root_mean_square(further.recorded()));
        further.weight = force.zip(own).filter(|(_, own)| *own > 0.0).map_or(1.0, |(force, own)| force / own);
        Some(further)
    }

    /// Samples around a turn or a rest (and the beginning): until the encoder has gone on by a travel (m), and the filters' blur; before it as far, where
    /// the table may stand while the motor goes on.
    pub(super) fn turning(&self, travel_m: f64) -> Vec<bool> {
        let (v, x) = (&self.velocity_m_s, &self.position_m);
        let (low, high) = extremes(x);
        let travel_m = travel_m.min(MOST * (high - low));
        let rest = RESTS * v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let around = (BLURRED / (self.recipe.cutoff_hz * self.step_s)).ceil() as usize;
        let mut turning = vec![false; v.len()];
        let (mut direction, mut last, mut until) = (0.0, 0, None::<(usize, f64)>);
        for at in 0..v.len() {
            if self.silent[at] {
                direction = 0.0;
            } else if v[at].abs() > rest {
                if v[at].signum() != direction {
                    direction = v[at].signum();
                    let turn = x[last..=at].iter().copied().fold(x[at], |a, b| if direction > 0.0 { a.min(b) } else { a.max(b) });
                    let before = (0..last).rev().take_while(|i| (x[*i] - turn).abs() < travel_m).count();
                    turning[last.saturating_sub(before.max(around))..at].fill(true);
                    until = Some((at + around, turn));
                }
                last = at;
            }
            if let Some((time, turn)) = until {
                turning[at] = true;
                if at >= time && (x[at] - turn).abs() >= travel_m {
                    until = None;
                }
            }
        }
        turning
    }

    /// Lengths and periods of its channels in sums over all: the force, then each further point.
    pub fn channels(&self) -> impl Iterator<Item = (usize, Option<usize>)> + '_ {
        std::iter::repeat_n((self.load.len(), self.period), 1 + self.further.len())
    }
}

/// Force that the unit of each column weighs as much as, by what a fit leaves of both: each channel counts in units of its own noise.
///
/// `left` runs over the channels of the motions, with their weights as they are.
pub fn weights(left: &[f64], motions: &[&MotionSignal]) -> BTreeMap<String, f64> {
    // Squares and samples of the force, and of each column.
    let mut force = (0.0, 0usize);
    let mut columns: BTreeMap<String, (f64, usize)> = BTreeMap::new();
    let mut from = 0;
    let mut squares = |length: usize| {
        let part = &left[from..from + length];
        from += length;
        part.iter().map(|e| e * e).sum::<f64>()
    };
    for motion in motions {
        force.0 += squares(motion.load.len());
        force.1 += motion.moves.iter().filter(|m| **m).count();
        for further in &motion.further {
            let sum = columns.entry(further.column.clone()).or_default();
            sum.0 += squares(motion.load.len()) / (further.weight * further.weight);
            sum.1 += further.counts.iter().filter(|c| **c).count();
        }
    }
    let level = |(squares, count): (f64, usize)| (squares / count.max(1) as f64).sqrt();
    let found = columns.into_iter().map(|(column, sum)| (column, level(force) / level(sum)));
    found.filter(|(_, weight)| *weight > 0.0 && weight.is_finite()).collect()
}

/// Leaves out of the further points of motions what is read while a play of the machine is crossed; whether anything was.
pub fn mask_backlash_crossings(motions: &mut [MotionSignal], rigid: &Rigid, machine: &Machine, values: &[f64]) -> bool {
    motions.iter_mut().fold(false, |any, motion| any | motion.leave_crossings_out(rigid, machine, values))
}

impl MotionSignal {
    /// Leaves out of its further points what is read while a play of the machine is crossed, and comes to rest: where the machine foretells it, and where
    /// the reading goes on by half of the play within the filters' reach; where both are more than half of what counts, the first alone, or nothing.
    /// Whether anything was left out.
    fn leave_crossings_out(&mut self, rigid: &Rigid, machine: &Machine, values: &[f64]) -> bool {
        let Some(played) = rigid.played(machine, values, self) else { return false };
        let mut left_out = false;
        for (at, played) in played.into_iter().enumerate() {
            let (low, high) = extremes(&played);
            let between = |place: &f64| (low + ASIDE * (high - low)..high - ASIDE * (high - low)).contains(place);
            let foretold = self.around(&played.iter().map(between).collect::<Vec<bool>>(), 0.0);
            let jumps = self.jumps(&self.further[at].error, 0.5 * (high - low));
            let further = &mut self.further[at];
            let without = |crossed: &dyn Fn(usize) -> bool| -> Vec<bool> {
                further.counts.iter().enumerate().map(|(i, counts)| *counts && !crossed(i)).collect()
            };
            let count = |of: &[bool]| of.iter().filter(|counts| **counts).count();
            let kept = [without(&|i| foretold[i] || jumps[i]), without(&|i| foretold[i])];
            let Some(kept) = kept.into_iter().find(|kept| 2 * count(kept) >= count(&further.counts)) else { continue };
            left_out |= kept != further.counts;
            further.counts = kept;
        }
        left_out
    }

    /// Thinned samples around which a thinned column goes on by more than `most` within the filters' reach.
    fn jumps(&self, column: &[f64], most: f64) -> Vec<bool> {
        let around = (CARRIED_S / self.thinned_step_s()).ceil() as usize;
        let near = |i: usize| &column[i.saturating_sub(around)..(i + around + 1).min(column.len())];
        (0..column.len()).map(|i| extremes(near(i))).map(|(low, high)| high - low > most).collect()
    }

    /// Gives its further points these weights.
    pub fn weigh(&mut self, weights: &BTreeMap<String, f64>) {
        for further in &mut self.further {
            further.weight = weights.get(&further.column).copied().unwrap_or(further.weight);
        }
    }
}
