//! How a device's workspace is fitted to the pot: where the hand rests, and how far it goes.
//!
//! Pure: is told where the device is and when the person says so; knows no window and no driver.
//! Invariant: whatever it was told, the fit that it gives is one that [`Calibration`] takes.

use glam::Vec3;

use super::Calibration;

/// How far the tool is to go above and below the middle, m: from the foot of the pot with which a wheel begins to its rim.
pub const REACH_ROOM_M: f32 = 0.100;
/// A hand that went less far up or down than this has shown no reach, m.
const LEAST_REACH_M: f32 = 0.010;

/// Where the middle of a workspace lies, and how many times as far as the hand the tool goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// m, from the device's own origin along the room's axes.
    pub middle_m: Vec3,
    /// From [`Calibration::SCALE_MIN`] to [`Calibration::SCALE_MAX`].
    pub scale: f32,
}

impl Fit {
    /// The same, if its numbers are ones that a device can be fitted with.
    #[must_use]
    pub fn sound(self) -> Option<Self> {
        let is_scale = (Calibration::SCALE_MIN..=Calibration::SCALE_MAX).contains(&self.scale);
        (self.middle_m.is_finite() && is_scale).then_some(self)
    }
}

/// What is asked of the person.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// To hold the device where the hand rests well.
    Rest,
    /// To move it as far as the hand goes without effort.
    Reach,
    /// To look whether it suits.
    Done,
}

/// A fitting, from the first step to the last.
///
/// ```
/// use glam::Vec3;
/// use pottery_client::device::{Fit, Fitting, Step};
///
/// let mut fitting = Fitting::new(Fit { middle_m: Vec3::ZERO, scale: 1.0 });
/// fitting.see(Vec3::new(0.01, 0.0, 0.02));
/// fitting.go_on();
/// assert_eq!(fitting.step(), Step::Reach);
/// for z_m in [0.02, 0.07, -0.02] {
///     fitting.see(Vec3::new(0.01, 0.0, z_m));
/// }
/// fitting.go_on();
/// // 40 mm down is all that the hand has, and the pot's foot is 100 mm below its middle
/// assert_eq!(fitting.fit(), Fit { middle_m: Vec3::new(0.01, 0.0, 0.02), scale: 2.5 });
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fitting {
    step: Step,
    /// As it was before.
    before: Fit,
    fit: Fit,
    /// The last place, and the box of those since the hand rested; m, as [`Fit::middle_m`].
    place_m: Option<Vec3>,
    low_m: Vec3,
    high_m: Vec3,
}

impl Fitting {
    /// Begins with the fit that there is.
    #[must_use]
    pub const fn new(before: Fit) -> Self {
        let (low_m, high_m) = (before.middle_m, before.middle_m);
        Self { step: Step::Rest, before, fit: before, place_m: None, low_m, high_m }
    }

    /// What is asked of the person now.
    #[must_use]
    pub const fn step(&self) -> Step {
        self.step
    }

    /// As it was before, to go back to.
    #[must_use]
    pub const fn before(&self) -> Fit {
        self.before
    }

    /// As far as it is known.
    #[must_use]
    pub const fn fit(&self) -> Fit {
        self.fit
    }

    /// Takes in where the device is, m as [`Fit::middle_m`]; what is no place is passed over.
    pub fn see(&mut self, place_m: Vec3) {
        if !place_m.is_finite() {
            return;
        }
        self.place_m = Some(place_m);
        match self.step {
            Step::Rest => (self.low_m, self.high_m) = (place_m, place_m),
            Step::Reach => {
                (self.low_m, self.high_m) = (self.low_m.min(place_m), self.high_m.max(place_m));
                self.fit.scale = self.scale();
            }
            Step::Done => {}
        }
    }

    /// The person says that it is so. A step that has seen nothing is not over.
    pub fn go_on(&mut self) {
        let Some(place_m) = self.place_m else { return };
        self.step = match self.step {
            Step::Rest => {
                self.fit.middle_m = place_m;
                Step::Reach
            }
            Step::Reach | Step::Done => Step::Done,
        };
    }

