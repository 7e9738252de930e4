//! Measures the time of a training step and of a prediction at the sizes of the FDLS networks.
//!
//! `cargo run --release -p learn --example step_time [-- EPOCHS]`

#![allow(clippy::print_stdout, reason = "a measuring program speaks through its output")]

use learn::{Architecture, EpochReport, Matrix, Observer, Samples, Training, train};
use std::sync::Mutex;
use std::time::Instant;

/// Notes when each epoch ended.
struct Clock(Mutex<Vec<Instant>>);

impl Observer for Clock {
    fn epoch(&self, _report: &EpochReport) {
        if let Ok(mut ends) = self.0.lock() {
            ends.push(Instant::now());
        }
    }
}

/// Numbers that look random and differ by place.
fn noise(row: usize, column: usize) -> f32 {
    let mixed = (row * 7919 + column * 104_729 + 17).wrapping_mul(2_654_435_761) >> 7;
    (mixed % 2003) as f32 / 1001.5 - 1.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let epochs = std::env::args().nth(1).map_or(Ok(6), |count| count.parse())?;
    for (inputs, width, blocks, conditions, outputs) in
        [(1161, 800, 3, 4, 14), (3960, 300, 3, 0, 14), (1161, 500, 2, 4, 14), (300, 150, 2, 0, 4)]
    {
        let batches = 5;
        let samples = (
            Matrix::from_fn(64 * batches, inputs, noise),
            Matrix::from_fn(64 * batches, conditions, |row, column| noise(row, column + 5)),
            Matrix::from_fn(64 * batches, outputs, |row, column| noise(row, column) * noise(row, column + 1)),
        );
        let architecture =
            Architecture { conditions, dropout: 0.01, ..Architecture::new(inputs, outputs, width, blocks) };
        let training = Training { epochs, ..Training::default() };
        let given =
            Samples { conditions: (conditions > 0).then_some(&samples.1), ..Samples::new(&samples.0, &samples.2) };
        let clock = Clock(Mutex::new(Vec::new()));
        let network = train(&architecture, &training, &given, &clock)?;
        let ends = clock.0.into_inner()?;
        let mut steps: Vec<f64> =
            ends.windows(2).map(|pair| (pair[1] - pair[0]).as_secs_f64() * 1e3 / batches as f64).collect();
        steps.sort_by(f64::total_cmp);
        let rows = 1830;
        let many = Matrix::from_fn(rows, inputs, noise);
        let beside = (conditions > 0).then(|| Matrix::from_fn(rows, conditions, noise));
        network.predict(&many.slice_rows(0, 1), beside.as_ref().map(|matrix| matrix.slice_rows(0, 1)).as_ref())?;
        let start = Instant::now();
        network.predict(&many, beside.as_ref())?;
        println!(
            "{inputs:5} inputs, width {width}, {blocks} blocks ({} parameters): {:6.2} ms a step (least {:.2}, most {:.2}), \
             {rows} rows predicted in {:.0} ms",
            architecture.parameter_count(),
            steps[steps.len() / 2],
            steps[0],
            steps[steps.len() - 1],
            start.elapsed().as_secs_f64() * 1e3
        );
    }
    Ok(())
}
