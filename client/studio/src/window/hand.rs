//! From pointer and buttons to where the tool should be.
//!
//! Pure: knows no window and no time but what it is told. Outside, the tool moves in front of the clay and is pushed towards
//! the axis; inside, it moves before the far wall, which the viewer sees through the mouth, and is pushed away from the axis.
//! Invariant: a tool that is not pushed does not touch the clay that was there when it was last free, and it changes sides
//! over the rim.

use glam::{Vec2, Vec3};
use pottery_client::render::Camera;
use pottery_shared::clay::Pot;

use pottery_shared::tool::Side;

use super::holding::Reach;

/// Gap between a free tool and the clay, m.
const GAP_M: f32 = 0.004;
/// How fast the tool is pushed in and let out, m/s, and the most by which it is pushed from one picture to the next, m: one that comes late is no
/// reason to stab.
const PUSH_M_S: f32 = 0.015;
const PUSH_MAX_M: f32 = 0.001;
const RELEASE_M_S: f32 = 0.12;
/// How deep the button pushes, m.
const BUTTON_DEPTH_M: f32 = 0.006;
/// Farthest to the side of the axis that the tool follows, m.
const SIDE_MAX_M: f32 = 0.3;
/// Deepest push, and what is none, m.
const PUSHED_MAX_M: f32 = 0.04;
const LEAST_M: f32 = 1e-5;
/// How long a tool that changes sides is lifted over the rim, and how long it is held there on the other side, s: at the
/// device's fastest glide it has then gone a quarter of a metre.
const LIFT_S: f32 = 0.45;
const CROSS_S: f32 = 0.35;
/// Least room between an inner tool and the axis, m: it needs a direction to be pushed in.
const AXIS_M: f32 = 1e-3;

/// How the tool is held.
#[derive(Debug)]
pub(super) struct Hand {
    /// Where the pointer is in the picture, −1 to 1.
    pointer: Option<Vec2>,
    button: bool,
    /// What the button pushes in the end, which wheel and keys change while it is held, m, and what at the moment.
    button_m: f32,
    by_button_m: f32,
    /// What was set by wheel or key, m, and what of that is pushed at the moment.
    set_m: f32,
    by_wheel_m: f32,
    /// Widest radius of each row when the tool was last free, m.
    outline_m: Vec<f32>,
    /// Narrowest radius of each row of the inner wall, m, and the height of its floor.
    bore_m: Vec<f32>,
    floor_m: f32,
    row_height_m: f32,
    side: Side,
    /// How long ago the person asked for the other side, s, until it is reached.
    crossing_s: Option<f32>,
}

impl Hand {
    pub(super) fn new(pot: &Pot) -> Self {
        let mut hand = Self {
            pointer: None,
            button: false,
            button_m: 0.0,
            by_button_m: 0.0,
            set_m: 0.0,
            by_wheel_m: 0.0,
            outline_m: Vec::new(),
            bore_m: Vec::new(),
            floor_m: 0.0,
            row_height_m: 1.0,
            side: Side::Outside,
            crossing_s: None,
        };
        hand.look_at(pot);
        hand
    }

    /// Follows the pointer from now on; whether it was elsewhere.
    pub(super) fn point_to(&mut self, pointer: Option<Vec2>) -> bool {
        std::mem::replace(&mut self.pointer, pointer) != pointer
    }

    pub(super) const fn press_button(&mut self, pressed: bool) {
        if pressed && !self.button {
            self.button_m = (GAP_M + BUTTON_DEPTH_M).max(self.set_m);
        }
        self.button = pressed;
    }

    /// The side of the wall on which the person works, or wants to.
    pub(super) const fn side(&self) -> Side {
        self.side
    }

    /// Goes over the rim to the other side, and lets out what was pushed.
    pub(super) const fn change_side(&mut self) {
        self.side = match self.side {
            Side::Outside => Side::Inside,
            Side::Inside => Side::Outside,
        };
        (self.set_m, self.by_wheel_m) = (0.0, 0.0);
        self.crossing_s = Some(0.0);
    }

