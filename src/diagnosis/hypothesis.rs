//! Hypotheses about what a machine's description lacks: each is one patched machine.

use machine::{
    Data, Effect, EffectIds, FitRule, JointPatch, Machine, MachineError, Mechanism, NumberSource, Operating,
    Parameter, Patch, PointMotion, PointPatch, Rescale, Role, Scale, TargetKind, UnitValues,
};
use num_complex::Complex64;
use numeric::statistics::quantile;

/// Kind of a hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub enum HypothesisKind {
    /// Nothing: the machine as described, with its tolerances.
    Nominal,
    /// An effect of the library or of the user.
    Effect,
    /// A frozen parameter is released.
    Release,
    /// A generic dynamic stiffness at an interface, which locates a discrepancy without naming its cause.
    Interface {
        /// Point or joint.
        interface: String,
        /// Form of the dynamic stiffness.
        shape: Shape,
    },
}

/// Form of a generic dynamic stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// Spring: k.
    Stiffness,
    /// Damper: iωc.
    Damping,
    /// Mass: −ω²m.
    Mass,
    /// Mass attached by a spring and a damper.
    Resonator,
    /// Damper in series with a spring.
    Relaxation,
}

impl Shape {
    /// Returns its name.
    pub fn word(self) -> &'static str {
        match self {
            Shape::Stiffness => "stiffness",
            Shape::Damping => "damping",
            Shape::Mass => "mass",
            Shape::Resonator => "resonator",
            Shape::Relaxation => "relaxation",
        }
    }

    /// Computes the dynamic stiffness (N/m or N·m/rad) at an angular frequency (rad/s).
    pub fn dynamic_stiffness(self, amplitudes: &Amplitudes, omega_rad_s: f64) -> Complex64 {
        let Amplitudes { stiffness, damping, inertia } = *amplitudes;
        let (i, omega) = (Complex64::i(), omega_rad_s);
        let spring = stiffness + i * omega * damping;
        match self {
            Shape::Stiffness | Shape::Damping => spring,
            Shape::Mass => Complex64::from(-omega * omega * inertia),
            Shape::Resonator => {
                let inertia = -omega * omega * inertia;
                inertia * spring / (spring + inertia)
            }
            Shape::Relaxation => {
                let damper = i * omega * damping;
                damper / (1.0 + damper / stiffness)
            }
        }
    }
}

/// Amplitudes of a generic dynamic stiffness; 0 where its shape has none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Amplitudes {
    /// k (N/m or N·m/rad).
    pub stiffness: f64,
    /// c (N·s/m or N·m·s/rad).
    pub damping: f64,
    /// m (kg or kg·m²).
    pub inertia: f64,
}

/// A machine with an addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Kind of the addition.
    pub kind: HypothesisKind,
    /// Effects and released parameters that it adds; none for a generic impedance.
    pub effects: EffectIds,
    /// The machine with the addition.
    pub machine: Machine,
    /// Indices of the added parameters.
    pub added: Vec<usize>,
}

impl Hypothesis {
    /// Returns its id: that of its effects, `interface:shape` or `nominal`.
    pub fn id(&self) -> String {
        match &self.kind {
            HypothesisKind::Nominal => "nominal".into(),
            HypothesisKind::Effect | HypothesisKind::Release => self.effects.to_string(),
            HypothesisKind::Interface { interface, shape } => format!("{interface}:{}", shape.word()),
        }
    }

    /// Computes the dynamic stiffness that a generic impedance with these parameter values adds, at an
    /// angular frequency (rad/s). `None` for other hypotheses.
    pub fn dynamic_stiffness(&self, values: &[f64], omega_rad_s: f64) -> Option<Complex64> {
        let HypothesisKind::Interface { shape, .. } = &self.kind else { return None };
        let mut amplitudes = Amplitudes::default();
        for index in &self.added {
            match self.machine.parameters[*index].mechanism {
                Mechanism::Stiffness => amplitudes.stiffness = values[*index],
                Mechanism::Damping => amplitudes.damping = values[*index],
                Mechanism::Inertia => amplitudes.inertia = values[*index],
                _ => {}
            }
        }
        Some(shape.dynamic_stiffness(&amplitudes, omega_rad_s))
    }

    /// Returns why an effect does not apply to this kind of data or to this machine.
    pub(super) fn obstacle(&self, effect: &Effect, data: Data) -> Option<String> {
        if !effect.data.contains(&data) {
            return Some(match data {
                Data::Frf => "it affects motion records only".into(),
                Data::Motion => "it affects frequency responses and modes only".into(),
            });
        }
        if self.machine.effects.contains(&effect.id) {
            return Some("the machine already contains it".into());
        }
        self.machine.missing_part(effect).map(|name| format!("the machine has no «{name}»"))
    }

