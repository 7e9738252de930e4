//! Ctrl-C and signals to end: the first cancels the cook, the second leaves at once.

use crate::exit::{Exit, Trouble};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

static CANCEL: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
static SIGNALS: AtomicUsize = AtomicUsize::new(0);

/// The flag that cancels a cook, raised by the first signal. Call once.
///
/// # Errors
/// Where the system refuses.
pub fn cancelled_by_signals() -> Result<Arc<AtomicBool>, Trouble> {
    ctrlc::set_handler(|| {
        if SIGNALS.fetch_add(1, Ordering::Relaxed) > 0 {
            // Bars may stand where the next prompt comes.
            crate::output::say("");
            std::process::exit(i32::from(Exit::Cancelled as u8));
        }
        CANCEL.store(true, Ordering::Relaxed);
    })?;
    Ok(Arc::clone(&CANCEL))
}

/// Whether a signal came.
pub fn came() -> bool {
    SIGNALS.load(Ordering::Relaxed) > 0
}
