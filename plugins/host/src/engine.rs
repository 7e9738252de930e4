//! The one WebAssembly engine of the process, and the clock that interrupts what runs in it.

use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use std::time::Duration;
use wasmtime::{Config, Engine};

/// How often running plugins are interrupted to look at the time and for a cancellation.
pub(crate) const TICK: Duration = Duration::from_millis(10);

/// The stack of a plugin, in bytes. It lies on that of the thread that runs it, whose size is at least 2 MiB.
const STACK_BYTES: usize = 512 * 1024;

static ENGINE: LazyLock<Result<Engine, String>> = LazyLock::new(|| {
    let mut config = Config::new();
    config
        .wasm_component_model(true)
        .epoch_interruption(true)
        .max_wasm_stack(STACK_BYTES)
        // The same bits on every machine of an architecture: relaxed instructions behave as one of their choices.
        .relaxed_simd_deterministic(true);
    Engine::new(&config).map_err(|problem| format!("{problem:#}"))
});

/// The engine of this process.
///
/// # Panics
/// Where this machine cannot run compiled WebAssembly at all, which the settings above do not depend on.
pub(crate) fn engine() -> &'static Engine {
    ENGINE.as_ref().expect("the settings of the engine are fixed and fit every machine that it is built for")
}

/// What compiled code and results depend on beside a plugin's own bytes.
pub(crate) fn identity() -> String {
    format!("wasmtime {} on {}", env!("WASMTIME_VERSION"), std::env::consts::ARCH)
}

static RUNNING: Mutex<usize> = Mutex::new(0);
static MORE: Condvar = Condvar::new();
static CLOCK: LazyLock<()> = LazyLock::new(|| {
    let tick = || loop {
        let running = RUNNING.lock().unwrap_or_else(PoisonError::into_inner);
        drop(MORE.wait_while(running, |running| *running == 0).unwrap_or_else(PoisonError::into_inner));
        std::thread::sleep(TICK);
        engine().increment_epoch();
    };
    let clock = std::thread::Builder::new().name("plugin clock".to_owned()).stack_size(64 * 1024).spawn(tick);
    // Without a thread for the clock, nothing could be interrupted; then nothing runs (see `Ticking::begin`).
    CLOCK_RUNS.store(clock.is_ok(), std::sync::atomic::Ordering::Relaxed);
});
static CLOCK_RUNS: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);

/// The clock ticks while one of these lives.
pub(crate) struct Ticking(());

impl Ticking {
    /// Lets the clock tick; `None` where it cannot.
    pub fn begin() -> Option<Self> {
        LazyLock::force(&CLOCK);
        if !CLOCK_RUNS.load(std::sync::atomic::Ordering::Relaxed) {
            return None;
        }
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        MORE.notify_one();
        Some(Self(()))
    }
}

impl Drop for Ticking {
    fn drop(&mut self) {
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
    }
}
