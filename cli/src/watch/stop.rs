//! Signals of a watch: SIGINT and SIGTERM end it, the second at once; SIGHUP has it look at everything again.

use crate::exit::{Exit, Trouble};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Flags that signals raise.
#[derive(Debug, Default)]
pub struct Signals {
    /// The watch should end.
    pub stop: Arc<AtomicBool>,
    /// Everything should be looked at again.
    pub rescan: Arc<AtomicBool>,
}

impl Signals {
    /// Flags that are raised from now on. Call once.
    ///
    /// # Errors
    /// Where the system refuses.
    #[cfg(unix)]
    pub fn new() -> Result<Self, Trouble> {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        use signal_hook::flag::{register, register_conditional_shutdown};
        let signals = Self::default();
        for signal in [SIGINT, SIGTERM] {
            // First, so that it acts on the second signal only.
            register_conditional_shutdown(signal, Exit::Cancelled as i32, Arc::clone(&signals.stop))?;
            register(signal, Arc::clone(&signals.stop))?;
        }
        register(SIGHUP, Arc::clone(&signals.rescan))?;
        Ok(signals)
    }

    /// The same where there is only Ctrl-C.
    ///
    /// # Errors
    /// Where the system refuses.
    #[cfg(not(unix))]
    pub fn new() -> Result<Self, Trouble> {
        use std::sync::atomic::Ordering;
        let signals = Self::default();
        let stop = Arc::clone(&signals.stop);
        ctrlc::set_handler(move || {
            if stop.swap(true, Ordering::Relaxed) {
                std::process::exit(i32::from(Exit::Cancelled as u8));
            }
        })?;
        Ok(signals)
    }
}
