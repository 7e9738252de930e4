//! What a trained network promises: rows do not touch each other, storing keeps every bit, wrong tables are refused.

#![allow(clippy::unwrap_used, clippy::float_cmp, reason = "a test ends at the first surprise")]

use learn::{Architecture, Matrix, Network, PredictError, Samples, Table, Training, train};

fn wave(row: usize, column: usize) -> f32 {
    ((row * 31 + column * 17) as f32 * 0.37).sin()
}

fn network(inputs: usize, width: usize, blocks: usize, conditions: usize) -> Network {
    let rows = 40;
    let tables = [inputs, conditions, 5].map(|columns| Matrix::from_fn(rows, columns, wave));
    let architecture = Architecture { conditions, ..Architecture::new(inputs, 5, width, blocks) };
    let training = Training { epochs: 2, batch: 16, ..Training::default() };
    let conditions = (conditions > 0).then_some(&tables[1]);
    let samples = Samples { conditions, ..Samples::new(&tables[0], &tables[2]) };
    train(&architecture, &training, &samples, &()).unwrap()
}

#[test]
fn rows_have_the_same_bits_in_any_block() {
    for (inputs, width, blocks, conditions) in [(13, 20, 1, 0), (131, 67, 2, 3), (300, 128, 3, 4)] {
        let network = network(inputs, width, blocks, conditions);
        let rows = 203;
        let many = Matrix::from_fn(rows, inputs, |row, column| wave(row + 3, column));
        let beside = Matrix::from_fn(rows, conditions, |row, column| wave(row, column + 9));
        let predict = |first: usize, count: usize| {
            let beside = (conditions > 0).then(|| beside.slice_rows(first, count));
            network.predict(&many.slice_rows(first, count), beside.as_ref()).unwrap()
        };
        let whole = predict(0, rows);
        for block in [1, 7, 32, 96, 97] {
            for first in (0..rows).step_by(block) {
                let count = block.min(rows - first);
                let part = predict(first, count);
                let same = part
                    .values()
                    .iter()
                    .zip(whole.slice_rows(first, count).values())
                    .all(|(a, b)| a.to_bits() == b.to_bits());
                assert!(same, "rows {first}.. in blocks of {block} differ");
            }
        }
    }
}

#[test]
fn storing_keeps_every_bit() {
    let network = network(13, 20, 2, 3);
    let read: Network = postcard::from_bytes(&postcard::to_stdvec(&network).unwrap()).unwrap();
    assert_eq!(read, network);
    let read: Network = serde_json::from_str(&serde_json::to_string(&network).unwrap()).unwrap();
    assert_eq!(read, network);
    let names: Vec<&str> = network.parameters().iter().map(|parameter| parameter.name.as_str()).collect();
    assert_eq!(names[..4], ["input.weight", "input.bias", "block0.open.weight", "block0.open.bias"]);
    assert_eq!(names[10..], ["head.weight", "head.bias", "output.weight", "output.bias"]);
}

#[test]
fn damaged_networks_are_refused() {
    let network = network(13, 20, 1, 0);
    let good = serde_json::to_value(&network).unwrap();
    let error_of = |value| serde_json::from_value::<Network>(value).unwrap_err().to_string();

    let mut renamed = good.clone();
    renamed["parameters"][2]["name"] = "block7.open.weight".into();
    assert!(error_of(renamed).contains("block0.open.weight (20 x 20)"));
    let mut short = good.clone();
    short["parameters"].as_array_mut().unwrap().pop();
    assert!(error_of(short).contains("parameter 9 is missing"));
    let mut flat = good.clone();
    flat["scalings"]["inputs"]["scale"][4] = 0.0.into();
    assert!(error_of(flat).contains("scale that is not positive"));
    let mut wide = good;
    wide["architecture"]["width"] = 21.into();
    assert!(error_of(wide).contains("parameter 0"));
}

#[test]
fn wrong_tables_are_named() {
    let network = network(13, 20, 1, 3);
    let good = Matrix::from_fn(4, 13, wave);
    let missing = network.predict(&good, None).unwrap_err();
    assert_eq!(missing, PredictError::Columns { table: Table::Conditions, found: 0, expected: 3 });
    let short = network.predict(&good, Some(&Matrix::from_fn(3, 3, wave))).unwrap_err();
    assert_eq!(short, PredictError::Rows { found: 3, expected: 4 });
    let hole = Matrix::from_fn(4, 13, |row, column| if (row, column) == (2, 5) { f32::INFINITY } else { 0.0 });
    let error = network.predict(&hole, Some(&Matrix::from_fn(4, 3, wave))).unwrap_err();
    assert!(matches!(error, PredictError::NonFinite { table: Table::Inputs, row: 2, column: 5, .. }), "{error}");
    let huge = Matrix::from_fn(4, 13, |row, _| if row == 3 { 3e38 } else { 0.0 });
    let error = network.predict(&huge, Some(&Matrix::from_fn(4, 3, wave))).unwrap_err();
    assert!(matches!(error, PredictError::Overflow { row: 3, .. }), "{error}");
}

#[test]
fn no_rows_are_no_error() {
    let network = network(13, 20, 1, 0);
    let nothing = network.predict(&Matrix::from_fn(0, 13, wave), None).unwrap();
    assert_eq!((nothing.rows(), nothing.columns()), (0, 5));
}
