//! Leaf mathematics that knows nothing of machines: bracketed roots, filters and small statistics.

pub mod filter;
pub mod random;
pub mod root;
pub mod statistics;
