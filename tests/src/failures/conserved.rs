//! What becomes of the clay over a long time.
//!
//! Owns the long run.
//! Invariant: the tool never leaves the clay, so that every tick counts.

use pottery_shared::clay::MethodKind;

use super::scene::Scene;

/// Ticks of a long run, a multiple of what lies between two measurements.
const TICKS: u32 = 102_300;

/// Change of the volume, with what is booked to the height, over the volume, after 10⁵ ticks, in percent.
///
/// Ends early once it is ten times what is allowed.
pub(super) fn volume(method: MethodKind) -> f64 {
    let mut scene = Scene::new(method, 90, 100);
    let before = scene.pot.enclosed_volume_m3();
    let mut drift = 0.0;
    for tick in 0..TICKS {
        let seconds = f64::from(tick) * 1e-3;
        // three frequencies that have no common multiple here, so that no groove is gone over twice alike
        let depth_mm = 2.0 + 0.8 * (seconds * 3.1).sin();
        let z_mm = 100.0 + 70.0 * (seconds * 0.37).sin();
        let angle_rad = (seconds * 5.3) % std::f64::consts::TAU;
        scene.press(scene.pressed(12.0, depth_mm as f32, angle_rad as f32, z_mm as f32));
        // a snapshot of the studio
        if tick % 33 == 32 {
            scene.settle();
        }
        if tick % 3300 == 3299 {
            drift = scene.unless_broken((scene.pot.enclosed_volume_m3() / before - 1.0).abs() * 100.0);
            if drift > 1.0 {
                break;
            }
        }
    }
    drift
}
