//! A driven axis in time: what force and motion follow from a machine's description and a command.
//!
//! The machine is q̈ = M⁻¹·f on the coordinates that have an inertia (rods as chains, points without inertia condensed), with friction and play
//! as laws that change form: sliding forward or backward, sticking; in contact or free. Within one such **mode** the motion follows a linear
//! equation, whose exact solution over a step is a matrix; where something smooth is not linear (a Stribeck curve, presliding, a wave over the
//! travel, lead error), it enters that solution as a parabola through the step's beginning, middle and end, found by iteration: fourth order,
//! and exact without it. The force of the drive, or the voltage of its motor, is held between samples of its loops, as the drive does; the
//! currents of the motor are coordinates beside the machine's.
//!
//! Steps are a period of the innermost loop halved again and again, so that the matrices of 2⁻ᵏ of it, once made, serve always. A step in
//! which a mode ends (a velocity or a gap changes sign, a holding force passes its limit) or whose parabola is too coarse is halved: that finds
//! each event to 2⁻³² of the period. Energy is kept account of: the drive's work is what is stored and what is lost.

mod bode;
mod control;
mod error;
mod force_element;
mod gain;
mod inverter;
mod linear;
mod plant;
mod record;
mod reference;
mod run;
mod runner;
mod servo_impedance;
mod settings;
mod state;
mod state_transition;
mod step;
mod trace;

pub use bode::{SineResponse, sine_response};
pub use error::MotionError;
pub use gain::{GainRow, gain_study};
pub use linear::{LinearLoops, Pole, smooth};
pub use record::{RecordGap, simulate_record};
pub use reference::{Circle, Course, SCurve, Sine, contour_error};
pub use run::simulate;
pub use servo_impedance::{ServoImpedance, gains_of};
pub use settings::SimulationSettings;
pub use trace::{Energy, Event, EventKind, Trace, TraceSample};
