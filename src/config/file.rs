//! The words of a configuration file, and what they mean as a patch of a machine.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::contact::{ContactDefaults, ContactFile, FrictionFile, RuleFile, SegmentFile, StiffnessFile, contacts, segments};
use super::motion::{DriveFile, FrictionForceFile, LeadErrorFile};
use super::number::{Number, source};
use super::rescale::RescaleFile;
use super::servo::ServoFile;
use super::tolerance::ToleranceFile;
use machine::{Data, DerivedPatch, Effect, FitRule, JointPatch, Motion, Parameter, Patch, Place, PointPatch, Scale, ShaftPatch, Source};
use numeric::unit::travel_per_radian_m;

/// A machine configuration.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineFile {
    /// What a person calls the machine.
    pub title: String,
    /// Ids of library effects (or of `[[effect]]` of this file) the machine contains.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Damping of every joint as a share of its stiffness (s).
    #[serde(default)]
    pub stiffness_proportional_damping_s: f64,
    /// Points.
    #[serde(default)]
    pub point: Vec<PointFile>,
    /// Shafts.
    #[serde(default)]
    pub shaft: Vec<ShaftFile>,
    /// Joints.
    #[serde(default)]
    pub joint: Vec<JointFile>,
    /// The drive that moves the machine.
    pub drive: Option<DriveFile>,
    /// Contacts by name, to be used as stiffnesses.
    #[serde(default)]
    pub contact: BTreeMap<String, ContactFile>,
    /// How contacts share their load, where they do not say it.
    pub contact_rule: Option<RuleFile>,
    /// Which stiffness of contacts counts, where they do not say it.
    pub contact_stiffness: Option<StiffnessFile>,
    /// Friction curves by name, which load contacts.
    #[serde(default)]
    pub friction: BTreeMap<String, FrictionFile>,
    /// Screw segments by name, to be used as stiffnesses.
    #[serde(default)]
    pub segment: BTreeMap<String, SegmentFile>,
    /// Parameters by id.
    #[serde(default)]
    pub parameter: BTreeMap<String, ParameterFile>,
    /// Effects of the user's own.
    #[serde(default)]
    pub effect: Vec<EffectFile>,
    /// Quantities to be reported, by name.
    #[serde(default)]
    pub derived: BTreeMap<String, DerivedFile>,
    /// How well numbers that are not fitted are known.
    #[serde(default)]
    pub tolerance: ToleranceFile,
}

/// The effect library: nothing but effects.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryFile {
    /// Effects.
    pub effect: Vec<EffectFile>,
}

/// `translation` or `rotation`.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MotionFile {
    /// Displacement (m).
    Translation,
    /// Angle (rad).
    Rotation,
}

/// A point.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    name: String,
    motion: MotionFile,
    mass_kg: Option<Number>,
    inertia_kg_m2: Option<Number>,
    /// `free` (default) or `fixed`.
    #[serde(default)]
    boundary: Boundary,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum Boundary {
    #[default]
    Free,
    Fixed,
}

