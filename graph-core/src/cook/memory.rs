//! Memory: how much of it a cook may take, and how much its values hold. Half of the budget is for values between nodes; what
//! the store holds is let go of above that, and read again where it is needed. The rest is for nodes at work, which are
//! refused what exceeds it.

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

    fn held(&self) -> u64 {
        self.held.load(Ordering::Relaxed)
    }
}

impl Engine {
    /// Bytes that values between nodes take.
    pub fn held_bytes(&self) -> u64 {
        self.shared.memory.held()
    }

    /// Lets go of values that the store holds, those of the earliest cells first, where values take more than they may.
    pub(super) fn make_room(&self) {
        let memory = &self.shared.memory;
        if memory.held() <= memory.worth_looking.load(Ordering::Relaxed) {
            return;
        }
        let enough = memory.budget / 2 - memory.budget / 16;
        for cell in &self.cells {
            if memory.held() <= enough {
                break;
            }
            let sets = cell.slots().into_iter().flat_map(|slots| slots.iter());
            sets.flat_map(SlotSet::slots).filter(|slot| slot.is_stored()).for_each(|slot| slot.release());
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
