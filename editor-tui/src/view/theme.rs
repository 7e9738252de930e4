//! Colours: few, calm, and told apart on terminals of 16, 256 or all colours.

use crate::model::status::Standing;
use ratatui::style::{Color, Modifier, Style};

/// How many colours a terminal has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Depth {
    /// Sixteen, as the terminal's own palette has them.
    #[default]
    Sixteen,
    /// The cube of 256.
    Cube,
    /// All.
    Full,
}

/// What one terminal can show.
#[derive(Debug, Clone, Copy, Default)]
pub struct Theme {
    /// How many there are.
    pub depth: Depth,
    /// Width and height of a cell in pixels, where the terminal draws pictures.
    pub cell_px: Option<(u16, u16)>,
}

/// A colour in full, and its nearest among sixteen.
type Paint = ((u8, u8, u8), Color);

const GROUND: Paint = ((13, 14, 20), Color::Black);
const ACCENT: Paint = ((137, 180, 250), Color::LightBlue);
const FAINT: Paint = ((110, 115, 141), Color::DarkGray);
const TEXT: Paint = ((205, 214, 244), Color::White);
const SOFT: Paint = ((166, 173, 200), Color::Gray);
const GOOD: Paint = ((166, 227, 161), Color::Green);
const STALE: Paint = ((249, 226, 175), Color::Yellow);
const BAD: Paint = ((243, 139, 168), Color::LightRed);
const KEY: Paint = ((250, 179, 135), Color::LightYellow);
const LIVE: Paint = ((116, 199, 236), Color::LightCyan);

/// Types that are met often; others share the colours by the letters of their names.
const TYPES: [(&str, Paint); 10] = [
    ("Curves", ((166, 227, 161), Color::Green)),
    ("Markers", ((249, 226, 175), Color::Yellow)),
    ("Rig", ((203, 166, 247), Color::Magenta)),
    ("Features", ((148, 226, 213), Color::Cyan)),
    ("Networks", ((250, 179, 135), Color::LightRed)),
    ("Image", ((137, 220, 235), Color::LightCyan)),
    ("Meshes", ((245, 194, 231), Color::LightMagenta)),
    ("Regions", ((180, 190, 254), Color::LightBlue)),
    ("Attachment", ((242, 205, 205), Color::LightYellow)),
    ("File", ((147, 153, 178), Color::Gray)),
];

impl Theme {
    /// The theme for what the environment says of the terminal.
    pub fn of_terminal() -> Self {
        let variable = |name: &str| std::env::var(name).unwrap_or_default();
        let full = ["truecolor", "24bit"].contains(&variable("COLORTERM").as_str());
        let depth = if full {
            Depth::Full
        } else if variable("TERM").contains("256") {
            Depth::Cube
        } else {
            Depth::Sixteen
        };
        Self { depth, cell_px: None }
    }

    fn paint(self, paint: Paint) -> Color {
        match self.depth {
            Depth::Sixteen => paint.1,
            _ => self.rgb(paint.0.0, paint.0.1, paint.0.2),
        }
    }

    /// The nearest that the terminal has to a colour.
    pub fn rgb(self, r: u8, g: u8, b: u8) -> Color {
        match self.depth {
            Depth::Full => Color::Rgb(r, g, b),
            Depth::Cube => {
                let step = |part: u8| {
                    if part < 48 {
                        0
                    } else if part < 115 {
                        1
                    } else {
                        (part - 35) / 40
                    }
                };
                let most = r.max(g).max(b) - r.min(g).min(b);
                if most < 12 {
                    let grey = (u16::from(r) + u16::from(g) + u16::from(b)) / 3;
                    let step = (grey.saturating_sub(3) / 10).min(23) as u8;
                    return Color::Indexed(232 + step);
                }
                Color::Indexed(16 + 36 * step(r) + 6 * step(g) + step(b))
            }
            Depth::Sixteen => {
                let light = (u16::from(r) * 3 + u16::from(g) * 6 + u16::from(b)) / 10;
                match light {
                    0..=45 => Color::Black,
                    46..=115 => Color::DarkGray,
                    116..=195 => Color::Gray,
                    _ => Color::White,
                }
            }
        }
    }

    /// Behind everything: the colours are made for a dark ground, whatever the terminal's own is.
    pub fn ground(self) -> Color {
        self.paint(GROUND)
    }

    /// What keys act on.
    pub fn accent(self) -> Style {
        Style::new().fg(self.paint(ACCENT))
    }

    /// What is there but not looked at.
    pub fn faint(self) -> Style {
        Style::new().fg(self.paint(FAINT))
    }

    /// What is read.
    pub fn text(self) -> Style {
        Style::new().fg(self.paint(TEXT))
    }

    /// What is read second.
    pub fn soft(self) -> Style {
        Style::new().fg(self.paint(SOFT))
    }

    /// What is wrong.
    pub fn bad(self) -> Style {
        Style::new().fg(self.paint(BAD))
    }

    /// What runs.
    pub fn live(self) -> Style {
        Style::new().fg(self.paint(LIVE))
    }

    /// A key that a person set.
    pub fn key(self) -> Style {
        Style::new().fg(self.paint(KEY))
    }

    /// A chosen line.
    pub fn chosen(self) -> Style {
        match self.depth {
            Depth::Sixteen => Style::new().add_modifier(Modifier::REVERSED),
            _ => Style::new().bg(self.rgb(49, 50, 68)).fg(self.paint(TEXT)),
        }
    }

    /// A panel's ground.
    pub fn panel(self) -> Style {
        match self.depth {
            Depth::Sixteen => Style::new(),
            _ => Style::new().bg(self.rgb(24, 24, 37)),
        }
    }

    /// The colour of a type's ports and wires.
    pub fn of_type(self, name: &str) -> Color {
        if name.is_empty() {
            return self.paint(FAINT);
        }
        let known = TYPES.iter().find(|(known, _)| *known == name).map(|(_, paint)| *paint);
        let by_letters = || TYPES[name.bytes().map(usize::from).sum::<usize>() % TYPES.len()].1;
        self.paint(known.unwrap_or_else(by_letters))
    }

    /// The sign and style of a standing; what runs turns with `beat`.
    pub fn of_standing(self, standing: Standing, beat: u64) -> (&'static str, Style) {
        const TURNING: [&str; 4] = ["◐", "◓", "◑", "◒"];
        match standing {
            Standing::Unknown => ("·", self.faint()),
            Standing::Clean => ("●", Style::new().fg(self.paint(GOOD))),
            Standing::Waiting => ("◌", Style::new().fg(self.paint(STALE))),
            Standing::Stale => ("○", Style::new().fg(self.paint(STALE))),
            Standing::Cooking => (TURNING[(beat / 2 % 4) as usize], self.live().add_modifier(Modifier::BOLD)),
            Standing::Skipped => ("⊘", self.faint()),
            Standing::Failed => ("✗", self.bad().add_modifier(Modifier::BOLD)),
        }
    }
}
