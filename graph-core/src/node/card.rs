//! Cards: what a node type says of itself.

use super::port::{Port, PortFacts};
use wire::{Data, Digest};

/// How a node uses time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Time {
    /// Its outputs may depend on every frame of its inputs.
    Whole,
    /// Frame t of its outputs needs only frames t − halo to t + halo of its time-varying inputs.
    PerFrame {
        /// Frames needed on either side.
        halo: usize,
    },
}

/// Something that a kind's computation is made of and that may change while its version stays: a plugin's bytes, say. It is
/// part of the key of every cell of the kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Code {
    /// What it is, in two words, such as `plugin code`.
    pub label: &'static str,
    /// Which it is, for people: name, version, the beginning of a digest.
    pub text: String,
    /// What it is known by.
    pub digest: Digest,
}

/// What a node says of itself: where it belongs, its ports, its version, how it uses time and files.
#[derive(Debug, Clone, PartialEq)]
pub struct Card {
    /// Folder in which the node stands, in the order of the data's flow.
    pub folder: &'static str,
    /// Version of its computation; raise it whenever results change.
    pub version: u32,
    /// What its computation is made of beside this program.
    pub code: Vec<Code>,
    /// Inputs.
    pub inputs: Vec<PortFacts>,
    /// Outputs.
    pub outputs: Vec<PortFacts>,
    /// How it uses time.
    pub time: Time,
    /// Parameter that names the file, or the pattern of files, it reads.
    pub reads: Option<&'static str>,
    /// Parameter that names the file it writes.
    pub writes: Option<&'static str>,
}

impl Card {
    /// A card in `folder`, version 1, that uses time as a whole.
    pub fn new(folder: &'static str) -> Self {
        Self {
            folder,
            version: 1,
            code: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            time: Time::Whole,
            reads: None,
            writes: None,
        }
    }

    /// Adds an input that must be connected.
    #[must_use]
    pub fn takes<T: Data>(mut self, port: &Port<T>) -> Self {
        self.inputs.push(port.facts());
        self
    }

    /// Adds an input that may be left open.
    #[must_use]
    pub fn may_take<T: Data>(mut self, port: &Port<T>) -> Self {
        self.inputs.push(PortFacts { optional: true, ..port.facts() });
        self
    }

    /// Adds an input that gathers all items of a list, in the order of their names.
    #[must_use]
    pub fn gathers<T: Data>(mut self, port: &Port<T>) -> Self {
        self.inputs.push(PortFacts { list: true, ..port.facts() });
        self
    }

    /// Adds an input that gathers all items of a list, or may be left open.
    #[must_use]
    pub fn may_gather<T: Data>(mut self, port: &Port<T>) -> Self {
        self.inputs.push(PortFacts { list: true, optional: true, ..port.facts() });
        self
    }

    /// Says that the input added last is given whole, though it varies over time and the node works per frame.
    #[must_use]
    pub fn still(mut self) -> Self {
        if let Some(port) = self.inputs.last_mut() {
            port.still = true;
        }
        self
    }

    /// Adds an output.
    #[must_use]
    pub fn gives<T: Data>(mut self, port: &Port<T>) -> Self {
        self.outputs.push(port.facts());
        self
    }

    /// Adds an output that is a list of named items.
    #[must_use]
    pub fn gives_list<T: Data>(mut self, port: &Port<T>) -> Self {
        self.outputs.push(PortFacts { list: true, ..port.facts() });
        self
    }

    /// Sets the version of the computation.
    #[must_use]
    pub fn version(mut self, version: u32) -> Self {
        self.version = version;
        self
    }

    /// Says that frame t needs only frames t − `halo` to t + `halo` of the time-varying inputs.
    #[must_use]
    pub fn per_frame(mut self, halo: usize) -> Self {
        self.time = Time::PerFrame { halo };
        self
    }

    /// Says which parameter names the file, or pattern of files, that the node reads.
    #[must_use]
    pub fn reads(mut self, parameter: &'static str) -> Self {
        self.reads = Some(parameter);
        self
    }

    /// Says which parameter names the file that the node writes; its output is then published there.
    #[must_use]
    pub fn writes(mut self, parameter: &'static str) -> Self {
        self.writes = Some(parameter);
        self.outputs.push(crate::cook::FILES.facts());
        self
    }

    /// The input called `name`.
    pub fn input(&self, name: &str) -> Option<&PortFacts> {
        self.inputs.iter().find(|port| port.name == name)
    }

    /// The output called `name`.
    pub fn output(&self, name: &str) -> Option<&PortFacts> {
        self.outputs.iter().find(|port| port.name == name)
    }
}