/// A shaft.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShaftFile {
    name: String,
    length_m: Number,
    diameter_m: Number,
    /// Bore over diameter of a hollow shaft; solid where it is absent.
    bore_ratio: Option<Number>,
    youngs_modulus_pa: Number,
    shear_modulus_pa: Number,
    density_kg_m3: Number,
    loss_factor: Option<Number>,
    station: Vec<StationFile>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct StationFile {
    at: Option<PlaceFile>,
    at_m: Option<f64>,
    axial: Option<String>,
    torsion: Option<String>,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum PlaceFile {
    Start,
    Nut,
    End,
}

/// A joint.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    name: String,
    /// Two points, or a point and `ground`.
    between: Option<[String; 2]>,
    /// Adds −lead/2π times the angle of a point: a screw–nut joint.
    screw: Option<ScrewFile>,
    /// Or any combination of points.
    on: Option<BTreeMap<String, f64>>,
    stiffness: Option<Number>,
    damping: Option<Number>,
    /// Instead of both: the loops of a drive that holds a point.
    servo: Option<ServoFile>,
    loss_factor: Option<Number>,
    /// Integral action of a servo that holds: stiffness times 1 + rate/(iω).
    integral_rate: Option<Number>,
    relaxation_stiffness: Option<Number>,
    friction: Option<FrictionForceFile>,
    /// Width of the dead zone (m or rad).
    gap: Option<Number>,
    lead_error: Option<LeadErrorFile>,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ScrewFile {
    angle: String,
    lead_m: f64,
}

/// A parameter.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ParameterFile {
    unit: String,
    start: f64,
    lower: f64,
    upper: f64,
    #[serde(default)]
    scale: Option<ScaleFile>,
    #[serde(default)]
    fit: FitFile,
    sd: Option<f64>,
    #[serde(default)]
    source: String,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum ScaleFile {
    Logarithmic,
    Linear,
}

#[derive(Debug, Clone, Copy, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum FitFile {
    #[default]
    Always,
    Frf,
    Never,
}

/// An effect.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectFile {
    /// Id.
    pub id: String,
    says: String,
    signature: Option<String>,
    separates: Option<String>,
    /// Effects that force and one encoder do not tell it from, whatever they explain: what they share rests on numbers that no record holds.
    #[serde(default)]
    like: Vec<String>,
    /// Effects that no motion tells it from in which inertia takes next to no force.
    #[serde(default)]
    like_slow: Vec<String>,
    /// Of what it does to motion machines have a little ordinarily: it takes more of it to be named.
    #[serde(default)]
    ordinary: bool,
    #[serde(default)]
    needs: Vec<String>,
    /// Where it sits in a person's eyes, where that is not what it changes first.
    at: Option<String>,
    /// Data it can show in; FRFs (and modes) where it says nothing.
    #[serde(default = "frf_alone")]
    data: Vec<DataFile>,
    #[serde(default)]
    point: Vec<PointFile>,
    #[serde(default)]
    joint: Vec<JointFile>,
    #[serde(default)]
    parameter: BTreeMap<String, ParameterFile>,
    #[serde(default)]
    rescale: Vec<RescaleFile>,
    #[serde(default)]
    reattach: Vec<ReattachFile>,
    #[serde(default)]
    attach: Vec<AttachFile>,
    #[serde(default)]
    lever: Vec<LeverFile>,
}

/// Kinds of data.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
enum DataFile {
    /// FRFs and modes.
    Frf,
    /// Time records.
    Motion,
}

fn frf_alone() -> Vec<DataFile> {
    vec![DataFile::Frf]
}

impl From<DataFile> for Data {
    fn from(file: DataFile) -> Self {
        match file {
            DataFile::Frf => Data::Frf,
            DataFile::Motion => Data::Motion,
        }
    }
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ReattachFile {
    joint: String,
    from: String,
    to: String,
}

#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AttachFile {
    joint: String,
    to: String,
    times: f64,
}

/// An arm on which sensor and hammer sit.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct LeverFile {
    /// The point at which the data are said to be taken.
    at: String,
    /// The point whose motion is felt there, too.
    with: String,
    /// How much of it the sensor feels.
    read: Number,
    /// How much of it the hammer drives.
    struck: Number,
}

/// A quantity to be reported: one of four kinds.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected { natural_frequency = n }, { antiresonance = n, at = \"point\" }, { inertia = [\"a\", \"b\"] } or { parameter = \"id\" }"
)]
pub enum DerivedFile {
    /// n-th undamped natural frequency above 0.
    NaturalFrequency {
        /// n.
        natural_frequency: usize,
    },
    /// n-th antiresonance at a point.
    Antiresonance {
        /// n.
        antiresonance: usize,
        /// The point.
        at: String,
    },
    /// Inertia of one point over that of another.
    InertiaRatio {
        /// The two points.
        inertia: [String; 2],
    },
    /// A parameter.
    Parameter {
        /// Its id.
        parameter: String,
    },
}

