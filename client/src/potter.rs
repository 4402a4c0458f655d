//! A person at a wheel: connection, hand and view in one.
//!
//! Owns the threads; everything they do is in `worker` and `haptic_loop`.
//! Invariant: a hand's thread ends with its connection, and after `leave` both have ended.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pottery_shared::protocol::Purpose;
use pottery_shared::session::Client;
use pottery_shared::units::Tick;
use tokio::sync::mpsc;

use crate::boundary::{HandSide, Status, boundary};
use crate::claim::{Claim, Granted};
use crate::connection::{self, JoinError, Target};
use crate::device::Device;
use crate::pacing::whole_ticks;
use crate::view::{SharedView, View};
use crate::way_back::{WayBack, greet};
use crate::worker::Worker;
use crate::{Command, HapticLoop, HapticReport, NetworkReport};

/// How a person works.
#[derive(Clone, Copy, Debug, Default)]
pub struct PotterOptions {
    /// Whether to record the own stroke.
    pub record: bool,
    /// What the hand's thread asks of the system.
    pub claim: Claim,
    /// Whether the tool stays lifted until the wheel's clay is there, as for who has seen it already: a hand would press an untouched pot.
    pub waits: bool,
    /// Whether the hand begins without force, as for somebody who has switched it off before.
    pub is_force_off: bool,
}

/// What a potter's stay gave.
#[derive(Clone, Debug)]
pub struct PotterReport {
    /// From the 1 kHz thread; `None` when it could not end well.
    pub haptic: Option<HapticReport>,
    /// What the system granted that thread.
    pub granted: Granted,
    /// From the worker.
    pub network: NetworkReport,
    /// What was to be seen at the end.
    pub view: View,
}

/// A place at a wheel, before a task and a hand are set to it.
///
/// [`Potter::join`] does both; whoever has a clock of their own runs the worker and ticks a [`HapticLoop`] themselves.
#[derive(Debug)]
pub struct Seat {
    /// What there is to see.
    pub view: SharedView,
    /// What both sides may read.
    pub status: Arc<Status>,
    /// To ask the worker for something; it leaves once all senders are gone.
    pub commands: mpsc::Sender<Command>,
    /// Local tick n is due n milliseconds after it.
    pub epoch: tokio::time::Instant,
    /// To be run as a task.
    pub worker: Worker,
    /// For the hand.
    pub hand: HandSide,
}

impl Seat {
    /// Joins a wheel.
    ///
    /// # Errors
    /// [`JoinError`] with a sentence for the person.
    pub async fn take(endpoint: &quinn::Endpoint, target: &Target, options: PotterOptions) -> Result<Self, JoinError> {
        Self::take_asking(endpoint, target, options, connection::log_waiting).await
    }

    async fn take_asking(
        endpoint: &quinn::Endpoint,
        target: &Target,
        options: PotterOptions,
        waits: impl Fn(),
    ) -> Result<Self, JoinError> {
        let epoch = tokio::time::Instant::now();
        let purpose = Purpose::Works { retells: true };
        let greeting = greet(target, purpose, target.pass());
        let open = |answer: &[u8], round_trip| Client::open(answer, epoch.elapsed().as_millis() as u64, round_trip);
        let (joined, session) = connection::join_asking(endpoint, target, None, &greeting, open, waits).await?;
        let view = SharedView::new(&session);
        let (hand, net_side) = boundary(&session.patch());
        let status = Arc::clone(&hand.status);
        status.switch_force_off(options.is_force_off);
        let (commands, received) = mpsc::channel(64);
        view.lock().fingerprint = joined.fingerprint;
        let way_back = WayBack::new(endpoint.clone(), target, purpose, joined.fingerprint);
        let worker = Worker::new((joined, session, epoch), net_side, view.clone(), received, way_back, options);
        Ok(Self { view, status, commands, epoch, worker, hand })
    }
}

/// A person at a wheel.
#[derive(Debug)]
pub struct Potter {
    view: SharedView,
    status: Arc<Status>,
    commands: mpsc::Sender<Command>,
    epoch: Instant,
    hand: Option<JoinHandle<HapticReport>>,
    granted: Granted,
    worker: tokio::task::JoinHandle<NetworkReport>,
}

