//! The kitchen: one engine on a thread of its own. It cooks when it is told of a change, takes in what changes meanwhile, and
//! keeps everything that it made.

use super::Wake;
use super::tell::Teller;
use crate::logs;
use graph_core::cook::{Change, Changes, CookError, Engine, Event, Options, Seen, Summary, session_name};
use graph_core::document::Override;
use graph_core::plan::Plan;
use graph_core::store::Store;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;

/// What a cook ended with.
#[derive(Debug)]
pub struct Cooked {
    /// How many of the changes that were told it has taken in.
    taken: u64,
    /// What the graph was seen to depend on.
    pub seen: Seen,
}

/// The engine, once there is a plan to cook.
#[derive(Debug)]
struct Stove {
    changes: Changes,
    orders: Sender<()>,
    thread: JoinHandle<()>,
}

/// Cooks on a thread of its own.
#[derive(Debug)]
pub struct Kitchen {
    overrides: Vec<Override>,
    store: Arc<Store>,
    options: Options,
    teller: Arc<Teller>,
    wake: Sender<Wake>,
    cancel: Arc<AtomicBool>,
    stove: Option<Stove>,
    told: u64,
    /// Whether a cook runs.
    pub cooking: bool,
}

impl Kitchen {
    /// A kitchen that has nothing to cook yet.
    pub fn new(
        overrides: Vec<Override>,
        store: Store,
        options: Options,
        teller: &Arc<Teller>,
        wake: Sender<Wake>,
    ) -> Self {
        let (store, teller, cancel) = (Arc::new(store), Arc::clone(teller), Arc::default());
        Self { overrides, store, options, teller, wake, cancel, stove: None, told: 0, cooking: false }
    }

    /// Whether there is an engine that cooks.
    pub fn is_open(&self) -> bool {
        self.stove.is_some()
    }

    /// Begins to cook `plan`, for the first time.
    ///
    /// # Errors
    /// Where the store cannot be used, or `--only` names nothing.
    pub fn open(&mut self, plan: Plan) -> Result<(), CookError> {
        let teller = Arc::clone(&self.teller);
        let tell = Arc::new(move |event: Event| {
            logs::log(&event);
            teller.event(&event);
        });
        let lease = self.store.lease(&session_name(&self.store, &plan.root().path))?;
        let (store, options, cancel) = (Arc::clone(&self.store), self.options.clone(), Arc::clone(&self.cancel));
        let mut engine = Engine::new(plan, &self.overrides, store, options, cancel, Some(tell))?;
        let changes = engine.changes();
        let (orders, work) = channel();
        let (teller, wake) = (Arc::clone(&self.teller), self.wake.clone());
        let thread = std::thread::spawn(move || {
            // Held for as long as the engine lives, so that nobody removes what it needs.
            let _lease = lease;
            for () in work {
                let summary = engine.cook().and_then(|summary| engine.remember().map(|()| summary));
                let summary = summary.unwrap_or_else(|problem| {
                    teller.trouble(&problem.to_string());
                    Summary::default()
                });
                teller.event(&Event::Summary(summary));
                let cooked = Cooked { taken: engine.changes_taken(), seen: engine.seen() };
                // The watch may be over.
                let _ = wake.send(Wake::Cooked(Box::new(cooked)));
            }
        });
        self.stove = Some(Stove { changes, orders, thread });
        self.order();
        Ok(())
    }

    /// Tells of a change, and cooks it.
    pub fn tell(&mut self, change: Change) {
        let Some(stove) = &self.stove else { return };
        stove.changes.tell(change);
        self.told += 1;
        if !self.cooking {
            self.order();
        }
    }

    fn order(&mut self) {
        self.cooking = self.stove.as_ref().is_some_and(|stove| stove.orders.send(()).is_ok());
    }

    /// A cook is over; what came too late for it is cooked now.
    pub fn take(&mut self, cooked: &Cooked) {
        self.cooking = false;
        if cooked.taken < self.told {
            self.order();
        }
    }

    /// Ends the cooking. Whether that cut a cook short.
    pub fn close(&mut self) -> bool {
        let cut = self.cooking;
        self.cancel.store(true, Ordering::Relaxed);
        if let Some(Stove { orders, thread, .. }) = self.stove.take() {
            drop(orders);
            // A panic of the engine was told where it happened.
            let _ = thread.join();
        }
        cut
    }
}