    /// Pushes in by so much more, or less, as fast as the button does: what the button pushes while it is held, and otherwise what stays.
    pub(super) fn push(&mut self, by_m: f32) {
        let pushed_m = if self.button { &mut self.button_m } else { &mut self.set_m };
        let to_m = (*pushed_m + by_m).min(PUSHED_MAX_M);
        // as many steps back as there were, but for what is rounded
        *pushed_m = if to_m < LEAST_M { 0.0 } else { to_m };
    }

    /// What the button pushes in the end, m.
    fn held_m(&self) -> f32 {
        if self.button && self.crossing_s.is_none() { self.button_m } else { 0.0 }
    }

    /// Whether more is to be pushed or let out than is at the moment.
    pub(super) fn is_on_its_way(&self) -> bool {
        self.by_wheel_m != self.set_m || self.by_button_m != self.held_m()
    }

    /// How deep the tool is pushed beyond the surface of the free clay, m.
    pub(super) fn pushed_m(&self) -> f32 {
        let pushed_m = self.by_button_m.max(self.by_wheel_m);
        if pushed_m > 0.0 { pushed_m - GAP_M } else { 0.0 }
    }

    /// Whether the clay's outline may be taken anew.
    pub(super) fn is_free(&self) -> bool {
        self.by_button_m <= 0.0 && self.by_wheel_m <= 0.0
    }

    /// Takes the widest outline of the pot, and its narrowest bore.
    pub(super) fn look_at(&mut self, pot: &Pot) {
        let [outer, inner] = pot.skins();
        let surface = &pot.surfaces()[outer.surface];
        self.row_height_m = surface.row_height_m();
        self.floor_m = pot.spec().wall.0;
        let rows = surface.shape().rows() as usize;
        self.outline_m.clear();
        self.outline_m.resize(rows, 0.0);
        self.bore_m.clear();
        self.bore_m.resize(rows, f32::INFINITY);
        for column in surface.radii_m().chunks_exact(rows) {
            for (widest, &radius) in self.outline_m.iter_mut().zip(column) {
                *widest = widest.max(radius);
            }
        }
        for column in pot.surfaces()[inner.surface].radii_m().chunks_exact(rows) {
            for (narrowest, &radius) in self.bore_m.iter_mut().zip(column) {
                *narrowest = narrowest.min(radius - inner.inset_m);
            }
        }
    }

    /// Lets `seconds` pass.
    pub(super) fn pass(&mut self, seconds: f32) {
        self.crossing_s = self.crossing_s.map(|passed| passed + seconds).filter(|passed| *passed < LIFT_S + CROSS_S);
        let (in_m, out_m) = ((PUSH_M_S * seconds).min(PUSH_MAX_M), RELEASE_M_S * seconds);
        let towards = |goal_m: f32, now_m: f32| {
            if goal_m > now_m {
                // the gap costs no time
                (now_m.max(GAP_M) + in_m).min(goal_m)
            } else {
                (now_m - out_m).max(goal_m)
            }
        };
        (self.by_button_m, self.by_wheel_m) =
            (towards(self.held_m(), self.by_button_m), towards(self.set_m, self.by_wheel_m));
    }

