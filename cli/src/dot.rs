//! `grimace dot`: the graph as a drawing for Graphviz.

use crate::arguments::Dot;
use crate::exit::{Exit, Trouble};
use crate::graph::Asked;
use crate::output;

/// Prints the plan in the DOT language.
pub fn dot(arguments: &Dot) -> Result<Exit, Trouble> {
    let plan = Asked::read(&arguments.graph)?.load_or_tell()?;
    output::print(&graph_core::plan::dot(&plan))?;
    Ok(Exit::Fine)
}
