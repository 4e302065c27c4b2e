//! Import of FRFs from CSV tables: frequency with real and imaginary part, or with magnitude and phase.

use num_complex::Complex64;

use super::{ImportedFrf, label};
use crate::{MeasurementError, Quantity};

/// Content of a column, by its usual names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Frequency,
    Real,
    Imaginary,
    Magnitude,
    PhaseDegrees,
    PhaseRadians,
    PhaseWithoutUnit,
    Coherence,
}

/// Recognises the content of a column by its name.
fn column(name: &str) -> Option<Column> {
    let lowercase: String = name.trim().trim_start_matches('\u{feff}').to_lowercase();
    let letters: String = lowercase.chars().map(|c| if c.is_alphanumeric() { c } else { ' ' }).collect();
    let words: Vec<&str> = letters.split_whitespace().collect();
    let any = |names: &[&str]| words.iter().any(|w| names.contains(w));
    if any(&["phase", "angle", "arg"]) {
        return Some(if any(&["deg", "degree", "degrees"]) || lowercase.contains('°') {
            Column::PhaseDegrees
        } else if any(&["rad", "radian", "radians"]) {
            Column::PhaseRadians
        } else {
            Column::PhaseWithoutUnit
        });
    }
    let kinds: [(&[&str], Column); 5] = [
        (&["frequency", "freq", "f", "hz"], Column::Frequency),
        (&["real", "re"], Column::Real),
        (&["imag", "imaginary", "im"], Column::Imaginary),
        (&["magnitude", "mag", "amplitude", "abs", "modulus"], Column::Magnitude),
        (&["coherence", "coh", "gamma2"], Column::Coherence),
    ];
    kinds.iter().find(|(names, _)| any(names)).map(|k| k.1)
}

/// Returns the unit in brackets of a column name, if any: `real (mm/N)`, `freq [kHz]`.
fn unit(name: &str) -> Option<&str> {
    let open = name.find(['(', '['])?;
    let inside = name[open + 1..].trim_end().trim_end_matches([')', ']']);
    // Inner brackets belong to the unit.
    let close = name[open + 1..].rfind([')', ']']).map_or(name.len(), |at| open + 1 + at);
    let inside = if inside.contains('(') && !inside.contains(')') { &name[open + 1..close] } else { inside };
    (!inside.trim().is_empty()).then_some(inside.trim())
}

