//! The two uses of `unsafe` of this crate, and why they are sound.

use graph_core::node::Context;
use std::ptr::NonNull;
use std::sync::{Mutex, PoisonError};
use wasmtime::Engine;
use wasmtime::component::Component;

/// A place in which the engine's context stands while a node computes. What runs in a store must live as long as it likes
/// (`'static`), and a context does not.
#[derive(Default)]
pub(crate) struct Lent(Mutex<Option<NonNull<Context<'static>>>>);

// SAFETY: the pointer is made from a shared reference to a `Context`, which is `Sync` (asserted below), and is only read
// through under the mutex.
unsafe impl Send for Lent {}
// SAFETY: as above.
unsafe impl Sync for Lent {}

const fn is_sync<T: Sync>() {}
const _: () = is_sync::<Context<'static>>();

struct TakeBack<'a>(&'a Lent);

impl Drop for TakeBack<'_> {
    fn drop(&mut self) {
        *self.0.0.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Lent {
    /// Runs `work` while `context` can be had through [`Lent::with`].
    pub fn lend<R>(&self, context: &Context<'_>, work: impl FnOnce() -> R) -> R {
        let pointer = NonNull::from(context).cast::<Context<'static>>();
        let _back = TakeBack(self);
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(pointer);
        work()
    }

    /// The context that is lent at this moment, for as long as `work` takes.
    pub fn with<R>(&self, work: impl FnOnce(&Context<'_>) -> R) -> Option<R> {
        let held = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: `lend` puts the pointer in and takes it out again before it returns, also when `work` unwinds, and both
        // need the mutex that is held here until `work` has returned. So the reference that the pointer was made from is
        // alive all the while. Its lifetime is shortened to that of this call: `work` takes any lifetime, so it cannot keep it.
        held.map(|pointer| work(unsafe { pointer.as_ref() }))
    }
}

/// Reads code back that [`Component::serialize`] wrote.
///
/// # Errors
/// Where the code is of another engine or another version of it.
pub(crate) fn code(engine: &Engine, bytes: &super::compiled::Sealed) -> wasmtime::Result<Component> {
    // SAFETY: `Sealed` is only made from bytes whose digest, keyed with a secret that only this user can read, shows that
    // this program wrote them after it compiled a component itself (see `compiled`). Bytes from elsewhere, damaged or cut
    // short, never get here; of another version of the engine, they are refused by the engine.
    unsafe { Component::deserialize(engine, bytes.bytes()) }
}
