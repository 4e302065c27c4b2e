//! Layouts of driven axes: encoders, transmission, loops and commands beside those of the catalogue.

use super::catalogue::{DrawnAxis, random_axis, stiffness_for};
use super::effect::EffectKind;
use crate::draw::Draw;
use crate::machine::catalogue::round_to;

named! {
    /// A layout of a driven axis.
    pub enum MotionLayout {
        /// All of them.
        ALL {
            /// A ball screw; the motor's encoder closes two proportional loops, as in the catalogue.
            IndirectEncoder = "indirect-encoder",
            /// A ball screw; a scale at the table closes the position loop, the motor's encoder a
            /// proportional–integral velocity loop.
            DirectEncoder = "direct-encoder",
            /// A toothed belt with its natural frequency at a half to a quarter of that of a screw.
            BeltDriven = "belt-driven",
            /// One PID loop on the motor's encoder: a cascade with full velocity feed-forward and an integral
            /// velocity loop has the same law.
            PidLoop = "pid-loop",
            /// Two proportional loops with velocity feed-forward.
            FeedForward = "feed-forward",
        }
    }
}

/// Natural frequency of motor against table over a belt (Hz), and its damping ratio.
///
/// # Source  catalogues of toothed belts: 1e6 to 3e6 N per unit strain and 25 mm of width, spans of 0.3 to
///   1.5 m.
const BELT_HZ: [f64; 2] = [100.0, 220.0];
const BELT_DAMPING: [f64; 2] = [0.03, 0.08];
/// Integral times of velocity loops, s.
const INTEGRAL_S: [f64; 2] = [0.02, 0.1];
/// Shares of velocity feed-forward.
const FEED_FORWARD: [f64; 2] = [0.3, 1.0];

impl MotionLayout {
    /// Returns why an effect cannot be missing from the description of such an axis, or does not show in its
    /// records.
    pub fn refusal(self, effect: EffectKind) -> Option<&'static str> {
        use EffectKind::{Backlash, DriveFlexibility, LeadError, LeadGrowth};
        match (self, effect) {
            (Self::BeltDriven, LeadError | LeadGrowth) => Some("a belt has no lead"),
            (Self::BeltDriven, Backlash | DriveFlexibility) => {
                Some("its description contains the flexible belt")
            }
            (Self::DirectEncoder | Self::PidLoop, LeadError | LeadGrowth | Backlash) => {
                Some("its loops do not give the encoder's reading that a scale is compared with")
            }
            _ => None,
        }
    }

    /// Draws an axis; `viscous` limits the ratio of viscous to dry friction at rapid speed.
    pub fn axis(self, viscous: [f64; 2], draw: &mut Draw) -> DrawnAxis {
        let mut drawn = random_axis(viscous, draw);
        let (axis, drive) = (&mut drawn.machine.axis, &mut drawn.machine.drive);
        let integral_time_s = |draw: &mut Draw| round_to(draw.log_between(INTEGRAL_S[0], INTEGRAL_S[1]), 2);
        match self {
            Self::IndirectEncoder => {}
            Self::DirectEncoder => {
                drive.set.is_direct = true;
                drive.set.integral_time_s = integral_time_s(draw);
            }
            Self::BeltDriven => {
                let frequency_hz = draw.between(BELT_HZ[0], BELT_HZ[1]);
                let stiffness = stiffness_for(axis.masses_kg, frequency_hz);
                let damping = stiffness * 2.0 * draw.between(BELT_DAMPING[0], BELT_DAMPING[1])
                    / (std::f64::consts::TAU * frequency_hz);
                // Shared as between coupling and nut of a screw: one in series with the other.
                (axis.coupling.stiffness_n_m, axis.coupling.damping_n_s_m) = (1.3 * stiffness, 1.3 * damping);
                (axis.nut.stiffness_n_m, axis.nut.damping_n_s_m) = (4.3 * stiffness, 4.3 * damping);
            }
            Self::PidLoop => {
                drive.set.feed_forward = 1.0;
                drive.set.integral_time_s = integral_time_s(draw);
            }
            Self::FeedForward => {
                drive.set.feed_forward = round_to(draw.between(FEED_FORWARD[0], FEED_FORWARD[1]), 2)
            }
        }
        drawn
    }
}
