//! Lateral bending of a shaft that is loaded off its axis at the nut.

use super::rod::modulus_each;
use super::simd::{Complexes, LANES, Reals};

/// The dynamic stiffness of a uniform beam on two bearings as the nut between them feels it: at the
/// displacement q = a·y + e·θ that deflection y and slope θ give along the axis, by a misalignment a and an
/// eccentricity e of the nut's force.
///
/// ```text
/// 1/D = dᵀ·(B_left + B_right + diag(k, 0))⁻¹·d,   d = (a, e)       k: lateral stiffness of the nut;  B: spans at (y, θ), rotations at the bearings eliminated
///
///                        ┌                                         ┐
/// span ℓ, near end:  E·I │ α³·(sh·c + ch·s)/ℓ³    ± α²·s·sh/ℓ²     │ 1      far end:  ± α²·(ch − c)/ℓ²  with y,   α·(sh − s)/ℓ  with θ,
///                        │ ± α²·s·sh/ℓ²            α·(ch·s − sh·c)/ℓ │ ─                α·(ch·s − sh·c)/ℓ + κ/L  on its diagonal
///                        └                                         ┘ N
///
/// N = 1 − c·ch,   α = ℓ·(ρ·S·ω²/(E·I))^¼,   s, c = sin α, cos α,   sh, ch = sinh α, cosh α,   ± : − on the left, + on the right
/// ```
///
/// # Units      E·I in N·m², ρ·S in kg/m, k in N/m, e in m; κ is the rotational stiffness of a bearing over
///   E·I/L
/// # Limits     ω → 0, a = 1, e = 0, k = 0 gives 48·E·I/L³ at the middle of a beam on two hinges, and
///   192·E·I/L³ between two clamps
/// # Source     Euler–Bernoulli beam: frequency functions of Koloušek, Dynamics in Engineering Structures
///   (1973); mode count of a clamped span: Howson
///   and Williams, J. Sound Vib. 26 (1973) 503–515. Checked against finite elements (test
///   `the_beam_agrees_with_finite_elements`)
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beam {
    /// E·I (N·m²).
    pub rigidity: f64,
    /// ρ·S (kg/m).
    pub mass_per_length: f64,
    /// Distance of the bearings L (m).
    pub length: f64,
    /// Distance of the nut from the left bearing (m).
    pub nut: f64,
    /// κ of the left and of the right bearing.
    pub clamping: [f64; 2],
    /// a and e (m).
    pub arms: [f64; 2],
    /// k (N/m).
    pub lateral_stiffness: f64,
    /// Loss factor η of E·I and of k, as of a rod.
    pub loss_factor: f64,
    /// Share s of dispersion of the loss factor.
    pub dispersion: f64,
    /// Decay rate σ of the window of a record (1/s): ω − iσ stands for ω.
    pub window_per_s: f64,
}

/// A number of a beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum BeamNumber {
    Rigidity,
    MassPerLength,
    Length,
    Nut,
    LeftClamping,
    RightClamping,
    Misalignment,
    Eccentricity,
    LateralStiffness,
    LossFactor,
    Dispersion,
}

/// Relative step of central differences, near the cube root of the rounding error, where truncation and
/// rounding are of one size.
const STEP: f64 = 1e-6;

/// Largest |α| for the first two terms of the series in α⁴. The third is below 1e-9 there, while the closed
/// forms cancel to 1e-13.
const SHORT: f64 = 0.25;

/// Entries of one span, on the near end and with its far end.
#[derive(Debug, Clone, Copy)]
struct Span {
    near: [Complexes; 3],
    far: [Complexes; 2],
    /// 1 − cos α·cosh α and α.
    denominator: Complexes,
    alpha: Complexes,
}

/// The spans on the left and on the right of the nut, for each frequency. Arms, bearings and the nut's
/// lateral stiffness are no part of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct BeamSpans {
    /// Relative complex modulus.
    material: Complexes,
    spans: [Span; 2],
}

impl Beam {
    /// Returns ω − iσ.
    fn complex_each(&self, omega_rad_s: Reals) -> Complexes {
        Complexes::new(omega_rad_s, Reals::splat(-self.window_per_s))
    }

