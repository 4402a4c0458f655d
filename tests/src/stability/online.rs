//! Simulated hands on one pot, with a server and a network between them: worker, room, prediction and loop are the studio's own.
//!
//! Owns how hands join, hold on and end; what they mean to do, and what comes of it, is the scenarios' affair.
//! Invariant: a hand begins just after a whole second of the room, so that clay is rounded at the same moments of every session.

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use pottery_client::boundary::Status;
use pottery_client::view::SharedView;
use pottery_client::{Command, HapticLoop, Seat};
use pottery_server::ServerConfig;
use pottery_shared::clay::Pot;
use pottery_shared::tool::Tool;
use pottery_shared::units::Rpm;
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep, sleep_until};

use super::bench::{Bench, Felt, Scene, told_device};
use super::mechanism::{Grip, Mechanism};
use crate::line::Quality;
use crate::simulation::{Joined, Simulation, in_virtual_time, ms};

/// Whoever joined at first begins at this tick of the room: by then a lead has found itself.
pub(super) const BEGIN: i64 = 3000;
/// Between two looks whether all hold the same clay.
const LOOK: Duration = ms(2);
/// After so long nobody waits on.
const PATIENCE: Duration = Duration::from_secs(20);

/// Where a hand means to be at a second after it began, m.
pub(super) type Meant = Arc<dyn Fn(f64) -> Vec3 + Send + Sync>;

/// A hand of a session.
#[derive(Clone)]
pub(super) struct Holder {
    pub(super) grip: Grip,
    pub(super) tool: Tool,
    pub(super) meant_m: Meant,
    /// Seconds after the first began at which it begins, a whole number of them; it joins one before.
    pub(super) from_s: u16,
    /// When it undoes what it did, s.
    pub(super) undoes_s: Option<f64>,
}

impl Holder {
    /// Somebody who is there from the beginning.
    pub(super) fn new(grip: Grip, meant_m: impl Fn(f64) -> Vec3 + Send + Sync + 'static) -> Self {
        Self { grip, tool: Tool::default(), meant_m: Arc::new(meant_m), from_s: 0, undoes_s: None }
    }
}

/// What is worked on, over which line each way, with which dice, and until which second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Session {
    pub(super) scene: Scene,
    pub(super) line: Quality,
    pub(super) seed: u64,
    pub(super) seconds: u16,
}

/// What came of it.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Tick by tick of every hand.
    pub(super) felt: Vec<Vec<Felt>>,
    /// For how many of them every hand stamped its samples as far ahead as at first.
    pub(super) steady: Vec<usize>,
    /// Time from the last press, and from when the last was due in the room, until all held the same clay; `None` when they never did.
    pub(super) settled: Option<[Duration; 2]>,
    /// Samples that were made and not pressed.
    pub(super) lost: u64,
    /// The room's clay in the end.
    pub(super) pot: Pot,
}

/// Somebody who has ended.
struct Person {
    felt: Vec<Felt>,
    steady: usize,
    last_press: Instant,
    last_stamp: i64,
    view: SharedView,
    status: Arc<Status>,
    commands: mpsc::Sender<Command>,
    worker: JoinHandle<pottery_client::NetworkReport>,
    endpoint: quinn::Endpoint,
}

/// Plays a session.
///
/// # Panics
/// When a server cannot be started in memory, or somebody cannot join it.
pub(super) fn hold(session: &Session, holders: &[Holder]) -> Held {
    let Session { scene, seed, .. } = *session;
    let (method, pot) = (scene.method, Bench::spec(&scene));
    let config = ServerConfig { wheel_speed: Rpm(scene.rpm), method, pot, ..ServerConfig::default() };
    in_virtual_time(async {
        let studio = Arc::new(Simulation::open(seed, config).expect("a server in memory"));
        let people: Vec<_> = (0..)
            .zip(holders)
            .map(|(number, holder)| tokio::spawn(take_part(Arc::clone(&studio), *session, number, holder.clone())))
            .collect();
        let mut ended = Vec::new();
        for person in people {
            ended.push(person.await.expect("nobody fails alone"));
        }
        let settled = settle(&studio, &ended).await;
        let mut standing = studio.server.standing().await.expect("a server answers until it is stopped");
        let pot = standing.pots.swap_remove(0);
        let mut held = Held { felt: Vec::new(), steady: Vec::new(), settled, lost: 0, pot };
        for person in ended {
            held.lost += person.status.lost_samples();
            person.commands.send(Command::Leave).await.expect("a worker listens until it has left");
            person.worker.await.expect("a worker ends by itself");
            person.endpoint.close(0_u32.into(), b"goodbye");
            held.felt.push(person.felt);
            held.steady.push(person.steady);
        }
        let standing = studio.server.standing().await.expect("a server answers until it is stopped");
        held.lost += standing.counts.refusals.total();
        if let Some(studio) = Arc::into_inner(studio) {
            studio.server.stop().await;
        }
        held
    })
}

