//! Studios that were joined by a short code: the key that each showed first, so that another one later is noticed.
//!
//! Owns `known-studios.toml` in the person's folder for settings; whom a long code or a link names needs no such memory.
//! Invariant: a key is forgotten only when the person says so, and a file that is not understood is never written over.

use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

use anyhow::{Context, ensure};
use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use pottery_client::whole_file::write_whole;
use pottery_client::{Target, sentence};

/// The file.
#[derive(Debug)]
pub(crate) struct Known {
    file: Option<PathBuf>,
    /// SHA-256 of certificates in hexadecimal digits, by address as typed.
    keys: BTreeMap<String, String>,
}

impl Known {
    /// Reads the file in the person's folder for settings, or begins a new one.
    ///
    /// # Errors
    /// When there is one that is not understood.
    pub(crate) fn open() -> anyhow::Result<Self> {
        Self::at(dirs::config_dir().map(|folder| folder.join("pottery-studio").join("known-studios.toml")))
    }

    fn at(file: Option<PathBuf>) -> anyhow::Result<Self> {
        let Some(path) = &file else { return Ok(Self { file, keys: BTreeMap::new() }) };
        let keys: BTreeMap<String, String> = match fs::read_to_string(path) {
            Ok(text) => toml::from_str(&text)
                .with_context(|| format!("{} is not understood; correct or delete it", path.display()))?,
            Err(error) if error.kind() == ErrorKind::NotFound => BTreeMap::new(),
            Err(error) => return Err(error).with_context(|| format!("{} cannot be read", path.display())),
        };
        for (address, key) in &keys {
            ensure!(key_of(key).is_some(), "{}: the key of {address} is none; correct or delete it", path.display());
        }
        Ok(Self { file, keys })
    }

    /// The target with the key that it is to show: the one it showed the last time, unless the code says it, or a new one is
    /// trusted.
    pub(crate) fn expect(&self, target: Target, trusts_new_key: bool) -> Target {
        let known = self.keys.get(&target.address).and_then(|key| key_of(key));
        Target { known: known.filter(|_| !trusts_new_key), ..target }
    }

    /// Keeps the key that a studio showed; true when it was not known and there is where to keep it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn keep(&mut self, target: &Target, shown: [u8; 32]) -> anyhow::Result<bool> {
        let shown = HEXLOWER.encode(&shown);
        if target.code.print().is_some() || self.keys.get(&target.address) == Some(&shown) {
            return Ok(false);
        }
        self.keys.insert(target.address.clone(), shown);
        let Some(path) = &self.file else { return Ok(false) };
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| format!("{} cannot be made", folder.display()))?;
        }
        let text = toml::to_string(&self.keys)?;
        write_whole(path, |file| file.write_all(text.as_bytes()))?;
        Ok(true)
    }
}

/// Keeps the key that a studio showed to who came with a short code, and says so the first time.
pub(crate) fn note(target: &Target, shown: Option<[u8; 32]>) {
    let Some(shown) = shown.filter(|_| target.code.print().is_none()) else { return };
    match Known::open().and_then(|mut known| known.keep(target, shown)) {
        Ok(true) => say!(
            "note: this short code does not say which server it belongs to; the one at {} is trusted from now on",
            target.address
        ),
        Ok(false) => {}
        Err(error) => {
            let why = sentence(error.as_ref());
            note!("the key of {} is not remembered: {why}", target.address);
        }
    }
}

/// The key that is written in digits.
fn key_of(digits: &str) -> Option<[u8; 32]> {
    HEXLOWER_PERMISSIVE.decode(digits.as_bytes()).ok()?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_kept_at_first_and_expected_from_then_on() {
        let folder = std::env::temp_dir().join(format!("pottery-known-{}", std::process::id()));
        let file = Some(folder.join("new").join("known-studios.toml"));
        let target = Target::new("192.168.1.20".into(), "K7QM3XPD".parse().unwrap(), 1);
        let mut known = Known::at(file.clone()).unwrap();
        assert_eq!(known.expect(target.clone(), false).known, None);
        assert!(known.keep(&target, [7; 32]).unwrap());
        let mut known = Known::at(file.clone()).unwrap();
        assert_eq!(known.expect(target.clone(), false).known, Some([7; 32]));
        assert_eq!(known.expect(target.clone(), true).known, None, "the person trusts whatever is shown");
        assert!(!known.keep(&target, [7; 32]).unwrap());
        assert!(known.keep(&target, [8; 32]).unwrap());
        let long = Target { code: target.code.clone().on_server(&[9; 32]), ..target };
        assert!(!known.keep(&long, [9; 32]).unwrap(), "a long code says it every time");
        fs::write(file.as_ref().unwrap(), "\"192.168.1.20\" = \"7\"\n").unwrap();
        let said = Known::at(file).unwrap_err().to_string();
        assert!(said.contains("192.168.1.20") && said.contains("known-studios.toml"), "{said}");
        fs::remove_dir_all(folder).unwrap();
    }
}