/// Reads an FRF from a table with a header line, separated by commas, semicolons or tabs.
///
/// # Errors  no header, a column missing or without unit, a cell that is not a number; no quantity is given.
pub fn frf_from_csv(source: &str, stem: &str, text: &str, requested: Option<Quantity>) -> Result<ImportedFrf, MeasurementError> {
    let in_file = |fault: String| MeasurementError::file(source, fault);
    let in_header = |fault: String| MeasurementError::line(source, 1, fault);
    let quantity = requested
        .ok_or_else(|| in_file("a table does not state its quantity; set the quantity to receptance, mobility or accelerance".into()))?;
    let first = text.lines().next().unwrap_or("");
    let separator = [b';', b'\t', b','].into_iter().max_by_key(|s| first.bytes().filter(|b| b == s).count()).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new().delimiter(separator).trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| in_file(format!("is not a table: {e}")))?.clone();
    let kinds: Vec<Option<Column>> = header.iter().map(column).collect();
    let find = |wanted: Column| kinds.iter().position(|k| *k == Some(wanted));
    if find(Column::PhaseWithoutUnit).is_some() {
        return Err(in_header("the phase has no unit; name the column phase_deg or phase_rad".into()));
    }
    let frequency = find(Column::Frequency).ok_or_else(|| in_header("no frequency column; name one frequency_hz".into()))?;
    let polar = find(Column::Magnitude).zip(find(Column::PhaseDegrees).or(find(Column::PhaseRadians)));
    let (first, second, is_polar) = match (find(Column::Real).zip(find(Column::Imaginary)), polar) {
        (Some((re, im)), _) => (re, im, false),
        (None, Some((magnitude, phase))) => (magnitude, phase, true),
        (None, None) => {
            return Err(in_header(format!(
                "write columns real,imag or magnitude,phase_deg (or phase_rad); found {}",
                header.iter().collect::<Vec<_>>().join(", ")
            )));
        }
    };
    let name = |at: usize| header.get(at).unwrap_or("");
    let to_hz = match unit(name(frequency)) {
        None => 1.0,
        Some(text) => label::frequency(text)
            .ok_or_else(|| in_header(format!("the frequency's unit «{text}» is unknown; write Hz, kHz, rad/s or rpm")))?,
    };
    let stated = unit(name(first)).filter(|_| is_polar || first != second);
    let decibels = |text: &str| text.to_lowercase().starts_with("db");
    if stated.is_some_and(decibels) || name(first).to_lowercase().contains("_db") {
        return Err(in_header(format!("«{}» is in decibels with unknown reference; write linear values", name(first))));
    }
    let mut warnings = Vec::new();
    let size = match stated {
        None => {
            warnings.push(format!("{stem}: the values have no unit; taken as SI"));
            1.0
        }
        Some(text) => match label::ratio(text) {
            Some((by_unit, _)) if by_unit != quantity => {
                let remedy = format!("set the quantity to {}", by_unit.word());
                return Err(in_header(format!(
                    "the unit «{text}» is that of a {}, not of a {}; {remedy}",
                    by_unit.word(),
                    quantity.word()
                )));
            }
            Some((_, size)) => size,
            None => {
                let remedy = "write one like m/N, (mm/s)/N or (m/s^2)/N, or none for SI";
                return Err(in_header(format!("the unit «{text}» is unknown; {remedy}")));
            }
        },
    };
    let to_rad = if find(Column::PhaseDegrees).is_some() { std::f64::consts::PI / 180.0 } else { 1.0 };
    let coherence = find(Column::Coherence);
    let (mut frequency_hz, mut values, mut gammas) = (Vec::new(), Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(|e| in_file(e.to_string()))?;
        let line = record.position().map_or(0, csv::Position::line);
        let in_line = |fault: String| MeasurementError::line(source, line, fault);
        let number = |at: usize| {
            let cell = record.get(at).unwrap_or("");
            cell.parse::<f64>().ok().filter(|x| x.is_finite()).ok_or_else(|| {
                let hint = if cell.contains(',') { "; write decimal points" } else { "" };
                in_line(format!("{} is «{cell}»; write a finite number{hint}", header.get(at).unwrap_or("")))
            })
        };
        let (a, b) = (number(first)?, number(second)?);
        if is_polar && a < 0.0 {
            return Err(in_line(format!("the magnitude is {a}; a linear magnitude is not negative")));
        }
        frequency_hz.push(number(frequency)? * to_hz);
        values.push(size * if is_polar { Complex64::from_polar(a, b * to_rad) } else { Complex64::new(a, b) });
        if let Some(at) = coherence {
            gammas.push(number(at)?);
        }
    }
    ImportedFrf {
        name: stem.into(),
        source: source.into(),
        texts: Vec::new(),
        response: "response".into(),
        excitation: "excitation".into(),
        quantity,
        frequency_hz,
        values,
        coherence: coherence.map(|_| gammas),
        dropped: 0,
        warnings,
    }
    .checked()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cartesian_and_polar_forms_agree() {
        let a = frf_from_csv("a.csv", "a", "Frequency (Hz),Real,Imag\n0,1,0\n10,0,-2\n", Some(Quantity::Receptance)).unwrap();
        let b = frf_from_csv("b.csv", "b", "freq;mag;phase [deg];coherence\n10;2;-90;0.99\n", Some(Quantity::Receptance)).unwrap();
        assert_eq!(a.frequency_hz, [10.0]);
        assert!((a.values[0] - b.values[0]).norm() < 1e-12);
        assert_eq!(b.coherence, Some(vec![0.99]));
    }

    #[test]
    fn header_units_are_applied_or_refused() {
        let read = |text: &str| frf_from_csv("a.csv", "a", text, Some(Quantity::Receptance));
        let a = read("freq (kHz),real (mm/N),imag (mm/N)\n1,2,0\n").unwrap();
        assert_eq!((a.frequency_hz[0], a.values[0].re), (1000.0, 2e-3));
        assert!(a.warnings.is_empty(), "{:?}", a.warnings);
        assert!(read("f (Hz),Magnitude (dB),Phase (deg)\n1,-40,0\n").unwrap_err().to_string().contains("decibels"));
        assert!(read("f (Hz),real (furlong),imag\n1,1,0\n").unwrap_err().to_string().contains("furlong"));
        assert!(read("f (Hz),real ((m/s^2)/N),imag\n1,1,0\n").unwrap_err().to_string().contains("set the quantity to accelerance"));
        assert!(read("f,mag,phase_deg\n1,-1,0\n").unwrap_err().to_string().contains("line 2"));
        assert!(read("f (parsec),re,im\n1,1,0\n").unwrap_err().to_string().contains("kHz"));
    }

    #[test]
    fn refuse_a_phase_without_unit_and_decimal_commas() {
        let phase = frf_from_csv("a.csv", "a", "f,mag,phase\n1,1,1\n", Some(Quantity::Receptance)).unwrap_err().to_string();
        assert!(phase.contains("phase_deg"), "{phase}");
        let comma = frf_from_csv("a.csv", "a", "f;re;im\n1,5;1;1\n", Some(Quantity::Receptance)).unwrap_err().to_string();
        assert!(comma.contains("line 2") && comma.contains("points"), "{comma}");
        assert!(frf_from_csv("a.csv", "a", "f,re,im\n1,1,1\n", None).unwrap_err().to_string().contains("set the quantity"));
    }
}
