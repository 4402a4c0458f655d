//! A service like Haply's on a port of its own: an inventory, then one reply for each message, unless told otherwise.
//!
//! Invariant: a device's force is what the last message said, and zero once its client has gone.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use glam::Vec3;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// What the service does wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    #[default]
    None,
    /// It takes messages and sends no replies.
    Silent,
    /// Its replies come late, by so many milliseconds.
    Late(u64),
    /// One reply does.
    LateOnce(u64),
    /// It sends two replies for each message.
    Twice,
    /// Its replies are no JSON.
    Garbage,
    /// Its replies name the device and say nothing of it.
    Stateless,
    /// It reports a place that is no number.
    NotANumber,
    /// Its device has lost its power.
    Powerless,
}

/// The service and its devices.
#[derive(Debug)]
pub struct State {
    /// What it does wrong.
    pub trouble: Trouble,
    /// Its devices; the first is the one that can be moved.
    pub devices: Vec<String>,
    /// Where the cursor is, m in the device's frame.
    pub cursor_m: Vec3,
    /// How fast, m/s.
    pub velocity_m_s: Vec3,
    /// Which axes it tells, as Haply's letters have it.
    pub basis: String,
    /// Where and how the device stands.
    pub mount: Value,
    /// What somebody does to its workspace.
    pub transform: Value,
    /// Whether it takes no other basis and no preset.
    pub is_stubborn: bool,
    /// Whether the grip's second button is down.
    pub button_b: bool,
    /// What was sent last, N.
    pub force_n: Vec3,
    /// To which device.
    pub addressed: String,
    /// Messages so far, on the connection there is.
    pub messages: u64,
    /// The first message on it.
    pub first: Value,
    connections: u32,
}

