//! A table split into cells, each with the line and column where it stands.

use super::CsvError;
use std::borrow::Cow;

/// One cell.
#[derive(Debug, Clone)]
pub(crate) struct Cell<'a> {
    pub column: usize,
    pub text: Cow<'a, str>,
}

/// One row.
#[derive(Debug, Clone)]
pub(crate) struct Row<'a> {
    pub line: usize,
    pub cells: Vec<Cell<'a>>,
}

/// A table: names of columns, and rows of that width.
#[derive(Debug)]
pub(crate) struct Table<'a> {
    /// Comment lines, without the `#`.
    pub comments: Vec<(usize, &'a str)>,
    pub names: Row<'a>,
    pub rows: Vec<Row<'a>>,
}

/// The text of a file, without its byte-order mark.
pub(crate) fn text(bytes: &[u8]) -> Result<&str, CsvError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    std::str::from_utf8(text).map_err(|error| {
        let at = bytes.len() - text.len() + error.valid_up_to();
        CsvError::NotText { line: bytes[..at].split(|byte| *byte == b'\n').count(), at }
    })
}

impl<'a> Table<'a> {
    /// Splits text into cells.
    pub fn read(text: &'a str) -> Result<Self, CsvError> {
        let mut cursor = Cursor { text, at: 0, line: 1, line_start: 0 };
        let mut comments = Vec::new();
        let mut names: Option<Row<'a>> = None;
        let mut rows = Vec::new();
        let mut blank = None;
        while !cursor.done() {
            let line = cursor.line;
            let rest = cursor.rest_of_line().trim();
            if rest.is_empty() {
                blank = blank.or(Some(line)).filter(|_| names.is_some());
                cursor.next_line();
                continue;
            }
            if let Some(comment) = rest.strip_prefix('#') {
                comments.push((line, comment.trim()));
                cursor.next_line();
                continue;
            }
            if let Some(line) = blank {
                return Err(CsvError::Blank { line });
            }
            let row = cursor.row()?;
            match &names {
                None => names = Some(row),
                Some(names) if names.cells.len() == row.cells.len() => rows.push(row),
                Some(names) => {
                    return Err(CsvError::Width {
                        line,
                        names_line: names.line,
                        expected: names.cells.len(),
                        found: row.cells.len(),
                    });
                }
            }
        }
        let names = names.ok_or(CsvError::Empty)?;
        let mut seen = std::collections::BTreeSet::new();
        for cell in &names.cells {
            let problem = if cell.text.is_empty() {
                "it has no name"
            } else if !seen.insert(cell.text.as_ref()) {
                "the name stands twice"
            } else {
                continue;
            };
            return Err(column_error(&names, cell, problem));
        }
        Ok(Self { comments, names, rows })
    }

    /// The table, where it has rows.
    pub fn with_rows(self) -> Result<Self, CsvError> {
        if self.rows.is_empty() { Err(CsvError::NoRows { line: self.names.line }) } else { Ok(self) }
    }

    /// The name of a column.
    pub fn name(&self, index: usize) -> &str {
        &self.names.cells[index].text
    }

    /// The finite number in a cell.
    pub fn number(&self, row: &Row<'_>, index: usize) -> Result<f32, CsvError> {
        match row.cells[index].text.parse::<f32>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.cell_error(row, index, "a finite number")),
        }
    }

    /// The error of a cell that does not hold what it should.
    pub fn cell_error(&self, row: &Row<'_>, index: usize, wanted: &'static str) -> CsvError {
        let cell = &row.cells[index];
        let name = self.name(index).to_owned();
        CsvError::Cell { line: row.line, column: cell.column, name, text: cell.text.to_string(), wanted }
    }

    /// Checks that the numbers in a column count frames one by one, and returns the first.
    pub fn frames(&self, index: usize) -> Result<i64, CsvError> {
        let mut before: Option<i64> = None;
        for row in &self.rows {
            let cell = &row.cells[index];
            let found: i64 = cell.text.parse().map_err(|_| self.cell_error(row, index, "a whole frame number"))?;
            if let Some(before) = before
                && before.checked_add(1) != Some(found)
            {
                return Err(CsvError::Frame { line: row.line, column: cell.column, before, found });
            }
            before = Some(found);
        }
        let count = self.rows.len().cast_signed() as i64;
        Ok(before.map_or(0, |last| last - (count - 1)))
    }

    /// The rate that a comment such as `# rate_hz: 60` states, in hertz.
    pub fn rate_hz(&self) -> Result<Option<f64>, CsvError> {
        for (line, comment) in &self.comments {
            let Some(rest) = comment.strip_prefix("rate_hz") else { continue };
            let number = rest.trim_start().trim_start_matches([':', '=']).trim();
            return match number.parse::<f64>() {
                Ok(rate) if rate.is_finite() && rate > 0.0 => Ok(Some(rate)),
                _ => Err(CsvError::Rate { line: *line, text: (*comment).to_owned() }),
            };
        }
        Ok(None)
    }
}

/// The error of a column name.
pub(crate) fn column_error(names: &Row<'_>, cell: &Cell<'_>, problem: impl Into<String>) -> CsvError {
    let name = cell.text.to_string();
    CsvError::Column { line: names.line, column: cell.column, name, problem: problem.into() }
}

