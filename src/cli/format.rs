//! A table of results on stdout, in the form that was asked for.

use clap::ValueEnum;
use comfy_table::{CellAlignment, ContentArrangement, LineStyle, Table, TableStyle, presets};
use console::Term;

/// Tables for the eye: lines above, below and under the header.
const TABLE: TableStyle = presets::UTF8_HORIZONTAL_ONLY.row_separator(LineStyle::none());

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
    /// How many of the first columns name a row.
    pub names: usize,
    /// Names of the columns.
    pub header: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

impl Sheet {
    /// The sheet as text, without a line break at its end; JSON is no sheet's. On a terminal that is too narrow for
    /// its columns it is several tables under each other, each with the columns that name a row.
    pub fn text(&self, format: Format) -> String {
        let terminal = Term::stdout();
        let size = terminal.is_term().then(|| terminal.size_checked()).flatten();
        self.text_within(format, size.map_or(usize::MAX, |(_, columns)| columns.into()))
    }

    fn text_within(&self, format: Format, most: usize) -> String {
        match format {
            Format::Csv => self.csv(),
            Format::Markdown => self.table(format, presets::ASCII_MARKDOWN),
            Format::Table | Format::Json => {
                let parts = self.parts(most);
                let texts = parts.iter().map(|part| part.table(format, TABLE));
                texts.collect::<Vec<_>>().join("\n")
            }
        }
    }

    /// The names with as many of the other columns as go into `most` characters, then with the next, and so on.
    fn parts(&self, most: usize) -> Vec<Self> {
        // With the spaces before, behind and between.
        let width = |column: usize| {
            let cells = self.rows.iter().chain([&self.header]).filter_map(|row| row.get(column));
            3 + cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let names: Vec<usize> = (0..self.names).collect();
        let of_names = (0..self.names).map(width).fold(0, usize::saturating_add);
        let mut parts = vec![names.clone()];
        let mut taken = of_names;
        for column in self.names..self.header.len() {
            let is_full = parts.last().is_some_and(|part| part.len() > self.names);
            if taken + width(column) > most && is_full {
                parts.push(names.clone());
                taken = of_names;
            }
            taken = taken.saturating_add(width(column));
            if let Some(part) = parts.last_mut() {
                part.push(column);
            }
        }
        let pick = |row: &Vec<String>, part: &[usize]| -> Vec<String> {
            part.iter().filter_map(|column| row.get(*column).cloned()).collect()
        };
        let sheet = |part: &Vec<usize>| Self {
            names: self.names,
            header: pick(&self.header, part),
            rows: self.rows.iter().map(|row| pick(row, part)).collect(),
        };
        parts.iter().map(sheet).collect()
    }

    fn table(&self, format: Format, preset: TableStyle) -> String {
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
            names: 1,
            header: vec!["a".into(), "b".into()],
            rows: vec![vec!["1 drop, fast".into(), "say \"no\"".into()]],
        };
        assert_eq!(sheet.text(Format::Csv), "a,b\n\"1 drop, fast\",\"say \"\"no\"\"\"");
        assert!(sheet.text(Format::Markdown).contains("| 1 drop, fast |"));
    }

    #[test]
    fn rows_are_not_ruled_apart() {
        let row = || vec!["a".to_string()];
        let sheet = Sheet { names: 1, header: row(), rows: vec![row(), row(), row()] };
        let text = sheet.text_within(Format::Table, 80);
        assert_eq!(
            text.lines().map(|line| line.contains(['─', '═'])).collect::<Vec<_>>(),
            [true, false, true, false, false, false, true],
            "{text}"
        );
    }

    #[test]
    fn tables_fit_the_terminal() {
        let figures = |n: usize| (0..20).map(move |c| (1000 * c + n).to_string());
        let row =
            |n: usize| ["row".into(), format!("no. {n}")].into_iter().chain(figures(n)).collect();
        let header =
            [const { String::new() }; 2].into_iter().chain((0..20).map(|c| format!("column {c}")));
        let sheet = Sheet { names: 2, header: header.collect(), rows: (0..3).map(row).collect() };
        for most in [40, 80, 170] {
            let text = sheet.text_within(Format::Table, most);
            assert!(text.lines().all(|line| line.chars().count() <= most), "{most}:\n{text}");
            assert!((0..20).all(|c| text.contains(&format!("column {c} "))), "{most}:\n{text}");
            // Each part tells what its rows are.
            let parts = text.lines().filter(|line| line.contains("column")).count();
            assert_eq!(text.matches("no. 2").count(), parts, "{most}:\n{text}");
        }
    }
}
