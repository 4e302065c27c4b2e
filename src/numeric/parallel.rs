//! Work on several threads that ends alike on one.

use rayon::iter::ParallelIterator;

/// Results of parallel work, collected.
pub trait OrFirstError<T, E> {
    /// All of them in order, or the error of the first that failed. Collecting into a `Result` gives the error that happened first, which changes from run to run.
    ///
    /// # Errors  that of the first in order.
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

    /// The first in order fails last.
    #[test]
    fn the_error_is_that_of_the_first_in_order() {
        let slow = |at: usize| {
            if at == 1 {
                std::thread::sleep(std::time::Duration::from_millis(20));
            }
            if at == 0 { Ok(at) } else { Err(at) }
        };
        assert_eq!((0..64).into_par_iter().map(slow).or_first_error(), Err(1));
        assert_eq!((0..64).into_par_iter().map(Ok::<_, ()>).or_first_error(), Ok((0..64).collect::<Vec<_>>()));
    }
}
