//! The care of a store: how much it holds ([`statistics()`]), whether it is sound ([`verify`](verify())), what may go
//! ([`collect`](collect())), and the graphs whose results must stay ([`pin`](pin())). It knows the store and what sessions
//! name; nothing of how a cook runs.

mod collect;
mod needs;
mod pin;
mod statistics;
mod verify;

pub use collect::{Collected, Removed, Spared, collect};
pub use pin::{Pin, pin, pins, unpin};
pub use statistics::{Statistics, statistics};
pub use verify::{Finding, Verified, verify};
