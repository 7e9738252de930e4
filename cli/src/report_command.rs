//! `grimace report`: a page about a graph, for those who look at results and cook none.

use crate::arguments::{Global, Report};
use crate::exit::{Exit, Trouble};

/// Cooks the graph and writes the page.
pub fn report(_arguments: &Report, _global: &Global) -> Result<Exit, Trouble> {
    Ok(Exit::Fine)
}
