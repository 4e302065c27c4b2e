//! Layout of a table: separator, decimal sign, header and first line of numbers.

/// Characters that begin a comment line.
const COMMENT: [char; 3] = ['#', '%', '!'];

/// Number of lines in which a table must begin.
const LONGEST_HEADER: usize = 1000;

/// Separator of the cells of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Separator {
    Character(char),
    /// Any number of blanks or tabs.
    Blanks,
}

/// Layout of a table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub separator: Separator,
    /// Whether numbers have a decimal comma.
    pub comma: bool,
    /// Names of the columns; `None` without a header line.
    pub header: Option<Vec<String>>,
    /// Line of the header, from 1.
    pub header_line: u64,
    /// Index of the first line of numbers.
    pub first: usize,
    /// Number of cells in a line.
    pub cells: usize,
}

impl Separator {
    /// Returns the cells of a line, without surrounding blanks and quotes.
    pub fn cells(self, line: &str) -> impl Iterator<Item = &str> {
        let pieces: Box<dyn Iterator<Item = &str>> = match self {
            Separator::Character(separator) => Box::new(line.split(separator)),
            Separator::Blanks => Box::new(line.split_whitespace()),
        };
        pieces.map(|cell| cell.trim().trim_matches('"').trim())
    }

    /// Returns the cells of a header line, in which a quoted name may contain the separator.
    fn names(self, line: &str) -> Vec<String> {
        let Separator::Character(separator) = self else {
            return self.cells(line).map(String::from).collect();
        };
        let (mut names, mut is_quoted) = (vec![String::new()], false);
        for character in line.chars() {
            match character {
                '"' => is_quoted = !is_quoted,
                c if c == separator && !is_quoted => names.push(String::new()),
                c => {
                    if let Some(name) = names.last_mut() {
                        name.push(c);
                    }
                }
            }
        }
        names.into_iter().map(|name| name.trim().to_string()).collect()
    }
}

/// Value of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell {
    Number(f64),
    /// No value: empty, NaN, infinite, or filled with asterisks.
    Missing,
    Text,
}

/// Reads a cell. A decimal comma is read where `comma`.
pub(super) fn cell(text: &str, comma: bool) -> Cell {
    let parse = |text: &str| text.parse::<f64>().ok();
    let number = if comma && text.contains(',') && !text.contains('.') {
        parse(&text.replacen(',', ".", 1))
    } else {
        parse(text)
    };
    match number
        .or_else(|| text.contains(['D', 'd']).then(|| parse(&text.replace(['D', 'd'], "e"))).flatten())
    {
        Some(number) if number.is_finite() => return Cell::Number(number),
        Some(_) => return Cell::Missing,
        None => {}
    }
    let word = text.trim_start_matches(['+', '-']).to_lowercase();
    let is_missing = [
        "", "na", "n/a", "#n/a", "nan(ind)", "null", "none", "1.#qnan", "1.#ind", "1.#inf", "1.#qnb",
        "#num!", "#div/0!",
    ];
    if is_missing.contains(&word.as_str()) || word.bytes().all(|byte| byte == b'*') {
        Cell::Missing
    } else {
        Cell::Text
    }
}

/// Whether a line is empty or a comment.
pub(super) fn is_void(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with(COMMENT) || line.starts_with("//")
}

/// Number of cells of a line of numbers; `None` for other lines.
fn numbers(line: &str, separator: Separator, comma: bool) -> Option<usize> {
    let (mut count, mut known) = (0, 0);
    for text in separator.cells(line) {
        count += 1;
        match cell(text, comma) {
            Cell::Number(_) => known += 1,
            Cell::Missing if count > 1 => {}
            Cell::Missing | Cell::Text => return None,
        }
    }
    (count >= 2 && known >= 1).then_some(count)
}

/// Finds the layout of a table; `None` where no line consists of numbers.
///
/// The first line of numbers decides: it has at least two cells. The header is the last line with
/// text before it that has as many cells; a line of units below the names is added to them in brackets.
pub(super) fn layout(text: &str) -> Option<Layout> {
    // A comma that does not separate is a decimal comma.
    let forms = [
        (Separator::Character(';'), true),
        (Separator::Character('\t'), true),
        (Separator::Character(','), false),
        (Separator::Blanks, true),
    ];
    let found = forms
        .into_iter()
        .filter_map(|(separator, comma)| Some((separator, comma, first_numbers(text, separator, comma)?)));
    // The first of several that begin in the same line.
    let (separator, comma, (first, cells)) = found.min_by_key(|(_, _, (first, _))| *first)?;
    let before: Vec<(usize, &str)> = text.lines().enumerate().take(first).collect();
    let (header, header_line) = header(&before, separator, cells);
    Some(Layout { separator, comma, header, header_line, first, cells })
}

