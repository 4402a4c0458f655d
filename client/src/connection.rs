//! Joining a studio: address, handshake, greeting, welcome.
//!
//! Owns everything up to the welcome, and the sentences for what can go wrong; afterwards the worker takes over.
//! Invariant: a join that fails leaves nothing running.

use std::net::SocketAddr;
use std::time::Duration;

use pottery_shared::protocol::{self, FrameReader, JoinCode, Notice, Pass, ResumeToken, TeacherToken};
use pottery_shared::session::ClientError;
use tokio::time::timeout;
use web_transport_quinn::{Session, SessionError, WebTransportError};

use crate::streams::Streams;
use crate::transport;

/// A handshake that takes longer than this is not going to end.
const PATIENCE: Duration = Duration::from_secs(5);
/// A studio that is there and has not said whom it lets in by then is not going to: on a long line that loses much the question, and what the
/// transport says of it, may be lost three times.
const ANSWERS_WITHIN: Duration = Duration::from_secs(20);
/// Other places to which a name leads that are tried as well.
const OTHERS_MAX: usize = 3;
/// A teacher who has let nobody in by then is not going to.
const WAITS_FOR: Duration = Duration::from_secs(1800);

/// What to join.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    /// Host and port as typed; the port may be left out.
    pub address: String,
    /// The join code.
    pub code: JoinCode,
    /// Number of the wheel, from 1.
    pub wheel: u16,
    /// With what one teaches there.
    pub teacher: Option<TeacherToken>,
    /// SHA-256 of the certificate that the server showed the last time, for a code that says nothing of it.
    pub known: Option<[u8; 32]>,
}

/// Why a studio could not be joined.
#[derive(Debug, thiserror::Error)]
pub enum JoinError {
    /// No such host.
    #[error("'{address}' is no address that can be found ({reason}); write it like 192.168.1.20:4747 or [::1]:4747")]
    Address {
        /// As typed.
        address: String,
        /// Which part of it.
        reason: &'static str,
    },
    /// Nobody answers there.
    #[error("no studio answers at {address}; is it open, is the port right, and does the network let UDP through?")]
    Unreachable {
        /// Where.
        address: SocketAddr,
    },
    /// It is there, and what is said to it or what it says does not get through.
    #[error(
        "the studio at {address} is there, but too much gets lost on the way to it; try again, or over a better network"
    )]
    Lossy {
        /// Where.
        address: SocketAddr,
    },
    /// Somebody else answers there.
    #[error("the server at {address} is not the one this code belongs to; ask the host for the code again")]
    WrongServer {
        /// Where.
        address: SocketAddr,
    },
    /// Another key than the last time.
    #[error(
        "the studio at {address} shows another key than the last time: somebody may be pretending to be it. Ask its host; if they \
         have begun anew on purpose, join once with --trust-new-key"
    )]
    NewKey {
        /// Where.
        address: SocketAddr,
    },
    /// Something answers that is no studio of this version.
    #[error("what answers at {address} is not a pottery studio of this version ({reason})")]
    NotAStudio {
        /// Where.
        address: SocketAddr,
        /// What it did.
        reason: String,
    },
    /// It ended while a teacher was asked.
    #[error(
        "the studio at {address} has closed, or the line to it broke, before you were let in; ask its host, and join again"
    )]
    ClosedBefore {
        /// Where.
        address: SocketAddr,
    },
    /// The studio does not let this client in, or does not make sense.
    #[error(transparent)]
    Session(#[from] ClientError),
    /// The system's network cannot be used.
    #[error("the network cannot be used: {reason}")]
    Network {
        /// What the system said.
        reason: String,
    },
}

impl JoinError {
    /// Whether it is what a studio answers: whoever asks again is told the same, until somebody there changes it.
    #[must_use]
    pub const fn is_answer(&self) -> bool {
        matches!(self, Self::Session(ClientError::Refused(_)) | Self::NewKey { .. } | Self::WrongServer { .. })
    }
}

/// A connection whose greeting was understood, for whoever runs a session of their own on it.
#[derive(Debug)]
pub struct Joined {
    /// The connection, for datagrams.
    pub connection: Session,
    /// Its streams.
    pub streams: Streams,
    /// SHA-256 of the certificate that the server showed.
    pub fingerprint: Option<[u8; 32]>,
}

/// The port studios listen on when none is typed.
const PORT: u16 = 4747;

