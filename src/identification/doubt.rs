//! Why a fit may not be that of the machine.

use std::fmt;

/// A reason to doubt that values of a fit are those of the machine, however narrow their intervals are:
/// intervals hold where the description is right within its tolerances.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// Residuals exceed noise and tolerances: their variance over the stated one (1).
    Misfit(f64),
    /// A stated number moved by this many standard deviations of its tolerance, and of the moves of numbers
    /// that are stated rightly.
    Tolerance(String, f64, f64),
    /// The data drive a parameter to the lower or the upper end of its range, which excludes its value.
    End(String, &'static str),
    /// The best minimum was found from so few of the starts that a better one may exist.
    Search(usize, usize),
    /// A parameter moved from its prior by this many of its standard deviations, and of the moves of right priors.
    Prior(String, f64, f64),
    /// Small print of a force is this many times as large as is common.
    SmallPrint(&'static str, f64),
    /// Share of the squared residual of a force that follows speed and acceleration.
    Systematic(f64),
    /// Share of the squared force that is left unexplained.
    Unexplained(f64),
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Doubt::Misfit(times) => write!(f, "a misfit of {times:.1} times the stated variance"),
            Doubt::Tolerance(name, deviation, moved) => {
                write!(
                    f,
                    "{name}, which moved by {deviation:+.1} standard deviations{}",
                    of_moves(*deviation, *moved)
                )
            }
            Doubt::End(id, which) => write!(f, "{id}, which the data drive to the {which} end of its range"),
            Doubt::Search(found, starts) => write!(f, "a minimum found from {found} of {starts} starts"),
            Doubt::Prior(id, deviation, moved) => {
                write!(
                    f,
                    "the prior of {id}, which the data contradict by {deviation:+.1} standard deviations{}",
                    of_moves(*deviation, *moved)
                )
            }
            Doubt::SmallPrint(name, times) => write!(f, "{name}, {times:.1} times what is common"),
            Doubt::Systematic(share) => {
                write!(
                    f,
                    "a residual that follows speed and acceleration by {:.0} % of its square",
                    100.0 * share
                )
            }
            Doubt::Unexplained(share) => {
                write!(f, "{:.0} % of the squared force, left unexplained", 100.0 * share)
            }
        }
    }
}

/// Ratio of the two measures of a move from which both are stated (1).
const APART: f64 = 1.2;

/// Says how many standard deviations of the moves of rightly stated numbers a move is, where that is more
/// than those of its tolerance: a number that the data hardly determine stays near the stated one.
pub(super) fn of_moves(deviation: f64, moved: f64) -> String {
    match moved > APART * deviation.abs() {
        true => format!(", {moved:.1} of the moves of a right number in such data"),
        false => String::new(),
    }
}
