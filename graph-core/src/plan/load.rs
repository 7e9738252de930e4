//! Reads a graph and every graph nested in it, into instances: one for each time a file is used.

use super::model::{Plan, Template};
use super::{check, resolve, scope};
use crate::document::{
    Body, Diagnostic, Diagnostics, Entry, Environment, Graph, Override, Place, Scope, Source, Spanned, apply_overrides,
    read, resolve_name,
};
use crate::node::Kinds;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// How deep graphs may nest; deeper nesting is a mistake.
const DEEPEST: usize = 64;

/// One use of a graph file.
pub(super) struct Instance {
    pub graph: Arc<Graph>,
    /// Names before the nodes' own, ending in `/` where not empty.
    pub prefix: String,
    pub scope: Arc<Scope>,
    /// The instance that nests this one, and the name of the node that does.
    pub parent: Option<(usize, String)>,
    /// What each node of the file has become.
    pub members: BTreeMap<String, Member>,
    /// The places that nest this file, outermost first.
    pub through: Vec<Place>,
}

/// What a node of a file has become.
#[derive(Clone, Copy)]
pub(super) enum Member {
    /// A node: index into [`Loader::nodes`].
    Node(usize),
    /// A nested graph: index into [`Loader::instances`].
    Nested(usize),
    /// Something that could not be made, and has been reported.
    Broken,
}

/// A node before wiring.
pub(super) struct RawNode {
    pub instance: usize,
    pub kind: Spanned<String>,
    pub template: Template,
    pub made: check::Made,
    /// Whether it was made from what the graph says. Where that has mistakes, a node with defaults stands in its place, so
    /// that its connections are checked all the same.
    pub sound: bool,
}

/// Everything read so far.
pub(super) struct Loader {
    pub instances: Vec<Instance>,
    pub nodes: Vec<RawNode>,
    pub diagnostics: Vec<Diagnostic>,
    /// Inputs of nested graphs whose connection has another type than they declare.
    pub mistyped: BTreeSet<(usize, String)>,
    /// Whether a mistake was met since this was last lowered, reported now or before.
    pub troubled: bool,
    /// Texts that are being resolved, by instance: one that comes up again leads in a circle.
    pub resolving: Vec<(usize, String)>,
    files: BTreeMap<PathBuf, Option<Arc<Graph>>>,
    /// Texts that stand in the place of what is on disk.
    texts: BTreeMap<PathBuf, String>,
    sources: Vec<Arc<Source>>,
    overrides: Vec<Override>,
    environment: Arc<Environment>,
}

impl Loader {
    /// Reports a mistake in the file of `instance`.
    pub fn report(&mut self, instance: usize, mut diagnostic: Diagnostic) {
        self.troubled = true;
        diagnostic.through.clone_from(&self.instances[instance].through);
        // A mistake in a file that is nested several times is told once.
        let same =
            |known: &Diagnostic| Diagnostic { through: diagnostic.through.clone(), ..known.clone() } == diagnostic;
        if !self.diagnostics.iter().any(|known| known.code == diagnostic.code && same(known)) {
            self.diagnostics.push(diagnostic);
        }
    }

    /// The kinds that the graphs may name.
    pub fn kinds(&self) -> &Kinds {
        self.environment.kinds()
    }

    /// The entry of a node.
    pub fn entry(&self, node: usize) -> &Entry {
        self.nodes[node].template.entry()
    }

    /// The name of a node through all nesting.
    pub fn path(&self, node: usize) -> String {
        let raw = &self.nodes[node];
        format!("{}{}", self.instances[raw.instance].prefix, raw.template.name)
    }

