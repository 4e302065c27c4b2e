//! Tables that terminal and page have in common.

use super::terminal::{table, table_text};

/// A table of text cells, drawn on a terminal or on the page. The first `names` columns are headings of their
/// rows, the others numbers.
pub struct TextTable {
    pub(super) caption: String,
    pub(super) names: usize,
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<(String, Vec<String>)>,
}

impl TextTable {
    /// Returns a table without rows.
    pub fn new(caption: &str, names: usize, header: impl IntoIterator<Item = impl Into<String>>) -> Self {
        TextTable {
            caption: caption.into(),
            names,
            header: header.into_iter().map(Into::into).collect(),
            rows: Vec::new(),
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.row_of("", cells);
    }

    /// Adds a row of a class of the page's style.
    pub fn row_of(&mut self, class: &str, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push((class.into(), cells.into_iter().map(Into::into).collect()));
    }

    /// Adds a column before the n-th, with a cell for each row.
    pub fn insert(&mut self, n: usize, head: &str, cells: impl IntoIterator<Item = String>) {
        self.header.insert(n, head.into());
        self.rows.iter_mut().zip(cells).for_each(|((_, row), cell)| row.insert(n, cell));
    }

    /// Draws the table for a terminal. Rows of class `first`, which begin a group, follow a blank line.
    pub fn text(&self) -> String {
        let mut out = table(&self.header);
        for (at, (class, cells)) in self.rows.iter().enumerate() {
            if at > 0 && class == "first" {
                out.add_row([""]);
            }
            out.add_row(cells);
        }
        table_text(&out)
    }
}

/// Formats a number for a cell; a dash where there is none.
pub fn cell(x: Option<f64>, write: impl Fn(f64) -> String) -> String {
    x.filter(|x| x.is_finite()).map_or_else(|| "–".into(), write)
}
