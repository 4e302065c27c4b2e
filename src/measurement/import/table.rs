//! Import of FRFs from tables: frequency with real and imaginary parts, or with magnitudes and phases, of one
//! or several FRFs.

use std::collections::{HashMap, HashSet};

use num_complex::Complex64;

use super::ImportedFrf;
use super::column::{Column, Content, column, contradicts, is_time};
use super::layout::{Cell, Layout, cell, is_void, layout};
use super::unit::{Fault, Measures, measures, of_frf, to_hz};
use crate::{MeasurementError, Quantity};

/// What a table does not state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TableRequest {
    /// Measured quantity, where the units do not state it.
    pub quantity: Option<Quantity>,
    /// Names of the columns, in place of a header.
    pub columns: Option<Vec<String>>,
    /// Whether a value that is not finite, and a coherence outside 0 to 1, refuse the table.
    pub strict: bool,
}

/// One FRF with its columns, by index, and their factors.
struct Group {
    frf: ImportedFrf,
    frequency: (usize, f64),
    first: (usize, f64),
    second: (usize, f64),
    form: Form,
    inverted: bool,
    coherence: Option<(usize, f64)>,
    relative_sd: Option<usize>,
}

/// Meaning of the two columns of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Cartesian,
    Polar,
    Decibels,
}

impl Form {
    /// Returns the value of a line; NaN where one of the columns has none.
    fn value(self, a: f64, b: f64, (of_a, of_b): (f64, f64)) -> Complex64 {
        match self {
            Form::Cartesian => Complex64::new(a * of_a, b * of_b),
            _ if !(a.is_finite() && b.is_finite()) => Complex64::new(f64::NAN, f64::NAN),
            Form::Polar => Complex64::from_polar(a * of_a, b * of_b),
            Form::Decibels => Complex64::from_polar(10_f64.powf(a / 20.0) * of_a, b * of_b),
        }
    }
}

/// Reads the FRFs of a table: cells separated by commas, semicolons, tabs or blanks, with points or commas in
/// numbers, with or without lines of text before the table.
///
/// # Errors  no table; a column without meaning, without partner or with an unknown unit; a cell that is no
///   number; the quantity is not stated.
pub fn frfs_from_table(
    source: &str,
    stem: &str,
    text: &str,
    request: &TableRequest,
) -> Result<Vec<ImportedFrf>, MeasurementError> {
    let layout = layout(text).ok_or_else(|| {
        let fault = if text.trim().is_empty() { "is empty" } else { "holds no line of numbers" };
        MeasurementError::file(
            source,
            format!("{fault}; write a table with the columns frequency_hz,real,imag"),
        )
    })?;
    let at_header = |fault: String| MeasurementError::line(source, layout.header_line, fault);
    let columns = columns(&layout, request).map_err(at_header)?;
    let mut groups = groups(&columns, request.quantity).map_err(at_header)?;
    read_values(source, text, &layout, &columns, &mut groups)?;
    let several = groups.len() > 1;
    let named = |(index, Group { mut frf, .. }): (usize, Group)| {
        let label = &frf.texts[0];
        let part = if label.is_empty() { format!("{}", index + 1) } else { label.replace(' ', "-") };
        let name = if several { format!("{stem}-{part}") } else { stem.to_string() };
        frf.warnings.iter_mut().for_each(|note| *note = format!("{name}: {note}"));
        ImportedFrf { name, source: source.into(), ..frf }
            .checked(request.strict)
            .map_err(|fault| in_lines(fault, &layout))
    };
    groups.into_iter().enumerate().map(named).collect()
}

/// States the first line of numbers where a value is at fault, so that its line can be found.
fn in_lines(fault: MeasurementError, layout: &Layout) -> MeasurementError {
    match fault {
        MeasurementError::Record { path, record, fault } => MeasurementError::Record {
            path,
            record,
            fault: format!("{fault}; the numbers begin in line {}", layout.first + 1),
        },
        other => other,
    }
}