impl Potter {
    /// Joins a wheel and takes the device in hand. Call it within a tokio runtime, which will carry the connection.
    ///
    /// # Errors
    /// [`JoinError`] with a sentence for the person.
    pub async fn join(
        endpoint: &quinn::Endpoint,
        target: &Target,
        device: Box<dyn Device>,
        options: PotterOptions,
    ) -> Result<Self, JoinError> {
        Self::join_asking(endpoint, target, device, options, connection::log_waiting).await
    }

    /// The same, for whom `waits` is told that a teacher is asked to let them in.
    ///
    /// # Errors
    /// [`JoinError`] with a sentence for the person.
    pub async fn join_asking(
        endpoint: &quinn::Endpoint,
        target: &Target,
        device: Box<dyn Device>,
        options: PotterOptions,
        waits: impl Fn(),
    ) -> Result<Self, JoinError> {
        let Seat { view, status, commands, epoch, worker, hand } =
            Seat::take_asking(endpoint, target, options, waits).await?;
        let epoch = epoch.into_std();
        let no_thread =
            |reason: &dyn std::fmt::Display| JoinError::Network { reason: format!("no thread for the hand: {reason}") };
        let (told, granted) = tokio::sync::oneshot::channel();
        let hand = std::thread::Builder::new()
            .name("haptic".into())
            .spawn(move || {
                // whoever does not wait for the answer any more has no potter either
                drop(told.send(options.claim.stake()));
                HapticLoop::new(device, hand).at(options.claim.rate).run(epoch)
            })
            .map_err(|error| no_thread(&error))?;
        let granted = granted.await.map_err(|error| no_thread(&error))?;
        let worker = tokio::spawn(worker.run());
        Ok(Self { view, status, commands, epoch, hand: Some(hand), granted, worker })
    }

    /// What there is to see.
    #[must_use]
    pub const fn view(&self) -> &SharedView {
        &self.view
    }

    /// What the hand feels, and the switch that lifts its tool.
    #[must_use]
    pub const fn status(&self) -> &Arc<Status> {
        &self.status
    }

    /// What the system granted the hand's thread.
    #[must_use]
    pub const fn granted(&self) -> &Granted {
        &self.granted
    }

    /// The tick that the hand stamps now.
    #[must_use]
    pub fn tick(&self) -> Tick {
        let local = whole_ticks(self.epoch.elapsed());
        Tick(0).offset(local as i64 + self.status.tick_offset())
    }

    /// Asks for something; false when the worker has ended or is too busy to hear.
    pub fn command(&self, command: Command) -> bool {
        self.commands.try_send(command).is_ok()
    }

    /// Lifts the tool and waits until everything pressed is confirmed, for at most `patience`; true when it is.
    pub async fn settle(&self, patience: Duration) -> bool {
        self.status.lift(true);
        let deadline = tokio::time::Instant::now() + patience;
        // samples on their way out of the hand are not yet known to the session
        tokio::time::sleep(Duration::from_millis(50)).await;
        while !self.view.lock().settled {
            if tokio::time::Instant::now() > deadline {
                return false;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        true
    }

    /// Leaves the wheel once everything pressed is confirmed.
    ///
    /// # Errors
    /// [`JoinError::Network`] when the worker did not end well.
    pub async fn leave(mut self) -> Result<PotterReport, JoinError> {
        self.status.lift(true);
        tokio::time::sleep(Duration::from_millis(20)).await;
        if self.commands.send(Command::Leave).await.is_err() {
            tracing::debug!("the worker had ended already");
        }
        let network = self.worker.await.map_err(|error| JoinError::Network { reason: error.to_string() })?;
        let hand = self.hand.take();
        let haptic = tokio::task::spawn_blocking(move || hand.and_then(|hand| hand.join().ok())).await.ok().flatten();
        let view = self.view.lock().clone();
        Ok(PotterReport { haptic, granted: self.granted, network, view })
    }
}
