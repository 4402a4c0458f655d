//! The JSON of Haply's service, version 3.5 and later, as far as a force and a place need it.
//!
//! Pure. Names from Haply's public pages on its protocol, bases, mounts and device configuration and its `haply` crate, whose dependencies (an HTTP client with a C
//! library, linear algebra) this program does not want. The service leaves out what is as by default.
//! Invariant: what is no number in JSON never becomes one here.

use glam::Vec3;
use serde::{Deserialize, Serialize};

/// What the service says of all devices.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Frame {
    /// The Inverse3 and its relatives; verse grips are not looked at, but for their buttons.
    #[serde(default)]
    pub(super) inverse3: Vec<Inverse3>,
    /// Grips with a cable.
    #[serde(default)]
    pub(super) verse_grip: Vec<Grip>,
    /// Grips without one.
    #[serde(default)]
    pub(super) wireless_verse_grip: Vec<Grip>,
}

/// One device.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Inverse3 {
    /// Its name on this machine.
    pub(super) device_id: String,
    /// How it is set up for this client, in a full report.
    #[serde(default)]
    pub(super) config: Option<Config>,
    /// How it is.
    #[serde(default)]
    pub(super) status: Status,
    /// Where it is.
    #[serde(default)]
    pub(super) state: State,
}

/// How a device is set up for a client.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Config {
    /// Which axis is which.
    pub(super) basis: Basis,
    /// Where and how it stands.
    pub(super) mount: Transform,
}

/// Which of the device's axes, x right, y away and z up, are the client's: their letters in order, `-` before one that is turned round.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Basis {
    /// The letters.
    pub(super) permutation: String,
}

impl Default for Basis {
    fn default() -> Self {
        Self { permutation: "XYZ".into() }
    }
}

impl Basis {
    /// Whether axes are what they are.
    #[must_use]
    pub(super) fn is_own(&self) -> bool {
        self.permutation.replace('+', "") == Self::default().permutation
    }
}

/// What the service does to places before it tells them.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Transform {
    /// Moves them, m.
    position: Vector,
    /// Turns them.
    rotation: Quaternion,
    /// Makes them larger.
    scale: Scale,
}

impl Transform {
    /// Whether it changes nothing that could be felt: a tenth of a millimetre, or of a degree at a metre.
    #[must_use]
    pub(super) fn is_none(&self) -> bool {
        let Quaternion { x, y, z, .. } = self.rotation;
        let scale = Vec3::new(self.scale.x, self.scale.y, self.scale.z) - Vec3::ONE;
        [self.position.to_vec3(), Vec3::new(x, y, z), scale].iter().all(|part| part.abs().max_element() < 1e-4)
    }
}

/// A turn; none by itself.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
struct Quaternion {
    x: f32,
    y: f32,
    z: f32,
}

/// Factors; one each by itself.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
struct Scale {
    x: f32,
    y: f32,
    z: f32,
}

impl Default for Scale {
    fn default() -> Self {
        Self { x: 1.0, y: 1.0, z: 1.0 }
    }
}

/// How a device is; what is left out is well.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(default)]
pub(super) struct Status {
    /// Knows its zero.
    pub(super) calibrated: bool,
    /// Has power for its motors.
    pub(super) power_supply: bool,
    /// Can be used.
    pub(super) ready: bool,
}

impl Default for Status {
    fn default() -> Self {
        Self { calibrated: true, power_supply: true, ready: true }
    }
}

/// Where a device is.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct State {
    /// Its cursor, m.
    pub(super) cursor_position: Option<Vector>,
    /// And how fast, m/s.
    pub(super) cursor_velocity: Option<Vector>,
    /// What somebody does to its workspace.
    pub(super) transform: Transform,
}

/// A grip, for its buttons.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Grip {
    /// What is pressed.
    #[serde(default)]
    pub(super) state: GripState,
}

/// What is pressed on a grip.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct GripState {
    /// The only button of a grip with a cable.
    pub(super) button: bool,
    /// Those of a grip without one.
    pub(super) buttons: Option<Buttons>,
}

