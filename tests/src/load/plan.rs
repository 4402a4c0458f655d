//! What a run is to be: how many people, doing what, for how long.
//!
//! Owns names, bounds and the files of `tests/data/load/`; starts nothing.
//! Invariant: a plan that was checked keeps within the caps, whatever file or flags it came from.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use pottery_files::sentence::{instead, of_line};
use pottery_shared::protocol::DetailWire;
use pottery_shared::snapshot::{Detail, DetailError};
use serde::{Deserialize, Serialize};

/// What spectators take in.
///
/// ```
/// use pottery_tests::load::plan::Sight;
///
/// assert_eq!("gallery".parse(), Ok(Sight::GALLERY));
/// let part: Sight = "quantum=8,fold=2,every=6,rows=4-9,tools".parse()?;
/// assert_eq!(part.to_string(), "quantum=8,fold=2,every=6,rows=4-9,tools");
/// # Ok::<(), pottery_tests::load::plan::SightError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Sight {
    /// Everything a potter gets, sixty times a second: they sit at the wheel with their hands in their lap.
    Full,
    /// One wheel, so closely.
    At(Detail),
}

impl Sight {
    /// One wheel, thirty times a second.
    pub const SPECTATOR: Self = Self::At(Detail::SPECTATOR);
    /// One wheel in a small picture, five times a second.
    pub const GALLERY: Self = Self::At(Detail::GALLERY);
}

impl Default for Sight {
    fn default() -> Self {
        Self::SPECTATOR
    }
}

/// Why there is no such sight.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SightError {
    /// No name and no list of figures.
    #[error(
        "{text:?} is no sight: say full, spectator or gallery, or quantum=8,fold=2,every=6 with figures of your own; \
         rows=4-9 shows those rows of tiles alone, and tools shows everybody's tools as well"
    )]
    Unknown {
        /// What was given.
        text: String,
    },
    /// A figure out of range.
    #[error(transparent)]
    Detail(#[from] DetailError),
}

impl FromStr for Sight {
    type Err = SightError;

    fn from_str(text: &str) -> Result<Self, SightError> {
        match text {
            "full" => return Ok(Self::Full),
            "spectator" => return Ok(Self::SPECTATOR),
            "gallery" => return Ok(Self::GALLERY),
            _ => {}
        }
        let unknown = || SightError::Unknown { text: text.to_owned() };
        let (mut quantum, mut fold, mut every, mut first, mut end, mut tools) =
            (1_u16, 1_u8, 1_u8, 0_u8, u8::MAX, false);
        for word in text.split(',') {
            let (key, value) = word.split_once('=').unwrap_or((word, ""));
            match key {
                "quantum" => quantum = value.parse().map_err(|_| unknown())?,
                "fold" => fold = value.parse().map_err(|_| unknown())?,
                "every" => every = value.parse().map_err(|_| unknown())?,
                "rows" => {
                    let (from, to) = value.split_once('-').ok_or_else(unknown)?;
                    (first, end) = (from.parse().map_err(|_| unknown())?, to.parse().map_err(|_| unknown())?);
                }
                "tools" if value.is_empty() => tools = true,
                _ => return Err(unknown()),
            }
        }
        Ok(Self::At(DetailWire::Own { quantum, fold, every, first, end, tools }.try_into()?))
    }
}

impl fmt::Display for Sight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::At(detail) = *self else { return f.write_str("full") };
        match DetailWire::from(detail) {
            DetailWire::Spectator => f.write_str("spectator"),
            DetailWire::Gallery => f.write_str("gallery"),
            DetailWire::Retold => f.write_str("retold"),
            DetailWire::Own { quantum, fold, every, first, end, tools } => {
                write!(f, "quantum={quantum},fold={fold},every={every}")?;
                if (first, end) != (0, u8::MAX) {
                    write!(f, ",rows={first}-{end}")?;
                }
                f.write_str(if tools { ",tools" } else { "" })
            }
        }
    }
}

impl TryFrom<String> for Sight {
    type Error = SightError;

    fn try_from(text: String) -> Result<Self, SightError> {
        text.parse()
    }
}

impl From<Sight> for String {
    fn from(sight: Sight) -> Self {
        sight.to_string()
    }
}

/// One run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// What it stands for, in a sentence.
    pub about: String,
    /// Wheels that a spawned server has.
    pub wheels: u16,
    /// Wheels that people sit at: the first so many; all when absent.
    pub used_wheels: Option<u16>,
    /// People who press, over all wheels.
    pub potters: u32,
    /// People who look on, over all wheels.
    pub spectators: u32,
    /// What they take in.
    pub sight: Sight,
    /// Potters who hold and predict the clay as the studio's client does, so that corrections can be measured; they cost the
    /// generator about as much as the server.
    pub full_potters: u32,
    /// Time over which people come, s.
    pub ramp_s: f64,
    /// Time after that which is left out of the figures, s.
    pub warmup_s: f64,
    /// Time that is measured, s.
    pub duration_s: f64,
    /// Of every roll of the dice.
    pub seed: u64,
    /// Potters press for so long and rest for as long, all together, s; they never rest when absent.
    pub burst_s: Option<f64>,
    /// Share of spectators who read nothing for two seconds out of four.
    pub slow_share: f64,
    /// Share of people whose connection breaks and who come again.
    pub flapping_share: f64,
    /// Time between two such breaks, s.
    pub flap_every_s: f64,
    /// Every so often, everybody's connection breaks at once, s.
    pub storm_every_s: Option<f64>,
    /// In the second half of the measured time strangers knock so often a second, with wrong codes and from one address; of a
    /// server on this machine only.
    pub strangers_per_s: u32,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            name: "custom".into(),
            about: String::new(),
            wheels: 1,
            used_wheels: None,
            potters: 4,
            spectators: 0,
            sight: Sight::default(),
            full_potters: 1,
            ramp_s: 1.0,
            warmup_s: 2.0,
            duration_s: 20.0,
            seed: 1,
            burst_s: None,
            slow_share: 0.0,
            flapping_share: 0.0,
            flap_every_s: 5.0,
            storm_every_s: None,
            strangers_per_s: 0,
        }
    }
}