struct Cursor<'a> {
    text: &'a str,
    at: usize,
    line: usize,
    line_start: usize,
}

impl<'a> Cursor<'a> {
    fn done(&self) -> bool {
        self.at >= self.text.len()
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn rest_of_line(&self) -> &'a str {
        let rest = self.rest();
        &rest[..rest.find('\n').unwrap_or(rest.len())]
    }

    fn next_line(&mut self) {
        self.at = self.rest().find('\n').map_or(self.text.len(), |end| self.at + end + 1);
        self.line += 1;
        self.line_start = self.at;
    }

    fn column(&self) -> usize {
        1 + self.text[self.line_start..self.at].chars().count()
    }

    fn row(&mut self) -> Result<Row<'a>, CsvError> {
        let line = self.line;
        let mut cells = Vec::new();
        // The column is counted on from cell to cell: counting it anew would take a time that grows with the square.
        let (mut column, mut counted_to, mut counted_line) = (1, self.at, self.line);
        loop {
            let rest = self.rest_of_line();
            self.at += rest.len() - rest.trim_start_matches([' ', '\t']).len();
            if counted_line != self.line {
                (column, counted_to, counted_line) = (1, self.line_start, self.line);
            }
            column += self.text[counted_to..self.at].chars().count();
            counted_to = self.at;
            let text = if self.rest().starts_with('"') { self.quoted()? } else { self.bare() };
            cells.push(Cell { column, text });
            if self.rest().starts_with(',') {
                self.at += 1;
            } else {
                self.next_line();
                return Ok(Row { line, cells });
            }
        }
    }

    fn bare(&mut self) -> Cow<'a, str> {
        let rest = self.rest_of_line();
        let cell = &rest[..rest.find(',').unwrap_or(rest.len())];
        self.at += cell.len();
        Cow::Borrowed(cell.trim())
    }

    fn quoted(&mut self) -> Result<Cow<'a, str>, CsvError> {
        let (line, column) = (self.line, self.column());
        let mut text = String::new();
        self.at += 1;
        loop {
            let Some(end) = self.rest().find('"') else {
                return Err(CsvError::Quote { line, column, problem: "the quote that begins here is never closed" });
            };
            let part = &self.rest()[..end];
            if let Some(newline) = part.rfind('\n') {
                self.line += part.matches('\n').count();
                self.line_start = self.at + newline + 1;
            }
            text.push_str(part);
            self.at += end + 1;
            if !self.rest().starts_with('"') {
                break;
            }
            text.push('"');
            self.at += 1;
        }
        let rest = self.rest_of_line();
        let after = rest.trim_start();
        if !after.is_empty() && !after.starts_with(',') {
            let problem = "text follows a closing quote; a comma must";
            return Err(CsvError::Quote { line: self.line, column: self.column(), problem });
        }
        self.at += rest.len() - after.len();
        Ok(Cow::Owned(text))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Vec<Vec<String>> {
        let table = Table::read(text).unwrap();
        std::iter::once(&table.names)
            .chain(&table.rows)
            .map(|row| row.cells.iter().map(|cell| cell.text.to_string()).collect())
            .collect()
    }

    #[test]
    fn comments_line_ends_blanks_and_quotes_are_understood() {
        let table = "\n# rate_hz: 59.94\r\n a ,\"b, \"\"c\"\"\"\r\n1,2\r\n# note\n3, 4 \n\n";
        assert_eq!(cells(table), [["a", "b, \"c\""], ["1", "2"], ["3", "4"]]);
        assert_eq!(Table::read(table).unwrap().rate_hz(), Ok(Some(59.94)));
        assert_eq!(cells("a,b\n\"1\n2\",3\n4,5"), [["a", "b"], ["1\n2", "3"], ["4", "5"]]);
        assert_eq!(text("\u{feff}a".as_bytes()), Ok("a"));
    }

    #[test]
    fn errors_name_line_and_column() {
        assert_eq!(
            Table::read("a,b\n1,2\n1\n").unwrap_err(),
            CsvError::Width { line: 3, names_line: 1, expected: 2, found: 1 }
        );
        assert_eq!(Table::read("a,b\n\n1,2\n").unwrap_err(), CsvError::Blank { line: 2 });
        assert!(matches!(Table::read("a,b\n1,\"2\n").unwrap_err(), CsvError::Quote { line: 2, column: 3, .. }));
        assert!(matches!(Table::read("a,b\n1,\"2\"3\n").unwrap_err(), CsvError::Quote { line: 2, column: 6, .. }));
        assert!(matches!(Table::read("a,ä, a\n").unwrap_err(), CsvError::Column { line: 1, column: 6, .. }));
        assert_eq!(Table::read("# only\n\n").unwrap_err(), CsvError::Empty);
        assert_eq!(text(b"a\nb\xff").unwrap_err(), CsvError::NotText { line: 2, at: 3 });
        let table = Table::read("frame,a\n1,x\n3,inf\n").unwrap();
        assert!(matches!(table.number(&table.rows[0], 1), Err(CsvError::Cell { line: 2, column: 3, .. })));
        assert!(matches!(table.number(&table.rows[1], 1), Err(CsvError::Cell { line: 3, column: 3, .. })));
        assert_eq!(table.frames(0), Err(CsvError::Frame { line: 3, column: 1, before: 1, found: 3 }));
    }
}
