//! Motions at a single frequency, which do not separate inertia from a force along the travel.
//!
//! A sine is its own second derivative. Torque ripple, cables and guides push along the travel; a force k·x of
//! theirs takes the place of inertia:
//!
//! ```text
//! x = x₀ + A·sin(ωt)        a = −ω²·(x − x₀)        m·a + k·x = (m − k/ω²)·a + k·x₀
//! ```
//!
//! The record determines m − k/ω² only, for any amplitude A. A second frequency, or an acceleration that differs
//! at one place of the travel, determines both.

use nalgebra::{DMatrix, DVector};

use super::nuisance_prior::RIPPLE;
use dynamics::inverse_dynamics::{MotionSignal, Rigid};
use machine::{Machine, ParameterValues};
use numeric::linear_fit::LinearFit;
use numeric::unit::omega_rad_s;

/// Least share (1) of an inertia force that is not in proportion to the position. With less, the inertia rests on
/// a force smaller than that which every axis has along its travel.
const LEAST_SHARE: f64 = RIPPLE;
/// Step of a parameter, as a share of its range (1).
const STEP: f64 = 1e-3;

/// Inertias that motions at a single frequency do not determine.
#[derive(Debug, Clone, PartialEq)]
pub struct SingleFrequency {
    /// Frequency of the motions (Hz).
    pub frequency_hz: f64,
    /// Indices of the parameters.
    pub parameters: Vec<usize>,
}

impl SingleFrequency {
    /// Finds the fitted inertias whose force is in proportion to the position, in all of the motions together.
    /// None where extra points were recorded: the wind-up between them measures the force beyond it.
    pub(super) fn of(
        (rigid, machine): (&Rigid, &Machine),
        (values, free, derivatives): (&ParameterValues, &[usize], &DMatrix<f64>),
        motions: &[&MotionSignal],
    ) -> Option<Self> {
        if motions.iter().any(|m| !m.extra_channels.is_empty()) {
            return None;
        }
        let rows = |of: &dyn Fn(&MotionSignal) -> Vec<f64>| {
            DVector::from_vec(motions.iter().flat_map(|m| of(m)).collect::<Vec<f64>>())
        };
        // The filters distort both ends of a record.
        let inside = rows(&|m| {
            let inner = m.clone().without_edges();
            inner.is_moving.iter().map(|moves| f64::from(u8::from(*moves))).collect()
        });
        let thinned = |column: fn(&MotionSignal) -> &Vec<f64>| {
            rows(&|m| m.thinned(column(m)).unwrap_or_default()).component_mul(&inside)
        };
        let travel = DMatrix::from_columns(&[inside.clone(), thinned(|m| &m.position_m)]);
        let slope = LinearFit::new(&travel, &thinned(|m| &m.acceleration_m_s2))?.coefficients[1];
        let is_inertia = |index: usize| {
            let mut moved = values.clone();
            moved[index] = machine.parameters[index].stepped(moved[index], STEP);
            rigid.inertia(machine, &moved) != rigid.inertia(machine, values)
        };
        let is_along_travel = |at: usize| {
            let column = derivatives.column(at).component_mul(&inside);
            LinearFit::new(&travel, &column)
                .is_some_and(|of| of.residual.norm() < LEAST_SHARE * column.norm())
        };
        let found = free.iter().enumerate().filter(|(at, index)| is_inertia(**index) && is_along_travel(*at));
        let parameters: Vec<usize> = found.map(|(_, index)| *index).collect();
        (!parameters.is_empty() && slope < 0.0)
            .then(|| SingleFrequency { frequency_hz: (-slope).sqrt() / omega_rad_s(1.0), parameters })
    }
}
