//! Tables of comma-separated values: what can be wrong with them, and how cells are written.
//!
//! Tolerant of a byte-order mark, either line end, `#` comment lines and quoted fields; strict about everything else,
//! because a table that is guessed at animates a face wrongly without anyone noticing.

mod grid;
mod table;

pub(crate) use grid::{Grid, GridRow, full_lines};
pub(crate) use table::{Cell, Row, Table, column_error, text};

/// Why text is not the table that was asked for. Lines and columns count from 1, columns in characters.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CsvError {
    /// No bytes at all.
    #[error("the file is empty; export the take again")]
    NoBytes,
    /// Nothing but blanks and comments.
    #[error("the file holds no table; its first line must name the columns")]
    Empty,
    /// Column names, but no rows.
    #[error("line {line}: column names, and no rows after them")]
    NoRows {
        /// Line of the names.
        line: usize,
    },
    /// Bytes that are no UTF-8 text.
    #[error("line {line}: byte {at} is not UTF-8 text; save the file as UTF-8")]
    NotText {
        /// The line.
        line: usize,
        /// Position of the byte in the file.
        at: usize,
    },
    /// A quote that is not closed, or goes on after it was.
    #[error("{line}:{column}: {problem}")]
    Quote {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// What is wrong.
        problem: &'static str,
    },
    /// A row of another width than the names.
    #[error("line {line} has {found} cells, the names in line {names_line} are {expected}; the row is cut or damaged")]
    Width {
        /// The line.
        line: usize,
        /// Line of the names.
        names_line: usize,
        /// Number of names.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// A blank line between rows.
    #[error("line {line} is blank in the middle of the table; remove it")]
    Blank {
        /// The line.
        line: usize,
    },
    /// A cell that should be a number.
    #[error("{line}:{column}: `{text}` in column `{name}` is not {wanted}")]
    Cell {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// Name of the column.
        name: String,
        /// What stands there.
        text: String,
        /// What should stand there.
        wanted: &'static str,
    },
    /// A frame number that does not follow the one before.
    #[error("{line}:{column}: frame {found} follows frame {before}; frames must follow one another")]
    Frame {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// The frame before.
        before: i64,
        /// This frame.
        found: i64,
    },
    /// A column name that is wrong.
    #[error("{line}:{column}: column `{name}`: {problem}")]
    Column {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// The name.
        name: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// A header of several lines that is not as its program writes it.
    #[error("{line}:{column}: {problem}")]
    Header {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// Fewer rows than the header says.
    #[error(
        "the frames end in line {line} after {found}, line {said_in} says {expected}; the file was cut short, copy or \
         export it again"
    )]
    Fewer {
        /// Line of the last row.
        line: usize,
        /// How many frames there are.
        found: usize,
        /// How many there should be.
        expected: u64,
        /// Line that says how many.
        said_in: usize,
    },
    /// A last row that ends in the middle.
    #[error(
        "line {line}: the file ends in the middle of this row, after {found} of {expected} cells; it was cut short, \
         copy or export it again"
    )]
    Cut {
        /// The line.
        line: usize,
        /// How many cells the row should have.
        expected: usize,
        /// How many cells it has.
        found: usize,
    },
    /// Rows nearly all of whose cells are absent.
    #[error("line {line}: the rows hold next to nothing of the {markers} markers that the header names; it is damaged")]
    Sparse {
        /// The line.
        line: usize,
        /// How many markers the header names.
        markers: usize,
    },
    /// A table of something else than markers.
    #[error("it holds {holds}, no markers; {cure}")]
    NoMarkers {
        /// What it holds.
        holds: String,
        /// What to do.
        cure: &'static str,
    },
    /// A timecode that goes backwards.
    #[error("line {line}: timecode {found} is earlier than {before} in the row before; put the rows in order of time")]
    Backwards {
        /// The line.
        line: usize,
        /// The timecode before.
        before: String,
        /// This timecode.
        found: String,
    },
    /// A recording most of which is missing.
    #[error(
        "line {line}: {seconds} s pass before this row, and the rows are fewer than half of the frames between the \
         first and the last; cut the file into one for each recording"
    )]
    Gap {
        /// Line of the row after the longest gap.
        line: usize,
        /// Length of the longest gap in whole seconds.
        seconds: u64,
    },
    /// A gap longer than may be filled.
    #[error(
        "line {line}: {frames} frames ({seconds:.2} s) are missing before this row, and gaps of up to {longest_s} s are \
         filled; cut the file there, or allow longer gaps where it is loaded (`longest_gap_s`)"
    )]
    LongGap {
        /// Line of the row after the gap.
        line: usize,
        /// Frames that are missing.
        frames: usize,
        /// How long it lasts, in seconds.
        seconds: f64,
        /// What may be filled, in seconds.
        longest_s: f64,
    },
    /// A table whose rate is not known.
    #[error(
        "neither the file nor the caller says how many frames pass a second; state the rate where the file is loaded, \
         or in the file with a line `# rate_hz: 60`"
    )]
    NoRate,
    /// A comment that states an impossible rate.
    #[error("line {line}: `{text}` states no rate in hertz above 0")]
    Rate {
        /// The line.
        line: usize,
        /// The comment.
        text: String,
    },
}

/// A line of a table, each cell quoted where it must be.
pub fn csv_line<'a>(cells: impl IntoIterator<Item = &'a str>) -> String {
    let mut line = String::new();
    for (index, cell) in cells.into_iter().enumerate() {
        if index > 0 {
            line.push(',');
        }
        push_cell(&mut line, cell);
    }
    line + "\n"
}

/// Appends a cell, quoted where it must be.
pub(crate) fn push_cell(out: &mut String, text: &str) {
    if text.contains(['"', ',', '\n', '\r', '#']) || text.trim() != text {
        out.push('"');
        out.push_str(&text.replace('"', "\"\""));
        out.push('"');
    } else {
        out.push_str(text);
    }
}

/// The cells of the first line that is neither blank nor a comment: the names of the columns, in a plain table.
pub(crate) fn first_names(text: &str) -> Option<Vec<std::borrow::Cow<'_, str>>> {
    let line = full_lines(text).find(|line| !line.trim_start().starts_with('#'))?;
    let row = Grid::new(line, ',').next_row().ok()??;
    Some(row.row.cells.into_iter().map(|cell| cell.text).collect())
}
