//! Writes C3D files as the systems of the world do: each number format, each place for each count, parameters in any
//! order. Written from the format's description, apart from the crate's own writer, so that the reader is held against
//! something else than itself.

use face_io::c3d::Processor;

/// What a file is to hold, and how.
#[derive(Debug, Clone)]
pub struct Forge {
    pub processor: Processor,
    /// Integers of so many units a step; reals where absent.
    pub scale: Option<f32>,
    /// `POINT:UNITS`; no such parameter where absent.
    pub units: Option<&'static str>,
    pub rate_hz: f32,
    pub first_frame: u32,
    pub names: Vec<String>,
    /// Coordinates in units, frame after frame; absent where missing.
    pub points: Vec<Option<[f32; 3]>>,
    /// Analog channels, and samples of each in a frame.
    pub analog: (u16, u16),
    pub counts: Counts,
    /// The block of the parameters, 2 or more.
    pub parameter_block: u8,
    /// Most labels in one parameter.
    pub labels_a_parameter: usize,
    /// In which order the records stand.
    pub order: Order,
    /// Whether names of parameters are marked as locked, and have descriptions.
    pub locked: bool,
    /// How missing points are marked.
    pub gap: Gap,
    /// Whether the last block is filled up.
    pub padded: bool,
    /// What `POINT:USED` says, as a real, where it is not the count of points.
    pub claimed_points: Option<f32>,
}

/// Where the number of frames stands, beside the header and `POINT:FRAMES`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Counts {
    HeaderOnly,
    FloatFrames,
    LongFrames,
    TrialWords,
    TrialFloats,
}

/// In which order groups and parameters stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    GroupsFirst,
    GroupsLast,
    Backwards,
}

/// How a missing point is marked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gap {
    Residual,
    /// Reals only: coordinates that are no numbers, with a residual of 0.
    NotANumber,
}

impl Forge {
    pub fn new(names: Vec<String>, points: Vec<Option<[f32; 3]>>) -> Self {
        Self {
            processor: Processor::Intel,
            scale: None,
            units: Some("mm"),
            rate_hz: 60.0,
            first_frame: 1,
            names,
            points,
            analog: (0, 0),
            counts: Counts::HeaderOnly,
            parameter_block: 2,
            labels_a_parameter: 255,
            order: Order::GroupsFirst,
            locked: false,
            gap: Gap::Residual,
            padded: true,
            claimed_points: None,
        }
    }

    pub fn frames(&self) -> usize {
        self.points.len() / self.names.len().max(1)
    }

    fn word(&self, number: u16) -> [u8; 2] {
        if self.processor == Processor::Mips { number.to_be_bytes() } else { number.to_le_bytes() }
    }

    fn real(&self, number: f32) -> [u8; 4] {
        match self.processor {
            Processor::Intel => number.to_le_bytes(),
            Processor::Mips => number.to_be_bytes(),
            Processor::Dec => {
                // The exponent of VAX counts from 2 more; its high word comes first; it has no infinities.
                let bits = if number == 0.0 { 0 } else { number.to_bits() + (2 << 23) };
                let [a, b, c, d] = bits.to_le_bytes();
                [c, d, a, b]
            }
        }
    }

    fn record(&self, group: i8, name: &str, kind: i8, dimensions: &[u8], values: &[u8]) -> Vec<u8> {
        let description: &[u8] = if self.locked { b"locked since 1987" } else { b"" };
        let length = name.len() as i8;
        let mut out = vec![if self.locked { -length } else { length }.cast_unsigned(), group.cast_unsigned()];
        out.extend(name.bytes());
        let rest = 2 + 2 + dimensions.len() + values.len() + 1 + description.len();
        out.extend(self.word(rest as u16));
        out.extend([kind.cast_unsigned(), dimensions.len() as u8]);
        out.extend(dimensions);
        out.extend(values);
        out.push(description.len() as u8);
        out.extend(description);
        out
    }

    fn group(&self, number: i8, name: &str) -> Vec<u8> {
        let mut out = vec![name.len() as u8, (-number).cast_unsigned()];
        out.extend(name.bytes());
        out.extend(self.word(3));
        out.push(0);
        out
    }

    fn texts(&self, group: i8, name: &str, texts: &[&str]) -> Vec<u8> {
        let width = texts.iter().map(|text| text.len()).max().unwrap_or(0);
        let bytes: Vec<u8> =
            texts.iter().flat_map(|text| text.bytes().chain(std::iter::repeat(b' ')).take(width)).collect();
        self.record(group, name, -1, &[width as u8, texts.len() as u8], &bytes)
    }

