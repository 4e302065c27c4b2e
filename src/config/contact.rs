//! Configuration sections of contacts, screw segments and friction curves.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::fault;
use machine::contact::{
    BALL_PRESSURE_LIMIT_PA, Balls, BearingData, ContactError, LoadedBalls, NutData, PreloadedPair, Printed,
    Rule, Side, Stiffness, StribeckCurve,
};
use machine::{LoadedPair, MachineError, ScrewEnd, Segment, SegmentEnd, Twist};

/// A friction curve: Duan et al., Eq. 11.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionFile {
    coulomb_n: f64,
    static_n: f64,
    viscous_n_s_per_m: f64,
    stribeck_velocity_m_s: f64,
}

/// A preloaded pair, described by its catalogue quantities.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactFile {
    kind: KindFile,
    preload_n: f64,
    rule: Option<Rule>,
    stiffness: Option<Stiffness>,
    printed: Option<Printed>,
    weight: Option<f64>,
    lead_m: Option<f64>,
    pitch_diameter_m: Option<f64>,
    ball_diameter_m: Option<f64>,
    contact_angle_deg: Option<f64>,
    /// Of both races with one number; with two, of screw and nut, or of inner and outer ring.
    conformity: Option<ConformityFile>,
    ball_count: Option<f64>,
    loaded_turns: Option<f64>,
    /// Bearings in tandem on side A and on side B.
    tandem: Option<[usize; 2]>,
    pressure_limit_pa: Option<f64>,
    /// A known point of one side, as an alternative to its geometry.
    load_n: Option<f64>,
    deflection_m: Option<f64>,
    friction: Option<String>,
    #[serde(default)]
    moved_mass_kg: f64,
    #[serde(default)]
    gravity_m_s2: f64,
    share: Option<f64>,
    /// Segment of the screw between the nut and this contact, where contacts at both ends of the screw carry
    /// the force: they then share it by compatibility. As printed they take `share`.
    segment: Option<String>,
    outside_share: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum KindFile {
    DoubleNut,
    BearingPair,
    KnownPair,
}

impl KindFile {
    fn word(self) -> &'static str {
        match self {
            KindFile::DoubleNut => "double-nut",
            KindFile::BearingPair => "bearing-pair",
            KindFile::KnownPair => "known-pair",
        }
    }
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected one conformity, or two in square brackets")]
enum ConformityFile {
    Both(f64),
    Each([f64; 2]),
}

/// A screw segment between an end and the nut.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentFile {
    diameter_m: f64,
    youngs_modulus_pa: f64,
    length_m: f64,
    #[serde(default)]
    from: SegmentEnd,
    twist: Option<TwistFile>,
}

#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct TwistFile {
    shear_modulus_pa: f64,
    lead_m: f64,
}

/// Defaults for contacts of a file.
#[derive(Debug, Clone, Copy)]
pub struct ContactDefaults {
    /// `contact_rule` of the file.
    pub rule: Option<Rule>,
    /// `contact_stiffness` of the file.
    pub stiffness: Option<Stiffness>,
}

/// Converts the segments of a file.
pub fn segments(files: BTreeMap<String, SegmentFile>) -> Result<Vec<Segment>, MachineError> {
    let lengths: Vec<(&String, f64)> = files.iter().map(|(name, file)| (name, file.length_m)).collect();
    if let Some(pair) = lengths.windows(2).find(|pair| pair[0].1 != pair[1].1) {
        let ((a, length_a), (b, length_b)) = (pair[0], pair[1]);
        return Err(fault(
            format!("segment.{b}.length_m"),
            format!(
                "is {length_b}, that of «{a}» is {length_a}; one nut position needs screws of equal length"
            ),
        ));
    }
    let twist = |t: TwistFile| Twist { shear_modulus_pa: t.shear_modulus_pa, lead_m: t.lead_m };
    let segment = |(name, file): (String, SegmentFile)| {
        let SegmentFile { diameter_m, youngs_modulus_pa, length_m, from, .. } = file;
        Segment { name, diameter_m, youngs_modulus_pa, length_m, from, twist: file.twist.map(twist) }
    };
    Ok(files.into_iter().map(segment).collect())
}

/// Converts the contacts of a file.
pub fn contacts(
    files: BTreeMap<String, ContactFile>,
    curves: &BTreeMap<String, FrictionFile>,
    segments: &[Segment],
    defaults: ContactDefaults,
) -> Result<Vec<LoadedPair>, MachineError> {
    let ends: Vec<(String, String)> =
        files.iter().filter_map(|(name, file)| Some((name.clone(), file.segment.clone()?))).collect();
    let mut contacts = files
        .into_iter()
        .map(|(name, file)| contact(name, &file, curves, defaults))
        .collect::<Result<Vec<_>, _>>()?;
    join_ends(&mut contacts, &ends, segments)?;
    Ok(contacts)
}

