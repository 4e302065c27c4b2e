//! Mathematics independent of machines: bracketed roots, filters, statistics, digests, and parallel work with
//! results independent of the number of threads.

pub mod digest;
pub mod distribution;
pub mod filter;
pub mod halton;
pub mod linear_fit;
pub mod long_run;
pub mod minimum;
pub mod parallel;
pub mod random;
pub mod root;
pub mod statistics;
pub mod unit;
