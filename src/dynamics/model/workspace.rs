//! Buffers for evaluations of a model and for a peak search.

use super::extremum_search::{Extremum, ExtremumSearch};
use super::rational_interpolant::RationalInterpolant;
use super::rod::RodLanes;
use super::simd::{ABREAST, Complexes, Reals};
use super::solution::Row;
use super::structure::Structure;

/// Buffers for evaluations at several frequencies at once. A reused workspace avoids allocation. Values of
/// several groups of frequencies are interleaved.
#[derive(Debug, Clone)]
pub struct Workspace {
    pub(super) real: Vec<Reals>,
    pub(super) complex: Vec<Complexes>,
    pub(super) rods: Vec<RodLanes>,
    pub(super) at_excitation: Vec<Complexes>,
    pub(super) at_response: Vec<Complexes>,
    /// Reading of the response with its lever arms.
    pub(super) response_with_arms: Vec<Complexes>,
    /// Buffers of a peak search.
    pub(super) peaks: Option<Box<PeakWorkspace>>,
}

/// Buffers of a peak search; a reused one avoids allocation.
#[derive(Debug, Clone, Default)]
pub(super) struct PeakWorkspace {
    /// Frequencies evaluated together, and the results.
    pub(super) omegas: Vec<f64>,
    pub(super) points: Vec<Row>,
    pub(super) below: Vec<usize>,
    /// Pieces still to be searched, the lowest last.
    pub(super) pieces: Vec<Piece>,
    /// Interpolants over the first pieces of the band.
    pub(super) first: Vec<RationalInterpolant>,
    /// Search over the current piece.
    pub(super) search: ExtremumSearch,
    /// Extrema of the band found so far, in rising frequency.
    pub(super) extrema: Vec<Extremum>,
    /// Indices of the maxima that have not converged yet.
    pub(super) unsettled: Vec<usize>,
}

/// A piece of the band (rad/s).
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) from: f64,
    pub(super) to: f64,
    /// Lower bound of the number of undamped natural frequencies below its lower end, and their number below
    /// its upper end.
    pub(super) below: (usize, usize),
    pub(super) halved: u32,
    /// Index of the first piece that contains it.
    pub(super) first: usize,
}

impl Structure {
    /// Creates buffers for evaluations of this structure.
    pub fn workspace(&self) -> Workspace {
        Workspace {
            real: vec![Reals::ZERO; self.elimination.slots() * ABREAST],
            complex: vec![Complexes::ZERO; self.elimination.slots() * ABREAST],
            rods: Vec::with_capacity(self.rods.len() * ABREAST),
            at_excitation: vec![Complexes::ZERO; self.size() * ABREAST],
            at_response: vec![Complexes::ZERO; self.size() * ABREAST],
            response_with_arms: vec![Complexes::ZERO; ABREAST],
            peaks: None,
        }
    }
}
