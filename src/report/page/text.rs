//! Formats text and tables as HTML, and escapes all names that come from files.

use file_access::printable;

pub use crate::text_table::{TextTable, cell};

/// Escapes text for HTML and for labels of charts: special characters are written as entities, hidden ones as
/// their code.
///
/// The charting crate knows few entities by name, but all by number; `%{` begins a placeholder in its hover
/// labels.
pub fn escape(text: &str) -> String {
    let text = printable(text);
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&#34;"),
            '{' if out.ends_with('%') => out.push_str("&#123;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// Formats a paragraph.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escape(text))
}

/// Formats a section with a heading; empty without content.
pub fn section(id: &str, heading: &str, content: &str) -> String {
    if content.is_empty() {
        return String::new();
    }
    format!(
        "<section id=\"{id}\" aria-labelledby=\"{id}-h\">\n<h2 id=\"{id}-h\">{}</h2>\n{content}</section>\n",
        escape(heading)
    )
}

impl TextTable {
    /// Formats the table as HTML; empty without rows.
    pub fn html(&self) -> String {
        if self.rows.is_empty() {
            return String::new();
        }
        let mut out = format!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"group\" aria-label=\"{0}\"><table><caption>{0}</caption>\n<thead><tr>",
            escape(&self.caption)
        );
        for (at, head) in self.header.iter().enumerate() {
            let class = if at < self.names { "" } else { " class=\"n\"" };
            out += &format!("<th scope=\"col\"{class}>{}</th>", escape(head));
        }
        out += "</tr></thead>\n<tbody>\n";
        for (class, cells) in &self.rows {
            out += &if class.is_empty() { "<tr>".to_string() } else { format!("<tr class=\"{class}\">") };
            for (at, cell) in cells.iter().enumerate() {
                out += &match at < self.names {
                    true => format!("<th scope=\"row\">{}</th>", escape(cell)),
                    false => format!("<td class=\"n\">{}</td>", escape(cell)),
                };
            }
            out += "</tr>\n";
        }
        out + "</tbody></table></div>\n"
    }
}

/// Rounds a number to `digits` significant digits. Further digits are invisible in charts and enlarge the
/// page.
pub fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_escaped() {
        let mut table = TextTable::new("a <caption>", 1, ["<th>", "x"]);
        table.row(["<script>alert(1)</script>", "\"'&"]);
        let html = table.html();
        assert!(!html.contains("<script>") && html.contains("&lt;script&gt;alert(1)"), "{html}");
        assert!(html.contains("&#34;&#39;&amp;"), "{html}");
        assert_eq!(escape("a\u{202e}b\u{1b}[1m %{x} {y}"), "a\\u{202e}b\\u{1b}[1m %&#123;x} {y}");
    }

    #[test]
    fn numbers_are_rounded() {
        assert_eq!(rounded(1.234_567_8e-9, 5), 1.2346e-9);
        assert_eq!(rounded(0.0, 5), 0.0);
    }
}
