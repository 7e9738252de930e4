//! The one WebAssembly engine of the process, and the clock that interrupts what runs in it.

use std::sync::{Condvar, LazyLock, Mutex, PoisonError};
use std::time::Duration;
use wasmtime::{Config, Enabled, Engine, PoolingAllocationConfig};

/// How often running plugins are interrupted to look at the time and for a cancellation.
pub(crate) const TICK: Duration = Duration::from_millis(10);

/// The stack of a plugin, in bytes. It lies on that of the thread that runs it, whose size is at least 2 MiB.
const STACK_BYTES: usize = 512 * 1024;

/// Evaluations that may run at once; their address space is set aside, and no memory before it is used.
const AT_ONCE: u32 = 512;
/// Instances that one component may be made of: compilers make three, interpreters tens.
const INSTANCES: u32 = 1000;
/// Entries that a table of a plugin may have.
pub(crate) const TABLE_ENTRIES: usize = 100_000;
/// Bytes of a memory that are wiped and kept for the next evaluation instead of given back to the system, which would have
/// to find every page anew.
const KEPT_BYTES: usize = 48 << 20;

static ENGINE: LazyLock<Result<Engine, String>> = LazyLock::new(|| {
    let mut config = Config::new();
    config
        .wasm_component_model(true)
        .epoch_interruption(true)
        .max_wasm_stack(STACK_BYTES)
        // The same bits on every machine of an architecture: relaxed instructions behave as one of their choices.
        .relaxed_simd_deterministic(true);
    let pooled = Engine::new(config.clone().allocation_strategy(pool()));
    // Where so much address space cannot be set aside, each evaluation asks for its own.
    pooled.or_else(|_| Engine::new(&config)).map_err(|problem| format!("{problem:#}"))
});

/// Memories that evaluations take turns in. Each is wiped before the next has it.
fn pool() -> PoolingAllocationConfig {
    let mut pool = PoolingAllocationConfig::new();
    pool.total_memories(AT_ONCE)
        .total_tables(AT_ONCE * 4)
        .total_core_instances(AT_ONCE * 8)
        .total_component_instances(AT_ONCE * 2)
        .max_core_instances_per_component(INSTANCES)
        .max_memories_per_component(16)
        .max_memories_per_module(16)
        .max_tables_per_component(INSTANCES)
        .max_tables_per_module(16)
        .max_memory_size(1 << 32)
        .table_elements(TABLE_ENTRIES)
        .linear_memory_keep_resident(KEPT_BYTES)
        .table_keep_resident(1 << 16)
        .pagemap_scan(Enabled::Auto);
    pool
}

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
