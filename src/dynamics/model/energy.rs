//! Distribution of a mode's strain energy over joints and shafts.

use super::assembled_model::AssembledModel;
use super::simd::{Complexes, Reals};
use machine::{Machine, Operating};

/// Share of a joint, of one spring of a series in a joint, or of a shaft in a mode's strain energy.
#[derive(Debug, Clone, PartialEq)]
pub struct EnergyShare {
    /// Name of the joint (`joint`), of a spring in it (`joint/spring`), or of the shaft.
    pub name: String,
    /// Deformation Σ cᵢ·qᵢ of the joint or spring (m or rad) for the given mode shape; `None` for a shaft.
    pub deformation: Option<f64>,
    /// Share of the strain energy of all joints and shafts.
    pub share: f64,
}

impl AssembledModel {
    /// Computes how the strain energy of an undamped mode is distributed over joints and shafts. Springs of a
    /// series follow their joint, whose share includes theirs.
    ///
    /// A joint holds V = ½·k·(Σ cᵢ·qᵢ)², a rod V = ½·(qᵀ·D·q − ½·ω·qᵀ·(dD/dω)·q). The latter holds for the
    /// exact rod and for the chain: qᵀ·D·q is twice the potential less the kinetic energy, and −dD/d(ω²) is
    /// the mass matrix at ω.
    ///
    /// The share is twice the sensitivity of the frequency: d ln f/d ln k = V_k/(2·V).
    ///
    /// # Source  Rayleigh's quotient; lumped servo-axis paper, Fig. 9 («modal deformations of the springs»).
    pub fn strain_energy(
        &self,
        machine: &Machine,
        parameters: &[f64],
        operating: &Operating,
        omega_rad_s: f64,
        shape: &[f64],
    ) -> Vec<EnergyShare> {
        if shape.is_empty() {
            return Vec::new();
        }
        let mut rows: Vec<EnergyShare> = Vec::new();
        for ((described, joint), on) in machine.joints.iter().zip(&self.joints).zip(&self.joint_points) {
            let deformation: f64 = on.iter().map(|&(i, c)| shape[i] * c).sum();
            let energy = joint.stiffness * deformation * deformation;
            rows.push(EnergyShare {
                name: described.name.clone(),
                deformation: Some(deformation),
                share: energy,
            });
            for (spring, part) in described.stiffness.compliance_shares(parameters, operating) {
                let name = format!("{}/{spring}", described.name);
                rows.push(EnergyShare { name, deformation: Some(deformation * part), share: energy * part });
            }
        }
        for (at, shaft) in machine.shafts.iter().enumerate() {
            let mut energy = 0.0;
            for (rod, rod_shape) in self.rods.iter().zip(&self.structure.rods).filter(|(_, s)| s.shaft == at)
            {
                let at = Reals::splat(omega_rad_s);
                let entries = rod.damped_each(at);
                let slopes = rod.slopes_each(at, &entries);
                let end = |c: Option<usize>| c.map_or(0.0, |i| shape[i]);
                let (a, b) = (end(rod_shape.ends[0]), end(rod_shape.ends[1]));
                let form = |(direct, cross): (Complexes, Complexes)| {
                    direct.lanes()[0].re * (a * a + b * b) + 2.0 * cross.lanes()[0].re * a * b
                };
                energy += form((entries.direct, entries.cross)) - 0.5 * omega_rad_s * form(slopes);
            }
            for (beam, beam_shape) in
                self.beams.iter().zip(&self.structure.beams).filter(|(_, s)| s.shaft == at)
            {
                let at = Reals::splat(omega_rad_s);
                let potential = (beam.undamped_each(at).0
                    - beam.undamped_slopes_each(at) * at * Reals::splat(0.5))
                .to_array()[0];
                energy += potential * shape[beam_shape.coordinate].powi(2);
            }
            rows.push(EnergyShare { name: shaft.name.clone(), deformation: None, share: energy });
        }
        let whole: f64 = rows.iter().filter(|row| !row.name.contains('/')).map(|row| row.share).sum();
        if whole > 0.0 {
            rows.iter_mut().for_each(|row| row.share /= whole);
        }
        rows
    }
}
