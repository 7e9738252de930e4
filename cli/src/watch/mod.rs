//! `grimace watch`: cooks a graph, and again whenever its files change.
//!
//! Three threads: `hints` listens to the system, `kitchen` cooks, and the loop here looks at the files (`watching`), decides with
//! `graph_core::watch` what has arrived, and tells the kitchen. `tell` shows it all. What the system says is only a reason to
//! look; what a look finds is the truth.

mod hints;
mod kitchen;
mod status;
mod stop;
mod tell;
mod watching;

use crate::arguments::{Global, Watch};
use crate::cooking;
use crate::exit::{Exit, Trouble};
use crate::graph::{self, Asked};
use graph_core::cook::Options;
use graph_core::files::Gate;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use stop::Signals;
use tell::{Teller, WatchEvent};
use watching::Watching;

/// Something that the loop wakes up for.
#[derive(Debug)]
pub enum Wake {
    /// The system says that something changed.
    Hint(hints::Hint),
    /// A cook is over.
    Cooked(Box<kitchen::Cooked>),
}

/// How often signals are looked for.
const GLANCE: Duration = Duration::from_millis(100);

/// Watches the graph until a signal ends it.
pub fn watch(arguments: &Watch, global: &Global) -> Result<Exit, Trouble> {
    let asked = Asked::read(&arguments.graph)?;
    let gate = Arc::new(Gate::default());
    let options = Options { resident: true, gate: Some(Arc::clone(&gate)), ..cooking::options(&arguments.cook, false) };
    let signals = Signals::new()?;
    let teller = Arc::new(Teller::new(arguments.json, global, Arc::clone(&signals.stop)));
    let store = graph::store(&arguments.store, &asked.path);
    let (wake, woken) = channel();
    let kitchen = kitchen::Kitchen::new(asked.overrides.clone(), store, options, &teller, wake.clone());
    let settle = Duration::from_secs_f64(arguments.settle);
    let mut watching = Watching::new(asked, gate, settle, hints::Hints::new(wake, arguments.poll), kitchen, &teller);
    watching.start();
    let mut looked = Instant::now();
    while !signals.stop.load(Ordering::Relaxed) {
        if let Some(problem) = watching.refused() {
            teller.end();
            return Err(problem.into());
        }
        if signals.rescan.swap(false, Ordering::Relaxed) {
            teller.watch(&WatchEvent::Rescan { because: "asked for by SIGHUP".to_owned() });
            watching.retry();
            looked = Instant::now();
        }
        let pause = watching.pause().saturating_sub(looked.elapsed()).min(GLANCE);
        let mut hinted = false;
        match woken.recv_timeout(pause) {
            Ok(first) => {
                for wake in std::iter::once(first).chain(woken.try_iter()) {
                    match wake {
                        Wake::Hint(hint) => {
                            hinted = true;
                            watching.take_hint(hint);
                        }
                        Wake::Cooked(cooked) => hinted |= watching.cooked(*cooked),
                    }
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if hinted || looked.elapsed() >= watching.pause() {
            watching.look();
            looked = Instant::now();
        }
        teller.tick(&watching.settling(), watching.is_cooking(), watching.is_broken());
    }
    let cut = watching.end();
    teller.end();
    teller.problem()?;
    Ok(if cut { Exit::Cancelled } else { Exit::Fine })
}
