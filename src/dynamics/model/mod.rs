//! Predictions from a machine's description; the module knows no data.
//!
//! A [`Structure`] is the compiled topology of a machine: its coordinates and their couplings. An
//! [`AssembledModel`] holds the numbers for one operating condition and one set of parameters. Its dynamic
//! stiffness D(ω) = K + iωC − ω²M + rods(ω) is eliminated exactly at each frequency. This gives receptances
//! and their slopes, the count of undamped modes below a frequency, the modes and the peaks of |H|.

mod assembled_model;
mod assembly;
mod beam;
mod derived;
mod elimination;
mod energy;
mod extremum_scan;
mod extremum_search;
mod frequency_grid;
mod joint;
mod matrices;
mod mode_shape;
mod modes;
mod peak_search;
mod peak_slopes;
mod peaks;
mod rational_interpolant;
mod receptance;
mod rod;
mod scalar;
mod sensitivity;
mod simd;
mod solution;
mod structure;
mod workspace;

pub use assembled_model::AssembledModel;
pub use derived::{derived, elastic_frequencies_hz};
pub use frequency_grid::{Frequencies, FrequencyGrid};
pub use matrices::{Matrices, matrices};
pub use modes::{UndampedMode, undamped_modes};
pub use peak_search::PeakSearch;
pub use peak_slopes::PeakSlopes;
pub use peaks::{Peak, peaks, peaks_into};
pub use sensitivity::Sensitivity;
pub use simd::{ABREAST, Complexes, LANES, Reals};
pub use structure::{ModelError, RodModel, Structure};
pub use workspace::Workspace;
