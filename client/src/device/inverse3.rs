//! Haply's Inverse3, through the WebSocket service that its maker installs.
//!
//! Owns the conversation: the service sends its inventory, then exactly one reply for each message; it adds up the forces
//! of all its clients and lets a device go idle when nobody talks, so that zero is sent as well. It turns axes as each client likes:
//! this one asks for the device's own and looks whether it got them. Verified against a service in the tests that keeps these rules and
//! one that does not; not yet tried on hardware.
//! Invariant: never two messages without a reply between them, and a last one that takes the force away.

mod message;

use std::io::ErrorKind;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_shared::units::Seconds;
use tungstenite::{Message, WebSocket};

use super::choice::with_others;
use super::{DeviceFault, Driver, Pace, Port, ROUND, Reading, Reported, SILENCE};
use message::{Frame, Inverse3, first_message, force_message};

const DEVICE: &str = "Haply Inverse3";
/// Where the service listens, from its version 3.5 on.
pub const ADDRESS: &str = "localhost:10001";
/// Middle of the workspace in the device's frame (x right, y away, z up, from its base), m: where its cursor is with the
/// arm half stretched. Not from a public source: the calibration key sets it anew.
pub const MIDDLE_M: Vec3 = Vec3::new(0.0, -0.14, 0.15);
/// How long connecting and the inventory may take.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Which service and which device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inverse3Settings {
    /// Host and port of the service.
    pub address: String,
    /// The device's name there, if there are several.
    pub device_id: Option<String>,
}

impl Default for Inverse3Settings {
    fn default() -> Self {
        Self { address: ADDRESS.into(), device_id: None }
    }
}

/// The driver.
#[derive(Clone, Debug, Default)]
pub struct Inverse3Driver {
    settings: Inverse3Settings,
}

impl Inverse3Driver {
    /// A driver for a device of the service.
    #[must_use]
    pub const fn new(settings: Inverse3Settings) -> Self {
        Self { settings }
    }

    /// Asks the service which devices it has, and says which one would be used.
    ///
    /// # Errors
    /// [`DeviceFault`] when there is no service or no device.
    pub fn probe(&self) -> Result<String, DeviceFault> {
        let mut talk = Talk::connect(&self.settings.address)?;
        let frame = talk.receive(PATIENCE)?;
        Ok(self.choose(&frame)?.1)
    }

    /// The device to use, and what to say about it.
    fn choose(&self, frame: &Frame) -> Result<(String, String), DeviceFault> {
        let names: Vec<&str> = frame.inverse3.iter().map(|device| device.device_id.as_str()).collect();
        let missing =
            |reason: String, remedy: &str| DeviceFault::NotFound { device: DEVICE, reason, remedy: remedy.into() };
        let chosen = match &self.settings.device_id {
            Some(wanted) => names.iter().find(|name| *name == wanted).ok_or_else(|| {
                missing(format!("the service has {names:?} and no {wanted}"), "choose one of these with id=NAME")
            })?,
            None => names.first().ok_or_else(|| {
                let reason = format!("the service at {} has none", self.settings.address);
                missing(reason, "plug in its cable and its power")
            })?,
        };
        let others: Vec<_> =
            names.iter().filter(|name| *name != chosen).map(|name| format!("inverse3:id={name}")).collect();
        Ok(((*chosen).to_owned(), with_others(format!("{DEVICE} {chosen}"), &others)))
    }
}

impl Driver for Inverse3Driver {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let mut talk = Talk::connect(&self.settings.address)?;
        let inventory = talk.receive(PATIENCE)?;
        let (device_id, about) = self.choose(&inventory)?;
        set_up(&mut talk, &device_id, inventory)?;
        port.found(about, Reported::default());
        let served = serve(&mut talk, &device_id, port);
        talk.part(&device_id);
        served
    }

    /// A message to the service and its reply take a quarter of a millisecond each: assumed, since there was no service to measure.
    fn delay(&self) -> Seconds {
        Seconds(ROUND.0 + 0.5e-3)
    }
}

