//! Sections of a configuration file and their conversion to a patch of a machine.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::contact::{ContactDefaults, ContactFile, FrictionFile, SegmentFile, contacts, segments};
use super::error::fault;
use super::fitted::FittedFile;
use super::rescale::RescaleFile;
use super::servo::ServoFile;
use super::unit::to_si;
use machine::contact::{Rule, Stiffness};
use machine::{
    AttachFile, BendingFile, Data, DerivedPatch, DriveFile, Effect, FitRule, FrictionForceFile, GROUND,
    JointPatch, LeadErrorFile, LeverFile, MachineError, NumberSource, Parameter, Patch, PointMotion,
    PointPatch, ReattachFile, Role, Scale, ShaftFile, Tolerance,
};
use numeric::unit::travel_per_radian_m;

/// A machine configuration.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineFile {
    /// Title of the machine for display.
    pub title: String,
    /// Name of the built-in measurement set that belongs to the machine, such as `tian`; absent where none
    /// does.
    pub measurements: Option<String>,
    /// Ids of the effects that the machine contains, from the library or from `[[effect]]` of this file.
    #[serde(default)]
    pub effects: Vec<String>,
    /// Stiffness-proportional damping b of every joint, c = b·k (s).
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
    /// Contacts by name, for use as stiffnesses.
    #[serde(default)]
    pub contact: BTreeMap<String, ContactFile>,
    /// Default rule of load sharing of contacts.
    pub contact_rule: Option<Rule>,
    /// Default kind of stiffness of contacts.
    pub contact_stiffness: Option<Stiffness>,
    /// Friction curves by name, which load contacts.
    #[serde(default)]
    pub friction: BTreeMap<String, FrictionFile>,
    /// Screw segments by name, for use as stiffnesses.
    #[serde(default)]
    pub segment: BTreeMap<String, SegmentFile>,
    /// Shafts that bend laterally.
    #[serde(default)]
    pub bending: Vec<BendingFile>,
    /// Parameters by id.
    #[serde(default)]
    pub parameter: BTreeMap<String, ParameterFile>,
    /// User-defined effects.
    #[serde(default)]
    pub effect: Vec<EffectFile>,
    /// Derived quantities to report, by name.
    #[serde(default)]
    pub derived: BTreeMap<String, DerivedPatch>,
    /// Tolerances of stated numbers.
    #[serde(default)]
    pub tolerance: Tolerance,
    /// Tolerances at identified values; only in the file of an identified machine.
    pub fitted: Option<FittedFile>,
}

/// The effect library: a file with effects only.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryFile {
    /// Effects.
    pub effect: Vec<EffectFile>,
}

/// A point.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointFile {
    name: String,
    motion: PointMotion,
    mass_kg: Option<NumberSource>,
    inertia_kg_m2: Option<NumberSource>,
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

/// A joint.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    name: String,
    /// Two points, or a point and `ground`.
    between: Option<[String; 2]>,
    /// Makes it a screw–nut joint: adds −lead/2π times the angle of a point.
    screw: Option<ScrewFile>,
    /// Any combination of points, as an alternative.
    on: Option<BTreeMap<String, f64>>,
    stiffness: Option<NumberSource>,
    damping: Option<NumberSource>,
    /// The loops of a drive that holds a point, in place of stiffness and damping.
    servo: Option<ServoFile>,
    /// η: the stiffness is multiplied by 1 + η·(i + s·2/π·ln(ω/ω₀)), ω₀ = 2π·100 rad/s; s is
    /// `tolerance.loss_dispersion`, 0 constant, 1 causal.
    loss_factor: Option<NumberSource>,
    /// Integral action (1/s) of a holding servo: the stiffness is multiplied by 1 + rate/(iω).
    integral_rate: Option<NumberSource>,
    relaxation_stiffness: Option<NumberSource>,
    friction: Option<FrictionForceFile>,
    /// Width of the dead zone (m or rad).
    gap: Option<NumberSource>,
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
    scale: Option<Scale>,
    #[serde(default)]
    fit: FitRule,
    /// Standard deviation of a normal prior about `start`; none by default.
    sd: Option<f64>,
    /// What is known of it before the measurement, as of a catalogue; nothing by default.
    prior: Option<PriorFile>,
    #[serde(default)]
    source: String,
    /// What it is, in a few words; by default the number of the machine that it stands for.
    #[serde(default)]
    description: String,
}

