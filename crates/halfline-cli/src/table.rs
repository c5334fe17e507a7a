//! A few aligned lines for people.

use std::fmt::Write;

use anstyle::{AnsiColor, Style};

use crate::report::Skipped;
use crate::units;

const LABEL: Style = AnsiColor::Cyan.on_default();
const NOTE: Style = Style::new().dimmed();

/// Lines of a label, a figure and a note, under a title. Styled: whoever prints it to anything
/// but a terminal strips that.
pub struct Table {
    title: String,
    rows: Vec<Row>,
}

struct Row {
    label: String,
    figure: String,
    note: String,
}

impl Table {
    /// An empty table.
    pub fn new(title: impl ToString) -> Table {
        Table { title: title.to_string(), rows: Vec::new() }
    }

    /// Adds a line.
    pub fn row(&mut self, label: &str, figure: impl ToString, note: impl ToString) -> &mut Table {
        self.rows.push(Row {
            label: label.into(),
            figure: figure.to_string(),
            note: note.to_string(),
        });
        self
    }

    /// Adds a line about the triangles that were kept out of the tree, if there are any.
    pub fn skipped(&mut self, skipped: Skipped) -> &mut Table {
        let count = |value: usize| units::count(value as u64);
        if skipped.total() > 0 {
            let note = format!(
                "{} without area, {} not finite: no ray can hit them",
                count(skipped.degenerate),
                count(skipped.non_finite)
            );
            self.row("skipped", count(skipped.total()), note);
        }
        self
    }

    /// The lines, figures flush right.
    pub fn print(&self) -> String {
        let width = |of: fn(&Row) -> &String| {
            self.rows.iter().map(|row| of(row).chars().count()).max().unwrap_or(0)
        };
        let (labels, figures) = (width(|row| &row.label), width(|row| &row.figure));
        let bold = Style::new().bold();
        let mut text = format!("{bold}{}{bold:#}\n", self.title);
        for Row { label, figure, note } in &self.rows {
            let _ = write!(text, "  {LABEL}{label:<labels$}{LABEL:#}  {figure:>figures$}");
            if !note.is_empty() {
                let _ = write!(text, "  {NOTE}{note}{NOTE:#}");
            }
            text.push('\n');
        }
        text
    }
}

/// A bar as long as `share`, 1 being 20 characters, to an eighth of a character.
pub fn bar(share: f64) -> String {
    const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];
    let eighths = (share * 160.0).ceil() as usize;
    "█".repeat(eighths / 8) + EIGHTHS[eighths % 8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_grow_by_eighths() {
        assert_eq!(bar(1.0), "█".repeat(20));
        assert_eq!((bar(0.0).as_str(), bar(1e-9).as_str(), bar(0.075).as_str()), ("", "▏", "█▌"));
    }

    #[test]
    fn columns_align() {
        let mut table = Table::new("scan.ply");
        table.row("a", "1,000", "").row("long", 7, "of 8");
        let plain = anstream::adapter::strip_str(&table.print()).to_string();
        assert_eq!(plain, "scan.ply\n  a     1,000\n  long      7  of 8\n");
    }
}
