//! From a core module, as compilers give it, to a component that speaks the interface.

use super::BuildError;
use wit_component::{ComponentEncoder, StringEncoding, embed_component_metadata};
use wit_parser::Resolve;

/// The interface, as it is written.
pub const INTERFACE: &str = include_str!("../../../wit/since-0.1/node.wit");

/// Names of the sections in which compilers' bindings leave the interface.
const BOUND: &[u8] = b"component-type";

/// Makes a component of a core module: text or binary, with or without the interface in it. A component stays as it is.
///
/// # Errors
/// Where it is no module, or does not export what the interface asks for.
pub fn component(core: &[u8]) -> Result<Vec<u8>, BuildError> {
    let wrong = |problem: String| BuildError::Component { problem };
    let mut module = wat::parse_bytes(core).map_err(|error| wrong(error.to_string()))?.into_owned();
    if module.get(4..8) == Some(&[0x0d, 0, 1, 0]) {
        return Ok(module);
    }
    if !module.windows(BOUND.len()).any(|bytes| bytes == BOUND) {
        let mut resolve = Resolve::default();
        let package = resolve.push_str("node.wit", INTERFACE).map_err(|error| wrong(format!("{error:#}")))?;
        let world = resolve.select_world(&[package], None).map_err(|error| wrong(format!("{error:#}")))?;
        embed_component_metadata(&mut module, &resolve, world, StringEncoding::UTF8)
            .map_err(|error| wrong(format!("{error:#}")))?;
    }
    let encoder = ComponentEncoder::default().validate(true).module(&module);
    encoder.and_then(|mut encoder| encoder.encode()).map_err(|error| wrong(format!("{error:#}")))
}
