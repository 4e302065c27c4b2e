//! The compiled topology of a machine: couplings of its coordinates and the order of elimination.

use thiserror::Error;

use super::elimination::Elimination;
use machine::{Machine, StationPlace};

/// Why a machine cannot be computed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// A point that does not exist or does not move.
    #[error("«{name}» {fault}")]
    Point {
        /// Name of the point.
        name: String,
        /// Fault in words.
        fault: &'static str,
    },
    /// A method needs a constrained machine, but a part of it moves freely.
    #[error(
        "a part of the machine moves freely: {part}; hold it by a joint to the ground, or fix one of its points"
    )]
    Unconstrained {
        /// The points that move.
        part: String,
    },
}

/// Representation of rods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RodModel {
    /// Exact wave solution.
    Exact,
    /// A chain of this many springs with the mass lumped at their ends; converges at second order. Its inner
    /// masses are eliminated in closed form.
    Lumped(usize),
}

/// A rod between two coordinates.
#[derive(Debug, Clone)]
pub(super) struct RodShape {
    /// Index of the shaft.
    pub shaft: usize,
    /// Start and end on the shaft.
    pub places: (StationPlace, StationPlace),
    /// Whether it is torsional; otherwise it is axial.
    pub torsional: bool,
    /// Coordinates at the left and the right end; `None` where fixed.
    pub ends: [Option<usize>; 2],
}

/// The bending of a shaft.
#[derive(Debug, Clone)]
pub(super) struct BeamShape {
    /// Index of the shaft.
    pub shaft: usize,
    /// Coordinate of the displacement that the nut feels.
    pub coordinate: usize,
}

/// The compiled topology of a machine for one pair of response and excitation.
#[derive(Debug, Clone)]
pub struct Structure {
    pub(super) elimination: Elimination,
    /// Coordinate of each point; `None` where it is fixed.
    pub(super) coordinate: Vec<Option<usize>>,
    pub(super) rods: Vec<RodShape>,
    pub(super) beams: Vec<BeamShape>,
    /// Slot of each diagonal entry.
    pub(super) diagonal: Vec<usize>,
    /// Per rod: slots of its direct entries and of its cross entry.
    pub(super) rod_slots: Vec<[Option<usize>; 3]>,
    /// Per joint: coordinates and coefficients of the points that move, by the described lead.
    pub(super) joints: Vec<Vec<(usize, f64)>>,
    /// As `joints`: of a joint that couples rotations with translations, the coefficients of its rotations,
    /// which contain the lead; else 0.
    pub(super) screws: Vec<Vec<(usize, f64)>>,
    pub(super) response: usize,
    pub(super) excitation: usize,
    /// Lever arms of the response and of the excitation: index of the machine's lever, and coordinate that
    /// acts on the arm.
    pub(super) response_arms: Vec<(usize, usize)>,
    pub(super) excitation_arms: Vec<(usize, usize)>,
    /// Representation of rods.
    pub representation: RodModel,
}

impl Structure {
    /// Compiles a machine for the receptance of `response` under a force (torque) at `excitation`, points by
    /// index.
    ///
    /// # Errors  response or excitation is fixed and cannot move.
    pub fn new(
        machine: &Machine,
        response: usize,
        excitation: usize,
        representation: RodModel,
    ) -> Result<Self, ModelError> {
        let mut size = 0;
        let mut next = || {
            size += 1;
            size - 1
        };
        let coordinate: Vec<Option<usize>> =
            machine.points.iter().map(|p| (!p.fixed).then(&mut next)).collect();
        let mut rods = Vec::new();
        for (shaft, description) in machine.shafts.iter().enumerate() {
            for torsional in [false, true] {
                let stations: Vec<(StationPlace, usize)> = description
                    .stations
                    .iter()
                    .filter_map(|s| Some((s.place, if torsional { s.torsion } else { s.axial }?)))
                    .collect();
                for pair in stations.windows(2) {
                    let ends = [coordinate[pair[0].1], coordinate[pair[1].1]];
                    rods.push(RodShape { shaft, places: (pair[0].0, pair[1].0), torsional, ends });
                }
            }
        }
        let joints: Vec<Vec<(usize, f64)>> = machine
            .joints
            .iter()
            .map(|j| j.on.iter().filter_map(|(p, c)| Some((coordinate[*p]?, *c))).collect())
            .collect();
        let screws = machine.joints.iter().map(|joint| {
            let lead_of = |point: usize, c: f64| if machine.has_lead(joint, point) { c } else { 0.0 };
            joint.on.iter().filter_map(|(p, c)| Some((coordinate[*p]?, lead_of(*p, *c)))).collect()
        });
        let screws: Vec<Vec<(usize, f64)>> = screws.collect();
        let moving = |point: usize| {
            coordinate[point].ok_or_else(|| ModelError::Point {
                name: machine.points[point].name.clone(),
                fault: "is fixed and has no receptance; name a point that moves",
            })
        };
        let arms = |point: usize| -> Result<Vec<(usize, usize)>, ModelError> {
            let levers = machine.chain.levers.iter().enumerate().filter(|(_, l)| l.point == point);
            levers.map(|(at, lever)| Ok((at, moving(lever.on)?))).collect()
        };
        let (response_arms, excitation_arms) = (arms(response)?, arms(excitation)?);
        let (response, excitation) = (moving(response)?, moving(excitation)?);
        let last: Vec<usize> =
            if response == excitation { vec![response] } else { vec![response, excitation] };
        let rod_pairs = rods.iter().filter_map(|r| Some((r.ends[0]?, r.ends[1]?)));
        let joint_pairs = joints.iter().flat_map(|on| on.iter().flat_map(|a| on.iter().map(|b| (a.0, b.0))));
        let elimination = Elimination::new(size, rod_pairs.chain(joint_pairs), &last);
        let diagonal: Vec<usize> = (0..size).map(|i| elimination.entry(i, i)).collect();
        let rod_slots = rods
            .iter()
            .map(|r| {
                let [i, j] = r.ends;
                [
                    i.map(|i| diagonal[i]),
                    j.map(|j| diagonal[j]),
                    i.zip(j).map(|(i, j)| elimination.entry(i, j)),
                ]
            })
            .collect();
        let bent = machine
            .shafts
            .iter()
            .enumerate()
            .filter_map(|(shaft, s)| Some((shaft, coordinate[s.bending.as_ref()?.point]?)));
        let beams = bent.map(|(shaft, coordinate)| BeamShape { shaft, coordinate }).collect();
        Ok(Structure {
            elimination,
            coordinate,
            rods,
            beams,
            diagonal,
            rod_slots,
            joints,
            screws,
            response,
            excitation,
            response_arms,
            excitation_arms,
            representation,
        })
    }

    /// Coordinate of a point (by index); `None` where it is fixed.
    pub fn coordinate_of(&self, point: usize) -> Option<usize> {
        self.coordinate[point]
    }

    /// Number of coordinates that move.
    pub fn size(&self) -> usize {
        self.elimination.size()
    }
}
