//! Tests on planted modes in the second-order form of mechanics (not the pole–residue form of the model),
//! refusals and limits.

mod fitting;
mod planted;
mod refused;
mod tracking;
