//! Messages that stay one line, whatever they quote.

/// `text` with its control characters escaped: a file's name may hold line breaks, an error
/// message may not.
pub fn one_line(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut line, c| {
        if c.is_control() {
            line.extend(c.escape_default());
        } else {
            line.push(c);
        }
        line
    })
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn control_characters_do_not_break_the_line() {
        assert_eq!(one_line("a\nb\t\u{1b}[2J é"), "a\\nb\\t\\u{1b}[2J é");
    }
}
