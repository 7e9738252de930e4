//! What is done outside of the state: keys read, files read and written, cooks run, values fetched, the screen drawn.
//!
//! One thread holds the state and draws. `keys` reads the terminal, `checker` checks texts and `cooker` cooks, each on a
//! thread of its own, `kinds` looks for plugins; all of them speak to the first by messages, so that nothing they do delays a key.

mod checker;
mod cooker;
mod files;
mod graphics;
mod journal;
mod kinds;
mod screen;
mod sixel;
mod timings;
mod workbench;

use crate::action::{names, update};
use crate::model::board::{Role, nested_file};
use crate::model::catalogue::Catalogue;
use crate::model::keymap::{Keymap, KeymapError};
use crate::model::texts::Texts;
use crate::model::{Effect, Message, Overlay, State};
use crate::view::{Theme, draw, look, pixels};
use checker::Checker;
use cooker::{Ask, Cooker};
use graph_core::cook::Options;
use graph_core::document::{Body, Override};
use graph_core::plan::tidy;
use graph_core::store::Store;
use journal::Journal;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};
use timings::Timings;

/// What is edited, and how it is cooked.
#[derive(Debug, Clone)]
pub struct Asked {
    /// The graph file.
    pub graph: PathBuf,
    /// What `--set` says.
    pub overrides: Vec<Override>,
    /// Where results are kept.
    pub store: PathBuf,
    /// How to cook.
    pub options: Options,
    /// A keymap of one's own.
    pub keys: Option<PathBuf>,
    /// A file into which times are written: a line each, what it is and how many milliseconds (see `timings`).
    pub timings: Option<PathBuf>,
}

