//! A failed node, as a block of lines: who, where, what was wrong, and what stood on its inputs.

use crate::words::{indented, one_line};
use console::style;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Inputs that are listed before the rest is only counted.
const LISTED: usize = 12;

/// What is known of a failed cell.
pub struct Failure<'a> {
    /// The cell.
    pub node: &'a str,
    /// Its kind.
    pub kind: &'a str,
    /// What was wrong.
    pub error: &'a str,
    /// `file:line:col` of the node.
    pub place: &'a str,
    /// What stood on its inputs.
    pub inputs: &'a BTreeMap<String, String>,
}

/// The block.
pub fn block(failure: &Failure<'_>) -> String {
    let Failure { node, kind, error, place, inputs } = failure;
    let cross = style("✗").red().bold().for_stderr();
    let mut out = format!("{cross} {} ({kind}) failed at {place}\n", style(node).red().bold().for_stderr());
    out += &indented(error.trim_end(), "    ");
    let widest = inputs.keys().take(LISTED).map(|port| console::measure_text_width(port)).max().unwrap_or(0);
    for (port, summary) in inputs.iter().take(LISTED) {
        let _ = write!(out, "\n    {} {port:<widest$}  {}", style("input").dim().for_stderr(), one_line(summary, 160));
    }
    if inputs.len() > LISTED {
        let _ = write!(out, "\n    … and {} more inputs", inputs.len() - LISTED);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::{Failure, block};
    use std::collections::BTreeMap;

    #[test]
    fn a_failure_says_all_that_is_known() {
        let told = |port: &str, summary: &str| (port.to_owned(), summary.to_owned());
        let inputs = BTreeMap::from([told("rig", "53 channels"), told("markers", "98 markers, 200 frames")]);
        let failure = Failure {
            node: "solve@smile",
            kind: "solve_regions",
            error: "input `markers`: `lip_upper` is missing in all frames\nfill it with fill_gaps",
            place: "graph.ron:14:9",
            inputs: &inputs,
        };
        let expected = "\
✗ solve@smile (solve_regions) failed at graph.ron:14:9
    input `markers`: `lip_upper` is missing in all frames
    fill it with fill_gaps
    input markers  98 markers, 200 frames
    input rig      53 channels";
        assert_eq!(block(&failure), expected);
    }
}
