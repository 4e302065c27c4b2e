//! Simulation of a driven axis in time: force and motion that follow from a machine's description and a
//! command.
//!
//! The machine is q̈ = M⁻¹·f on the coordinates with inertia; rods are chains, massless points are condensed.
//! Friction and backlash are laws with discrete **modes**: sliding forward or backward or sticking, in
//! contact or free. Within one mode the motion follows a linear equation, whose exact solution over a step is
//! a matrix.
//!
//! Smooth nonlinearities are a Stribeck curve, presliding, a wave over the travel, or lead error. They enter
//! as a parabola through start, middle and end of the step, which an iteration finds. The solution is of
//! fourth order, and exact without nonlinearities. The force of the drive, or the voltage of its motor, is
//! held between samples of its loops, as in a real drive. The currents of the motor are states in addition to
//! those of the machine.
//!
//! Steps are halvings of the innermost loop's period, so that the matrices for 2⁻ᵏ of it are computed once
//! and reused. A step is halved if a mode ends in it or its parabola is too coarse. A mode ends when a
//! velocity or gap changes sign or a holding force exceeds its limit. Halving locates each event to 2⁻³² of
//! the period. The energy balance is recorded: the work of the drive equals stored plus lost energy.

mod bode;
mod control;
mod error;
mod force_element;
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
pub use linear::{LinearLoops, Pole, smooth};
pub use record::{RecordGap, simulate_record};
pub use reference::{Course, SCurve, Sine, require_positive};
pub use run::simulate;
pub use servo_impedance::{ServoImpedance, gains_of};
pub use settings::SimulationSettings;
pub use trace::{Event, EventKind, Trace, TraceSample};
