//! Deflection of shafts along their length in an undamped mode.

use super::assembled_model::AssembledModel;
use machine::{Machine, Operating};
use numeric::unit::omega_rad_s;

/// The deflection of a shaft in one mode.
#[derive(Debug, Clone, PartialEq)]
pub struct ShaftDeflection {
    /// Index of the shaft.
    pub shaft: usize,
    /// Whether the shaft twists (rad); otherwise it moves along its axis (m).
    pub torsional: bool,
    /// Distance from the shaft's left end (m), and deflection in the scale of the mode shape.
    pub points: Vec<(f64, f64)>,
}

impl AssembledModel {
    /// Computes the deflection of every shaft in a mode of the given frequency and shape, at `steps` points
    /// on each of its rods. The model must have been [`update`](AssembledModel::update)d to the same
    /// parameters and operating condition.
    ///
    /// # Source  a uniform rod whose ends deflect by a and b: u(x) = (a·sin(φ − λx) + b·sin λx)/sin φ, with φ
    ///   = ω·transit time. The lumped rod
    ///   has the same shape at its masses, to second order.
    pub fn shaft_deflections(
        &self,
        machine: &Machine,
        parameters: &[f64],
        operating: &Operating,
        mode: (f64, &[f64]),
        steps: usize,
    ) -> Vec<ShaftDeflection> {
        let (frequency_hz, shape) = mode;
        let mut out: Vec<ShaftDeflection> = Vec::new();
        if shape.is_empty() {
            return out;
        }
        for (rod, rod_shape) in self.rods.iter().zip(&self.structure.rods) {
            let shaft = &machine.shafts[rod_shape.shaft];
            let place = |p| shaft.place_m(p, parameters, operating);
            let (Some(from), Some(to)) = (place(rod_shape.places.0), place(rod_shape.places.1)) else {
                continue;
            };
            let [a, b] = rod_shape.ends.map(|c| c.map_or(0.0, |c| shape[c]));
            let phi = omega_rad_s(frequency_hz) * rod.transit_s;
            let sine = phi.sin();
            let at = |share: f64| match sine.abs() > 1e-9 {
                true => (a * (phi * (1.0 - share)).sin() + b * (phi * share).sin()) / sine,
                false => a + (b - a) * share,
            };
            let steps = steps.max(1);
            let points =
                (0..=steps).map(|i| i as f64 / steps as f64).map(|s| (from + s * (to - from), at(s)));
            match out.iter_mut().find(|o| o.shaft == rod_shape.shaft && o.torsional == rod_shape.torsional) {
                // The end of one rod is the start of the next.
                Some(known) => known.points.extend(points.skip(1)),
                None => out.push(ShaftDeflection {
                    shaft: rod_shape.shaft,
                    torsional: rod_shape.torsional,
                    points: points.collect(),
                }),
            }
        }
        out
    }
}
