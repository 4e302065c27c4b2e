//! Hypotheses about what a machine's description lacks: each is one patched machine.

use machine::{
    Data, Effect, FitRule, JointPatch, Machine, MachineError, NumberSource, Operating, Parameter, Patch, PointMotion, PointPatch, Rescale,
    Scale, Target, UnitValues,
};
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
}

/// A machine with an addition.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// Id of the effect, of the parameter released, or `interface:shape`.
    pub id: String,
    /// Kind of the addition.
    pub kind: HypothesisKind,
    /// The machine with the addition.
    pub machine: Machine,
    /// Indices of the added parameters.
    pub added: Vec<usize>,
}

impl Hypothesis {
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
        let held = move |p: &Parameter| (frozen.contains(&p.id) || p.fit == FitRule::Never) && !but.contains(&p.id);
        machine.parameters.iter().enumerate().filter(move |(_, p)| held(p)).map(|(index, _)| self.releasing(index))
    }

    /// Returns the hypothesis without an addition.
    pub fn nominal(machine: Machine) -> Self {
        Hypothesis { id: "nominal".into(), kind: HypothesisKind::Nominal, machine, added: Vec::new() }
    }

    /// Adds an effect.
    ///
    /// # Errors  as [`Machine::with_effect`]: the effect does not apply.
    pub fn with(&self, effect: &Effect) -> Result<Self, MachineError> {
        let machine = self.machine.with_effect(effect)?;
        let id = if self.kind == HypothesisKind::Nominal { effect.id.clone() } else { format!("{}+{}", self.id, effect.id) };
        let added = self.added.iter().copied().chain(self.machine.parameters.len()..machine.parameters.len()).collect();
        Ok(Hypothesis { id, kind: HypothesisKind::Effect, machine, added })
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
        Hypothesis { id: machine.parameters[parameter].id.clone(), kind: HypothesisKind::Release, machine, added: vec![parameter] }
    }
}

fn amplitude(id: &str, unit: &str, range: (f64, f64)) -> Parameter {
    Parameter {
        id: id.into(),
        unit: unit.into(),
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

/// An interface: its name, the points it acts on with coefficients, and whether its motion is a translation or a rotation.
type Across = (String, Vec<(String, f64)>, PointMotion);

/// Returns all generic dynamic stiffnesses at all points of a machine (to ground) and across all of its joints.
pub fn interfaces(nominal: &Hypothesis) -> Vec<Hypothesis> {
    let machine = &nominal.machine;
    let mut all = Vec::new();
    let grounded: Vec<Across> = machine
        .points
        .iter()
        .filter(|p| !p.fixed && !p.name.starts_with('~'))
        .map(|p| (p.name.clone(), vec![(p.name.clone(), 1.0)], p.motion))
        .collect();
    let mut across: Vec<Across> = Vec::new();
    for joint in machine.joints.iter().filter(|j| j.on.len() > 1) {
        // Joints that share one motion form one interface across the mean of their motions.
        let coefficients = joint.on.iter().map(|(p, c)| (machine.points[*p].name.clone(), c * joint.share.sqrt()));
        match across.iter_mut().find(|(name, _, _)| *name == joint.name) {
            None => across.push((joint.name.clone(), coefficients.collect(), machine.points[joint.on[0].0].motion)),
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
                name: "~interface".into(),
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
                    patch.parameters.push(amplitude("~k", "N/m", wide(k)));
                    patch.joints.push(joint(of("~k"), zero, None));
                }
                Shape::Damping => {
                    patch.parameters.push(amplitude("~c", "N*s/m", wide(c)));
                    patch.joints.push(joint(zero, of("~c"), None));
                }
                Shape::Relaxation => {
                    patch.parameters.extend([amplitude("~c", "N*s/m", wide(c)), amplitude("~k", "N/m", wide(k))]);
                    patch.joints.push(joint(zero, of("~c"), Some(of("~k"))));
                }
                Shape::Mass if on.len() == 1 => {
                    patch.parameters.push(Parameter { start: 1e-9 * m, lower: 1e-12 * m, ..amplitude("~m", "kg", (1e-4 * m, 1e2 * m)) });
                    patch.rescales.push((Target::PointInertia(on[0].0.clone()), Rescale::Added, "~m".into()));
                }
                Shape::Resonator => {
                    patch.parameters.extend([
                        amplitude("~m", "kg", (1e-4 * m, 1e2 * m)),
                        amplitude("~k", "N/m", wide(k)),
                        amplitude("~c", "N*s/m", wide(c)),
                    ]);
                    patch.points.push(PointPatch { name: "~mass".into(), motion, inertia: of("~m"), fixed: false });
                    let mut attached = joint(of("~k"), of("~c"), None);
                    attached.on.push(("~mass".into(), -1.0));
                    patch.joints.push(attached);
                }
                Shape::Mass => continue,
            }
            if let Ok(with) = machine.with(&patch) {
                let added = (machine.parameters.len()..with.parameters.len()).collect();
                let id = format!("{name}:{}", shape.word());
                all.push(Hypothesis { id, kind: HypothesisKind::Interface { interface: name.clone(), shape }, machine: with, added });
            }
        }
    }
    all
}

/// Typical stiffness, damping and inertia of a machine's translations and rotations: they centre the ranges of generic impedances.
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
        let joints = machine.joints.iter().filter(|j| j.on.first().is_some_and(|(p, _)| machine.points[*p].motion == motion));
        let middle = |values: Vec<f64>, usual: f64| quantile(values.into_iter().filter(|x| *x > 0.0), 0.5).unwrap_or(usual);
        let (k, m) = if motion == PointMotion::Translation { (1e8, 100.0) } else { (1e3, 1e-3) };
        let stiffness = middle(joints.map(|j| j.stiffness.at(&start, &operating)).collect(), k);
        let inertia = middle(machine.points.iter().filter(|p| p.motion == motion).map(|p| p.inertia.at(&start, &operating)).collect(), m);
        // Damping with a loss factor of one near 100 Hz.
        (stiffness, stiffness / 600.0, inertia)
    };
    TypicalStiffness { translation: of(PointMotion::Translation), rotation: of(PointMotion::Rotation) }
}
