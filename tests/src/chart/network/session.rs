//! Sessions of several people that the server records, and their clay, tick by tick, from the file.
//!
//! Owns whose hands those are: the strokes of `tests/data/strokes`, with the tremor of a hand on them, through the whole haptic chain.
//! Invariant: the clay comes from the file alone, through the studio's own playback.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use pottery_client::device::Device;
use pottery_client::stroke::Stroke;
use pottery_server::recording::{Playback, Recording};
use pottery_shared::clay::{MethodKind, Pot, Support};
use pottery_shared::haptics::DeviceSpecs;
use pottery_shared::room::Happening;
use pottery_shared::snapshot::Moment;
use pottery_shared::tool::{Orientation, Tool};
use pottery_shared::units::{Rpm, Tick};

use super::studio::{Scene, play};
use super::{NetworkError, StudioError};
use crate::line::Quality;

/// Strokes that touch the clay within the first second, for as many people.
const STROKES: [&str; 4] = [
    include_str!("../../../data/strokes/evaluation.csv"),
    include_str!("../../../data/strokes/waist.csv"),
    include_str!("../../../data/strokes/foot.csv"),
    include_str!("../../../data/strokes/neck.csv"),
];

/// A session that is recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Take {
    /// How the clay gives way.
    pub method: MethodKind,
    /// What holds its wall.
    pub support: Support,
    /// How many press, up to four.
    pub people: usize,
    /// For how long, s.
    pub seconds: f64,
}

impl Take {
    /// In a few words.
    #[must_use]
    pub fn title(&self) -> String {
        let clay = match self.method {
            MethodKind::Plastic => "our clay",
            MethodKind::Original => "the original's",
            MethodKind::Improved => "the improved method's",
        };
        let hollow = if self.support == Support::Hollow { ", hollow," } else { "" };
        match self.people {
            1 => format!("{clay}{hollow} and one hand"),
            people => format!("{clay}{hollow} and {people} hands"),
        }
    }

    /// Plays it on a wheel at 60 rpm, with lines as homes have them; returns the file.
    ///
    /// # Errors
    /// [`StudioError`].
    pub fn record(&self, folder: &Path) -> Result<PathBuf, StudioError> {
        let method = format!("{:?}", self.method).to_lowercase();
        let hollow = if self.support == Support::Hollow { "-hollow" } else { "" };
        let file = folder.join(format!("{method}{hollow}-{}.session", self.people));
        let scene = Scene {
            seed: 1,
            method: self.method,
            support: self.support,
            wheel_speed: Rpm(60.0),
            line: Quality::HOME,
            seconds: self.seconds,
            file: &file,
        };
        let hand = |number: usize, begun_s: f64| -> Box<dyn Device> {
            let stroke = Stroke::parse(STROKES[number % STROKES.len()]).expect("a stroke of the repository");
            let ends_s = begun_s + self.seconds;
            Box::new(Trembling { stroke: Arc::new(stroke), begun_s, ends_s, asked_s: 0.0, number })
        };
        play(&scene, self.people, hand, |_, _, _, _| {})?;
        Ok(file)
    }
}

/// A stroke by a hand that trembles as hands do: 0.05 mm at 9 Hz and less beside it (Elble and Koller 1990 have 8 to 12 Hz).
struct Trembling {
    stroke: Arc<Stroke>,
    begun_s: f64,
    ends_s: f64,
    asked_s: f64,
    number: usize,
}

impl Device for Trembling {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        // the strokes begin outside of the clay: they are met half a second on
        self.asked_s = seconds - self.begun_s + 0.5;
        let place_m = self.stroke.at(self.asked_s).filter(|_| seconds < self.ends_s)?;
        let phase = self.number as f64 * 1.7;
        let wave = |hertz: f64, shift: f64| ((seconds * hertz + shift + phase) * std::f64::consts::TAU).sin() as f32;
        let tremor_m = Vec3::new(
            0.05e-3 * wave(9.1, 0.0) + 0.02e-3 * wave(11.3, 0.2),
            0.04e-3 * wave(8.3, 0.4),
            0.05e-3 * wave(9.7, 0.7) + 0.1e-3 * wave(1.3, 0.1),
        );
        // an Omni's encoders
        let step_m = DeviceSpecs::OMNI.resolution_m;
        Some(((place_m + tremor_m) / step_m).round() * step_m)
    }

    fn tool(&self) -> Tool {
        self.stroke.tool_at(self.asked_s)
    }

    fn orientation(&self) -> Orientation {
        self.stroke.orientation_at(self.asked_s)
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }
}

/// The clay of a session, tick by tick.
pub struct Clay {
    path: PathBuf,
    playback: Playback<File>,
    span: (Tick, Tick),
}

impl Clay {
    /// Opens a session file at its first wheel.
    ///
    /// # Errors
    /// [`NetworkError::Session`].
    pub fn open(path: &Path) -> Result<Self, NetworkError> {
        let opened = || {
            let recording = Recording::open(File::open(path)?)?;
            let span = recording.span(0).unwrap_or_default();
            Ok((Playback::begin(recording, 0)?, span))
        };
        let (playback, span) = opened().map_err(|source| NetworkError::Session { path: path.to_owned(), source })?;
        Ok(Self { path: path.to_owned(), playback, span })
    }

    /// The same file from its beginning.
    ///
    /// # Errors
    /// [`NetworkError::Session`].
    pub fn again(&self) -> Result<Self, NetworkError> {
        Self::open(&self.path)
    }

    /// Its first tick and its last.
    #[must_use]
    pub const fn span(&self) -> (Tick, Tick) {
        self.span
    }

    /// Goes on to a tick; the clay then.
    ///
    /// # Errors
    /// [`NetworkError::Session`].
    pub fn at(&mut self, tick: Tick) -> Result<&Pot, NetworkError> {
        let session = |source| NetworkError::Session { path: self.path.clone(), source };
        self.playback.advance(tick).map_err(session)?;
        Ok(self.playback.replay().pot())
    }

    /// Goes through one thing that happened; which, or `None` behind the last one.
    ///
    /// # Errors
    /// [`NetworkError::Session`].
    pub fn step(&mut self) -> Result<Option<(Tick, Happening)>, NetworkError> {
        self.playback.step().map_err(|source| NetworkError::Session { path: self.path.clone(), source })
    }

    /// The clay at the tick that was gone to, or after what was gone through last.
    #[must_use]
    pub fn pot(&self) -> &Pot {
        self.playback.replay().pot()
    }

    /// When that was, and how the wheel stood.
    #[must_use]
    pub fn moment(&self, tick: Tick) -> Moment {
        Moment { tick, phase: self.playback.replay().conditions().phase(tick) }
    }
}