/// A log-normal prior: the parameter lies within `factor` of `value`, above or below, with a probability of
/// 68 %.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PriorFile {
    /// Median, in the unit of the parameter.
    value: f64,
    /// Factor above 1: exp of the standard deviation of the logarithm.
    factor: f64,
}

/// An effect.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EffectFile {
    /// Id.
    pub id: String,
    #[serde(alias = "says")]
    description: String,
    signature: Option<String>,
    #[serde(alias = "separates")]
    discriminating_test: Option<String>,
    /// Effects from which force and one encoder cannot distinguish it: the difference depends on numbers that
    /// no record contains.
    #[serde(default, alias = "like")]
    confusable_with: Vec<String>,
    /// Effects from which it cannot be distinguished in motion with negligible inertia force.
    #[serde(default, alias = "like_slow")]
    confusable_with_slow: Vec<String>,
    /// Whether most machines show a little of it in motion, so that stronger evidence is required to name it.
    #[serde(default, alias = "ordinary")]
    common: bool,
    /// The effect that it describes in more detail: a verdict names that effect alone.
    refines: Option<String>,
    #[serde(default)]
    needs: Vec<String>,
    /// Location to report where it is not the first part that the effect changes.
    at: Option<String>,
    /// Data in which it can show; FRFs (and modes) by default.
    #[serde(default = "frf_alone")]
    data: Vec<Data>,
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
    #[serde(default)]
    bending: Vec<BendingFile>,
}

fn frf_alone() -> Vec<Data> {
    vec![Data::Frf]
}

/// Returns a point that an effect adds.
fn added_point(file: PointFile) -> Result<PointPatch, MachineError> {
    Ok(PointPatch { role: Role::Effect, ..point(file)? })
}

fn point(file: PointFile) -> Result<PointPatch, MachineError> {
    let motion = file.motion;
    let (right, wrong, wrong_key) = match motion {
        PointMotion::Translation => (file.mass_kg, file.inertia_kg_m2, "inertia_kg_m2"),
        PointMotion::Rotation => (file.inertia_kg_m2, file.mass_kg, "mass_kg"),
    };
    if wrong.is_some() {
        return Err(fault(
            format!("point.{}", file.name),
            format!("a {} has no {wrong_key}; write {}", motion.noun(), motion.inertia_key()),
        ));
    }
    if let Some(NumberSource::Number(0.0)) = right {
        return Err(fault(
            format!("point.{}.{}", file.name, motion.inertia_key()),
            "is 0; leave the key out for a point without inertia",
        ));
    }
    Ok(PointPatch {
        inertia: right.unwrap_or_default(),
        motion,
        fixed: file.boundary == Boundary::Fixed,
        role: Role::Described,
        name: file.name,
    })
}

fn joint(file: JointFile) -> Result<JointPatch, MachineError> {
    let name = file.name;
    let alike = file.between.iter().flatten().filter(|n| *n != GROUND).cloned().collect();
    let mut angles = Vec::new();
    let mut on: Vec<(String, f64)> = match (file.between, file.on) {
        (Some([a, b]), None) if a != b => {
            [(a, 1.0), (b, -1.0)].into_iter().filter(|(n, _)| n != GROUND).collect()
        }
        (Some([a, _]), None) => {
            return Err(fault(
                format!("joint.{name}.between"),
                format!("«{a}» appears twice; name two different points, or one and \"ground\""),
            ));
        }
        (None, Some(on)) => on.into_iter().collect(),
        _ => {
            return Err(fault(
                format!("joint.{name}"),
                "write either between = [\"a\", \"b\"] or on = { a = 1.0, … }",
            ));
        }
    };
    if on.len() == 1 && on[0].1 < 0.0 {
        on[0].1 = 1.0;
    }
    if let Some(screw) = file.screw {
        if !(screw.lead_m.abs() > 0.0 && screw.lead_m.is_finite()) {
            return Err(fault(
                format!("joint.{name}.screw.lead_m"),
                format!("is {}; write the travel per turn in m", screw.lead_m),
            ));
        }
        angles.push(screw.angle.clone());
        on.push((screw.angle, -travel_per_radian_m(screw.lead_m)));
    }
    let (stiffness, damping) = match file.servo {
        None if file.stiffness.is_none() && file.damping.is_none() && file.friction.is_none() => {
            return Err(fault(
                format!("joint.{name}"),
                "has neither stiffness nor damping nor friction; write at least one",
            ));
        }
        None => (file.stiffness.unwrap_or_default(), file.damping.unwrap_or_default()),
        Some(servo) if file.stiffness.is_none() && file.damping.is_none() => {
            servo.stiffness_and_damping(&name)?
        }
        Some(_) => {
            return Err(fault(
                format!("joint.{name}.servo"),
                "defines stiffness and damping; leave those keys out",
            ));
        }
    };
    Ok(JointPatch {
        name,
        on,
        alike,
        angles,
        stiffness,
        damping,
        loss_factor: file.loss_factor.unwrap_or_default(),
        integral_rate: file.integral_rate.unwrap_or_default(),
        relaxation_stiffness: file.relaxation_stiffness,
        friction: file.friction.unwrap_or_default(),
        gap: file.gap.unwrap_or_default(),
        lead_error: file.lead_error.unwrap_or_default(),
    })
}