impl Target {
    /// A studio that nobody knows yet, and where one does not teach.
    #[must_use]
    pub const fn new(address: String, code: JoinCode, wheel: u16) -> Self {
        Self { address, code, wheel, teacher: None, known: None }
    }

    /// What is shown beside the code.
    #[must_use]
    pub fn pass(&self) -> Pass {
        self.teacher.map_or(Pass::None, Pass::Teacher)
    }

    /// What is shown by who comes back: that they teach as well, since a server that has begun anew does not know them.
    pub(crate) fn pass_back(&self, resume: ResumeToken) -> Pass {
        self.teacher.map_or(Pass::Resume(resume), |teacher| Pass::Return(resume, teacher))
    }

    /// Where that is.
    ///
    /// # Errors
    /// [`JoinError::Address`] when no such host is found.
    pub async fn resolved(&self) -> Result<SocketAddr, JoinError> {
        Ok(resolve(&self.address).await?.0)
    }
}

/// Where an address leads, and where else.
async fn resolve(typed: &str) -> Result<(SocketAddr, Vec<SocketAddr>), JoinError> {
    let address = typed.trim();
    let bad = |reason| JoinError::Address { address: address.to_owned(), reason };
    if let Ok(known) = address.parse::<SocketAddr>() {
        return Ok((known, Vec::new()));
    }
    let bare = address.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(address);
    if let Ok(ip) = bare.parse::<std::net::IpAddr>() {
        return Ok((SocketAddr::new(ip, PORT), Vec::new()));
    }
    let (name, port) = match address.rsplit_once(':') {
        None => (address, PORT),
        Some((name, port)) => (name, port.parse().map_err(|_| bad("a port is a number up to 65535"))?),
    };
    let found = tokio::net::lookup_host((name, port)).await;
    let mut found = found.map_err(|_| bad("no computer of that name answers to the name service"))?;
    let first = found.next().ok_or_else(|| bad("the name leads nowhere"))?;
    let others = found.filter(|other| *other != first).take(OTHERS_MAX).collect();
    Ok((first, others))
}

/// Says in the log that a teacher is asked, for who has nothing else to say it with.
pub(crate) fn log_waiting() {
    tracing::warn!("waiting for the teacher to let you in");
}

/// Connects, greets and waits for the answer, of which `open` makes a session; it is told the round trip.
///
/// # Errors
/// [`JoinError`] with a sentence for the person.
pub async fn join<S>(
    endpoint: &quinn::Endpoint,
    target: &Target,
    greeting: &[u8],
    open: impl FnOnce(&[u8], Duration) -> Result<S, ClientError>,
) -> Result<(Joined, S), JoinError> {
    join_asking(endpoint, target, None, greeting, open, log_waiting).await
}

/// The same, over a line whose round trip may have been measured before; `waits` is told that a teacher is asked.
pub(crate) async fn join_asking<S>(
    endpoint: &quinn::Endpoint,
    target: &Target,
    round_trip: Option<Duration>,
    greeting: &[u8],
    open: impl FnOnce(&[u8], Duration) -> Result<S, ClientError>,
    waits: impl Fn(),
) -> Result<(Joined, S), JoinError> {
    let (first, others) = resolve(&target.address).await?;
    let config = transport::config_for(&target.code, target.known, round_trip)?;
    let mut reached = reach(endpoint, target, config.clone(), first).await.map(|connection| (first, connection));
    for address in others {
        // of the ways to a host, some may lead nowhere; what is said is why the first did
        if !matches!(reached, Err(JoinError::Unreachable { .. } | JoinError::Network { .. })) {
            break;
        }
        match reach(endpoint, target, config.clone(), address).await {
            Err(JoinError::Unreachable { .. } | JoinError::Network { .. }) => {}
            other => reached = other.map(|connection| (address, connection)),
        }
    }
    let (address, connection) = reached?;
    let unreachable = JoinError::Unreachable { address };
    let round_trip = connection.rtt();
    let fingerprint = transport::fingerprint_of(&connection);
    let session = Session::raw(connection);
    let greeted = greet(session.clone(), fingerprint, greeting, |answer| open(answer, round_trip), waits);
    match timeout(WAITS_FOR, greeted).await {
        Ok(Ok(joined)) => Ok(joined),
        Ok(Err(error)) => {
            let is_unheard = matches!(
                session.close_reason(),
                Some(SessionError::WebTransportError(WebTransportError::Closed(protocol::CLOSED_UNHEARD, _)))
            );
            session.close(0, b"");
            Err(match error {
                GreetError::Session(error) => error.into(),
                GreetError::Stream(_) if is_unheard => JoinError::Lossy { address },
                GreetError::Stream(reason) => JoinError::NotAStudio { address, reason },
                GreetError::Silent => JoinError::Lossy { address },
                GreetError::Ended => JoinError::ClosedBefore { address },
            })
        }
        Err(_) => Err(unreachable),
    }
}

