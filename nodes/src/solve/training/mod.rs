//! How `train_regions` trains: the settings of each region, and the run that trains all of them.

mod run;
mod settings;
#[cfg(test)]
pub(crate) mod toy;

pub(super) use run::{Job, train_all};
pub(super) use settings::{RegionSettings, Settled};
