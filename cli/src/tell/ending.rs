//! The last lines of a cook: what failed, the totals, and where files were written.

use super::board::Board;
use crate::words::{count, duration};
use console::style;
use graph_core::cook::Summary;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Failed cells that are named before the rest is only counted.
const NAMED: usize = 12;

/// The last lines.
pub fn ending(board: &Board, summary: &Summary) -> Vec<String> {
    let mut lines = Vec::new();
    if !board.failed.is_empty() {
        let mut names = board.failed.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join(", ");
        if board.failed.len() > NAMED {
            let _ = write!(names, " and {} more", board.failed.len() - NAMED);
        }
        let failed = style(format!("{} failed", count(board.failed.len(), "cell"))).red().bold().for_stderr();
        let skipped = match summary.skipped {
            0 => String::new(),
            skipped => format!("; {} skipped, as what they need failed", count(skipped, "cell")),
        };
        let rest = if summary.cancelled { "" } else { "; everything else went on" };
        lines.push(format!("{failed}: {names}{skipped}{rest}"));
    }
    lines.push(totals(board, summary));
    lines
}

/// `42 cooked, 7 cached in 3.2 s; wrote 6 files under out/`.
fn totals(board: &Board, summary: &Summary) -> String {
    let mut parts = Vec::new();
    if summary.cancelled {
        parts.push("cancelled".to_owned());
    }
    let blocks = summary.blocks_cooked + summary.blocks_cached;
    let of_blocks = match (summary.blocks_cooked, summary.blocks_cached) {
        (0, _) | (_, 0) => String::new(),
        _ => format!(" ({} of {})", summary.blocks_cooked, count(blocks, "block")),
    };
    parts.push(format!("{} cooked{of_blocks}", summary.cooked));
    parts.push(format!("{} cached", summary.cached));
    if summary.remade > 0 {
        parts.push(format!("{} made again", summary.remade));
    }
    let mut line = format!("{} in {}", parts.join(", "), duration(summary.seconds));
    match board.written.as_slice() {
        [] => {}
        [only] => {
            let _ = write!(line, "; wrote {}", only.display());
        }
        several => {
            let _ = write!(line, "; wrote {}", count(several.len(), "file"));
            if let Some(folder) = common_folder(several) {
                let _ = write!(line, " under {}/", folder.display());
            }
        }
    }
    line
}

/// The deepest folder that holds all `files`; `None` where they have none in common.
fn common_folder(files: &[PathBuf]) -> Option<PathBuf> {
    let mut folders = files.iter().filter_map(|file| file.parent());
    let first = folders.next()?;
    let common = folders.fold(first.to_owned(), |common, folder| {
        common
            .components()
            .zip(folder.components())
            .take_while(|(one, other)| one == other)
            .map(|(one, _)| one)
            .collect()
    });
    Some(common).filter(|common| common != Path::new("") && common != Path::new("/"))
}

#[cfg(test)]
mod tests {
    use super::{common_folder, ending};
    use crate::tell::Wanted;
    use crate::tell::board::Board;
    use graph_core::cook::Summary;
    use std::path::{Path, PathBuf};

    #[test]
    fn files_meet_in_their_folder() {
        let of = |files: &[&str]| common_folder(&files.iter().map(PathBuf::from).collect::<Vec<_>>());
        assert_eq!(of(&["out/a.csv", "out/b/c.csv"]).as_deref(), Some(Path::new("out")));
        assert_eq!(of(&["/x/out/a.csv", "/x/outer/c.csv"]).as_deref(), Some(Path::new("/x")));
        assert_eq!(of(&["a.csv", "out/c.csv"]), None);
        assert_eq!(of(&["/a/x", "/b/x"]), None);
    }

    #[test]
    fn the_last_line_counts_and_says_where() {
        let mut board = Board::new(Wanted::default(), None);
        let summary = Summary { cooked: 42, cached: 7, seconds: 3.2, ..Summary::default() };
        assert_eq!(ending(&board, &summary), ["42 cooked, 7 cached in 3.2 s"]);
        board.written = vec!["out/a.csv".into()];
        assert_eq!(ending(&board, &summary), ["42 cooked, 7 cached in 3.2 s; wrote out/a.csv"]);
        board.written.push("out/b.csv".into());
        let blocks = Summary { blocks_cooked: 2, blocks_cached: 61, ..summary.clone() };
        let expected = "42 cooked (2 of 63 blocks), 7 cached in 3.2 s; wrote 2 files under out/";
        assert_eq!(ending(&board, &blocks), [expected]);
        board.failed = vec!["solve@a".into()];
        let failed = Summary { skipped: 2, failed: 1, ..summary };
        let expected = "1 cell failed: solve@a; 2 cells skipped, as what they need failed; everything else went on";
        assert_eq!(ending(&board, &failed)[0], expected);
    }
}