/// Returns the columns of a table, by its header or as requested.
fn columns(layout: &Layout, request: &TableRequest) -> Result<Vec<Column>, Fault> {
    let names = match (&request.columns, &layout.header) {
        (Some(names), header) if names.len() == layout.cells => {
            let stated = header.iter().flatten().zip(names);
            if let Some((stated, named)) = stated.clone().find(|(stated, named)| contradicts(stated, named)) {
                return Err(format!(
                    "the column «{stated}» of the header is named {named}; leave columns out, or correct the header"
                ));
            }
            names.clone()
        }
        (Some(names), _) => {
            return Err(format!(
                "{} columns are named, but the table has {}; name each of them",
                names.len(),
                layout.cells
            ));
        }
        (None, Some(names)) => names.clone(),
        (None, None) => {
            return Err(format!(
                "the table has no header with {} names; name its columns, as in frequency_hz,real,imag (the setting columns)",
                layout.cells
            ));
        }
    };
    let mut columns = Vec::new();
    for (at, name) in names.iter().enumerate() {
        // Lines that end in a separator have a last column without name.
        if name.is_empty() && at + 1 == names.len() {
            columns.push(Column {
                name: String::new(),
                content: Content::Empty,
                unit: None,
                decibels: false,
                label: String::new(),
            });
            continue;
        }
        columns.push(column(name).ok_or_else(|| {
            if is_time(name) {
                return format!("the column «{name}» is a time, and FRFs stand over frequency; compute FRFs from time records first (frf)");
            }
            let known = "frequency_hz, real, imag, magnitude, phase_deg, phase_rad, coherence, relative_sd";
            let all = names.join(", ");
            format!("the column «{name}» of «{all}» has no known meaning and is not dropped; remove it, or name it one of {known}")
        })?);
    }
    Ok(columns)
}

/// Sorts the columns into FRFs: by the labels of their names, and by their order where the names are equal.
fn groups(columns: &[Column], requested: Option<Quantity>) -> Result<Vec<Group>, Fault> {
    let all = || columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
    let mut labels: Vec<&str> = Vec::new();
    let mut places: HashMap<(Content, &str), Vec<usize>> = HashMap::new();
    let mut labelled: HashSet<&str> = HashSet::new();
    for (at, column) in columns.iter().enumerate() {
        places.entry((column.content, column.label.as_str())).or_default().push(at);
        let is_value = matches!(
            column.content,
            Content::Real | Content::Imaginary | Content::Magnitude | Content::Phase
        );
        if is_value && labelled.insert(&column.label) {
            labels.push(&column.label);
        }
    }
    let of = |content: Content, label: &str| -> Vec<usize> {
        places.get(&(content, label)).cloned().unwrap_or_default()
    };
    let every = |content: Content| {
        (0..columns.len()).filter(|at| columns[*at].content == content).collect::<Vec<_>>()
    };
    let frequencies = every(Content::Frequency);
    if frequencies.is_empty() {
        return Err(format!("no frequency column among «{}»; name one frequency_hz", all()));
    }
    let mut used: Vec<bool> = columns.iter().map(|column| column.content == Content::Empty).collect();
    let mut groups = Vec::new();
    for label in &labels {
        let (real, imaginary, magnitude, phase) = (
            of(Content::Real, label),
            of(Content::Imaginary, label),
            of(Content::Magnitude, label),
            of(Content::Phase, label),
        );
        let has_both = !real.is_empty() && !magnitude.is_empty();
        let (firsts, seconds, is_polar) =
            if real.is_empty() { (magnitude.clone(), phase.clone(), true) } else { (real, imaginary, false) };
        if firsts.len() != seconds.len() || firsts.is_empty() {
            let which = if label.is_empty() { String::new() } else { format!(" of «{label}»") };
            return Err(format!(
                "write columns real,imag or magnitude,phase_deg (or phase_rad){which}; found {}",
                all()
            ));
        }
        let own = |content: Content, index: usize| {
            let own = of(content, label);
            if own.len() == firsts.len() { own.get(index).copied() } else { None }
        };
        for (index, (first, second)) in firsts.iter().copied().zip(seconds.iter().copied()).enumerate() {
            let frequency = match frequencies.as_slice() {
                [only] => *only,
                _ => own(Content::Frequency, index).ok_or_else(|| {
                    format!(
                        "several frequency columns in «{}», and none belongs to «{label}»; keep one",
                        all()
                    )
                })?,
            };
            let alone = labels.len() == 1 && firsts.len() == 1;
            let shared = |content: Content| {
                own(content, index).or_else(|| every(content).first().copied().filter(|_| alone))
            };
            let mut group = group(columns, frequency, (first, second), is_polar, requested)?;
            group.coherence = shared(Content::Coherence)
                .map(|at| (at, if columns[at].unit.as_deref() == Some("%") { 0.01 } else { 1.0 }));
            group.relative_sd = shared(Content::RelativeSd);
            group.frf.coherence = group.coherence.map(|_| Vec::new());
            group.frf.relative_sd = group.relative_sd.map(|_| Vec::new());
            if has_both && !is_polar {
                magnitude.iter().chain(&phase).for_each(|at| used[*at] = true);
                group
                    .frf
                    .warnings
                    .push("magnitude and phase repeat the real and imaginary parts, which are used".into());
            }
            let own =
                [Some(frequency), Some(first), Some(second), group.coherence.map(|c| c.0), group.relative_sd];
            own.into_iter().flatten().for_each(|at| used[at] = true);
            groups.push(group);
        }
    }
    if groups.is_empty() {
        return Err(format!(
            "write columns real,imag or magnitude,phase_deg (or phase_rad); found {}",
            all()
        ));
    }
    if let Some(at) = used.iter().position(|used| !used) {
        return Err(format!(
            "the column «{}» is left over: it belongs to none of the FRFs; remove or rename it",
            columns[at].name
        ));
    }
    Ok(groups)
}

