//! What stands between the bindings and the machine: memory that the host fills, last words of a panic, and the host's
//! functions, which natively do nothing.

#[cfg(target_arch = "wasm32")]
use crate::bindings::grimace::node::host;
use std::alloc::{Layout, alloc, dealloc};

/// Says something to whoever reads the log; natively to nobody.
pub fn log(message: &str) {
    #[cfg(target_arch = "wasm32")]
    host::log(host::Level::Info, message);
    #[cfg(not(target_arch = "wasm32"))]
    let _ = message;
}

/// Tells progress, and asks whether to stop.
pub(crate) fn progress(fraction: f64, numbers: &[(&str, f64)]) -> bool {
    #[cfg(target_arch = "wasm32")]
    {
        let numbers: Vec<(String, f64)> = numbers.iter().map(|(name, number)| ((*name).to_owned(), *number)).collect();
        host::progress(fraction, &numbers)
    }
    #[cfg(not(target_arch = "wasm32"))]
    {
        let _ = (fraction, numbers);
        false
    }
}

/// Lets panics tell the host their message before they trap.
#[doc(hidden)]
pub fn listen() {
    #[cfg(target_arch = "wasm32")]
    {
        static ONCE: std::sync::Once = std::sync::Once::new();
        ONCE.call_once(|| {
            std::panic::set_hook(Box::new(|panic| host::log(host::Level::Panic, &panic.to_string())));
        });
    }
}

/// Memory that is freed when this is dropped.
pub(crate) struct Cleanup {
    pointer: *mut u8,
    layout: Layout,
}

impl Cleanup {
    /// Memory of the given layout; none where it is empty.
    pub fn new(layout: Layout) -> (*mut u8, Option<Self>) {
        if layout.size() == 0 {
            return (std::ptr::null_mut(), None);
        }
        // SAFETY: the layout is not empty.
        let pointer = unsafe { alloc(layout) };
        if pointer.is_null() {
            std::alloc::handle_alloc_error(layout);
        }
        (pointer, Some(Self { pointer, layout }))
    }

    /// Leaves the memory to whoever holds the pointer.
    pub fn forget(self) {
        std::mem::forget(self);
    }
}

impl Drop for Cleanup {
    fn drop(&mut self) {
        // SAFETY: `new` allocated it with this layout, and `forget` keeps it from being freed here as well.
        unsafe { dealloc(self.pointer, self.layout) };
    }
}

/// Constructors of libraries: there are none.
#[cfg(target_arch = "wasm32")]
pub(crate) fn run_ctors_once() {}

/// Memory for the host to put values in.
///
/// # Safety
/// As the component model asks for: the host hands on what an earlier call gave, with its size.
#[cfg(target_arch = "wasm32")]
#[unsafe(no_mangle)]
unsafe extern "C" fn cabi_realloc(old: *mut u8, old_size: usize, align: usize, new_size: usize) -> *mut u8 {
    // SAFETY: align is a power of two that the component model chose, and sizes fit into this machine's memory.
    let layout = unsafe { Layout::from_size_align_unchecked(if old_size == 0 { new_size } else { old_size }, align) };
    if new_size == 0 {
        return align as *mut u8;
    }
    // SAFETY: the layout is not empty, or is that of the memory at `old`.
    let pointer = unsafe { if old_size == 0 { alloc(layout) } else { std::alloc::realloc(old, layout, new_size) } };
    if pointer.is_null() {
        std::alloc::handle_alloc_error(layout);
    }
    pointer
}

/// Keeps `cabi_realloc` from being dropped by the linker.
pub(crate) fn maybe_link_cabi_realloc() {
    #[cfg(target_arch = "wasm32")]
    #[used]
    static KEEP: unsafe extern "C" fn(*mut u8, usize, usize, usize) -> *mut u8 = cabi_realloc;
}
