//! A wheel that spins fast under a slow tool, advanced as one profile over height instead of a grid over angle and height.
//!
//! Owns the choice between profile and grid, and the hand-over both ways; what a turn does to a profile is told by `profile`.
//! Invariant: while the grid is in force no radius of it is touched, and while the profile is, the grid is as it was taken.

use alloc::vec::Vec;
use core::f32::consts::TAU;

use super::ellipse::Step;
use super::lanes::{LANES, hypot, root};
use super::profile::{Pass, Profile, thread};
use super::{Contact, PlasticCsem, Press, Support, Surface, Window};
use crate::tool::Side;

/// Largest error that a profile may make, over the depth of the tool.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct ErrorBound(f32);

/// Why an error bound cannot be used; choose one in the range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("an error bound of {value} of the depth cannot be used: choose one from {min} to {max}")]
pub struct BoundError {
    /// What was asked for.
    pub value: f32,
    /// Least allowed.
    pub min: f32,
    /// Largest allowed.
    pub max: f32,
}

impl ErrorBound {
    /// Finer than what the grid itself is off.
    const MIN: f32 = 1e-4;
    /// As coarse as the worst thread.
    const MAX: f32 = 0.2;

    /// A bound as a share of the depth.
    ///
    /// # Errors
    /// [`BoundError`] below 0.0001, above 0.2 or for what is not a number.
    pub fn new(share_of_depth: f32) -> Result<Self, BoundError> {
        if (Self::MIN..=Self::MAX).contains(&share_of_depth) {
            Ok(Self(share_of_depth))
        } else {
            Err(BoundError { value: share_of_depth, min: Self::MIN, max: Self::MAX })
        }
    }

    /// The bound as a share of the depth.
    #[must_use]
    pub const fn share(self) -> f32 {
        self.0
    }
}

impl Default for ErrorBound {
    /// 1 % of the depth.
    fn default() -> Self {
        Self(0.01)
    }
}

/// The choice between profile and grid, and the profile while it is in force.
///
/// With P the way of the tool along the axis in a turn, δ its depth, `2a = 2·√(2Rδ − δ²)` its contact, d the change of its
/// distance from the axis in a turn, r the clay's radius, and `g = −ln(1 − y)`, y the share of its penetration that yields while clay passes it, the
/// error is estimated as `0.44·(P/2a)² + 1.1·(δ/r)² + g·d/(√12·δ)`: the ridges of the thread (measured 0.40 to 0.44; 1/√5 for a parabola), what a deep groove
/// adds (fitted to grooves of 1.5 to 8 mm in pots of 20 and 60 mm), and
/// what a depth that changes within a turn leaves on one side of the pot. The profile is chosen below half of the bound, since errors of up to 1.8
/// times the estimate are known, and left above it. It is also chosen only where the pot under the tool is round, apart from the thread that the tool is
/// cutting: the rest has an RMS below half of the bound times δ.
///
/// Works outside of a backed wall, with one sphere, in the law of [`PlasticCsem`].
/// The estimate knows nothing of the grid: one with fewer than five elements to a contact is itself farther off.
#[derive(Clone, Debug)]
pub struct Lathe {
    bound: ErrorBound,
    law: PlasticCsem,
    profile: Profile,
    /// Mean radii as they were taken from the grid, m.
    taken_m: Vec<f32>,
    /// Rows that were taken; empty while the grid is in force.
    rows: (usize, usize),
    /// Place of every column on the thread.
    threads: Vec<f32>,
    path: Path,
    pending: Pending,
    /// Radians since it was last asked whether the pot is round.
    asked_rad: f32,
    /// Widest clay beside the tool, m.
    widest_m: f32,
    /// What [`Lathe::costs`] told when the profile last went on.
    costs: Option<[f32; 3]>,
    contact: Contact,
}

impl Lathe {
    /// Part of a turn that one step of the profile stands for, rad.
    const STRIDE_RAD: f32 = TAU / 4.0;
    /// RMS of a thread over the depth, over the square of its pitch over the contact.
    pub const CUSPS: f32 = 0.44;
    /// RMS of a deep groove over the depth, over the square of its depth over the clay's radius.
    pub const DEEP: f32 = 1.1;
    /// RMS of an even change, over the change.
    const EVEN: f32 = 0.288_675_13;
    /// Largest g, at which 39 % of a penetration yields in one pass.
    const PASS_MAX: f32 = 0.5;
    /// Smallest distance from the axis over the tool's radius: nearer, the contact is too wide for its angles' series.
    const DISTANCE_MIN: f32 = 1.5;

