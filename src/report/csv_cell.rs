//! Cells of CSV tables.

use std::borrow::Cow;

/// Quotes a text as a cell of a CSV table where it must be: with a separator, a quote, a line end, or a space
/// at its ends.
pub fn csv_cell(text: &str) -> Cow<'_, str> {
    let must =
        text.contains([',', ';', '"', '\n', '\r', '\t']) || text.trim() != text || text.starts_with('#');
    if must { Cow::Owned(format!("\"{}\"", text.replace('"', "\"\""))) } else { Cow::Borrowed(text) }
}

#[cfg(test)]
mod tests {
    use super::csv_cell;

    #[test]
    fn only_cells_that_need_it_are_quoted() {
        assert_eq!(csv_cell("l1"), "l1");
        assert_eq!(csv_cell("table, left"), "\"table, left\"");
        assert_eq!(csv_cell("3\" screw"), "\"3\"\" screw\"");
        assert_eq!(csv_cell("two\nlines"), "\"two\nlines\"");
    }
}
