//! Free functions: smooth functions of speed, position, acceleration or travel since the last reversal, added to the force or to the error of an
//! extra channel. They locate a discrepancy without naming its cause.

use nalgebra::DMatrix;

use super::data::MotionData;
use dynamics::inverse_dynamics::{MotionSignal, Rigid};
use machine::Machine;

/// A free function.
#[derive(Debug, Clone)]
pub(super) struct FreeFunction {
    /// Extra channel whose error it describes; `None` for the force.
    pub column: Option<String>,
    /// Variable of the function.
    pub over: &'static str,
    /// Form of dynamic stiffness that it resembles.
    pub shape: &'static str,
    /// Its columns.
    pub columns: DMatrix<f64>,
}

/// Number of knots of a function.
const KNOTS: usize = 9;

/// Returns all free functions, piecewise linear between knots at even quantiles of the samples.
pub(super) fn free_functions(data: &MotionData<'_>) -> Vec<FreeFunction> {
    let one = |_: &MotionSignal| None::<Vec<f64>>;
    let direction = |m: &MotionSignal| Some(m.direction());
    let mut shapes = Vec::new();
    for channel in data.channels() {
        let mut add = |over, shape, of: &dyn Fn(&MotionSignal) -> Vec<f64>, times: &dyn Fn(&MotionSignal) -> Option<Vec<f64>>| {
            let knots = knots(data.motions.iter().flat_map(|m| of(m)).collect());
            if knots.len() < 3 {
                return;
            }
            let columns: Vec<_> = (0..knots.len())
                .map(|at| {
                    data.channel(channel, |m| {
                        let hat = of(m).into_iter().map(|x| hat(&knots, at, x));
                        match times(m) {
                            None => hat.collect(),
                            Some(factor) => hat.zip(factor).map(|(h, f)| h * f).collect(),
                        }
                    })
                })
                .filter(|c| c.norm() > 0.0)
                .collect();
            if !columns.is_empty() {
                shapes.push(FreeFunction { column: channel.map(str::to_string), over, shape, columns: DMatrix::from_columns(&columns) });
            }
        };
        add("speed", "damping", &|m| m.velocity_m_s.clone(), &one);
        add("position", "stiffness", &|m| m.position_m.clone(), &one);
        add("position and direction", "other", &|m| m.position_m.clone(), &direction);
        add("acceleration", "mass", &|m| m.acceleration_m_s2.clone(), &one);
        add("acceleration and direction", "loss", &|m| m.acceleration_m_s2.clone(), &direction);
        add("travel since reversal", "relaxation", &|m| since_reversal(m), &direction);
    }
    shapes
}

/// Returns ln of the travel (µm, at least 0.1) since the last reversal.
fn since_reversal(motion: &MotionSignal) -> Vec<f64> {
    let mut from = motion.position_m[0];
    let mut before = 0.0;
    motion
        .position_m
        .iter()
        .zip(&motion.velocity_m_s)
        .map(|(x, v)| {
            if v * before < 0.0 {
                from = *x;
            }
            if *v != 0.0 {
                before = *v;
            }
            (1e6 * (x - from).abs()).max(0.1).ln()
        })
        .collect()
}

/// Returns knots at even quantiles of the samples, each clearly apart from the one before.
fn knots(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    let range = values[last] - values[0];
    let mut knots: Vec<f64> = (0..KNOTS).map(|i| values[i * last / (KNOTS - 1)]).collect();
    knots.dedup_by(|a, b| *a - *b < 0.02 * range);
    knots
}

/// Evaluates the hat function: one at a knot, zero at its neighbours.
fn hat(knots: &[f64], at: usize, x: f64) -> f64 {
    let x = x.clamp(knots[0], knots[knots.len() - 1]);
    if x == knots[at] {
        1.0
    } else if x < knots[at] {
        if at == 0 { 1.0 } else { ((x - knots[at - 1]) / (knots[at] - knots[at - 1])).max(0.0) }
    } else if at + 1 == knots.len() {
        1.0
    } else {
        ((knots[at + 1] - x) / (knots[at + 1] - knots[at])).max(0.0)
    }
}

/// Names of the points and joints of a machine at which forces arise.
pub(super) struct ForceLocations<'p> {
    machine: &'p Machine,
    motions: &'p [&'p MotionSignal],
    /// The joint with the largest friction; the driven point in a machine without friction.
    friction_location: String,
    /// The point with the largest inertia seen at the encoder.
    heaviest: Option<usize>,
}

impl<'p> ForceLocations<'p> {
    /// Determines the points of a machine with given values along motions.
    pub fn new(rigid: &Rigid, machine: &'p Machine, values: &[f64], motions: &'p [&'p MotionSignal]) -> Self {
        let friction_location =
            motions.iter().find_map(|m| rigid.joint_with_most_friction(machine, values, m)).map(|joint| machine.joints[joint].name.clone());
        let driven = || machine.drive.as_ref().map_or("drive".into(), |d| machine.points[d.on].name.clone());
        ForceLocations {
            machine,
            motions,
            friction_location: friction_location.unwrap_or_else(driven),
            heaviest: rigid.largest_mass_point(machine, values),
        }
    }

    /// Returns the location of a free function. Errors of an extra channel arise at its point, forces depending on acceleration at the largest
    /// inertia, all others at the largest friction.
    pub fn of(&self, over: &str, column: Option<&str>) -> String {
        let further = |name: &str| self.motions.iter().flat_map(|m| &m.extra_channels).find(|f| f.column == name).map(|f| f.point);
        let point = match column {
            Some(column) => further(column),
            None if over == "acceleration" => self.heaviest,
            None => None,
        };
        point.map_or_else(|| self.friction_location.clone(), |p| self.machine.points[p].name.clone())
    }
}
