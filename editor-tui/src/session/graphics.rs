//! Pictures on terminals that draw them: asked for when the editor begins, shown over the preview, taken away again.
//!
//! Kitty's protocol takes pixels as they are and keeps them until they are deleted; sixels are drawn into the screen like
//! letters. Which of them a terminal has, it tells when asked; `GRIMACE_GRAPHICS` (`kitty`, `sixel`, `none`) decides without asking.

use super::sixel;
use crate::view::{Look, Pixels};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use ratatui::crossterm::cursor::{MoveTo, RestorePosition, SavePosition};
use ratatui::crossterm::queue;
use ratatui::crossterm::terminal::window_size;
use std::io::Write;

/// How a terminal takes pictures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Protocol {
    Kitty,
    Sixel,
}

/// The pictures of one terminal.
pub struct Graphics {
    protocol: Protocol,
    shown: Option<Look>,
}

/// The number of our picture.
const IMAGE: u32 = 20_471;

/// Bytes of one piece of a picture, at most.
const PIECE: usize = 4096;

impl Graphics {
    /// What the terminal can draw; it is to be in raw mode, and nobody else may read from it meanwhile.
    pub fn ask() -> Option<Self> {
        let protocol = match std::env::var("GRIMACE_GRAPHICS").as_deref() {
            Ok("kitty") => Some(Protocol::Kitty),
            Ok("sixel") => Some(Protocol::Sixel),
            Ok(_) => None,
            Err(_) => answer().as_deref().and_then(told),
        };
        Some(Self { protocol: protocol?, shown: None })
    }

    /// Width and height of a cell in pixels.
    pub fn cell_px(&self) -> Option<(u16, u16)> {
        let size = window_size().ok();
        let own = size.map(|size| (size.width / size.columns.max(1), size.height / size.rows.max(1)));
        match own.filter(|(width, height)| *width >= 2 && *height >= 2) {
            // Kitty's protocol fits a picture into its cells by itself.
            None => (self.protocol == Protocol::Kitty).then_some((8, 16)),
            known => known,
        }
    }

    /// Whether what shows now must be wiped before the screen is drawn.
    pub fn stale(&self, next: Option<&Look>) -> bool {
        let moved = |shown: &Look| next.is_none_or(|next| next.area != shown.area);
        self.protocol == Protocol::Sixel && self.shown.as_ref().is_some_and(moved)
    }

    /// Shows what `next` looks at, drawn by `draw`, or nothing; where it shows already, nothing is sent.
    pub fn show(
        &mut self,
        next: Option<Look>,
        draw: impl FnOnce(&Look) -> Option<Pixels>,
        out: &mut impl Write,
    ) -> std::io::Result<()> {
        if next == self.shown {
            return Ok(());
        }
        match (self.protocol, next.as_ref().and_then(draw)) {
            (Protocol::Kitty, None) => write!(out, "\x1b_Ga=d,d=I,i={IMAGE},q=2\x1b\\")?,
            (Protocol::Sixel, None) => {}
            (protocol, Some(pixels)) => {
                let text = if protocol == Protocol::Kitty { kitty(&pixels) } else { sixel::encoded(&pixels) };
                queue!(out, SavePosition, MoveTo(pixels.area.x, pixels.area.y))?;
                out.write_all(text.as_bytes())?;
                queue!(out, RestorePosition)?;
            }
        }
        self.shown = next;
        out.flush()
    }
}

/// The sequences that draw a picture at the cursor and leave it there, in the place of the one before.
fn kitty(pixels: &Pixels) -> String {
    let bytes: Vec<u8> = pixels.colours.iter().flatten().copied().collect();
    let text = STANDARD.encode(bytes);
    let mut out = String::with_capacity(text.len() + text.len() / 64);
    let pieces = text.len().div_ceil(PIECE);
    for (number, first) in (0..text.len()).step_by(PIECE).enumerate() {
        let more = u8::from(number + 1 < pieces);
        let head = if number == 0 {
            let (area, width, height) = (pixels.area, pixels.width, pixels.height);
            let cells = format!("c={},r={}", area.width, area.height);
            format!("a=T,i={IMAGE},p=1,q=2,f=24,s={width},v={height},{cells},C=1,m={more}")
        } else {
            format!("q=2,m={more}")
        };
        out.push_str("\x1b_G");
        out.push_str(&head);
        out.push(';');
        out.push_str(&text[first..(first + PIECE).min(text.len())]);
        out.push_str("\x1b\\");
    }
    out
}

