//! Parts of the state as others ask for them: the open level, the selected card, boards made anew.

use super::board::{Board, CardBox, Role, nested_file};
use super::catalogue::Catalogue;
use super::keymap::Keymap;
use super::layout::{Layout, Place, Zoom};
use super::texts::Texts;
use super::{Focus, Form, Level, Note, Overlay, PortAt, State};
use crate::preview::Preview;
use graph_core::document::{Body, Entry};
use std::path::Path;
use std::sync::Arc;

impl State {
    /// The editor with the graph at `root`, whose text is among `texts`.
    pub fn new(root: &Path, texts: Texts, catalogue: Arc<Catalogue>, keymap: Arc<Keymap>, size: (u16, u16)) -> Self {
        let name = root.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let folder = root.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        let name = if name == "graph" { folder.unwrap_or(name) } else { name };
        let level = Level {
            file: root.to_owned(),
            name,
            prefix: String::new(),
            selected: None,
            port: None,
            pan: (0, 0),
            board: Arc::default(),
            layout: Arc::default(),
            other: None,
        };
        let mut state = Self {
            texts,
            trail: vec![level],
            statuses: super::Statuses::default(),
            item: None,
            mistakes: Arc::default(),
            checked: 0,
            focus: Focus::Canvas,
            overlay: Overlay::None,
            zoom: Zoom::Normal,
            size,
            form: Form::default(),
            preview_open: false,
            preview: Preview::default(),
            work: None,
            cooking: None,
            note: None,
            beat: 0,
            catalogue,
            keymap,
            drag: None,
        };
        state.refresh();
        state.select_first();
        state.centre();
        state
    }

    /// The level that shows.
    pub fn level(&self) -> &Level {
        // The trail is never empty: it is made with the root, and `leave` keeps that.
        &self.trail[self.trail.len() - 1]
    }

    /// The level that shows.
    pub fn level_mut(&mut self) -> &mut Level {
        let last = self.trail.len() - 1;
        &mut self.trail[last]
    }

    /// Makes the boards of all open levels anew.
    pub fn refresh(&mut self) {
        let root = self.trail[0].file.clone();
        let mut file = root;
        let mut kept = 1;
        for at in 0..self.trail.len() {
            if at > 0 {
                let above = &self.trail[at - 1];
                let card = above.board.index.get(&self.trail[at].name).map(|card| &above.board.cards[*card]);
                match card.map(|card| &card.role) {
                    Some(Role::Nested(_, Some(nested))) => file.clone_from(nested),
                    _ => break,
                }
            }
            let board = Board::of(&file, &self.texts, &self.catalogue);
            let same = self.trail[at].board.cards == board.cards && self.trail[at].board.wires == board.wires;
            let level = &mut self.trail[at];
            level.file.clone_from(&file);
            if !same || level.layout.places.len() != board.cards.len() {
                level.layout = Arc::new(Layout::of(&board, self.zoom));
                level.other = None;
                level.board = Arc::new(board);
            }
            let gone = level.selected.as_ref().is_some_and(|name| level.board.find(name).is_none());
            if gone {
                (level.selected, level.port) = (None, None);
            }
            kept = at + 1;
        }
        self.trail.truncate(kept);
    }

    /// Lays the open boards out anew, as after a change of zoom.
    pub fn lay_out(&mut self) {
        let zoom = self.zoom;
        for level in &mut self.trail {
            let made = || Arc::new(Layout::of(&level.board, zoom));
            let next = level.other.take().unwrap_or_else(made);
            level.other = Some(std::mem::replace(&mut level.layout, next));
        }
        self.centre();
    }

    /// The selected card's position.
    pub fn card_at(&self) -> Option<usize> {
        self.level().board.find(self.level().selected.as_ref()?)
    }

    /// The selected card.
    pub fn card(&self) -> Option<&CardBox> {
        self.card_at().map(|at| &self.level().board.cards[at])
    }

    /// The selected node's entry in its file.
    pub fn entry(&self) -> Option<&Entry> {
        let graph = self.texts.get(&self.level().file)?.graph.as_ref()?;
        graph.nodes.get(self.level().selected.as_ref()?)
    }

    /// The selected node's name through all nesting.
    pub fn path(&self) -> Option<String> {
        Some(self.path_of(self.level().selected.as_ref()?))
    }

    /// A node's name through all nesting.
    pub fn path_of(&self, name: &str) -> String {
        format!("{}{name}", self.level().prefix)
    }

    /// The file that the selected node nests.
    pub fn nested(&self) -> Option<std::path::PathBuf> {
        match &self.entry()?.body {
            Body::Graph(file) => nested_file(&self.level().file, &file.value),
            Body::Kind(_) => None,
        }
    }