/// Connects to one of the places to which a name leads.
async fn reach(
    endpoint: &quinn::Endpoint,
    target: &Target,
    config: quinn::ClientConfig,
    address: SocketAddr,
) -> Result<quinn::Connection, JoinError> {
    let connecting = endpoint
        .connect_with(config, reachable_from(endpoint, address), transport::SERVER_NAME)
        .map_err(|error| JoinError::Network { reason: error.to_string() })?;
    match timeout(PATIENCE, connecting).await {
        Ok(Ok(connection)) => Ok(connection),
        Ok(Err(error)) => Err(match explain(error, address) {
            JoinError::WrongServer { address } if target.code.print().is_none() => JoinError::NewKey { address },
            error => error,
        }),
        Err(_) => Err(JoinError::Unreachable { address }),
    }
}

enum GreetError {
    Session(ClientError),
    Stream(String),
    /// It said nothing for long.
    Silent,
    /// It ended while a teacher was asked.
    Ended,
}

async fn greet<S>(
    connection: Session,
    fingerprint: Option<[u8; 32]>,
    greeting: &[u8],
    open: impl FnOnce(&[u8]) -> Result<S, ClientError>,
    waits: impl Fn(),
) -> Result<(Joined, S), GreetError> {
    let broken = |error: &dyn std::fmt::Display| GreetError::Stream(error.to_string());
    let (mut control_out, mut control_in) = connection.open_bi().await.map_err(|error| broken(&error))?;
    control_out.write_all(greeting).await.map_err(|error| broken(&error))?;
    let mut frames = FrameReader::default();
    let mut piece = [0; 4096];
    let mut is_waiting = false;
    loop {
        while let Some(frame) = frames.next_frame().map_err(|error| broken(&error))? {
            match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(&frame) {
                Ok(Notice::Waiting) => {
                    is_waiting = true;
                    waits();
                    continue;
                }
                Ok(Notice::Closing) if is_waiting => return Err(GreetError::Ended),
                _ => {}
            }
            let session = open(&frame).map_err(GreetError::Session)?;
            let streams = Streams::new(&connection, control_out, control_in, frames);
            return Ok((Joined { connection, streams, fingerprint }, session));
        }
        let patience = if is_waiting { WAITS_FOR } else { ANSWERS_WITHIN };
        match timeout(patience, control_in.read(&mut piece)).await {
            Ok(Ok(Some(length))) => frames.push(&piece[..length]),
            Ok(Ok(None) | Err(_)) if is_waiting => return Err(GreetError::Ended),
            Ok(Ok(None)) => return Err(GreetError::Stream("it said nothing".into())),
            Ok(Err(error)) => return Err(broken(&error)),
            Err(_) => return Err(GreetError::Silent),
        }
    }
}

/// An IPv4 address as an IPv6 socket must write it.
fn reachable_from(endpoint: &quinn::Endpoint, address: SocketAddr) -> SocketAddr {
    match (endpoint.local_addr(), address) {
        (Ok(local), SocketAddr::V4(v4)) if local.is_ipv6() => {
            SocketAddr::new(v4.ip().to_ipv6_mapped().into(), v4.port())
        }
        _ => address,
    }
}

fn explain(error: quinn::ConnectionError, address: SocketAddr) -> JoinError {
    match error {
        quinn::ConnectionError::TimedOut => JoinError::Unreachable { address },
        // a TLS alert travels as 0x100 + its number; ours for a certificate that is refused, theirs for the protocol
        quinn::ConnectionError::TransportError(error) => {
            let code = u64::from(error.code);
            if (0x100..0x200).contains(&code) && code != 0x178 {
                JoinError::WrongServer { address }
            } else {
                JoinError::NotAStudio { address, reason: error.to_string() }
            }
        }
        other => JoinError::NotAStudio { address, reason: other.to_string() },
    }
}
