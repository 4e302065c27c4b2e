//! Parallel work with results independent of the number of threads.

use rayon::iter::ParallelIterator;

/// Collects results of parallel work.
pub trait OrFirstError<T, E> {
    /// Returns all results in order, or the error of the first item in order that failed.
    ///
    /// Collecting into a `Result` would return the error that occurred first in time, which varies between
    /// runs.
    ///
    /// # Errors  that of the first failed item in order.
    fn or_first_error(self) -> Result<Vec<T>, E>;
}

impl<I: ParallelIterator<Item = Result<T, E>>, T: Send, E: Send> OrFirstError<T, E> for I {
    fn or_first_error(self) -> Result<Vec<T>, E> {
        self.collect_vec_list().into_iter().flatten().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::OrFirstError;
    use rayon::prelude::*;

    /// The first failing item in order finishes last.
    #[test]
    fn the_error_is_that_of_the_first_in_order() {
        let slow = |at: usize| {
            if at == 1 {
                std::thread::sleep(std::time::Duration::from_millis(20));
            }
            if at == 0 { Ok(at) } else { Err(at) }
        };
        assert_eq!((0..64).into_par_iter().map(slow).or_first_error(), Err(1));
        assert_eq!(
            (0..64).into_par_iter().map(Ok::<_, ()>).or_first_error(),
            Ok((0..64).collect::<Vec<_>>())
        );
    }
}
