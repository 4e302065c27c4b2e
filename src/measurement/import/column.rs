//! Content, unit and label of a table's column, from its name.

use numeric::unit::{Unit, parse};

/// Content of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Content {
    /// A column without name and without values, as where lines end in a separator.
    Empty,
    Frequency,
    Real,
    Imaginary,
    Magnitude,
    Phase,
    Coherence,
    RelativeSd,
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Column {
    pub name: String,
    pub content: Content,
    /// Unit as stated, without «dB».
    pub unit: Option<String>,
    /// Whether a magnitude is in decibels.
    pub decibels: bool,
    /// Rest of the name, which tells the columns of several FRFs apart: `1` of `Real 1`.
    pub label: String,
}

/// Words of the contents, in the order in which they decide.
const WORDS: [(Content, &[&str]); 7] = [
    (Content::RelativeSd, &["relative_sd"]),
    (Content::Phase, &["phase", "angle", "arg", "phi"]),
    (Content::Coherence, &["coherence", "coh", "gamma2", "kohärenz"]),
    (Content::Real, &["real", "re", "realteil"]),
    (Content::Imaginary, &["imag", "imaginary", "im", "imaginärteil"]),
    (Content::Magnitude, &["magnitude", "mag", "amplitude", "abs", "modulus", "betrag"]),
    (Content::Frequency, &["frequency", "frequencies", "freq", "frequenz", "omega", "f", "hz", "khz", "rpm"]),
];

/// Words that may stand in brackets without being a unit, and so belong to no label either.
const FUNCTIONS: [&str; 9] = ["h", "h1", "h2", "hv", "frf", "tf", "jw", "jω", "f"];

/// Recognises a column by its name; `None` where the name says nothing.
pub(super) fn column(name: &str) -> Option<Column> {
    let name = name.trim().trim_start_matches('\u{feff}').trim();
    let (mut rest, mut unit) = without_bracket(name);
    let mut decibels = false;
    if let Some(text) = &unit
        && FUNCTIONS.contains(&text.to_lowercase().as_str())
    {
        unit = None;
    }
    if let Some(text) = unit.clone().filter(|text| text.to_lowercase().starts_with("db")) {
        decibels = true;
        unit = reference(&text[2..]);
    }
    if rest.is_empty() {
        rest = name.to_string();
    }
    let lowercase = rest.to_lowercase();
    let words = if lowercase.trim() == "relative_sd" { vec!["relative_sd"] } else { split(&lowercase) };
    let (content, at) = WORDS
        .iter()
        .find_map(|(content, names)| Some((*content, words.iter().position(|w| names.contains(w))?)))?;
    let mut others: Vec<&str> =
        words.iter().enumerate().filter(|(index, _)| *index != at).map(|(_, word)| *word).collect();
    if ["hz", "khz", "rpm"].contains(&words[at]) {
        unit = unit.or_else(|| Some(cased(words[at]).into()));
    }
    if words[at] == "omega" {
        unit = unit.or_else(|| Some("rad/s".into()));
    }
    if content == Content::Magnitude && others.contains(&"db") {
        decibels = true;
        others.retain(|word| *word != "db");
    }
    if unit.is_none()
        && let Some((found, count)) = trailing_unit(&rest, &words[at + 1..])
    {
        unit = Some(found);
        others.truncate(others.len() - count);
    }
    others.retain(|word| !FUNCTIONS.contains(word) || word.len() > 1);
    Some(Column { name: name.into(), content, unit, decibels, label: others.join(" ") })
}

/// Whether the name of a column in a header says another content than the name that a request gives it.
pub(super) fn contradicts(stated: &str, named: &str) -> bool {
    let named = column(named).map(|named| named.content);
    match column(stated) {
        Some(stated) => named.is_some_and(|named| stated.content != named),
        None => is_time(stated) && named == Some(Content::Frequency),
    }
}

/// Whether a column is a time, by its name or its unit.
pub(super) fn is_time(name: &str) -> bool {
    let (rest, unit) = without_bracket(name);
    let words = ["time", "zeit", "temps", "tiempo", "t", "sec", "seconds", "second", "s", "ms"];
    let is_second = |unit: &str| parse(unit).is_ok_and(|unit| unit.dimension.name() == "a time");
    unit.is_some_and(|unit| is_second(&unit))
        || split(&rest.to_lowercase()).first().is_some_and(|first| words.contains(first))
}

fn split(lowercase: &str) -> Vec<&str> {
    lowercase
        .split(|c: char| !(c.is_alphanumeric() || "°%".contains(c)))
        .filter(|word| !word.is_empty())
        .collect()
}