/// Says who is talking and has the service tell places as the device has them.
fn set_up(talk: &mut Talk, device_id: &str, inventory: Frame) -> Result<(), DeviceFault> {
    talk.send(first_message(device_id))?;
    let reply = talk.receive(PATIENCE)?;
    let config = |frame: Frame| frame.inverse3.into_iter().find(|device| device.device_id == device_id)?.config;
    // a service that does not say what became of it has left it as it was
    let config = config(reply).or_else(|| config(inventory)).unwrap_or_default();
    let unusable =
        |reason: String, remedy: &str| Err(DeviceFault::Unusable { device: DEVICE, reason, remedy: remedy.into() });
    if !config.basis.is_own() {
        let reason = format!("its service tells its axes as {} and not as XYZ", config.basis.permutation);
        return unusable(reason, "set its basis to XYZ in Haply's program");
    }
    if !config.mount.is_none() {
        let reason = "its service has it mounted elsewhere, turned or scaled".to_owned();
        return unusable(reason, "choose its preset `defaults` in Haply's program");
    }
    Ok(())
}

fn serve(talk: &mut Talk, device_id: &str, port: &mut Port) -> Result<(), DeviceFault> {
    let mut pace = Pace::new();
    let mut unfit: Option<&'static str> = None;
    while !port.is_closing() {
        // a device that is not fit gets no force, and is asked on
        let force_n = if unfit.is_some() { Vec3::ZERO } else { port.force_n() };
        talk.send(force_message(device_id, force_n))?;
        let frame = talk.receive(SILENCE)?;
        talk.expect_nothing_more()?;
        let buttons = frame.buttons();
        let device = frame.inverse3.into_iter().find(|device| device.device_id == device_id).ok_or_else(|| {
            DeviceFault::Gone { device: DEVICE, reason: format!("the service no longer has {device_id}") }
        })?;
        let complaint = complaint(&device);
        if complaint == unfit && complaint.is_none() {
            port.publish(reading(&device, buttons)?);
        } else if complaint.is_some() {
            port.withdraw();
        }
        if complaint != unfit {
            port.notify(complaint.map(str::to_owned));
            unfit = complaint;
        }
        pace.wait();
    }
    Ok(())
}

/// What a person has to do before the device can be used.
fn complaint(device: &Inverse3) -> Option<&'static str> {
    if !device.status.power_supply {
        Some("the Haply Inverse3 has no power: plug in its supply; its force is off until then")
    } else if !device.status.calibrated {
        Some(
            "the Haply Inverse3 is not calibrated: put its arm in its holder as its manual says; its force is off until then",
        )
    } else if !device.status.ready {
        Some("the Haply Inverse3 is not ready: look at its light and its manual; its force is off until it is")
    } else if !device.state.transform.is_none() {
        Some(
            "the Haply Inverse3's service moves, turns or scales its workspace: take that transform back; its force is off until then",
        )
    } else {
        None
    }
}

fn reading(device: &Inverse3, buttons: u32) -> Result<Reading, DeviceFault> {
    let place = device.state.cursor_position.ok_or_else(|| DeviceFault::Protocol {
        device: DEVICE,
        expected: "a cursor_position",
        found: "a state without one".into(),
    })?;
    let velocity_m_s = device.state.cursor_velocity.map(message::Vector::to_vec3);
    Ok(Reading { position_m: place.to_vec3(), velocity_m_s, buttons })
}

/// A connection to the service.
#[derive(Debug)]
struct Talk {
    socket: WebSocket<TcpStream>,
}

fn lost(error: &tungstenite::Error) -> DeviceFault {
    DeviceFault::Gone { device: DEVICE, reason: format!("its service: {error}") }
}

