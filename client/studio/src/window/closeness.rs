//! How much detail a picture of a wheel can show, by its size and by what of the pot is in it.
//!
//! Owns when another detail is asked for: what a person drags or scrolls through is not asked for on the way.
//! Invariant: what is asked for was right for [`STANDS_FOR`].

use std::time::{Duration, Instant};

use pottery_client::render::Camera;
use pottery_shared::clay::{GridShape, PotSpec, Surface};
use pottery_shared::snapshot::{Band, Detail};
use pottery_shared::units::Metres;

/// Time for which a detail has to be the right one.
const STANDS_FOR: Duration = Duration::from_millis(300);
/// Parts of a pot's height that are told of as a whole: people who look at about the same share what is made for them.
const PARTS: f32 = 4.0;
/// Heights at which it is looked whether they are in the picture.
const LOOKS: u32 = 32;

/// The detail that a small picture so many pixels high shows of a pot like that; `coarseness` pixels are taken for one.
pub(super) fn of_picture(camera: &Camera, spec: &PotSpec, height_px: f32, aspect: f32, coarseness: f32) -> Detail {
    let near_m = (camera.distance_m - spec.radius.0).max(Camera::DISTANCE_MIN_M);
    let pixel_m = 2.0 * camera.half_height(aspect) * near_m / height_px.max(1.0);
    let element_m = spec.height.0 / (spec.shape.rows() - 1) as f32;
    Detail::for_picture(Metres(coarseness * pixel_m), Metres(element_m))
}

/// The rows of a pot that are in a picture, in quarters of its height.
pub(super) fn band_in(camera: &Camera, surface: &Surface, aspect: f32, grid: GridShape) -> Band {
    let widest_m = surface.radii_m().iter().copied().fold(0.0, f32::max);
    let (y, x) = camera.azimuth_rad.sin_cos();
    let is_seen = |share: f32| {
        let sides = [-widest_m, 0.0, widest_m]
            .map(|radius_m| glam::Vec3::new(radius_m * x, radius_m * y, share * surface.height_m()));
        // what is behind the camera may be beside it as well
        let heights = sides.map(|point_m| camera.ndc(point_m, aspect).map(|ndc| ndc.y));
        let below = heights.iter().all(|y| y.is_some_and(|y| y < -1.0));
        let above = heights.iter().all(|y| y.is_some_and(|y| y > 1.0));
        !below && !above
    };
    let seen: Vec<f32> = (0..=LOOKS).map(|look| look as f32 / LOOKS as f32).filter(|share| is_seen(*share)).collect();
    let (Some(first), Some(last)) = (seen.first(), seen.last()) else { return Band::WHOLE };
    // one look more on either side: what is between two looks may be in the picture
    let look = 1.0 / LOOKS as f32;
    let part = ((first - look) * PARTS).floor() / PARTS..((last + look) * PARTS).ceil() / PARTS;
    Band::over(part, grid)
}

/// What is asked for, and what would be better.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    detail: Detail,
    better: Option<(Detail, Instant)>,
}

impl Asked {
    pub(super) const fn new(detail: Detail) -> Self {
        Self { detail, better: None }
    }

    pub(super) const fn detail(&self) -> Detail {
        self.detail
    }

    /// Takes in what would be right now; true when that is asked for from now on.
    pub(super) fn wants(&mut self, detail: Detail, now: Instant) -> bool {
        if detail == self.detail {
            self.better = None;
            return false;
        }
        let since = self.better.filter(|(better, _)| *better == detail).map_or(now, |(_, since)| since);
        self.better = Some((detail, since));
        let is_time = now.saturating_duration_since(since) >= STANDS_FOR;
        if is_time {
            *self = Self::new(detail);
        }
        is_time
    }
}

#[cfg(test)]
mod tests {
    use pottery_shared::clay::Pot;

    use super::*;

    #[test]
    fn larger_pictures_show_more_and_nothing_that_is_smaller_than_a_pixel() {
        let spec = PotSpec::default();
        let of = |height_px: f32| of_picture(&Camera::default(), &spec, height_px, 1.25, 1.0);
        let folds: Vec<u32> = (1..=60).map(|size| of(25.0 * size as f32).fold()).collect();
        assert!(folds.is_sorted_by(|one, other| one >= other), "{folds:?}");
        assert_eq!((folds[0], folds[59]), (8, 1));
        // a class of sixty in a window, as it was before anybody counted pixels
        assert_eq!(of(130.0), Detail::GALLERY);
    }

    #[test]
    fn whoever_is_near_sees_a_part_and_whoever_is_far_all_of_it() {
        let pot = Pot::new(PotSpec::default()).unwrap();
        let surface = &pot.surfaces()[0];
        let band = |camera: &Camera| band_in(camera, surface, 1.6, surface.shape());
        assert_eq!(band(&Camera::default()), Band::WHOLE);
        // two and a half centimetres off the wall, half way up
        let target_m = glam::Vec3::Z * 0.1;
        let near = Camera { distance_m: 0.085, elevation_rad: 0.0, target_m, ..Camera::default() };
        let rim = Camera { target_m: glam::Vec3::Z * 0.19, ..near };
        // of 25 rows of tiles: the middle half, and the upper half
        assert_eq!(band(&near), Band::new(6, 19).unwrap());
        assert_eq!(band(&rim), Band::over(0.5..1.0, surface.shape()));
        assert!(band(&rim) != Band::WHOLE);
    }

    #[test]
    fn what_is_passed_on_the_way_is_not_asked_for() {
        let begun = Instant::now();
        let mut asked = Asked::new(Detail::GALLERY);
        for ms in 0..1000 {
            // another one every tenth of a second
            let detail = if ms / 100 % 2 == 0 { Detail::SPECTATOR } else { Detail::GALLERY };
            assert!(!asked.wants(detail, begun + Duration::from_millis(ms)));
        }
        let changes: Vec<u64> =
            (1000..2000).filter(|ms| asked.wants(Detail::SPECTATOR, begun + Duration::from_millis(*ms))).collect();
        assert_eq!((changes, asked.detail()), (vec![1300], Detail::SPECTATOR));
    }
}
