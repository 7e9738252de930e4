//! Features and networks of the toy head, for tests of the nodes that train and solve.

use crate::rig::toy;
use crate::solve::{GraphFeatures, TrainRegions};
use crate::testing::{compute, made};
use crate::values::Networks;
use face_math::data::{Curves, Features, Markers, Regions};
use face_math::rig::MarkerRig;
use graph_core::node::{Inputs, Port};
use serde_json::json;
use std::sync::LazyLock;

const MARKERS: Port<Markers> = Port::new("markers", "");
const NEUTRAL: Port<Markers> = Port::new("neutral", "");
const REGIONS: Port<Regions> = Port::new("regions", "");
const FEATURES: Port<Features> = Port::new("features", "");
const CURVES: Port<Curves> = Port::new("curves", "");
const NETWORKS: Port<Networks> = Port::new("networks", "");

/// The toy's features under `curves`.
pub(crate) fn features(curves: &Curves) -> Features {
    let markers = MarkerRig::attached(&toy::rig(), &toy::attachment()).unwrap().drive(curves).unwrap();
    let inputs =
        Inputs::default().with(&MARKERS, markers).with(&NEUTRAL, toy::neutral()).with(&REGIONS, toy::regions());
    compute(&GraphFeatures::default(), &inputs).unwrap().get(&FEATURES).unwrap().clone()
}

/// What `train_regions` is given: features of `curves`, the curves, the toy's regions.
pub(crate) fn training(curves: &Curves) -> Inputs {
    Inputs::default().with(&FEATURES, features(curves)).with(&CURVES, curves.clone()).with(&REGIONS, toy::regions())
}

/// A small, quick `train_regions`.
pub(crate) fn small(epochs: usize) -> TrainRegions {
    made(json!({
        "width": 32, "blocks": 1, "dropout": 0.0, "learning_rate": 3e-3, "epochs": epochs, "schedule": {"one_cycle": {}},
    }))
}

/// Networks trained on 500 frames of the toy, made once.
pub(crate) fn networks() -> Networks {
    static NETWORKS_MADE: LazyLock<Networks> = LazyLock::new(|| {
        let outputs = compute(&small(60), &training(&toy::curves(500, 1))).unwrap();
        outputs.get(&NETWORKS).unwrap().clone()
    });
    NETWORKS_MADE.clone()
}