impl From<DerivedFile> for DerivedPatch {
    fn from(file: DerivedFile) -> Self {
        match file {
            DerivedFile::NaturalFrequency { natural_frequency } => DerivedPatch::NaturalFrequency(natural_frequency),
            DerivedFile::Antiresonance { antiresonance, at } => DerivedPatch::Antiresonance(antiresonance, at),
            DerivedFile::InertiaRatio { inertia: [a, b] } => DerivedPatch::InertiaRatio(a, b),
            DerivedFile::Parameter { parameter } => DerivedPatch::Parameter(parameter),
        }
    }
}

fn point(file: PointFile) -> Result<PointPatch, String> {
    let motion = match file.motion {
        MotionFile::Translation => Motion::Translation,
        MotionFile::Rotation => Motion::Rotation,
    };
    let (right, wrong, wrong_key) = match motion {
        Motion::Translation => (file.mass_kg, file.inertia_kg_m2, "inertia_kg_m2"),
        Motion::Rotation => (file.inertia_kg_m2, file.mass_kg, "mass_kg"),
    };
    if wrong.is_some() {
        return Err(format!("point.{}: a {} has no {wrong_key}; write {}", file.name, motion.noun(), motion.inertia_key()));
    }
    if let Some(Number::Fixed(0.0)) = right {
        return Err(format!("point.{}.{}: is 0; leave the key out where there is no inertia", file.name, motion.inertia_key()));
    }
    Ok(PointPatch { inertia: source(right), motion, fixed: file.boundary == Boundary::Fixed, name: file.name })
}

fn shaft(file: ShaftFile) -> Result<ShaftPatch, String> {
    let mut stations = Vec::new();
    for station in file.station {
        let place = match (station.at, station.at_m) {
            (Some(PlaceFile::Start), None) => Place::At(0.0),
            (Some(PlaceFile::Nut), None) => Place::Nut,
            (Some(PlaceFile::End), None) => Place::End,
            (None, Some(distance_m)) => Place::At(distance_m),
            _ => return Err(format!("shaft.{}.station: write either at = \"start\", \"nut\" or \"end\", or at_m = a distance", file.name)),
        };
        stations.push((place, station.axial, station.torsion));
    }
    Ok(ShaftPatch {
        name: file.name,
        length: file.length_m.into(),
        diameter: file.diameter_m.into(),
        bore_ratio: source(file.bore_ratio),
        youngs_modulus: file.youngs_modulus_pa.into(),
        shear_modulus: file.shear_modulus_pa.into(),
        density: file.density_kg_m3.into(),
        loss_factor: source(file.loss_factor),
        stations,
    })
}

fn joint(file: JointFile) -> Result<JointPatch, String> {
    let name = file.name;
    let alike = file.between.iter().flatten().filter(|n| *n != "ground").cloned().collect();
    let mut angles = Vec::new();
    let mut on: Vec<(String, f64)> = match (file.between, file.on) {
        (Some([a, b]), None) if a != b => [(a, 1.0), (b, -1.0)].into_iter().filter(|(n, _)| n != "ground").collect(),
        (Some([a, _]), None) => return Err(format!("joint.{name}.between: «{a}» twice; name two different points, or one and \"ground\"")),
        (None, Some(on)) => on.into_iter().collect(),
        _ => return Err(format!("joint.{name}: write either between = [\"a\", \"b\"] or on = {{ a = 1.0, … }}")),
    };
    if on.len() == 1 && on[0].1 < 0.0 {
        on[0].1 = 1.0;
    }
    if let Some(screw) = file.screw {
        if !(screw.lead_m.abs() > 0.0 && screw.lead_m.is_finite()) {
            return Err(format!("joint.{name}.screw.lead_m: is {}; write the travel per turn in m", screw.lead_m));
        }
        angles.push(screw.angle.clone());
        on.push((screw.angle, -travel_per_radian_m(screw.lead_m)));
    }
    let (stiffness, damping) = match file.servo {
        None if file.stiffness.is_none() && file.damping.is_none() && file.friction.is_none() => {
            return Err(format!("joint.{name}: has neither stiffness nor damping nor friction; write at least one"));
        }
        None => (source(file.stiffness), source(file.damping)),
        Some(servo) if file.stiffness.is_none() && file.damping.is_none() => servo.stiffness_and_damping(&name)?,
        Some(_) => return Err(format!("joint.{name}.servo: gives stiffness and damping; leave those out")),
    };
    Ok(JointPatch {
        name,
        on,
        alike,
        angles,
        stiffness,
        damping,
        loss_factor: source(file.loss_factor),
        integral_rate: source(file.integral_rate),
        relaxation_stiffness: file.relaxation_stiffness.map(Source::from),
        friction: file.friction.unwrap_or_default().into(),
        gap: source(file.gap),
        lead_error: file.lead_error.unwrap_or_default().into(),
    })
}

