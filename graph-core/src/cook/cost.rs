//! What nodes cost: where a kind has shown itself to be cheap, its next cell is computed in place, since handing it to the
//! pool would take longer than the work.

use crate::plan::Plan;
use std::collections::HashMap;

/// Computations below this are done in place.
pub(crate) const CHEAP_S: f64 = 30e-6;

/// What a file costs that is written to the store and read again, in seconds. A cheap value is kept only where computing it
/// again, with all that is not kept before it, would take longer.
pub(crate) const FILE_S: f64 = 2e-3;

/// Bytes up to which a time-varying value that is not cheap is always kept.
pub(crate) const SMALL_BYTES: u64 = 256 << 10;

/// How fast a kept value is read back, in bytes a second, at a careful guess.
const READ_BYTES_A_SECOND: f64 = 250e6;

/// Whether a value of so many bytes is sooner read than computed again, which takes so many seconds.
pub(crate) fn sooner_read(bytes: u64, again_s: f64) -> bool {
    again_s > FILE_S + bytes as f64 / READ_BYTES_A_SECOND
}

/// Seconds a cell, by kind.
pub(crate) struct Costs {
    /// The kind of each plan node, as an index.
    kinds: Vec<usize>,
    /// Whether nothing counts as cheap.
    none: bool,
    /// A mean of what the kind's cells took; infinite before the first.
    seconds: Vec<f64>,
}

impl Costs {
    pub fn of(plan: &Plan, none: bool) -> Self {
        let mut known: HashMap<&str, usize> = HashMap::new();
        let kinds = plan.nodes.iter().map(|node| {
            let next = known.len();
            *known.entry(node.kind.as_str()).or_insert(next)
        });
        let kinds: Vec<usize> = kinds.collect();
        Self { kinds, none, seconds: vec![f64::INFINITY; known.len()] }
    }

    pub fn cheap(&self, plan: usize) -> bool {
        !self.none && self.seconds[self.kinds[plan]] < CHEAP_S
    }

    /// Learns from one computation. A dear one counts at once; cheap ones are believed soon, since a computation may also have
    /// been slow because the machine was busy.
    pub fn learn(&mut self, plan: usize, seconds: f64) {
        let mean = &mut self.seconds[self.kinds[plan]];
        *mean = if mean.is_finite() && seconds < *mean { 0.5 * (*mean + seconds) } else { seconds };
    }
}