    /// Where a tool of that reach should be, m; `None` while the pointer is not over the wheel.
    pub(super) fn target_m(&self, camera: &Camera, aspect: f32, reach: &Reach) -> Option<Vec3> {
        let (eye, direction) = camera.ray(self.pointer?, aspect);
        let towards = (eye - camera.target_m).with_z(0.0).normalize_or(Vec3::X);
        let aside = towards.cross(Vec3::Z);
        let slope = direction.dot(towards);
        if slope > -1e-3 {
            return None;
        }
        let over_m = self.height_m() + reach.over_rim_m;
        // the side it is still on, and how low it may be on the way to the other
        let (side, lowest_m) = match (self.crossing_s, self.side) {
            (Some(passed), Side::Inside) if passed < LIFT_S => (Side::Outside, over_m),
            (Some(passed), Side::Outside) if passed < LIFT_S => (Side::Inside, over_m),
            (Some(_), side) => (side, over_m),
            (None, Side::Outside) => (Side::Outside, reach.lowest_m),
            (None, Side::Inside) => (Side::Inside, self.floor_m + reach.under_m + GAP_M),
        };
        // The free tool is drawn under the pointer: the plane on which the ray is met stands before the axis by as much
        // as the tool does, which depends on where the ray meets it; it settles in a few turns.
        let mut before_m = 0.0;
        let (mut along, mut height, mut free_m) = (0.0, 0.0, 0.0);
        for _ in 0..4 {
            let at = eye + direction * ((before_m - eye.dot(towards)) / slope);
            along = at.dot(aside);
            height = at.z.clamp(lowest_m.min(over_m), over_m);
            let (from_m, to_m) = (height - reach.below_m, height + reach.above_m);
            (free_m, before_m) = match side {
                Side::Outside => {
                    let free_m = self.widest_m(from_m, to_m) + reach.inwards_m + GAP_M;
                    (free_m, in_front_m(free_m, along))
                }
                Side::Inside => {
                    let free_m = (self.narrowest_m(from_m, to_m) - reach.outwards_m - GAP_M).max(AXIS_M);
                    (free_m, -in_front_m(free_m, along))
                }
            };
        }
        if along.abs() > SIDE_MAX_M {
            return None;
        }
        let pushed_m = self.by_button_m.max(self.by_wheel_m);
        if side == Side::Inside {
            let along = along.clamp(-free_m, free_m);
            return Some((aside * along + towards * before_m) * ((free_m + pushed_m) / free_m) + Vec3::Z * height);
        }
        let distance_m = (free_m - pushed_m).max(0.0);
        if along.abs() < free_m {
            // pushed towards the axis
            let share = distance_m / free_m;
            Some((aside * along + towards * before_m) * share + Vec3::Z * height)
        } else {
            let along = along.signum() * (along.abs() - pushed_m).max(0.0);
            Some(aside * along + Vec3::Z * height)
        }
    }

    fn height_m(&self) -> f32 {
        self.row_height_m * (self.outline_m.len() - 1) as f32
    }

    /// The rows between two heights.
    fn rows(&self, from_m: f32, to_m: f32) -> std::ops::RangeInclusive<usize> {
        let row = |z_m: f32| (z_m / self.row_height_m).clamp(0.0, (self.outline_m.len() - 1) as f32) as usize;
        row(from_m)..=row(to_m)
    }

    /// Widest radius between two heights.
    fn widest_m(&self, from_m: f32, to_m: f32) -> f32 {
        self.outline_m[self.rows(from_m, to_m)].iter().copied().fold(0.0, f32::max)
    }

    /// Narrowest inner radius between two heights.
    fn narrowest_m(&self, from_m: f32, to_m: f32) -> f32 {
        self.bore_m[self.rows(from_m, to_m)].iter().copied().fold(f32::INFINITY, f32::min)
    }
}