/// Returns index and number of cells of the first line of numbers.
fn first_numbers(text: &str, separator: Separator, comma: bool) -> Option<(usize, usize)> {
    let lines = || text.lines().enumerate().take(LONGEST_HEADER).filter(|(_, line)| !is_void(line));
    lines().find_map(|(index, line)| {
        let cells = numbers(line, separator, comma)?;
        let mut after = text
            .lines()
            .skip(index + 1)
            .filter(|line| !is_void(line))
            .map(|line| numbers(line, separator, comma));
        let next = after.next().flatten();
        // Numbers above the table, such as a date: the two lines below agree with each other alone.
        let is_above = next.is_some_and(|next| next != cells) && after.next().flatten() == next;
        (!is_above).then_some((index, cells))
    })
}

/// Returns the names of the columns and their line.
fn header(before: &[(usize, &str)], separator: Separator, cells: usize) -> (Option<Vec<String>>, u64) {
    // Names may contain blanks, so that another separator may be used for them.
    let separators = [
        separator,
        Separator::Character('\t'),
        Separator::Character(';'),
        Separator::Character(','),
        Separator::Blanks,
    ];
    let fitting = |line: &str| {
        let line = line.trim_start_matches('\u{feff}').trim_start_matches(COMMENT).trim_matches(['\r', '\n']);
        let split = |s: &Separator| {
            Some(s.names(line))
                .filter(|names| names.len() == cells && names.iter().any(|name| !name.is_empty()))
        };
        separators.iter().find_map(split)
    };
    let mut above = before.iter().rev().filter(|(_, line)| !line.trim().is_empty());
    let Some((index, line)) = above.next() else { return (None, 1) };
    let Some(names) = fitting(line) else { return (None, *index as u64 + 1) };
    let is_unit = |name: &str| {
        let inside = name.trim_matches(['(', ')', '[', ']']);
        name.is_empty()
            || name == "-"
            || [name, inside].iter().any(|text| numeric::unit::parse(text).is_ok())
            || inside.to_lowercase().starts_with("db")
    };
    if names.iter().all(|name| is_unit(name))
        && let Some((_, line)) = above.next()
        && let Some(titles) = fitting(line)
    {
        let with_unit = |(title, unit): (String, &String)| match unit.trim_matches(['[', ']', '-']) {
            "" => title,
            unit => format!("{title} ({unit})"),
        };
        return (Some(titles.into_iter().zip(&names).map(with_unit).collect()), *index as u64 + 1);
    }
    (Some(names), *index as u64 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> (Separator, bool, Vec<String>, usize) {
        let layout = layout(text).unwrap();
        (layout.separator, layout.comma, layout.header.unwrap_or_default(), layout.first)
    }

    #[test]
    fn separator_decimal_sign_and_header_are_found() {
        use Separator::{Blanks, Character};
        let names = |list: &[&str]| list.iter().map(|n| (*n).to_string()).collect::<Vec<_>>();
        assert_eq!(found("f,re,im\n1,2,3\n"), (Character(','), false, names(&["f", "re", "im"]), 1));
        assert_eq!(found("f;re;im\n1,5;2;3\n2;1;1\n"), (Character(';'), true, names(&["f", "re", "im"]), 1));
        assert_eq!(found("f re im\n1.5 2 3\n2 1 1\n"), (Blanks, true, names(&["f", "re", "im"]), 1));
        assert_eq!(found("1,5 2,5 3,5\n"), (Blanks, true, Vec::new(), 0));
        assert_eq!(found("# test 7\n# f re im\n1 2 3\n"), (Blanks, true, names(&["f", "re", "im"]), 2));
        assert_eq!(
            found("Test of 2020\nDate;1.1.2020\n\nFrequency;Real;Imag\nHz;m/N;m/N\n1.5;2;3\n2.5;2;3\n"),
            (Character(';'), true, names(&["Frequency (Hz)", "Real (m/N)", "Imag (m/N)"]), 5)
        );
        assert_eq!(found("\"Freq, Hz\",re,im\n1,2,3\n").2[0], "Freq, Hz");
        assert_eq!(layout("no numbers here\n"), None);
    }

    #[test]
    fn cells_are_numbers_missing_or_text() {
        assert_eq!(cell("1.5D-3", false), Cell::Number(1.5e-3));
        assert_eq!(cell("1,5", true), Cell::Number(1.5));
        assert_eq!(cell("1.234,5", true), Cell::Text);
        for text in ["", "NaN", "-inf", "********", "1.#QNAN", "N/A"] {
            assert_eq!(cell(text, false), Cell::Missing, "{text}");
        }
        assert_eq!(cell("abc", false), Cell::Text);
    }
}
