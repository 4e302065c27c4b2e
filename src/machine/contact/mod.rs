//! Rolling contacts: deflection of nuts and bearings under load, and the friction that loads them.
//!
//! ```text
//! elliptic ── hertz ── race ──┬── nut ─────┐
//!                             └── bearing ─┴── side ── pair      stribeck ── fit
//! ```
//!
//! A ball between two races deflects by δ = c·P^(2/3) at constant contact angle, and so does the whole nut or
//! bearing. A [`Side`] is that constant with the load limit of the formula. Two sides preloaded against each
//! other form a [`PreloadedPair`]. [`Rule::Physics`] shares a load by equilibrium and adds the two tangent
//! stiffnesses. [`Rule::AsPrinted`] follows the papers, so that both can be compared.
//!
//! # Source  Duan et al., «Dynamic Modeling and Experiment Research on Twin Ball Screw Feed System
//!   Considering the
//! Joint Stiffness» (2018), cited as *Duan*; the vertical ball-screw feed system under acceleration, cited as
//! *vertical*; Harris and Kotzalas, «Essential Concepts of Bearing Technology», ch. 6, cited as *Harris*.

mod bearing;
mod elliptic;
mod error;
mod fit;
mod hertz;
mod interval;
mod nut;
mod pair;
mod projection;
pub mod published;
mod race;
mod side;
mod stribeck;

pub use bearing::BearingData;
pub use error::ContactError;
pub use fit::{Observation, StribeckFit, StribeckNoise, StribeckOptions, fit_stribeck};
pub use hertz::{BALL_PRESSURE_LIMIT_PA, ContactMaterial, Curvatures, PointContact, STEEL};
pub use interval::{ParameterEstimate, ParameterInterval};
pub use nut::{Balls, NutData};
pub use pair::{PreloadedPair, Printed, Rule, Share};
pub use race::{LoadedBalls, RaceContacts};
pub use side::{Side, Stiffness};
pub use stribeck::{ScrewDrive, StribeckCurve};