/// Why a plan cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// No file and no scenario of that name.
    #[error("there is no scenario {name:?}: give a file, or one of {known}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// Those there are.
        known: String,
    },
    /// A file that cannot be read.
    #[error("the scenario {path} cannot be read: {source}")]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file that says something else.
    #[error("the scenario {path} is not understood: {reason}")]
    Syntax {
        /// Which.
        path: PathBuf,
        /// What the parser said.
        reason: String,
    },
    /// A figure out of range.
    #[error("{setting} = {value} cannot be used: choose a number from {min} to {max}")]
    Range {
        /// Name of the setting.
        setting: &'static str,
        /// What was given.
        value: f64,
        /// Smallest allowed.
        min: f64,
        /// Largest allowed.
        max: f64,
    },
}

impl Plan {
    /// Most people of a run.
    pub const PEOPLE_MAX: u32 = 4096;
    /// Most of them who press.
    pub const POTTERS_MAX: u32 = 512;
    /// Most of those who predict the clay.
    pub const FULL_POTTERS_MAX: u32 = 64;
    /// Most knocks of strangers, a second.
    pub const STRANGERS_MAX: u32 = 10_000;
    /// Longest that people come, and that is left out of the figures after it, s.
    pub const PREPARATION_MAX_S: f64 = 3600.0;
    /// Longest run, s.
    pub const DURATION_MAX_S: f64 = 86_400.0;

    /// A scenario by its file, or by the name of one in `tests/data/load/`.
    ///
    /// # Errors
    /// [`PlanError`].
    pub fn read(name: &str) -> Result<Self, PlanError> {
        let given = PathBuf::from(name);
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/load");
        let path = if given.is_file() { given } else { folder.join(name).with_extension("toml") };
        if !path.is_file() {
            return Err(PlanError::Unknown { name: name.to_owned(), known: names(&folder).join(", ") });
        }
        let text = std::fs::read_to_string(&path).map_err(|source| PlanError::File { path: path.clone(), source })?;
        let parsed = if path.extension().is_some_and(|ending| ending == "json") {
            serde_json::from_str(&text).map_err(|error| instead(&error.to_string()))
        } else {
            toml::from_str(&text).map_err(|error| of_line(&text, error.span().map(|span| span.start), error.message()))
        };
        parsed.map_err(|reason| PlanError::Syntax { path, reason })
    }

    /// Checks every figure.
    ///
    /// # Errors
    /// [`PlanError::Range`] with the setting and its bounds.
    pub fn checked(self) -> Result<Self, PlanError> {
        let within = |setting: &'static str, value: f64, min: f64, max: f64| {
            if (min..=max).contains(&value) { Ok(()) } else { Err(PlanError::Range { setting, value, min, max }) }
        };
        let wheels_max = f64::from(pottery_server::ServerConfig::WHEELS_MAX);
        let people_max = f64::from(Self::PEOPLE_MAX);
        within("wheels", f64::from(self.wheels), 1.0, wheels_max)?;
        within("used_wheels", f64::from(self.used()), 1.0, f64::from(self.wheels))?;
        within("potters", f64::from(self.potters), 0.0, f64::from(Self::POTTERS_MAX))?;
        within("spectators", f64::from(self.spectators), 0.0, people_max)?;
        // of nobody there is nothing to measure, but how strangers are sent away
        let people_min = f64::from(u8::from(self.strangers_per_s == 0));
        within("potters and spectators", f64::from(self.people()), people_min, people_max)?;
        within("full_potters", f64::from(self.full_potters), 0.0, f64::from(Self::FULL_POTTERS_MAX))?;
        within("ramp_s", self.ramp_s, 0.0, Self::PREPARATION_MAX_S)?;
        within("warmup_s", self.warmup_s, 0.0, Self::PREPARATION_MAX_S)?;
        within("duration_s", self.duration_s, 1.0, Self::DURATION_MAX_S)?;
        within("burst_s", self.burst_s.unwrap_or(1.0), 0.1, 3600.0)?;
        within("slow_share", self.slow_share, 0.0, 1.0)?;
        within("flapping_share", self.flapping_share, 0.0, 1.0)?;
        within("flap_every_s", self.flap_every_s, 1.0, 3600.0)?;
        within("storm_every_s", self.storm_every_s.unwrap_or(60.0), 1.0, 3600.0)?;
        within("strangers_per_s", f64::from(self.strangers_per_s), 0.0, f64::from(Self::STRANGERS_MAX))?;
        Ok(self)
    }

    /// Wheels that people sit at.
    #[must_use]
    pub fn used(&self) -> u16 {
        self.used_wheels.unwrap_or(self.wheels)
    }

    /// Everybody.
    #[must_use]
    pub const fn people(&self) -> u32 {
        self.potters + self.spectators
    }

    /// Time from the beginning to the end of what is measured, s.
    #[must_use]
    pub fn total_s(&self) -> f64 {
        self.ramp_s + self.warmup_s + self.duration_s
    }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path().file_stem()?.to_string_lossy().into_owned()))
        .collect();
    names.sort();
    names
}