/// Lets the contacts that name a segment share the force on the nut: two, one at each end of the screw.
fn join_ends(
    contacts: &mut [LoadedPair],
    ends: &[(String, String)],
    segments: &[Segment],
) -> Result<(), MachineError> {
    let Some((name, _)) = ends.first() else { return Ok(()) };
    let key = |name: &String, key: &str| format!("contact.{name}.{key}");
    let [first, second] = ends else {
        let fault_text = format!(
            "a screw has two ends that share a force; {} contacts name a segment, write it for two",
            ends.len()
        );
        return Err(fault(key(name, "segment"), fault_text));
    };
    let find = |(name, segment): &(String, String)| {
        let at = contacts.iter().position(|c| c.name == *name);
        let known = || segments.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join(", ");
        let found = segments.iter().find(|s| s.name == *segment);
        let absent = || {
            fault(key(name, "segment"), format!("no segment is called «{segment}»; there are: {}", known()))
        };
        found.cloned().zip(at).ok_or_else(absent)
    };
    let ((first_segment, a), (second_segment, b)) = (find(first)?, find(second)?);
    if first_segment.from == second_segment.from {
        let fault_text = format!(
            "«{}» and «{}» begin at the same end of the screw; name the segments of both ends",
            first.1, second.1
        );
        return Err(fault(key(&second.0, "segment"), fault_text));
    }
    let (one, other) = (&contacts[a], &contacts[b]);
    let same = [
        ("rule", one.rule == other.rule),
        ("friction", one.friction == other.friction),
        ("moved_mass_kg", one.moved_mass_kg == other.moved_mass_kg),
        ("gravity_m_s2", one.gravity_m_s2 == other.gravity_m_s2),
        ("outside_share", one.outside_share == other.outside_share),
    ];
    if let Some((differs, _)) = same.iter().find(|(_, same)| !same) {
        let fault_text = format!(
            "differs from that of contact.{}, with which it shares one force; write the same",
            one.name
        );
        return Err(fault(key(&second.0, differs), fault_text));
    }
    let ends = [
        ScrewEnd {
            segment: first_segment.clone(),
            other_pair: other.pair,
            other_segment: second_segment.clone(),
        },
        ScrewEnd { segment: second_segment, other_pair: one.pair, other_segment: first_segment },
    ];
    for (at, end) in [a, b].into_iter().zip(ends) {
        contacts[at].end = Some(Arc::new(end));
    }
    Ok(())
}

fn contact(
    name: String,
    file: &ContactFile,
    curves: &BTreeMap<String, FrictionFile>,
    defaults: ContactDefaults,
) -> Result<LoadedPair, MachineError> {
    let pair = pair(&name, file)?;
    let friction = match &file.friction {
        None => None,
        Some(curve) => {
            let found = curves.get(curve).ok_or_else(|| {
                let known: Vec<&str> = curves.keys().map(String::as_str).collect();
                let known = if known.is_empty() {
                    "there are none".to_string()
                } else {
                    format!("there are {}", known.join(", "))
                };
                let remedy = format!(
                    "no friction curve is called «{curve}»; {known}. Describe it as [friction.{curve}]"
                );
                fault(format!("contact.{name}.friction"), remedy)
            })?;
            Some(StribeckCurve {
                coulomb_n: found.coulomb_n,
                static_n: found.static_n,
                viscous_n_s_per_m: found.viscous_n_s_per_m,
                stribeck_velocity_m_per_s: found.stribeck_velocity_m_s,
            })
        }
    };
    Ok(LoadedPair {
        pair,
        rule: file.rule.or(defaults.rule).unwrap_or(Rule::Physics),
        stiffness: file.stiffness.or(defaults.stiffness).unwrap_or(Stiffness::Tangent),
        weight: file.weight.unwrap_or(1.0),
        friction,
        moved_mass_kg: file.moved_mass_kg,
        gravity_m_s2: file.gravity_m_s2,
        share: file.share.unwrap_or(1.0),
        end: None,
        outside_share: file.outside_share.unwrap_or(1.0),
        name,
    })
}