fn parameter((id, file): (String, ParameterFile)) -> Parameter {
    let scale = match file.scale {
        Some(ScaleFile::Logarithmic) => Scale::Logarithmic,
        Some(ScaleFile::Linear) => Scale::Linear,
        None if file.lower > 0.0 => Scale::Logarithmic,
        None => Scale::Linear,
    };
    let fit = match file.fit {
        FitFile::Always => FitRule::Always,
        FitFile::Frf => FitRule::Frf,
        FitFile::Never => FitRule::Never,
    };
    Parameter { id, unit: file.unit, start: file.start, lower: file.lower, upper: file.upper, scale, fit, sd: file.sd, source: file.source }
}

impl MachineFile {
    /// What the file describes, without its effects.
    pub fn patch(self) -> Result<Patch, String> {
        let defaults = ContactDefaults { rule: self.contact_rule, stiffness: self.contact_stiffness };
        Ok(Patch {
            contacts: contacts(self.contact, &self.friction, defaults)?,
            segments: segments(self.segment)?,
            points: self.point.into_iter().map(point).collect::<Result<_, _>>()?,
            shafts: self.shaft.into_iter().map(shaft).collect::<Result<_, _>>()?,
            joints: self.joint.into_iter().map(joint).collect::<Result<_, _>>()?,
            drive: self.drive.map(Into::into),
            parameters: self.parameter.into_iter().map(parameter).collect(),
            rescales: Vec::new(),
            reattached: Vec::new(),
            attached: Vec::new(),
            levers: Vec::new(),
            derived: self.derived.into_iter().map(|(name, d)| (name, d.into())).collect(),
        })
    }
}

impl EffectFile {
    /// The effect.
    pub fn effect(self) -> Result<Effect, String> {
        let id = self.id.clone();
        let named = |fault: String| format!("effect {id}, {fault}");
        Ok(Effect {
            patch: Patch {
                points: self.point.into_iter().map(point).collect::<Result<_, _>>().map_err(named)?,
                joints: self.joint.into_iter().map(joint).collect::<Result<_, _>>().map_err(named)?,
                parameters: self.parameter.into_iter().map(parameter).collect(),
                rescales: self.rescale.into_iter().map(RescaleFile::rescale).collect::<Result<_, _>>().map_err(named)?,
                reattached: self.reattach.into_iter().map(|r| (r.joint, r.from, r.to)).collect(),
                attached: self.attach.into_iter().map(|a| (a.joint, a.to, a.times)).collect(),
                levers: self.lever.into_iter().map(|l| (l.at, l.with, [l.read, l.struck].map(|x| source(Some(x))))).collect(),
                ..Patch::default()
            },
            id: self.id,
            says: self.says,
            signature: self.signature,
            separates: self.separates,
            like: self.like,
            like_slow: self.like_slow,
            ordinary: self.ordinary,
            needs: self.needs,
            at: self.at,
            data: self.data.into_iter().map(Data::from).collect(),
        })
    }
}