    /// Computes a span of a length with the rigidity E·I·material.
    fn span(wave: Complexes, rigidity: Complexes, length: f64) -> Span {
        let alpha = wave * length;
        let (s, c) = alpha.sin_cos();
        let (turned, ch) = alpha.times_i().sin_cos();
        let sh = -turned.times_i();
        let denominator = Complexes::real(Reals::ONE) - c * ch;
        let scale = alpha * denominator.inverse();
        let square = scale * alpha;
        let closed = [
            square * alpha * (sh * c + ch * s),
            scale * (ch * s - sh * c),
            square * s * sh,
            square * (ch - c),
            scale * (sh - s),
        ];
        // Stiffness and consistent mass of one cubic element: Przemieniecki, Theory of Matrix Structural
        // Analysis (1968), sections 5.6 and 11.4.
        let fourth = alpha * alpha * alpha * alpha;
        let is_short = alpha.norm_sqr().simd_lt(Reals::splat(SHORT * SHORT));
        let either = |closed: Complexes, [at_rest, by_mass]: [f64; 2]| {
            let series = Complexes::real(Reals::splat(at_rest)) + fourth * (by_mass / 420.0);
            Complexes::new(is_short.select(series.re, closed.re), is_short.select(series.im, closed.im))
        };
        let series = [[12.0, -156.0], [4.0, -4.0], [6.0, -22.0], [6.0, 13.0], [2.0, 3.0]];
        let powers = [3, 1, 2, 2, 1];
        let [near_y, turning, both, far_y, far_turning] =
            std::array::from_fn(|at| rigidity * either(closed[at], series[at]) * length.powi(-powers[at]));
        Span {
            near: [near_y, turning, both],
            far: [far_y, far_turning],
            denominator: either(denominator, [0.0, 70.0]),
            alpha,
        }
    }

    /// Computes the spans at real or complex frequencies.
    fn spans(&self, omega_rad_s: Complexes, material: Complexes) -> BeamSpans {
        let rigidity = material * self.rigidity;
        let root = (rigidity.inverse() * self.mass_per_length).sqrt();
        let wave = (root * omega_rad_s).sqrt();
        BeamSpans {
            material,
            spans: [Self::span(wave, rigidity, self.nut), Self::span(wave, rigidity, self.length - self.nut)],
        }
    }

    /// Computes the spans with loss, for each frequency.
    pub fn spans_each(&self, omega_rad_s: Reals) -> BeamSpans {
        self.spans(
            self.complex_each(omega_rad_s),
            modulus_each(omega_rad_s, self.loss_factor, self.dispersion),
        )
    }

    /// Returns the entry of the rotation at each bearing.
    fn pivots(&self, BeamSpans { material, spans }: &BeamSpans) -> [Complexes; 2] {
        let rigidity = *material * self.rigidity;
        std::array::from_fn(|side| spans[side].near[1] + rigidity * (self.clamping[side] / self.length))
    }

    /// Returns the entries (y, y), (θ, θ) and (y, θ) of both spans and of the nut's lateral stiffness.
    fn joined(&self, of: &BeamSpans) -> [Complexes; 3] {
        let [left, right] = self.pivots(of);
        let condensed = |span: &Span, pivot: Complexes, sign: f64| {
            let [y, theta, both] = span.near;
            let [with_y, with_theta] = span.far;
            let inverse = pivot.inverse();
            [
                y - with_y * with_y * inverse,
                theta - with_theta * with_theta * inverse,
                (both - with_y * with_theta * inverse) * sign,
            ]
        };
        let ([a, b, c], [d, e, f]) =
            (condensed(&of.spans[0], left, -1.0), condensed(&of.spans[1], right, 1.0));
        [a + d + of.material * self.lateral_stiffness, b + e, c + f]
    }

    /// Returns D, and the determinant of the entries.
    fn condensed(&self, [y, theta, both]: [Complexes; 3]) -> (Complexes, Complexes) {
        let [a, e] = self.arms;
        let determinant = y * theta - both * both;
        let spread = theta * (a * a) - both * (2.0 * a * e) + y * (e * e);
        (determinant * spread.inverse(), determinant)
    }

    /// Computes D for each frequency.
    pub fn damped_each(&self, omega_rad_s: Reals) -> Complexes {
        self.damped_with(&self.spans_each(omega_rad_s))
    }

    /// Computes D from its spans.
    fn damped_with(&self, of: &BeamSpans) -> Complexes {
        self.condensed(self.joined(of)).0
    }

