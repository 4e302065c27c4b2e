//! Quantity and factor of a universal record, from the codes and units of its axes and from dataset 164.

use numeric::unit::{Unit, parse};

use super::unit::{Fault, Measures, measures, of_frf, to_hz};
use crate::{MeasurementError, Quantity};
use universal_files::{RecordAxis, RecordHeader, Units, data_type};

/// Relative difference of two factors that counts as a contradiction (1).
const CONTRADICTION: f64 = 2e-3;

/// Function H of a record: SI value = value · factor, or factor / value where `inverted`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ordinates {
    pub quantity: Quantity,
    pub factor: f64,
    /// Whether the record holds force over motion.
    pub inverted: bool,
    pub by_torque: bool,
}

/// Meaning of an axis by its code.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Code {
    Open,
    Motion(Quantity),
    Force,
    Other(i64),
}

fn code(axis: &RecordAxis) -> Code {
    match axis.data_type {
        data_type::UNKNOWN | data_type::GENERAL => Code::Open,
        data_type::DISPLACEMENT => Code::Motion(Quantity::Receptance),
        data_type::VELOCITY => Code::Motion(Quantity::Mobility),
        data_type::ACCELERATION => Code::Motion(Quantity::Accelerance),
        data_type::EXCITATION_FORCE | data_type::REACTION_FORCE => Code::Force,
        other => Code::Other(other),
    }
}

/// Returns the motion that a quantity has above its fraction line.
fn motion(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Receptance => "displacement",
        Quantity::Mobility => "velocity",
        Quantity::Accelerance => "acceleration",
    }
}

/// An axis of the ordinate with its unit.
struct Axis<'r> {
    label: Option<&'r str>,
    unit: Option<Unit>,
    code: Code,
}

