//! What whole-system tests share: projects in temporary folders, runs of the program, terminals with the editor in them, and
//! the way to test data.
//!
//! The tests stand in `tests/`: each takes the whole house as a user or a developer finds it.

mod browser;
mod data;
mod pane;
mod project;
mod run;
#[cfg(unix)]
mod watch;
mod workspace;

pub use browser::Browser;
pub use data::{skipped, test_data};
pub use pane::Pane;
pub use project::Project;
pub use run::Run;
#[cfg(unix)]
pub use watch::Watch;
pub use workspace::{Workspace, root};
