//! Several people on one pot.
//!
//! Owns the scenarios in which it must not matter who presses, and who else does.
//! Invariant: what is compared is compared bit for bit, where the words do not say otherwise.

use std::f32::consts::PI;

use pottery_shared::clay::{MethodKind, Press};
use pottery_shared::tool::Side;

use super::scene::{Scene, around, larger};

/// Three overlapping tools, two outside and one inside, in each of their six orders: how many end in another pot than the first.
pub(super) fn another_order(method: MethodKind) -> f64 {
    const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let digests = ORDERS.map(|order| {
        let mut scene = Scene::new(method, 90, 100);
        for tick in 0..40_u8 {
            let along = f32::from(tick) * 0.01;
            let presses = [
                scene.pressed(12.0, 3.0, 0.1 + along, 100.0),
                scene.pressed(8.0, 2.0, 0.3 - along, 104.0),
                Press { side: Side::Inside, ..scene.tool(10.0, around(46.0, 0.2 + along, 97.0)) },
            ];
            scene.advance(&order.map(|number| presses[number]));
        }
        scene.pot.digest()
    });
    digests.iter().filter(|digest| **digest != digests[0]).count() as f64
}

/// Two tools on opposite sides: what either feels of the other, N; infinite when the clay is not that of both alone.
pub(super) fn opposite_sides(method: MethodKind) -> f64 {
    let [mut both, mut one, mut other] = [(); 3].map(|()| Scene::new(method, 180, 200));
    let mut felt = 0.0_f64;
    for tick in 0..100_u8 {
        let z_mm = 90.0 + 0.2 * f32::from(tick);
        let presses = [both.pressed(12.0, 3.0, 0.1, z_mm), both.pressed(12.0, 2.0, 0.1 + PI, 180.0 - z_mm)];
        let forces = both.advance(&presses).iter().map(|contact| contact.force_n).collect::<Vec<_>>();
        let alone = [one.advance(&presses[..1])[0].force_n, other.advance(&presses[1..])[0].force_n];
        for (force, alone) in forces.iter().zip(alone) {
            felt = larger(felt, f64::from((*force - alone).length()));
        }
    }
    let untouched = both.untouched_m();
    let superposed =
        one.radii_m().iter().zip(other.radii_m()).map(|(&one, &other)| if one == untouched { other } else { one });
    if both.radii_m().iter().copied().eq(superposed) { both.unless_broken(felt) } else { f64::INFINITY }
}

/// A wall pinched for a second, 2 mm from either side: the farthest that an element went, over those 2 mm.
pub(super) fn pinched_wall(method: MethodKind) -> f64 {
    let mut scene = Scene::new(method, 180, 200);
    let mut farthest = 0.0_f64;
    // the published methods have no wall: both tools press the one surface
    let wall_mm = if method == MethodKind::Plastic { 8.0 } else { 0.0 };
    for _ in 0..1000 {
        let outside = scene.pressed(12.0, 2.0, 0.1, 101.3);
        let inside = scene.tool(12.0, around(60.0 - wall_mm - 12.0 + 2.0, 0.1, 101.3));
        scene.advance(&[outside, Press { side: Side::Inside, ..inside }]);
        let moved = scene.radii_m().iter().map(|radius| f64::from((radius - scene.untouched_m()).abs()));
        farthest = moved.fold(farthest, larger);
    }
    scene.unless_broken(farthest / 2e-3)
}
