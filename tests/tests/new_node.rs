//! The node that `cargo xtask new-node` starts from compiles, and its own test passes here as it will in `nodes`.

#![allow(clippy::unwrap_used, reason = "a failing unwrap is a failing test")]

#[path = "../../xtask/src/new_node/node_name.rs"]
mod node_name;

#[test]
fn it_is_a_node_like_any_other() {
    let kind = graph_core::node::kind("node_name").unwrap();
    assert_eq!(graph_core::node::describe(kind).parameters[0].default.as_deref(), Some("1.0"));
    assert!(format!("{:?}", node_name::NodeName::default()).contains("gain"));
}

/// What the tests of nodes share, as far as the new node uses it.
mod testing {
    use graph_core::node::{Context, Host, Inputs, Node, NodeError, Outputs, SourceFile};
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    struct NoEngine;

    impl Host for NoEngine {
        fn memory_bytes(&self) -> u64 {
            1 << 30
        }

        fn progress(&self, _: f64, _: &[(&str, f64)]) {}

        fn source(&self) -> Result<SourceFile, NodeError> {
            Err(NodeError::failed("this node has no source file"))
        }

        fn sibling(&self, name: &str) -> Result<Arc<Vec<u8>>, NodeError> {
            Err(NodeError::file(name, "there is no such file"))
        }

        fn checkpoint(&self, _: &str) -> Option<Vec<u8>> {
            None
        }

        fn save_checkpoint(&self, _: &str, _: &[u8]) {}
    }

    pub fn compute(node: &dyn Node, inputs: &Inputs) -> Result<Outputs, NodeError> {
        node.compute(&Context::new(&NoEngine, &AtomicBool::new(false), ""), inputs)
    }

    pub fn made<T: serde::de::DeserializeOwned>(parameters: serde_json::Value) -> T {
        serde_json::from_value(parameters).unwrap()
    }
}