    /// A choice for one surface and an error bound; the grid is in force.
    #[must_use]
    pub fn new(surface: &Surface, bound: ErrorBound, law: PlasticCsem) -> Self {
        let rows = surface.shape().rows() as usize;
        Self {
            bound,
            law,
            profile: Profile::new(rows, Step::of(surface), surface.thickness_m(), surface.bounds_m()),
            taken_m: alloc::vec![0.0; rows.next_multiple_of(LANES)],
            rows: (0, 0),
            threads: alloc::vec![0.0; surface.shape().columns() as usize],
            path: Path::default(),
            pending: Pending::default(),
            asked_rad: 0.0,
            widest_m: 0.0,
            costs: None,
            contact: Contact::default(),
        }
    }

    /// Whether the profile is in force, and the surface not up to date.
    #[must_use]
    pub const fn is_turning(&self) -> bool {
        self.rows.0 < self.rows.1
    }

    /// Does one tick of a tool that went `turned_rad` round the pot since the tick before, counted with the columns.
    ///
    /// `None` says that the grid is in force and has to be pressed; `changed` has then been told of the window that was
    /// written, if the profile was in force before. With a profile, the contact is that of its last step, up to a quarter of
    /// a turn old, without sink and with nothing held, and its rim is that of clay that yields at once: what it would lack where a step yields little
    /// of a steep press is left out.
    pub fn advance(
        &mut self,
        surface: &mut Surface,
        press: &Press,
        turned_rad: f32,
        changed: impl FnMut(Window),
    ) -> Option<Contact> {
        // read back from where its parts were written one by one, it would be waited for
        let at_m = at_m(press);
        self.path.note(press, at_m, turned_rad);
        if self.is_turning() {
            if self.must_leave(press) {
                self.leave(surface, changed);
                return None;
            }
        } else if surface.support() == Support::Hollow || !self.enter_if_round(surface, press) {
            return None;
        }
        if !self.pending.is_like(press) {
            self.flush();
        }
        self.pending.add(press, at_m, turned_rad);
        if self.pending.turned_rad.abs() >= Self::STRIDE_RAD {
            self.flush();
            if !self.take_in_reach(surface, press) {
                self.leave(surface, changed);
                return None;
            }
        }
        Some(self.contact)
    }

    /// Estimated error over the depth, for a tool that goes on as it did in the last turn, beside clay that is `widest_m` wide.
    ///
    /// Infinite where the profile does not apply: for a tool of facets, inside of the wall, in the air, near the axis, before a whole turn is known,
    /// or when the wheel turns so slowly that two fifths of a dent are made in one pass.
    #[must_use]
    pub fn error_estimate(&self, press: &Press, widest_m: f32) -> f32 {
        self.path.error(self.costs(press, widest_m))
    }

    /// Error whatever the pitch, for each square metre of it, and for each metre of change.
    fn costs(&self, press: &Press, widest_m: f32) -> Option<[f32; 3]> {
        let (radius_m, distance_m) = (press.tool.sphere()?.radius().0, self.path.at_m[1]);
        let depth_m = (widest_m - distance_m + radius_m).min(radius_m);
        if press.side == Side::Inside || depth_m <= 0.0 || distance_m < Self::DISTANCE_MIN * radius_m {
            return None;
        }
        let contact_m = 2.0 * root(2.0 * radius_m * depth_m - depth_m * depth_m);
        let pass = contact_m / widest_m / self.path.step_rad.abs() * -libm::log1pf(-press.response);
        let holds = pass <= Self::PASS_MAX;
        let deep = depth_m / widest_m;
        let by_change = Self::EVEN * pass / depth_m;
        holds.then_some([Self::DEEP * deep * deep, Self::CUSPS / (contact_m * contact_m), by_change])
    }

    /// Whether a tool goes so that the profile may be chosen, if the pot is round under it.
    #[must_use]
    pub fn may_enter(&self, press: &Press, widest_m: f32) -> bool {
        self.error_estimate(press, widest_m) <= 0.5 * self.bound.0
    }

