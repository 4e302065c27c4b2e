//! Import of FRFs from universal files: quantity and units from the codes of each record.

use num_complex::Complex64;

use super::{ImportedFrf, label};
use crate::universal::{NodeLocation, Ordinate, RecordAxis, RecordHeader, UniversalFile, UniversalRecord, data_type, function_type};
use crate::{MeasurementError, Quantity};

/// Largest relative difference of two abscissa values that count as equal (1).
const ABSCISSA_TOLERANCE: f64 = 1e-6;

/// Whether a record is an FRF or the coherence of one.
pub fn is_of_frf(header: &RecordHeader) -> bool {
    [function_type::FREQUENCY_RESPONSE, function_type::COHERENCE].contains(&header.function_type)
}

/// Returns the FRFs of a universal file, each with its coherence where the file holds one, and notes on skipped data.
///
/// `requested` is the quantity of records whose codes and units do not state one.
///
/// # Errors  such a record without `requested`; a record whose numbers are not a valid FRF.
pub fn frfs_from_universal(
    source: &str,
    stem: &str,
    file: UniversalFile,
    requested: Option<Quantity>,
) -> Result<(Vec<ImportedFrf>, Vec<String>), MeasurementError> {
    let mut notes: Vec<String> = file.warnings.iter().map(|w| format!("{source}: {w}")).collect();
    let mut other_records = file.functions.iter().filter(|r| !is_of_frf(&r.header)).count() as u64;
    for skipped in &file.skipped {
        match skipped.number {
            58 => other_records += skipped.times,
            number => notes.push(format!("{source}: dataset {number} is not read ({} ×)", skipped.times)),
        }
    }
    if other_records > 0 {
        notes.push(format!("{source}: {other_records} records of dataset 58 are not FRFs (function type 4) and are skipped"));
    }
    let (coherences, frfs): (Vec<UniversalRecord>, Vec<UniversalRecord>) =
        file.functions.into_iter().filter(|r| is_of_frf(&r.header)).partition(|r| r.header.function_type == function_type::COHERENCE);
    let alone = frfs.len() == 1;
    let mut imported = Vec::new();
    for (at, record) in frfs.into_iter().enumerate() {
        let name = if alone { stem.to_string() } else { format!("{stem}-{}", at + 1) };
        imported.push(import_record(source, name, &record, &coherences, requested)?);
    }
    Ok((imported, notes))
}

/// Formats point, sign and axis, for example `7:+Z`, preceded by the entity's name where it has one.
fn point(location: &NodeLocation) -> String {
    let axis = match location.direction.abs() {
        1 => "X",
        2 => "Y",
        3 => "Z",
        4 => "RX",
        5 => "RY",
        6 => "RZ",
        _ => "",
    };
    let sign = if axis.is_empty() {
        ""
    } else if location.direction < 0 {
        "-"
    } else {
        "+"
    };
    let entity = location.entity.trim();
    let entity = if entity.is_empty() || entity == "NONE" { String::new() } else { format!("{entity}:") };
    if axis.is_empty() { format!("{entity}{}", location.node) } else { format!("{entity}{}:{sign}{axis}", location.node) }
}

/// Converts one record, with its coherence if there is one, to an FRF.
fn import_record(
    source: &str,
    name: String,
    record: &UniversalRecord,
    coherences: &[UniversalRecord],
    requested: Option<Quantity>,
) -> Result<ImportedFrf, MeasurementError> {
    let header = &record.header;
    let mut warnings: Vec<String> = header.warnings.iter().map(|w| format!("{name}: {w}")).collect();
    let (quantity, scale) = quantity_and_scale(source, &name, record, requested, &mut warnings)?;
    let Ordinate::Complex(values) = &record.ordinate else {
        return Err(MeasurementError::record(source, &name, "the FRF is stored as real numbers, without phase; export it as complex"));
    };
    let frequency_hz = record.abscissa.values();
    let same = |other: &&UniversalRecord| {
        let h = &other.header;
        h.response == header.response
            && h.reference.node == header.reference.node
            && other.ordinate.len() == values.len()
            && other
                .abscissa
                .values()
                .iter()
                .zip(&frequency_hz)
                .all(|(a, b)| (a - b).abs() <= ABSCISSA_TOLERANCE * b.abs().max(ABSCISSA_TOLERANCE))
    };
    let coherence = coherences.iter().find(same).and_then(|c| match &c.ordinate {
        Ordinate::Real(values) => Some(values.clone()),
        Ordinate::Complex(_) => None,
    });
    let entity = |l: &NodeLocation| l.entity.trim().to_string();
    ImportedFrf {
        source: source.into(),
        texts: header.id_lines.iter().map(|l| l.trim().to_string()).chain([entity(&header.response), entity(&header.reference)]).collect(),
        response: point(&header.response),
        excitation: point(&header.reference),
        quantity,
        values: values.iter().map(|v: &Complex64| v * scale).collect(),
        frequency_hz,
        coherence,
        dropped: 0,
        warnings,
        name,
    }
    .checked()
}

/// Returns the quantity and the factor from the file's units to SI.
fn quantity_and_scale(
    source: &str,
    name: &str,
    record: &UniversalRecord,
    requested: Option<Quantity>,
    warnings: &mut Vec<String>,
) -> Result<(Quantity, f64), MeasurementError> {
    let header = &record.header;
    let text = |axis: &RecordAxis| axis.unit().map(str::to_string);
    let (response_unit, force_unit) = (text(&header.ordinate), text(&header.denominator));
    let by_label = response_unit.as_deref().and_then(label::response);
    let by_code = match header.ordinate.data_type {
        data_type::DISPLACEMENT => Some(Quantity::Receptance),
        data_type::VELOCITY => Some(Quantity::Mobility),
        data_type::ACCELERATION => Some(Quantity::Accelerance),
        _ => None,
    };
    if ![data_type::EXCITATION_FORCE, data_type::REACTION_FORCE].contains(&header.denominator.data_type)
        && force_unit.as_deref().and_then(label::force).is_none()
    {
        warnings.push(format!("{name}: neither code nor unit identifies the reference as a force; taken as a force in N"));
    }
    let quantity = by_code.or(by_label.map(|l| l.0)).or(requested).ok_or_else(|| {
        let remedy = "set the quantity to receptance, mobility or accelerance";
        MeasurementError::record(source, name, format!("neither code nor unit states the quantity of the response; {remedy}"))
    })?;
    if let Some((by_label, _)) = by_label.filter(|l| l.0 != quantity) {
        warnings.push(format!(
            "{name}: the code means {}, the unit «{}» means {}; the code is used",
            quantity.word(),
            response_unit.as_deref().unwrap_or(""),
            by_label.word()
        ));
    }
    let scale = match &header.units {
        Some(units) => {
            if response_unit.as_deref().is_some_and(|o| o.trim().eq_ignore_ascii_case("g")) {
                warnings.push(format!("{name}: the unit is «g», but dataset 164 gives factors of length and force; the factors are used"));
            }
            units.length_m(1.0) / units.force_n(1.0)
        }
        None => {
            let response = by_label.filter(|l| l.0 == quantity).map(|l| l.1);
            let force = force_unit.as_deref().and_then(label::force);
            if response.is_none() || force.is_none() {
                warnings.push(format!(
                    "{name}: no dataset 164 and no unit for {}; taken as SI",
                    if response.is_none() { "the response" } else { "the force" }
                ));
            }
            response.unwrap_or(1.0) / force.unwrap_or(1.0)
        }
    };
    Ok((quantity, scale))
}
