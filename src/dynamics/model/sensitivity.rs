//! Exact derivatives of a receptance with a machine's parameters.
//!
//! ```text
//! ∂H_rv/∂a = − x_rᵀ·(∂D/∂a)·x_e        x_r, x_e: displacements under a unit force at the response and at the excitation
//! ```
//!
//! For a lever arm r at one end, ∂H/∂r is the displacement of the arm's coordinate under a unit force at the
//! other end.
//!
//! D depends on a few elements (a stiffness, an inertia, a rod's transit time …), and these depend on the
//! parameters. The derivatives of the elements are computed once per operating condition, those of D at each
//! frequency.
//!
//! # Source  derivative of the inverse of a symmetric matrix, d(D⁻¹) = −D⁻¹·dD·D⁻¹.

use super::assembled_model::AssembledModel;
use super::beam::{BeamNumber, BeamSpans};
use super::frequency_grid::Frequencies;
use super::joint::{JointNumbers, over_each};
use super::receptance::ReceptanceEnd;
use super::rod::dispersion_each;
use super::simd::{ABREAST, Complexes, Reals};
use super::solution::Solution;
use super::workspace::Workspace;
use machine::{Machine, Operating};

/// An element: a number on which the dynamic stiffness depends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Element {
    /// Inertia at a coordinate.
    Inertia(usize),
    /// Stiffness of a joint.
    Stiffness(usize),
    /// Damping of a joint.
    Damping(usize),
    /// Loss factor of a joint.
    Loss(usize),
    /// Share of dispersion of a joint's loss factor.
    Dispersion(usize),
    /// Integral rate of a joint.
    Integral(usize),
    /// Relaxation stiffness of a joint.
    Relaxation(usize),
    /// Relative deviation of the lead of a joint.
    Lead(usize),
    /// A number of a rod.
    Rod(usize, RodNumber),
    /// A number of a beam.
    Beam(usize, BeamNumber),
    /// Lever arm r, of the sensor or of the hammer.
    Lever(usize, ReceptanceEnd),
}

/// A number of a rod.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum RodNumber {
    /// A/L.
    Stiffness,
    /// Transit time.
    Transit,
    /// Loss factor.
    Loss,
    /// Share of dispersion of the loss factor.
    Dispersion,
}

/// Factors shared by all numbers of one rod at one group of frequencies.
#[derive(Debug, Clone, Copy)]
struct AtRod {
    /// aᵀ·(∂D/∂entry)·b of the direct and of the cross entry.
    factors: (Complexes, Complexes),
    /// d(direct)/dω and d(cross)/dω.
    slopes: (Complexes, Complexes),
    /// aᵀ·(∂D/∂material)·b.
    by_material: Complexes,
}

impl AtRod {
    const NONE: Self = AtRod {
        factors: (Complexes::ZERO, Complexes::ZERO),
        slopes: (Complexes::ZERO, Complexes::ZERO),
        by_material: Complexes::ZERO,
    };
}

/// What several elements share, for each group of frequencies that is evaluated. Entries of one rod, or of
/// one beam, follow each other.
struct Shared {
    /// 2/π·ln(ω/ω₀), the slope of a loss with its share of dispersion.
    dispersion: [Reals; ABREAST],
    /// Of the last rod.
    rod: [AtRod; ABREAST],
    /// Spans of the last beam.
    beam: [Option<BeamSpans>; ABREAST],
}

/// Derivatives of a model's elements with some parameters, for one operating condition and one set of
/// parameters.
#[derive(Debug, Clone, Default)]
pub struct Sensitivity {
    /// Element, column, d(element)/d(parameter of the column); entries of one element are contiguous.
    entries: Vec<(Element, usize, f64)>,
}

/// Computes d ln(1 − b^power)/db of a bore ratio b: 2 for the area of a section, 4 for its second moments.
fn section_by_bore(bore: f64, power: i32) -> f64 {
    -f64::from(power) * bore.powi(power - 1) / (1.0 - bore.powi(power))
}

/// Computes the derivative of the true nut position with the stated one, of which it is a linear function.
fn true_by_stated(nut_position: &machine::Value, parameters: &[f64], operating: &Operating) -> f64 {
    let at = |nut_m: f64| nut_position.at(parameters, &Operating { nut_m: Some(nut_m), ..*operating });
    at(1.0) - at(0.0)
}