    /// Whether the profile in force has to be left: the error is estimated above the bound, or the tool is in the air.
    #[must_use]
    #[inline(always)]
    pub fn must_leave(&self, press: &Press) -> bool {
        let touches = press.tool.sphere().is_some_and(|it| self.path.at_m[1] - it.radius().0 < self.widest_m);
        // written so that what is not a number leaves
        let holds = touches && press.side == Side::Outside && self.path.error(self.costs) <= self.bound.0;
        !holds
    }

    /// Writes the profile to the grid, which is in force from now on. Rows that no tool moved keep every bit.
    ///
    /// The thread that the tool was cutting goes along: with Δ the fall of a row in a turn and s the place on its turn, from
    /// −½ behind the tool to ½ before it, `r² = r̄² + 2·r̄·Δ·s`, so that the mean of the squares is kept.
    pub fn leave(&mut self, surface: &mut Surface, mut changed: impl FnMut(Window)) {
        if !self.is_turning() {
            return;
        }
        self.flush();
        let (first, end) = core::mem::take(&mut self.rows);
        let moved = |row: &usize| self.profile.radii_m[*row] != self.taken_m[*row];
        let end = end.min(surface.shape().rows() as usize);
        if let (Some(low), Some(high)) = ((first..end).find(moved), (first..end).rfind(moved)) {
            let contact_rad = self.half_contact_rad(low, high);
            self.fill_threads(surface, contact_rad);
            for column in 0..surface.shape().columns() {
                let place = 2.0 * self.threads[column as usize];
                for row in low..=high {
                    let radius_m = self.profile.radii_m[row];
                    if radius_m != self.taken_m[row] {
                        let square_m2 = radius_m * (radius_m + self.profile.fall_m[row] * place);
                        surface.set_radius(column, row as u32, root(square_m2.max(0.0)));
                    }
                }
            }
            let columns = surface.shape().columns();
            changed(Window { first_column: 0, columns, first_row: low as u32, rows: (high - low + 1) as u32 });
        }
        self.profile.rest();
    }

    fn half_contact_rad(&self, low: usize, high: usize) -> f32 {
        (low..=high).map(|row| self.profile.half_contact_rad(row)).fold(0.0, f32::max)
    }

    /// Places of the columns on the thread that ends at the tool; their mean is zero.
    fn fill_threads(&mut self, surface: &Surface, half_contact_rad: f32) {
        let column_rad = surface.shape().column_angle_rad();
        let [x, y] = self.path.place_m;
        let (tool_rad, sign) = (libm::atan2f(y, x), if self.path.step_rad < 0.0 { -1.0 } else { 1.0 });
        let mut sum = 0.0;
        for (column, place) in self.threads.iter_mut().enumerate() {
            *place = thread((column as f32 * column_rad - tool_rad) * sign, half_contact_rad);
            sum += *place;
        }
        let mean = sum / self.threads.len() as f32;
        self.threads.iter_mut().for_each(|place| *place -= mean);
    }

    fn enter_if_round(&mut self, surface: &Surface, press: &Press) -> bool {
        self.asked_rad += self.path.step_rad.abs();
        if self.asked_rad < Self::STRIDE_RAD {
            return false;
        }
        self.asked_rad = 0.0;
        self.widest_m = self.widest_near(surface, press);
        if !self.may_enter(press, self.widest_m) {
            return false;
        }
        self.pending = Pending::default();
        self.contact = Contact::default();
        let entered = self.take_in_reach(surface, press);
        if !entered {
            self.rows = (0, 0);
            self.profile.rest();
        }
        entered
    }

    /// The widest clay beside a tool, in the column that it touches, m.
    fn widest_near(&self, surface: &Surface, press: &Press) -> f32 {
        let shape = surface.shape();
        let angle_rad = libm::atan2f(press.centre_m.y, press.centre_m.x);
        let column = shape.wrap(libm::roundf(angle_rad / shape.column_angle_rad()) as i64);
        let (first, end) = self.beside(surface, press);
        widest(&surface.column_m(column)[first..end])
    }

