//! Leaf mathematics that knows nothing of machines: bracketed roots and small statistics.

pub mod random;
pub mod root;
pub mod statistics;
