//! Numbers, words and columns for a terminal, at most 80 columns wide.

use comfy_table::presets;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table};

/// A table whose cells wrap before it is wider than 80 columns.
pub(super) fn table(header: impl IntoIterator<Item = impl Into<String>>) -> Table {
    let header: Vec<String> = header.into_iter().map(Into::into).collect();
    let mut table = Table::new();
    let style = presets::NOTHING.header_separator(LineStyle::none().fill('─'));
    table.load_style(style).set_content_arrangement(ContentArrangement::Dynamic).set_width(80).set_header(header);
    table.column_iter_mut().skip(1).for_each(|column| {
        column.set_cell_alignment(CellAlignment::Right);
    });
    table
}

/// As text.
pub(super) fn table_text(table: &Table) -> String {
    table.to_string().lines().map(|l| format!("{}\n", l.trim_end())).collect()
}

/// Four significant figures, in powers of ten beyond 10⁻³ … 10⁵.
pub(super) fn figure(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        format!("{x:.3e}")
    } else {
        let digits = (3.0 - size.max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
        format!("{x:.digits$}")
    }
}

/// From one figure to another.
pub(super) fn range([from, to]: [f64; 2]) -> String {
    format!("{} … {}", figure(from), figure(to))
}

/// Per cent with two decimals.
pub(super) fn percent(x: f64) -> String {
    format!("{:.2} %", 100.0 * x)
}

/// Text in lines of at most 79 columns, indented as it begins, the later ones by four more.
pub fn wrapped(text: &str) -> String {
    let indent = text.len() - text.trim_start_matches(' ').len();
    let mut out = " ".repeat(indent);
    let mut width = indent;
    for (at, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if at > 0 && width + 1 + length > 79 {
            out += &format!("\n{}", " ".repeat(indent + 4));
            width = indent + 4;
        } else if at > 0 {
            out.push(' ');
            width += 1;
        }
        out.push_str(word);
        width += length;
    }
    out.push('\n');
    out
}

/// Columns of numbers under heads that wrap, so that many fit 80 columns; names stand left.
pub fn columns(header: &[String], rows: impl Iterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = rows.collect();
    let names = rows.iter().any(|row| row.first().is_some_and(|cell| cell.trim().parse::<f64>().is_err()));
    let mut out = Table::new();
    out.load_style(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_width(80).set_header(header.to_vec());
    for (at, column) in out.column_iter_mut().enumerate() {
        column.set_cell_alignment(if at == 0 && names { CellAlignment::Left } else { CellAlignment::Right });
        column.set_padding((0, 1));
    }
    rows.into_iter().for_each(|row| {
        out.add_row(row);
    });
    table_text(&out)
}
