//! Room for evaluations of a network, and for a search of its peaks.

use super::extremum_search::{Extremum, ExtremumSearch};
use super::rational_interpolant::RationalInterpolant;
use super::rod::RodLanes;
use super::simd::{ABREAST, Complexes, Reals};
use super::solution::Row;
use super::structure::Structure;

/// Room for evaluations at some frequencies at once; keep it and none allocates. What is kept for each of some groups of frequencies stands side by side.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) real: Vec<Reals>,
    pub(super) complex: Vec<Complexes>,
    pub(super) rods: Vec<RodLanes>,
    pub(super) at_excitation: Vec<Complexes>,
    pub(super) at_response: Vec<Complexes>,
    /// What is read on an arm.
    pub(super) on_arm: Vec<Complexes>,
    /// Room for a search of peaks.
    pub(super) peaks: Option<Box<Room>>,
}

/// Room for a search; kept, a later one takes none.
#[derive(Debug, Clone, Default)]
pub(super) struct Room {
    /// Frequencies asked for together, and what is found there.
    pub(super) omegas: Vec<f64>,
    pub(super) points: Vec<Row>,
    pub(super) below: Vec<usize>,
    /// What is still to be looked at, the lowest last.
    pub(super) pieces: Vec<Piece>,
    /// The pieces that the band is first cut into.
    pub(super) first: Vec<RationalInterpolant>,
    /// What is seen of the piece at hand.
    pub(super) sight: ExtremumSearch,
    /// Maxima and minima of the band so far, in rising frequency.
    pub(super) turns: Vec<Extremum>,
    /// Those of the maxima that are not yet found exactly.
    pub(super) open: Vec<usize>,
}

/// A piece of the band (rad/s).
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) from: f64,
    pub(super) to: f64,
    /// At least so many undamped natural frequencies lie below its lower end, and this many below its upper one.
    pub(super) below: (usize, usize),
    pub(super) halved: u32,
    /// Its number among those that the band is first cut into, unless halved.
    pub(super) first: usize,
}

impl Structure {
    /// Room for evaluations of this structure.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            real: vec![Reals::ZERO; self.elimination.slots() * ABREAST],
            complex: vec![Complexes::ZERO; self.elimination.slots() * ABREAST],
            rods: Vec::with_capacity(self.rods.len() * ABREAST),
            at_excitation: vec![Complexes::ZERO; self.size() * ABREAST],
            at_response: vec![Complexes::ZERO; self.size() * ABREAST],
            on_arm: vec![Complexes::ZERO; ABREAST],
            peaks: None,
        }
    }
}
