//! What a person likes the window to be like, kept from one run to the next.
//!
//! Owns `preferences.toml` in the person's folder for settings; what the wheel is set to is the room's.
//! Invariant: a file that is not understood is said and never written over.

use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use pottery_client::device::Fit;
use pottery_client::of_line;
use pottery_client::render::Finish;
use pottery_client::whole_file::write_whole;
use serde::{Deserialize, Serialize};

use crate::window::TOOL_MM;
use crate::words::{Language, Words};

/// Smallest and largest text, % of the usual.
pub(crate) const TEXT_PERCENT: (u16, u16) = (80, 200);

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Theme {
    /// Light on dark.
    #[default]
    Dark,
    /// Dark on light.
    Light,
    /// As the system is set.
    System,
}

/// What is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct Preferences {
    /// The window's language; the system's when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) language: Option<Language>,
    pub(crate) theme: Theme,
    pub(crate) text_percent: u16,
    /// Whether the clay is to be heard.
    pub(crate) sound: bool,
    /// Radius of the sphere, mm.
    pub(crate) sphere_mm: f32,
    /// What the clay is shown as.
    #[serde(with = "finish_name")]
    pub(crate) finish: Finish,
    /// Whether the first lesson is over.
    pub(crate) knows_lesson: bool,
    /// How devices were fitted to the hand, by their names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(crate) fits: BTreeMap<String, KeptFit>,
}

/// How a device is fitted to the hand, as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct KeptFit {
    /// Where the hand rests, mm from the device's own origin: to the right, away and up.
    middle_mm: [f32; 3],
    /// How many times as far as the hand the tool goes.
    scale: f32,
}

impl KeptFit {
    pub(crate) fn of(fit: Fit) -> Self {
        // to a tenth of a millimetre and a hundredth, as people read it
        let round = |value: f32, parts: f32| (value * parts).round() / parts;
        let middle_mm = fit.middle_m.to_array().map(|along_m| round(along_m * 1e3, 10.0));
        Self { middle_mm, scale: round(fit.scale, 100.0) }
    }
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            language: None,
            theme: Theme::default(),
            text_percent: 100,
            sound: true,
            sphere_mm: crate::window::Holding::default().sphere_mm,
            finish: Finish::default(),
            knows_lesson: false,
            fits: BTreeMap::new(),
        }
    }
}

/// Why preferences are not those of the file.
#[derive(Debug, thiserror::Error)]
pub(crate) enum PreferencesError {
    /// It cannot be read.
    #[error("your preferences in {path} cannot be read ({source}); the usual ones are used and nothing is kept")]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It says something else.
    #[error("your preferences in {path} are not understood ({reason}); correct the file or delete it")]
    Syntax {
        /// Which file.
        path: PathBuf,
        /// What the parser said, in a line.
        reason: String,
        /// What the other lines say.
        understood: Box<Preferences>,
    },
}

impl Preferences {
    /// The file, where the system has a folder for such things.
    pub(crate) fn file() -> Option<PathBuf> {
        dirs::config_dir().map(|folder| folder.join("pottery-studio").join("preferences.toml"))
    }

    /// Reads them; the usual ones where there is no file yet.
    ///
    /// # Errors
    /// [`PreferencesError`] when the file is not understood, with what of it is.
    pub(crate) fn read(path: &Path) -> Result<Self, PreferencesError> {
        let text = match fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            Err(source) => return Err(PreferencesError::File { path: path.to_path_buf(), source }),
        };
        let read: Self = toml::from_str(&text).map_err(|error| PreferencesError::Syntax {
            path: path.to_path_buf(),
            reason: of_line(&text, error.span().map(|span| span.start), error.message()),
            understood: Box::new(Self::understood(&text).within_bounds()),
        })?;
        Ok(read.within_bounds())
    }

    /// What is understood of a file that is not as a whole: whoever needs large letters needs them to read why, too.
    fn understood(text: &str) -> Self {
        let mut lines: toml::Table = toml::from_str(text).unwrap_or_default();
        lines.retain(|name, value| {
            let alone = toml::Table::from_iter([(name.to_owned(), value.clone())]);
            alone.try_into::<Self>().is_ok()
        });
        lines.try_into().unwrap_or_default()
    }

    /// How a device of that name was fitted, if that can be used.
    pub(crate) fn fit(&self, device: &str) -> Option<Fit> {
        let KeptFit { middle_mm, scale } = *self.fits.get(device)?;
        Fit { middle_m: middle_mm.map(|along_mm| along_mm * 1e-3).into(), scale }.sound()
    }

    /// Numbers that somebody typed, brought to what can be had.
    fn within_bounds(self) -> Self {
        let sphere_mm = if self.sphere_mm.is_finite() { self.sphere_mm } else { Self::default().sphere_mm };
        Self {
            text_percent: self.text_percent.clamp(TEXT_PERCENT.0, TEXT_PERCENT.1),
            sphere_mm: sphere_mm.clamp(TOOL_MM.0, TOOL_MM.1),
            ..self
        }
    }

    /// Writes them, whole or not at all.
    ///
    /// # Errors
    /// What is in the way, in a sentence.
    pub(crate) fn write(&self, path: &Path) -> Result<(), String> {
        let text = toml::to_string(self).map_err(|error| error.to_string())?;
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|error| format!("{} cannot be made: {error}", folder.display()))?;
        }
        write_whole(path, |file| file.write_all(text.as_bytes())).map_err(|error| error.to_string())
    }
}