/// Buttons of a wireless grip.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Buttons {
    /// The first.
    pub(super) a: bool,
    /// The second.
    pub(super) b: bool,
    /// The third.
    pub(super) c: bool,
}

/// Three numbers in the device's frame.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(default)]
pub(super) struct Vector {
    /// To the right.
    pub(super) x: f32,
    /// Away from the person.
    pub(super) y: f32,
    /// Up.
    pub(super) z: f32,
}

impl Vector {
    /// As a vector.
    #[must_use]
    pub(super) const fn to_vec3(self) -> Vec3 {
        Vec3::new(self.x, self.y, self.z)
    }
}

impl From<Vec3> for Vector {
    fn from(vector: Vec3) -> Self {
        Self { x: vector.x, y: vector.y, z: vector.z }
    }
}

impl Frame {
    /// Reads a message of the service.
    ///
    /// # Errors
    /// What JSON or the service's form does not allow, in words.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }

    /// Buttons that are down on any grip.
    #[must_use]
    pub(super) fn buttons(&self) -> u32 {
        let down = |grip: &Grip| {
            let buttons = grip.state.buttons.unwrap_or_default();
            u32::from(grip.state.button | buttons.a) | u32::from(buttons.b) << 1 | u32::from(buttons.c) << 2
        };
        self.verse_grip.iter().chain(&self.wireless_verse_grip).map(down).fold(0, |all, grip| all | grip)
    }
}

#[derive(Serialize)]
struct Message<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    session: Option<Session>,
    inverse3: [Addressed<'a>; 1],
}

#[derive(Serialize)]
struct Session {
    configure: SessionConfigure,
    force_render_full_state: Nothing,
}

#[derive(Serialize)]
struct SessionConfigure {
    profile: Profile,
    basis: Basis,
}

#[derive(Serialize)]
struct Profile {
    name: &'static str,
}

#[derive(Serialize)]
struct Nothing {}

#[derive(Serialize)]
struct Addressed<'a> {
    device_id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    configure: Option<DeviceConfigure>,
    commands: Commands,
}

#[derive(Serialize)]
struct DeviceConfigure {
    preset: Preset,
}

#[derive(Serialize)]
struct Preset {
    preset: &'static str,
}

#[derive(Serialize)]
struct Commands {
    set_cursor_force: SetCursorForce,
}

#[derive(Serialize)]
struct SetCursorForce {
    vector: Vector,
}

/// The message that gives a device a force, N in its frame.
///
/// # Errors
/// None for a finite force; what JSON says of another.
pub(super) fn force_message(device_id: &str, force_n: Vec3) -> Result<String, String> {
    said(device_id, force_n, None, None)
}

/// The first message: says who is talking, asks for the device's own axes and place for as long as that lasts, gives no force and
/// asks for a full report.
///
/// # Errors
/// None; what JSON says of what it cannot write.
pub(super) fn first_message(device_id: &str) -> Result<String, String> {
    let configure = SessionConfigure { profile: Profile { name: "pottery-studio" }, basis: Basis::default() };
    let session = Session { configure, force_render_full_state: Nothing {} };
    let preset = DeviceConfigure { preset: Preset { preset: "defaults" } };
    said(device_id, Vec3::ZERO, Some(session), Some(preset))
}

