//! Numbers, words and columns for a terminal, as wide as the terminal is.

use std::sync::LazyLock;

use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table};
use terminal_size::{Width, terminal_size_of};

/// Width (columns) of output that goes to a file or a pipe, where no terminal states one.
const PLAIN_WIDTH: usize = 80;
/// Least width (columns): below, tables break words.
const LEAST_WIDTH: usize = 40;
/// Greatest width (columns) of running text: longer lines are hard to read.
const PROSE_WIDTH: usize = 100;

/// Width (columns) of the terminal on stdout; tests have none.
pub fn width() -> usize {
    static WIDTH: LazyLock<usize> = LazyLock::new(|| match terminal_size_of(std::io::stdout()) {
        Some((Width(columns), _)) if !cfg!(test) => usize::from(columns).max(LEAST_WIDTH),
        _ => PLAIN_WIDTH,
    });
    *WIDTH
}

/// Starts a table whose cells wrap before it is wider than the terminal.
pub(super) fn table(header: impl IntoIterator<Item = impl Into<String>>) -> Table {
    let header: Vec<String> = header.into_iter().map(Into::into).collect();
    let mut table = Table::new();
    let style = presets::NOTHING.header_separator(LineStyle::none().fill('─'));
    table
        .load_style(style)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(width() as u16)
        .set_header(header);
    table.column_iter_mut().skip(1).for_each(|column| {
        column.set_cell_alignment(CellAlignment::Right);
    });
    table
}

/// Draws a table as text.
pub(super) fn table_text(table: &Table) -> String {
    table.to_string().lines().map(|l| format!("{}\n", l.trim_end())).collect()
}

/// How a number is written: its decimals, and the power of ten it is divided by.
#[derive(Clone, Copy)]
struct Layout {
    decimals: usize,
    power: Option<i32>,
}

impl Layout {
    /// Shows a number of this size with so many significant figures; powers of ten beyond 10⁻³ … 10⁵.
    fn of(size: f64, figures: i32) -> Layout {
        if size == 0.0 || !size.is_finite() {
            return Layout { decimals: 0, power: None };
        }
        let power = power_of(size);
        if (1e-3..1e5).contains(&size) {
            Layout { decimals: (figures - 1 - power).clamp(0, 12) as usize, power: None }
        } else {
            Layout { decimals: (figures - 1).max(0) as usize, power: Some(power) }
        }
    }

    /// Writes a number; zero has no sign.
    fn write(self, x: f64) -> String {
        let decimals = self.decimals;
        let text = format!("{:.decimals$}", self.power.map_or(x, |power| x / 10_f64.powi(power)));
        let is_zero = text.chars().all(|c| ['-', '0', '.'].contains(&c));
        let text = if is_zero { text.trim_start_matches('-') } else { &text };
        self.power.filter(|_| !is_zero).map_or_else(|| text.to_string(), |power| format!("{text}e{power}"))
    }
}

/// Power of ten of the first figure.
fn power_of(x: f64) -> i32 {
    // By way of the decimal digits: log10 of 0.001 is a little off −3.
    format!("{:e}", x.abs()).split_once('e').and_then(|(_, power)| power.parse().ok()).unwrap_or(0)
}

/// Writes a number with four significant figures, in powers of ten beyond 10⁻³ … 10⁵.
pub(super) fn figure(x: f64) -> String {
    // Rounded first: 9.9996 is written 10.00, not 10.000.
    let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
    Layout::of(rounded.abs(), 4).write(rounded)
}

/// Writes a range from one figure to another.
pub(super) fn range([from, to]: [f64; 2]) -> String {
    format!("{} … {}", figure(from), figure(to))
}

/// Layout of a value known to a deviation: two figures of the deviation are shown, and of the value no fewer
/// than `least`.
fn layout_within(value: f64, deviation: f64, least: i32) -> Layout {
    let size = value.abs().max(deviation);
    Layout::of(size, (power_of(size) - power_of(deviation) + 2).clamp(least, 9))
}

/// Writes a value and the interval it lies in with the same decimals.
pub(super) fn with_interval(value: f64, [from, to]: [f64; 2]) -> (String, String) {
    let half = 0.5 * (to - from).abs();
    // An interval wider than its value says nothing of the value's digits.
    if !half.is_finite() || half == 0.0 || half > value.abs() {
        return (figure(value), range([from, to]));
    }
    let layout = layout_within(value, half, 3);
    (layout.write(value), format!("{} … {}", layout.write(from), layout.write(to)))
}

/// Writes a value and its deviation with the same decimals: 97.930 ± 0.002.
pub(super) fn with_deviation(value: f64, deviation: f64) -> String {
    if !deviation.is_finite() || deviation == 0.0 {
        return format!("{} ± {}", figure(value), figure(deviation));
    }
    let layout = layout_within(value, deviation.abs(), 2);
    format!("{} ± {}", layout.write(value), layout.write(deviation.abs()))
}

/// Writes a share in per cent with two decimals; a share below 0.1 % with two figures.
pub(super) fn percent(x: f64) -> String {
    let size = (100.0 * x).abs();
    if size == 0.0 {
        "0 %".into()
    } else if size < 1e-4 {
        "<0.0001 %".into()
    } else if size < 0.095 {
        format!(
            "{} %",
            Layout { decimals: (1 - power_of(size)).max(0) as usize, power: None }.write(100.0 * x)
        )
    } else {
        format!("{:.2} %", 100.0 * x)
    }
}

/// Writes a number with two significant figures and its sign; zero has none.
pub(super) fn signed(x: f64) -> String {
    let rounded: f64 = format!("{x:.1e}").parse().unwrap_or(x);
    let sign = if rounded > 0.0 { "+" } else { "" };
    format!("{sign}{}", Layout::of(rounded.abs(), 2).write(rounded))
}

