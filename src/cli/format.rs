//! A table of results on stdout, in the form that was asked for.

use clap::ValueEnum;
use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

/// What results are printed as.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Lines and columns, for the eye
    #[default]
    Table,
    /// The result file itself
    Json,
    /// Comma-separated values under a line of names
    Csv,
    /// A Markdown table, for a comment on a change
    Markdown,
}

/// Rows under a header; the first column is text, the others are figures.
pub struct Sheet {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl Sheet {
    /// The sheet as text, without a line break at its end; JSON is no sheet's.
    pub fn text(&self, format: Format) -> String {
        let preset = match format {
            Format::Csv => return self.csv(),
            Format::Markdown => presets::ASCII_MARKDOWN,
            Format::Table | Format::Json => presets::UTF8_HORIZONTAL_ONLY,
        };
        let mut table = Table::new();
        table.load_style(preset);
        table.set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(&self.header);
        for row in &self.rows {
            // A bar would end the cell.
            let cell = |cell: &String| match format {
                Format::Markdown => cell.replace('|', "\\|"),
                _ => cell.clone(),
            };
            table.add_row(row.iter().map(cell));
        }
        for column in table.column_iter_mut().skip(1) {
            column.set_cell_alignment(CellAlignment::Right);
        }
        table.to_string()
    }

    /// Fields with commas, quotes or line breaks stand in quotes, as RFC 4180 has it.
    fn csv(&self) -> String {
        let field = |text: &String| match text.contains([',', '"', '\n']) {
            true => format!("\"{}\"", text.replace('"', "\"\"")),
            false => text.clone(),
        };
        let line = |cells: &Vec<String>| cells.iter().map(field).collect::<Vec<_>>().join(",");
        let lines: Vec<String> =
            std::iter::once(&self.header).chain(&self.rows).map(line).collect();
        lines.join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn csv_quotes_what_must_be_quoted() {
        let sheet = Sheet {
            header: vec!["a".into(), "b".into()],
            rows: vec![vec!["1 drop, fast".into(), "say \"no\"".into()]],
        };
        assert_eq!(sheet.text(Format::Csv), "a,b\n\"1 drop, fast\",\"say \"\"no\"\"\"");
        assert!(sheet.text(Format::Markdown).contains("| 1 drop, fast |"));
    }
}
