//! The terminal: taken over, given back however the editor ends, and its keys read.

use crate::model::Message;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{
    self, DisableBracketedPaste, DisableMouseCapture, EnableBracketedPaste, EnableMouseCapture, Event,
};
use ratatui::crossterm::execute;
use std::io::stdout;
use std::panic::PanicHookInfo;
use std::sync::mpsc::Sender;
use std::time::Instant;

/// What is done when something panics.
type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Send + Sync + 'static>;

/// The terminal while the editor has it.
pub struct Screen {
    /// Where one draws.
    pub terminal: DefaultTerminal,
    hook: Option<Hook>,
}

impl Screen {
    /// Takes the terminal over.
    pub fn begin() -> std::io::Result<Self> {
        // What a node says when it panics would be written over the screen; its failure is told by the cook.
        let hook = std::panic::take_hook();
        let editor = std::thread::current().id();
        std::panic::set_hook(Box::new(move |facts| {
            if std::thread::current().id() == editor {
                ratatui::restore();
                hook(facts);
            }
        }));
        let terminal = ratatui::try_init()?;
        let mut screen = Self { terminal, hook: None };
        // ratatui adds a hook that gives the terminal back on any thread's panic; a node's must not.
        screen.hook = Some(std::panic::take_hook());
        std::panic::set_hook(Box::new(move |facts| {
            if std::thread::current().id() == editor {
                ratatui::restore();
                drop(execute!(stdout(), DisableMouseCapture, DisableBracketedPaste));
                drop(std::io::Write::write_all(&mut std::io::stderr(), format!("{facts}\n").as_bytes()));
            }
        }));
        execute!(stdout(), EnableMouseCapture, EnableBracketedPaste)?;
        screen.terminal.clear()?;
        Ok(screen)
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        drop(execute!(stdout(), DisableMouseCapture, DisableBracketedPaste));
        ratatui::restore();
        if let Some(hook) = self.hook.take() {
            std::panic::set_hook(hook);
        }
    }
}

/// Reads the terminal on a thread of its own, until nobody listens.
pub fn read_keys(sender: Sender<(Instant, Message)>) {
    std::thread::spawn(move || {
        while let Ok(event) = event::read() {
            let message = match event {
                Event::Key(key) => Message::Key(key),
                Event::Mouse(mouse) => Message::Mouse(mouse),
                Event::Paste(text) => Message::Paste(text),
                Event::Resize(columns, rows) => Message::Size(columns, rows),
                Event::FocusGained | Event::FocusLost => continue,
            };
            if sender.send((Instant::now(), message)).is_err() {
                return;
            }
        }
    });
}
