//! Counts tests from what their binaries print, and shows of it what people need.

use std::fmt;

/// How many tests passed, failed, and were skipped.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Tests that ran and passed.
    pub passed: usize,
    /// Tests that failed.
    pub failed: usize,
    /// Tests that were ignored, or said that what they need is not on this machine.
    pub skipped: usize,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} passed, {} failed, {} skipped", self.passed, self.failed, self.skipped)
    }
}

/// What a test prints where something it needs is missing. It passes as far as its binary knows.
const SKIPPED: &str = "SKIPPED:";

/// Reads the lines of test binaries run with `--show-output`: what passing tests print comes under `successes:`, each
/// under a heading of its own, and then their names once more.
#[derive(Debug, Default)]
pub struct Reader {
    /// All binaries so far.
    pub tally: Tally,
    /// Skipped tests of the present binary.
    skipped: usize,
    within_successes: bool,
    /// Whether the present test has said that it was skipped.
    noted: bool,
}

impl Reader {
    /// Takes a line, and says whether people should see it.
    pub fn take(&mut self, line: &str) -> bool {
        let line = line.trim_end();
        if line == "successes:" {
            self.within_successes = true;
            return false;
        }
        if line == "failures:" {
            self.within_successes = false;
        }
        if let Some(result) = line.strip_prefix("test result:") {
            self.within_successes = false;
            self.add(result);
            return true;
        }
        if !self.within_successes {
            return true;
        }
        if line.starts_with("---- ") {
            self.noted = false;
        }
        let skips = line.starts_with(SKIPPED);
        if skips && !self.noted {
            self.noted = true;
            self.skipped += 1;
        }
        skips
    }

    fn add(&mut self, result: &str) {
        let count = |what: &str| {
            let part = result.split([';', '.']).map(str::trim).find_map(|part| part.strip_suffix(what));
            part.and_then(|number| number.trim().parse::<usize>().ok()).unwrap_or(0)
        };
        let skipped = std::mem::take(&mut self.skipped);
        self.tally.passed += count("passed").saturating_sub(skipped);
        self.tally.failed += count("failed");
        self.tally.skipped += count("ignored") + skipped;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Tally, Vec<&str>) {
        let mut reader = Reader::default();
        let shown = text.lines().filter(|line| reader.take(line)).collect();
        (reader.tally, shown)
    }

    #[test]
    fn results_of_several_binaries_add_up() {
        let text = "running 3 tests\ntest a ... ok\n\
            test result: FAILED. 2 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s\n\
            test result: ok. 40 passed; 0 failed; 2 ignored; 0 measured; 0 filtered out; finished in 12.30s\n";
        assert_eq!(read(text).0, Tally { passed: 42, failed: 1, skipped: 2 });
    }

    #[test]
    fn a_test_that_says_it_was_skipped_counts_once_as_skipped() {
        let text = "test a ... ok\ntest b ... ok\n\nsuccesses:\n\n---- a stdout ----\nSKIPPED: no takes\nSKIPPED: no rig\n\
            ---- b stdout ----\nloss 0.1\n\nsuccesses:\n    a\n    b\n\n\
            test result: ok. 2 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s\n";
        let (tally, shown) = read(text);
        assert_eq!(tally, Tally { passed: 1, failed: 0, skipped: 1 });
        assert_eq!(shown.iter().filter(|line| line.starts_with("SKIPPED")).count(), 2);
        assert!(!shown.contains(&"loss 0.1") && !shown.contains(&"    a"), "{shown:?}");
    }

    #[test]
    fn what_failing_tests_print_is_shown() {
        let text = "successes:\n\n---- a stdout ----\nx\n\nfailures:\n\n---- b stdout ----\nSKIPPED: y\n\n\
            test result: FAILED. 1 passed; 1 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.00s\n";
        let (tally, shown) = read(text);
        assert_eq!(tally, Tally { passed: 1, failed: 1, skipped: 0 });
        assert!(shown.contains(&"SKIPPED: y") && !shown.contains(&"x"), "{shown:?}");
    }
}
