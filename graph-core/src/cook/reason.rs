//! Why a cell is cooked, in words: finds the part of its key that differs, and where the difference was written.

use super::cell::{CellId, Settings, some_of};
use super::engine::Engine;
use super::key::shown;
use super::session::{Cause, NodeRecord, Reason};
use super::why::{Now, difference, settings_difference};
use crate::document::{Body, Place, canonical_parameters};
use crate::node::Kinds;
use crate::plan::{PlanInput, PlanSource};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use wire::Digest;

/// Items of a gathering input that are remembered by name.
const MOST_ITEMS: usize = 200;

impl Engine {
    /// In a plan, why a cell with inputs that are not known is cooked whatever they turn out to be.
    pub(super) fn own_reason(&self, id: CellId, file: Option<Digest>) -> Option<Reason> {
        let cell = &self.cells[id];
        let inputs: Vec<_> = cell.links.iter().map(|link| self.link_digest(link)).collect();
        let now = Now { settings: &cell.settings, file, links: &cell.links, inputs };
        match difference(cell.before.as_deref(), &now) {
            Reason::Forgotten => None,
            own => Some(self.in_words(id, own, None)),
        }
    }

    /// The first part of the key that differs from the one before.
    pub(super) fn reason(&self, id: CellId, file: Option<Digest>, inputs: &[Digest]) -> Reason {
        let cell = &self.cells[id];
        let (reason, was) = match (cell.made_settings(), &cell.before) {
            // Computed before by this very engine.
            (Some(before), _) => {
                let same = Arc::ptr_eq(before, &cell.settings);
                let own = if same { None } else { settings_difference(&before.parts, &cell.settings.parts) };
                let input = || cell.made.inputs.iter().zip(inputs).position(|(before, now)| before != now);
                let reason = match own {
                    Some(own) => own,
                    None if cell.made.file != file => Reason::Changed("file".to_owned()),
                    None => input().map_or(Reason::Forgotten, |link| Reason::Input(link, None)),
                };
                (reason, Some(Arc::clone(before)))
            }
            (None, None) => (Reason::New, None),
            (None, before) => {
                let inputs = inputs.iter().copied().map(Some).collect();
                let now = Now { settings: &cell.settings, file, links: &cell.links, inputs };
                (difference(before.as_deref(), &now), None)
            }
        };
        self.in_words(id, reason, was.as_deref())
    }

    /// The reason with what only now can be told: the values before and after, the connection, the file. `was` are the
    /// settings before, where this very engine knew them.
    fn in_words(&self, id: CellId, reason: Reason, was: Option<&Settings>) -> Reason {
        let cell = &self.cells[id];
        let known = self.known_node(cell.plan);
        let here = || Some(self.plan.nodes[cell.plan].place.text());
        let told = |text: String, place: Option<String>| Reason::told(Cause { text, place, upstream: None });
        match reason {
            Reason::New if known.is_some() && !cell.items.is_empty() => {
                if let Some(file) = &cell.file {
                    return told("its file is new".into(), Some(file.display().to_string()));
                }
                let changed = |id: &CellId| self.cells[*id].changed_run == self.session.run;
                let same = |id: &CellId| self.cells[*id].items.last() == cell.items.last();
                let mut producers = self.turns[id].producers.iter().copied().filter(changed);
                let upstream = producers.clone().find(same).or_else(|| producers.next());
                let upstream = upstream.map(|id| self.cells[id].name.clone());
                let text = format!("its item `{}` is new", cell.items.join("/"));
                Reason::told(Cause { text, place: here().filter(|_| upstream.is_none()), upstream })
            }
            Reason::Forgotten => match self.changed_sibling(id) {
                Some(path) => told("a file that it reads beside its own changed".into(), Some(path)),
                None => Reason::Forgotten,
            },
            Reason::Changed(label) => {
                let text = |settings: &Settings| {
                    settings.parts.iter().find(|part| part.label == label).map(|part| part.text.clone())
                };
                let was = match was {
                    Some(was) => text(was),
                    None => known.and_then(|known| known.text_of(&label, self.plan.kinds())),
                };
                let (Some(was), Some(now)) = (was, text(&cell.settings)) else { return Reason::Changed(label) };
                if is_code(&label) {
                    return told(format!("its {label} changed from {was} to {now}"), self.kind_place(id));
                }
                let Some(parameter) = parameter_of(&label) else {
                    return told(self.other_kind(id, &was, &now), self.kind_place(id));
                };
                told(
                    format!("{label} changed from {was} to {now}"),
                    self.parameter_place(cell.plan, parameter).or_else(here),
                )
            }
            Reason::Input(link, _) => self.input_reason(id, link),
            other => other,
        }
    }