/// A running service; it ends when it is dropped.
#[derive(Debug)]
pub struct HaplyTwin {
    address: SocketAddr,
    state: Arc<Mutex<State>>,
    is_closing: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl HaplyTwin {
    /// Starts the service with one device at `cursor_m`.
    ///
    /// # Panics
    /// When this machine has no port to give.
    #[must_use]
    pub fn start(cursor_m: Vec3) -> Self {
        Self::listen(SocketAddr::from(([127, 0, 0, 1], 0)), cursor_m)
    }

    /// Starts it where another was, as a service that is started anew.
    ///
    /// # Panics
    /// When the port is taken.
    #[must_use]
    pub fn listen(address: SocketAddr, cursor_m: Vec3) -> Self {
        let listener = TcpListener::bind(address).expect("a port on loopback");
        listener.set_nonblocking(true).expect("a port that can be asked");
        let address = listener.local_addr().expect("the address of a bound port");
        let state = State {
            trouble: Trouble::None,
            devices: vec!["04BA".into()],
            cursor_m,
            velocity_m_s: Vec3::ZERO,
            basis: "XYZ".into(),
            mount: json!({}),
            transform: json!({}),
            is_stubborn: false,
            button_b: false,
            force_n: Vec3::ZERO,
            addressed: String::new(),
            messages: 0,
            first: Value::Null,
            connections: 0,
        };
        let state = Arc::new(Mutex::new(state));
        let is_closing = Arc::new(AtomicBool::new(false));
        let thread = std::thread::spawn({
            let (state, is_closing) = (Arc::clone(&state), Arc::clone(&is_closing));
            move || accept(&listener, &state, &is_closing)
        });
        Self { address, state, is_closing, thread: Some(thread) }
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Looks at it, or changes it.
    pub fn with<T>(&self, look: impl FnOnce(&mut State) -> T) -> T {
        look(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the cursor, m in the device's frame.
    pub fn hold_at(&self, cursor_m: Vec3) {
        self.with(|state| state.cursor_m = cursor_m);
    }

    /// What was sent last, N in the device's frame.
    #[must_use]
    pub fn force_n(&self) -> Vec3 {
        self.with(|state| state.force_n)
    }
}

impl Drop for HaplyTwin {
    fn drop(&mut self) {
        self.is_closing.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            drop(thread.join());
        }
    }
}

/// One client after the other; each on a thread, so that a deserted one does not hold up the next.
fn accept(listener: &TcpListener, state: &Arc<Mutex<State>>, is_closing: &Arc<AtomicBool>) {
    let mut threads = Vec::new();
    while !is_closing.load(Ordering::Relaxed) {
        match listener.accept() {
            Ok((stream, _)) => {
                let (state, is_closing) = (Arc::clone(state), Arc::clone(is_closing));
                threads.push(std::thread::spawn(move || talk(stream, &state, &is_closing)));
            }
            Err(_) => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    for thread in threads {
        drop(thread.join());
    }
}

/// A conversation; whatever ends it takes its force away.
fn talk(stream: TcpStream, state: &Mutex<State>, is_closing: &AtomicBool) {
    let look = || state.lock().unwrap_or_else(PoisonError::into_inner);
    let set = stream.set_nonblocking(false).and_then(|()| stream.set_nodelay(true));
    if set.and_then(|()| stream.set_read_timeout(Some(Duration::from_secs(2)))).is_err() {
        return;
    }
    let Ok(mut socket) = tungstenite::accept(stream) else { return };
    let connection = {
        let mut state = look();
        state.connections += 1;
        (state.messages, state.first) = (0, Value::Null);
        state.connections
    };
    let inventory = look().report(true).to_string();
    let mut goes_on = socket.send(Message::text(inventory)).is_ok();
    if socket.get_ref().set_read_timeout(Some(Duration::from_millis(10))).is_err() {
        return;
    }
    while goes_on && !is_closing.load(Ordering::Relaxed) {
        match socket.read() {
            Ok(Message::Text(text)) => {
                let (trouble, reply) = {
                    let mut state = look();
                    let is_full = state.obey(text.as_str());
                    let trouble = state.trouble;
                    if matches!(trouble, Trouble::LateOnce(_)) {
                        state.trouble = Trouble::None;
                    }
                    (trouble, state.report(is_full).to_string())
                };
                goes_on = answer(&mut socket, trouble, reply);
            }
            Ok(_) => {}
            Err(tungstenite::Error::Io(error))
                if matches!(error.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut) => {}
            Err(_) => goes_on = false,
        }
    }
    let mut state = look();
    // forces of several clients add up; the twin has one at a time
    if state.connections == connection {
        state.force_n = Vec3::ZERO;
    }
}

/// Sends what the service replies in its trouble; false when the client has gone.
fn answer(socket: &mut WebSocket<TcpStream>, trouble: Trouble, reply: String) -> bool {
    let mut send = |text: String| socket.send(Message::text(text)).is_ok();
    match trouble {
        Trouble::Silent => true,
        Trouble::Late(ms) | Trouble::LateOnce(ms) => {
            std::thread::sleep(Duration::from_millis(ms));
            send(reply)
        }
        Trouble::Twice => send(reply.clone()) && send(reply),
        Trouble::Garbage => send("<html>".into()),
        _ => send(reply),
    }
}

impl State {
    /// A vector of the device's in the axes that are told.
    fn told(&self, own: Vec3) -> Vec3 {
        let [x, y, z] = self.axes();
        Vec3::new(x.dot(own), y.dot(own), z.dot(own))
    }

    /// The axes that are told, in the device's frame.
    fn axes(&self) -> [Vec3; 3] {
        let mut axes = [Vec3::ZERO; 3];
        let (mut sign, mut at) = (1.0, 0);
        for letter in self.basis.chars() {
            let axis = match letter {
                'X' => Vec3::X,
                'Y' => Vec3::Y,
                'Z' => Vec3::Z,
                letter => {
                    sign = if letter == '-' { -1.0 } else { 1.0 };
                    continue;
                }
            };
            (axes[at], at, sign) = (axis * sign, at + 1, 1.0);
        }
        axes
    }

    /// What the service says: everything at first and when it is asked to, states otherwise.
    fn report(&self, is_inventory: bool) -> Value {
        let vector = |v: Vec3| json!({ "x": v.x, "y": v.y, "z": v.z });
        let place = match self.trouble {
            Trouble::NotANumber => json!({ "x": null, "y": "NaN", "z": 1e300 }),
            _ => vector(self.told(self.cursor_m)),
        };
        let velocity = vector(self.told(self.velocity_m_s));
        let mut state = json!({
            "mode": "idle", "cursor_position": place, "cursor_velocity": velocity, "transform": self.transform,
        });
        if self.trouble == Trouble::Stateless {
            state = json!({});
        }
        let power = self.trouble != Trouble::Powerless;
        let status =
            json!({ "calibrated": true, "in_use": true, "power_supply": power, "ready": power, "started": true });
        let device = |name: &String| {
            let mut device = json!({ "device_id": name, "state": state, "status": status });
            if is_inventory {
                let basis = json!({ "permutation": self.basis });
                device["config"] = json!({ "type": "inverse3", "port": "COM18", "basis": basis, "mount": self.mount });
            }
            device
        };
        let grip =
            json!({ "device_id": "1412", "state": { "buttons": { "a": false, "b": self.button_b, "c": false } } });
        let inverse3: Vec<Value> = self.devices.iter().map(device).collect();
        json!({ "session_id": 16, "inverse3": inverse3, "verse_grip": [], "wireless_verse_grip": [grip] })
    }

    /// Does what a message says; whether everything is to be told.
    fn obey(&mut self, text: &str) -> bool {
        let message: Value = serde_json::from_str(text).unwrap_or_default();
        if self.messages == 0 {
            self.first = message.clone();
        }
        self.messages += 1;
        let command = &message["inverse3"][0];
        self.addressed = command["device_id"].as_str().unwrap_or_default().to_owned();
        if let Some(basis) = message["session"]["configure"]["basis"]["permutation"].as_str()
            && !self.is_stubborn
        {
            self.basis = basis.to_owned();
        }
        if command["configure"]["preset"]["preset"] == "defaults" && !self.is_stubborn {
            self.mount = json!({});
        }
        let vector = &command["commands"]["set_cursor_force"]["vector"];
        let along = |axis: &str| vector[axis].as_f64().unwrap_or(f64::NAN) as f32;
        let [x, y, z] = self.axes();
        self.force_n = x * along("x") + y * along("y") + z * along("z");
        message["session"]["force_render_full_state"].is_object()
    }
}