/// Joins in time, keeps still in the air until it begins, and holds on to the end.
async fn take_part(studio: Arc<Simulation>, session: Session, number: u8, holder: Holder) -> Person {
    let Session { scene, line, .. } = session;
    let begin = BEGIN + i64::from(holder.from_s) * 1000;
    if holder.from_s > 0 {
        sleep_until(studio.opened + ms(begin as u64 - 1000)).await;
    }
    let joined = studio.join(number, line, line, &studio.target(1)).await;
    let Joined { endpoint, seat, .. } = joined.unwrap_or_else(|error| panic!("{number} cannot join: {error}"));
    let Seat { view, status, commands, epoch, worker, hand } = seat;
    let worker = tokio::spawn(worker.run());
    let (device, told) = told_device(&scene, holder.tool);
    let mut hand = HapticLoop::new(device, hand);
    let resolution_m = f64::from(scene.specs.resolution_m);
    let mut mechanism = Mechanism::at_rest(holder.grip, (holder.meant_m)(0.0), resolution_m, scene.delay_s);
    let (mut felt, mut work_j) = (Vec::new(), 0.0);
    let ticks = usize::from(session.seconds - holder.from_s) * 1000;
    let (mut last_stamp, mut steady) = (0, None);
    for local in epoch.elapsed().as_millis() as u64 + 1.. {
        sleep_until(epoch + ms(local)).await;
        let stamp = local as i64 + status.tick_offset();
        assert!(stamp <= begin || !felt.is_empty() || last_stamp > 0, "{number} came too late");
        told.put(Some(mechanism.reported_m()));
        hand.tick(local);
        if !felt.is_empty() && stamp != last_stamp + 1 {
            steady.get_or_insert(felt.len());
        }
        if stamp > begin {
            let seconds = felt.len() as f64 * 1e-3;
            work_j += mechanism.pass(told.force_n(), (holder.meant_m)(seconds), 1e-3);
            felt.push(Felt::of(&mechanism, told.force_n(), work_j).beside(hand.hand().field().pot(), status.tool_m()));
            if holder.undoes_s.is_some_and(|undoes_s| (undoes_s * 1e3) as usize == felt.len()) {
                commands.send(Command::Undo).await.expect("a worker listens until it has left");
            }
        }
        last_stamp = stamp;
        if felt.len() == ticks {
            told.put(None);
            hand.tick(local + 1);
            break;
        }
    }
    let steady = steady.unwrap_or(felt.len());
    Person { felt, steady, last_press: Instant::now(), last_stamp, view, status, commands, worker, endpoint }
}

/// Waits until everybody holds the server's clay and every sample is confirmed.
async fn settle(studio: &Simulation, people: &[Person]) -> Option<[Duration; 2]> {
    let last_press = people.iter().map(|person| person.last_press).max()?;
    let last_due = studio.opened + ms(people.iter().map(|person| person.last_stamp).max()? as u64);
    let is_settled = || people.iter().all(|person| person.view.lock().settled);
    while last_press.elapsed() < PATIENCE {
        if is_settled() {
            let standing = studio.server.standing().await.expect("a server answers until it is stopped");
            let (digest, pot) = (standing.digests[0], standing.pots[0].digest());
            let is_same = |person: &Person| {
                let view = person.view.lock();
                view.settled && view.digest == digest && view.pot.digest() == pot
            };
            if people.iter().all(is_same) {
                return Some([last_press.elapsed(), last_due.elapsed()]);
            }
        }
        sleep(LOOK).await;
    }
    None
}
