//! Salsa's side: the same graph as inputs and one tracked function. Its recursion needs a large stack.

use crate::shape::{Shape, mix};
use crate::{Round, timed};
use salsa::Setter;

#[salsa::db]
#[derive(Clone, Default)]
struct Database {
    storage: salsa::Storage<Self>,
}

#[salsa::db]
impl salsa::Database for Database {}

#[salsa::input]
struct Mixed {
    salt: u64,
    #[returns(ref)]
    sources: Vec<Mixed>,
}

#[salsa::tracked]
fn number(db: &dyn salsa::Database, node: Mixed) -> u64 {
    mix(*node.salt(db), node.sources(db).iter().map(|source| *number(db, *source)))
}

/// Room for the recursion of a chain of 100,000 nodes.
const STACK_BYTES: usize = 6 << 30;

pub fn round(shape: &Shape) -> Round {
    std::thread::scope(|scope| {
        let work = || measured(shape);
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES).spawn_scoped(scope, work);
        thread.expect("a thread with a large stack can be made").join().expect("salsa goes through")
    })
}

fn measured(shape: &Shape) -> Round {
    let mut db = Database::default();
    let (plan, nodes) = timed(|| {
        let mut nodes: Vec<Mixed> = Vec::with_capacity(shape.nodes());
        for node in 0..shape.nodes() {
            let sources = shape.sources(node).into_iter().map(|source| nodes[source]).collect();
            nodes.push(Mixed::new(&db, node as u64 * 2, sources));
        }
        nodes
    });
    let ends = &nodes[shape.nodes() - shape.width..];
    let ask = |db: &Database| ends.iter().map(|node| *number(db, *node)).fold(0, u64::wrapping_add);
    let (cold, first) = timed(|| ask(&db));
    let (nothing, again) = timed(|| ask(&db));
    assert_eq!(first, again);
    let (edit, edited) = timed(|| {
        nodes[shape.hundredth()].set_salt(&mut db).to(1_000_000_007 * 2);
        ask(&db)
    });
    assert_ne!(first, edited);
    let (cut_off, same) = timed(|| {
        nodes[0].set_salt(&mut db).to(1);
        ask(&db)
    });
    assert_eq!(edited, same);
    Round { plan, cold, nothing, edit, cut_off }
}
