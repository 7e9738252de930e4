//! Turns: where each cell stands in the order of work, apart from the cells themselves, so that pushing a change touches
//! little memory; and the line of those that are to be looked at.

use super::cell::CellId;
use smallvec::SmallVec;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

/// Cells that a cell is wired to: mostly few.
pub(crate) type Few = SmallVec<[CellId; 2]>;

/// Where a cell stands in the order of work.
#[derive(Debug, Default)]
pub(crate) struct Turn {
    /// Its place in the plan.
    pub plan: u32,
    /// Producers that are not settled: in the making, or waiting for something that is.
    pub pending: u32,
    /// Consumers that are not settled; at zero, memory may be let go.
    pub open_consumers: u32,
    /// Whether the cell itself is settled.
    pub settled: bool,
    /// Whether something it depends on has changed since it was last looked at.
    pub dirty: bool,
    pub queued: bool,
    /// Cells that it is wired to, each once.
    pub producers: Few,
    pub consumers: Few,
}

/// Dirty cells in the order in which they are looked at: that of the plan, then of their numbers. Most come in that order
/// already and only stand in line; a heap holds the others.
#[derive(Debug, Default)]
pub(crate) struct Line {
    ascending: VecDeque<(u32, CellId)>,
    others: BinaryHeap<Reverse<(u32, CellId)>>,
}

impl Line {
    pub fn push(&mut self, plan: u32, id: CellId) {
        if self.ascending.back().is_none_or(|last| *last <= (plan, id)) {
            self.ascending.push_back((plan, id));
        } else {
            self.others.push(Reverse((plan, id)));
        }
    }

    /// Takes out the first.
    pub fn pop(&mut self) -> Option<CellId> {
        let other = self.others.peek().map(|Reverse(other)| *other);
        let first = match (self.ascending.front(), other) {
            (Some(ascending), Some(other)) if other < *ascending => self.others.pop().map(|Reverse(other)| other),
            (None, Some(_)) => self.others.pop().map(|Reverse(other)| other),
            _ => self.ascending.pop_front(),
        };
        first.map(|(_, id)| id)
    }

    pub fn clear(&mut self) {
        self.ascending.clear();
        self.others.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_first_of_the_plan_comes_first(pushes in prop::collection::vec((0_u32..20, 0_usize..20, 0_usize..3), 0..200)) {
            let (mut line, mut plain) = (Line::default(), BinaryHeap::new());
            for (plan, id, pops) in pushes {
                line.push(plan, id);
                plain.push(Reverse((plan, id)));
                for _ in 0..pops {
                    prop_assert_eq!(line.pop(), plain.pop().map(|Reverse((_, id))| id));
                }
            }
            while let Some(Reverse((_, id))) = plain.pop() {
                prop_assert_eq!(line.pop(), Some(id));
            }
            prop_assert_eq!(line.pop(), None);
        }
    }
}
