//! Presses that make no sense.
//!
//! Owns the numbers that nobody should press with.
//! Invariant: the dice are the scenario's own, so that every method meets the same presses.

use glam::Vec3;
use pottery_shared::clay::{Contact, MethodKind, Press, Strength};
use pottery_shared::tool::Side;

use super::scene::Scene;
use crate::dice::Dice;

/// Numbers at the ends of what a number can be, and none.
const ODD: [f32; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    1e20,
    -1e20,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// 3000 presses with one to nine numbers that make no sense: radii, forces and sinks that are
/// then no number or out of bounds.
pub(super) fn odd_numbers(method: MethodKind) -> f64 {
    let mut dice = Dice::new(0x0dd);
    let mut scene = Scene::new(method, 32, 40);
    let mut broken = 0;
    for _ in 0..3000 {
        let presses: Vec<Press> = (0..1 + dice.roll() % 2).map(|_| odd_press(&scene, &mut dice)).collect();
        let contacts = scene.advance(&presses);
        broken += contacts.iter().filter(|contact| is_strange(contact)).count();
        broken += scene.misplaced();
    }
    broken as f64
}

fn is_strange(contact: &Contact) -> bool {
    let sink = contact.sink.unwrap_or_default();
    let sink = [sink.angle_rad, sink.z_m, sink.radius_m, sink.half_arc_m, sink.half_height_m, sink.depth_m];
    !contact.force_n.is_finite() || !contact.penetration_m.is_finite() || sink.iter().any(|number| !number.is_finite())
}

fn odd_press(scene: &Scene, dice: &mut Dice) -> Press {
    let radius_mm = 0.5 + 39.5 * dice.share() as f32;
    let angle_rad = dice.share() as f32 * std::f32::consts::TAU;
    let mut press = scene.pressed(radius_mm, 30.0 * dice.share() as f32, angle_rad, 200.0 * dice.share() as f32);
    let odd = |usual: f32, dice: &mut Dice| {
        if dice.chance(0.2) { ODD[(dice.roll() % ODD.len() as u64) as usize] } else { usual }
    };
    let odd_place = |dice: &mut Dice| Vec3::from_array(press.centre_m.to_array().map(|along| odd(along, dice)));
    press.from_m = dice.chance(0.5).then(|| odd_place(dice));
    press.centre_m = odd_place(dice);
    press.response = odd(press.response, dice);
    let Strength { youngs_pa, yield_pa } = press.strength;
    press.strength = Strength { youngs_pa: odd(youngs_pa, dice), yield_pa: odd(yield_pa, dice) };
    press.side = if dice.chance(0.5) { Side::Inside } else { Side::Outside };
    press.turning = dice.roll() as i8;
    press
}
