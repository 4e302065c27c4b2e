//! Free functions: smooth functions of speed, position, acceleration or travel since the last reversal, added
//! to the force or to the error of an extra channel. They locate a discrepancy without naming its cause.

use nalgebra::{DMatrix, DVector};

use super::data::MotionData;
use dynamics::inverse_dynamics::{MotionSignal, Rigid};
use machine::Machine;

/// Variable of a free function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variable {
    Speed,
    Position,
    PositionAndDirection,
    Acceleration,
    AccelerationAndDirection,
    TravelSinceReversal,
}

impl Variable {
    const ALL: [Variable; 6] = [
        Variable::Speed,
        Variable::Position,
        Variable::PositionAndDirection,
        Variable::Acceleration,
        Variable::AccelerationAndDirection,
        Variable::TravelSinceReversal,
    ];

    /// Returns its name.
    pub fn word(self) -> &'static str {
        match self {
            Variable::Speed => "speed",
            Variable::Position => "position",
            Variable::PositionAndDirection => "position and direction",
            Variable::Acceleration => "acceleration",
            Variable::AccelerationAndDirection => "acceleration and direction",
            Variable::TravelSinceReversal => "travel since reversal",
        }
    }

    /// Returns the form of dynamic stiffness that a function of it resembles.
    pub fn shape(self) -> &'static str {
        match self {
            Variable::Speed => "damping",
            Variable::Position => "stiffness",
            Variable::PositionAndDirection => "other",
            Variable::Acceleration => "mass",
            Variable::AccelerationAndDirection => "loss",
            Variable::TravelSinceReversal => "relaxation",
        }
    }

    /// Returns its samples along a motion.
    fn samples(self, motion: &MotionSignal) -> Vec<f64> {
        match self {
            Variable::Speed => motion.velocity_m_s.clone(),
            Variable::Position | Variable::PositionAndDirection => motion.position_m.clone(),
            Variable::Acceleration | Variable::AccelerationAndDirection => motion.acceleration_m_s2.clone(),
            Variable::TravelSinceReversal => since_reversal(motion),
        }
    }

    /// Whether the function changes its sign with the direction of the motion.
    fn is_directed(self) -> bool {
        matches!(
            self,
            Variable::PositionAndDirection
                | Variable::AccelerationAndDirection
                | Variable::TravelSinceReversal
        )
    }
}

/// A free function.
#[derive(Debug, Clone)]
pub(super) struct FreeFunction {
    /// Extra channel whose error it describes; `None` for the force.
    pub column: Option<String>,
    /// Its columns.
    pub columns: DMatrix<f64>,
    pub variable: Variable,
    knots: Vec<f64>,
    /// Knots that have a column.
    used: Vec<usize>,
}

impl FreeFunction {
    /// Returns its columns on other records.
    pub fn columns_on(&self, data: &MotionData<'_>) -> DMatrix<f64> {
        let column = |at: &usize| hat_column(data, self.column.as_deref(), self.variable, &self.knots, *at);
        DMatrix::from_columns(&self.used.iter().map(column).collect::<Vec<_>>())
    }

    /// Returns the penalty on each of its columns. Hat functions sum to columns of the machine (a constant, a
    /// direction): a small ridge penalty separates them.
    pub fn ridge(&self) -> f64 {
        1e-3 * self.columns.norm_squared() / self.columns.ncols() as f64
    }
}

/// A free function with its figures.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatedMotion {
    /// Joint or point of the machine at which such a force arises.
    pub interface: String,
    /// Extra channel whose transmission error it describes; `None` for the force.
    pub column: Option<String>,
    /// Variable of the function.
    pub over: &'static str,
    /// Form of dynamic stiffness that it resembles.
    pub shape: &'static str,
    /// Share of the squared misfit of the fitted records that it takes away.
    pub gain: f64,
    /// Gap of the held-out records with the function, fitted together with the machine's parameters.
    pub gap_held_out: Option<f64>,
}

/// Returns the column of one hat function.
fn hat_column(
    data: &MotionData<'_>,
    channel: Option<&str>,
    variable: Variable,
    knots: &[f64],
    at: usize,
) -> DVector<f64> {
    data.channel(channel, |motion| {
        let hats = variable.samples(motion).into_iter().map(|x| hat(knots, at, x));
        if variable.is_directed() {
            hats.zip(motion.direction()).map(|(hat, sign)| hat * sign).collect()
        } else {
            hats.collect()
        }
    })
}

/// Number of knots of a function.
const KNOTS: usize = 9;

/// Returns all free functions, piecewise linear between knots at even quantiles of the samples.
pub(super) fn free_functions(data: &MotionData<'_>) -> Vec<FreeFunction> {
    let mut functions = Vec::new();
    for channel in data.channels() {
        for variable in Variable::ALL {
            let knots = knots(data.motions.iter().flat_map(|motion| variable.samples(motion)).collect());
            if knots.len() < 3 {
                continue;
            }
            let columns = (0..knots.len()).map(|at| hat_column(data, channel, variable, &knots, at));
            let (used, columns): (Vec<usize>, Vec<DVector<f64>>) =
                columns.enumerate().filter(|(_, column)| column.norm() > 0.0).unzip();
            if !columns.is_empty() {
                let (column, columns) = (channel.map(str::to_string), DMatrix::from_columns(&columns));
                functions.push(FreeFunction { column, columns, variable, knots, used });
            }
        }
    }
    functions
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
        let friction_location = motions
            .iter()
            .find_map(|m| rigid.joint_with_most_friction(machine, values, m))
            .map(|joint| machine.joints[joint].name.clone());
        let driven = || machine.drive.as_ref().map_or("drive".into(), |d| machine.points[d.on].name.clone());
        ForceLocations {
            machine,
            motions,
            friction_location: friction_location.unwrap_or_else(driven),
            heaviest: rigid.largest_mass_point(machine, values),
        }
    }

    /// Returns the location of a free function. Errors of an extra channel arise at its point, forces
    /// depending on acceleration at the largest inertia, all others at the largest friction.
    pub fn of(&self, over: Variable, column: Option<&str>) -> String {
        let further = |name: &str| {
            self.motions.iter().flat_map(|m| &m.extra_channels).find(|f| f.column == name).map(|f| f.point)
        };
        let point = match column {
            Some(column) => further(column),
            None if over == Variable::Acceleration => self.heaviest,
            None => None,
        };
        point.map_or_else(|| self.friction_location.clone(), |p| self.machine.points[p].name.clone())
    }
}