fn said(
    device_id: &str,
    force_n: Vec3,
    session: Option<Session>,
    configure: Option<DeviceConfigure>,
) -> Result<String, String> {
    let commands = Commands { set_cursor_force: SetCursorForce { vector: force_n.into() } };
    let message = Message { session, inverse3: [Addressed { device_id, configure, commands }] };
    serde_json::to_string(&message).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn force_message_is_the_one_of_the_public_protocol() {
        let message = force_message("049D", Vec3::new(0.0, 0.0, 1.5)).unwrap();
        let expected = r#"{"inverse3":[{"device_id":"049D","commands":{"set_cursor_force":{"vector":{"x":0.0,"y":0.0,"z":1.5}}}}]}"#;
        assert_eq!(message, expected);
        let expected = concat!(
            r#"{"session":{"configure":{"profile":{"name":"pottery-studio"},"basis":{"permutation":"XYZ"}},"force_render_full_state":{}},"#,
            r#""inverse3":[{"device_id":"049D","configure":{"preset":{"preset":"defaults"}},"#,
            r#""commands":{"set_cursor_force":{"vector":{"x":0.0,"y":0.0,"z":0.0}}}}]}"#
        );
        assert_eq!(first_message("049D").unwrap(), expected);
    }

    #[test]
    fn what_is_left_out_of_a_transform_does_nothing_and_what_is_there_is_seen() {
        let transform = |text: &str| serde_json::from_str::<Transform>(text).unwrap();
        for text in [
            "{}",
            r#"{"position":{"x":0,"y":0,"z":0},"rotation":{"w":1,"x":0,"y":0,"z":0},"scale":{"x":1,"y":1,"z":1}}"#,
            r#"{"rotation":{"w":-1},"scale":{"y":1}}"#,
        ] {
            assert!(transform(text).is_none(), "{text}");
        }
        for text in [
            r#"{"position":{"z":0.01}}"#,
            r#"{"rotation":{"w":0.6,"z":0.8}}"#,
            r#"{"scale":{"x":2}}"#,
            r#"{"scale":{"x":0.5,"y":0.5,"z":0.5}}"#,
        ] {
            assert!(!transform(text).is_none(), "{text}");
        }
        let is_own = |permutation: &str| Basis { permutation: permutation.into() }.is_own();
        assert!(is_own("XYZ") && is_own("+X+Y+Z"));
        assert!(!is_own("XZY") && !is_own("X-YZ") && !is_own(""));
    }

    #[test]
    fn inventory_and_state_are_read_whatever_else_they_hold() {
        let inventory = r#"{"session_id":16,"inverse3":[{"device_id":"04BA","config":{"type":"inverse3","port":"COM18"},
            "state":{"mode":"idle","cursor_position":{"x":0.0257,"y":-0.1668,"z":0.0936},"cursor_velocity":{"x":1,"y":0,"z":0}},
            "status":{"calibrated":true,"in_use":false,"power_supply":true,"ready":false,"started":true}}],
            "verse_grip":[{"device_id":"61548","state":{"button":false,"hall":0}}],
            "wireless_verse_grip":[{"device_id":"0","state":{"buttons":{"a":false,"b":true,"c":true}}}],
            "custom_verse_grip":[]}"#;
        let frame = Frame::parse(inventory).unwrap();
        assert_eq!(frame.inverse3[0].device_id, "04BA");
        assert_eq!(frame.inverse3[0].state.cursor_position.unwrap().to_vec3(), Vec3::new(0.0257, -0.1668, 0.0936));
        assert!(!frame.inverse3[0].status.ready && frame.inverse3[0].status.power_supply);
        assert_eq!(frame.buttons(), 0b110);
        let state = r#"{"inverse3":[{"device_id":"04BA","state":{"cursor_position":{"x":0.1}}}]}"#;
        let frame = Frame::parse(state).unwrap();
        assert_eq!(frame.inverse3[0].state.cursor_position.unwrap().to_vec3(), Vec3::new(0.1, 0.0, 0.0));
        assert!(frame.inverse3[0].status.ready && frame.inverse3[0].state.cursor_velocity.is_none());
    }

    #[test]
    fn what_is_no_message_of_the_service_is_refused() {
        for text in [
            "",
            "7",
            "{\"inverse3\":7}",
            "{\"inverse3\":[{}]}",
            "{\"inverse3\":[{\"device_id\":\"A\",\"state\":{\"cursor_position\":{\"x\":\"NaN\"}}}]}",
        ] {
            assert!(Frame::parse(text).is_err(), "{text}");
        }
    }
}