/// Returns the columns of one FRF with their factors.
fn group(
    columns: &[Column],
    frequency: usize,
    (first, second): (usize, usize),
    is_polar: bool,
    requested: Option<Quantity>,
) -> Result<Group, Fault> {
    let mut notes = Vec::new();
    let (a, b) = (&columns[first], &columns[second]);
    let factor_hz = match &columns[frequency].unit {
        None => 1.0,
        Some(unit) => to_hz(unit)
            .map_err(|fault| format!("{}: {fault}; write Hz, kHz, rad/s or rpm", columns[frequency].name))?,
    };
    let form = match (is_polar, a.decibels) {
        (false, _) => Form::Cartesian,
        (true, false) => Form::Polar,
        (true, true) => Form::Decibels,
    };
    let (of_a, found) = match &a.unit {
        Some(unit) => value_unit(a, unit).map(|(factor, kind)| (Some(factor), Some(kind)))?,
        None => (None, None),
    };
    let (of_b, kind) = if is_polar {
        (Some(phase_factor(b)?), found)
    } else {
        match &b.unit {
            Some(unit) => {
                let (factor, other) = value_unit(b, unit)?;
                if let Some(found) = found.filter(|found| *found != other) {
                    return Err(format!(
                        "«{}» and «{}» measure different quantities, {} and {}; correct their units",
                        a.name,
                        b.name,
                        found.name(),
                        other.name()
                    ));
                }
                (Some(factor), Some(other))
            }
            None => (of_a, found),
        }
    };
    let (stated, by_torque, inverted) = match kind {
        Some(Measures::Ratio(quantity, by_torque)) => (Some(quantity), by_torque, false),
        Some(Measures::Inverse(quantity, by_torque)) => (Some(quantity), by_torque, true),
        _ => (None, false, false),
    };
    let quantity = quantity(stated, requested, a.unit.as_ref().or(b.unit.as_ref()))?;
    if kind.is_none() {
        notes.push(if form == Form::Decibels {
            "decibels without reference; taken as relative to one SI unit".into()
        } else {
            "the values have no unit; taken as SI".into()
        });
    }
    if inverted {
        notes.push(format!(
            "the columns hold force over motion; their reciprocal is taken as {}",
            quantity.word()
        ));
    }
    let frf = ImportedFrf {
        name: String::new(),
        source: String::new(),
        texts: vec![a.label.clone()],
        response: "response".into(),
        excitation: "excitation".into(),
        response_direction: 0,
        excitation_direction: 0,
        by_torque,
        quantity,
        frequency_hz: Vec::new(),
        values: Vec::new(),
        coherence: None,
        relative_sd: None,
        dropped: 0,
        warnings: notes,
    };
    Ok(Group {
        frf,
        frequency: (frequency, factor_hz),
        first: (first, of_a.or(if is_polar { None } else { of_b }).unwrap_or(1.0)),
        second: (second, of_b.unwrap_or(1.0)),
        form,
        inverted,
        coherence: None,
        relative_sd: None,
    })
}

/// Returns the quantity that the units state, or the requested one.
fn quantity(
    stated: Option<Quantity>,
    requested: Option<Quantity>,
    unit: Option<&String>,
) -> Result<Quantity, Fault> {
    match (stated, requested) {
        (Some(stated), Some(requested)) if stated != requested => Err(format!(
            "the unit «{}» means {stated}, not {}; set the quantity to {stated}",
            unit.map_or("", |unit| unit.as_str()),
            requested.word(),
            stated = stated.word()
        )),
        _ => stated.or(requested).ok_or_else(|| {
            "a table without units does not state its quantity; set the quantity to receptance, mobility or accelerance".into()
        }),
    }
}

/// Returns factor and kind of the unit of a value.
fn value_unit(column: &Column, label: &str) -> Result<(f64, Measures), Fault> {
    let unit = of_frf(label).map_err(|fault| {
        format!("{}: {fault}; write one like m/N, (mm/s)/N or (m/s^2)/N, or none for SI", column.name)
    })?;
    match measures(unit) {
        kind @ (Measures::Ratio(..) | Measures::Inverse(..)) => Ok((unit.to_si(), kind)),
        _ => Err(format!(
            "{}: the unit «{label}» is that of {}, not of motion over force; write one like m/N, (mm/s)/N or (m/s^2)/N",
            column.name,
            unit.dimension.name()
        )),
    }
}

