//! Tests of [`Autoencoder`]: learning, rest, and gradients by finite differences.

#![allow(clippy::float_cmp, reason = "rest is exactly 0")]

use super::*;

/// 12 values that 2 numbers and a condition make.
fn samples(rows: usize) -> (Matrix, Matrix) {
    let mut random = Stream::new(4, Use::Dropout, 0);
    let drives: Vec<[f32; 3]> = (0..rows).map(|_| [0; 3].map(|_| 2.0 * random.unit() - 1.0)).collect();
    let values = Matrix::from_fn(rows, 12, |row, column| {
        let ([a, b, c], phase) = (drives[row], column as f32);
        0.1 * (a * phase.sin() + b * (1.7 * phase).cos() + 0.5 * c * (phase - 3.0).sin() + 0.2 * a * b)
    });
    (values, Matrix::from_fn(rows, 1, |row, _| 0.3 * drives[row][2]))
}

fn quick() -> AutoencoderTraining {
    AutoencoderTraining { hidden: 24, latent: 3, epochs: 150, batch: 32, learning_rate: 0.03, ..Default::default() }
}

#[test]
fn it_learns_and_keeps_rest_exactly() {
    let (values, conditions) = samples(400);
    let (network, losses) = train_autoencoder(&quick(), &values, &conditions, |_, _| true).unwrap();
    assert!(losses[149] < 0.02 && losses[149] < 0.1 * losses[0], "{} {}", losses[0], losses[149]);
    assert_eq!(network.reconstruct(&[0.0; 12], &[0.0]), [0.0; 12]);
    let again = train_autoencoder(&quick(), &values, &conditions, |_, _| true).unwrap().0;
    assert_eq!(again, network);
}

#[test]
fn gradients_equal_finite_differences() {
    let (values, conditions) = samples(5);
    let settings = AutoencoderTraining { epochs: 3, ..quick() };
    let (mut network, _) = train_autoencoder(&settings, &values, &conditions, |_, _| true).unwrap();
    let wide = |matrix: &Matrix| matrix.values().iter().map(|value| f64::from(*value)).collect::<Vec<_>>();
    let (values, conditions) = (wide(&values), wide(&conditions));
    let gradients = network.gradients(&values, &conditions).1;
    let step = 1e-6;
    for (layer, (exact, _)) in gradients.iter().enumerate() {
        for place in (0..network.layers[layer].weights.len()).step_by(37) {
            let mut mean = |by: f64| {
                network.layers[layer].weights[place] += by;
                let loss = network.gradients(&values, &conditions).0 / values.len() as f64;
                network.layers[layer].weights[place] -= by;
                loss
            };
            let slope = (mean(step) - mean(-step)) / (2.0 * step);
            let exact = exact[place];
            assert!((slope - exact).abs() < 1e-6 * (1.0 + exact.abs()), "{layer} {place}: {slope} {exact}");
        }
    }
    let by: Vec<f64> = (0..60).map(|at| f64::from(at % 7) - 3.0).collect();
    let pulled = network.pull_back(&values, &conditions, &by);
    for place in 0..60 {
        let sum = |shift: f64| {
            let mut moved = values.clone();
            moved[place] += shift;
            network.reconstruct(&moved, &conditions).iter().zip(&by).map(|(a, b)| a * b).sum::<f64>()
        };
        let slope = (sum(step) - sum(-step)) / (2.0 * step);
        assert!((slope - pulled[place]).abs() < 1e-6 * (1.0 + slope.abs()), "{place}: {slope} {}", pulled[place]);
    }
}

#[test]
fn what_cannot_be_trained_is_named() {
    let (values, conditions) = samples(6);
    let train = |settings: &AutoencoderTraining, conditions: &Matrix| {
        train_autoencoder(settings, &values, conditions, |_, _| true)
    };
    assert!(train(&quick(), &conditions.slice_rows(0, 5)).unwrap_err().to_string().contains("rows of conditions"));
    assert!(train(&AutoencoderTraining { latent: 0, ..quick() }, &conditions).is_err());
    assert!(matches!(
        train_autoencoder(&quick(), &values, &conditions, |_, _| false),
        Err(TrainError::Cancelled { epoch: 1, .. })
    ));
}