/// How far in front of the plane through the axis a point of the circle of `radius_m` round the axis stands.
fn in_front_m(radius_m: f32, along_m: f32) -> f32 {
    (radius_m * radius_m - along_m * along_m).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::clay::PotSpec;

    /// A sphere of 12 mm.
    const BALL: Reach = Reach {
        inwards_m: 0.012,
        outwards_m: 0.012,
        below_m: 0.006,
        above_m: 0.006,
        under_m: 0.012,
        lowest_m: -0.006,
        over_rim_m: 0.024,
    };

    fn pot() -> Pot {
        Pot::new(PotSpec::default()).expect("the usual pot can be made")
    }

    fn hand_at(pointer: Vec2) -> (Hand, Camera) {
        let pot = pot();
        let mut hand = Hand::new(&pot);
        hand.point_to(Some(pointer));
        (hand, Camera::on(&pot))
    }

    #[test]
    fn a_tool_changes_sides_over_the_rim_alone() {
        let (mut hand, camera) = hand_at(Vec2::new(0.0, -0.1));
        let spec = PotSpec::default();
        let (wall_m, bore_m) = (spec.radius.0, spec.radius.0 - spec.wall.0);
        let mut sides = Vec::new();
        hand.change_side();
        for _ in 0..60 {
            hand.pass(0.02);
            let at_m = hand.target_m(&camera, 1.6, &BALL).expect("the pointer is over the wheel");
            let away_m = at_m.truncate().length();
            // past the wall on either side, or wholly over it
            let is_over = at_m.z - 0.012 > spec.height.0;
            assert!(is_over || away_m > wall_m + 0.012 || away_m < bore_m - 0.012, "{at_m} at {away_m}");
            sides.push(away_m < bore_m);
        }
        assert_eq!((sides.first(), sides.last()), (Some(&false), Some(&true)));
        assert_eq!(hand.side(), Side::Inside);
    }

    #[test]
    fn inside_the_button_pushes_the_tool_away_from_the_axis() {
        let (mut hand, camera) = hand_at(Vec2::new(0.05, 0.1));
        hand.change_side();
        hand.pass(1.0);
        let at = |hand: &Hand| hand.target_m(&camera, 1.6, &BALL).expect("the pointer is over the wheel").truncate();
        let free = at(&hand);
        hand.press_button(true);
        (0..10).for_each(|_| hand.pass(0.02));
        let pushed = at(&hand);
        let pushed_m = pushed.length() - free.length();
        assert!((pushed_m - hand.pushed_m() - GAP_M).abs() < 1e-5 && pushed_m > 0.005, "{pushed_m}");
        assert!(free.perp_dot(pushed).abs() < 1e-6, "it is pushed straight outwards");
    }

    #[test]
    fn wheel_and_keys_change_how_deep_a_held_button_pushes_and_letting_go_frees_the_tool() {
        let (mut hand, _) = hand_at(Vec2::new(0.0, 0.1));
        hand.press_button(true);
        let pushed_after = |hand: &mut Hand, steps: i8| {
            (0..steps.abs()).for_each(|_| hand.push(f32::from(steps.signum()) * 0.001));
            (0..50).for_each(|_| hand.pass(0.02));
            hand.pushed_m()
        };
        for (steps, pushed_m) in [(0, 0.006), (3, 0.009), (-4, 0.005)] {
            let found_m = pushed_after(&mut hand, steps);
            assert!((found_m - pushed_m).abs() < 1e-6, "after {steps} steps {found_m} m");
        }
        hand.press_button(false);
        hand.pass(0.1);
        assert!(hand.is_free() && !hand.is_on_its_way());
        // what was set without the button stays when the button is let go
        (0..7).for_each(|_| hand.push(0.001));
        hand.press_button(true);
        assert!((pushed_after(&mut hand, 1) - 0.007).abs() < 1e-6);
        hand.press_button(false);
        assert!((pushed_after(&mut hand, 0) - 0.003).abs() < 1e-6);
    }

    #[test]
    fn what_wheel_and_keys_ask_for_at_once_is_pushed_as_the_button_does() {
        let (mut hand, _) = hand_at(Vec2::new(0.0, 0.1));
        (0..10).for_each(|_| hand.push(0.001));
        assert!(hand.is_on_its_way());
        // a picture that comes late, and then those that do not
        hand.pass(0.2);
        assert!((hand.pushed_m() - 0.001).abs() < 1e-6, "{} m", hand.pushed_m());
        (0..10).for_each(|_| hand.pass(0.02));
        assert!((hand.pushed_m() - 0.004).abs() < 1e-6, "{} m", hand.pushed_m());
        (0..20).for_each(|_| hand.pass(0.02));
        assert!((hand.pushed_m() - 0.006).abs() < 1e-6 && !hand.is_on_its_way(), "{} m", hand.pushed_m());
        // and it is let out at once, by as many steps
        (0..10).for_each(|_| hand.push(-0.001));
        hand.pass(0.1);
        assert!(hand.is_free() && !hand.is_on_its_way());
    }
}