impl<'r> Axis<'r> {
    /// Parses the unit. An unknown one is refused, unless dataset 164 states the units anyway.
    fn of(
        axis: &'r RecordAxis,
        role: &str,
        has_factors: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Fault> {
        let unit = match axis.unit().map(of_frf) {
            None => None,
            Some(Ok(unit)) => Some(unit),
            Some(Err(fault)) if has_factors => {
                warnings.push(format!("{role}: {fault}; the factors of dataset 164 are used"));
                None
            }
            Some(Err(fault)) => {
                return Err(format!("{role}: {fault}; correct it, or state the units in dataset 164"));
            }
        };
        Ok(Axis { label: axis.unit(), unit, code: code(axis) })
    }

    fn measures(&self) -> Option<Measures> {
        self.unit.filter(|unit| *unit != Unit::ONE).map(measures)
    }

    fn unit_name(&self) -> String {
        self.unit.map_or_else(String::new, |unit| unit.dimension.name())
    }

    fn text(&self) -> &str {
        self.label.unwrap_or("")
    }
}

/// Warns where the label of an axis names another quantity than its code.
fn label_against_code(axis: &RecordAxis, role: &str, warnings: &mut Vec<String>) {
    let label = axis.label.to_lowercase();
    let words = [
        ("acceleration", data_type::ACCELERATION),
        ("velocity", data_type::VELOCITY),
        ("displacement", data_type::DISPLACEMENT),
        ("force", data_type::EXCITATION_FORCE),
        ("frequency", data_type::FREQUENCY),
        ("time", data_type::TIME),
    ];
    let named: Vec<i64> =
        words.iter().filter(|(word, _)| label.contains(word)).map(|(_, code)| *code).collect();
    let stated = if axis.data_type == data_type::REACTION_FORCE {
        data_type::EXCITATION_FORCE
    } else {
        axis.data_type
    };
    if let ([named], Some((word, _))) = (named.as_slice(), words.iter().find(|(_, code)| *code == stated))
        && *named != stated
    {
        warnings.push(format!(
            "{role}: the label «{}» contradicts the code {} ({word}); the code is used",
            axis.label.trim(),
            axis.data_type
        ));
    }
}

/// Returns the factor from the abscissa to Hz.
pub(super) fn abscissa_to_hz(
    source: &str,
    name: &str,
    axis: &RecordAxis,
    warnings: &mut Vec<String>,
) -> Result<f64, MeasurementError> {
    let refuse = |text: String| MeasurementError::record(source, name, text);
    let is_time = axis.unit().is_none() && axis.label.to_lowercase().contains("time");
    let kind = match axis.data_type {
        data_type::UNKNOWN | data_type::GENERAL if is_time => Some("a time".to_string()),
        data_type::UNKNOWN | data_type::GENERAL | data_type::FREQUENCY => None,
        data_type::TIME => Some("a time".to_string()),
        data_type::ROTATIONAL_SPEED => None,
        data_type::ORDER => Some("an order".into()),
        other => Some(format!("of code {other}")),
    };
    if let Some(kind) = kind {
        let unit = axis.unit().map_or_else(|| "without unit".into(), |unit| format!("in «{unit}»"));
        return Err(refuse(format!(
            "the abscissa is {kind} ({unit}), not a frequency (code 18); export the FRF over frequency"
        )));
    }
    let mut own = Vec::new();
    label_against_code(axis, "abscissa", &mut own);
    warnings.extend(own.into_iter().map(|text| format!("{name}: {text}")));
    match axis.unit() {
        Some(unit) => {
            to_hz(unit).map_err(|fault| refuse(format!("abscissa: {fault}; write Hz, kHz, rad/s or rpm")))
        }
        None if axis.data_type == data_type::ROTATIONAL_SPEED => {
            warnings.push(format!("{name}: the abscissa is a rotational speed without unit; taken in rpm"));
            Ok(1.0 / 60.0)
        }
        None => Ok(1.0),
    }
}

/// Returns quantity and factor of a record.
///
/// # Errors  the record is no motion over force; its quantity is not stated; a unit is unknown or contradicts
///   its code.
pub(super) fn ordinates(
    source: &str,
    name: &str,
    header: &RecordHeader,
    requested: Option<Quantity>,
    warnings: &mut Vec<String>,
) -> Result<Ordinates, MeasurementError> {
    let mut own = Vec::new();
    let found = of_header(header, requested, &mut own);
    warnings.extend(own.into_iter().map(|text| format!("{name}: {text}")));
    found.map_err(|text| MeasurementError::record(source, name, text))
}

fn of_header(
    header: &RecordHeader,
    requested: Option<Quantity>,
    warnings: &mut Vec<String>,
) -> Result<Ordinates, Fault> {
    let has_factors = header.units.is_some();
    let upper = Axis::of(&header.ordinate, "ordinate", has_factors, warnings)?;
    let lower = Axis::of(&header.denominator, "denominator", has_factors, warnings)?;
    label_against_code(&header.ordinate, "ordinate", warnings);
    label_against_code(&header.denominator, "denominator", warnings);
    for (axis, role) in [(&upper, "ordinate"), (&lower, "denominator")] {
        code_against_unit(axis, role)?;
        if let Code::Other(code) = axis.code {
            return Err(format!(
                "{role}: code {code} is neither motion nor force; an FRF here is motion over force"
            ));
        }
    }
    if let Some(Measures::Ratio(quantity, by_torque) | Measures::Inverse(quantity, by_torque)) =
        upper.measures()
    {
        let inverted = matches!(upper.measures(), Some(Measures::Inverse(..)));
        return of_ratio(&upper, &lower, (quantity, by_torque, inverted), header, requested, warnings);
    }
    let is_force = |axis: &Axis<'_>| {
        axis.code == Code::Force || matches!(axis.measures(), Some(Measures::Force | Measures::Torque))
    };
    let is_motion = |axis: &Axis<'_>| {
        matches!(axis.code, Code::Motion(_)) || matches!(axis.measures(), Some(Measures::Motion(_)))
    };
    match (is_force(&upper), is_force(&lower)) {
        (true, true) => return Err("the record is force over force; an FRF here is motion over force".into()),
        (true, false) if !is_motion(&lower) => {
            return Err(
                "the record is force over an unknown quantity; state code or unit of the denominator".into(),
            );
        }
        (false, _) if is_motion(&lower) && is_motion(&upper) => {
            return Err("the record is motion over motion, a transmissibility without force; export motion over force".into());
        }
        (false, _) if is_motion(&lower) => {
            return Err("the denominator is a motion, not a force; export motion over force".into());
        }
        _ => {}
    }
    let inverted = is_force(&upper);
    let (moving, forcing) = if inverted { (&lower, &upper) } else { (&upper, &lower) };
    let (moving_direction, forcing_direction) = directions(header, inverted);
    if !is_force(forcing) {
        let unit = forcing.label.map_or_else(String::new, |unit| format!(" («{unit}»)"));
        warnings.push(format!(
            "neither code nor unit{unit} identifies the reference as a force; taken as a force in N"
        ));
    }
    let quantity = quantity_of(moving, requested, warnings)?;
    let by_torque = matches!(forcing.measures(), Some(Measures::Torque))
        || (forcing.unit.is_none() && forcing_direction.abs() > 3);
    let own = |axis: &Axis<'_>| axis.measures().and(axis.unit).map(Unit::to_si);
    let (own_motion, own_force) = (own(moving), own(forcing));
    let factor = match &header.units {
        None => {
            let missing = [("the response", own_motion), ("the force", own_force)];
            for (what, _) in missing.iter().filter(|(_, unit)| unit.is_none()) {
                warnings.push(format!("no dataset 164 and no unit for {what}; taken as SI"));
            }
            own_motion.unwrap_or(1.0) / own_force.unwrap_or(1.0)
        }
        Some(units) => {
            let angular = moving.unit.map_or(moving_direction.abs() > 3, |unit| unit.angle != 0);
            let motion = if angular { 1.0 } else { units.length_m(1.0) };
            let force = units.force_n(1.0) * if by_torque { units.length_m(1.0) } else { 1.0 };
            for (axis, stated, own) in [(moving, motion, own_motion), (forcing, force, own_force)] {
                warnings.extend(own.and_then(|own| against_dataset(units, stated, axis.text(), own)));
            }
            motion / force
        }
    };
    if inverted {
        let kind = motion(quantity);
        warnings.push(format!(
            "the record is force over {kind}; its reciprocal is taken as {}, exact for one force and one motion",
            quantity.word()
        ));
    }
    Ok(Ordinates { quantity, factor, inverted, by_torque })
}

