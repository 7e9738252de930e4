//! The writer: one thread that puts results into the store in the order in which they come, so that nobody who needs a result
//! waits for the disk. A cook is over when everything is written.

use super::slot::Slot;
use crate::store::{Action, Pack, PackWriter, Store, StoreError};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use wire::Digest;

/// Orders that may wait; who brings more waits for the disk, so that results do not pile up in memory.
const WAITING: usize = 64;

/// What is to be written.
enum Order {
    /// The value of a slot.
    Value(Arc<Slot>, Pack),
    /// The outputs of a computation, whose checkpoints are of no use any more.
    Action(Digest, Box<Action>),
}

/// Takes orders, and carries them out on a thread of its own.
#[derive(Debug)]
pub(crate) struct Writer {
    store: Arc<Store>,
    orders: Mutex<Option<SyncSender<Order>>>,
    state: Arc<State>,
}

#[derive(Debug, Default)]
struct State {
    standing: Mutex<Standing>,
    idle: Condvar,
}

#[derive(Debug, Default)]
struct Standing {
    open: usize,
    failed: bool,
    problem: Option<StoreError>,
}

impl State {
    fn standing(&self) -> MutexGuard<'_, Standing> {
        self.standing.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Writer {
    /// A writer into `store`, which begins its thread with the first order.
    pub fn new(store: Arc<Store>) -> Self {
        Self { store, orders: Mutex::new(None), state: Arc::default() }
    }

    /// Writes the value of `slot`, whose blocks are in `blocks`.
    pub fn value(&self, slot: &Arc<Slot>, blocks: &PackWriter) {
        let pack = blocks.finish(&slot.kind);
        slot.will_be_stored(pack.clone());
        self.order(Order::Value(Arc::clone(slot), pack));
    }

    /// Writes what the computation under `key` gave, after the values that it names.
    pub fn action(&self, key: Digest, action: Action) {
        self.order(Order::Action(key, Box::new(action)));
    }

    fn order(&self, order: Order) {
        self.state.standing().open += 1;
        let mut orders = self.orders.lock().unwrap_or_else(PoisonError::into_inner);
        let sender = orders.get_or_insert_with(|| {
            let (sender, receiver) = sync_channel(WAITING);
            let (store, state) = (Arc::clone(&self.store), Arc::clone(&self.state));
            std::thread::spawn(move || carry_out(&receiver, &store, &state));
            sender
        });
        let sender = sender.clone();
        drop(orders);
        // The thread lives as long as there is a sender.
        let _ = sender.send(order);
    }

    /// Waits until everything is written.
    pub fn finish(&self) {
        let mut standing = self.state.standing();
        while standing.open > 0 {
            standing = self.state.idle.wait(standing).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Why the store takes nothing any more, told once.
    pub fn problem(&self) -> Option<StoreError> {
        self.state.standing().problem.take()
    }
}

fn carry_out(orders: &Receiver<Order>, store: &Store, state: &State) {
    for order in orders {
        let given_up = state.standing().failed;
        let done = if given_up { Ok(()) } else { order.carry_out(store) };
        if let Order::Value(slot, _) = &order {
            if given_up || done.is_err() { slot.will_not_be_stored() } else { slot.now_stored() }
        }
        let mut standing = state.standing();
        if let Err(problem) = done {
            standing.failed = true;
            standing.problem = Some(problem);
        }
        standing.open -= 1;
        if standing.open == 0 {
            state.idle.notify_all();
        }
    }
}

impl Order {
    fn carry_out(&self, store: &Store) -> Result<(), StoreError> {
        match self {
            Self::Value(slot, pack) => store.put_pack(&slot.digest, pack),
            Self::Action(key, action) => {
                store.put_action(key, action)?;
                store.drop_checkpoints(key);
                Ok(())
            }
        }
    }
}
