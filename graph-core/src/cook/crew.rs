//! The crew: the threads that run jobs, in the order in which those come. Where long jobs hold all of them while others wait,
//! a few more threads help, so that what is soon done is not held up by a training. Who runs a job makes no difference to
//! what it gives.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use std::collections::VecDeque;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long nobody may have taken up a job, while some wait, before others help.
const PATIENCE: Duration = Duration::from_millis(250);
/// Groups of helpers at the most: each may be held by long jobs of its own.
const GROUPS: usize = 3;

type Work = Box<dyn FnOnce() + Send>;

/// Threads, and the jobs that wait for them.
pub(crate) struct Crew {
    pool: ThreadPool,
    waiting: Arc<Waiting>,
    helpers: Vec<Helpers>,
}

#[derive(Default)]
struct Waiting(Mutex<Line>);

#[derive(Default)]
struct Line {
    jobs: VecDeque<Work>,
    /// When the first job was taken up, or began to wait where none did before.
    moved: Option<Instant>,
}

struct Helpers {
    pool: ThreadPool,
    busy: Arc<AtomicUsize>,
}

impl Waiting {
    fn line(&self) -> MutexGuard<'_, Line> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes up the job that has waited longest. Whether there was one.
    fn work(&self) -> bool {
        let job = {
            let mut line = self.line();
            line.moved = Some(Instant::now());
            line.jobs.pop_front()
        };
        job.map(|job| job()).is_some()
    }
}

impl Crew {
    /// A crew of so many threads; 0 means one for each core.
    ///
    /// # Errors
    /// Where threads cannot be started.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        Ok(Self { pool: pool(threads)?, waiting: Arc::default(), helpers: Vec::new() })
    }

    /// How many threads it has, helpers aside.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Has `job` run as soon as a thread is free.
    pub fn spawn(&self, job: impl FnOnce() + Send + 'static) {
        {
            let mut line = self.waiting.line();
            if line.jobs.is_empty() {
                line.moved = Some(Instant::now());
            }
            line.jobs.push_back(Box::new(job));
        }
        let waiting = Arc::clone(&self.waiting);
        self.pool.spawn(move || {
            waiting.work();
        });
    }

    /// Has helpers take up jobs, where some wait and nobody took one up for a while: half as many as the crew, at least one.
    ///
    /// # Errors
    /// Where threads cannot be started.
    pub fn help(&mut self) -> Result<(), ThreadPoolBuildError> {
        let held = {
            let line = self.waiting.line();
            !line.jobs.is_empty() && line.moved.is_none_or(|moved| moved.elapsed() >= PATIENCE)
        };
        if !held {
            return Ok(());
        }
        let free = self.helpers.iter().position(|helpers| helpers.busy.load(Ordering::Acquire) == 0);
        let group = match free {
            Some(free) => free,
            None if self.helpers.len() == GROUPS => return Ok(()),
            None => {
                let pool = pool((self.pool.current_num_threads() / 2).max(1))?;
                self.helpers.push(Helpers { pool, busy: Arc::default() });
                self.helpers.len() - 1
            }
        };
        let Helpers { pool, busy } = &self.helpers[group];
        for _ in 0..pool.current_num_threads() {
            let (waiting, busy) = (Arc::clone(&self.waiting), Arc::clone(busy));
            busy.fetch_add(1, Ordering::AcqRel);
            pool.spawn(move || {
                while waiting.work() {}
                busy.fetch_sub(1, Ordering::AcqRel);
            });
        }
        Ok(())
    }
}

fn pool(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;

    #[test]
    fn jobs_behind_long_ones_are_helped_with() {
        let mut crew = Crew::new(1).unwrap();
        let (done, told) = channel();
        let mut ends = Vec::new();
        // Long ones hold the crew, then a group of helpers.
        for _ in 0..2 {
            let (end, ended) = channel::<()>();
            ends.push(end);
            crew.spawn(move || assert!(ended.recv().is_err()));
        }
        for name in ["first", "second"] {
            let done = done.clone();
            crew.spawn(move || done.send(name).unwrap());
        }
        crew.help().unwrap();
        assert!(crew.helpers.is_empty(), "nobody helps before somebody waited");
        let mut order = Vec::new();
        while order.len() < 2 {
            crew.help().unwrap();
            order.extend(told.recv_timeout(Duration::from_millis(20)));
        }
        assert_eq!(order, ["first", "second"]);
        assert_eq!(crew.helpers.len(), 2);
        drop(ends);
    }
}
