//! A sound server on a socket of its own, in PulseAudio's protocol: takes what is played, and plays nothing.
//!
//! Invariant: who plays is asked for samples as fast as they would be played, whatever they are.

use std::collections::VecDeque;
use std::io::{BufReader, Cursor, Read};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use pulseaudio::protocol::{
    self, AuthReply, Command, CreatePlaybackStreamReply, ProtocolError, PulseError, Request, SampleFormat,
    SetClientNameReply,
};

/// How often samples are asked for.
const EVERY: Duration = Duration::from_millis(10);
/// Samples by which it is judged how loud it is: a tenth of a second at 48 kHz.
const LATELY: usize = 4800;
/// Bytes of a sample.
const SAMPLE: usize = size_of::<f32>();

/// What the server does wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    None,
    /// It hangs up on everybody.
    HangsUp,
    /// It lets nobody in.
    Denies,
}

/// What was heard.
#[derive(Debug, Default)]
struct Heard {
    samples: u64,
    lately: VecDeque<f32>,
    connections: Vec<UnixStream>,
}

/// A running server; it ends when it is dropped.
#[derive(Debug)]
pub struct PulseTwin {
    heard: Arc<Mutex<Heard>>,
    is_closing: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

fn locked(heard: &Mutex<Heard>) -> MutexGuard<'_, Heard> {
    heard.lock().unwrap_or_else(PoisonError::into_inner)
}

impl PulseTwin {
    /// Listens at a path where nothing is yet.
    ///
    /// # Panics
    /// When that is no place for a socket.
    #[must_use]
    pub fn listen(path: &Path, trouble: Trouble) -> Self {
        let listener = UnixListener::bind(path).expect("a place for a socket");
        listener.set_nonblocking(true).expect("a socket that can be asked");
        let (heard, is_closing) = (Arc::<Mutex<Heard>>::default(), Arc::<AtomicBool>::default());
        let thread = std::thread::spawn({
            let (heard, is_closing) = (Arc::clone(&heard), Arc::clone(&is_closing));
            move || accept(&listener, trouble, &heard, &is_closing)
        });
        Self { heard, is_closing, thread: Some(thread) }
    }

    /// Samples heard so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        locked(&self.heard).samples
    }

    /// The loudest sample of the last tenth of a second, once so much was heard.
    #[must_use]
    pub fn loudest(&self) -> Option<f32> {
        let heard = locked(&self.heard);
        (heard.lately.len() == LATELY).then(|| heard.lately.iter().fold(0.0, |most, sample| sample.abs().max(most)))
    }
}

impl Drop for PulseTwin {
    fn drop(&mut self) {
        self.is_closing.store(true, Ordering::Relaxed);
        for connection in &locked(&self.heard).connections {
            // who has hung up already is gone as well
            drop(connection.shutdown(Shutdown::Both));
        }
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

fn accept(listener: &UnixListener, trouble: Trouble, heard: &Arc<Mutex<Heard>>, is_closing: &Arc<AtomicBool>) {
    let mut threads = Vec::new();
    while !is_closing.load(Ordering::Relaxed) {
        let Ok((stream, _)) = listener.accept() else {
            std::thread::sleep(Duration::from_millis(2));
            continue;
        };
        if trouble == Trouble::HangsUp {
            continue;
        }
        let (heard, is_closing) = (Arc::clone(heard), Arc::clone(is_closing));
        threads.push(std::thread::spawn(move || {
            let ended = talk(&stream, trouble, &heard, &is_closing);
            drop((ended, stream.shutdown(Shutdown::Both)));
        }));
    }
    for thread in threads {
        drop(thread.join());
    }
}

/// A conversation, until either side ends it.
fn talk(
    stream: &UnixStream,
    trouble: Trouble,
    heard: &Arc<Mutex<Heard>>,
    is_closing: &Arc<AtomicBool>,
) -> Result<(), ProtocolError> {
    stream.set_nonblocking(false)?;
    locked(heard).connections.push(stream.try_clone()?);
    let mut reader = BufReader::new(stream.try_clone()?);
    let writer = Arc::new(Mutex::new(stream.try_clone()?));
    let mut version = protocol::MAX_VERSION;
    loop {
        let head = protocol::read_descriptor(&mut reader)?;
        let mut body = vec![0; head.length as usize];
        reader.read_exact(&mut body)?;
        if head.channel != u32::MAX {
            take(heard, &body);
            continue;
        }
        let (sequence, command) = Command::read_tag_prefixed(&mut Cursor::new(&body), version)?;
        let mut to = writer.lock().unwrap_or_else(PoisonError::into_inner);
        match command {
            Command::Auth(_) if trouble == Trouble::Denies => {
                protocol::write_error(&mut *to, sequence, &PulseError::AccessDenied)?;
            }
            Command::Auth(asked) => {
                let reply = AuthReply { version: asked.version.min(version), use_memfd: false, use_shm: false };
                protocol::write_reply_message(&mut *to, sequence, &reply, version)?;
                version = reply.version;
            }
            Command::SetClientName(_) => {
                protocol::write_reply_message(&mut *to, sequence, &SetClientNameReply { client_id: 1 }, version)?;
            }
            Command::CreatePlaybackStream(asked) => {
                assert_eq!((asked.sample_spec.format, asked.sample_spec.channels), (SampleFormat::Float32Le, 1));
                let reply = CreatePlaybackStreamReply {
                    requested_bytes: asked.buffer_attr.target_length,
                    buffer_attr: asked.buffer_attr,
                    sample_spec: asked.sample_spec,
                    channel_map: asked.channel_map,
                    sink_name: asked.sink_name,
                    ..CreatePlaybackStreamReply::default()
                };
                protocol::write_reply_message(&mut *to, sequence, &reply, version)?;
                let length = asked.sample_spec.sample_rate / 100 * SAMPLE as u32;
                let (writer, is_closing) = (Arc::clone(&writer), Arc::clone(is_closing));
                // ends with the connection
                std::thread::spawn(move || ask(&writer, length, version, &is_closing));
            }
            _ => protocol::write_ack_message(&mut *to, sequence)?,
        }
    }
}

fn take(heard: &Mutex<Heard>, body: &[u8]) {
    let mut heard = locked(heard);
    for bytes in body.chunks_exact(SAMPLE) {
        let mut sample = [0; SAMPLE];
        sample.copy_from_slice(bytes);
        heard.lately.push_back(f32::from_le_bytes(sample));
        heard.samples += 1;
        if heard.lately.len() > LATELY {
            heard.lately.pop_front();
        }
    }
}

/// Asks for samples until nobody is there.
fn ask(writer: &Mutex<UnixStream>, length: u32, version: u16, is_closing: &AtomicBool) {
    while !is_closing.load(Ordering::Relaxed) {
        std::thread::sleep(EVERY);
        let mut to = writer.lock().unwrap_or_else(PoisonError::into_inner);
        let request = Command::Request(Request { channel: 0, length });
        if protocol::write_command_message(&mut *to, u32::MAX, &request, version).is_err() {
            return;
        }
    }
}
