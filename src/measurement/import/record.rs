//! Import of FRFs from universal files: quantity and units from the codes of each record.

use num_complex::Complex64;

use super::ImportedFrf;
use super::axis::{Ordinates, abscissa_to_hz, ordinates, shown_unit};
use super::coherence::{self, coherence_of, paired};
use super::place::point;
use crate::{MeasurementError, Quantity};
use universal_files::{NodeLocation, Ordinate, RecordHeader, UniversalFile, UniversalRecord, function_type};

/// Whether a record is an FRF or the coherence of one.
pub fn is_of_frf(header: &RecordHeader) -> bool {
    [function_type::FREQUENCY_RESPONSE, function_type::COHERENCE].contains(&header.function_type)
}

/// Returns the FRFs of a universal file, each with its coherence where the file holds one, and notes on data
/// left out.
///
/// `requested` is the quantity of records whose codes and units do not state one. A record that is not a
/// valid FRF is left out, named in the notes; where `strict` or where no other is left, it is refused.
///
/// # Errors  such a record; its text names what is wrong with it.
pub fn frfs_from_universal(
    source: &str,
    stem: &str,
    file: UniversalFile,
    requested: Option<Quantity>,
    strict: bool,
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
        notes.push(format!(
            "{source}: {other_records} records of dataset 58 are not FRFs (function type 4) and are skipped"
        ));
    }
    let (coherences, frfs): (Vec<UniversalRecord>, Vec<UniversalRecord>) = file
        .functions
        .into_iter()
        .filter(|r| is_of_frf(&r.header))
        .partition(|r| r.header.function_type == function_type::COHERENCE);
    let pairs = paired(source, &frfs, &coherences, &mut notes);
    let alone = frfs.len() == 1;
    let (mut imported, mut refused) = (Vec::new(), Vec::new());
    for (at, (record, pair)) in frfs.into_iter().zip(pairs).enumerate() {
        let name = if alone { stem.to_string() } else { format!("{stem}-{}", at + 1) };
        match import_record(source, name, record, pair.map(|at| &coherences[at]), requested, strict) {
            Ok(frf) => imported.push(frf),
            Err(fault) if strict => return Err(fault),
            Err(fault) => refused.push(fault),
        }
    }
    if imported.is_empty() && !refused.is_empty() {
        return Err(refused.swap_remove(0));
    }
    notes.extend(refused.into_iter().map(|fault| format!("{fault}; this record is left out")));
    Ok((imported, notes))
}

/// Converts one record, with its coherence if there is one, to an FRF.
fn import_record(
    source: &str,
    name: String,
    record: UniversalRecord,
    coherence: Option<&UniversalRecord>,
    requested: Option<Quantity>,
    strict: bool,
) -> Result<ImportedFrf, MeasurementError> {
    let UniversalRecord { header, abscissa, ordinate } = record;
    let mut warnings: Vec<String> = header.warnings.iter().map(|w| format!("{name}: {w}")).collect();
    let to_hz = abscissa_to_hz(source, &name, &header.abscissa, &mut warnings)?;
    let Ordinates { quantity, factor, inverted, by_torque } =
        ordinates(source, &name, &header, requested, &mut warnings)?;
    let Ordinate::Complex(mut values) = ordinate else {
        return Err(MeasurementError::record(
            source,
            &name,
            "the FRF is stored as real numbers, without phase; export it as complex",
        ));
    };
    let si = |v: Complex64| if inverted { factor / v } else { v * factor };
    values.iter_mut().for_each(|v| *v = si(*v));
    let mut frequency_hz = abscissa.values();
    drop(abscissa);
    frequency_hz.iter_mut().for_each(|f| *f *= to_hz);
    let of_coherence = coherence.and_then(coherence::values);
    if let Some(complex) = coherence.filter(|_| of_coherence.is_none()) {
        warnings.push(format!("{name}: {} is complex and is left out", coherence_of(complex)));
    }
    let entity = |l: &NodeLocation| l.entity.trim().to_string();
    let (moving, struck) =
        if inverted { (&header.reference, &header.response) } else { (&header.response, &header.reference) };
    ImportedFrf {
        source: source.into(),
        texts: header
            .id_lines
            .iter()
            .map(|l| l.trim().to_string())
            .chain([entity(&header.response), entity(&header.reference)])
            .collect(),
        response: point(moving),
        excitation: point(struck),
        response_direction: moving.direction,
        excitation_direction: struck.direction,
        by_torque,
        quantity,
        values,
        frequency_hz,
        coherence: of_coherence,
        relative_sd: None,
        dropped: 0,
        warnings,
        name,
    }
    .checked(strict)
}

/// Describes a record by its header: type, lines, range of the abscissa, places, units, quantity.
pub fn described(header: &RecordHeader) -> String {
    let kind = match header.function_type {
        function_type::FREQUENCY_RESPONSE => "FRF".to_string(),
        function_type::COHERENCE => "coherence".into(),
        function_type::TIME => "time record".into(),
        other => format!("function type {other}"),
    };
    let unit = header.abscissa.unit().map_or_else(String::new, |unit| format!(" {}", unit.trim()));
    let range = if header.even && header.count > 0 {
        let last = header.abscissa_first + (header.count - 1) as f64 * header.abscissa_step;
        format!("{}…{last}{unit}, step {}", header.abscissa_first, header.abscissa_step)
    } else {
        format!("uneven abscissa{unit}")
    };
    let items = if is_of_frf(header) { "lines" } else { "values" };
    let mut text = format!(
        "{kind}  {} {items}  {range}  {} / {}",
        header.count,
        point(&header.response),
        point(&header.reference)
    );
    if header.function_type == function_type::FREQUENCY_RESPONSE {
        let quantity = match ordinates("", "", header, None, &mut Vec::new()) {
            Ok(found) if found.inverted => format!("reciprocal of {}", found.quantity.word()),
            Ok(found) => found.quantity.word().into(),
            Err(_) => "quantity unclear".into(),
        };
        let (upper, lower) = (shown_unit(&header.ordinate), shown_unit(&header.denominator));
        let set = header
            .units
            .as_ref()
            .map_or_else(String::new, |units| format!(", dataset 164 «{}»", units.description.trim()));
        text += &format!("  {quantity}, {upper} / {lower}{set}");
    }
    if header.version != 0 {
        text += &format!("  version {}", header.version);
    }
    // One of them may name the position.
    let ids = header.id_lines.iter().map(|id| id.trim());
    ids.filter(|id| !id.is_empty() && !id.eq_ignore_ascii_case("none"))
        .for_each(|id| text += &format!("  «{id}»"));
    text
}