    /// The graph file at `path`, reached `through` the places that nest it; `None` where its mistakes are reported.
    fn graph(&mut self, path: &Path, through: &[Place]) -> Result<Option<Arc<Graph>>, Diagnostic> {
        if let Some(known) = self.files.get(path) {
            return Ok(known.clone());
        }
        let source = match self.texts.remove(path) {
            Some(text) => Source::new(path, text),
            None => Source::load(path)?,
        };
        let source = Arc::new(source);
        self.sources.push(Arc::clone(&source));
        let (graph, mistakes) = read(source);
        let reached = mistakes.into_iter().map(|mistake| Diagnostic { through: through.to_vec(), ..mistake });
        self.diagnostics.extend(reached);
        let graph = graph.map(Arc::new);
        self.files.insert(path.to_owned(), graph.clone());
        Ok(graph)
    }
}

/// Loads the graph at `path` with the given overrides (`--set`).
///
/// # Errors
/// Every mistake in the graph and the graphs nested in it, found in one pass.
pub fn load(path: &Path, overrides: &[Override]) -> Result<Plan, Diagnostics> {
    load_texts(path, overrides, BTreeMap::new())
}

/// The same where some files, by the paths under which they are reached, have other texts than on disk.
///
/// # Errors
/// Every mistake in the graph and the graphs nested in it, found in one pass.
pub fn load_texts(path: &Path, overrides: &[Override], texts: BTreeMap<PathBuf, String>) -> Result<Plan, Diagnostics> {
    let environment = Arc::new(Environment::of_graph(path));
    let mut loader = Loader {
        instances: Vec::new(),
        nodes: Vec::new(),
        diagnostics: Vec::new(),
        mistyped: BTreeSet::new(),
        troubled: false,
        resolving: Vec::new(),
        files: BTreeMap::new(),
        texts,
        sources: Vec::new(),
        overrides: overrides.to_vec(),
        environment: Arc::clone(&environment),
    };
    let root = match loader.graph(path, &[]) {
        Ok(Some(root)) => root,
        Ok(None) => return Err(Diagnostics(loader.diagnostics)),
        Err(diagnostic) => return Err(Diagnostics(vec![diagnostic])),
    };
    let (scope, mistakes) = apply_overrides(&root, overrides, &environment);
    loader.diagnostics.extend(mistakes);
    for (name, input) in root.inputs.iter().filter(|(_, input)| !input.optional) {
        let message = format!("the graph needs the input `{name}`, so it can only be cooked nested in another graph");
        loader.diagnostics.push(Diagnostic::at("open-input", &root.source, input.span, message));
    }
    loader.instances.push(Instance {
        graph: root,
        prefix: String::new(),
        scope: Arc::new(scope),
        parent: None,
        members: BTreeMap::new(),
        through: Vec::new(),
    });
    // Nested graphs join the end of the list while it is walked.
    let mut next = 0;
    while next < loader.instances.len() {
        open(&mut loader, next);
        next += 1;
    }
    unused_overrides(&mut loader);
    let wired = resolve::wires(&mut loader);
    check::types(&mut loader, &wired);
    let scoped = scope::order_and_scope(&mut loader, &wired);
    let plan = check::assemble(&mut loader, &wired, scoped);
    match plan {
        Some(mut plan) if loader.diagnostics.is_empty() => {
            (plan.sources, plan.environment) = (loader.sources, environment);
            Ok(plan)
        }
        _ => Err(Diagnostics(loader.diagnostics)),
    }
}

/// Makes the members of one instance.
fn open(loader: &mut Loader, index: usize) {
    let instance = &loader.instances[index];
    let (graph, mistakes) = instance.scope.wire(&instance.graph);
    for mistake in mistakes {
        loader.report(index, mistake);
    }
    loader.instances[index].graph = Arc::clone(&graph);
    for (name, entry) in &graph.nodes {
        let member = match &entry.body {
            Body::Kind(kind) => {
                let scope = Arc::clone(&loader.instances[index].scope);
                let path = format!("{}{name}", loader.instances[index].prefix);
                let (made, mistakes) = check::make(&graph, name, kind, &scope, None, &loader.overrides, &path);
                for mistake in mistakes {
                    loader.report(index, mistake);
                }
                let sound = made.is_some();
                match made.or_else(|| check::stand_in(loader.kinds(), &kind.value)) {
                    None => Member::Broken,
                    Some(made) => {
                        let mentions_item = made.mentions_item;
                        let template = Template { graph: Arc::clone(&graph), name: name.clone(), scope, mentions_item };
                        loader.nodes.push(RawNode { instance: index, kind: kind.clone(), template, made, sound });
                        Member::Node(loader.nodes.len() - 1)
                    }
                }
            }
            Body::Graph(file) => nest(loader, index, name, entry, file),
        };
        loader.instances[index].members.insert(name.clone(), member);
    }
}

