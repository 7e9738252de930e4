//! A node costs no more in a large graph than in a small one, and no graph is too deep for a thread's stack.

use crate::world::{Number, Project};
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use graph_core::register;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;

const BEFORE: Port<Number> = Port::new("before", "a number");
const NEXT: Port<Number> = Port::new("next", "one more");

/// Counts on. So little that it is computed without a thread's help.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
struct CountOn {}

register!(CountOn);

#[typetag::serde(name = "count_on")]
impl Node for CountOn {
    fn card(&self) -> Card {
        Card::new("work").may_take(&BEFORE).gives(&NEXT)
    }
    fn compute(&self, _: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
        let before = inputs.may_get(&BEFORE)?.map_or(0.0, |number| number.0);
        Ok(Outputs::default().with(&NEXT, Number(before + 1.0)))
    }
}

/// Seconds a node that the first cook of a chain of `nodes` takes.
fn seconds_a_node(nodes: usize) -> f64 {
    let mut graph = "(grimace: 1, nodes: {\n\"n0\": (kind: \"count_on\"),\n".to_owned();
    for node in 1..nodes {
        writeln!(graph, "\"n{node}\": (kind: \"count_on\", in: {{\"before\": \"n{}\"}}),", node - 1).unwrap();
    }
    let mut project = Project::new(&(graph + "})"));
    project.options.keep_cheap = false;
    let cooked = project.cook();
    assert_eq!(cooked.summary.cooked, nodes);
    cooked.summary.seconds / nodes as f64
}

#[test]
fn cost_a_node_does_not_grow_with_the_graph() {
    // Other tests run beside this one, so the best of a few counts.
    let least = |nodes: usize| (0..3).map(|_| seconds_a_node(nodes)).fold(f64::INFINITY, f64::min);
    let (small, large) = (least(2_000), least(20_000));
    assert!(large < 3.0 * small, "a node costs {:.1} µs of 2,000, and {:.1} of 20,000", small * 1e6, large * 1e6);
}
