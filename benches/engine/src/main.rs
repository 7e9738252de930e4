//! The engine beside salsa, in one run: what a node costs cold, what nothing costs, what an edit costs. CPU time of the
//! whole process, the least of several rounds, both sides in turn.
//!
//!     cargo run --release --manifest-path benches/Cargo.toml -p engine-bench [ROUNDS] [GRAPH]

mod node;
mod ours;
mod shape;
mod theirs;

use cpu_time::ProcessTime;
use shape::Shape;

/// Microseconds of CPU time that `work` takes, and what it gives.
pub fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = ProcessTime::now();
    let given = work();
    (start.elapsed().as_secs_f64() * 1e6, given)
}

/// What one round measured, in microseconds.
#[derive(Debug, Clone, Copy)]
pub struct Round {
    /// Planning: reading the graph's text and making the plan; for salsa, setting the inputs.
    pub plan: f64,
    /// The first cook of every node.
    pub cold: f64,
    /// A cook where nothing changed.
    pub nothing: f64,
    /// A parameter whose cone is 1% of the nodes.
    pub edit: f64,
    /// A parameter of the first node whose result stays equal.
    pub cut_off: f64,
}

fn least(rounds: &[Round], of: fn(&Round) -> f64) -> f64 {
    rounds.iter().map(of).fold(f64::INFINITY, f64::min)
}

fn main() {
    let rounds: usize = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(5);
    let only = std::env::args().nth(2).unwrap_or_default();
    println!("CPU microseconds, the least of {rounds} rounds\n");
    println!(
        "{:<16} {:<8} {:>12} {:>12} {:>10} {:>12} {:>10}",
        "graph", "engine", "plan/node", "cold/node", "nothing", "1% edit", "cut-off"
    );
    for shape in [
        Shape { name: "chain 10,000", layers: 10_000, width: 1 },
        Shape { name: "wide 100 x 100", layers: 100, width: 100 },
        Shape { name: "wide 1,000 x 100", layers: 1_000, width: 100 },
        Shape { name: "chain 100,000", layers: 100_000, width: 1 },
    ] {
        if !shape.name.contains(&only) {
            continue;
        }
        let (mut own, mut peer) = (Vec::new(), Vec::new());
        for _ in 0..rounds {
            own.push(ours::round(&shape));
            peer.push(theirs::round(&shape));
        }
        let nodes = (shape.layers * shape.width) as f64;
        for (name, rounds) in [("grimace", &own), ("salsa", &peer)] {
            println!(
                "{:<16} {:<8} {:>12.3} {:>12.3} {:>10.2} {:>12.1} {:>10.2}",
                shape.name,
                name,
                least(rounds, |round| round.plan) / nodes,
                least(rounds, |round| round.cold) / nodes,
                least(rounds, |round| round.nothing),
                least(rounds, |round| round.edit),
                least(rounds, |round| round.cut_off),
            );
        }
    }
}
