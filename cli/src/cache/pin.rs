//! `grimace cache pin` and `unpin`: graphs whose results stay.

use super::{existing, graph_file};
use crate::arguments::CachePin;
use crate::exit::{Exit, Trouble};
use crate::output;
use graph_core::care;

/// Pins a graph.
pub fn pin(arguments: &CachePin) -> Result<Exit, Trouble> {
    let graph = graph_file(&arguments.graph)?;
    let store = existing(&arguments.store, &graph)?;
    let pin = care::pin(&store, &graph)?;
    output::say(&format!("pinned {}: what its last cook was made of stays in {}", pin.graph, store.root().display()));
    Ok(Exit::Fine)
}

/// Takes the pin away. A graph that is gone is known by the name under which it was pinned.
pub fn unpin(arguments: &CachePin) -> Result<Exit, Trouble> {
    let graph = crate::graph::file(&arguments.graph);
    let store = existing(&arguments.store, &graph)?;
    if care::unpin(&store, &graph)? {
        output::say(&format!("{} is pinned no more", graph.display()));
        return Ok(Exit::Fine);
    }
    let pinned: Vec<String> = care::pins(&store).into_iter().map(|(_, pin)| pin.graph).collect();
    let help = match pinned.as_slice() {
        [] => "no graph is pinned in this store".to_owned(),
        pinned => format!("pinned: {}", pinned.join(", ")),
    };
    Err(Trouble::command_line(format!("{} is not pinned", graph.display()), Some(help)))
}
