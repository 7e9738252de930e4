//! What became of one value of a snapshot, in words and as JSON.

use graph_core::snapshot::{Agreement, FirstDifference, Verdict};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Differences that are listed of one value.
const LISTED: usize = 6;

/// One value that was held against its snapshot.
pub struct Checked {
    pub output: String,
    pub item: String,
    pub kind: String,
    pub fate: Fate,
    /// Where its difference came from.
    pub first: Option<FirstDifference>,
    /// The plot of what was beside what is.
    pub plot: Option<PathBuf>,
}

/// What became of it.
pub enum Fate {
    /// It was compared.
    Compared(Verdict),
    /// The snapshot holds it, and the graph no longer gives it.
    Gone,
    /// The graph gives it, and the snapshot does not hold it.
    New,
    /// It is of another type now.
    OtherType(String),
}

impl Checked {
    /// Whether the check fails by it.
    pub fn fails(&self) -> bool {
        !matches!(&self.fate, Fate::Compared(verdict) if verdict.agreement != Agreement::Differs)
    }

    fn name(&self) -> String {
        if self.item.is_empty() { self.output.clone() } else { format!("{}@{}", self.output, self.item) }
    }

    /// As JSON.
    pub fn json(&self) -> Value {
        let (fate, differences) = match &self.fate {
            Fate::Compared(verdict) => (json!(verdict.agreement), json!(verdict.differences)),
            Fate::Gone => (json!("gone"), json!([])),
            Fate::New => (json!("new"), json!([])),
            Fate::OtherType(_) => (json!("other_type"), json!([])),
        };
        json!({
            "event": "compared", "output": self.output, "item": self.item, "type": self.kind, "ok": !self.fails(), "agreement": fate,
            "differences": differences, "first": self.first, "plot": self.plot.as_ref().map(|path| path.display().to_string()),
        })
    }

    /// In words.
    pub fn text(&self) -> String {
        let name = self.name();
        let verdict = match &self.fate {
            Fate::Gone => return format!("✗ {name}: the snapshot holds it, the graph no longer gives it\n"),
            Fate::New => return format!("✗ {name}: the graph gives it, the snapshot does not hold it\n"),
            Fate::OtherType(now) => return format!("✗ {name}: was of the type {}, is {now}\n", self.kind),
            Fate::Compared(verdict) => verdict,
        };
        match verdict.agreement {
            Agreement::Equal => return format!("✓ {name}: equal\n"),
            Agreement::Within => return format!("✓ {name}: not equal in all bits, and within its tolerances\n"),
            Agreement::Differs => {}
        }
        let mut out =
            format!("✗ {name} ({}): {} of {} numbers differ\n", self.kind, verdict.differences.len(), verdict.compared);
        let shown: Vec<[String; 5]> = verdict
            .differences
            .iter()
            .take(LISTED)
            .map(|one| {
                let place = [one.table.as_str(), one.column.as_str()].into_iter().filter(|part| !part.is_empty());
                let tolerance = if one.tolerance.is_empty() {
                    "must be equal".to_owned()
                } else {
                    format!("tolerance {}", one.tolerance)
                };
                let (expected, found) = (format!("expected {}", one.expected), format!("found {}", one.found));
                [place.collect::<Vec<_>>().join(" "), one.place.clone(), expected, found, tolerance]
            })
            .collect();
        let widths: Vec<usize> =
            (0..4).map(|at| shown.iter().map(|row| row[at].chars().count()).max().unwrap_or(0)).collect();
        for [column, place, expected, found, tolerance] in &shown {
            let [a, b, c, d] = [widths[0], widths[1], widths[2], widths[3]];
            let _ = writeln!(out, "    {column:a$}  {place:b$}  {expected:c$}  {found:d$}  {tolerance}");
        }
        if verdict.differences.len() > shown.len() {
            let _ = writeln!(out, "    … and {} more", verdict.differences.len() - shown.len());
        }
        if let Some(first) = &self.first {
            let others = match first.others.len() {
                0 => String::new(),
                more => format!("; differences begin at {more} more before it"),
            };
            let _ = writeln!(
                out,
                "    first to differ: {} ({}) at {}: {}{others}",
                first.node, first.kind, first.place, first.because
            );
        }
        if let Some(plot) = &self.plot {
            let _ = writeln!(out, "    drawn in {}", plot.display());
        }
        out
    }
}
