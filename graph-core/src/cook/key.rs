//! Keys: key(cell) = hash(kind, version, code of plugins, canonical parameters, content of files, content of inputs).
//! Nothing else enters: no path, host, thread count or name.

use super::cell::{Cell, Link, Settings};
use crate::document::canonical_parameters;
use crate::node::{Card, Node, Time};
use std::ops::Range;
use std::path::Path;
use wire::{Digest, Hasher};

/// Raise this when the engine itself changes what a key means.
const ENGINE: u64 = 2;

/// One part of a key, labelled for `why`.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    pub label: String,
    pub digest: Digest,
    /// What it says, for people: cut where it is long.
    pub text: String,
}

/// Letters of a value that are kept to tell people what it was.
const SHOWN: usize = 60;

/// The beginning of a text.
pub(crate) fn shown(text: &str) -> String {
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

impl Settings {
    /// The parts that come from the node itself: kind, version, code and parameters without the names of files.
    pub fn of(node: &dyn Node, card: &Card) -> Self {
        let kind = node.typetag_name();
        let version = Hasher::new(kind).number(u64::from(card.version)).number(ENGINE).finish();
        let text = format!("{kind} {}", card.version);
        let mut parts = vec![Part { label: "version".into(), digest: version, text }];
        for code in &card.code {
            parts.push(Part { label: code.label.to_owned(), digest: code.digest, text: shown(&code.text) });
        }
        let skipped: Vec<&str> = card.reads.into_iter().chain(card.writes).collect();
        for (name, text) in canonical_parameters(node, &skipped) {
            let digest = Digest::of(text.as_bytes());
            parts.push(Part { label: format!("parameter `{name}`"), digest, text: shown(&text) });
        }
        let mut hasher = Hasher::new("settings");
        for part in &parts {
            hasher.bytes(part.label.as_bytes()).digest(&part.digest);
        }
        Self { digest: hasher.finish(), parts }
    }
}

/// What is computed, and over which ports: the beginning of a cell's key, known before its inputs are.
pub(crate) fn frame_of(settings: &Settings, reads_file: bool, links: &[Link]) -> Digest {
    let mut hasher = Hasher::new("cell");
    hasher.digest(&settings.digest).number(u64::from(reads_file)).number(links.len() as u64);
    for link in links {
        hasher.bytes(link.port.name.as_bytes());
    }
    hasher.finish()
}

/// The key of a cell: how it begins, the content of its file, and that of every input.
pub(crate) fn key_of(frame: &Digest, file: Option<&Digest>, inputs: &[Digest]) -> Digest {
    let mut hasher = Hasher::bare();
    hasher.digest(frame);
    for digest in file.into_iter().chain(inputs) {
        hasher.digest(digest);
    }
    hasher.finish()
}

/// The content of a source file as it enters keys: with its ending, by which formats are told apart.
pub(crate) fn content_of(file: &Path, content: &Digest) -> Digest {
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    Hasher::new("file").bytes(ending.as_bytes()).digest(content).finish()
}

/// How a per-frame cell is cut into blocks.
#[derive(Debug, Clone)]
pub(crate) struct Frames {
    pub count: usize,
    pub halo: usize,
    /// Frames in a block.
    pub block: usize,
}

impl Frames {
    pub fn blocks(&self) -> usize {
        self.count.div_ceil(self.block)
    }

    /// The frames that block `block` of the output covers.
    pub fn of_block(&self, block: usize) -> Range<usize> {
        super::slot::block_range(block, self.block, self.count)
    }

    /// The frames of the inputs that block `block` needs.
    pub fn with_halo(&self, block: usize) -> Range<usize> {
        self.around(&self.of_block(block))
    }

    /// The frames of the inputs that frames of the output need.
    pub fn around(&self, frames: &Range<usize>) -> Range<usize> {
        frames.start.saturating_sub(self.halo)..(frames.end + self.halo).min(self.count)
    }
}

/// The halo of a per-frame cell that has at least one time-varying input.
pub(crate) fn halo(cell: &Cell) -> Option<usize> {
    let Time::PerFrame { halo } = cell.card.time else { return None };
    cell.links.iter().any(Link::framed).then_some(halo)
}
