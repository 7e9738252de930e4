//! Publishing: writes the files that nodes made to the places that graphs name, each with a sidecar that says what it
//! came from. A file that someone changed by hand is kept beside the new one.

use super::artifact::Artifact;
use super::cell::{CellId, SlotSet};
use super::engine::Engine;
use super::event::Event;
use super::job::JobError;
use super::results::Message;
use super::slot::Slot;
use crate::files::Signature;
use crate::node::NodeError;
use crate::store::Store;
use serde_json::json;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wire::Digest;

/// A published file.
pub(crate) struct Written {
    path: PathBuf,
    signature: Signature,
    digest: Digest,
    /// Size, where it was written now; else it was already right.
    bytes: Option<usize>,
    /// Where a file that was changed by hand was put.
    kept: Option<PathBuf>,
}

impl Engine {
    /// Publishes the file of a finished writing cell, where it is not in place already.
    pub(super) fn publish(&mut self, id: CellId) {
        if self.options.dry || !self.options.publish {
            return;
        }
        let (Some(path), Some(slot)) = (self.cells[id].writes.clone(), self.file(id).cloned()) else { return };
        if self.written(id).is_some_and(|signature| stands(&path, &signature)) {
            return;
        }
        let missing = slot.absent(&self.shared.store, slot.blocks_of(None));
        if !missing.is_empty() {
            return self.remake(id, missing.into_iter().collect());
        }
        let provenance = self.provenance(id);
        self.spawn(id, move |shared| {
            let result = write_out(&path, &slot, &shared.store, provenance);
            Message::Published { cell: id, result }
        });
    }

    /// The content of the file that a cell writes.
    fn file(&self, id: CellId) -> Option<&Arc<Slot>> {
        self.cells[id].outputs().find_map(|(name, slots)| match slots {
            SlotSet::One(slot) if name == super::FILES.name() => Some(slot),
            _ => None,
        })
    }

    /// The file that a cell writes as it was last published, where that was with its present content.
    pub(super) fn written(&self, id: CellId) -> Option<Signature> {
        let (signature, digest) = self.published.get(self.cells[id].writes.as_ref()?)?;
        (*digest == self.file(id)?.digest).then_some(*signature)
    }

    /// Takes what became of a file.
    pub(super) fn published(&mut self, id: CellId, result: Result<Written, JobError>) {
        let node = self.cells[id].name.clone();
        match result {
            Ok(written) => {
                if let Some(kept) = written.kept {
                    let path = written.path.display();
                    let message =
                        format!("{path} was not as it was written; what stood there is now {}", kept.display());
                    self.tell(|| Event::Notice { about: node.clone(), message });
                }
                if let Some(bytes) = written.bytes {
                    self.summary.written += 1;
                    self.tell(|| Event::Wrote { node, path: written.path.display().to_string(), bytes });
                }
                self.published.insert(written.path, (written.signature, written.digest));
            }
            Err(JobError::Absent(_)) => self.remake(id, BTreeSet::new()),
            Err(JobError::Store(error)) => {
                self.broken.get_or_insert(error.into());
            }
            Err(JobError::Node(error)) => {
                // The value is sound; only its file is not in place.
                let place = self.plan.nodes[self.cells[id].plan].place.text();
                let kind = self.kind(id);
                self.summary.failed += 1;
                self.tell(|| Event::Failed { node, kind, error: error.to_string(), place, inputs: BTreeMap::new() });
            }
        }
    }