/// What a terminal's answer tells of it. All answer the question for their attributes, of which 4 are sixels; those who know
/// Kitty's protocol answer that one before.
fn told(answer: &str) -> Option<Protocol> {
    if answer.contains(&format!("_Gi={IMAGE};OK")) {
        return Some(Protocol::Kitty);
    }
    let attributes = answer.split("\x1b[?").nth(1)?.split('c').next()?;
    attributes.split(';').skip(1).any(|attribute| attribute == "4").then_some(Protocol::Sixel)
}

/// Asks the terminal; what it says within a fifth of a second.
#[cfg(unix)]
fn answer() -> Option<String> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use std::time::{Duration, Instant};
    let stdin = std::io::stdin();
    let mut out = std::io::stdout();
    write!(out, "\x1b_Gi={IMAGE},s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\\x1b[c").ok()?;
    out.flush().ok()?;
    let (begun, patience) = (Instant::now(), Duration::from_millis(200));
    let mut said = Vec::new();
    while let Some(left) = patience.checked_sub(begun.elapsed()) {
        let mut waiting = [PollFd::new(&stdin, PollFlags::IN)];
        let left = Timespec { tv_sec: 0, tv_nsec: i64::from(left.subsec_nanos()) };
        if poll(&mut waiting, Some(&left)).ok()? == 0 {
            break;
        }
        let mut buffer = [0; 256];
        let count = rustix::io::read(&stdin, &mut buffer[..]).ok()?;
        said.extend_from_slice(&buffer[..count]);
        let text = String::from_utf8_lossy(&said);
        if count == 0 || text.split("\x1b[?").nth(1).is_some_and(|attributes| attributes.contains('c')) {
            return Some(text.into_owned());
        }
    }
    None
}

#[cfg(not(unix))]
fn answer() -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use ratatui::layout::Rect;

    #[test]
    fn terminals_tell_what_they_draw() {
        assert_eq!(told("\x1b_Gi=20471;OK\x1b\\\x1b[?62;c"), Some(Protocol::Kitty));
        assert_eq!(told("\x1b[?63;1;2;4;6c"), Some(Protocol::Sixel));
        assert_eq!(told("\x1b[?64;1;2c"), None);
        assert_eq!(told("\x1b[?4;1c"), None, "the first number is the kind of terminal");
        assert_eq!(told("abc"), None);
    }

    fn pixels(width: usize, height: usize) -> Pixels {
        Pixels { area: Rect::new(3, 2, 10, 4), width, height, colours: vec![[1, 2, 3]; width * height] }
    }

    #[test]
    fn a_picture_goes_out_in_pieces_that_hold_all_of_it() {
        let text = kitty(&pixels(100, 60));
        let pieces: Vec<&str> = text.split("\x1b\\").filter(|piece| !piece.is_empty()).collect();
        assert!(pieces.len() > 1 && pieces[0].contains("s=100,v=60,c=10,r=4"));
        let last = pieces.len() - 1;
        for (at, piece) in pieces.iter().enumerate() {
            let (head, body) = piece.split_once(';').unwrap();
            assert!(head.ends_with(if at == last { "m=0" } else { "m=1" }) && body.len() <= PIECE);
        }
        let body: String = pieces.iter().map(|piece| piece.split_once(';').unwrap().1).collect();
        assert_eq!(STANDARD.decode(body).unwrap(), [1, 2, 3].repeat(6000));
    }
}
