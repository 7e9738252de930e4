//! The state of the editor: what is edited, what is selected, what is open, what is known of the cook. Nothing here draws,
//! reads files or waits.

pub mod board;
pub mod catalogue;
pub mod curves;
pub mod fields;
pub mod keymap;
pub mod layout;
pub mod line;
pub mod merge;
pub mod status;
pub mod texts;
pub mod view_of;
pub mod wiring;

use crate::preview::Preview;
use board::Board;
use catalogue::Catalogue;
use curves::{CurveWork, Desk};
use graph_core::cook::{Event, Summary};
use graph_core::document::Diagnostic;
use keymap::Keymap;
use layout::{Layout, Zoom};
use line::Line;
use ratatui::crossterm::event::{KeyEvent, MouseEvent};
use status::Statuses;
use std::path::PathBuf;
use std::sync::Arc;
use texts::{Operation, Texts};
use wiring::Choice;

/// Where keys go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Focus {
    /// The graph.
    #[default]
    Canvas,
    /// The parameters.
    Form,
    /// The value of the selected output.
    Preview,
    /// The curves that are worked on.
    Curves,
}

/// A port of the selected card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PortAt {
    /// Whether it is an input.
    pub input: bool,
    /// Its position.
    pub at: usize,
}

/// A graph file that is open, from the root down.
#[derive(Debug, Clone)]
pub struct Level {
    /// The file.
    pub file: PathBuf,
    /// The node that nests it; for the root, the file's name.
    pub name: String,
    /// Names before those of its nodes, ending in `/` where not empty.
    pub prefix: String,
    /// The selected card.
    pub selected: Option<String>,
    /// The selected port.
    pub port: Option<PortAt>,
    /// The part of the board that shows: its left and upper edge.
    pub pan: (i32, i32),
    /// What stands on it.
    pub board: Arc<Board>,
    /// Where that stands.
    pub layout: Arc<Layout>,
    /// Where it stands at the other zoom, once that was asked for.
    pub other: Option<Arc<Layout>>,
}

/// What is being asked for in a line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ask {
    /// A new name for a node.
    Rename(String),
    /// A name for a new node of a kind, to be wired to a port.
    NewName(String, Option<wiring::Fit>),
    /// A node to go to.
    Find,
    /// A channel to go to.
    Channel,
    /// What a key asks for.
    Key,
}

/// What must be decided before anything else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Question {
    /// Whether to leave with unsaved edits.
    Quit,
    /// A file changed on disk where it was edited here.
    Conflict {
        /// The file.
        file: PathBuf,
        /// What it holds on disk.
        theirs: String,
    },
    /// Edits of an editor that was not closed.
    Journal {
        /// The edits.
        operations: Vec<Operation>,
        /// The texts that they begin with, by file.
        bases: Vec<(PathBuf, String)>,
    },
}

/// What lies over everything.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Overlay {
    /// Nothing.
    #[default]
    None,
    /// The keys; the number is the first line that shows.
    Help(usize),
    /// Kinds to add.
    Palette {
        /// What is typed.
        line: Line,
        /// The chosen one.
        at: usize,
        /// What it should fit to.
        fit: Option<wiring::Fit>,
    },
    /// A line of text.
    Prompt {
        /// What for.
        ask: Ask,
        /// What is typed.
        line: Line,
        /// What is wrong with it.
        error: Option<String>,
    },
    /// What a port may be wired to.
    Wiring {
        /// The port.
        fit: wiring::Fit,
        /// What is typed.
        line: Line,
        /// All that there is, with reasons against.
        choices: Vec<Choice>,
        /// The chosen one.
        at: usize,
    },
    /// A question.
    Question(Question),
}

/// The parameters of the selected node, or of the graph.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Form {
    /// Whether the graph's own parameters show.
    pub of_graph: bool,
    /// The chosen field.
    pub at: usize,
    /// The value that is being typed.
    pub editing: Option<Line>,
    /// What is wrong with it.
    pub error: Option<String>,
}

/// A cook that runs.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cooking {
    /// Cells known.
    pub cells: usize,
    /// Cells done.
    pub done: usize,
    /// Whether it was asked to end.
    pub cancelled: bool,
    /// The texts' revision that is cooked.
    pub revision: u64,
}

