//! Natural modes, FRF and static stiffness of one machine at one operating condition.

use std::sync::Arc;

use nalgebra::DVector;
use num_complex::Complex64;

use crate::{StudyError, StudyResult};
use dynamics::model::{
    AssembledModel, PeakSearch, RodModel, Structure, UndampedMode, Workspace, matrices, peaks, undamped_modes,
};
use machine::{Machine, Operating, Value};
use measurement::Quantity;
use numeric::unit::omega_rad_s;
use report::prediction::NaturalMode;

/// Relative precision of the peaks.
const PRECISION: f64 = 1e-8;
/// Ends of the search for peaks and modes over those of the band (1): peaks at the ends of the band lie
/// inside.
const SEARCHED: (f64, f64) = (0.5, 1.15);

/// Damping ratio up to which that of the undamped mode holds: its error grows with the square (1).
const LIGHT: f64 = 0.3;

/// What is predicted, and on which machine.
pub(crate) struct Evaluation<'m> {
    machine: &'m Machine,
    /// The machine under a constant load: without integral action and relaxing dampers.
    at_rest: Option<(Machine, String)>,
    structure: Arc<Structure>,
    quantity: Quantity,
    pub(crate) band_hz: (f64, f64),
}

/// Working memory of one thread.
pub(crate) struct EvaluationSpace {
    model: AssembledModel,
    work: Workspace,
}

impl<'m> Evaluation<'m> {
    /// Prepares the prediction of a response (points of the machine) in a quantity, over a band (Hz).
    ///
    /// # Errors  the machine has no coordinate that moves.
    pub(crate) fn new(
        machine: &'m Machine,
        (response, excitation): (usize, usize),
        quantity: Quantity,
        rods: RodModel,
        band_hz: (f64, f64),
    ) -> StudyResult<Self> {
        let structure =
            Arc::new(Structure::new(machine, response, excitation, rods).map_err(StudyError::impossible)?);
        let at_rest = (response == excitation).then(|| {
            let mut at_rest = machine.clone();
            for joint in &mut at_rest.joints {
                joint.integral_rate = Value::number(0.0);
                joint.relaxation_stiffness = None;
            }
            (at_rest, machine.points[excitation].name.clone())
        });
        Ok(Evaluation { machine, at_rest, structure, quantity, band_hz })
    }

    pub(crate) fn space(&self) -> EvaluationSpace {
        EvaluationSpace { model: self.structure.empty_model(), work: self.structure.workspace() }
    }

    /// Returns the highest frequency (Hz) up to which modes are computed.
    pub(crate) fn highest_hz(&self) -> f64 {
        SEARCHED.1 * self.band_hz.1
    }

    /// Computes the natural modes in ascending frequency, without rigid-body modes.
    pub(crate) fn modes(
        &self,
        values: &[f64],
        operating: &Operating,
        space: &mut EvaluationSpace,
    ) -> Vec<NaturalMode> {
        let EvaluationSpace { model, work } = space;
        model.update(self.machine, values, operating);
        let elastic: Vec<UndampedMode> = undamped_modes(model, self.highest_hz(), work)
            .into_iter()
            .filter(|m| m.frequency_hz > 0.0)
            .collect();
        let search = PeakSearch {
            from_hz: SEARCHED.0
                * self.band_hz.0.min(elastic.first().map_or(f64::INFINITY, |m| m.frequency_hz)),
            to_hz: self.highest_hz(),
            precision: PRECISION,
            omega_power: self.quantity.power(),
        };
        let found = peaks(model, search, work);
        // Each peak belongs to the mode with the nearest frequency; of several peaks of a mode the highest
        // counts.
        let distance = |a: f64, b: f64| (a / b).ln().abs();
        let nearest = |hz: f64| {
            let by_distance = |a: &(usize, &UndampedMode), b: &(usize, &UndampedMode)| {
                distance(a.1.frequency_hz, hz).total_cmp(&distance(b.1.frequency_hz, hz))
            };
            elastic.iter().enumerate().min_by(by_distance).map(|(at, _)| at)
        };
        let of_mode = |at: usize| {
            let own = found.iter().filter(|peak| nearest(peak.frequency_hz) == Some(at));
            own.max_by(|a, b| a.amplitude.total_cmp(&b.amplitude))
        };
        // An overdamped mode does not oscillate. It is counted where the FRF has a peak: there another part
        // of the machine carries the damping.
        let oscillates =
            |at: &usize| of_mode(*at).is_some() || elastic[*at].damping_ratio.is_none_or(|z| z < 1.0);
        let row = |(order, at): (usize, usize)| {
            let (mode, peak) = (&elastic[at], of_mode(at));
            NaturalMode {
                order: order + 1,
                frequency_hz: peak.map(|p| p.frequency_hz),
                natural_hz: mode.frequency_hz,
                damping_ratio: mode.damping_ratio.filter(|z| *z < LIGHT),
                amplitude: peak.map(|p| p.amplitude),
            }
        };
        (0..elastic.len()).filter(oscillates).enumerate().map(row).collect()
    }

    /// Computes the FRF at some frequencies (Hz).
    pub(crate) fn frf(
        &self,
        values: &[f64],
        operating: &Operating,
        lines_hz: &[f64],
        space: &mut EvaluationSpace,
    ) -> Vec<Complex64> {
        space.model.update(self.machine, values, operating);
        let omegas: Vec<f64> = lines_hz.iter().copied().map(omega_rad_s).collect();
        let receptances = space.model.sweep(&omegas, &mut space.work);
        receptances
            .into_iter()
            .zip(&omegas)
            .map(|(h, omega)| h * self.quantity.from_receptance(*omega))
            .collect()
    }

    /// Computes the static stiffness at the excited point; `None` where the response is another point, or a
    /// part of the machine is free to move.
    pub(crate) fn static_stiffness(&self, values: &[f64], operating: &Operating) -> Option<f64> {
        let (machine, point) = self.at_rest.as_ref()?;
        let found = matrices(machine, values, operating, 1).ok()?;
        let at = found.names.iter().position(|name| name == point)?;
        if !found.free_parts().is_empty() {
            return None;
        }
        let mut force = DVector::zeros(found.names.len());
        force[at] = 1.0;
        // The two supports of a short nut may pass its centre, which leaves K regular but not positive
        // definite.
        let deflection: DVector<f64> = found.stiffness.lu().solve(&force)?;
        Some(1.0 / deflection[at]).filter(|k| k.is_finite())
    }
}