    fn records(&self, data_block: u16) -> Vec<Vec<u8>> {
        let frames = self.frames() as u32;
        let last = self.first_frame + frames.max(1) - 1;
        let halves = |number: u32| [self.word(number as u16), self.word((number >> 16) as u16)].concat();
        let mut records = vec![
            match self.claimed_points {
                None => self.record(5, "USED", 2, &[], &self.word(self.names.len() as u16)),
                Some(claimed) => self.record(5, "USED", 4, &[], &self.real(claimed)),
            },
            self.record(5, "SCALE", 4, &[], &self.real(self.scale.unwrap_or(-1.0))),
            self.record(5, "RATE", 4, &[], &self.real(self.rate_hz)),
            self.record(5, "DATA_START", 2, &[], &self.word(data_block)),
            self.record(9, "USED", 2, &[], &self.word(self.analog.0)),
            self.record(9, "RATE", 4, &[], &self.real(self.rate_hz * f32::from(self.analog.1))),
            self.record(9, "SCALE", 4, &[2], &[self.real(0.1), self.real(2.5)].concat()),
            self.record(30, "CORNERS", 4, &[3, 4, 2], &[0; 96]),
            self.record(30, "TYPE", 1, &[2], &[1, 255]),
        ];
        match self.counts {
            Counts::HeaderOnly => {
                records.push(self.record(5, "FRAMES", 2, &[], &self.word(frames.min(65_535) as u16)));
            }
            Counts::FloatFrames => records.push(self.record(5, "FRAMES", 4, &[], &self.real(frames as f32))),
            Counts::LongFrames => {
                records.push(self.record(5, "FRAMES", 2, &[], &self.word(65_535)));
                records.push(self.record(5, "LONG_FRAMES", 4, &[1], &self.real(frames as f32)));
            }
            Counts::TrialWords => {
                records.push(self.record(5, "FRAMES", 2, &[], &self.word(frames.min(65_535) as u16)));
                records.push(self.record(77, "ACTUAL_START_FIELD", 2, &[2], &halves(self.first_frame)));
                records.push(self.record(77, "ACTUAL_END_FIELD", 2, &[2], &halves(last)));
            }
            Counts::TrialFloats => {
                records.push(self.record(77, "ACTUAL_START_FIELD", 4, &[1], &self.real(self.first_frame as f32)));
                records.push(self.record(77, "ACTUAL_END_FIELD", 4, &[1], &self.real(last as f32)));
            }
        }
        if let Some(units) = self.units {
            records.push(self.texts(5, "UNITS", &[units]));
        }
        for (index, names) in self.names.chunks(self.labels_a_parameter).enumerate() {
            let name = if index == 0 { "LABELS".to_owned() } else { format!("LABELS{}", index + 1) };
            records.push(self.texts(5, &name, &names.iter().map(String::as_str).collect::<Vec<_>>()));
        }
        let groups =
            [(5, "POINT"), (9, "ANALOG"), (30, "FORCE_PLATFORM"), (77, "trial")].map(|(n, name)| self.group(n, name));
        match self.order {
            Order::GroupsFirst => groups.into_iter().chain(records).collect(),
            Order::GroupsLast => records.into_iter().chain(groups).collect(),
            Order::Backwards => groups.into_iter().chain(records).rev().collect(),
        }
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let start = (usize::from(self.parameter_block) - 1) * 512;
        // The records are as long whatever block of the data they name.
        let length: usize = self.records(0).iter().map(Vec::len).sum();
        let blocks = (4 + length + 2).div_ceil(512);
        let data_block = usize::from(self.parameter_block) + blocks;
        let mut out = vec![0; start];
        (out[0], out[1]) = (self.parameter_block, 0x50);
        let frames = self.frames() as u32;
        let last = (self.first_frame + frames).saturating_sub(1).min(65_535) as u16;
        let analog = self.analog.0 * self.analog.1;
        for (index, word) in [
            (2, self.names.len() as u16),
            (3, analog),
            (4, self.first_frame.min(65_535) as u16),
            (5, last),
            (6, 10),
            (9, data_block as u16),
            (10, self.analog.1),
        ] {
            out[2 * index - 2..2 * index].copy_from_slice(&self.word(word));
        }
        out[12..16].copy_from_slice(&self.real(self.scale.unwrap_or(-1.0)));
        out[20..24].copy_from_slice(&self.real(self.rate_hz));
        out.extend([1, 0x50, blocks as u8, 83 + 1 + self.processor as u8]);
        out.extend(self.records(data_block as u16).concat());
        out.resize((data_block - 1) * 512, 0);
        for frame in self.points.chunks(self.names.len().max(1)) {
            for point in frame {
                out.extend(self.point(*point));
            }
            for sample in 0..analog {
                match self.scale {
                    None => out.extend(self.real(f32::from(sample) - 7.5)),
                    Some(_) => out.extend(self.word(sample.wrapping_mul(9_001))),
                }
            }
        }
        if self.padded {
            out.resize(out.len().div_ceil(512) * 512, 0);
        }
        out
    }

    fn point(&self, point: Option<[f32; 3]>) -> Vec<u8> {
        let missing = point.is_none();
        let by_number =
            missing && self.gap == Gap::NotANumber && self.scale.is_none() && self.processor != Processor::Dec;
        let coordinates = point.unwrap_or(if by_number { [f32::NAN; 3] } else { [0.0; 3] });
        let residual = if missing && !by_number { -1.0 } else { 3.0 };
        match self.scale {
            None => coordinates.into_iter().chain([residual]).flat_map(|number| self.real(number)).collect(),
            Some(scale) => {
                let step = |number: f32| ((number / scale).round() as i16).cast_unsigned();
                // The high byte of the last word tells which cameras saw the point.
                let last = if missing { u16::MAX } else { 0x1503 };
                coordinates.map(step).into_iter().chain([last]).flat_map(|number| self.word(number)).collect()
            }
        }
    }

    /// The position of each point in metres, as the file holds it.
    pub fn metres(&self, unit_metres: f64) -> Vec<Option<[f64; 3]>> {
        let stored = |number: f32| match self.scale {
            None => f64::from(number),
            Some(scale) => f64::from((number / scale).round() as i16) * f64::from(scale),
        };
        self.points.iter().map(|point| point.map(|point| point.map(|number| stored(number) * unit_metres))).collect()
    }
}
