//! A session as people have it: the real server with its recorder, the real clients, QUIC between them, over a network in memory.
//!
//! Owns the run; whose hands go where is the caller's affair. A millisecond of virtual time is a tick of every hand.
//! Invariant: what a hand feels is that of the studio's own loop: nothing of it is made anew here.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use pottery_client::boundary::Status;
use pottery_client::device::Device;
use pottery_client::{Command, HapticLoop, JoinError, NetworkReport, Seat};
use pottery_server::ServerConfig;
use pottery_shared::clay::{MethodKind, Pot, PotSpec, Support};
use pottery_shared::units::{Rpm, Tick};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, sleep_until};

use crate::line::Quality;
use crate::simulation::{Joined, Simulation, SimulationError, in_virtual_time, ms};

/// Time for what was pressed last to reach the room.
const QUIET: Duration = Duration::from_secs(2);

/// Why a session could not be played.
#[derive(Debug, thiserror::Error)]
pub enum StudioError {
    /// A session of an earlier run cannot be taken away.
    #[error("a session cannot be begun: {0}; choose another folder")]
    Begin(#[from] std::io::Error),
    /// There is no server; the message says what is in the way.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Somebody could not join.
    #[error("person {number} cannot join: {source}")]
    Join {
        /// Who.
        number: usize,
        /// Why.
        source: JoinError,
    },
}

/// What is played.
pub(super) struct Scene<'a> {
    pub(super) seed: u64,
    pub(super) method: MethodKind,
    pub(super) support: Support,
    pub(super) wheel_speed: Rpm,
    /// Of everybody's line, each way.
    pub(super) line: Quality,
    /// Seconds from the moment at which all are there.
    pub(super) seconds: f64,
    /// Where the server's recorder writes.
    pub(super) file: &'a Path,
}

/// A person whose hand is ticked here.
struct Person {
    endpoint: quinn::Endpoint,
    epoch: Instant,
    status: Arc<Status>,
    commands: mpsc::Sender<Command>,
    worker: tokio::task::JoinHandle<NetworkReport>,
    hand: HapticLoop,
    last: u64,
}

/// Plays a scene with a hand for each person, which is made when all have joined, by the seconds on its own clock at which that is.
/// `felt` is told of every tick of everybody: who, at which of the room's ticks, where the tool is, m, and the clay that the hand then
/// feels. What the clients' workers measured comes back.
///
/// # Errors
/// [`StudioError`].
pub(super) fn play(
    scene: &Scene<'_>,
    people: usize,
    hand: impl Fn(usize, f64) -> Box<dyn Device>,
    mut felt: impl FnMut(usize, Tick, Option<Vec3>, &Pot),
) -> Result<Vec<NetworkReport>, StudioError> {
    // an earlier run's, of the same name: a server writes over none
    if scene.file.exists() {
        std::fs::remove_file(scene.file)?;
    }
    in_virtual_time(async {
        let config = ServerConfig {
            method: scene.method,
            pot: PotSpec { support: scene.support, ..PotSpec::default() },
            wheel_speed: scene.wheel_speed,
            record: Some(scene.file.to_owned()),
            ..ServerConfig::default()
        };
        let studio = Simulation::open(scene.seed, config)?;
        let mut seats = Vec::new();
        for number in 0..people {
            let joined = studio.join(number as u8, scene.line, scene.line, &studio.target(1)).await;
            let Joined { endpoint, seat, .. } = joined.map_err(|source| StudioError::Join { number, source })?;
            let Seat { status, commands, epoch, worker, hand, .. } = seat;
            seats.push((endpoint, status, commands, epoch, tokio::spawn(worker.run()), hand));
        }
        let begun = Instant::now();
        let mut persons = Vec::new();
        for (number, (endpoint, status, commands, epoch, worker, side)) in seats.into_iter().enumerate() {
            let since = epoch.elapsed();
            let hand = HapticLoop::new(hand(number, since.as_secs_f64()), side);
            persons.push(Person { endpoint, epoch, status, commands, worker, hand, last: since.as_millis() as u64 });
        }
        let ticks = (scene.seconds * 1e3) as u64 + QUIET.as_millis() as u64;
        for tick in 1..=ticks {
            sleep_until(begun + ms(tick)).await;
            for (number, person) in persons.iter_mut().enumerate() {
                person.tick(|tick, tool_m, pot| felt(number, tick, tool_m, pot));
            }
        }
        let mut reports = Vec::new();
        for person in persons {
            // who is gone already has nothing to leave, and its worker has a report all the same
            drop(person.commands.send(Command::Leave).await);
            reports.extend(person.worker.await);
            person.endpoint.close(0_u32.into(), b"goodbye");
        }
        sleep(ms(100)).await;
        studio.server.stop().await;
        Ok(reports)
    })
}

impl Person {
    /// Does the tick that is due, if one is.
    fn tick(&mut self, felt: impl FnOnce(Tick, Option<Vec3>, &Pot)) {
        let local = self.epoch.elapsed().as_millis() as u64;
        if local > self.last {
            self.last = local;
            let stamp = Tick(0).offset(local as i64 + self.status.tick_offset());
            self.hand.tick(local);
            felt(stamp, self.status.tool_m(), self.hand.hand().field().pot());
        }
    }
}