    /// Returns hypotheses that each release one frozen parameter of a machine, except those in `but`.
    pub(super) fn releases<'h>(
        &'h self,
        machine: &'h Machine,
        frozen: &'h [String],
        but: &'h [String],
    ) -> impl Iterator<Item = Hypothesis> + 'h {
        let held =
            move |p: &Parameter| (frozen.contains(&p.id) || p.fit == FitRule::Never) && !but.contains(&p.id);
        machine
            .parameters
            .iter()
            .enumerate()
            .filter(move |(_, p)| held(p))
            .map(|(index, _)| self.releasing(index))
    }

    /// Returns the hypothesis without an addition.
    pub fn nominal(machine: Machine) -> Self {
        Hypothesis {
            kind: HypothesisKind::Nominal,
            effects: EffectIds::default(),
            machine,
            added: Vec::new(),
        }
    }

    /// Adds an effect.
    ///
    /// # Errors  as [`Machine::with_effect`]: the effect does not apply.
    pub fn with(&self, effect: &Effect) -> Result<Self, MachineError> {
        let machine = self.machine.with_effect(effect)?;
        let added = self
            .added
            .iter()
            .copied()
            .chain(self.machine.parameters.len()..machine.parameters.len())
            .collect();
        Ok(Hypothesis {
            kind: HypothesisKind::Effect,
            effects: self.effects.with(&effect.id),
            machine,
            added,
        })
    }

    /// Freezes all parameters except the added ones at the given coordinates.
    pub(super) fn kept_at(mut self, units: &UnitValues) -> Self {
        for (index, (parameter, unit)) in self.machine.parameters.iter_mut().zip(units).enumerate() {
            if !self.added.contains(&index) {
                parameter.start = parameter.from_unit(*unit);
                parameter.fit = FitRule::Never;
            }
        }
        self
    }

    /// Releases a frozen parameter.
    pub fn releasing(&self, parameter: usize) -> Self {
        let mut machine = self.machine.clone();
        machine.parameters[parameter].fit = FitRule::Always;
        let effects = EffectIds::single(&machine.parameters[parameter].id);
        Hypothesis { kind: HypothesisKind::Release, effects, machine, added: vec![parameter] }
    }
}

/// Ids of the amplitudes and names of the parts of generic impedances, which no description uses.
const STIFFNESS: &str = "~k";
const DAMPING: &str = "~c";
const INERTIA: &str = "~m";
const IMPEDANCE_JOINT: &str = "~interface";
const RESONATOR_POINT: &str = "~mass";

fn amplitude(mechanism: Mechanism, range: (f64, f64)) -> Parameter {
    let (id, unit) = match mechanism {
        Mechanism::Damping => (DAMPING, "N*s/m"),
        Mechanism::Inertia => (INERTIA, "kg"),
        _ => (STIFFNESS, "N/m"),
    };
    Parameter {
        id: id.into(),
        unit: unit.into(),
        mechanism,
        role: Role::GenericImpedance,
        start: (range.0 * range.1).sqrt(),
        lower: range.0,
        upper: range.1,
        scale: Scale::Logarithmic,
        fit: FitRule::Always,
        prior: None,
        source: "range that covers the interfaces of feed drives".into(),
        description: String::new(),
    }
}

/// An interface: its name, the points it acts on with coefficients, and whether its motion is a translation
/// or a rotation.
type Across = (String, Vec<(String, f64)>, PointMotion);

