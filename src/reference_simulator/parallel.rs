//! Parallel computations whose result does not depend on the order of threads.

use rayon::prelude::*;

use super::Result;

/// Collects results in their order, or returns the first error.
pub fn in_order<T: Send>(results: impl IndexedParallelIterator<Item = Result<T>>) -> Result<Vec<T>> {
    results.collect::<Vec<Result<T>>>().into_iter().collect()
}