/// Returns the factor of a phase to rad.
fn phase_factor(column: &Column) -> Result<f64, Fault> {
    let label =
        column.unit.as_deref().ok_or("the phase has no unit; name the column phase_deg or phase_rad")?;
    let unit =
        numeric::unit::parse(label).map_err(|fault| format!("{}: {fault}; write deg or rad", column.name))?;
    let is_angle =
        unit.dimension == numeric::unit::Unit::ONE.dimension && (unit.angle == 1 || unit.turns == 1);
    if is_angle {
        Ok(unit.to_si())
    } else {
        Err(format!("{}: «{label}» is no angle; write deg or rad", column.name))
    }
}

/// Reads all lines of numbers into the FRFs.
fn read_values(
    source: &str,
    text: &str,
    layout: &Layout,
    columns: &[Column],
    groups: &mut [Group],
) -> Result<(), MeasurementError> {
    let mut numbers = vec![f64::NAN; columns.len()];
    for (index, line) in text.lines().enumerate().skip(layout.first) {
        if is_void(line) {
            continue;
        }
        let in_line = |fault: String| MeasurementError::line(source, index as u64 + 1, fault);
        read_line(line, layout, columns, &mut numbers).map_err(in_line)?;
        for group in groups.iter_mut() {
            let (a, b) = (numbers[group.first.0], numbers[group.second.0]);
            if group.form == Form::Polar && a < 0.0 {
                return Err(in_line(format!("the magnitude is {a}; a linear magnitude is not negative")));
            }
            let frequency = numbers[group.frequency.0];
            if !frequency.is_finite() {
                return Err(in_line(format!(
                    "{} is missing; each line has a frequency",
                    columns[group.frequency.0].name
                )));
            }
            let value = group.form.value(a, b, (group.first.1, group.second.1));
            group.frf.frequency_hz.push(frequency * group.frequency.1);
            group.frf.values.push(if group.inverted { value.inv() } else { value });
            if let (Some((at, factor)), Some(coherence)) = (group.coherence, &mut group.frf.coherence) {
                coherence.push(numbers[at] * factor);
            }
            if let (Some(at), Some(relative_sd)) = (group.relative_sd, &mut group.frf.relative_sd) {
                relative_sd.push(numbers[at]);
            }
        }
    }
    Ok(())
}

/// Reads the cells of a line; NaN where a value is missing.
fn read_line(line: &str, layout: &Layout, columns: &[Column], numbers: &mut [f64]) -> Result<(), Fault> {
    let mut count = 0;
    let mut read = |text: &str| {
        if let Some(number) = numbers.get_mut(count) {
            *number = match cell(text, layout.comma) {
                _ if columns[count].content == Content::Empty && !text.is_empty() => {
                    let shown: String = text.chars().take(40).collect();
                    return Err(format!(
                        "the column without a name holds «{shown}»; name it in the header, or remove it"
                    ));
                }
                Cell::Number(number) => number,
                Cell::Missing => f64::NAN,
                Cell::Text => {
                    let shown: String = text.chars().take(40).collect();
                    return Err(format!("{} is «{shown}»; write a finite number", columns[count].name));
                }
            };
        }
        count += 1;
        Ok(())
    };
    layout.separator.cells(line).try_for_each(&mut read)?;
    if count != columns.len() {
        let hint =
            if count > columns.len() && !layout.comma { " (decimal commas? write points)" } else { "" };
        return Err(format!("has {count} cells, not {} as the first line of numbers{hint}", columns.len()));
    }
    Ok(())
}

/// Describes a table: columns, lines, frequency range, units and quantity.
///
/// # Errors  as [`frfs_from_table`].
pub fn described_table(source: &str, text: &str, request: &TableRequest) -> Result<String, MeasurementError> {
    let frfs = frfs_from_table(
        source,
        "table",
        text,
        &TableRequest { quantity: request.quantity.or(Some(Quantity::Receptance)), ..request.clone() },
    )
    .or_else(|_| frfs_from_table(source, "table", text, request))?;
    let layout = layout(text);
    let names =
        request.columns.clone().or(layout.and_then(|layout| layout.header)).unwrap_or_default().join(", ");
    let mut described = format!("a table of {} FRFs, columns {names}", frfs.len());
    for frf in &frfs {
        let (first, last) =
            (frf.frequency_hz.first().unwrap_or(&0.0), frf.frequency_hz.last().unwrap_or(&0.0));
        let has_unit = frf.warnings.iter().all(|w| !w.contains("taken as"));
        let quantity = if has_unit { frf.quantity.word() } else { "quantity and unit not stated" };
        let coherence = if frf.coherence.is_some() { ", with coherence" } else { "" };
        described += &format!(
            "\n  {} lines  {first}…{last} Hz  {quantity}{coherence}  directions and averages not stated",
            frf.frequency_hz.len()
        );
    }
    Ok(described)
}

#[cfg(test)]
mod tests;