/// A line that tells how something went.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The text.
    pub text: String,
    /// Whether something is wrong.
    pub bad: bool,
}

/// Everything.
#[derive(Debug, Clone)]
pub struct State {
    /// The files.
    pub texts: Texts,
    /// The open levels, the root first; never empty.
    pub trail: Vec<Level>,
    /// What is known of the nodes.
    pub statuses: Statuses,
    /// The item of repeated nodes that shows.
    pub item: Option<String>,
    /// Mistakes in the graph as it is now.
    pub mistakes: Arc<Vec<Diagnostic>>,
    /// The texts' revision that was checked last.
    pub checked: u64,
    /// Where keys go.
    pub focus: Focus,
    /// What lies over everything.
    pub overlay: Overlay,
    /// How much of cards is shown.
    pub zoom: Zoom,
    /// Columns and rows of the terminal.
    pub size: (u16, u16),
    /// The parameters.
    pub form: Form,
    /// Whether the preview shows.
    pub preview_open: bool,
    /// What it shows.
    pub preview: Preview,
    /// The curves that are worked on.
    pub work: Option<CurveWork>,
    /// The cook that runs.
    pub cooking: Option<Cooking>,
    /// How the last thing went.
    pub note: Option<Note>,
    /// Beats of the clock, for what moves.
    pub beat: u64,
    /// The kinds.
    pub catalogue: Arc<Catalogue>,
    /// The keys.
    pub keymap: Arc<Keymap>,
    /// Where the mouse last was pressed, while it drags the board.
    pub drag: Option<(u16, u16)>,
}

/// What happens to the editor.
#[derive(Debug)]
pub enum Message {
    /// A key.
    Key(KeyEvent),
    /// The mouse.
    Mouse(MouseEvent),
    /// Pasted text.
    Paste(String),
    /// The terminal has another size.
    Size(u16, u16),
    /// Time passed.
    Beat,
    /// The texts were checked.
    Checked {
        /// Their revision.
        revision: u64,
        /// The mistakes.
        mistakes: Vec<Diagnostic>,
        /// How each cell stands.
        events: Vec<Event>,
    },
    /// A cook began.
    CookBegan,
    /// A cook tells something.
    Cook(Event),
    /// A cook is over.
    CookEnded(Result<Summary, String>),
    /// A value that was asked for.
    Peeked {
        /// The cell and port.
        of: (String, String),
        /// The value, made ready to be drawn.
        value: Result<Arc<crate::preview::Picture>, String>,
    },
    /// The curves that are worked on, as the texts of this revision make them.
    Desk {
        /// The cell and port that were asked for.
        of: (String, String),
        /// The texts' revision.
        revision: u64,
        /// The curves, or why there are none.
        desk: Result<Arc<Desk>, String>,
    },
    /// A file on disk.
    OnDisk {
        /// The file.
        file: PathBuf,
        /// What it holds, or why it cannot be read.
        text: Result<String, String>,
    },
    /// Plugins were found, or others than before.
    Kinds(Arc<Catalogue>),
    /// Files were written.
    Saved(Result<Vec<(PathBuf, String)>, String>),
    /// Edits of an editor that was not closed.
    JournalFound {
        /// The edits.
        operations: Vec<Operation>,
        /// The texts that they begin with.
        bases: Vec<(PathBuf, String)>,
        /// Those of the files that are no graphs, as they are on disk.
        sources: Vec<(PathBuf, String)>,
    },
}

/// What is to be done outside of the state.
#[derive(Debug, Clone, PartialEq)]
pub enum Effect {
    /// Read a graph file that is nested, or the file of the edits that are worked on.
    Read(PathBuf),
    /// Check the texts and see what a cook would do.
    Check,
    /// Drop what stands in memory: nodes compute something else now.
    Forget,
    /// Cook everything, or only some nodes and what they need.
    Cook(Vec<String>),
    /// End the cook.
    Cancel,
    /// Write all that is unsaved.
    Save,
    /// Note an operation in the journal.
    Journal(Operation),
    /// Get the value of a cell's output.
    Peek(String, String),
    /// Cook what work on a cell's curves shows, and get it.
    Work(String, String),
    /// Throw the journal away.
    DropJournal,
    /// End the editor.
    Quit,
}