/// Returns all generic dynamic stiffnesses at all points of a machine (to ground) and across all of its
/// joints.
pub fn interfaces(nominal: &Hypothesis) -> Vec<Hypothesis> {
    let machine = &nominal.machine;
    let mut all = Vec::new();
    let grounded: Vec<Across> = machine
        .points
        .iter()
        .filter(|p| !p.fixed && matches!(p.role, Role::Described | Role::Effect))
        .map(|p| (p.name.clone(), vec![(p.name.clone(), 1.0)], p.motion))
        .collect();
    let mut across: Vec<Across> = Vec::new();
    for joint in machine.joints.iter().filter(|j| j.on.len() > 1) {
        // Joints that share one motion form one interface across the mean of their motions.
        let coefficients =
            joint.on.iter().map(|(p, c)| (machine.points[*p].name.clone(), c * joint.share.sqrt()));
        match across.iter_mut().find(|(name, _, _)| *name == joint.name) {
            None => across.push((
                joint.name.clone(),
                coefficients.collect(),
                machine.points[joint.on[0].0].motion,
            )),
            Some((_, on, _)) => {
                for (point, coefficient) in coefficients {
                    match on.iter_mut().find(|(known, _)| *known == point) {
                        Some((_, sum)) => *sum += coefficient,
                        None => on.push((point, coefficient)),
                    }
                }
            }
        }
    }
    let scale = typical(machine);
    for (name, on, motion) in grounded.into_iter().chain(across) {
        let (k, c, m) = scale.of(motion);
        let wide = |x: f64| (1e-5 * x, 1e3 * x);
        for shape in [Shape::Stiffness, Shape::Damping, Shape::Mass, Shape::Resonator, Shape::Relaxation] {
            let joint = |stiffness, damping, relaxation_stiffness| JointPatch {
                name: IMPEDANCE_JOINT.into(),
                on: on.clone(),
                stiffness,
                damping,
                relaxation_stiffness,
                ..JointPatch::default()
            };
            let of = |id: &str| NumberSource::Parameter(id.into());
            let zero = NumberSource::Number(0.0);
            let mut patch = Patch::default();
            match shape {
                Shape::Stiffness => {
                    patch.parameters.push(amplitude(Mechanism::Stiffness, wide(k)));
                    patch.joints.push(joint(of(STIFFNESS), zero, None));
                }
                Shape::Damping => {
                    patch.parameters.push(amplitude(Mechanism::Damping, wide(c)));
                    patch.joints.push(joint(zero, of(DAMPING), None));
                }
                Shape::Relaxation => {
                    patch.parameters.extend([
                        amplitude(Mechanism::Damping, wide(c)),
                        amplitude(Mechanism::Stiffness, wide(k)),
                    ]);
                    patch.joints.push(joint(zero, of(DAMPING), Some(of(STIFFNESS))));
                }
                Shape::Mass if on.len() == 1 => {
                    patch.parameters.push(Parameter {
                        start: 1e-9 * m,
                        lower: 1e-12 * m,
                        ..amplitude(Mechanism::Inertia, (1e-4 * m, 1e2 * m))
                    });
                    patch.rescales.push((
                        TargetKind::PointInertia.of(&on[0].0),
                        Rescale::Added,
                        INERTIA.into(),
                    ));
                }
                Shape::Resonator => {
                    patch.parameters.extend([
                        amplitude(Mechanism::Inertia, (1e-4 * m, 1e2 * m)),
                        amplitude(Mechanism::Stiffness, wide(k)),
                        amplitude(Mechanism::Damping, wide(c)),
                    ]);
                    patch.points.push(PointPatch {
                        name: RESONATOR_POINT.into(),
                        motion,
                        inertia: of(INERTIA),
                        fixed: false,
                        role: Role::GenericImpedance,
                    });
                    let mut attached = joint(of(STIFFNESS), of(DAMPING), None);
                    attached.on.push((RESONATOR_POINT.into(), -1.0));
                    patch.joints.push(attached);
                }
                Shape::Mass => continue,
            }
            if let Ok(with) = machine.with(&patch) {
                let added = (machine.parameters.len()..with.parameters.len()).collect();
                let kind = HypothesisKind::Interface { interface: name.clone(), shape };
                all.push(Hypothesis { kind, effects: EffectIds::default(), machine: with, added });
            }
        }
    }
    all
}

/// Typical stiffness, damping and inertia of a machine's translations and rotations: they centre the ranges
/// of generic impedances.
struct TypicalStiffness {
    translation: (f64, f64, f64),
    rotation: (f64, f64, f64),
}

impl TypicalStiffness {
    fn of(&self, motion: PointMotion) -> (f64, f64, f64) {
        match motion {
            PointMotion::Translation => self.translation,
            PointMotion::Rotation => self.rotation,
        }
    }
}

fn typical(machine: &Machine) -> TypicalStiffness {
    let start = machine.start();
    let operating = Operating { nut_m: machine.stroke_m().map(|s| 0.5 * s), ..Default::default() };
    let of = |motion: PointMotion| {
        let joints = machine
            .joints
            .iter()
            .filter(|j| j.on.first().is_some_and(|(p, _)| machine.points[*p].motion == motion));
        let middle = |values: Vec<f64>, usual: f64| {
            quantile(values.into_iter().filter(|x| *x > 0.0), 0.5).unwrap_or(usual)
        };
        let (k, m) = if motion == PointMotion::Translation { (1e8, 100.0) } else { (1e3, 1e-3) };
        let stiffness = middle(joints.map(|j| j.stiffness.at(&start, &operating)).collect(), k);
        let inertia = middle(
            machine
                .points
                .iter()
                .filter(|p| p.motion == motion)
                .map(|p| p.inertia.at(&start, &operating))
                .collect(),
            m,
        );
        // Damping with a loss factor of one near 100 Hz.
        (stiffness, stiffness / 600.0, inertia)
    };
    TypicalStiffness { translation: of(PointMotion::Translation), rotation: of(PointMotion::Rotation) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_dynamic_stiffness_of_each_shape() {
        let all = Amplitudes { stiffness: 4e6, damping: 300.0, inertia: 2.0 };
        let of = |shape: Shape, omega_rad_s: f64| shape.dynamic_stiffness(&all, omega_rad_s);
        let near = |found: Complex64, expected: Complex64| {
            assert!((found / expected - 1.0).norm() < 1e-5, "{found} for {expected}")
        };
        assert_eq!(of(Shape::Mass, 10.0), Complex64::from(-200.0));
        near(of(Shape::Stiffness, 1e-6), Complex64::from(4e6));
        // A resonator moves as a rigid mass at low frequencies, and its spring and damper alone resist at
        // high ones.
        near(of(Shape::Resonator, 1e-3), Complex64::from(-2e-6));
        near(of(Shape::Resonator, 1e9), Complex64::new(4e6, 3e11));
        // A damper in series with a spring damps slow motion and is a spring for fast motion.
        near(of(Shape::Relaxation, 1e-3), Complex64::new(0.0, 0.3));
        near(of(Shape::Relaxation, 1e12), Complex64::from(4e6));
    }
}
