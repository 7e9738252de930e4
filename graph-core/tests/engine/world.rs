//! A small world for engine tests: numbers over frames, nodes that read, scale, blur, split, sum and write them, and a
//! project folder that is cooked while its events are kept.
use graph_core::cook::{Artifact, Event, FILES, Options, Summary, cook};
use graph_core::document::Override;
use graph_core::node::{Card, Context, Inputs, Node, NodeError, Outputs, Port};
use graph_core::plan::load;
use graph_core::register;
use graph_core::store::Store;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use wire::{Data, DecodeError, Decoder, Encoder, FrameAxis, JoinError, Value, ValueKind};

/// One number a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    pub axis: FrameAxis,
    pub values: Vec<f64>,
}

impl Value for Series {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }
    fn encode(&self, out: &mut Encoder) {
        out.record(&self.axis);
        out.f64s(&self.values);
    }
    fn summary(&self) -> String {
        format!("{} numbers", self.values.len())
    }
    fn size(&self) -> usize {
        self.values.len() * 8
    }
    fn axis(&self) -> Option<FrameAxis> {
        Some(self.axis)
    }
    fn slice(&self, frames: Range<usize>) -> Option<Arc<dyn Value>> {
        Some(Arc::new(Self { axis: self.axis.slice(&frames), values: self.values[frames].to_vec() }))
    }
}

impl Data for Series {
    const NAME: &'static str = "Series";
    const VERSION: u32 = 1;
    const FRAMED: bool = true;
    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { axis: input.record()?, values: input.f64s()? })
    }
    fn join(slices: &[&Self]) -> Result<Self, JoinError> {
        let count = slices.iter().map(|slice| slice.axis.count).sum();
        let values = slices.iter().flat_map(|slice| slice.values.iter().copied()).collect();
        Ok(Self { axis: FrameAxis { count, ..slices[0].axis }, values })
    }
}

/// One number without frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Number(pub f64);

impl Value for Number {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }
    fn encode(&self, out: &mut Encoder) {
        out.f64s(&[self.0]);
    }
    fn summary(&self) -> String {
        self.0.to_string()
    }
    fn size(&self) -> usize {
        8
    }
}

impl Data for Number {
    const NAME: &'static str = "Number";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;
    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self(input.f64s()?[0]))
    }
}

const SERIES: Port<Series> = Port::new("series", "numbers over frames");
const NUMBER: Port<Number> = Port::new("number", "a number");

macro_rules! kind {
    ($(#[$doc:meta])* $name:ident, $tag:literal, { $($field:ident : $type:ty = $default:expr),* }, $card:expr, $compute:expr) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $($field: $type),* }
        impl Default for $name {
            fn default() -> Self { Self { $($field: $default),* } }
        }
        register!($name);
        #[typetag::serde(name = $tag)]
        impl Node for $name {
            fn card(&self) -> Card { let card: fn(&Self) -> Card = $card; card(self) }
            fn compute(&self, context: &Context<'_>, inputs: &Inputs) -> Result<Outputs, NodeError> {
                let compute: fn(&Self, &Context<'_>, &Inputs) -> Result<Outputs, NodeError> = $compute;
                compute(self, context, inputs)
            }
        }
    };
}

kind!(
    /// Reads numbers, one a line.
    Read, "read", { path: String = String::new() },
    |_| Card::new("load").gives(&SERIES).reads("path"),
    |_, context, _| {
        let file = context.source()?;
        let text = String::from_utf8_lossy(&file.bytes).into_owned();
        let values = text.lines().map(|line| line.parse().map_err(|_| NodeError::file(&file.name, format!("`{line}` is no number"))));
        let values: Vec<f64> = values.collect::<Result<_, _>>()?;
        Ok(Outputs::default().with(&SERIES, Series { axis: FrameAxis::new(values.len(), 60.0), values }))
    }
);

kind!(
    /// Multiplies every frame.
    Scale, "scale", { by: f64 = 2.0 },
    |_| Card::new("work").takes(&SERIES).gives(&SERIES).per_frame(0),
    |node, _, inputs| {
        let series = inputs.get(&SERIES)?;
        assert!(node.by <= 1000.0, "far too large");
        let values = series.values.iter().map(|value| value * node.by).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis: series.axis, values }))
    }
);

