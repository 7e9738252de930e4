//! The engine's side: a graph file of trivial nodes, planned, cooked, edited, cooked.

use crate::node::Mix;
use crate::shape::Shape;
use crate::{Round, timed};
use graph_core::cook::{Engine, Options};
use graph_core::node::Node;
use graph_core::plan::load;
use graph_core::store::Store;
use std::fmt::Write;
use std::sync::Arc;

fn text(shape: &Shape) -> String {
    let mut text = String::from("(grimace: 1, nodes: {\n");
    for node in 0..shape.nodes() {
        let sources = shape.sources(node);
        let wires: Vec<_> =
            ["one", "other"].iter().zip(&sources).map(|(port, from)| format!("\"{port}\": \"n{from}\"")).collect();
        let _ =
            writeln!(text, "\"n{node}\": (kind: \"mix\", in: {{{}}}, with: (salt: {})),", wires.join(", "), node * 2);
    }
    text + "})\n"
}

fn mixed(salt: u64) -> Arc<dyn Node> {
    Arc::new(Mix { salt })
}

pub fn round(shape: &Shape) -> Round {
    let folder = tempfile::tempdir().expect("a temporary folder can be made");
    let graph = folder.path().join("graph.ron");
    std::fs::write(&graph, text(shape)).expect("the graph can be written");
    let options = Options { resident: true, ..Options::default() };
    let (plan_us, mut engine) = timed(|| {
        let plan = load(&graph, &[]).expect("the graph is right");
        let store = Arc::new(Store::at(&folder.path().join("store")));
        let mut engine = Engine::new(plan, &[], store, options, Arc::default(), None).expect("the engine can be made");
        engine.unfold_now();
        engine
    });
    let cook = |engine: &mut Engine| engine.cook().expect("the cook goes through").cooked;
    let (cold, cooked) = timed(|| cook(&mut engine));
    assert_eq!(cooked, shape.nodes());
    let (nothing, cooked) = timed(|| cook(&mut engine));
    assert_eq!(cooked, 0);
    let at = shape.hundredth();
    let (edit, cooked) = timed(|| {
        engine.exchange(&format!("n{at}"), &mixed(1_000_000_007 * 2)).expect("there is such a node");
        cook(&mut engine)
    });
    assert!(cooked * 100 >= shape.nodes() && cooked * 100 <= shape.nodes() * 3, "{cooked}");
    let (cut_off, cooked) = timed(|| {
        engine.exchange("n0", &mixed(1)).expect("there is such a node");
        cook(&mut engine)
    });
    assert_eq!(cooked, 1);
    Round { plan: plan_us, cold, nothing, edit, cut_off }
}
