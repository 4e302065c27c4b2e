//! Minimum of a function of one variable.

/// Returns the least point of a function of one minimum between two ends, with its value, after a number of
/// steps of golden section.
///
/// # Errors  those of the function.
///
/// # Source  Kiefer, "Sequential minimax search for a maximum", Proc. AMS 4 (1953) 502–506.
pub fn golden_section<E>(
    (mut low, mut high): (f64, f64),
    steps: usize,
    mut function: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, f64), E> {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let inner = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut ends = [(inner[0], function(inner[0])?), (inner[1], function(inner[1])?)];
    for _ in 0..steps {
        if ends[0].1 < ends[1].1 {
            high = ends[1].0;
            let next = high - ratio * (high - low);
            ends = [(next, function(next)?), ends[0]];
        } else {
            low = ends[0].0;
            let next = low + ratio * (high - low);
            ends = [ends[1], (next, function(next)?)];
        }
    }
    Ok(if ends[0].1 <= ends[1].1 { ends[0] } else { ends[1] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn limit_minimum_of_a_parabola_and_of_an_end() {
        let Ok((x, value)) =
            golden_section((-1.0, 3.0), 40, |x| Ok::<f64, Infallible>((x - 0.7).powi(2) + 2.0));
        assert!((x - 0.7).abs() < 1e-7 && (value - 2.0).abs() < 1e-13, "{x} {value}");
        let Ok((x, _)) = golden_section((1.0, 2.0), 30, Ok::<f64, Infallible>);
        assert!((x - 1.0).abs() < 1e-5, "{x}");
        assert_eq!(golden_section((0.0, 1.0), 3, |_| Err("stopped")), Err("stopped"));
    }
}
