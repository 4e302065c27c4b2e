//! Patches: what a description, or an effect, adds to a machine.
//!
//! A machine's own description is a patch of the empty machine; an effect is a patch of a machine.
//! A patch names points, shafts and joints; [`Machine::with`](super::Machine::with) resolves the names.

use super::{Circumstance, DrivePatch, FrictionPatch, LeadErrorPatch, LoadedPair, Machine, Motion, Parameter, Place, Segment, Target};

/// A number in a patch: fixed, or a parameter by id.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A fixed number.
    Number(f64),
    /// The parameter of that id.
    Parameter(String),
    /// The stiffness of the contact of that name.
    Contact(String),
    /// The stiffness of the screw segment of that name.
    Segment(String),
    /// Springs in series.
    Series(Vec<Source>),
    /// Another one times the parameter of that id.
    Times(Box<Source>, String),
}

impl Source {
    /// What a person calls it.
    pub(super) fn label(&self) -> String {
        match self {
            Source::Number(number) => number.to_string(),
            Source::Parameter(name) | Source::Contact(name) | Source::Segment(name) => name.clone(),
            Source::Series(_) => "series".into(),
            Source::Times(other, _) => other.label(),
        }
    }
}

impl Default for Source {
    fn default() -> Self {
        Source::Number(0.0)
    }
}

/// A point a patch adds.
#[derive(Debug, Clone, PartialEq)]
pub struct PointPatch {
    /// Unique name.
    pub name: String,
    /// Displacement or angle.
    pub motion: Motion,
    /// Mass (kg) or moment of inertia (kg·m²).
    pub inertia: Source,
    /// Held to the ground.
    pub fixed: bool,
}

/// A shaft a patch adds; fields as in [`Shaft`](super::Shaft).
#[derive(Debug, Clone, PartialEq)]
pub struct ShaftPatch {
    /// Unique name.
    pub name: String,
    /// Length (m).
    pub length: Source,
    /// Diameter (m).
    pub diameter: Source,
    /// Bore over diameter.
    pub bore_ratio: Source,
    /// E (Pa).
    pub youngs_modulus: Source,
    /// G (Pa).
    pub shear_modulus: Source,
    /// ρ (kg/m³).
    pub density: Source,
    /// η.
    pub loss_factor: Source,
    /// Place, axial point, torsional point.
    pub stations: Vec<(Place, Option<String>, Option<String>)>,
}

/// A joint a patch adds; fields as in [`Joint`](super::Joint).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JointPatch {
    /// Unique name.
    pub name: String,
    /// Point names and coefficients.
    pub on: Vec<(String, f64)>,
    /// Points that must move alike: all translations, or all rotations.
    pub alike: Vec<String>,
    /// Points that must be angles.
    pub angles: Vec<String>,
    /// k.
    pub stiffness: Source,
    /// c.
    pub damping: Source,
    /// η.
    pub loss_factor: Source,
    /// ω_i.
    pub integral_rate: Source,
    /// Stiffness in series with the damper.
    pub relaxation_stiffness: Option<Source>,
    /// Friction.
    pub friction: FrictionPatch,
    /// Play.
    pub gap: Source,
    /// Error of the lead.
    pub lead_error: LeadErrorPatch,
}

/// How a patch scales a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rescale {
    /// Times 1 + p.
    Relative,
    /// Times exp(p·(2·s − 1)), s = nut position / stroke.
    AlongStroke,
    /// Times exp(p·(1 − (2·s − 1)²)): a hump at mid-stroke.
    MidStroke,
    /// An inertia becomes the stiffness of a beam of that inertia over the shaft's free length left of the nut.
    LeftSpan,
    /// The same right of the nut.
    RightSpan,
    /// Times exp(p·x) with the size x of a circumstance.
    With(Circumstance),
    /// Becomes the parameter itself.
    Replace,
    /// With the parameter as a spring in series: x·p/(x + p).
    InSeries,
    /// Plus the parameter.
    Added,
    /// Less the parameter, which is elsewhere.
    Less,
    /// Times the parameter.
    Times,
}

impl Effect {
    /// Effects of which a kind of data is to be asked: of those with one id, which are for machines described in different words, what is for other data
    /// is left out.
    pub fn asked_of(effects: &[Effect], data: Data) -> impl Iterator<Item = &Effect> {
        let shows = move |e: &Effect| e.data.contains(&data);
        effects.iter().filter(move |e| shows(e) || !effects.iter().any(|other| other.id == e.id && shows(other)))
    }

