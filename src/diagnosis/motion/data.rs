//! The records of a diagnosis: what is fitted, cut into parts that are left out one after another, and what is ordinarily a little wrong.

use nalgebra::{DMatrix, DVector};

use crate::inverse_dynamics::{Fit, InverseError, Motion, Rigid, free_parameters, recorded};
use crate::machine::{Machine, Operating, Value};

/// Parts of a record that are left out one after another.
const PARTS: usize = 12;

/// Records to fit.
pub struct MotionData<'m> {
    /// Their motions.
    pub motions: Vec<&'m Motion>,
    /// Recorded force, thinned, and the transmission error of further points, record after record.
    pub y: DVector<f64>,
    /// Columns of further points, each once.
    pub columns: Vec<String>,
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
            // All channels of a time are left out together.
            for (samples, period) in motion.channels() {
                let cycle = period.unwrap_or(samples);
                part.extend((0..samples).map(|i| at * PARTS + (i % cycle) * PARTS / cycle));
            }
        }
        let mut columns: Vec<String> = motions.iter().flat_map(|m| &m.further).map(|f| f.column.clone()).collect();
        columns.sort();
        columns.dedup();
        MotionData { y: recorded(&motions), columns, parts: PARTS * motions.len(), part, motions }
    }

    /// Samples.
    pub fn samples(&self) -> usize {
        self.y.len()
    }

    /// A column of force made record by record, thinned.
    pub fn column(&self, of: impl Fn(&Motion) -> Vec<f64>) -> DVector<f64> {
        self.channel(None, of)
    }

    /// The same of one channel, the force or a column of a further point; nothing in the others.
    pub fn channel(&self, column: Option<&str>, of: impl Fn(&Motion) -> Vec<f64>) -> DVector<f64> {
        let mut all = Vec::with_capacity(self.samples());
        for m in &self.motions {
            let made = of(m);
            let nothing = || vec![0.0; m.load.len()];
            all.extend(if column.is_none() { m.thinned(&made).unwrap_or_else(nothing) } else { nothing() });
            for further in &m.further {
                let own = column == Some(further.column.as_str());
                all.extend(if own { further.thinned(m, &made).unwrap_or_else(nothing) } else { nothing() });
            }
        }
        DVector::from_vec(all)
    }

    /// A column of friction in units of the drive's force, with what further points give way under it.
    fn rubbing(&self, of: impl Fn(&Motion) -> Vec<f64>, rigid: &Rigid, machine: &Machine, fit: &Fit) -> DVector<f64> {
        let mut sum = self.column(&of);
        for column in &self.columns {
            let gives = |m: &Motion| {
                let at = m.further.iter().position(|f| f.column == *column);
                let gives = at.map_or(0.0, |at| rigid.rubbed(machine, &fit.values, m)[at]);
                of(m).into_iter().map(|f| gives * f).collect::<Vec<f64>>()
            };
            sum += self.channel(Some(column), gives);
        }
        sum
    }

    /// All channels: the force, and columns of further points.
    pub fn channels(&self) -> impl Iterator<Item = Option<&str>> {
        std::iter::once(None).chain(self.columns.iter().map(|c| Some(c.as_str())))
    }

    /// Root mean square of the recorded force over all of its samples.
    fn level(&self) -> f64 {
        let (mut squares, mut samples) = (0.0, 0);
        for m in &self.motions {
            squares += m.load.iter().map(|x| x * x).sum::<f64>();
            samples += m.load.len();
        }
        (squares / samples.max(1) as f64).sqrt()
    }

    /// Lengths and periods of the records' channels, in thinned samples.
    pub fn records(&self) -> Vec<(usize, Option<usize>)> {
        self.motions.iter().flat_map(|m| m.channels()).collect()
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
const SKEW: f64 = 0.25;
/// Standard deviations of friction and force that vary smoothly along the travel, and drift with time, as shares of the force's root mean square.
const ALONG: f64 = 0.015;
/// Half waves along the travel that are ordinary; those of more than three the less, the shorter they are.
const WAVES: u32 = 7;
const DRIFT: f64 = 0.01;
/// Travels (m) over which friction ordinarily builds up before it slides, the wind-up of the parts that carry it included, and the standard
/// deviation of its share that does.
const REACHES: [(f64, f64); 2] = [(1e-6, 1.0), (4e-6, 0.5)];
/// Standard deviation of a scale's error along the travel, per travel.
const SCALE: f64 = 2e-6;

impl MotionData<'_> {
    /// What is ordinarily a little wrong: synchrony of force and position, the blur of filter and differences, friction and force that vary
    /// smoothly along the travel, their drift, and the micrometres that rolling elements and seals give way before they slide.
    ///
    /// # Source  widths: a drive holds its force for a sample, which comes half a sample late; guides are ground to a few percent of preload; friction of a
    /// warm axis changes by percents within a record.
    pub fn nuisances(&self, rigid: &Rigid, machine: &Machine, fit: &Fit) -> Vec<Nuisance> {
        let level = if self.columns.is_empty() { (self.y.norm_squared() / self.samples() as f64).sqrt() } else { self.level() };
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
        let described = self.column(force);
        for (reach_m, sd) in REACHES {
            let elastic = elastic(machine, &fit.values, rigid, reach_m);
            let column = sd * (self.column(|m| rigid.force(&elastic, &fit.values, m)) - &described);
            all.push(Nuisance { name: format!("~slides after {:.0} µm", 1e6 * reach_m), column });
        }
        for n in (1..=WAVES).map(f64::from) {
            let size = ALONG * level * (3.0 / n).min(1.0);
            let wave = |m: &Motion| m.position_m.iter().map(|x| size * angle(*x, n).cos()).collect::<Vec<f64>>();
            let turned = |m: &Motion| wave(m).iter().zip(direction(m)).map(|(w, s)| w * s).collect::<Vec<f64>>();
            all.push(Nuisance { name: format!("~friction along {n}"), column: self.rubbing(turned, rigid, machine, fit) });
            all.push(Nuisance { name: format!("~force along {n}"), column: self.column(wave) });
        }
        let drift = |m: &Motion| {
            let count = m.position_m.len() as f64;
            (0..m.position_m.len()).map(|i| DRIFT * level * (2.0 * i as f64 / count - 1.0)).collect::<Vec<f64>>()
        };
        let turned = |m: &Motion| drift(m).iter().zip(direction(m)).map(|(w, s)| w * s).collect::<Vec<f64>>();
        all.push(Nuisance { name: "~drift of friction".into(), column: self.rubbing(turned, rigid, machine, fit) });
        all.push(Nuisance { name: "~drift of force".into(), column: self.column(drift) });
        self.columns.iter().for_each(|column| self.further_nuisances(column, rigid, angle, &mut all));
        all
    }

    /// What is ordinarily a little wrong of a further point beside what [`Further::thinned`](crate::inverse_dynamics::Further::thinned) takes out:
    /// errors of both scales and of the way that vary smoothly along the travel.
    ///
    /// # Source  width: linear scales of machine tools are sold as good to ±3 µm (some to ±5 µm) per metre
    fn further_nuisances(&self, column: &str, rigid: &Rigid, angle: impl Fn(f64, f64) -> f64, all: &mut Vec<Nuisance>) {
        let ratio = |m: &Motion| m.further.iter().find(|f| f.column == column).map_or(0.0, |f| rigid.point_ratio(f.point));
        let travel = |m: &Motion| {
            m.position_m.iter().fold(f64::NEG_INFINITY, |a, x| a.max(*x)) - m.position_m.iter().fold(f64::INFINITY, |a, x| a.min(*x))
        };
        for n in [1.0, 2.0, 3.0] {
            let wave = |m: &Motion| {
                let size = ratio(m) * SCALE * travel(m);
                m.position_m.iter().map(|x| size * angle(*x, n).cos()).collect::<Vec<f64>>()
            };
            all.push(Nuisance { name: format!("~scale of {column} along {n}"), column: self.channel(Some(column), wave) });
        }
    }

    /// Free parameters of a machine.
    ///
    /// # Errors  as [`free_parameters`].
    pub fn free(&self, machine: &Machine, frozen: &[String]) -> Result<Vec<usize>, InverseError> {
        free_parameters(machine, frozen)
    }
}

/// The machine with dry friction that builds up over a travel (m of the reading) where it is described to be there at once.
fn elastic(machine: &Machine, values: &[f64], rigid: &Rigid, reach_m: f64) -> Machine {
    let mut elastic = machine.clone();
    for joint in &mut elastic.joints {
        let number = |value: &Value| value.at(values, &Operating::default());
        let (level, way) = (number(&joint.friction.coulomb), rigid.ratio(&joint.on).abs() * reach_m);
        if level > 0.0 && way > 0.0 && number(&joint.friction.presliding_stiffness) == 0.0 {
            joint.friction.presliding_stiffness = Value::number(level / way);
        }
    }
    elastic
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
