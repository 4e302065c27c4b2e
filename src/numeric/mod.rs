//! Leaf mathematics that knows nothing of machines: bracketed roots, filters, small statistics and digests.

pub mod digest;
pub mod filter;
pub mod random;
pub mod root;
pub mod statistics;