/// Warns of a unit whose factor to SI is not that of dataset 164.
fn against_dataset(units: &Units, stated: f64, label: &str, own: f64) -> Option<String> {
    let description = units.description.trim();
    ((own / stated - 1.0).abs() > CONTRADICTION).then(|| {
        format!(
            "the unit is «{label}» (factor to SI {own}), but dataset 164 «{description}» gives a factor of {stated}; dataset 164 is used"
        )
    })
}

/// Returns the directions of the motion and of the force.
fn directions(header: &RecordHeader, inverted: bool) -> (i64, i64) {
    let (response, reference) = (header.response.direction, header.reference.direction);
    if inverted { (reference, response) } else { (response, reference) }
}

/// Refuses a unit of another kind than its code means.
fn code_against_unit(axis: &Axis<'_>, role: &str) -> Result<(), Fault> {
    let Some(measured) = axis.measures() else { return Ok(()) };
    let fits = match (axis.code, measured) {
        (_, Measures::Ratio(..) | Measures::Inverse(..)) => role == "ordinate",
        (_, Measures::Other) => false,
        (Code::Motion(_), Measures::Motion(_))
        | (Code::Force, Measures::Force | Measures::Torque)
        | (Code::Open | Code::Other(_), _) => true,
        _ => false,
    };
    if fits {
        return Ok(());
    }
    let meant = match axis.code {
        Code::Motion(quantity) => format!("the code means {}", motion(quantity)),
        Code::Force => "the code means a force".into(),
        _ => "an FRF here is motion over force".into(),
    };
    Err(format!(
        "{role}: the unit «{}» is that of {}, but {meant}; correct one of them",
        axis.text(),
        axis.unit_name()
    ))
}