impl AssembledModel {
    /// Computes the derivatives of the elements with the parameters. `column[i]` is the column of the
    /// machine's parameter i, `None` if not required; `nut` is the column of the nut position.
    pub fn sensitivity(
        &self,
        machine: &Machine,
        parameters: &[f64],
        operating: &Operating,
        column: &[Option<usize>],
        nut: Option<usize>,
    ) -> Sensitivity {
        let shape = &self.structure;
        let mut entries = Vec::new();
        for (point, coordinate) in machine.points.iter().zip(&shape.coordinate) {
            if let Some(i) = *coordinate {
                point.inertia.gradient(parameters, operating, |p, d| {
                    entries.extend(column[p].map(|c| (Element::Inertia(i), c, d)));
                });
            }
        }
        let share_s = machine.stiffness_proportional_damping_s;
        for (index, joint) in machine.joints.iter().enumerate() {
            joint.stiffness.gradient(parameters, operating, |p, d| {
                if let Some(c) = column[p] {
                    entries.push((Element::Stiffness(index), c, d));
                    if share_s != 0.0 {
                        entries.push((Element::Damping(index), c, share_s * d));
                    }
                }
            });
            let mut push = |element, value: &machine::Value| {
                value.gradient(parameters, operating, |p, d| {
                    entries.extend(column[p].map(|c| (element, c, d)))
                });
            };
            push(Element::Damping(index), &joint.damping);
            push(Element::Loss(index), &joint.loss_factor);
            push(Element::Dispersion(index), &machine.loss_dispersion);
            push(Element::Integral(index), &joint.integral_rate);
            push(Element::Lead(index), &joint.lead_error.growth);
            if let Some(relaxation) = &joint.relaxation_stiffness {
                push(Element::Relaxation(index), relaxation);
            }
        }
        let at = (machine, parameters, operating);
        (0..self.rods.len()).for_each(|rod| self.rod_entries(rod, at, column, nut, &mut entries));
        (0..self.beams.len()).for_each(|beam| self.beam_entries(beam, at, column, nut, &mut entries));
        let arms = machine.chain.levers.iter().enumerate().flat_map(|(at, l)| {
            [(at, ReceptanceEnd::Response, &l.sensor_arm), (at, ReceptanceEnd::Excitation, &l.hammer_arm)]
        });
        for (index, end, arm) in arms {
            arm.gradient(parameters, operating, |p, d| {
                entries.extend(column[p].map(|c| (Element::Lever(index, end), c, d)))
            });
        }
        entries.sort_by_key(|(element, _, _)| *element);
        Sensitivity { entries }
    }

