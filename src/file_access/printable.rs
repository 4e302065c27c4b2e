//! Text from outside, escaped for terminals, messages and pages.

/// Whether a character moves the cursor, changes the direction of text or is invisible: control characters,
/// direction marks and overrides, line and paragraph separators, zero-width characters, tags.
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}'
                | '\u{61c}'
                | '\u{180e}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{feff}'
                | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

/// Escapes hidden characters except line ends and tabs, as `\u{202e}`.
pub fn printable(text: &str) -> String {
    escaped(text, |c| !matches!(c, '\n' | '\t') && is_hidden(c))
}

/// Escapes hidden characters; the text becomes one line. A tab becomes a space.
pub fn one_line(text: &str) -> String {
    escaped(&text.replace('\t', " "), is_hidden)
}

/// Returns a text of at most `most` characters on one line, for quoting in a message.
pub fn shortened(text: &str, most: usize) -> String {
    let text = one_line(text);
    if text.chars().count() <= most { text } else { text.chars().take(most).chain(['…']).collect() }
}

fn escaped(text: &str, hidden: impl Fn(char) -> bool) -> String {
    if !text.chars().any(&hidden) {
        return text.to_string();
    }
    text.chars().fold(String::with_capacity(text.len()), |mut out, c| {
        match c {
            '\n' if hidden(c) => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            c if hidden(c) => out.extend(c.escape_unicode()),
            c => out.push(c),
        }
        out
    })
}

/// Escapes hidden characters in JSON text, where they stand only inside strings; its value remains the same.
pub fn escape_json(json: String) -> String {
    let hidden = |c: char| c != '\n' && is_hidden(c);
    if !json.chars().any(hidden) {
        return json;
    }
    json.chars().fold(String::with_capacity(json.len()), |mut out, c| {
        if hidden(c) {
            c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| out.push_str(&format!("\\u{unit:04x}")));
        } else {
            out.push(c);
        }
        out
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hidden_characters_are_escaped_and_others_kept() {
        assert_eq!(printable("µm · «Führung» 軸 é\n"), "µm · «Führung» 軸 é\n");
        assert_eq!(
            one_line("a\u{1b}[31mb\u{202e}c\r\nd\te\u{9b}"),
            "a\\u{1b}[31mb\\u{202e}c\\r\\nd e\\u{9b}"
        );
        assert_eq!(shortened("abcdef", 3), "abc…");
        let json = format!("{{\"a\": \"{}\u{e0041}\"}}\n", "\u{202e}\u{7f}");
        assert_eq!(escape_json(json), "{\"a\": \"\\u202e\\u007f\\udb40\\udc41\"}\n");
    }
}