    /// Computes D without loss, and the number of modes below each frequency with q held.
    ///
    /// # Source  Wittrick and Williams, Q. J. Mech. Appl. Math. 24 (1971) 263–284: with q free there are as
    ///   many more as D is negative.
    pub fn undamped_each(&self, omega_rad_s: Reals) -> (Reals, Reals) {
        let of = self.spans(Complexes::real(omega_rad_s), Complexes::real(Reals::ONE));
        let entries = self.joined(&of);
        let (condensed, determinant) = self.condensed(entries);
        let negative = |x: Reals| x.to_array().map(|x| f64::from(u8::from(x < 0.0)));
        let clamped = of.spans.each_ref().map(|span| {
            let (alpha, denominator) = (span.alpha.re.to_array(), span.denominator.re.to_array());
            std::array::from_fn::<f64, LANES, _>(|lane| {
                let half_waves = (alpha[lane] / std::f64::consts::PI).floor();
                let parity = if half_waves % 2.0 == 0.0 { 1.0 } else { -1.0 };
                half_waves - 0.5 * (1.0 - parity * denominator[lane].signum())
            })
        });
        let [left, right] = self.pivots(&of);
        let pivots = [left.re, right.re, entries[0].re, determinant.re * entries[0].re].map(negative);
        let held = negative(condensed.re);
        let count = std::array::from_fn(|lane| {
            clamped[0][lane] + clamped[1][lane] + pivots.iter().map(|p| p[lane]).sum::<f64>() - held[lane]
        });
        (condensed.re, Reals::from(count))
    }

    /// Computes the derivative of D with one of the numbers, for each frequency. `of` is [`Beam::spans_each`]
    /// there: bearings, arms and the nut's lateral stiffness do not change it.
    pub fn slopes_each(&self, omega_rad_s: Reals, of: &BeamSpans, number: BeamNumber) -> Complexes {
        let size = match number {
            BeamNumber::Rigidity => self.rigidity,
            BeamNumber::MassPerLength => self.mass_per_length,
            BeamNumber::Length => self.length,
            BeamNumber::Nut => self.nut.min(self.length - self.nut),
            BeamNumber::Eccentricity => self.arms[1].abs().max(1e-3 * self.length),
            BeamNumber::LateralStiffness => self.lateral_stiffness.max(self.rigidity / self.length.powi(3)),
            BeamNumber::LeftClamping | BeamNumber::RightClamping => {
                self.clamping[usize::from(number == BeamNumber::RightClamping)].max(1.0)
            }
            BeamNumber::Misalignment | BeamNumber::LossFactor | BeamNumber::Dispersion => 1.0,
        };
        let step = STEP * size;
        let at = |by: f64| {
            let mut beam = *self;
            *match number {
                BeamNumber::Rigidity => &mut beam.rigidity,
                BeamNumber::MassPerLength => &mut beam.mass_per_length,
                BeamNumber::Length => &mut beam.length,
                BeamNumber::Nut => &mut beam.nut,
                BeamNumber::LeftClamping => &mut beam.clamping[0],
                BeamNumber::RightClamping => &mut beam.clamping[1],
                BeamNumber::Misalignment => &mut beam.arms[0],
                BeamNumber::Eccentricity => &mut beam.arms[1],
                BeamNumber::LateralStiffness => &mut beam.lateral_stiffness,
                BeamNumber::LossFactor => &mut beam.loss_factor,
                BeamNumber::Dispersion => &mut beam.dispersion,
            } += by;
            match number {
                BeamNumber::LeftClamping
                | BeamNumber::RightClamping
                | BeamNumber::Misalignment
                | BeamNumber::Eccentricity
                | BeamNumber::LateralStiffness => beam.damped_with(of),
                _ => beam.damped_each(omega_rad_s),
            }
        };
        (at(step) - at(-step)) * (0.5 / step)
    }

    /// Computes the derivative of D with ω, for each frequency.
    pub fn frequency_slopes_each(&self, omega_rad_s: Reals) -> Complexes {
        let step = omega_rad_s * Reals::splat(STEP);
        (self.damped_each(omega_rad_s + step) - self.damped_each(omega_rad_s - step))
            * (Reals::splat(0.5) / step)
    }

    /// Computes the derivative of D without loss with ω, for each frequency.
    pub fn undamped_slopes_each(&self, omega_rad_s: Reals) -> Reals {
        let step = omega_rad_s * Reals::splat(STEP);
        (self.undamped_each(omega_rad_s + step).0 - self.undamped_each(omega_rad_s - step).0)
            * (Reals::splat(0.5) / step)
    }

    /// Computes D at rest.
    pub fn static_stiffness(&self) -> f64 {
        self.undamped_each(Reals::ZERO).0.to_array()[0]
    }