/// Returns the parameters that a file states, in SI units, with the mechanisms of their uses in the patch.
fn parameters(files: BTreeMap<String, ParameterFile>, uses: &Patch) -> Result<Vec<Parameter>, MachineError> {
    files.into_iter().map(|(id, file)| parameter(id, file, uses)).collect()
}

fn parameter(id: String, file: ParameterFile, uses: &Patch) -> Result<Parameter, MachineError> {
    let catalogue = file.prior.map(|prior| checked_prior(&id, prior, &file)).transpose()?;
    let ParameterFile { unit, start, lower, upper, scale, fit, sd, source, description, .. } = file;
    let (unit, factor) = to_si(&id, &unit, uses)?;
    let scale = scale.unwrap_or(if lower > 0.0 { Scale::Logarithmic } else { Scale::Linear });
    Ok(Parameter {
        mechanism: uses.mechanism_of(&id, &unit),
        role: Role::Described,
        id,
        unit,
        start: factor * start,
        lower: factor * lower,
        upper: factor * upper,
        scale,
        fit,
        prior: match catalogue {
            Some((value, sd)) => Some(machine::Prior::Catalogue(factor * value, sd)),
            None => sd.map(|sd| machine::Prior::Normal(factor * sd)),
        },
        source,
        description,
    })
}

/// Checks a stated prior. Returns its median (in the unit of the file) and the standard deviation of its
/// logarithm.
fn checked_prior(
    id: &str,
    PriorFile { value, factor }: PriorFile,
    of: &ParameterFile,
) -> Result<(f64, f64), MachineError> {
    let refuse = |key: &str, text: String| Err(fault(format!("parameter.{id}.{key}"), text));
    if !(value > 0.0 && value.is_finite()) {
        return refuse("prior.value", format!("is {value}; write a number above 0"));
    }
    if !(factor > 1.0 && factor.is_finite()) {
        let remedy = "write a factor above 1, such as 1.5: the value lies within it with 68 %";
        return refuse("prior.factor", format!("is {factor}; {remedy}"));
    }
    if !(of.lower..=of.upper).contains(&value) {
        let text = format!(
            "{value} is outside the range {} … {}; widen the range or correct it",
            of.lower, of.upper
        );
        return refuse("prior.value", text);
    }
    if !(of.lower > 0.0) {
        let text = format!("a factor needs a range above 0, lower is {}; write lower above 0", of.lower);
        return refuse("prior", text);
    }
    if of.sd.is_some() {
        return refuse("prior", "stands beside sd, another prior; keep one of them".into());
    }
    if of.fit == FitRule::Never {
        return refuse("prior", "has no effect with fit = \"never\"; remove one of them".into());
    }
    Ok((value, factor.ln()))
}

impl MachineFile {
    /// Returns the patch that the file describes, without its effects.
    pub fn patch(self) -> Result<Patch, MachineError> {
        let defaults = ContactDefaults { rule: self.contact_rule, stiffness: self.contact_stiffness };
        let segments = segments(self.segment)?;
        let mut patch = Patch {
            contacts: contacts(self.contact, &self.friction, &segments, defaults)?,
            segments,
            points: self.point.into_iter().map(point).collect::<Result<_, _>>()?,
            shafts: self.shaft.into_iter().map(|s| s.locations().map(|_| s)).collect::<Result<_, _>>()?,
            joints: self.joint.into_iter().map(joint).collect::<Result<_, _>>()?,
            bending: self.bending,
            drive: self.drive,
            derived: self.derived,
            ..Patch::default()
        };
        patch.parameters = parameters(self.parameter, &patch)?;
        Ok(patch)
    }
}