    /// What an earlier process knew of a node of the plan.
    fn known_node(&self, plan: usize) -> Option<&NodeRecord> {
        if self.session.nodes.is_empty() { None } else { self.session.nodes.get(&self.plan.nodes[plan].path) }
    }

    /// What became of a cell's kind and version.
    fn other_kind(&self, id: CellId, was: &str, now: &str) -> String {
        let split = |text: &str| {
            text.split_once(' ')
                .map_or((text.to_owned(), String::new()), |(kind, version)| (kind.to_owned(), version.to_owned()))
        };
        let ((old, before), (kind, version)) = (split(was), split(now));
        match (old == kind, before == version) {
            (false, _) => format!("its kind is now `{kind}`, and was `{old}`"),
            (true, false) => format!("its kind `{kind}` is now version {version}, and was {before}"),
            (true, true) => format!("this program keeps results of `{}` in another way", self.kind(id)),
        }
    }

    fn kind_place(&self, id: CellId) -> Option<String> {
        let template = &self.plan.nodes[self.cells[id].plan].template;
        let Body::Kind(kind) = &template.entry().body else { return None };
        Some(Place { source: Arc::clone(&template.graph.source), span: kind.span }.text())
    }

    /// A file that the cell was seen to read beside its own, and that is no longer as it was.
    fn changed_sibling(&self, id: CellId) -> Option<String> {
        let cell = &self.cells[id];
        let reads = cell.before.as_ref().map_or(&cell.reads, |before| &before.action.reads);
        let folder = cell.file.as_deref()?.parent()?;
        let changed =
            reads.iter().find(|(name, digest)| self.shared.files.digest(&folder.join(name)).ok() != Some(*digest));
        changed.map(|(name, _)| folder.join(name).display().to_string())
    }

    /// Why an input differs: another connection, the producer whose result changed, or items that are gone.
    fn input_reason(&self, id: CellId, link: usize) -> Reason {
        let cell = &self.cells[id];
        let port = cell.links[link].port.name;
        let input = || self.plan.nodes[cell.plan].inputs.iter().find(|input| input.port.name == port);
        let known = self.known_node(cell.plan);
        let told =
            |text: String| Reason::told(Cause { text, place: input().map(|input| input.place.text()), upstream: None });
        if let Some(was) = known.and_then(|known| known.inputs.get(port))
            && let Some(input) = input()
        {
            let now = sources(input);
            if now != *was {
                return told(format!(
                    "its input `{port}` is connected to {}, and was to {}",
                    listed(&now),
                    listed(was)
                ));
            }
        }
        let mut producers = cell.links[link].wires.iter().map(|wire| wire.cell);
        if let Some(producer) = producers.find(|producer| self.cells[*producer].changed_run == self.session.run) {
            return Reason::Input(link, Some(producer));
        }
        if let Some(was) = known.and_then(|known| known.items.get(port)) {
            let now: Vec<String> = self.slots_of(&cell.links[link]).into_iter().map(|(name, _)| name).collect();
            let gone: Vec<String> = was.iter().filter(|name| !now.contains(name)).cloned().collect();
            if !gone.is_empty() {
                return told(format!("its input `{port}` no longer has {}", listed(&gone)));
            }
            let more: Vec<String> = now.iter().filter(|name| !was.contains(name)).cloned().collect();
            if !more.is_empty() {
                return told(format!("its input `{port}` now has {}", listed(&more)));
            }
        }
        Reason::Input(link, None)
    }

