//! The compiled shape of a machine: which coordinate meets which, and in which order they are eliminated.

use thiserror::Error;

use super::elimination::Elimination;
use machine::{Machine, StationPlace};

/// Why a machine cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// A point that is not there or does not move.
    #[error("«{name}» {fault}")]
    Point {
        /// Its name.
        name: String,
        /// What is wrong with it.
        fault: &'static str,
    },
    /// Something needs a machine that is held.
    #[error("a part of the machine moves freely: {part}; hold it by a joint to the ground, or fix one of its points")]
    Unconstrained {
        /// The points that move.
        part: String,
    },
    /// A method that needs an inertia everywhere met a point without.
    #[error("point «{name}» has neither inertia nor shaft, which receptance coupling needs; the direct assembly takes it")]
    Massless {
        /// Its name.
        name: String,
    },
}

/// How rods are represented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rods {
    /// Exactly, by their wave solution.
    Exact,
    /// As a chain of this many springs with the mass lumped at their ends: converges at second order. Its inner masses are eliminated in
    /// closed form.
    Lumped(usize),
}

/// A rod between two coordinates.
#[derive(Debug, Clone)]
pub(super) struct RodShape {
    /// Which shaft.
    pub shaft: usize,
    /// Where it begins and ends.
    pub places: (StationPlace, StationPlace),
    /// Torsional, or else axial.
    pub torsional: bool,
    /// The coordinates at its left and right end, `None` where held.
    pub along: [Option<usize>; 2],
}

/// The compiled shape of a machine for one pair of response and excitation.
#[derive(Debug, Clone)]
pub struct Structure {
    pub(super) elimination: Elimination,
    /// Coordinate of each point; `None` where it is held.
    pub(super) coordinate: Vec<Option<usize>>,
    pub(super) rods: Vec<RodShape>,
    /// Slot of each diagonal entry.
    pub(super) diagonal: Vec<usize>,
    /// Per rod: slots of its direct entries and of its cross entry.
    pub(super) rod_slots: Vec<[Option<usize>; 3]>,
    /// Per joint: coordinates and coefficients of the points that move.
    pub(super) joints: Vec<Vec<(usize, f64)>>,
    pub(super) response: usize,
    pub(super) excitation: usize,
    /// Arms of the response and of the excitation: which of the machine's levers, and the coordinate felt.
    pub(super) read: Vec<(usize, usize)>,
    pub(super) struck: Vec<(usize, usize)>,
    /// How rods are represented.
    pub representation: Rods,
}

impl Structure {
    /// Compiles a machine for the receptance of `response` under a force (torque) at `excitation`, points by index.
    ///
    /// # Errors  a point is held, so that it cannot move.
    pub fn new(machine: &Machine, response: usize, excitation: usize, representation: Rods) -> Result<Self, ModelError> {
        let mut size = 0;
        let mut next = || {
            size += 1;
            size - 1
        };
        let coordinate: Vec<Option<usize>> = machine.points.iter().map(|p| (!p.fixed).then(&mut next)).collect();
        let mut rods = Vec::new();
        for (shaft, description) in machine.shafts.iter().enumerate() {
            for torsional in [false, true] {
                let stations: Vec<(StationPlace, usize)> =
                    description.stations.iter().filter_map(|s| Some((s.place, if torsional { s.torsion } else { s.axial }?))).collect();
                for pair in stations.windows(2) {
                    let along = [coordinate[pair[0].1], coordinate[pair[1].1]];
                    rods.push(RodShape { shaft, places: (pair[0].0, pair[1].0), torsional, along });
                }
            }
        }
        let joints: Vec<Vec<(usize, f64)>> =
            machine.joints.iter().map(|j| j.on.iter().filter_map(|(p, c)| Some((coordinate[*p]?, *c))).collect()).collect();
        let moving = |point: usize| {
            coordinate[point].ok_or_else(|| ModelError::Point {
                name: machine.points[point].name.clone(),
                fault: "is held to the ground and has no receptance; name a point that moves",
            })
        };
        let arms = |point: usize| -> Result<Vec<(usize, usize)>, ModelError> {
            let levers = machine.chain.levers.iter().enumerate().filter(|(_, l)| l.point == point);
            levers.map(|(at, lever)| Ok((at, moving(lever.on)?))).collect()
        };
        let (read, struck) = (arms(response)?, arms(excitation)?);
        let (response, excitation) = (moving(response)?, moving(excitation)?);
        let last: Vec<usize> = if response == excitation { vec![response] } else { vec![response, excitation] };
        let rod_pairs = rods.iter().filter_map(|r| Some((r.along[0]?, r.along[1]?)));
        let joint_pairs = joints.iter().flat_map(|on| on.iter().flat_map(|a| on.iter().map(|b| (a.0, b.0))));
        let elimination = Elimination::new(size, rod_pairs.chain(joint_pairs), &last);
        let diagonal: Vec<usize> = (0..size).map(|i| elimination.entry(i, i)).collect();
        let rod_slots = rods
            .iter()
            .map(|r| {
                let [i, j] = r.along;
                [i.map(|i| diagonal[i]), j.map(|j| diagonal[j]), i.zip(j).map(|(i, j)| elimination.entry(i, j))]
            })
            .collect();
        Ok(Structure { elimination, coordinate, rods, diagonal, rod_slots, joints, response, excitation, read, struck, representation })
    }

    /// Coordinate of a point (by index); `None` where it is held.
    pub fn coordinate_of(&self, point: usize) -> Option<usize> {
        self.coordinate[point]
    }

    /// Number of coordinates that move.
    pub fn size(&self) -> usize {
        self.elimination.size()
    }
}