    /// Computes a factor with zeros where D has poles: where the beam resonates with q held.
    pub fn poles_each(&self, omega_rad_s: Reals) -> Complexes {
        let of = self.spans_each(omega_rad_s);
        let (condensed, determinant) = self.condensed(self.joined(&of));
        let unit = self.length / self.rigidity;
        let rotations = of.spans.iter().zip(self.pivots(&of));
        let free = rotations.fold(determinant * (unit * unit), |product, (span, pivot)| {
            product * (pivot * span.denominator * unit)
        });
        free * condensed.inverse()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn beam(nut: f64, clamping: [f64; 2]) -> Beam {
        Beam {
            rigidity: 1600.0,
            mass_per_length: 2.5,
            length: 1.2,
            nut,
            clamping,
            arms: [0.0, 0.01],
            lateral_stiffness: 0.0,
            loss_factor: 0.0,
            dispersion: 0.0,
            window_per_s: 0.0,
        }
    }

    /// Number of modes below λ·L with the nut free.
    fn modes_below(beam: &Beam, wave_times_length: f64) -> f64 {
        let omega = (wave_times_length / beam.length).powi(2) * (beam.rigidity / beam.mass_per_length).sqrt();
        let (felt, held) = beam.undamped_each(Reals::splat(omega));
        held.to_array()[0] + f64::from(u8::from(felt.to_array()[0] < 0.0))
    }

    /// Between hinges λ·L = nπ, between clamps 4.7300, 7.8532, 10.9956; wherever the nut sits.
    ///
    /// # Source  Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-1.
    #[test]
    fn limit_modes_of_a_beam_without_a_nut() {
        for nut in [0.31, 0.6, 0.9] {
            for (clamping, roots) in [
                ([0.0; 2], [PI, 2.0 * PI, 3.0 * PI]),
                ([1e9; 2], [4.73004, 7.85320, 10.9956]),
                ([1e9, 0.0], [3.92660, 7.06858, 10.2102]),
            ] {
                for (below, root) in roots.iter().enumerate() {
                    let count = |factor: f64| modes_below(&beam(nut, clamping), root * factor);
                    assert_eq!(
                        (count(0.999), count(1.001)),
                        (below as f64, below as f64 + 1.0),
                        "nut {nut} m, clamping {clamping:?}, root {root}"
                    );
                }
            }
        }
    }

    /// The closed forms and the series for short waves agree where one takes over, and both with finite
    /// elements.
    #[test]
    fn limit_short_waves_are_a_cubic_element() {
        let of = Beam { arms: [0.1, 0.01], lateral_stiffness: 1e5, ..beam(0.02, [3.0, 0.7]) };
        let change = (SHORT / 0.02_f64).powi(2) * (of.rigidity / of.mass_per_length).sqrt();
        let [below, above] =
            [0.999, 1.001].map(|factor| of.damped_each(Reals::splat(factor * change)).lanes()[0].re);
        let expected = [0.999, 1.001].map(|factor| by_finite_elements(&of, factor * change));
        assert!(
            (below / expected[0] - 1.0).abs() < 1e-3 && (above / expected[1] - 1.0).abs() < 1e-3,
            "{below} {above} for {expected:?}"
        );
        assert_eq!(modes_below(&beam(0.005, [3.0, 0.7]), 1e-4), 0.0);
        assert!((of.static_stiffness() / of.damped_each(Reals::splat(1.0)).lanes()[0].re - 1.0).abs() < 1e-4);
    }

    /// 48·E·I/L³ at the middle between hinges, 192·E·I/L³ between clamps; against the slope there 12 and
    /// 16·E·I/L.
    #[test]
    fn limit_static_stiffness_at_the_middle() {
        for (clamping, deflection, slope) in [([0.0; 2], 48.0, 12.0), ([1e9; 2], 192.0, 16.0)] {
            let of = beam(0.6, clamping);
            let unit = of.rigidity / of.length;
            for (arms, expected) in
                [([1.0, 0.0], deflection * unit / of.length.powi(2)), ([0.0, 0.01], slope * unit * 1e4)]
            {
                let found = Beam { arms, ..of }.damped_each(Reals::splat(1.0)).lanes()[0].re;
                assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected}");
            }
        }
    }

