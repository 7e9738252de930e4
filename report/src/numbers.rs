//! Numbers that the graph measured: scores, and how the training of networks went.

use crate::ReportError;
use crate::html::{Section, figure, table};
use graph_core::cook::Engine;
use nodes::values::{Networks, Scores};
use plot::{Ink, Line, Plot, escaped};
use std::sync::Arc;
use wire::{Data, Value};

/// Names of a score that are told, the worst.
const WORST: usize = 5;

/// All values of a type that the graph gave, each with the cell and item that gave it.
fn all_of<T: Data>(engine: &mut Engine) -> Result<Vec<(String, Arc<T>)>, ReportError> {
    let mut places = Vec::new();
    for cell in engine.cells() {
        let card = &engine.plan().nodes[cell.node].card;
        for (port, record) in &cell.outputs {
            if card.output(port).is_some_and(|port| port.kind.name == T::NAME) {
                let each = record.values().into_iter();
                places.extend(each.map(|(item, _)| (cell.id, cell.name.to_owned(), *port, item.to_owned())));
            }
        }
    }
    let mut found = Vec::new();
    for (cell, name, port, item) in places {
        let value: Arc<dyn Value> = engine.value(cell, port, &item)?;
        let name = if item.is_empty() { name } else { format!("{name}/{item}") };
        found.extend(value.downcast_arc::<T>().map(|value| (name, value)));
    }
    Ok(found)
}

/// What was measured against known results.
pub(crate) fn scores(engine: &mut Engine) -> Result<Option<Section>, ReportError> {
    let scores = all_of::<Scores>(engine)?;
    if scores.is_empty() {
        return Ok(None);
    }
    let row = |(name, score): &(String, Arc<Scores>)| {
        let mut worst: Vec<_> = score.by_name.iter().collect();
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let worst: Vec<String> =
            worst.into_iter().take(WORST).map(|(name, number)| format!("{} {number:.4}", escaped(name))).collect();
        (String::new(), vec![escaped(name), escaped(&score.what), worst.join(", "), format!("{:.5}", score.overall)])
    };
    let rows: Vec<_> = scores.iter().map(row).collect();
    let body = table("What was measured, and where it is worst", &["node", "what", "worst", "overall"], 3, &rows);
    Ok(Some(Section { id: "scores", title: "Scores", body }))
}

/// Losses of trained networks over their epochs.
pub(crate) fn losses(engine: &mut Engine) -> Result<Option<Section>, ReportError> {
    let networks = all_of::<Networks>(engine)?;
    if networks.is_empty() {
        return Ok(None);
    }
    let mut body = String::from(
        "<p>The mean loss of each epoch; 1 is what a network would have that always gives the mean.</p>\n<div class=\"row\">\n",
    );
    for (name, networks) in &networks {
        let line = |region: &nodes::values::RegionNetwork| {
            let points: Vec<_> =
                region.training.losses.iter().enumerate().map(|(epoch, loss)| ((epoch + 1) as f64, *loss)).collect();
            Line { name: region.region.clone(), dots: points.len() < 3, points }
        };
        let (width_px, height_px) = (560.0, 340.0);
        let plot = Plot {
            title: name.clone(),
            x_label: "epoch".to_owned(),
            y_label: "loss".to_owned(),
            from_zero: true,
            width_px,
            height_px,
            lines: networks.regions.iter().map(line).collect(),
        };
        body += &figure(&plot::draw(&plot, &Ink::PAGE), &format!("{name}: {}", networks.summary()));
    }
    Ok(Some(Section { id: "training", title: "Training", body: body + "</div>\n" }))
}
