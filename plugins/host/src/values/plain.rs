//! A number, a text, and bytes.

use wire::{Data, DecodeError, Decoder, Encoder, Rows, Table, Tolerance, Value, ValueKind};

/// One number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

/// A text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Text(pub String);

/// Bytes that only the plugins that pass them on understand.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Blob {
    /// Version of what the bytes are, as the plugin counts it.
    pub version: u32,
    /// The bytes.
    pub bytes: Vec<u8>,
}

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

    fn tables(&self) -> Vec<Table<'_>> {
        vec![Table {
            what: "number",
            unit: "",
            tolerance: Tolerance { absolute: 1e-9, relative: 1e-6 },
            rows: Rows::Counted("row", 1),
            columns: vec!["number".to_owned()],
            number: Box::new(|_, _| self.0),
        }]
    }
}

impl Data for Number {
    const NAME: &'static str = "Number";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        match input.f64s()?.as_slice() {
            [number] => Ok(Self(*number)),
            _ => Err(DecodeError::Invalid { what: "number".to_owned() }),
        }
    }
}

impl Value for Text {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.text(&self.0);
    }

    fn summary(&self) -> String {
        let line = self.0.lines().next().unwrap_or_default();
        let shown: String = line.chars().take(60).collect();
        format!("{} letters: {shown}", self.0.chars().count())
    }

    fn size(&self) -> usize {
        self.0.len()
    }
}

impl Data for Text {
    const NAME: &'static str = "Text";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        input.text().map(Self)
    }
}

impl Value for Blob {
    fn kind(&self) -> ValueKind {
        ValueKind::of::<Self>()
    }

    fn encode(&self, out: &mut Encoder) {
        out.record(&self.version);
        out.blob(&self.bytes);
    }

    fn summary(&self) -> String {
        format!("{} bytes, version {}", self.bytes.len(), self.version)
    }

    fn size(&self) -> usize {
        self.bytes.len()
    }
}

impl Data for Blob {
    const NAME: &'static str = "Blob";
    const VERSION: u32 = 1;
    const FRAMED: bool = false;

    fn decode(input: &mut Decoder<'_>) -> Result<Self, DecodeError> {
        Ok(Self { version: input.record()?, bytes: input.blob()?.to_vec() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_round_trip() {
        let number = Number(2.5);
        let read = (number.kind().decode)(&(&number as &dyn Value).encoded()).unwrap();
        assert_eq!(read.downcast_ref::<Number>(), Some(&number));
        let text = Text("chin up".to_owned());
        let read = (text.kind().decode)(&(&text as &dyn Value).encoded()).unwrap();
        assert_eq!(read.downcast_ref::<Text>(), Some(&text));
        let blob = Blob { version: 3, bytes: vec![1, 2, 3] };
        let read = (blob.kind().decode)(&(&blob as &dyn Value).encoded()).unwrap();
        assert_eq!(read.downcast_ref::<Blob>(), Some(&blob));
    }
}
