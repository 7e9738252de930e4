//! Events: what a cook tells while it runs. The command line draws bars from them, `--json` prints them, the editor
//! shows them live; the engine itself prints nothing.

use serde::Serialize;
use std::collections::BTreeMap;

/// One thing that happened in a cook. Cells are named `node` or `node@item`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// More cells are known; sent once before cooking and again whenever a list's items become known.
    Planned {
        /// Cells known so far.
        cells: usize,
    },
    /// A cell's computation began.
    Started {
        /// The cell.
        node: String,
        /// Its kind.
        kind: String,
        /// Why it is cooked.
        because: String,
        /// Blocks of frames that will be computed; 0 for a node that works on the whole.
        blocks: usize,
    },
    /// A cell told how far it is.
    Progress {
        /// The cell.
        node: String,
        /// Fraction done, 0 to 1.
        fraction: f64,
        /// Named numbers such as a loss.
        numbers: BTreeMap<String, f64>,
    },
    /// A cell was computed.
    Cooked {
        /// The cell.
        node: String,
        /// Its kind.
        kind: String,
        /// Seconds of computation, summed over blocks.
        seconds: f64,
        /// Blocks of frames computed.
        blocks_cooked: usize,
        /// Blocks of frames kept from before.
        blocks_cached: usize,
        /// One line an output.
        outputs: BTreeMap<String, String>,
    },
    /// A value that the store does not keep was computed again, since something downstream needed it.
    Remade {
        /// The cell.
        node: String,
        /// Blocks of frames computed; 0 for a node that works on the whole.
        blocks: usize,
    },
    /// A cell was up to date.
    Cached {
        /// The cell.
        node: String,
        /// Its kind.
        kind: String,
        /// Blocks of frames it consists of; 0 for a node that works on the whole.
        blocks: usize,
    },
    /// In a plan: a cell would be cooked.
    WouldCook {
        /// The cell.
        node: String,
        /// Its kind.
        kind: String,
        /// Why.
        because: String,
        /// Whether it is sure; else it depends on whether something upstream changes its result.
        sure: bool,
    },
    /// A cell failed.
    Failed {
        /// The cell.
        node: String,
        /// Its kind.
        kind: String,
        /// What was wrong.
        error: String,
        /// `file:line:col` of the node.
        place: String,
        /// What stood on its inputs.
        inputs: BTreeMap<String, String>,
    },
    /// A cell could not be cooked since something it needs failed.
    Skipped {
        /// The cell.
        node: String,
        /// The failed cell.
        because: String,
    },
    /// A file was written.
    Wrote {
        /// The cell.
        node: String,
        /// The file.
        path: String,
        /// Its size.
        bytes: usize,
    },
    /// Something worth knowing that is no failure.
    Notice {
        /// What it is about: a cell or a file.
        about: String,
        /// The message.
        message: String,
    },
    /// The cook is over; always the last event.
    Summary(Summary),
}

/// What a cook did.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Summary {
    /// Cells computed.
    pub cooked: usize,
    /// Cells that were up to date.
    pub cached: usize,
    /// Cells that failed.
    pub failed: usize,
    /// Cells that were not cooked since something they need failed.
    pub skipped: usize,
    /// Cells computed again only because the store does not keep their value.
    pub remade: usize,
    /// Blocks of frames computed in per-frame nodes.
    pub blocks_cooked: usize,
    /// Blocks of frames kept in per-frame nodes.
    pub blocks_cached: usize,
    /// Files written.
    pub written: usize,
    /// Whether the cook was cancelled.
    pub cancelled: bool,
    /// Seconds from start to end.
    pub seconds: f64,
}