    /// Selects a card.
    pub fn select(&mut self, name: &str) {
        let level = self.level_mut();
        if level.selected.as_deref() != Some(name) {
            level.selected = Some(name.to_owned());
            level.port = None;
            self.form = Form::default();
        }
        self.show_selected();
    }

    /// Selects the upper left card where none is selected.
    pub fn select_first(&mut self) {
        if self.level().selected.is_some() {
            return;
        }
        let layout = Arc::clone(&self.level().layout);
        let first = (0..layout.places.len()).min_by_key(|at| (layout.places[*at].x, layout.places[*at].y));
        if let Some(first) = first {
            let name = self.level().board.cards[first].name.clone();
            self.select(&name);
        }
    }

    /// The selected card's place.
    pub fn place(&self) -> Option<Place> {
        self.level().layout.places.get(self.card_at()?).copied()
    }

    /// Columns and rows of the canvas.
    pub fn canvas_size(&self) -> (i32, i32) {
        let areas = crate::view::areas(self);
        (i32::from(areas.canvas.width), i32::from(areas.canvas.height))
    }

    /// Moves the board as little as shows the selected card.
    pub fn show_selected(&mut self) {
        let (Some(place), (width, height)) = (self.place(), self.canvas_size()) else { return };
        let margin = (3.min(width / 4), 1);
        let pan = &mut self.level_mut().pan;
        pan.0 = pan.0.min(place.x - margin.0).max(place.x + place.width + margin.0 - width);
        pan.1 = pan.1.min(place.y - margin.1).max(place.y + place.height + margin.1 - height);
    }

    /// Moves the board so that the whole shows where it fits, else the selected card amid the canvas.
    pub fn centre(&mut self) {
        let (width, height) = self.canvas_size();
        let layout = Arc::clone(&self.level().layout);
        let place = self.place().unwrap_or_default();
        let along = |whole: i32, room: i32, at: i32, own: i32| {
            if whole <= room {
                (whole - room) / 2
            } else {
                (at + own / 2 - room / 2).clamp(-2, (whole - room + 2).max(-2))
            }
        };
        let x = along(layout.width, width, place.x, place.width);
        let y = along(layout.height, height, place.y, place.height);
        self.level_mut().pan = (x, y);
    }

    /// The output that the preview shows: the selected one, or the first.
    pub fn output(&self) -> Option<String> {
        let card = self.card()?;
        let at = match self.level().port {
            Some(PortAt { input: false, at }) => at,
            _ => 0,
        };
        card.outputs.get(at).map(|port| port.name.clone())
    }

    /// The cell whose value and standing show for the selected node.
    pub fn cell(&self) -> Option<String> {
        Some(self.cell_of(&self.path()?))
    }

    /// The cell of the node at `path` for the item that shows, or the first.
    pub fn cell_of(&self, path: &str) -> String {
        let told = self.statuses.telling(path, self.item.as_deref());
        let first = || {
            let tally = self.statuses.tally(path)?;
            Some(format!("{path}@{}", tally.items.keys().next()?))
        };
        let wanted = self.item.as_ref().map(|item| format!("{path}@{item}"));
        let known = |name: &String| self.statuses.cell(name).is_some();
        let told = || told.map(|(name, _)| name.to_owned());
        wanted.filter(known).or_else(first).or_else(told).unwrap_or_else(|| path.to_owned())
    }

    /// The cell and port on which the selected output's value stands: within a nested graph, where that has it from.
    pub fn shown_output(&self) -> Option<(String, String)> {
        let (mut file, mut prefix) = (self.level().file.clone(), self.level().prefix.clone());
        let (mut name, mut port) = (self.level().selected.clone()?, Some(self.output()?));
        loop {
            let graph = self.texts.get(&file)?.graph.clone()?;
            match &graph.nodes.get(&name)?.body {
                Body::Kind(kind) => {
                    let first = || Some(self.catalogue.get(&kind.value)?.outputs.first()?.name.to_owned());
                    return Some((self.cell_of(&format!("{prefix}{name}")), port.or_else(first)?));
                }
                Body::Graph(nested) => {
                    prefix = format!("{prefix}{name}/");
                    file = nested_file(&file, &nested.value)?;
                    let outputs = &self.texts.get(&file)?.graph.as_ref()?.outputs;
                    let source = match &port {
                        Some(port) => outputs.get(port)?,
                        None => outputs.values().next()?,
                    };
                    let (node, of) = match source.value.rsplit_once('.') {
                        Some((node, of)) => (node, Some(of.to_owned())),
                        None => (source.value.as_str(), None),
                    };
                    (name, port) = (node.to_owned(), of);
                }
            }
        }
    }

    /// Tells how something went.
    pub fn say(&mut self, text: impl Into<String>) {
        self.note = Some(Note { text: text.into(), bad: false });
    }

    /// Tells what is wrong.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.note = Some(Note { text: text.into(), bad: true });
    }
}
