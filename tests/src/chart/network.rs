//! What the network costs: how far predicted clay is from the room's, and what a byte buys.
//!
//! Owns which measurements there are and in which order they run; everything goes through sessions that the studio's own server has
//! recorded, played in virtual time.
//! Invariant: the same extent gives the same figures on every machine, but for the few bytes by which a signature of TLS is longer.

pub mod codecs;
mod pictures;
pub mod prediction;
mod session;
mod studio;
pub mod subscription;

use std::path::{Path, PathBuf};

use pottery_server::recording::RecordingError;
use pottery_shared::clay::{MethodKind, Support};
use pottery_shared::snapshot::{Detail, Quantum};

use super::progress::Progress;
use super::{ChartError, csv};
use codecs::CodecFigures;
use prediction::{Case, Overlap, PredictionFigures};
pub use session::{Clay, Take};
pub use studio::StudioError;
use subscription::SubscriptionFigures;

/// Why the network cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    /// A session could not be played.
    #[error(transparent)]
    Studio(#[from] StudioError),
    /// A session file cannot be gone through; record it anew, or choose another.
    #[error("the session {} cannot be gone through: {source}", path.display())]
    Session {
        /// Which.
        path: PathBuf,
        /// Why.
        source: RecordingError,
    },
    /// The codec did not give back what was put in, which is an error of the studio's own.
    #[error(
        "the codec gave back other clay than was put in, at tick {tick} of {name}: this is an error of the studio, please report it"
    )]
    Unlike {
        /// Of which session.
        name: String,
        /// When.
        tick: u64,
    },
    /// A file or picture cannot be made.
    #[error(transparent)]
    Chart(#[from] ChartError),
}

/// How much is measured.
#[derive(Clone, Debug)]
pub struct NetworkExtent {
    /// Ways and back, losses and overlaps that prediction is measured at.
    pub prediction: Vec<Case>,
    /// Seconds for which two hands press in each of them.
    pub prediction_s: f64,
    /// Sessions that are recorded.
    pub takes: Vec<Take>,
    /// Those of them, the first ones, that are gone through with every subscription.
    pub subscribed: usize,
    /// What is subscribed to, of every element.
    pub details: Vec<Detail>,
}

/// Every quantum, in steps of the finest, at every rate: with every so many of the room's snapshots.
fn details(steps: &[u16], every: &[u8]) -> Vec<Detail> {
    let all = every.iter().flat_map(|&every| steps.iter().map(move |&steps| (Quantum::of_steps(steps), every)));
    all.map(|(quantum, every)| Detail::new(quantum, 1, every).expect("rates within bounds")).collect()
}

impl NetworkExtent {
    /// All of it.
    #[must_use]
    pub fn full() -> Self {
        let take = |method, people| Take { method, support: Support::Backed, people, seconds: 9.0 };
        Self {
            prediction: Case::all(&[20, 50, 100, 200, 400], &[0, 1, 5, 10], &Overlap::ALL),
            prediction_s: 7.0,
            takes: vec![
                take(MethodKind::Plastic, 1),
                take(MethodKind::Plastic, 4),
                take(MethodKind::Original, 1),
                take(MethodKind::Original, 4),
            ],
            // one hand and four, of our clay
            subscribed: 2,
            details: details(&[1, 3, 5, 9, 13, 25], &[1, 2, 4, 6]),
        }
    }

    /// Under two minutes.
    #[must_use]
    pub fn quick() -> Self {
        let take = |method, people| Take { method, support: Support::Backed, people, seconds: 3.0 };
        Self {
            prediction: Case::all(&[50, 200], &[0, 5], &Overlap::ALL),
            prediction_s: 2.0,
            takes: vec![take(MethodKind::Plastic, 2), take(MethodKind::Original, 2)],
            subscribed: 1,
            details: details(&[1, 3, 13], &[1, 4]),
        }
    }
}

/// Everything that is measured.
#[derive(Clone, Debug)]
pub struct NetworkFigures {
    /// How far predicted clay is off.
    pub prediction: Vec<PredictionFigures>,
    /// What a subscription costs and shows.
    pub subscription: Vec<SubscriptionFigures>,
    /// What codecs take.
    pub codecs: Vec<CodecFigures>,
}

/// Records sessions into `folder`, which is made when it is not there, and measures; `others` are session files that were recorded
/// elsewhere, which are opened first.
///
/// # Errors
/// [`NetworkError`].
pub fn measure(
    extent: &NetworkExtent,
    folder: &Path,
    others: &[PathBuf],
    progress: &mut Progress<'_>,
) -> Result<NetworkFigures, NetworkError> {
    // before anything is measured, since what cannot be gone through would be found minutes later
    let open = |path: &PathBuf| -> Result<(String, Clay), NetworkError> {
        let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().replace(',', " "));
        Ok((name, Clay::open(path)?))
    };
    let mut others = others.iter().map(open).collect::<Result<Vec<_>, _>>()?;
    std::fs::create_dir_all(folder).map_err(|source| ChartError::Write { path: folder.to_owned(), source })?;
    let sessions = extent.takes.len() + others.len();
    let subscribed = &extent.takes[..extent.subscribed];
    progress.expect((extent.prediction.len() + extent.takes.len() + sessions + subscribed.len()) as u32);
    let mut prediction = Vec::new();
    for case in &extent.prediction {
        progress.begin(&format!("prediction, {}", case.title()));
        prediction.push(prediction::measure(case, extent.prediction_s, folder)?);
    }
    prediction::tidy(folder);
    let mut paths: Vec<(String, PathBuf)> = Vec::new();
    for take in &extent.takes {
        progress.begin(&format!("recording {}", take.title()));
        paths.push((take.title(), take.record(folder)?));
    }
    let mut codecs = Vec::new();
    for (name, path) in &paths {
        progress.begin(&format!("codecs, {name}"));
        codecs.extend(codecs::measure(name, &mut Clay::open(path)?)?);
    }
    for (name, clay) in &mut others {
        progress.begin(&format!("codecs, {name}"));
        codecs.extend(codecs::measure(name, clay)?);
    }
    let mut subscription = Vec::new();
    for (name, path) in &paths[..subscribed.len()] {
        progress.begin(&format!("subscriptions, {name}"));
        subscription.extend(subscription::measure(name, &mut Clay::open(path)?, &extent.details)?);
    }
    Ok(NetworkFigures { prediction, subscription, codecs })
}

/// Every file: name and bytes.
///
/// # Errors
/// [`ChartError::Picture`] when a picture cannot be packed.
pub fn files(figures: &NetworkFigures) -> Result<Vec<(&'static str, Vec<u8>)>, ChartError> {
    Ok(vec![
        ("prediction.csv", csv::text(&figures.prediction).into()),
        ("subscription.csv", csv::text(&figures.subscription).into()),
        ("codecs.csv", csv::text(&figures.codecs).into()),
        ("prediction.png", pictures::prediction(&figures.prediction)?),
        ("subscription.png", pictures::subscription(&figures.subscription)?),
        ("codecs.png", pictures::codecs(&figures.codecs)?),
    ])
}
