//! Compiled code, kept by the digest of the component and of the engine in a private folder of the user, so that a plugin is
//! compiled once. A file begins with a keyed digest of its content, whose key lies beside it for this user alone: what is
//! damaged, or was put there by anybody else, is compiled anew. A plugin cannot bring compiled code.

use crate::kernel;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use wasmtime::Engine;
use wasmtime::component::Component;
use wire::{Digest, Hasher};

/// Compiled code that this program wrote.
pub(crate) struct Sealed(Vec<u8>);

const SEAL: usize = 32;

impl Sealed {
    /// The code.
    pub fn bytes(&self) -> &[u8] {
        &self.0[SEAL..]
    }

    fn open(bytes: Vec<u8>, key: &[u8; 32]) -> Option<Self> {
        let seal = seal(bytes.get(SEAL..)?, key);
        (bytes[..SEAL] == seal.0).then_some(Self(bytes))
    }
}

fn seal(code: &[u8], key: &[u8; 32]) -> Digest {
    Hasher::new("compiled plugin").bytes(key).bytes(code).finish()
}

/// Where compiled code is kept.
#[derive(Debug, Clone)]
pub(crate) struct Compiled {
    folder: PathBuf,
}

impl Compiled {
    /// The user's own folder: `GRIMACE_PLUGIN_CODE`, else `$XDG_CACHE_HOME/grimace/plugins`, else `~/.cache/grimace/plugins`.
    pub fn of_user() -> Option<Self> {
        let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = set("GRIMACE_PLUGIN_CODE")
            .or_else(|| Some(set("XDG_CACHE_HOME")?.join("grimace/plugins")))
            .or_else(|| Some(set("HOME")?.join(".cache/grimace/plugins")))
            .or_else(|| Some(set("LOCALAPPDATA")?.join("grimace/plugins")))?;
        Some(Self { folder })
    }

    /// The component `bytes`, whose digest is `digest`: from its kept code, or compiled now.
    pub fn component(
        kept: Option<&Self>,
        engine: &Engine,
        bytes: &[u8],
        digest: &Digest,
    ) -> wasmtime::Result<Component> {
        let Some((kept, key)) = kept.and_then(|kept| Some((kept, kept.key()?))) else {
            return Component::from_binary(engine, bytes);
        };
        let path = kept.folder.join(format!("{}-{}.code", digest.short(), name_of(engine, digest).short()));
        let sealed = std::fs::read(&path).ok().and_then(|bytes| Sealed::open(bytes, &key));
        if let Some(component) = sealed.and_then(|sealed| kernel::code(engine, &sealed).ok()) {
            return Ok(component);
        }
        let component = Component::from_binary(engine, bytes)?;
        // Where it cannot be kept, it is compiled again next time.
        if let Ok(code) = component.serialize() {
            let _ = kept.put(&path, &seal(&code, &key).0, &code);
        }
        Ok(component)
    }

    fn put(&self, path: &Path, seal: &[u8], code: &[u8]) -> std::io::Result<()> {
        let mut file = tempfile::NamedTempFile::new_in(&self.folder)?;
        file.write_all(seal)?;
        file.write_all(code)?;
        file.persist(path)?;
        Ok(())
    }

    /// The key of this user's seals, made at first use. None where the folder is open to others.
    fn key(&self) -> Option<[u8; 32]> {
        make_private(&self.folder).ok()?;
        let path = self.folder.join("key");
        let read = || {
            let mut key = [0; 32];
            std::fs::File::open(&path).and_then(|mut file| file.read_exact(&mut key)).ok()?;
            Some(key)
        };
        read().or_else(|| {
            let mut hasher = Hasher::new("key");
            // A map's random state is seeded by the system.
            for _ in 0..8 {
                use std::hash::{BuildHasher, Hasher as _};
                hasher.number(std::hash::RandomState::new().build_hasher().finish());
            }
            let mut file = tempfile::NamedTempFile::new_in(&self.folder).ok()?;
            file.write_all(&hasher.finish().0).ok()?;
            // Whoever comes first makes the key of all.
            let _ = file.persist_noclobber(&path);
            read()
        })
    }
}

#[cfg(unix)]
fn make_private(folder: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(folder)?;
    let mode = std::fs::metadata(folder)?.permissions().mode();
    if mode & 0o022 != 0 {
        return Err(std::io::Error::other("the folder is open to others"));
    }
    Ok(())
}

#[cfg(not(unix))]
fn make_private(folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)
}

/// A digest of the component and of everything about the engine that compiled code depends on.
fn name_of(engine: &Engine, digest: &Digest) -> Digest {
    struct Gather(Hasher);
    impl std::hash::Hasher for Gather {
        fn write(&mut self, bytes: &[u8]) {
            self.0.bytes(bytes);
        }
        fn finish(&self) -> u64 {
            0
        }
    }
    let mut gather = Gather(Hasher::new("engine"));
    std::hash::Hash::hash(&engine.precompile_compatibility_hash(), &mut gather);
    gather.0.digest(digest);
    gather.0.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::engine;

    const EMPTY: &str = "(component (core module (func (export \"f\"))))";

    #[test]
    fn code_is_kept_and_what_is_damaged_is_compiled_anew() {
        let folder = tempfile::tempdir().unwrap();
        let kept = Compiled { folder: folder.path().join("code") };
        let bytes = wat::parse_str(EMPTY).unwrap();
        let digest = Digest::of(&bytes);
        let files = || {
            let mut paths: Vec<PathBuf> =
                std::fs::read_dir(&kept.folder).unwrap().map(|entry| entry.unwrap().path()).collect();
            paths.retain(|path| path.extension().is_some());
            paths
        };
        Compiled::component(Some(&kept), engine(), &bytes, &digest).unwrap();
        let [path] = files().try_into().unwrap();
        let written = std::fs::read(&path).unwrap();
        let key = kept.key().unwrap();
        assert!(Sealed::open(written.clone(), &key).is_some());
        for damage in [0, SEAL, written.len() - 1] {
            let mut harmed = written.clone();
            harmed[damage] ^= 1;
            assert!(Sealed::open(harmed.clone(), &key).is_none());
            std::fs::write(&path, harmed).unwrap();
            Compiled::component(Some(&kept), engine(), &bytes, &digest).unwrap();
            assert_eq!(std::fs::read(&path).unwrap()[..SEAL], written[..SEAL]);
        }
        assert!(Sealed::open(written[..10].to_vec(), &key).is_none());
    }
}