/// What keeps them while a window is open.
#[derive(Debug)]
pub(crate) struct Keeper {
    /// None where nothing can be kept, or must not be.
    file: Option<PathBuf>,
    /// As they were last written or read.
    liking: Preferences,
    trouble: Option<Trouble>,
}

#[derive(Debug)]
enum Trouble {
    /// A file that is not understood.
    Unread(PreferencesError),
    /// A file that cannot be written, and why.
    Unwritten(String),
}

impl Keeper {
    /// Reads the file; without one nothing is kept.
    pub(crate) fn open(file: Option<PathBuf>) -> Self {
        let read = file.as_deref().map_or_else(|| Ok(Preferences::default()), Preferences::read);
        match read {
            Ok(liking) => Self { file, liking, trouble: None },
            // it may be a slip of the pen: what the person wrote is not lost
            Err(error) => {
                let liking = match &error {
                    PreferencesError::Syntax { understood, .. } => (**understood).clone(),
                    PreferencesError::File { .. } => Preferences::default(),
                };
                Self { file: None, liking, trouble: Some(Trouble::Unread(error)) }
            }
        }
    }

    /// As they are kept.
    pub(crate) const fn liking(&self) -> &Preferences {
        &self.liking
    }

    /// In the language that the person chose, or the system's.
    pub(crate) fn words(&self) -> Words {
        Words::new(self.liking.language.unwrap_or_else(Language::of_system))
    }

    /// Keeps them, if they are others than before.
    pub(crate) fn keep(&mut self, liking: &Preferences) {
        if *liking == self.liking {
            return;
        }
        self.liking = liking.clone();
        if let Some(file) = &self.file {
            self.trouble = liking.write(file).err().map(Trouble::Unwritten);
        }
    }

    /// Why nothing is kept, in a sentence.
    pub(crate) fn trouble(&self, words: &Words) -> Option<String> {
        self.trouble.as_ref().map(|trouble| match trouble {
            Trouble::Unread(error) => error.to_string(),
            Trouble::Unwritten(reason) => words.say_with("not-kept", &[("reason", reason)]),
        })
    }
}

/// A finish by its name.
mod finish_name {
    use pottery_client::render::Finish;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde's form")]
    pub(super) fn serialize<S: Serializer>(finish: &Finish, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(finish.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Finish, D::Error> {
        let name = String::deserialize(deserializer)?;
        let known = || Finish::ALL.map(Finish::name).join(", ");
        Finish::from_name(&name).ok_or_else(|| D::Error::custom(format!("there is no finish {name:?}: {}", known())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("pottery-preferences-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn what_is_written_is_read_again_and_no_file_is_the_usual() {
        let folder = folder("written");
        let path = folder.join("new").join("preferences.toml");
        assert_eq!(Preferences::read(&path).unwrap(), Preferences::default());
        let liked = Preferences {
            language: Some(Language::German),
            theme: Theme::Light,
            text_percent: 150,
            sphere_mm: 7.5,
            fits: [("falcon".to_owned(), KeptFit { middle_mm: [1.5, -20.0, 125.0], scale: 2.5 })].into(),
            ..Preferences::default()
        };
        assert_eq!(liked.fit("falcon").map(KeptFit::of), liked.fits.get("falcon").copied());
        liked.write(&path).unwrap();
        assert_eq!(Preferences::read(&path).unwrap(), liked);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_misspelt_line_is_named_and_numbers_are_brought_to_what_can_be_had() {
        let folder = folder("misspelt");
        let path = folder.join("preferences.toml");
        fs::write(&path, "them = \"dark\"\ntext_percent = 180\n").unwrap();
        let said = Preferences::read(&path).unwrap_err().to_string();
        assert!(said.contains("them") && said.contains("preferences.toml"), "{said}");
        let mut keeper = Keeper::open(Some(path.clone()));
        let understood = Preferences { text_percent: 180, ..Preferences::default() };
        assert_eq!(*keeper.liking(), understood, "what is understood of it holds");
        keeper.keep(&Preferences { text_percent: 150, ..Preferences::default() });
        assert!(keeper.trouble(&Words::new(Language::English)).is_some_and(|said| said.contains("them")));
        assert!(fs::read_to_string(&path).unwrap().starts_with("them = \"dark\"\n"), "what the person wrote stays");
        let typed = "text_percent = 9000\nsphere_mm = inf\n[fits.falcon]\nmiddle_mm = [nan, 0.0, 0.0]\nscale = 1.0\n";
        fs::write(&path, typed).unwrap();
        let read = Preferences::read(&path).unwrap();
        assert_eq!((read.text_percent, read.sphere_mm), (TEXT_PERCENT.1, Preferences::default().sphere_mm));
        assert_eq!(read.fit("falcon"), None);
        fs::remove_dir_all(folder).unwrap();
    }
}
