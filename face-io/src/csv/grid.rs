//! Tables with headers of several lines and rows of any width, as capture systems export them, split into cells.
//!
//! The plain tables of this crate go through [`super::Table`], which is stricter.

use super::{Cell, CsvError, Row};
use std::borrow::Cow;

/// Reads rows one after another; blank ones too, because in such files they part sections.
#[derive(Debug, Clone)]
pub(crate) struct Grid<'a> {
    rest: &'a str,
    line: usize,
    separator: char,
}

impl<'a> Grid<'a> {
    /// The rows of `text`, from its first line on.
    pub fn new(text: &'a str, separator: char) -> Self {
        Self { rest: text, line: 1, separator }
    }

    /// The rows of text whose cells a comma, a semicolon or a tab parts: whichever its first lines have most of.
    pub fn guess(text: &'a str) -> Self {
        let start: Vec<&str> = full_lines(text).take(6).collect();
        let count = |separator: char| start.iter().map(|line| line.matches(separator).count()).sum::<usize>();
        let separator = ['\t', ';', ','].into_iter().max_by_key(|separator| count(*separator)).unwrap_or(',');
        Self::new(text, separator)
    }

    /// The next row, and nothing at the end of the text.
    pub fn next_row(&mut self) -> Result<Option<GridRow<'a>>, CsvError> {
        if self.rest.is_empty() {
            return Ok(None);
        }
        let end = self.rest.find(['\n', '\r']);
        let (text, rest) = match end {
            None => (self.rest, ""),
            Some(end) => {
                let after = &self.rest[end..];
                (&self.rest[..end], after.strip_prefix("\r\n").unwrap_or(&after[1..]))
            }
        };
        let line = self.line;
        (self.rest, self.line) = (rest, line + 1);
        Ok(Some(GridRow { row: Row { line, cells: cells(text, line, self.separator)? }, ended: end.is_some() }))
    }

    /// The next row that holds something.
    pub fn next_full_row(&mut self) -> Result<Option<GridRow<'a>>, CsvError> {
        while let Some(row) = self.next_row()? {
            if !row.is_blank() {
                return Ok(Some(row));
            }
        }
        Ok(None)
    }

    /// Number of the line that comes next.
    pub fn line(&self) -> usize {
        self.line
    }
}

/// The lines that are not blank, whatever ends them.
pub(crate) fn full_lines(text: &str) -> impl Iterator<Item = &str> {
    text.split(['\n', '\r']).filter(|line| !line.trim().is_empty())
}

fn cells(text: &str, line: usize, separator: char) -> Result<Vec<Cell<'_>>, CsvError> {
    let mut cells = Vec::new();
    let (mut rest, mut column) = (text, 1);
    loop {
        let own = rest.trim_start_matches(' ');
        let (cell, after) = if own.starts_with('"') {
            let column = column + rest.chars().count() - own.chars().count();
            quoted(own, line, column, separator)?
        } else {
            let end = rest.find(separator).unwrap_or(rest.len());
            (Cow::Borrowed(rest[..end].trim()), &rest[end..])
        };
        cells.push(Cell { column, text: cell });
        column += rest[..rest.len() - after.len()].chars().count() + 1;
        match after.strip_prefix(separator) {
            Some(next) => rest = next,
            None => return Ok(cells),
        }
    }
}

/// The text between quotes at the start of `text`, and what follows.
fn quoted(text: &str, line: usize, column: usize, separator: char) -> Result<(Cow<'_, str>, &str), CsvError> {
    let wrong = |problem| CsvError::Quote { line, column, problem };
    let (mut own, mut rest) = (String::new(), &text[1..]);
    loop {
        let Some(end) = rest.find('"') else {
            return Err(wrong("the quote that begins here is not closed in its line"));
        };
        own.push_str(&rest[..end]);
        rest = &rest[end + 1..];
        match rest.strip_prefix('"') {
            Some(after) => {
                own.push('"');
                rest = after;
            }
            None => break,
        }
    }
    let after = rest.trim_start_matches(' ');
    if after.is_empty() || after.starts_with(separator) {
        return Ok((Cow::Owned(own.trim().to_owned()), after));
    }
    Err(wrong("text follows the closing quote of this cell; the next separator must"))
}

/// One row of a grid.
#[derive(Debug)]
pub(crate) struct GridRow<'a> {
    pub row: Row<'a>,
    /// Whether a line end follows it; a last row without one may be cut.
    pub ended: bool,
}

impl GridRow<'_> {
    pub fn line(&self) -> usize {
        self.row.line
    }

    /// Number of cells.
    pub fn width(&self) -> usize {
        self.row.cells.len()
    }

    /// What stands in a cell; nothing beyond the end of the row.
    pub fn text(&self, index: usize) -> &str {
        self.row.cells.get(index).map_or("", |cell| &cell.text)
    }

    /// Where a cell stands in its line, in characters from 1; for cells beyond the row, where it ends.
    pub fn column(&self, index: usize) -> usize {
        self.row.cells.get(index).or(self.row.cells.last()).map_or(1, |cell| cell.column)
    }

    pub fn is_blank(&self) -> bool {
        self.row.cells.iter().all(|cell| cell.text.is_empty())
    }

    /// The error of a cell of a header.
    pub fn wrong(&self, index: usize, problem: impl Into<String>) -> CsvError {
        CsvError::Header { line: self.line(), column: self.column(index), problem: problem.into() }
    }

    /// The error of a cell that does not hold what it should.
    pub fn cell_error(&self, index: usize, name: &str, wanted: &'static str) -> CsvError {
        let (line, column) = (self.line(), self.column(index));
        CsvError::Cell { line, column, name: name.to_owned(), text: self.text(index).to_owned(), wanted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<Vec<String>> {
        let mut grid = Grid::guess(text);
        let mut rows = Vec::new();
        while let Some(row) = grid.next_row().unwrap() {
            rows.push(row.row.cells.iter().map(|cell| cell.text.to_string()).collect());
        }
        rows
    }

    #[test]
    fn every_line_end_and_separator_is_understood() {
        assert_eq!(rows("a,b\r\n\n1, 2 ,\n"), [vec!["a", "b"], vec![""], vec!["1", "2", ""]]);
        assert_eq!(rows("a\tb,c\td\r1\t\t2"), [["a", "b,c", "d"], ["1", "", "2"]]);
        assert_eq!(rows("a;b;\n\"x;\"\"y\" ;2"), [vec!["a", "b", ""], vec!["x;\"y", "2"]]);
    }

    #[test]
    fn rows_know_where_they_stand_and_whether_they_are_whole() {
        let mut grid = Grid::new("\u{b5}, \"b\",c\n1,2", ',');
        let first = grid.next_row().unwrap().unwrap();
        assert_eq!((first.line(), first.column(1), first.column(2), first.ended), (1, 3, 8, true));
        let second = grid.next_row().unwrap().unwrap();
        assert_eq!((second.line(), second.ended, second.text(7), second.column(7)), (2, false, "", 3));
        assert!(grid.next_row().unwrap().is_none());
    }

    #[test]
    fn quotes_that_are_not_closed_are_named() {
        let error = |text: &str| Grid::new(text, ',').next_row().unwrap_err();
        assert!(matches!(error("a, \"b\n"), CsvError::Quote { line: 1, column: 4, .. }), "{}", error("a, \"b\n"));
        assert!(matches!(error("\"a\"b,c"), CsvError::Quote { line: 1, column: 1, .. }));
    }
}