    /// Rows beside a tool.
    fn beside(&self, surface: &Surface, press: &Press) -> (usize, usize) {
        let radius_m = radius_m(press);
        let row =
            |z_m: f32| ((z_m / surface.row_height_m()).max(0.0) as usize).min(surface.shape().rows() as usize - 1);
        (row(press.centre_m.z - radius_m), row(press.centre_m.z + radius_m) + 1)
    }

    /// Takes the rows that the tool reaches from the grid, as far as they are not yet; false when they are not round.
    fn take_in_reach(&mut self, surface: &Surface, press: &Press) -> bool {
        let (first, end) = self.profile.reach(radius_m(press), press.centre_m.z);
        let (low, high) = self.rows;
        let fresh = if low < high { [(first, low.min(end)), (high.max(first), end)] } else { [(first, end), (0, 0)] };
        if low < high && (first > high || end < low) {
            return false;
        }
        for (from, to) in fresh {
            if from < to && !self.take_rows(surface, press, from, to) {
                return false;
            }
        }
        self.rows = if low < high { (low.min(first), high.max(end)) } else { (first, end) };
        let (from, to) = self.beside(surface, press);
        self.widest_m = widest(&self.profile.radii_m[from..to]);
        self.costs = self.costs(press, self.widest_m);
        true
    }

    fn take_rows(&mut self, surface: &Surface, press: &Press, from: usize, to: usize) -> bool {
        let radius_m = radius_m(press);
        let depth_m = (self.widest_m - self.path.at_m[1] + radius_m).clamp(0.0, radius_m);
        let contact_rad = root(2.0 * radius_m * depth_m - depth_m * depth_m) / self.widest_m;
        self.fill_threads(surface, contact_rad);
        let columns = f64::from(surface.shape().columns());
        let thread2: f64 = self.threads.iter().map(|place| f64::from(place * place)).sum();
        let allowed_m = f64::from(0.5 * self.bound.0 * depth_m);
        let to = to.min(surface.shape().rows() as usize);
        let (mut rest, mut rows) = (0.0, 0.0);
        for begin in (from..to).step_by(LANES) {
            let end = (begin + LANES).min(to);
            let ([mut sums, mut squares, mut slopes], first) = ([[0.0_f64; LANES]; 3], surface.column_m(0));
            for (column, &place) in self.threads.iter().enumerate() {
                let radii_m = &surface.column_m(column as u32)[begin..end];
                for (lane, (&radius_m, &first_m)) in radii_m.iter().zip(&first[begin..end]).enumerate() {
                    // from the first column on, so that small differences are kept
                    let more_m = f64::from(radius_m - first_m);
                    sums[lane] += more_m;
                    squares[lane] += more_m * more_m;
                    slopes[lane] += more_m * f64::from(place);
                }
            }
            for (lane, (row, &first_m)) in (begin..end).zip(&first[begin..end]).enumerate() {
                let first_m = f64::from(first_m);
                let (mean_m, slope_m) = (sums[lane] / columns, slopes[lane] / thread2);
                rest += squares[lane] / columns - mean_m * mean_m - slope_m * slope_m * thread2 / columns;
                rows += 1.0;
                let square_m2 = first_m * first_m + 2.0 * first_m * mean_m + squares[lane] / columns;
                self.taken_m[row] = libm::sqrt(square_m2) as f32;
                self.profile.take(row, self.taken_m[row], slope_m as f32);
            }
        }
        rest <= allowed_m * allowed_m * rows
    }

    /// Does what has been put off.
    fn flush(&mut self) {
        let pending = core::mem::take(&mut self.pending);
        let Some(like) = pending.like else { return };
        if pending.turned_rad == 0.0 {
            return;
        }
        let ticks = pending.ticks as f32;
        let pass = Pass {
            radius_m: radius_m(&like),
            distance_m: pending.distance_m / ticks,
            z_m: pending.z_m / ticks,
            strength: like.strength,
            rate_per_rad: -libm::log1pf(-like.response) * ticks / pending.turned_rad.abs(),
            speed_rad_s: pending.turned_rad.abs() / (like.dt.0 * ticks),
            turns: pending.turned_rad.abs() / TAU,
        };
        self.contact = self.profile.advance(&self.law, &pass);
        let ([x, y], force) = (self.path.place_m, self.contact.force_n);
        let across = hypot(x, y);
        let (cos, sin) = (x / across, y / across);
        let along = force.y * pending.turned_rad.signum();
        self.contact.force_n.x = force.x * cos - along * sin;
        self.contact.force_n.y = force.x * sin + along * cos;
    }
}