/// Splits off the last bracket of a name: rest and content. A bracket with a number is part of the name.
fn without_bracket(name: &str) -> (String, Option<String>) {
    let whole = || (name.to_string(), None);
    if let Some(open) = name.char_indices().find(|(_, c)| "([".contains(*c)).map(|(at, _)| at)
        && !name.ends_with([')', ']'])
        && !name[open..].contains([')', ']'])
    {
        // An unclosed bracket, as where a program cuts long names.
        return (name[..open].trim().into(), Some(name[open + 1..].trim().into()));
    }
    let Some((last, close)) = name.char_indices().rev().find(|(_, c)| ")]".contains(*c)) else {
        return whole();
    };
    // Brackets of the other kind belong to the content.
    let open = if close == ')' { '(' } else { '[' };
    let mut depth = 0;
    for (at, character) in name[..=last].char_indices().rev() {
        depth += i32::from(character == close) - i32::from(character == open);
        if depth == 0 {
            let inside = name[at + 1..last].trim();
            if inside.is_empty() || inside.chars().all(|c| c.is_ascii_digit()) {
                return whole();
            }
            return (
                format!("{} {}", name[..at].trim(), name[last + 1..].trim()).trim().into(),
                Some(inside.into()),
            );
        }
    }
    whole()
}

/// Returns the reference of «dB re 1 m/N», «dB(m/N)» or «dB m/N», from the text after «dB».
fn reference(text: &str) -> Option<String> {
    let text = text
        .trim()
        .trim_start_matches("ref")
        .trim_start_matches("re")
        .trim_start_matches([':', '.', '='])
        .trim();
    (!text.is_empty()).then(|| text.to_string())
}

/// Spells a unit of a lower-case name.
fn cased(word: &str) -> &str {
    match word {
        "hz" => "Hz",
        "khz" => "kHz",
        "n" => "N",
        "kn" => "kN",
        "nm" => "N*m",
        other => other,
    }
}

/// Returns the unit that ends a name, and how many words it has: `frequency_rad_s`, `real_mm_n`, `phase_deg`,
/// `Frequency, rad/s`.
fn trailing_unit(name: &str, after: &[&str]) -> Option<(String, usize)> {
    // «Frequency / Hz» and «Real, mm/N» keep the unit as written.
    for sign in [" / ", ", ", " in "] {
        if let Some((_, text)) = name.rsplit_once(sign)
            && parse(text.trim()).is_ok_and(|unit| unit != Unit::ONE)
        {
            return Some((text.trim().into(), split(&text.to_lowercase()).len()));
        }
    }
    let after: Vec<&str> = after.iter().copied().filter(|word| *word != "per").collect();
    let from = (0..after.len()).find(|from| {
        let words = &after[*from..];
        // «s2» is a unit, «s1» a label.
        let may_be_unit = |word: &str| !word.trim_end_matches('2').contains(|c: char| c.is_ascii_digit());
        words.iter().all(|word| {
            may_be_unit(word) && word.starts_with(char::is_alphabetic) && parse(cased(word)).is_ok()
        })
    })?;
    let words: Vec<&str> = after[from..].iter().map(|word| cased(word)).collect();
    Some((words.join("/"), words.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str) -> (Content, Option<String>, String) {
        let column = column(name).unwrap_or_else(|| panic!("{name}"));
        (column.content, column.unit, column.label)
    }

    #[test]
    fn names_tell_content_unit_and_label() {
        let unit = |text: &str| Some(text.to_string());
        for (name, content, expected, label) in [
            ("frequency_hz", Content::Frequency, unit("Hz"), ""),
            ("frequency_rad_s", Content::Frequency, unit("rad/s"), ""),
            ("freq_khz", Content::Frequency, unit("kHz"), ""),
            ("Frequency (Hz)", Content::Frequency, unit("Hz"), ""),
            ("Frequency [rad/s]", Content::Frequency, unit("rad/s"), ""),
            ("Frequency, Hz", Content::Frequency, unit("Hz"), ""),
            ("Hz", Content::Frequency, unit("Hz"), ""),
            ("f", Content::Frequency, None, ""),
            ("omega", Content::Frequency, unit("rad/s"), ""),
            ("Real 1", Content::Real, None, "1"),
            ("Real (1)", Content::Real, None, "1"),
            ("Imag ((m/s^2)/N)", Content::Imaginary, unit("(m/s^2)/N"), ""),
            ("p2 imag (mm/N)", Content::Imaginary, unit("mm/N"), "p2"),
            ("Re(H)", Content::Real, None, ""),
            ("real_mm_n", Content::Real, unit("mm/N"), ""),
            ("imag_m_s2_n", Content::Imaginary, unit("m/s2/N"), ""),
            ("phase_deg", Content::Phase, unit("deg"), ""),
            ("Phase [°]", Content::Phase, unit("°"), ""),
            ("relative_sd", Content::RelativeSd, None, ""),
            ("coherence", Content::Coherence, None, ""),
            ("real_p1", Content::Real, None, "p1"),
            ("Real (m/N", Content::Real, unit("m/N"), ""),
            ("Real ([31m/N)", Content::Real, unit("[31m/N"), ""),
            ("Real [(m/s^2)/N]", Content::Real, unit("(m/s^2)/N"), ""),
        ] {
            assert_eq!(of(name), (content, expected, label.to_string()), "{name}");
        }
        let decibels = column("Magnitude (dB re 1 m/N)").unwrap();
        assert!(decibels.decibels && decibels.unit.as_deref() == Some("1 m/N"), "{decibels:?}");
        assert!(column("mag_db").unwrap().decibels);
        assert_eq!(column("remark"), None);
    }
}
