//! The records of a diagnosis: what is fitted, cut into parts that are left out one after another, and what is ordinarily a little wrong.

use nalgebra::{DMatrix, DVector};

use crate::inverse_dynamics::{Fit, InverseError, Motion, Rigid, free_parameters, recorded};
use crate::machine::Machine;

/// Parts of a record that are left out one after another.
const PARTS: usize = 12;

/// Records to fit.
pub struct MotionData<'m> {
    /// Their motions.
    pub motions: Vec<&'m Motion>,
    /// Recorded force, thinned, record after record.
    pub y: DVector<f64>,
    /// The part that each sample belongs to.
    pub part: Vec<usize>,
    /// Number of parts.
    pub parts: usize,
}

impl<'m> MotionData<'m> {
    /// Cuts records into twelve parts each: of the time, or where the command repeats of its period, so that what is left out is left out of
    /// every period.
    pub fn new(motions: Vec<&'m Motion>) -> Self {
        let mut part = Vec::new();
        for (at, motion) in motions.iter().enumerate() {
            let (samples, cycle) = (motion.load.len(), motion.period.unwrap_or(motion.load.len()));
            part.extend((0..samples).map(|i| at * PARTS + (i % cycle) * PARTS / cycle));
        }
        MotionData { y: recorded(&motions), parts: PARTS * motions.len(), part, motions }
    }

    /// Samples.
    pub fn samples(&self) -> usize {
        self.y.len()
    }

    /// A column made record by record, thinned.
    pub fn column(&self, of: impl Fn(&Motion) -> Vec<f64>) -> DVector<f64> {
        let each = self.motions.iter().flat_map(|m| m.thinned(&of(m)).unwrap_or_default());
        DVector::from_iterator(self.samples(), each)
    }

    /// Lengths and periods of the records, in thinned samples.
    pub fn records(&self) -> Vec<(usize, Option<usize>)> {
        self.motions.iter().map(|m| (m.load.len(), m.period)).collect()
    }
}

/// Something that is ordinarily a little wrong: a column of force per standard deviation.
#[derive(Debug, Clone, PartialEq)]
pub struct Nuisance {
    /// Name.
    pub name: String,
    /// Force (N or N·m) of one standard deviation.
    pub column: DVector<f64>,
}

/// Standard deviation of the time between force and position, in samples of the record.
const SKEW: f64 = 0.5;
/// Standard deviations of friction and force that vary smoothly along the travel, and drift with time, as shares of the force's root mean square.
const ALONG: f64 = 0.015;
const DRIFT: f64 = 0.01;
/// Standard deviation of the force by which a change of direction is blurred, early or late, as a share of the force's root mean square.
const TURN: f64 = 0.3;

impl MotionData<'_> {
    /// What is ordinarily a little wrong: synchrony of force and position, the blur of filter and differences, also where
    /// the axis turns, friction and force that vary
    /// smoothly along the travel, their drift.
    ///
    /// # Source  widths: a drive holds its force for a sample, which comes half a sample late; guides are ground to a few percent of preload; friction of a
    /// warm axis changes by percents within a record.
    pub fn nuisances(&self, rigid: &Rigid, machine: &Machine, fit: &Fit) -> Vec<Nuisance> {
        let level = (self.y.norm_squared() / self.samples() as f64).sqrt();
        let force = |m: &Motion| rigid.force(machine, &fit.values, m);
        let slope = |x: &[f64]| crate::numeric::filter::central_differences(x);
        let direction = |m: &Motion| m.velocity_m_s.iter().map(|v| if *v == 0.0 { 0.0 } else { v.signum() }).collect::<Vec<f64>>();
        // One travel for all records: a place of the guide is the same place in each.
        let (low, high) =
            self.motions.iter().flat_map(|m| &m.position_m).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(*x), h.max(*x)));
        let angle = |x: f64, n: f64| std::f64::consts::PI * n * (x - low) / (high - low);
        let mut all = vec![
            Nuisance { name: "~synchrony".into(), column: self.column(|m| slope(&force(m)).iter().map(|d| SKEW * d).collect()) },
            Nuisance { name: "~blur".into(), column: self.column(|m| slope(&slope(&force(m)))) },
        ];
        // The filter lets the velocity change its sign a little before or after the force does, where the axis sticks as it turns.
        let turn = |m: &Motion| (1.0 / (m.recipe.cutoff_hz * m.step_s)).round().max(1.0) as usize;
        let late = |m: &Motion| {
            let (s, width) = (direction(m), turn(m));
            let at = |i: usize| s[i.min(s.len() - 1)];
            (0..s.len()).map(|i| 0.5 * TURN * level * (at(i + width) - at(i.saturating_sub(width)))).collect::<Vec<f64>>()
        };
        let blurred = |m: &Motion| {
            let (s, width) = (direction(m), turn(m));
            let mean = |i: usize| {
                let around = &s[i.saturating_sub(width)..(i + width + 1).min(s.len())];
                around.iter().sum::<f64>() / around.len() as f64
            };
            (0..s.len()).map(|i| TURN * level * (mean(i) - s[i])).collect::<Vec<f64>>()
        };
        all.push(Nuisance { name: "~turn late".into(), column: self.column(late) });
        all.push(Nuisance { name: "~turn blurred".into(), column: self.column(blurred) });
        for n in [1.0, 2.0, 3.0] {
            let wave = |m: &Motion| m.position_m.iter().map(|x| ALONG * level * angle(*x, n).cos()).collect::<Vec<f64>>();
            let turned = |m: &Motion| wave(m).iter().zip(direction(m)).map(|(w, s)| w * s).collect::<Vec<f64>>();
            all.push(Nuisance { name: format!("~friction along {n}"), column: self.column(turned) });
            all.push(Nuisance { name: format!("~force along {n}"), column: self.column(wave) });
        }
        let drift = |m: &Motion| {
            let count = m.position_m.len() as f64;
            (0..m.position_m.len()).map(|i| DRIFT * level * (2.0 * i as f64 / count - 1.0)).collect::<Vec<f64>>()
        };
        let turned = |m: &Motion| drift(m).iter().zip(direction(m)).map(|(w, s)| w * s).collect::<Vec<f64>>();
        all.push(Nuisance { name: "~drift of friction".into(), column: self.column(turned) });
        all.push(Nuisance { name: "~drift of force".into(), column: self.column(drift) });
        all
    }

    /// Free parameters of a machine.
    ///
    /// # Errors  as [`free_parameters`].
    pub fn free(&self, machine: &Machine, frozen: &[String]) -> Result<Vec<usize>, InverseError> {
        free_parameters(machine, frozen)
    }
}

/// Columns beside one another.
pub(super) fn beside(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let rows = parts[0].nrows();
    let columns: usize = parts.iter().map(|p| p.ncols()).sum();
    let mut all = DMatrix::zeros(rows, columns);
    let mut at = 0;
    for part in parts {
        all.columns_mut(at, part.ncols()).copy_from(*part);
        at += part.ncols();
    }
    all
}