    /// What is to be remembered of each node that cells stand for.
    pub(super) fn node_records(&self) -> BTreeMap<String, NodeRecord> {
        let mut defaults: HashMap<&str, BTreeMap<String, String>> = HashMap::new();
        let mut records = BTreeMap::new();
        for (index, node) in self.plan.nodes.iter().enumerate() {
            let Some(done) = self.of_plan[index].iter().find(|cell| self.cells[**cell].slots().is_some()) else {
                // Of a node that was not cooked, or failed, the last result is that of an earlier cook.
                records.extend(
                    self.session.nodes.get_key_value(&node.path).map(|(path, known)| (path.clone(), known.clone())),
                );
                continue;
            };
            let usual = defaults.entry(node.kind.as_str()).or_insert_with(|| {
                self.plan
                    .kinds()
                    .get(&node.kind)
                    .map(|kind| canonical_parameters(kind.default_node().as_ref(), &[]))
                    .unwrap_or_default()
            });
            let mut record =
                NodeRecord { kind: format!("{} {}", node.kind, node.card.version), ..NodeRecord::default() };
            for part in &self.cells[*done].settings.parts {
                if is_code(&part.label) {
                    record.values.insert(part.label.clone(), part.text.clone());
                }
                let Some(name) = parameter_of(&part.label) else { continue };
                if usual.get(name).is_none_or(|usual| shown(usual) != part.text) {
                    record.values.insert(name.to_owned(), part.text.clone());
                }
            }
            record.inputs = node.inputs.iter().map(|input| (input.port.name.to_owned(), sources(input))).collect();
            if let ([cell], true) = (self.of_plan[index].as_slice(), node.scope.is_empty()) {
                for link in self.cells[*cell].links.iter().filter(|link| link.port.list) {
                    let names: Vec<String> =
                        self.slots_of(link).into_iter().map(|(name, _)| name).take(MOST_ITEMS + 1).collect();
                    if names.len() <= MOST_ITEMS {
                        record.items.insert(link.port.name.to_owned(), names);
                    }
                }
            }
            records.insert(node.path.clone(), record);
        }
        records
    }

    /// A reason in words, with its place.
    pub(super) fn cause(&self, id: CellId, reason: &Reason) -> Cause {
        let cell = &self.cells[id];
        let plan = &self.plan.nodes[cell.plan];
        let here = Some(plan.place.text());
        let plain = |text: String, place: Option<String>| Cause { text, place, upstream: None };
        match reason {
            Reason::Told(cause) => Cause::clone(cause),
            Reason::New => plain("it is new".into(), here),
            Reason::Forgotten => plain("the store no longer holds its result".into(), None),
            Reason::Added(label) => plain(format!("{label} was added"), here),
            Reason::Removed(label) => plain(format!("{label} was taken away"), here),
            Reason::Changed(label) if label == "version" => {
                plain(format!("its kind `{}` is now version {}", plan.kind, cell.card.version), None)
            }
            Reason::Changed(label) if label == "file" => {
                plain("its file changed".into(), cell.file.as_ref().map(|file| file.display().to_string()))
            }
            Reason::Changed(label) => {
                let place = parameter_of(label).and_then(|name| self.parameter_place(cell.plan, name));
                plain(format!("{label} changed"), place.or(here))
            }
            Reason::Input(link, upstream) => {
                let port = cell.links.get(*link).map_or("", |link| link.port.name);
                if let Some(producer) = upstream {
                    let text = format!("its input `{port}` changed");
                    return Cause { text, place: None, upstream: Some(self.cells[*producer].name.clone()) };
                }
                let input = plan.inputs.iter().find(|input| input.port.name == port);
                let text = format!("its input `{port}` is connected to something else, or has other items");
                plain(text, input.map(|input| input.place.text()))
            }
        }
    }

    /// Where the value of a parameter of a plan node comes from.
    fn parameter_place(&self, plan: usize, name: &str) -> Option<String> {
        let node = &self.plan.nodes[plan];
        let set = self.overrides.iter().find(|set| set.name == name && set.path.join("/") == node.path);
        set.map(|set| format!("--set {}", set.text)).or_else(|| Some(node.template.parameter_place(name)?.text()))
    }
}

impl NodeRecord {
    /// What a part of the settings said.
    fn text_of(&self, label: &str, kinds: &Kinds) -> Option<String> {
        if is_code(label) {
            return self.values.get(label).cloned();
        }
        let Some(name) = parameter_of(label) else { return (label == "version").then(|| self.kind.clone()) };
        let default = || {
            let kind = kinds.get(self.kind.split(' ').next()?)?;
            canonical_parameters(kind.default_node().as_ref(), &[]).get(name).map(|text| shown(text))
        };
        self.values.get(name).cloned().or_else(default)
    }
}

/// Whether the label of a part is that of code: no parameter's name has two words.
fn is_code(label: &str) -> bool {
    label.contains(' ') && parameter_of(label).is_none()
}

/// The parameter that the label of a part is about.
fn parameter_of(label: &str) -> Option<&str> {
    label.strip_prefix("parameter `").and_then(|rest| rest.strip_suffix('`'))
}

/// What an input is connected to, as people write it.
fn sources(input: &PlanInput) -> Vec<String> {
    let name = |source: &PlanSource| {
        if source.label.contains('.') { source.label.clone() } else { format!("{}.{}", source.label, source.port) }
    };
    input.sources.iter().map(name).collect()
}

fn listed(names: &[String]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    if quoted.is_empty() { "nothing".to_owned() } else { some_of(&quoted) }
}