impl Talk {
    fn connect(address: &str) -> Result<Self, DeviceFault> {
        let missing = |reason: String| DeviceFault::NotFound {
            device: DEVICE,
            reason: format!("no service answers at {address} ({reason})"),
            remedy: "install and start the Haply Inverse Service, 3.5 or later".into(),
        };
        let addresses = address.to_socket_addrs().map_err(|error| missing(error.to_string()))?;
        let mut failure = "no address".to_owned();
        for candidate in addresses {
            match Self::open(address, candidate) {
                Ok(talk) => return Ok(talk),
                Err(reason) => failure = reason,
            }
        }
        Err(missing(failure))
    }

    fn open(address: &str, candidate: std::net::SocketAddr) -> Result<Self, String> {
        let stream = TcpStream::connect_timeout(&candidate, PATIENCE).map_err(|error| error.to_string())?;
        let set = stream.set_nodelay(true).and_then(|()| stream.set_write_timeout(Some(SILENCE)));
        set.and_then(|()| stream.set_read_timeout(Some(PATIENCE))).map_err(|error| error.to_string())?;
        let (socket, _) = tungstenite::client(format!("ws://{address}/"), stream).map_err(|error| error.to_string())?;
        Ok(Self { socket })
    }

    fn send(&mut self, message: Result<String, String>) -> Result<(), DeviceFault> {
        let message = message.map_err(|error| DeviceFault::Protocol {
            device: DEVICE,
            expected: "a finite force",
            found: error,
        })?;
        self.socket.send(Message::text(message)).map_err(|error| lost(&error))
    }

    /// The next reply.
    fn receive(&mut self, patience: Duration) -> Result<Frame, DeviceFault> {
        let begin = Instant::now();
        loop {
            let left = patience.saturating_sub(begin.elapsed());
            let silent = DeviceFault::Silent { device: DEVICE, ms: patience.as_millis() as u64 };
            if left.is_zero() || self.socket.get_ref().set_read_timeout(Some(left)).is_err() {
                return Err(silent);
            }
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    return Frame::parse(text.as_str()).map_err(|found| DeviceFault::Protocol {
                        device: DEVICE,
                        expected: "a state in JSON",
                        found,
                    });
                }
                Ok(Message::Ping(_) | Message::Pong(_)) => {}
                Ok(other) => {
                    return Err(DeviceFault::Protocol {
                        device: DEVICE,
                        expected: "text",
                        found: format!("a message of {} bytes that is none", other.len()),
                    });
                }
                Err(tungstenite::Error::Io(error))
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) =>
                {
                    return Err(silent);
                }
                Err(error) => return Err(lost(&error)),
            }
        }
    }

    /// Looks whether the service keeps to one reply; a second one would be taken for the next, and every force be late.
    fn expect_nothing_more(&mut self) -> Result<(), DeviceFault> {
        let blocking = |socket: &WebSocket<TcpStream>, blocks: bool| {
            let set = socket.get_ref().set_nonblocking(!blocks);
            set.map_err(|error| lost(&tungstenite::Error::Io(error)))
        };
        blocking(&self.socket, false)?;
        let more = self.socket.read();
        blocking(&self.socket, true)?;
        match more {
            Ok(Message::Ping(_) | Message::Pong(_)) => Ok(()),
            Ok(_) => Err(DeviceFault::Protocol {
                device: DEVICE,
                expected: "one reply for each message",
                found: "a second one".into(),
            }),
            Err(tungstenite::Error::Io(error)) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            Err(error) => Err(lost(&error)),
        }
    }

    /// Takes the force away and leaves; a service that is gone has done both.
    fn part(&mut self, device_id: &str) {
        // the reply says that the service has taken it
        let said = self.send(force_message(device_id, Vec3::ZERO)).and_then(|()| self.receive(SILENCE)).is_ok();
        if let Err(error) = self.socket.close(None).and_then(|()| self.socket.flush()) {
            tracing::debug!(%error, said, "the service did not hear the end");
        }
    }
}