/// Why the editor could not begin, or had to end.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The graph cannot be read.
    #[error("{0}")]
    Graph(String),
    /// The keymap cannot be read.
    #[error("{}: {problem}", file.display())]
    Keys {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// The keymap is wrong.
    #[error(transparent)]
    Keymap(#[from] KeymapError),
    /// The terminal failed.
    #[error("the terminal cannot be used: {0}")]
    Terminal(#[from] std::io::Error),
}

/// The state of an editor at its start, with every nested graph read that can be.
///
/// # Errors
/// Where the graph or the keymap cannot be read.
pub fn begin(asked: &Asked, size: (u16, u16)) -> Result<State, SessionError> {
    let own = match &asked.keys {
        None => None,
        Some(file) => Some(
            std::fs::read_to_string(file)
                .map_err(|problem| SessionError::Keys { file: file.clone(), problem: problem.to_string() })?,
        ),
    };
    let keymap = Keymap::read(own.as_deref(), &names())?;
    let root = tidy(&asked.graph);
    let mut texts = Texts::default();
    texts.add(root.clone(), files::read(&root).map_err(SessionError::Graph)?);
    read_nested(&mut texts, &root);
    Ok(State::new(&root, texts, Arc::new(Catalogue::of_program()), Arc::new(keymap), size))
}

/// Reads every graph nested in the one at `root`; what cannot be read is told when the graph is checked.
fn read_nested(texts: &mut Texts, root: &Path) {
    let mut open = vec![root.to_owned()];
    while let Some(path) = open.pop() {
        let graph = texts.get(&path).and_then(|text| text.graph.clone());
        let bodies = graph.iter().flat_map(|graph| graph.nodes.values()).map(|entry| &entry.body);
        let nested: Vec<PathBuf> = bodies
            .filter_map(|body| match body {
                Body::Graph(file) => nested_file(&path, &file.value),
                Body::Kind(_) => None,
            })
            .collect();
        for file in nested {
            if texts.get(&file).is_none()
                && let Ok(text) = files::read(&file)
            {
                texts.add(file.clone(), text);
                open.push(file);
            }
        }
    }
}

/// Edits a graph in the terminal until the person leaves.
///
/// # Errors
/// Where the graph cannot be read or the terminal cannot be used.
pub fn edit(asked: &Asked) -> Result<(), SessionError> {
    let begun = Instant::now();
    let size = ratatui::crossterm::terminal::size()?;
    let state = begin(asked, size)?;
    let (sender, messages) = channel();
    let mut session = Session::new(asked, state, &sender);
    let mut screen = screen::Screen::begin()?;
    session.graphics = graphics::Graphics::ask();
    kinds::follow(&asked.graph, &sender);
    screen::read_keys(sender);
    session.draw(&mut screen)?;
    session.timings.opened(begun);
    let done = session.run(&messages, &mut screen);
    drop(screen);
    session.cooker.cancel();
    done
}

/// How often files are looked at.
const LOOK: Duration = Duration::from_millis(700);
/// How long journals of others are looked for.
const DYING: Duration = Duration::from_secs(30);
/// How often what moves is drawn anew.
const BEAT: Duration = Duration::from_millis(120);
/// News of a cook are drawn no more often.
const NEWS: Duration = Duration::from_millis(40);

struct Session {
    state: State,
    theme: Theme,
    /// How the terminal draws pictures, where it does.
    graphics: Option<graphics::Graphics>,
    cooker: Cooker,
    checker: Checker,
    journal: Journal,
    seen: files::Seen,
    timings: Timings,
    leaving: bool,
}

impl Session {
    fn new(asked: &Asked, state: State, sender: &Sender<(Instant, Message)>) -> Self {
        let root = state.trail[0].file.clone();
        let store = Arc::new(Store::at(&asked.store));
        let mut session = Self {
            theme: Theme::of_terminal(),
            graphics: None,
            cooker: Cooker::begin(asked, &root, &store, sender),
            checker: Checker::begin(asked, &root, &store, sender),
            journal: Journal::of(&asked.store, &root),
            seen: files::Seen::default(),
            timings: Timings::for_file(asked.timings.clone()),
            leaving: false,
            state,
        };
        session.perform(vec![Effect::Check]);
        session.offer_journal();
        session
    }

    /// Asks what is to become of edits that an editor left behind; whether there are any.
    fn offer_journal(&mut self) -> bool {
        let Some((bases, operations)) = self.journal.left_behind() else { return false };
        let unknown = bases.iter().filter(|(file, _)| self.state.texts.get(file).is_none());
        let read = |(file, _): &(PathBuf, String)| Some((file.clone(), files::read(file).ok()?));
        let sources = unknown.filter_map(read).collect();
        self.take(Message::JournalFound { operations, bases, sources });
        true
    }

    fn run(
        &mut self,
        messages: &Receiver<(Instant, Message)>,
        screen: &mut screen::Screen,
    ) -> Result<(), SessionError> {
        let (mut beaten, mut looked, mut drawn) = (Instant::now(), Instant::now(), Instant::now());
        let mut waiting_news = false;
        let (begun, mut offered) = (Instant::now(), !matches!(self.state.overlay, Overlay::None));
        while !self.leaving {
            let plays = self.state.work.as_ref().is_some_and(|work| work.playing);
            let moving = self.state.cooking.is_some() || self.state.preview.playing || plays;
            let mut wait =
                if moving { BEAT.saturating_sub(beaten.elapsed()) } else { LOOK.saturating_sub(looked.elapsed()) };
            if waiting_news {
                wait = wait.min(NEWS.saturating_sub(drawn.elapsed()));
            }
            let mut pressed: Vec<Instant> = Vec::new();
            let mut changed = false;
            match messages.recv_timeout(wait.max(Duration::from_millis(1))) {
                Ok(first) => {
                    let mut next = Some(first);
                    while let Some((at, message)) = next {
                        let news = matches!(message, Message::Cook(_));
                        waiting_news |= news;
                        changed |= !news;
                        let key = matches!(message, Message::Key(_) | Message::Mouse(_));
                        if key {
                            pressed.push(at);
                        }
                        let before = self.state.texts.revision;
                        self.take(message);
                        if key && self.state.texts.revision != before && self.state.work.is_some() {
                            self.timings.edited(at);
                        }
                        // Keys are shown at once, however much a cook tells.
                        next = if pressed.len() < 8 { messages.try_recv().ok() } else { None };
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if moving && beaten.elapsed() >= BEAT {
                beaten = Instant::now();
                self.take(Message::Beat);
                changed = true;
            }
            if looked.elapsed() >= LOOK {
                looked = Instant::now();
                changed |= self.look_at_files();
                // An editor that was killed may take a while to end, and counts as alive until then.
                let untouched = matches!(self.state.overlay, Overlay::None) && !self.state.texts.is_unsaved();
                if !offered && untouched && begun.elapsed() < DYING {
                    offered = self.offer_journal();
                    changed |= offered;
                }
            }
            if changed || (waiting_news && drawn.elapsed() >= NEWS) {
                self.draw(screen)?;
                drawn = Instant::now();
                waiting_news = false;
                self.timings.drawn(&pressed, &self.state);
            }
        }
        self.timings.write();
        Ok(())
    }

    fn draw(&mut self, screen: &mut screen::Screen) -> Result<(), SessionError> {
        self.theme.cell_px = self.graphics.as_ref().and_then(graphics::Graphics::cell_px);
        let (state, theme) = (&self.state, self.theme);
        let look = look(state, theme);
        if self.graphics.as_ref().is_some_and(|graphics| graphics.stale(look.as_ref())) {
            screen.terminal.clear()?;
        }
        screen.terminal.draw(|frame| draw(state, theme, frame))?;
        if let Some(graphics) = &mut self.graphics {
            graphics.show(look, |look| pixels(state, look), &mut std::io::stdout())?;
        }
        Ok(())
    }

    fn take(&mut self, message: Message) {
        let from_disk = matches!(message, Message::OnDisk { .. });
        let effects = update(&mut self.state, message);
        self.perform(effects);
        if from_disk {
            self.journal.restart(&self.state.texts);
        }
    }

    fn perform(&mut self, effects: Vec<Effect>) {
        for effect in effects {
            match effect {
                Effect::Read(file) => {
                    let text = files::read(&file);
                    self.take(Message::OnDisk { file, text });
                }
                Effect::Check => self.checker.check(self.state.texts.revision, self.overlay()),
                Effect::Cook(only) => self.cooker.cook(self.overlay(), only),
                Effect::Forget => self.cooker.forget(),
                Effect::Cancel => self.cooker.cancel(),
                Effect::Work(cell, port) => self.cooker.work(Ask {
                    texts: self.overlay(),
                    revision: self.state.texts.revision,
                    graphs_revision: self.state.texts.graphs_revision,
                    of: (cell, port),
                }),
                Effect::Peek(cell, port) => self.cooker.peek(self.overlay(), cell, port),
                Effect::Journal(operation) => {
                    if let Err(problem) = self.journal.note(&self.state.texts, &operation) {
                        self.state.complain(format!("the journal cannot be written: {problem}"));
                    }
                }
                Effect::DropJournal => self.journal.drop_all(),
                Effect::Save => {
                    if !self.save() {
                        return;
                    }
                }
                Effect::Quit => self.leaving = true,
            }
        }
    }

    /// The texts that differ from what is on disk.
    fn overlay(&self) -> std::collections::BTreeMap<PathBuf, String> {
        self.state.texts.unsaved()
    }

    /// Writes what is unsaved; whether all of it was written. What changed on disk meanwhile is never written over.
    fn save(&mut self) -> bool {
        if self.look_at_files() && !matches!(self.state.overlay, Overlay::None) {
            return false;
        }
        let written = files::write_all(&self.state.texts.unsaved());
        let done = written.is_ok();
        let root = self.state.trail[0].file.clone();
        self.take(Message::Saved(written));
        if done {
            self.journal.drop_own();
            self.seen.forget(&root);
        }
        done
    }

    /// Takes in files that changed on disk; whether any did.
    fn look_at_files(&mut self) -> bool {
        let files: Vec<PathBuf> = self.state.texts.files().map(|(path, _)| path.clone()).collect();
        let mut any = false;
        for file in files {
            if let Some(text) = self.seen.changed(&file) {
                let base = self.state.texts.get(&file).map(|known| known.base.clone());
                if text.as_ref().ok() != base.as_ref() {
                    any = true;
                    self.take(Message::OnDisk { file, text });
                }
            }
        }
        // A nested graph that was not there may be there now.
        let missing = self.state.level().board.cards.iter().find_map(|card| match &card.role {
            Role::Nested(_, Some(file)) if self.state.texts.get(file).is_none() && file.exists() => Some(file.clone()),
            _ => None,
        });
        if let Some(file) = missing
            && let Ok(text) = files::read(&file)
        {
            any = true;
            self.take(Message::OnDisk { file, text: Ok(text) });
        }
        any
    }
}
