//! Undamped natural modes: counting, isolating and refining their frequencies.

use super::assembled_model::AssembledModel;
use super::simd::{Complexes, Reals};
use super::solution::Solution;
use super::workspace::Workspace;
use numeric::root::{Bracket, refine};
use numeric::unit::omega_rad_s;

/// An undamped natural mode.
#[derive(Debug, Clone, PartialEq)]
pub struct UndampedMode {
    /// Natural frequency (Hz); 0 for a rigid-body mode.
    pub frequency_hz: f64,
    /// Deflection of each coordinate of the structure, scaled to a largest value of 1. Empty if there are
    /// several rigid-body modes.
    pub shape: Vec<f64>,
    /// Modal mass-normalised damping ζ = φᵀCφ/(2ω·φᵀMφ) of a lightly damped mode; `None` at 0 Hz.
    pub damping_ratio: Option<f64>,
}

/// Limit (Hz) below which a natural frequency belongs to a rigid-body mode.
const RIGID_HZ: f64 = 1e-3;
/// Relative width to which the interval of a natural frequency is refined.
const WIDTH: f64 = 1e-11;

/// Computes all undamped modes up to `max_hz`, rigid-body modes first.
///
/// The Wittrick–Williams count isolates every mode, so that none is missed. Frequencies that coincide to
/// 1e-11 (relative) are repeated by their multiplicity.
pub fn undamped_modes(model: &AssembledModel, max_hz: f64, work: &mut Workspace) -> Vec<UndampedMode> {
    let count = |f: f64, work: &mut Workspace| model.modes_below(omega_rad_s(f), work);
    let rigid = count(RIGID_HZ, work);
    let mut modes: Vec<UndampedMode> = (0..rigid)
        .map(|_| UndampedMode { frequency_hz: 0.0, shape: Vec::new(), damping_ratio: None })
        .collect();
    if let [only] = modes.as_mut_slice() {
        only.shape = mode_at(model, RIGID_HZ, work).shape;
    }
    let mut pending = vec![(RIGID_HZ, rigid, max_hz, count(max_hz, work))];
    while let Some((low, below_low, high, below_high)) = pending.pop() {
        let inside = below_high.saturating_sub(below_low);
        if inside == 0 {
            continue;
        }
        if inside == 1 || high - low <= WIDTH * high {
            let frequency = if inside == 1 {
                refine_isolated(model, low, below_low, high, work)
            } else {
                0.5 * (low + high)
            };
            modes.extend((0..inside).map(|_| mode_at(model, frequency, work)));
            continue;
        }
        let middle = 0.5 * (low + high);
        let below = count(middle, work);
        pending.push((middle, below, high, below_high));
        pending.push((low, below_low, middle, below));
    }
    modes
}

/// Refines the single natural frequency (Hz) between `low` and `high` by bisection of the mode count, to
/// 1e-11 (relative).
fn refine_isolated(
    model: &AssembledModel,
    low: f64,
    below_low: usize,
    high: f64,
    work: &mut Workspace,
) -> f64 {
    let side = |f: f64, work: &mut Workspace| {
        if model.modes_below(omega_rad_s(f), work) > below_low { 1.0 } else { -1.0 }
    };
    refine(Bracket { lower: (low, -1.0), upper: (high, 1.0) }, WIDTH, |f| side(f, work))
}

/// Computes the mode shape by inverse iteration close to the natural frequency, and the damping ratio.
fn mode_at(model: &AssembledModel, frequency: f64, work: &mut Workspace) -> UndampedMode {
    let size = model.structure.size();
    let offset_rad_s = omega_rad_s(frequency * (1.0 + 1e-9));
    let mut shape: Vec<f64> = (0..size).map(|i| 1.0 + 0.1 * ((i * 7919) % 13) as f64).collect();
    for _ in 0..3 {
        shape = model.undamped_shape(offset_rad_s, &shape, work);
        let largest = shape.iter().copied().fold(0.0, |m: f64, x| if x.abs() > m.abs() { x } else { m });
        if largest == 0.0 || !largest.is_finite() {
            break;
        }
        shape.iter_mut().for_each(|x| *x /= largest);
    }
    let damping_ratio = model.modal_damping(omega_rad_s(frequency), &shape);
    UndampedMode { frequency_hz: frequency, shape, damping_ratio }
}

impl AssembledModel {
    /// Solves for the displacements of all coordinates under the given forces, without damping.
    fn undamped_shape(&self, omega_rad_s: f64, force: &[f64], work: &mut Workspace) -> Vec<f64> {
        self.factor_undamped(&[Reals::splat(omega_rad_s)], &mut work.real);
        let mut x: Vec<Reals> = force.iter().map(|f| Reals::splat(*f)).collect();
        self.structure.elimination.solve(1, &work.real, &mut x);
        x.into_iter().map(|x| x.to_array()[0]).collect()
    }

    /// Computes ζ = (φᵀ·Im D·φ) / (−ω·φᵀ·(dD/dω)·φ): the first-order damping ratio of an undamped mode.
    fn modal_damping(&self, omega_rad_s: f64, shape: &[f64]) -> Option<f64> {
        let complex: Vec<Complexes> = shape.iter().map(|x| Complexes::splat((*x).into())).collect();
        let at = Reals::splat(omega_rad_s);
        let rods: Vec<_> = self.rods.iter().map(|r| r.damped_each(at)).collect();
        let mut slope = [Complexes::ZERO];
        self.bilinear_slopes(
            Solution { omega_rad_s: &[at], at_excitation: &complex, at_response: &complex, rods: &rods },
            &mut slope,
        );
        let inertia = -slope[0].lanes()[0].re * omega_rad_s;
        let mut lost = 0.0;
        for (joint, on) in self.joints.iter().zip(&self.joint_points) {
            let deformation: f64 = on.iter().map(|&(i, c)| shape[i] * c).sum();
            lost += joint.dynamic(omega_rad_s).im * deformation * deformation;
        }
        for (beam, beam_shape) in
            self.beams.iter().zip(&self.structure.beams).filter(|(beam, _)| beam.loss_factor > 0.0)
        {
            lost += beam.damped_each(at).lanes()[0].im * shape[beam_shape.coordinate].powi(2);
        }
        for (rod, rod_shape) in
            self.rods.iter().zip(&self.structure.rods).filter(|(r, _)| r.loss_factor > 0.0)
        {
            let end = |c: Option<usize>| c.map_or(0.0, |i| shape[i]);
            let entries = rod.damped(omega_rad_s);
            let (a, b) = (end(rod_shape.ends[0]), end(rod_shape.ends[1]));
            lost += entries.direct.im * (a * a + b * b) + 2.0 * entries.cross.im * a * b;
        }
        (inertia > 0.0).then(|| lost / inertia)
    }
}