    /// Adds the derivatives of a rod's numbers.
    fn rod_entries(
        &self,
        index: usize,
        (machine, parameters, operating): (&Machine, &[f64], &Operating),
        column: &[Option<usize>],
        nut: Option<usize>,
        entries: &mut Vec<(Element, usize, f64)>,
    ) {
        let (rod_shape, rod) = (&self.structure.rods[index], &self.rods[index]);
        let shaft = &machine.shafts[rod_shape.shaft];
        let place = |p| shaft.place_m(p, parameters, operating).unwrap_or(f64::NAN);
        let length_m = place(rod_shape.places.1) - place(rod_shape.places.0);
        // d ln(stiffness) and d ln(transit time) with length, section, modulus and density.
        let (k, t) = (rod.stiffness, rod.transit_s);
        let mut push = |column: usize, dk: f64, dt: f64| {
            if dk != 0.0 {
                entries.push((Element::Rod(index, RodNumber::Stiffness), column, dk));
            }
            if dt != 0.0 {
                entries.push((Element::Rod(index, RodNumber::Transit), column, dt));
            }
        };
        let mut with = |value: &machine::Value, dk: f64, dt: f64| {
            let number = value.at(parameters, operating);
            value.gradient(parameters, operating, |p, d| {
                if let Some(c) = column[p] {
                    push(c, dk * k * d / number, dt * t * d / number);
                }
            });
        };
        with(&shaft.diameter, if rod_shape.torsional { 4.0 } else { 2.0 }, 0.0);
        with(if rod_shape.torsional { &shaft.shear_modulus } else { &shaft.youngs_modulus }, 1.0, -0.5);
        with(&shaft.density, 0.0, 0.5);
        let at_end = |p| f64::from(u8::from(p == machine::StationPlace::End));
        let with_end = at_end(rod_shape.places.1) - at_end(rod_shape.places.0);
        if with_end != 0.0 {
            let share = with_end * shaft.length.at(parameters, operating) / length_m;
            with(&shaft.length, -share, share);
        }
        let (bore, power) =
            (shaft.bore_ratio.at(parameters, operating), if rod_shape.torsional { 4 } else { 2 });
        let by_bore = section_by_bore(bore, power);
        shaft.bore_ratio.gradient(parameters, operating, |p, d| {
            if let Some(c) = column[p] {
                push(c, by_bore * k * d, 0.0);
            }
        });
        let at_nut = |p| {
            f64::from(u8::from(matches!(p, machine::StationPlace::Nut | machine::StationPlace::NearNut(_))))
        };
        let share = (at_nut(rod_shape.places.1) - at_nut(rod_shape.places.0)) / length_m;
        let moves = shaft.nut_moves(parameters, operating);
        shaft.nut_position.gradient(parameters, operating, |p, d| {
            if let Some(c) = column[p].filter(|_| moves) {
                push(c, -k * share * d, t * share * d);
            }
        });
        if let Some(nut) = nut.filter(|_| moves) {
            let share = share * true_by_stated(&shaft.nut_position, parameters, operating);
            push(nut, -k * share, t * share);
        }
        let nut_offset = |p| if let machine::StationPlace::NearNut(offset_m) = p { offset_m } else { 0.0 };
        let (left, right) = (nut_offset(rod_shape.places.0), nut_offset(rod_shape.places.1));
        for (value, farther) in
            [(&shaft.nut_support_factor, right - left), (&shaft.nut_support_offset, right.abs() - left.abs())]
        {
            value.gradient(parameters, operating, |p, d| {
                if let Some(c) = column[p] {
                    push(c, -k * farther / length_m * d, t * farther / length_m * d);
                }
            });
        }
        for (number, value) in
            [(RodNumber::Loss, &shaft.loss_factor), (RodNumber::Dispersion, &machine.loss_dispersion)]
        {
            value.gradient(parameters, operating, |p, d| {
                entries.extend(column[p].map(|c| (Element::Rod(index, number), c, d)))
            });
        }
    }

    /// Adds the derivatives of a beam's numbers.
    fn beam_entries(
        &self,
        index: usize,
        (machine, parameters, operating): (&Machine, &[f64], &Operating),
        column: &[Option<usize>],
        nut: Option<usize>,
        entries: &mut Vec<(Element, usize, f64)>,
    ) {
        let beam = &self.beams[index];
        let shaft = &machine.shafts[self.structure.beams[index].shaft];
        let Some(bending) = &shaft.bending else { return };
        let at = |value: &machine::Value| value.at(parameters, operating);
        let mut push = |number: BeamNumber, value: &machine::Value, factor: f64| {
            let element = Element::Beam(index, number);
            value.gradient(parameters, operating, |p, d| {
                entries.extend(column[p].map(|c| (element, c, factor * d)))
            });
        };
        let (diameter, bore) = (at(&shaft.diameter), at(&shaft.bore_ratio));
        push(BeamNumber::Rigidity, &shaft.youngs_modulus, beam.rigidity / at(&shaft.youngs_modulus));
        push(BeamNumber::Rigidity, &shaft.diameter, 4.0 * beam.rigidity / diameter);
        push(BeamNumber::Rigidity, &shaft.bore_ratio, section_by_bore(bore, 4) * beam.rigidity);
        push(BeamNumber::MassPerLength, &shaft.density, beam.mass_per_length / at(&shaft.density));
        push(BeamNumber::MassPerLength, &shaft.diameter, 2.0 * beam.mass_per_length / diameter);
        push(BeamNumber::MassPerLength, &shaft.bore_ratio, section_by_bore(bore, 2) * beam.mass_per_length);
        push(BeamNumber::Length, &shaft.length, 1.0);
        push(BeamNumber::LeftClamping, &bending.clamping[0], 1.0);
        push(BeamNumber::RightClamping, &bending.clamping[1], 1.0);
        push(BeamNumber::Misalignment, &bending.misalignment, 1.0);
        push(BeamNumber::LateralStiffness, &bending.lateral_stiffness, 1.0);
        push(BeamNumber::Eccentricity, &bending.eccentricity, 1.0);
        push(BeamNumber::LossFactor, &bending.loss_factor, 1.0);
        push(BeamNumber::Dispersion, &machine.loss_dispersion, 1.0);
        if shaft.nut_moves(parameters, operating) {
            push(BeamNumber::Nut, &shaft.nut_position, 1.0);
            if let Some(nut) = nut {
                let by_stated = true_by_stated(&shaft.nut_position, parameters, operating);
                entries.push((Element::Beam(index, BeamNumber::Nut), nut, by_stated));
            }
        }
    }