    /// A chain of cubic elements with consistent masses, condensed to the displacement that the nut feels.
    ///
    /// # Source  Przemieniecki, Theory of Matrix Structural Analysis (1968), sections 5.6 and 11.4.
    fn by_finite_elements(beam: &Beam, omega_rad_s: f64) -> f64 {
        let elements = 60;
        let size = 2 * (2 * elements + 1);
        let mut d = nalgebra::DMatrix::<f64>::zeros(size, size);
        for at in 0..2 * elements {
            let l = if at < elements { beam.nut } else { beam.length - beam.nut } / elements as f64;
            let k = beam.rigidity / l.powi(3);
            let m = beam.mass_per_length * l / 420.0 * omega_rad_s * omega_rad_s;
            let of = |a: f64, b: f64, l: f64| k * a * l - m * b * l;
            let own = [
                [of(12.0, 156.0, 1.0), of(6.0, 22.0, l), of(-12.0, 54.0, 1.0), of(6.0, -13.0, l)],
                [of(6.0, 22.0, l), of(4.0, 4.0, l * l), of(-6.0, 13.0, l), of(2.0, -3.0, l * l)],
                [of(-12.0, 54.0, 1.0), of(-6.0, 13.0, l), of(12.0, 156.0, 1.0), of(-6.0, -22.0, l)],
                [of(6.0, -13.0, l), of(2.0, -3.0, l * l), of(-6.0, -22.0, l), of(4.0, 4.0, l * l)],
            ];
            for (i, row) in own.iter().enumerate() {
                row.iter().enumerate().for_each(|(j, x)| d[(2 * at + i, 2 * at + j)] += x);
            }
        }
        let spring = |at: usize| beam.clamping[at] * beam.rigidity / beam.length;
        d[(1, 1)] += spring(0);
        d[(size - 1, size - 1)] += spring(1);
        d[(2 * elements, 2 * elements)] += beam.lateral_stiffness;
        let moving: Vec<usize> = (1..size).filter(|i| *i != size - 2).collect();
        let mut force = nalgebra::DVector::zeros(size);
        (force[2 * elements], force[2 * elements + 1]) = (beam.arms[0], beam.arms[1]);
        let (d, force) = (d.select_rows(&moving).select_columns(&moving), force.select_rows(&moving));
        1.0 / force.dot(&d.lu().solve(&force).unwrap())
    }

    #[test]
    fn the_beam_agrees_with_finite_elements() {
        for (clamping, arms, lateral_stiffness) in [
            ([0.0, 0.0], [0.0, 0.01], 0.0),
            ([3.0, 0.7], [0.1, 0.01], 1e5),
            ([50.0, 8.0], [-0.05, 0.02], 1e6),
        ] {
            let of = Beam { arms, lateral_stiffness, ..beam(0.47, clamping) };
            for hz in [5.0, 40.0, 130.0, 330.0] {
                let omega = std::f64::consts::TAU * hz;
                let (found, expected) =
                    (of.damped_each(Reals::splat(omega)).lanes()[0].re, by_finite_elements(&of, omega));
                assert!((found / expected - 1.0).abs() < 1e-3, "{hz} Hz: {found:e} for {expected:e}");
            }
        }
    }

    #[test]
    fn slopes_match_the_change_of_the_beam() {
        let of = Beam {
            arms: [0.1, 0.01],
            lateral_stiffness: 1e5,
            loss_factor: 0.03,
            dispersion: 0.4,
            ..beam(0.47, [3.0, 0.7])
        };
        let omega = Reals::splat(900.0);
        let here = of.damped_each(omega);
        let softer = Beam {
            rigidity: 0.99 * of.rigidity,
            mass_per_length: 0.99 * of.mass_per_length,
            lateral_stiffness: 0.99 * of.lateral_stiffness,
            ..of
        };
        // All stiffnesses and masses in one proportion change D in the same.
        let change = (here - softer.damped_each(omega)) * 100.0;
        assert!((change.lanes()[0] / here.lanes()[0] - 1.0).norm() < 1e-9);
        let slope =
            |number, size: f64| of.slopes_each(omega, &of.spans_each(omega), number).lanes()[0] * size;
        let sum = slope(BeamNumber::Rigidity, of.rigidity)
            + slope(BeamNumber::MassPerLength, of.mass_per_length)
            + slope(BeamNumber::LateralStiffness, of.lateral_stiffness);
        assert!((sum / here.lanes()[0] - 1.0).norm() < 1e-6, "{sum}");
        let moved = |nut: f64, length: f64| Beam { nut, length, ..of }.damped_each(omega).lanes()[0];
        let by_nut = (moved(of.nut + 1e-4, of.length) - moved(of.nut - 1e-4, of.length)) / 2e-4;
        let by_length = (moved(of.nut, of.length + 1e-4) - moved(of.nut, of.length - 1e-4)) / 2e-4;
        for (number, expected) in [(BeamNumber::Nut, by_nut), (BeamNumber::Length, by_length)] {
            assert!(
                (slope(number, 1.0) / expected - 1.0).norm() < 1e-4,
                "{number:?}: {} for {expected}",
                slope(number, 1.0)
            );
        }
    }
}