kind!(
    /// Averages each frame with its neighbours.
    Blur, "blur", { halo: usize = 2 },
    |node| Card::new("work").takes(&SERIES).gives(&SERIES).per_frame(node.halo),
    |node, _, inputs| {
        let series = inputs.get(&SERIES)?;
        let last = series.values.len() - 1;
        let values = (0..=last).map(|t| {
            let near = &series.values[t.saturating_sub(node.halo)..=(t + node.halo).min(last)];
            near.iter().sum::<f64>() / near.len() as f64
        }).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis: series.axis, values }))
    }
);

kind!(
    /// Rounds every frame, so that small edits are cut off here.
    Round, "round", {},
    |_| Card::new("work").takes(&SERIES).gives(&SERIES).per_frame(0),
    |_, _, inputs| {
        let series = inputs.get(&SERIES)?;
        let values = series.values.iter().map(|value| value.round()).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis: series.axis, values }))
    }
);

kind!(
    /// Sums all series that it gathers.
    Sum, "sum", { offset: f64 = 0.0 },
    |_| Card::new("work").gathers(&SERIES).gives(&NUMBER),
    |node, _, inputs| {
        let total = inputs.items(&SERIES)?.iter().flat_map(|(_, series)| &series.values).sum::<f64>();
        Ok(Outputs::default().with(&NUMBER, Number(total + node.offset)))
    }
);

kind!(
    /// Cuts a series into named runs of ten frames.
    Split, "split", {},
    |_| Card::new("work").takes(&SERIES).gives_list(&SERIES),
    |_, _, inputs| {
        let series = inputs.get(&SERIES)?;
        let runs = series.values.chunks(10).enumerate().map(|(run, values)| {
            (format!("run{run}"), Series { axis: FrameAxis::new(values.len(), 60.0), values: values.to_vec() })
        });
        Ok(Outputs::default().with_list(&SERIES, runs))
    }
);

kind!(
    /// Adds a number to every frame.
    Add, "add", {},
    |_| Card::new("work").takes(&SERIES).takes(&NUMBER).gives(&SERIES).per_frame(0),
    |_, _, inputs| {
        let (series, number) = (inputs.get(&SERIES)?, inputs.get(&NUMBER)?);
        let values = series.values.iter().map(|value| value + number.0).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis: series.axis, values }))
    }
);

kind!(
    /// Averages all series that it gathers, frame by frame.
    Mean, "mean", {},
    |_| Card::new("work").gathers(&SERIES).gives(&SERIES).per_frame(0),
    |_, _, inputs| {
        let items = inputs.items(&SERIES)?;
        let axis = items[0].1.axis;
        let sum = |t: usize| items.iter().map(|(_, series)| series.values[t]).sum::<f64>();
        let values = (0..axis.count).map(|t| sum(t) / items.len() as f64).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis, values }))
    }
);

/// The versions that kinds of the test have reached, by `slot`; 1 where none is set.
pub static VERSIONS: Mutex<BTreeMap<u32, u32>> = Mutex::new(BTreeMap::new());

fn version_of(slot: u32) -> u32 {
    VERSIONS.lock().unwrap().get(&slot).copied().unwrap_or(1)
}

kind!(
    /// Adds half of its version, rounded down: versions 2 and 3 give the same.
    Versioned, "versioned", { slot: u32 = 0 },
    |node| Card::new("work").takes(&SERIES).gives(&SERIES).per_frame(0).version(version_of(node.slot)),
    |node, _, inputs| {
        let (series, more) = (inputs.get(&SERIES)?, f64::from(version_of(node.slot) / 2));
        let values = series.values.iter().map(|value| value + more).collect();
        Ok(Outputs::default().with(&SERIES, Series { axis: series.axis, values }))
    }
);

