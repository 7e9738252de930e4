//! Makes the SDK's bindings from the interface: `cargo run --manifest-path plugins/bindings/Cargo.toml` writes
//! `plugins/sdk/src/bindings.rs`.

use std::path::Path;
use wit_bindgen_core::{Files, WorldGenerator, wit_parser::Resolve};

const HEAD: &str = "//! Generated from `plugins/wit` by `cargo run` in `plugins/bindings`: do not edit.\n";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let plugins = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut resolve = Resolve::default();
    let (package, _) = resolve.push_path(plugins.join("wit/since-0.1/node.wit"))?;
    let world = resolve.select_world(&[package], None)?;
    let options = wit_bindgen_rust::Opts {
        runtime_path: Some("crate::runtime".into()),
        pub_export_macro: true,
        export_macro_name: Some("export_bindings".into()),
        default_bindings_module: Some("crate::bindings".into()),
        additional_derive_attributes: vec!["PartialEq".into()],
        format: true,
        ..Default::default()
    };
    let mut files = Files::default();
    options.build().generate(&mut resolve, world, &mut files)?;
    for (_, text) in files.iter().filter(|(name, _)| name.ends_with(".rs")) {
        let text = [HEAD.as_bytes(), text].concat();
        std::fs::write(plugins.join("sdk/src/bindings.rs"), text)?;
    }
    Ok(())
}