fn nest(loader: &mut Loader, index: usize, name: &str, entry: &Entry, file: &Spanned<String>) -> Member {
    let parent = &loader.instances[index];
    let source = Arc::clone(&parent.graph.source);
    let path = match resolve_name(file, &parent.scope) {
        Ok((name, folder)) => tidy(&folder.join(name)),
        Err(mistakes) => {
            for mistake in mistakes {
                loader.report(index, mistake);
            }
            return Member::Broken;
        }
    };
    let mut through = parent.through.clone();
    through.push(Place { source: Arc::clone(&source), span: file.span });
    let cycle = through.iter().any(|place| same_file(&place.source.path, &path));
    if cycle || through.len() > DEEPEST {
        let chain: Vec<_> = through.iter().map(|place| place.source.path.display().to_string()).collect();
        let message = format!("the graph nests itself: {} → {}", chain.join(" → "), path.display());
        let mistake = Diagnostic::at("nesting-cycle", &source, file.span, message);
        loader.report(index, mistake.help("take this node out, or nest another graph"));
        return Member::Broken;
    }
    let graph = match loader.graph(&path, &through) {
        Ok(Some(graph)) => graph,
        Ok(None) => return Member::Broken,
        Err(problem) => {
            let mistake = Diagnostic::at("unreadable-file", &source, file.span, problem.message).may_help(problem.help);
            loader.report(index, mistake);
            return Member::Broken;
        }
    };
    let parent = &loader.instances[index];
    let prefix = format!("{}{name}/", parent.prefix);
    let outer_path = prefix.trim_end_matches('/');
    let (scope, mistakes) = Scope::nested(&graph, entry, &source, &parent.scope, &loader.overrides, outer_path);
    for mistake in mistakes {
        loader.report(index, mistake);
    }
    loader.instances.push(Instance {
        graph,
        prefix,
        scope: Arc::new(scope),
        parent: Some((index, name.to_owned())),
        members: BTreeMap::new(),
        through,
    });
    Member::Nested(loader.instances.len() - 1)
}

/// `path` without `folder/..` where that leads to the same file.
pub fn tidy(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        match (part, short.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => drop(short.pop()),
            (part, _) => short.push(part),
        }
    }
    if same_file(&short, path) { short } else { path.to_owned() }
}

fn same_file(one: &Path, other: &Path) -> bool {
    match (one.canonicalize(), other.canonicalize()) {
        (Ok(one), Ok(other)) => one == other,
        _ => one == other,
    }
}

/// Overrides of nodes' parameters (`--set node.param=value`) that name no node.
fn unused_overrides(loader: &mut Loader) {
    let named = loader
        .instances
        .iter()
        .flat_map(|instance| instance.members.keys().map(|name| format!("{}{name}", instance.prefix)));
    let paths: BTreeSet<String> = named.collect();
    for wanted in &loader.overrides {
        let node = wanted.path.join("/");
        if !wanted.path.is_empty() && !paths.contains(&node) {
            let near = crate::document::did_you_mean(&node, paths.iter().map(String::as_str));
            loader.diagnostics.push(
                Diagnostic::new("unknown-node", format!("`--set {}`: there is no node `{node}`", wanted.text))
                    .may_help(near.map(|near| format!("did you mean `{near}`?"))),
            );
        }
    }
}
