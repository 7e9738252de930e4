//! Reports: one page about a cooked graph for those who look at results and cook none. Self-contained HTML: no scripts, no fonts
//! and no pictures from elsewhere, readable in light and dark and by the keyboard alone.
//!
//! [`Told`] keeps what a cook told; [`page`] then looks at the engine: `drawing` draws the graph, `errors` find errors of markers and meshes
//! over time and the worst frames, which `faces` renders, `numbers` are scores and losses, `cells` say what was cooked and why, and `html`
//! puts it all into a page.

mod cells;
mod drawing;
mod errors;
mod faces;
mod html;
mod numbers;
mod told;

pub use told::Told;

use graph_core::cook::{Engine, LookError};
use html::Section;
use std::path::Path;

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A value cannot be looked at.
    #[error(transparent)]
    Look(#[from] LookError),
    /// A frame cannot be drawn.
    #[error("the worst frames of `{node}` cannot be drawn: {problem}")]
    Frame {
        /// The cell whose errors they are.
        node: String,
        /// What is wrong.
        problem: String,
    },
    /// A picture cannot be encoded.
    #[error(transparent)]
    Picture(#[from] face_io::WriteError),
}

/// What stands on top of a page.
#[derive(Debug, Clone)]
pub struct Heading {
    /// The graph.
    pub graph: String,
    /// What it is for.
    pub doc: Option<String>,
    /// What was set on the command line.
    pub set: Vec<String>,
    /// When the page was made.
    pub made: String,
}

/// The page about what `engine` cooked, to be written into `folder`.
///
/// # Errors
/// Where a value cannot be looked at, or a picture not be drawn.
pub fn page(engine: &mut Engine, told: &Told, heading: &Heading, folder: &Path) -> Result<String, ReportError> {
    let errors = errors::find(engine)?;
    let sections: [Option<Section>; 9] = [
        Some(drawing::section(engine)),
        errors::over_time(&errors),
        faces::worst(engine, &errors)?,
        numbers::scores(engine)?,
        numbers::losses(engine)?,
        faces::sheets(engine)?,
        faces::meshes(engine)?,
        Some(cells::section(engine)),
        cells::files(engine, folder),
    ];
    let tiles = cells::tiles(engine, told, &errors);
    Ok(html::page(heading, &tiles, told, sections.into_iter().flatten().collect()))
}