fn pair(name: &str, file: &ContactFile) -> Result<PreloadedPair, MachineError> {
    use KindFile::{BearingPair, DoubleNut, KnownPair};
    let kind = file.kind;
    let in_contact = |text: String| fault(format!("contact.{name}"), text);
    let at_key = |key: &str, text: String| fault(format!("contact.{name}.{key}"), text);
    let need = |key: &str, value: Option<f64>| {
        value.ok_or_else(|| in_contact(format!("a {} needs {key}; write it", kind.word())))
    };
    let of_contact = |e: ContactError| in_contact(e.to_string());
    // A key that this kind does not use points to a misunderstanding.
    let unused: [(&str, bool, &[KindFile]); 11] = [
        ("lead_m", file.lead_m.is_some(), &[BearingPair, KnownPair]),
        ("ball_diameter_m", file.ball_diameter_m.is_some(), &[KnownPair]),
        ("pitch_diameter_m", file.pitch_diameter_m.is_some(), &[KnownPair]),
        ("contact_angle_deg", file.contact_angle_deg.is_some(), &[KnownPair]),
        ("conformity", file.conformity.is_some(), &[KnownPair]),
        ("ball_count", file.ball_count.is_some(), &[KnownPair]),
        ("loaded_turns", file.loaded_turns.is_some(), &[BearingPair, KnownPair]),
        ("pressure_limit_pa", file.pressure_limit_pa.is_some(), &[KnownPair]),
        ("tandem", file.tandem.is_some(), &[DoubleNut]),
        ("load_n", file.load_n.is_some(), &[DoubleNut, BearingPair]),
        ("deflection_m", file.deflection_m.is_some(), &[DoubleNut, BearingPair]),
    ];
    if let Some((key, ..)) = unused.iter().find(|(_, there, kinds)| *there && kinds.contains(&kind)) {
        return Err(at_key(key, format!("a {} does not use this key; remove it", kind.word())));
    }
    let conformity = match file.conformity {
        Some(ConformityFile::Both(f)) => Ok([f, f]),
        Some(ConformityFile::Each(f)) => Ok(f),
        None => Err(in_contact(format!(
            "a {} needs conformity; write the groove radius over the ball diameter",
            kind.word()
        ))),
    };
    let pressure_limit_pa = file.pressure_limit_pa.unwrap_or(BALL_PRESSURE_LIMIT_PA);
    if !(pressure_limit_pa > 0.0) {
        return Err(at_key("pressure_limit_pa", format!("is {pressure_limit_pa}; write a pressure above 0")));
    }
    let converted = match kind {
        DoubleNut => {
            let balls = match (file.ball_count, file.loaded_turns) {
                (Some(count), None) => Balls::Count(count),
                (None, Some(turns)) => Balls::Turns(turns),
                _ => {
                    return Err(in_contact(
                        "a double-nut needs either ball_count or loaded_turns; write one of them".into(),
                    ));
                }
            };
            let [screw, nut] = conformity?;
            let steel = NutData::steel(
                need("lead_m", file.lead_m)?,
                need("pitch_diameter_m", file.pitch_diameter_m)?,
                need("ball_diameter_m", file.ball_diameter_m)?,
                need("contact_angle_deg", file.contact_angle_deg)?.to_radians(),
                screw,
                balls,
            );
            let nut = LoadedBalls::of_nut(&NutData { nut_conformity: nut, pressure_limit_pa, ..steel })
                .map_err(of_contact)?;
            PreloadedPair::double_nut(nut.side(), file.preload_n)
        }
        BearingPair => {
            let count = need("ball_count", file.ball_count)?;
            if !(count >= 1.0 && count.fract() == 0.0) {
                return Err(at_key("ball_count", format!("is {count}; write a whole number from 1")));
            }
            let [inner, outer] = conformity?;
            let steel = BearingData::steel(
                count as usize,
                need("ball_diameter_m", file.ball_diameter_m)?,
                need("pitch_diameter_m", file.pitch_diameter_m)?,
                need("contact_angle_deg", file.contact_angle_deg)?.to_radians(),
                inner,
            );
            let bearing =
                LoadedBalls::of_bearing(&BearingData { outer_conformity: outer, pressure_limit_pa, ..steel })
                    .map_err(of_contact)?;
            let [a, b] = file.tandem.unwrap_or([1, 1]);
            PreloadedPair::bearing_set(bearing.side(), a, b, file.preload_n)
        }
        KnownPair => {
            let side =
                Side::from_point(need("load_n", file.load_n)?, need("deflection_m", file.deflection_m)?)
                    .map_err(of_contact)?;
            PreloadedPair::double_nut(side, file.preload_n)
        }
    }
    .map_err(of_contact)?;
    Ok(file.printed.map_or(converted, |printed| converted.printed(printed)))
}
