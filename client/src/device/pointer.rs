//! The mouse: a tool that glides to where the pointer asks for it.
//!
//! The window says where the tool should be, at the picture's rate; the device glides there at the hand's rate, so that
//! a jump of the pointer is a fast movement and not a jump of the tool.
//! Invariant: the tool moves no faster than [`SPEED_MAX_M_S`], and on its way comes no nearer to the axis than the nearer of
//! its ends: it goes round a pot and not through it. Another tool is taken up where it is to be, since where the one before was it may reach into clay.

use glam::{Vec2, Vec3};
use pottery_shared::haptics::{DeviceSpecs, Setup};
use pottery_shared::tool::{Orientation, Tool};

use super::Device;

/// Fastest glide, m/s.
const SPEED_MAX_M_S: f32 = 0.8;
/// Time constant of the glide, s.
const GLIDE_S: f32 = 0.02;

/// How far the tool gives way to a teacher's hand, m/N: as the lightest hand would, since nobody feels the force.
const YIELDS_M_N: f32 = 0.01;

/// Where the pointer asks the tool to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pointer {
    /// Centre of the tool, m; `None` while the pointer is away.
    pub target_m: Option<Vec3>,
    /// The tool.
    pub tool: Tool,
    /// How it is to be turned.
    pub orientation: Orientation,
}

/// The device's end.
#[derive(Debug)]
pub struct PointerDevice {
    asked: triple_buffer::Output<Pointer>,
    at: Option<(f64, Vec3, Orientation)>,
}

/// The window's end and the device's.
#[must_use]
pub fn pointer() -> (triple_buffer::Input<Pointer>, PointerDevice) {
    let (input, asked) = triple_buffer::TripleBuffer::new(&Pointer::default()).split();
    (input, PointerDevice { asked, at: None })
}

impl PointerDevice {
    /// What the window asked for last.
    pub(super) fn asked(&self) -> &Pointer {
        self.asked.output_buffer()
    }
}

/// A share of the way round the axis from one place to another, of no more than `most_m`: outwards, along the arc and up each
/// on their own.
fn glided(from_m: Vec3, to_m: Vec3, share: f32, most_m: f32) -> Vec3 {
    let (at, goal) = (from_m.truncate(), to_m.truncate());
    let (out_m, goal_out_m) = (at.length(), goal.length());
    // on the axis every side is as near
    let facing = at.try_normalize().or_else(|| goal.try_normalize()).unwrap_or(Vec2::X);
    let turn_rad = facing.perp_dot(goal).atan2(facing.dot(goal));
    // the arc is longest where the tool is farther out
    let way = Vec3::new(goal_out_m - out_m, turn_rad * out_m.max(goal_out_m), to_m.z - from_m.z);
    let step = (way * share).clamp_length_max(most_m);
    let part = if way.length() > 0.0 { step.length() / way.length() } else { 1.0 };
    (Vec2::from_angle(turn_rad * part).rotate(facing) * (out_m + step.x)).extend(from_m.z + step.z)
}

impl Device for PointerDevice {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let before = self.tool();
        self.asked.update();
        let Pointer { target_m, tool, orientation } = *self.asked.output_buffer();
        let is_same = tool == before;
        let Some(target) = target_m.filter(|_| is_same || self.at.is_none()) else {
            self.at = None;
            return None;
        };
        let (before, from, turned) = self.at.unwrap_or((seconds, target, orientation));
        let dt = (seconds - before).clamp(0.0, 0.02) as f32;
        let share = 1.0 - (-dt / GLIDE_S).exp();
        let now = glided(from, target, share, SPEED_MAX_M_S * dt);
        // what is left may be less than a share can be rounded to
        let nearer = turned.towards(orientation, share);
        let turned = if share > 0.0 && nearer == turned { orientation } else { nearer };
        self.at = Some((seconds, now, turned));
        Some(now)
    }

    fn tool(&self) -> Tool {
        self.asked.output_buffer().tool
    }

    fn orientation(&self) -> Orientation {
        self.at.map_or_else(Orientation::default, |(_, _, orientation)| orientation)
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::MOUSE
    }

    /// Nobody feels it, so that the clay may be pressed twice as hard as a small device does for the same lag, and a teacher's
    /// force moves the tool instead of the hand.
    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { yields_m_n: YIELDS_M_N, ..Setup::for_device(self.specs(), 0.5 * share_of_small) }
    }
}

#[cfg(test)]
mod tests {
    use pottery_shared::tool::Shape;

    use super::*;

    #[test]
    fn another_tool_is_put_down_and_taken_up_where_it_is_to_be() {
        let (mut asked, mut device) = pointer();
        let [near_m, far_m] = [0.076, 0.086].map(|away_m| Vec3::new(away_m, 0.0, 0.1));
        let mut hold = |tool: Tool, target_m: Vec3, millis: u32| {
            asked.write(Pointer { target_m: Some(target_m), tool, ..Pointer::default() });
            (device.position(f64::from(millis) * 1e-3), device.tool())
        };
        let rib = Tool::Convex(Shape::RIB);
        assert_eq!(hold(Tool::default(), near_m, 1), (Some(near_m), Tool::default()));
        assert_eq!(hold(rib, far_m, 2), (None, rib));
        assert_eq!(hold(rib, far_m, 3), (Some(far_m), rib));
        // the same one glides
        let (Some(at_m), _) = hold(rib, near_m, 4) else { panic!("it is in the hand") };
        assert!(at_m.x < far_m.x && at_m.x > near_m.x, "{at_m}");
    }
}
