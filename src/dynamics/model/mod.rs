//! What physics predicts from a machine's description; knows no data.
//!
//! A [`Structure`] is the compiled shape of a machine (which coordinate meets which), a [`Network`] the
//! numbers on it for one operating condition and one set of parameters. Its dynamic stiffness
//! D(ω) = K + iωC − ω²M + rods(ω) is eliminated exactly at each frequency; from that come receptances and their
//! slopes, the count of undamped modes below a frequency, the modes and the peaks of |H|.

mod along;
mod assembly;
pub mod coupling;
mod derived;
mod elimination;
mod energy;
mod fraction;
mod joint;
mod lanes;
mod lines;
mod matrices;
mod modes;
mod network;
mod peak_search;
mod peaks;
mod receptance;
mod rod;
mod scalar;
mod sensitivity;
mod sight;
mod solution;
mod structure;
mod workspace;

pub use along::Along;
pub use derived::{derived, elastic_frequencies_hz};
pub use energy::EnergyShare;
pub use lanes::{ABREAST, Complexes, LANES, Reals};
pub use lines::Lines;
pub use matrices::{Matrices, matrices};
pub use modes::{Mode, undamped_modes};
pub use network::Network;
pub use peak_search::PeakSearch;
pub use peaks::{Peak, peaks, peaks_into};
pub use sensitivity::Sensitivity;
pub use solution::Point as FrequencyPoint;
pub use structure::{ModelError, Rods, Structure};
pub use workspace::Workspace;
