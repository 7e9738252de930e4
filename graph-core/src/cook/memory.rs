//! Memory: how much of it a cook may take, and how much its values hold. Half of the budget is for values between nodes; above
//! that, what the store holds is let go of, and read again where it is needed, then what is kept for later alone, and computed
//! again. The rest is for nodes at work, which are refused what exceeds it.

use super::cell::SlotSet;
use super::engine::Engine;
use std::sync::atomic::{AtomicU64, Ordering};

/// The memory of one engine.
#[derive(Debug)]
pub(crate) struct Memory {
    /// Bytes that a cook may take.
    pub budget: u64,
    /// Bytes that values between nodes take.
    held: AtomicU64,
    /// Bytes from which on it is worth looking again for something to let go of.
    worth_looking: AtomicU64,
}

impl Memory {
    /// A budget of `bytes`, or of what this machine suggests.
    pub fn new(bytes: Option<u64>) -> Self {
        let budget = bytes.unwrap_or_else(suggested);
        Self { budget, held: AtomicU64::new(0), worth_looking: AtomicU64::new(budget / 2) }
    }

    pub fn take(&self, bytes: usize) {
        self.held.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    pub fn give_back(&self, bytes: usize) {
        self.held.fetch_sub(bytes as u64, Ordering::Relaxed);
    }

    /// Says that values may be let go of that could not before.
    pub fn look_again(&self) {
        self.worth_looking.store(self.budget / 2, Ordering::Relaxed);
    }

    fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }
}

impl Engine {
    /// Bytes that values between nodes take.
    pub fn held_bytes(&self) -> u64 {
        self.shared.memory.held()
    }

    /// Lets go of values, those of the earliest cells first, where they take more than they may: of those that the store holds,
    /// then of those that no cell in the making asks for.
    pub(super) fn make_room(&self) {
        let memory = &self.shared.memory;
        if memory.held() <= memory.worth_looking.load(Ordering::Relaxed) {
            return;
        }
        let enough = memory.budget / 2 - memory.budget / 16;
        for stored in [true, false] {
            for (id, cell) in self.cells.iter().enumerate() {
                if memory.held() <= enough {
                    break;
                }
                if stored || !self.is_wanted(id) {
                    let slots = cell.slots().into_iter().flat_map(|sets| sets.iter()).flat_map(SlotSet::slots);
                    slots.filter(|slot| !stored || slot.is_stored()).for_each(|slot| slot.release());
                }
            }
        }
        // Where little could go, another look pays only after more has come.
        let next = (memory.held() + memory.budget / 16).max(memory.budget / 2);
        memory.worth_looking.store(next, Ordering::Relaxed);
    }
}

/// Four fifths of the machine's memory, or of what the process's control group may take.
fn suggested() -> u64 {
    system_bytes().map_or(u64::MAX, |bytes| bytes / 5 * 4)
}

#[cfg(target_os = "linux")]
fn system_bytes() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let info = read("/proc/meminfo")?;
    let total = info.lines().find_map(|line| line.strip_prefix("MemTotal:")?.trim().strip_suffix(" kB")?.parse().ok());
    let limits = ["/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"];
    let limit = limits.iter().filter_map(|path| read(path)?.trim().parse::<u64>().ok()).min();
    let total = total.map(|kibibytes: u64| kibibytes * 1024);
    [total, limit].into_iter().flatten().min()
}

#[cfg(not(target_os = "linux"))]
fn system_bytes() -> Option<u64> {
    None
}