    /// The effect of an id that a machine was put together with: of those with one id, which are for machines described in different words, the one whose
    /// parameters it has.
    pub fn put_in<'e>(effects: &'e [Effect], id: &str, machine: &Machine) -> Option<&'e Effect> {
        let has = |e: &Effect| e.patch.parameters.iter().all(|p| machine.parameter(&p.id).is_some());
        effects.iter().find(|e| e.id == id && has(e))
    }

    /// Where it sits: points, joints and shafts that it changes, each with the parameter by which, where there is one; else where it adds joints;
    /// «drive» and «measurement» for what is none.
    pub fn places(&self) -> Vec<(String, Option<String>)> {
        if let Some(at) = &self.at {
            return vec![(at.clone(), None)];
        }
        let Patch { points, joints, rescales, reattached, attached, .. } = &self.patch;
        let is_new = |name: &str| points.iter().any(|p| p.name == name) || joints.iter().any(|j| j.name == name);
        let scaled = rescales.iter().map(|(target, _, parameter)| (target.part().to_string(), Some(parameter.clone())));
        let moved = reattached.iter().map(|r| &r.0).chain(attached.iter().map(|a| &a.0)).map(|joint| (joint.clone(), None));
        let on = joints.iter().flat_map(|joint| joint.on.iter().map(|(point, _)| (point.clone(), None)));
        let changed: Vec<_> = scaled.chain(moved).filter(|(name, _)| !is_new(name)).collect();
        if changed.is_empty() { on.filter(|(name, _)| !is_new(name)).collect() } else { changed }
    }

    /// The first of them.
    pub fn place(&self) -> Option<String> {
        self.places().into_iter().next().map(|(place, _)| place)
    }

    /// What must differ between data for the effect to show, where it is a change with the operating condition.
    pub fn circumstance(&self) -> Option<Circumstance> {
        self.patch.rescales.iter().find_map(|(_, rescale, _)| match rescale {
            Rescale::With(circumstance) => Some(*circumstance),
            _ => None,
        })
    }
}

/// What a description, or an effect, adds to a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// Points it adds.
    pub points: Vec<PointPatch>,
    /// Shafts it adds.
    pub shafts: Vec<ShaftPatch>,
    /// Joints it adds.
    pub joints: Vec<JointPatch>,
    /// The drive, where it describes one.
    pub drive: Option<DrivePatch>,
    /// Contacts it describes, to be used as stiffnesses.
    pub contacts: Vec<LoadedPair>,
    /// Screw segments it describes, to be used as stiffnesses.
    pub segments: Vec<Segment>,
    /// Parameters it adds. One that the machine has already (by id) is kept as the machine has it.
    pub parameters: Vec<Parameter>,
    /// Numbers it scales: which, how, by which parameter.
    pub rescales: Vec<(Target, Rescale, String)>,
    /// Joints that act on one point (or the ground) and from now on act on another: joint, from, to.
    pub reattached: Vec<(String, String, String)>,
    /// Points that joints act on from now on, too: joint, point, coefficient.
    pub attached: Vec<(String, String, f64)>,
    /// Arms on which sensor and hammer sit: point, the one whose motion is felt there, too, and how much by either.
    pub levers: Vec<(String, String, [Source; 2])>,
    /// Quantities to be reported: name and how they follow.
    pub derived: Vec<(String, DerivedPatch)>,
}

/// Kinds of data that an effect can show in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Data {
    /// FRFs and modes.
    Frf,
    /// Time records of a driven axis.
    Motion,
}

/// An effect: a named patch and what a person should know of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Effect {
    /// Id, for example `rotor-hold`.
    pub id: String,
    /// One sentence for the user.
    pub says: String,
    /// What it looks like in measurements, where that was written down.
    pub signature: Option<String>,
    /// The measurement that tells it from its look-alikes, where that was written down.
    pub separates: Option<String>,
    /// Effects (ids) that force and one encoder do not tell it from.
    pub like: Vec<String>,
    /// Effects (ids) that no motion tells it from in which inertia takes next to no force.
    pub like_slow: Vec<String>,
    /// Of what it does to motion machines have a little ordinarily: it takes more of it to be named.
    pub ordinary: bool,
    /// The points, joints or shafts a machine must have for it to apply, by name; «drive» stands for its drive.
    pub needs: Vec<String>,
    /// Where it sits in a person's eyes, where that is not what it changes first.
    pub at: Option<String>,
    /// Data it can show in.
    pub data: Vec<Data>,
    /// What it adds.
    pub patch: Patch,
}

/// How a quantity follows; as [`Derivation`](super::Derivation), with names.
#[derive(Debug, Clone, PartialEq)]
pub enum DerivedPatch {
    /// n-th natural frequency.
    NaturalFrequency(usize),
    /// n-th antiresonance at a point.
    Antiresonance(usize, String),
    /// Inertia of one point over that of another.
    InertiaRatio(String, String),
    /// A parameter.
    Parameter(String),
}