    /// Lets the tool go so many times as far as the hand.
    pub fn set_scale(&mut self, scale: f32) {
        if let Some(fit) = (Fit { scale, ..self.fit }).sound() {
            self.fit = fit;
        }
    }

    /// How far the hand was seen to go from where it rests, m: to the left and right, away and near, and down and up.
    #[must_use]
    pub fn reach_m(&self) -> [Vec3; 2] {
        [self.low_m, self.high_m].map(|corner_m| corner_m - self.fit.middle_m)
    }

    /// Where the hand is now, as [`Fitting::reach_m`].
    #[must_use]
    pub fn here_m(&self) -> Option<Vec3> {
        self.place_m.map(|place_m| place_m - self.fit.middle_m)
    }

    /// So that the lesser of the ways up and down takes the tool from the middle to foot or rim.
    fn scale(&self) -> f32 {
        let [low_m, high_m] = self.reach_m();
        let reach_m = high_m.z.min(-low_m.z);
        if reach_m < LEAST_REACH_M {
            return self.before.scale;
        }
        (REACH_ROOM_M / reach_m).clamp(Calibration::SCALE_MIN, Calibration::SCALE_MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BEFORE: Fit = Fit { middle_m: Vec3::new(0.0, 0.1, 0.0), scale: 1.5 };

    #[test]
    fn a_hand_that_only_rests_changes_the_middle_alone() {
        let mut fitting = Fitting::new(BEFORE);
        fitting.go_on();
        assert_eq!(fitting.step(), Step::Rest, "nothing was seen of the device");
        let rest_m = Vec3::new(0.02, 0.05, -0.01);
        fitting.see(rest_m);
        fitting.see(Vec3::NAN);
        fitting.go_on();
        // a hand trembles
        fitting.see(rest_m + Vec3::splat(0.002));
        fitting.see(rest_m - Vec3::splat(0.002));
        fitting.go_on();
        assert_eq!((fitting.step(), fitting.fit()), (Step::Done, Fit { middle_m: rest_m, ..BEFORE }));
        assert_eq!(fitting.before(), BEFORE);
    }

    #[test]
    fn one_way_is_no_reach_and_a_place_after_the_last_step_changes_nothing() {
        let mut fitting = Fitting::new(BEFORE);
        fitting.see(Vec3::ZERO);
        fitting.go_on();
        fitting.see(Vec3::Z * 0.08);
        assert_eq!(fitting.fit().scale, BEFORE.scale);
        fitting.see(Vec3::Z * -0.05);
        assert_eq!(fitting.fit().scale, 2.0);
        fitting.go_on();
        fitting.see(Vec3::Z * -0.5);
        assert_eq!(fitting.here_m(), Some(Vec3::Z * -0.5));
        assert_eq!((fitting.fit().scale, fitting.reach_m()), (2.0, [Vec3::Z * -0.05, Vec3::Z * 0.08]));
        fitting.set_scale(f32::NAN);
        assert_eq!(fitting.fit().scale, 2.0);
        fitting.set_scale(3.0);
        assert_eq!(fitting.fit().scale, 3.0);
    }

    #[test]
    fn any_hand_gives_a_fit_that_can_be_used() {
        const ALONG: [f32; 7] = [f32::NAN, f32::INFINITY, -f32::MAX, -1e-30, 0.0, 0.011, f32::MAX];
        let places = || ALONG.into_iter().flat_map(|x| ALONG.map(|z| Vec3::new(x, 0.0, z)));
        for (first, second) in places().flat_map(|first| places().map(move |second| (first, second))) {
            let mut fitting = Fitting::new(BEFORE);
            for place_m in [first, second, -second] {
                fitting.see(place_m);
                assert!(fitting.fit().sound().is_some(), "{first}, {second}: {fitting:?}");
                fitting.go_on();
                assert!(fitting.fit().sound().is_some(), "{first}, {second}: {fitting:?}");
            }
        }
    }
}
