//! How `train_regions` trains: what it is given is checked, each region gets its settings, and one run trains them all.

pub(super) mod checks;
mod run;
mod settings;
#[cfg(test)]
pub(crate) mod toy;

pub(super) use run::{Job, train_all};
pub(super) use settings::{RegionSettings, Settled};