/// Returns the quantity of the response, by code, unit or request.
fn quantity_of(
    axis: &Axis<'_>,
    requested: Option<Quantity>,
    warnings: &mut Vec<String>,
) -> Result<Quantity, Fault> {
    let by_code = if let Code::Motion(quantity) = axis.code { Some(quantity) } else { None };
    let by_unit = if let Some(Measures::Motion(quantity)) = axis.measures() { Some(quantity) } else { None };
    if let (Some(code), Some(unit)) = (by_code, by_unit)
        && code != unit
    {
        let found =
            format!("the code means {}, the unit «{}» means {}", code.word(), axis.text(), unit.word());
        let Some(chosen) = requested.filter(|q| [code, unit].contains(q)) else {
            return Err(format!("{found}; set the quantity to the right one"));
        };
        warnings.push(format!("{found}; {} is used, as requested", chosen.word()));
        return Ok(chosen);
    }
    let Some(stated) = by_code.or(by_unit) else {
        let remedy = "set the quantity to receptance, mobility or accelerance";
        return requested
            .ok_or_else(|| format!("neither code nor unit states the quantity of the response; {remedy}"));
    };
    against_request(stated, requested, warnings);
    Ok(stated)
}

/// Warns of a requested quantity that the record contradicts.
fn against_request(stated: Quantity, requested: Option<Quantity>, warnings: &mut Vec<String>) {
    if let Some(requested) = requested.filter(|requested| *requested != stated) {
        warnings.push(format!(
            "the record states {}, {} was requested; {} is used",
            stated.word(),
            requested.word(),
            stated.word()
        ));
    }
}

/// Returns quantity and factor where the unit of the ordinate contains the force.
fn of_ratio(
    upper: &Axis<'_>,
    lower: &Axis<'_>,
    (by_unit, by_torque, inverted): (Quantity, bool, bool),
    header: &RecordHeader,
    requested: Option<Quantity>,
    warnings: &mut Vec<String>,
) -> Result<Ordinates, Fault> {
    let label = upper.text();
    match upper.code {
        Code::Motion(code) if !inverted && code != by_unit && requested.is_none() => {
            return Err(format!(
                "the code means {}, the unit «{label}» {}; set the quantity to the right one",
                code.word(),
                by_unit.word()
            ));
        }
        Code::Motion(_) if inverted => {
            return Err(format!(
                "the code means a motion, the unit «{label}» is force over motion; correct one of them"
            ));
        }
        Code::Force if !inverted => {
            return Err(format!(
                "the code means a force, the unit «{label}» is motion over force; correct one of them"
            ));
        }
        _ => {}
    }
    against_request(by_unit, requested, warnings);
    if let Some(lower) = lower.label {
        warnings.push(format!("the unit «{label}» contains the denominator already; «{lower}» of the denominator is not applied again"));
    }
    let own = upper.unit.map_or(1.0, Unit::to_si);
    let mut factor = own;
    if let Some(units) = &header.units {
        let length = if upper.unit.is_some_and(|unit| unit.angle != 0) { 1.0 } else { units.length_m(1.0) };
        let ratio = length / units.force_n(1.0) / if by_torque { units.length_m(1.0) } else { 1.0 };
        factor = if inverted { ratio.recip() } else { ratio };
        warnings.extend(against_dataset(units, factor, label, own));
    }
    if inverted {
        let kind = motion(by_unit);
        warnings.push(format!(
            "the unit «{label}» is force over {kind}; its reciprocal is taken as {}",
            by_unit.word()
        ));
    }
    // A reciprocal's factor divides: 1/(value·factor).
    Ok(Ordinates {
        quantity: by_unit,
        factor: if inverted { factor.recip() } else { factor },
        inverted,
        by_torque,
    })
}

/// Returns the unit of an axis for display: its label, with what it measures where it is known.
pub(super) fn shown_unit(axis: &RecordAxis) -> String {
    match axis.unit() {
        None => "no unit".into(),
        Some(label) if parse(label).is_ok() => label.trim().into(),
        Some(label) => format!("{} (unknown)", label.trim()),
    }
}