/// Frames that `count` nodes gave since it was last set.
pub static COUNTED: AtomicUsize = AtomicUsize::new(0);

kind!(
    /// Gives what it takes, and counts the frames.
    Count, "count", {},
    |_| Card::new("work").takes(&SERIES).gives(&SERIES).per_frame(0),
    |_, _, inputs| {
        let series = inputs.get(&SERIES)?;
        COUNTED.fetch_add(series.values.len(), Ordering::Relaxed);
        Ok(Outputs::default().with(&SERIES, series.clone()))
    }
);

kind!(
    /// Writes numbers, one a line.
    Write, "write", { path: String = String::new() },
    |_| Card::new("save").takes(&SERIES).writes("path"),
    |_, _, inputs| {
        let text = lines(inputs.get(&SERIES)?.values.iter().copied());
        Ok(Outputs::default().with(&FILES, Artifact { bytes: text.into_bytes() }))
    }
);

/// Numbers as text, one a line.
fn lines(numbers: impl Iterator<Item = f64>) -> String {
    let lines: Vec<String> = numbers.map(|number| number.to_string()).collect();
    lines.join("\n") + "\n"
}

/// A folder that vanishes, in memory where the system has such: what is tested here is the engine, not the disk.
fn memory_folder() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() }
}

/// A folder with a graph, its files and its store.
pub struct Project {
    folder: tempfile::TempDir,
    pub options: Options,
}

/// What a cook told.
pub struct Cooked {
    pub events: Vec<Event>,
    pub summary: Summary,
}

impl Cooked {
    /// Cells that were computed, with the number of blocks computed, in the order of their names.
    pub fn cooked(&self) -> Vec<(String, usize)> {
        let mut cells: Vec<_> = self
            .events
            .iter()
            .filter_map(|event| match event {
                Event::Cooked { node, blocks_cooked, .. } => Some((node.clone(), *blocks_cooked)),
                _ => None,
            })
            .collect();
        cells.sort();
        cells
    }

    /// Names of the cells that were computed.
    pub fn names(&self) -> Vec<String> {
        self.cooked().into_iter().map(|(name, _)| name).collect()
    }
}

impl Project {
    pub fn new(graph: &str) -> Self {
        let project =
            Self { folder: memory_folder(), options: Options { jobs: 2, keep_cheap: true, ..Options::default() } };
        project.write("graph.ron", graph);
        project
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// Writes a series of `count` frames, frame t holding `value(t)`.
    pub fn series(&self, name: &str, count: usize, value: impl Fn(usize) -> f64) {
        self.write(name, &lines((0..count).map(value)));
    }

    pub fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn store(&self) -> Arc<Store> {
        Arc::new(Store::at(&self.path("store")))
    }

    pub fn cook(&self) -> Cooked {
        self.cook_with(&[])
    }

    pub fn cook_with(&self, set: &[&str]) -> Cooked {
        cook_at(&self.path("graph.ron"), &self.store(), &self.options, set)
    }
}

pub fn cook_at(graph: &Path, store: &Arc<Store>, options: &Options, set: &[&str]) -> Cooked {
    let overrides: Vec<Override> = set.iter().map(|text| Override::parse(text).unwrap()).collect();
    let plan = load(graph, &overrides).unwrap_or_else(|mistakes| panic!("{mistakes:#?}"));
    let events = Mutex::new(Vec::new());
    let cancel = Arc::new(AtomicBool::new(false));
    let tell = |event| events.lock().unwrap().push(event);
    let summary = cook(plan, &overrides, Arc::clone(store), options, cancel, &tell).unwrap();
    Cooked { events: events.into_inner().unwrap(), summary }
}