    /// What a file came from: its key, the graph, the inputs, all source files upstream, and the versions.
    fn provenance(&self, id: CellId) -> serde_json::Value {
        let cell = &self.cells[id];
        let mut inputs = serde_json::Map::new();
        for link in &cell.links {
            for wire in &link.wires {
                let digest = self.wire_digest(wire).map(|digest| digest.hex());
                let from = {
                    let producer = &self.cells[wire.cell];
                    format!("{}.{}", producer.name, producer.card.outputs[wire.output].name)
                };
                inputs.insert(link.port.name.to_owned(), json!({ "from": from, "digest": digest }));
            }
        }
        let (mut open, mut seen) = (vec![id], BTreeSet::new());
        let (mut sources, mut versions) = (BTreeMap::new(), BTreeMap::new());
        while let Some(id) = open.pop() {
            if !seen.insert(id) {
                continue;
            }
            let cell = &self.cells[id];
            versions.insert(self.kind(id), cell.card.version);
            if let Some(file) = &cell.file {
                let digest = self.shared.files.last_digest(file).map(|digest| digest.hex());
                sources.insert(file.display().to_string(), digest);
            }
            open.extend(&self.turns[id].producers);
        }
        let graphs: BTreeMap<_, _> = self
            .plan
            .sources
            .iter()
            .map(|source| (source.path.display().to_string(), Digest::of(source.text.as_bytes()).hex()))
            .collect();
        json!({
            "grimace": env!("CARGO_PKG_VERSION"),
            "node": cell.name,
            "kind": self.kind(id),
            "item": cell.item(),
            "key": cell.key().hex(),
            "graphs": graphs,
            "inputs": inputs,
            "sources": sources,
            "versions": versions,
        })
    }
}

/// Whether a published file stands as it was written, with its sidecar.
pub(super) fn stands(path: &Path, signature: &Signature) -> bool {
    Signature::of(path).is_ok_and(|now| now == *signature) && sidecar(path).is_file()
}

/// The place of a file's sidecar.
fn sidecar(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

fn write_out(path: &Path, slot: &Slot, store: &Store, mut provenance: serde_json::Value) -> Result<Written, JobError> {
    let value = slot.whole(store)?;
    let artifact = value
        .downcast_ref::<Artifact>()
        .ok_or_else(|| NodeError::failed("what should be written is not a file's content"))?;
    let content = Digest::of(&artifact.bytes).hex();
    provenance["content"] = json!(content);
    provenance["file"] = json!(path.file_name().unwrap_or_default().to_string_lossy());
    let failed = |problem: io::Error| {
        JobError::Node(NodeError::file(&path.display().to_string(), format!("cannot be written: {problem}")))
    };
    let mut text = serde_json::to_string_pretty(&provenance).unwrap_or_default();
    text.push('\n');
    let standing = fs::read(path).ok();
    let right = standing.as_ref().is_some_and(|standing| *standing == artifact.bytes);
    let mut kept = None;
    if !right {
        if let Some(standing) = standing
            && !written_by_us(path, &standing)
        {
            kept = Some(set_aside(path).map_err(failed)?);
        }
        replace(path, &artifact.bytes).map_err(failed)?;
    }
    if !right || fs::read_to_string(sidecar(path)).ok().as_deref() != Some(text.as_str()) {
        replace(&sidecar(path), text.as_bytes()).map_err(failed)?;
    }
    let signature = Signature::of(path).map_err(failed)?;
    let bytes = (!right).then_some(artifact.bytes.len());
    Ok(Written { path: path.to_owned(), signature, digest: slot.digest, bytes, kept })
}

/// Whether the bytes that stand at `path` are those that the sidecar says were written there.
fn written_by_us(path: &Path, standing: &[u8]) -> bool {
    let text = fs::read_to_string(sidecar(path)).unwrap_or_default();
    let recorded: Option<serde_json::Value> = serde_json::from_str(&text).ok();
    recorded.is_some_and(|recorded| recorded["content"] == json!(Digest::of(standing).hex()))
}

/// Moves a file to the first free name of the form `name.kept-1`.
fn set_aside(path: &Path) -> io::Result<PathBuf> {
    for number in 1..10_000 {
        let mut name = path.as_os_str().to_owned();
        name.push(format!(".kept-{number}"));
        let place = PathBuf::from(name);
        if !place.exists() {
            fs::rename(path, &place)?;
            return Ok(place);
        }
    }
    Err(io::Error::new(io::ErrorKind::AlreadyExists, "too many kept copies stand beside it"))
}

/// Writes a file whole or not at all.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        fs::create_dir_all(folder)?;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = folder.join(format!(".{name}.{}.part", std::process::id()));
    let written = fs::File::create(&temporary)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_data()))
        .and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    written
}