/// Radius of the tool, m; a tool of facets never comes here.
fn radius_m(press: &Press) -> f32 {
    press.tool.sphere().map_or(0.0, |sphere| sphere.radius().0)
}

/// The largest of some radii, m; eight by eight, or each would wait for the one before.
fn widest(radii_m: &[f32]) -> f32 {
    let larger = |a: f32, b: f32| if b > a { b } else { a };
    let (eights, rest) = radii_m.as_chunks::<LANES>();
    let mut most = [0.0; LANES];
    for eight in eights {
        for (most, &radius_m) in most.iter_mut().zip(eight) {
            *most = larger(*most, radius_m);
        }
    }
    most.into_iter().chain(rest.iter().copied()).fold(0.0, larger)
}

/// Height of a tool and its distance from the axis, m.
fn at_m(press: &Press) -> [f32; 2] {
    let centre_m = press.centre_m;
    [centre_m.z, root(centre_m.x * centre_m.x + centre_m.y * centre_m.y)]
}

/// Ticks of a tool that the profile has not seen yet: the first of them, and what has come together since.
///
/// What changes with every tick lies in one line of the cache: what crosses two is waited for.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct Pending {
    like: Option<Press>,
    ticks: u32,
    turned_rad: f32,
    distance_m: f32,
    z_m: f32,
}

impl Pending {
    #[inline(always)]
    fn is_like(&self, press: &Press) -> bool {
        self.like.is_none_or(|like| {
            like.tool == press.tool
                && like.dt == press.dt
                && like.response == press.response
                && like.strength == press.strength
        })
    }

    #[inline(always)]
    fn add(&mut self, press: &Press, [z_m, distance_m]: [f32; 2], turned_rad: f32) {
        if self.like.is_none() {
            self.like = Some(*press);
        }
        self.ticks += 1;
        self.turned_rad += turned_rad;
        self.distance_m += distance_m;
        self.z_m += z_m;
    }
}

/// How a tool went in the turn before this one, and in this one so far.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(64))]
struct Path {
    /// Height and distance from the axis, m.
    at_m: [f32; 2],
    /// Where it is across the axis, m.
    place_m: [f32; 2],
    step_rad: f32,
    turned_rad: f32,
    low_m: [f32; 2],
    high_m: [f32; 2],
    before_m: Option<[f32; 2]>,
}

impl Path {
    #[inline(always)]
    fn note(&mut self, press: &Press, at_m: [f32; 2], turned_rad: f32) {
        self.at_m = at_m;
        self.place_m = [press.centre_m.x, press.centre_m.y];
        let turns_on = turned_rad * self.step_rad > 0.0;
        self.step_rad = turned_rad;
        if !turns_on {
            // another way round, or at a stand: nothing is known
            (self.turned_rad, self.before_m) = (0.0, None);
            (self.low_m, self.high_m) = (at_m, at_m);
            return;
        }
        self.turned_rad += turned_rad.abs();
        for (number, at_m) in at_m.into_iter().enumerate() {
            self.low_m[number] = self.low_m[number].min(at_m);
            self.high_m[number] = self.high_m[number].max(at_m);
        }
        if self.turned_rad >= TAU {
            self.turned_rad -= TAU;
            self.before_m = Some(self.range_m());
            (self.low_m, self.high_m) = (at_m, at_m);
        }
    }

    #[inline(always)]
    fn range_m(&self) -> [f32; 2] {
        [self.high_m[0] - self.low_m[0], self.high_m[1] - self.low_m[1]]
    }

    /// Estimated error of a profile; infinite before a whole turn is known.
    #[inline(always)]
    fn error(&self, costs: Option<[f32; 3]>) -> f32 {
        let (Some(before_m), Some([at_least, by_pitch, by_change])) = (self.before_m, costs) else {
            return f32::INFINITY;
        };
        let now_m = self.range_m();
        let (pitch_m, change_m) = (before_m[0].max(now_m[0]), before_m[1].max(now_m[1]));
        at_least + by_pitch * pitch_m * pitch_m + by_change * change_m
    }
}