/// Writes the share of a gap that a model closes; «none» where the gap grows.
pub(super) fn share_closed(closed: Option<f64>) -> String {
    match closed {
        None => "–".into(),
        Some(x) if x < -0.005 => "none".into(),
        Some(x) if x < 0.005 => "0 %".into(),
        Some(x) if x > 0.9 => format!("{:.1} %", 100.0 * x),
        Some(x) => format!("{:.0} %", 100.0 * x),
    }
}

/// Writes a probability: four decimals, or below what.
pub(super) fn probability(p: f64) -> String {
    if p < 1e-4 { "<0.0001".into() } else { format!("{p:.4}") }
}

/// Writes a unit as it is printed: N·m for N*m.
pub(super) fn unit(unit: &str) -> String {
    if unit == "1" { String::new() } else { unit.replace('*', "·").replace("^2", "²") }
}

/// Joins names as «a, b and c», with `last` as the last conjunction.
pub(super) fn listed(names: &[String], last: &str) -> String {
    match names {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., end] => format!("{} {last} {end}", first.join(", ")),
    }
}

/// Wraps text to the terminal, at most 100 columns, indented as it begins, later lines by four more.
pub fn wrapped(text: &str) -> String {
    let most = width().min(PROSE_WIDTH) - 1;
    let indent = text.len() - text.trim_start_matches(' ').len();
    let mut out = " ".repeat(indent);
    let mut column = indent;
    for (at, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if at > 0 && column + 1 + length > most {
            out += &format!("\n{}", " ".repeat(indent + 4));
            column = indent + 4;
        } else if at > 0 {
            out.push(' ');
            column += 1;
        }
        out.push_str(word);
        column += length;
    }
    out.push('\n');
    out
}

/// Shortens numbers with more than 24 digits to powers of ten.
pub fn brief_numbers(text: &str) -> String {
    if !text.as_bytes().windows(24).any(|window| window.iter().all(|c| c.is_ascii_digit())) {
        return text.to_string();
    }
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut out = String::new();
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let end = rest[start..].find(|c: char| !is_part(c)).map_or(rest.len(), |length| start + length);
        let number = &rest[start..end];
        out += &rest[..start];
        match number.parse::<f64>().ok().filter(|_| number.len() > 24) {
            Some(x) => out += &format!("{x:e}"),
            None => out += number,
        }
        rest = &rest[end..];
    }
    out + rest
}

/// Draws columns of numbers under heads that wrap, so that many fit the terminal; names stand left.
pub fn columns(header: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = rows.collect();
    let names = rows.iter().any(|row| row.first().is_some_and(|cell| cell.trim().parse::<f64>().is_err()));
    let mut out = Table::new();
    out.load_style(presets::NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_width(width() as u16)
        .set_header(header.to_vec());
    for (at, column) in out.column_iter_mut().enumerate() {
        column.set_cell_alignment(if at == 0 && names { CellAlignment::Left } else { CellAlignment::Right });
        column.set_padding((0, 1));
    }
    rows.into_iter().for_each(|row| {
        out.add_row(row);
    });
    table_text(&out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_shortened() {
        assert_eq!(brief_numbers(&format!("a {} m, {}; 12.", 1e300, 5e-324)), "a 1e300 m, 5e-324; 12.");
        assert_eq!(brief_numbers("0123456789abcdef0123456789"), "0123456789abcdef0123456789");
    }

    #[test]
    fn zero_has_no_sign_and_small_shares_keep_figures() {
        assert_eq!(
            ["0 %", "0 %", "0.0010 %", "-0.050 %", "12.35 %"],
            [0.0, -0.0, 1e-5, -5e-4, 0.12345].map(percent).each_ref().map(String::as_str)
        );
        assert_eq!(
            ["0", "0.001000", "9.999e-4", "99990", "1.000e5", "10.00"],
            [-0.0, 1e-3, 9.9994e-4, 99_990.0, 1e5, 9.9996].map(figure).each_ref().map(String::as_str)
        );
        assert_eq!(
            ["–", "none", "0 %", "76 %", "99.3 %"],
            [None, Some(-11.97), Some(-0.001), Some(0.76), Some(0.993)]
                .map(share_closed)
                .each_ref()
                .map(String::as_str)
        );
    }

    #[test]
    fn names_are_joined_with_a_conjunction() {
        assert_eq!(listed(&["a".into(), "b".into(), "c".into()], "and"), "a, b and c");
    }

    #[test]
    fn signed_numbers_have_two_figures() {
        assert_eq!(
            ["+0.17", "-0.0042", "0", "-12", "+3.2e-4"],
            [0.174, -0.0042, -0.0, -12.3, 3.2e-4].map(signed).each_ref().map(String::as_str)
        );
    }

    #[test]
    fn a_value_has_the_decimals_of_its_deviation() {
        assert_eq!(with_deviation(97.93012, 0.00213), "97.9301 ± 0.0021");
        assert_eq!(with_deviation(0.0, 1.5e-6), "0.0 ± 1.5e-6");
        assert_eq!(with_deviation(12.0, 340.0), "12 ± 340");
        assert_eq!(with_interval(3.98e7, [3.293e7, 6.607e7]), ("3.98e7".into(), "3.29e7 … 6.61e7".into()));
        assert_eq!(with_interval(0.2766, [0.21, 0.3616]), ("0.277".into(), "0.210 … 0.362".into()));
        assert_eq!(with_interval(97.93, [97.928, 97.932]), ("97.9300".into(), "97.9280 … 97.9320".into()));
    }
}