    /// Computes receptances at up to [`ABREAST`](super::ABREAST) groups of frequencies. Adds their
    /// derivatives with the columns of a
    /// [`Sensitivity`] to `gradient`: column c of group w at c·groups + w.
    pub fn gradient<'w>(
        &self,
        at: Frequencies<'w>,
        sensitivity: &Sensitivity,
        work: &'w mut Workspace,
        gradient: &mut [Complexes],
    ) -> &'w [Complexes] {
        let omega_rad_s = at.omega_rad_s;
        let (receptances, solution) = self.solve(at, work);
        let mut products = [Complexes::ZERO; ABREAST];
        let mut of = None;
        let dispersion =
            std::array::from_fn(|w| omega_rad_s.get(w).map_or(Reals::ZERO, |omega| dispersion_each(*omega)));
        let mut shared = Shared { dispersion, rod: [AtRod::NONE; ABREAST], beam: [None; ABREAST] };
        let (mut last_rod, mut last_beam) = (None, None);
        for &(element, column, slope) in &sensitivity.entries {
            if of.replace(element) != Some(element) {
                match element {
                    Element::Rod(rod, _) if last_rod.replace(rod) != Some(rod) => {
                        self.at_rod(rod, &solution, &mut shared.rod)
                    }
                    Element::Beam(beam, _) if last_beam.replace(beam) != Some(beam) => {
                        let groups = shared.beam.iter_mut().zip(omega_rad_s);
                        groups.for_each(|(spans, omega)| *spans = Some(self.beams[beam].spans_each(*omega)));
                    }
                    _ => {}
                }
                products.iter_mut().take(omega_rad_s.len()).enumerate().for_each(|(w, product)| {
                    *product = self.element_product(element, &solution, (&shared, w));
                });
            }
            let sums = gradient[column * omega_rad_s.len()..][..omega_rad_s.len()].iter_mut();
            sums.zip(&products).for_each(|(sum, product)| *sum -= *product * slope);
        }
        receptances
    }

    /// Computes the shared factors of a rod at each group of frequencies, in place: copying them takes as
    /// long as computing them.
    fn at_rod(&self, rod: usize, of: &Solution<'_>, groups: &mut [AtRod; ABREAST]) {
        let abreast = of.omega_rad_s.len();
        for (w, (group, omega)) in groups.iter_mut().zip(of.omega_rad_s).enumerate() {
            let entries = &of.rods[rod * abreast + w];
            let (direct, cross) = of.rod_factors(self.structure.rods[rod].ends, w);
            let slopes = self.rods[rod].slopes_each(*omega, entries);
            let (by_direct, by_cross) = entries.by_material(*omega, slopes);
            let by_material = (direct * by_direct + cross * by_cross) * entries.material_inverse;
            *group = AtRod { factors: (direct, cross), slopes, by_material };
        }
    }

    /// Computes the factor of a loss factor for one group of frequencies, as
    /// [`loss_each`](super::rod::loss_each).
    #[inline]
    fn loss(&self, shared: &Shared, w: usize) -> Complexes {
        Complexes::new(shared.dispersion[w] * Reals::splat(self.dispersion), Reals::ONE)
    }

    /// Computes aᵀ·(∂D/∂number)·b of one number of a rod for one group of frequencies.
    #[inline]
    fn rod_product(
        &self,
        rod: usize,
        number: RodNumber,
        of: &Solution<'_>,
        (shared, w): (&Shared, usize),
    ) -> Complexes {
        let AtRod { factors: (direct, cross), slopes, by_material } = shared.rod[w];
        let (omega, entries) = (of.omega_rad_s[w], &of.rods[rod * of.omega_rad_s.len() + w]);
        let rod = &self.rods[rod];
        match number {
            RodNumber::Stiffness => (direct * entries.direct + cross * entries.cross) * (1.0 / rod.stiffness),
            RodNumber::Transit => {
                (direct * slopes.0 + cross * slopes.1) * (omega * Reals::splat(1.0 / rod.transit_s))
            }
            RodNumber::Loss => by_material * self.loss(shared, w),
            RodNumber::Dispersion if rod.loss_factor == 0.0 => Complexes::ZERO,
            RodNumber::Dispersion => by_material * (shared.dispersion[w] * Reals::splat(rod.loss_factor)),
        }
    }

    /// Computes aᵀ·(∂D/∂element)·b for one group of frequencies.
    #[inline]
    fn element_product(
        &self,
        element: Element,
        of: &Solution<'_>,
        (shared, w): (&Shared, usize),
    ) -> Complexes {
        let omega = of.omega_rad_s[w];
        let s = self.complex_frequency_each(omega);
        let product = |joint: usize| {
            let on = &self.joint_points[joint];
            of.deformation(of.at_response, on, w) * of.deformation(of.at_excitation, on, w)
        };
        match element {
            Element::Inertia(at) => of.product(at, w) * (s * s),
            Element::Stiffness(joint) => {
                let of = &self.joints[joint];
                if of.loss_factor == 0.0 && of.integral_rate == 0.0 {
                    return product(joint);
                }
                let mut factor = Complexes::real(Reals::ONE) + self.loss(shared, w) * of.loss_factor;
                if of.integral_rate != 0.0 {
                    factor += over_each(of.integral_rate, s);
                }
                product(joint) * factor
            }
            Element::Integral(joint) => product(joint) * over_each(self.joints[joint].stiffness, s),
            Element::Loss(joint) => product(joint) * self.loss(shared, w) * self.joints[joint].stiffness,
            Element::Dispersion(joint) => {
                let JointNumbers { stiffness, loss_factor, .. } = self.joints[joint];
                if loss_factor == 0.0 {
                    Complexes::ZERO
                } else {
                    product(joint) * (shared.dispersion[w] * Reals::splat(stiffness * loss_factor))
                }
            }
            Element::Beam(beam, number) => {
                let Some(spans) = &shared.beam[w] else { return Complexes::ZERO };
                self.beams[beam].slopes_each(omega, spans, number)
                    * of.product(self.structure.beams[beam].coordinate, w)
            }
            Element::Rod(rod, number) => self.rod_product(rod, number, of, (shared, w)),
            Element::Damping(joint) => self.joints[joint].damper_derivative_each(product(joint), s) * s,
            Element::Relaxation(joint) => {
                let Some(k) = self.joints[joint].relaxation_stiffness else { return Complexes::ZERO };
                let share = self.joints[joint].damper_each(k, s) * (1.0 / k);
                product(joint) * (share * share)
            }
            Element::Lead(joint) => {
                let (all, turning) = (&self.joint_points[joint], &self.structure.screws[joint]);
                let [response, excitation] = [of.at_response, of.at_excitation];
                let [whole, turned] = [all, turning]
                    .map(|on| [of.deformation(response, on, w), of.deformation(excitation, on, w)]);
                (whole[0] * turned[1] + turned[0] * whole[1]) * self.joints[joint].dynamic_each(omega, s)
            }
            // A lever is not part of D: H = f_rᵀ·D⁻¹·f_e depends on it through the force vectors.
            Element::Lever(lever, end) => {
                let (arms, x) = match end {
                    ReceptanceEnd::Response => (&self.structure.response_arms, of.at_excitation),
                    ReceptanceEnd::Excitation => (&self.structure.excitation_arms, of.at_response),
                };
                let felt = arms.iter().filter(|(own, _)| *own == lever);
                felt.fold(Complexes::ZERO, |sum, (_, on)| sum - x[on * of.omega_rad_s.len() + w])
            }
        }
    }
}