/// Checks a name that arguments, verdicts and documents join with others.
fn check_name(part: &str, name: &str) -> Result<(), MachineError> {
    if !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '-' | '_')) {
        return Ok(());
    }
    Err(fault(part, format!("«{name}» is no name; write letters, digits, - and _")))
}

/// Words of verdicts and of arguments that no effect may have as its id.
const RESERVED: [&str; 8] =
    ["none", "unknown", "measurement", "nominal", "effect", "ambiguous", "wrong-parameter", "insufficient"];

impl EffectFile {
    /// Returns the effect.
    pub fn effect(self) -> Result<Effect, MachineError> {
        let id = self.id.clone();
        let named =
            |error: MachineError| MachineError { part: format!("effect {id}, {}", error.part), ..error };
        check_name("id", &id).map_err(named)?;
        if RESERVED.contains(&id.as_str()) {
            return Err(named(fault("id", format!("«{id}» is a word of verdicts; choose another name"))));
        }
        self.parameter.keys().try_for_each(|key| check_name("parameter", key)).map_err(named)?;
        let mut patch = Patch {
            points: self.point.into_iter().map(added_point).collect::<Result<_, _>>().map_err(named)?,
            joints: self.joint.into_iter().map(joint).collect::<Result<_, _>>().map_err(named)?,
            rescales: self
                .rescale
                .into_iter()
                .map(RescaleFile::rescale)
                .collect::<Result<_, _>>()
                .map_err(named)?,
            reattached: self.reattach,
            attached: self.attach,
            levers: self.lever,
            bending: self.bending,
            ..Patch::default()
        };
        patch.parameters = parameters(self.parameter, &patch).map_err(named)?;
        Ok(Effect {
            patch,
            id: self.id,
            description: self.description,
            signature: self.signature,
            discriminating_test: self.discriminating_test,
            confusable_with: self.confusable_with,
            confusable_with_slow: self.confusable_with_slow,
            common: self.common,
            refines: self.refines,
            needs: self.needs,
            at: self.at,
            data: self.data,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::read_machine_text;
    use machine::Prior;

    /// One mass on one spring with a prior.
    fn read(prior: &str, more: &str) -> Result<Option<Prior>, String> {
        let text = format!(
            "title = \"one\"\neffects = []\n[[point]]\nname = \"m\"\nmotion = \"translation\"\nmass_kg = 2.0\n\
             [[joint]]\nname = \"j\"\nbetween = [\"m\", \"ground\"]\nstiffness = \"k\"\n\
             [parameter.k]\nunit = \"N/um\"\nstart = 3.0\nlower = 1.0\nupper = 9.0\nprior = {prior}\n{more}"
        );
        let read = read_machine_text("one.toml", &text, &[], &[]).map_err(|e| e.to_string())?;
        Ok(read.machine.parameters[0].prior)
    }

    #[test]
    fn limit_a_prior_is_within_its_factor_by_one_standard_deviation() {
        let prior = read("{ value = 2.0, factor = 1.5 }", "").unwrap().unwrap();
        for (value, deviation) in [(2e6, 0.0), (3e6, 1.0), (2e6 / 1.5, -1.0)] {
            assert!((prior.deviation(3e6, value) - deviation).abs() < 1e-12, "{prior:?}");
        }
    }

    #[test]
    fn refuse_priors_that_make_no_sense() {
        for (prior, more, words) in [
            ("{ value = 0.0, factor = 1.5 }", "", ["parameter.k.prior.value", "above 0"]),
            ("{ value = nan, factor = 1.5 }", "", ["parameter.k.prior.value", "NaN"]),
            ("{ value = 2.0, factor = 1.0 }", "", ["parameter.k.prior.factor", "above 1"]),
            ("{ value = 20.0, factor = 1.5 }", "", ["parameter.k.prior.value", "outside the range 1 … 9"]),
            ("{ value = 2.0, factor = 1.5 }", "sd = 1.0", ["parameter.k.prior", "sd"]),
            ("{ value = 2.0, factor = 1.5 }", "fit = \"never\"", ["parameter.k.prior", "never"]),
            ("{ value = 2.0 }", "", ["factor", "one.toml"]),
        ] {
            let fault = read(prior, more).unwrap_err();
            assert!(words.iter().all(|word| fault.contains(word)), "{prior} {more}: {fault}");
        }
    }
}
