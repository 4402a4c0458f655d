//! The profile of a fast wheel, held against the full grid: its error, its choice, and the hand-over both ways.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};
use pottery_shared::clay::{
    Contact, ErrorBound, GridShape, Lathe, MethodKind, PlasticCsem, Pot, PotSpec, Press, SubStep, Surface, Window,
};
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Tick};
use pottery_tests::dice::Dice;

const POT_RADIUS_M: f32 = 0.06;
const SEED: u64 = 0x1a74e;

/// A tool that comes in slowly, goes along the pot, and is at work still when it is over.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    rpm: f32,
    tool_m: f32,
    depth_m: f32,
    turns_in: f32,
    /// Feed for each turn over the length of contact, and turns that it lasts.
    pitch: f32,
    turns: f32,
}

impl Stroke {
    const STILL: Self = Self { rpm: 120.0, tool_m: 0.012, depth_m: 0.002, turns_in: 5.0, pitch: 0.0, turns: 20.0 };

    fn random(dice: &mut Dice) -> Self {
        let mut between = |low: f32, high: f32| low + (high - low) * dice.share() as f32;
        Self {
            rpm: between(60.0, 300.0),
            tool_m: between(0.008, 0.02),
            depth_m: between(0.0005, 0.003),
            turns_in: between(2.0, 10.0),
            pitch: between(0.0, 0.1),
            turns: between(8.0, 15.0),
        }
    }

    fn contact_m(&self) -> f32 {
        2.0 * (2.0 * self.tool_m * self.depth_m - self.depth_m * self.depth_m).sqrt()
    }

    /// Angle between two ticks, rad: the tool goes round against the wheel.
    fn tick_rad(&self) -> f32 {
        -self.rpm / 60.0 * TAU * Tick::PERIOD.0
    }

    fn ticks(&self) -> u32 {
        ((self.turns_in + self.turns) * TAU / -self.tick_rad()) as u32
    }

    fn press(&self, tick: u32) -> Press {
        let turned = tick as f32 * -self.tick_rad() / TAU;
        let depth_m = self.depth_m * (turned / self.turns_in).min(1.0);
        let along_m = self.pitch * self.contact_m() * (turned - self.turns_in).max(0.0);
        self.press_at(tick, depth_m, 0.08 + along_m)
    }

    fn press_at(&self, tick: u32, depth_m: f32, z_m: f32) -> Press {
        let distance_m = POT_RADIUS_M + self.tool_m - depth_m;
        let at = |tick: u32| {
            let angle_rad = (f64::from(tick) * f64::from(self.tick_rad())) as f32;
            Vec3::new(distance_m * angle_rad.cos(), distance_m * angle_rad.sin(), z_m)
        };
        let tool = Sphere::new(Metres(self.tool_m)).expect("the stroke's tools are in range");
        Press { from_m: tick.checked_sub(1).map(at), turning: 1, ..Press::held(tool, at(tick)) }
    }
}

/// A pot that is advanced by the grid alone, or by grid and profile as the choice has it.
struct Wheel {
    pot: Pot,
    substep: SubStep,
    lathe: Option<Lathe>,
    changed: Vec<Window>,
    ticks_turning: u32,
    /// Force on the tool in the last tick, N.
    felt_n: Vec3,
}

impl Wheel {
    fn new(columns: u32, rows: u32, bound: Option<ErrorBound>) -> Self {
        let shape = GridShape::new(columns, rows).expect("the test's grids are in range");
        let pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the default pot can be made");
        let lathe = bound.map(|bound| Lathe::new(&pot.surfaces()[0], bound, PlasticCsem::default()));
        Self {
            pot,
            substep: SubStep::for_grid(shape),
            lathe,
            changed: Vec::new(),
            ticks_turning: 0,
            felt_n: Vec3::ZERO,
        }
    }

    fn tick(&mut self, press: &Press, turned_rad: f32) -> bool {
        let changed = &mut self.changed;
        if let Some(lathe) = &mut self.lathe {
            let surface = &mut self.pot.surfaces_mut()[0];
            if let Some(contact) = lathe.advance(surface, press, turned_rad, |window| changed.push(window)) {
                self.ticks_turning += 1;
                self.felt_n = contact.force_n;
                return true;
            }
        }
        let contacts =
            self.substep.advance(&mut self.pot, &[*press], MethodKind::Plastic, |_, window| changed.push(window));
        self.felt_n = contacts[0].force_n;
        false
    }

    fn stroke(&mut self, stroke: &Stroke) {
        for tick in 0..stroke.ticks() {
            self.tick(&stroke.press(tick), stroke.tick_rad());
        }
    }

    fn leave(&mut self) {
        let changed = &mut self.changed;
        if let Some(lathe) = &mut self.lathe {
            lathe.leave(&mut self.pot.surfaces_mut()[0], |window| changed.push(window));
        }
    }

    /// Goes on from `tick` as `press` has it until the grid is in force; the number of ticks that took.
    fn ticks_until_left(&mut self, stroke: &Stroke, from: u32, press: impl Fn(u32) -> Press, at_most: u32) -> u32 {
        (0..at_most).find(|tick| !self.tick(&press(from + tick), stroke.tick_rad())).unwrap_or(at_most)
    }

    fn surface(&self) -> &Surface {
        &self.pot.surfaces()[0]
    }
}

/// A wheel on which a still tool works until the profile is in force, and the tick at which it is.
fn turning(stroke: &Stroke) -> (Wheel, u32) {
    let mut wheel = Wheel::new(180, 200, Some(ErrorBound::default()));
    let entered = (0..stroke.ticks()).find(|tick| wheel.tick(&stroke.press(*tick), stroke.tick_rad()));
    let entered = entered.expect("a tool that is held becomes a profile");
    (wheel, entered + 1)
}

/// RMS difference over the rows that were moved by more than a fiftieth of the depth, over the depth.
fn error(grid: &Surface, profile: &Surface, depth_m: f32) -> f64 {
    let columns = 0..grid.shape().columns();
    let (mut squares, mut count) = (0.0, 0.0);
    for row in 0..grid.shape().rows() as usize {
        let radii_m = columns.clone().map(|column| (grid.column_m(column)[row], profile.column_m(column)[row]));
        if radii_m.clone().any(|(radius_m, _)| (radius_m - POT_RADIUS_M).abs() > 0.02 * depth_m) {
            squares += radii_m.map(|(one_m, other_m)| f64::from(one_m - other_m).powi(2)).sum::<f64>();
            count += f64::from(grid.shape().columns());
        }
    }
    (squares / f64::max(count, 1.0)).sqrt() / f64::from(depth_m)
}

/// The default bound is the claim. The grid has at least five elements to a contact each way: with fewer it is itself farther
/// from a finer one than that.
#[test]
fn hundred_random_strokes_stay_within_the_bound() {
    let bound = ErrorBound::default();
    let mut dice = Dice::new(SEED);
    let (mut worst, mut sum, mut turning, mut ticks) = (0.0_f64, 0.0, 0_u64, 0_u64);
    for number in 0..100 {
        let stroke = Stroke::random(&mut dice.split());
        let [mut grid, mut both] = [None, Some(bound)].map(|bound| Wheel::new(360, 300, bound));
        for wheel in [&mut grid, &mut both] {
            wheel.stroke(&stroke);
            wheel.leave();
        }
        let error = error(grid.surface(), both.surface(), stroke.depth_m);
        assert!(
            error <= f64::from(bound.share()),
            "seed {SEED:#x}, stroke {number}: {error:.4} of the depth, {stroke:?}"
        );
        (worst, sum) = (worst.max(error), sum + error);
        turning += u64::from(both.ticks_turning);
        ticks += u64::from(stroke.ticks());
    }
    println!("worst {worst:.4}, mean {:.4} of the depth, {turning} of {ticks} ticks as a profile", sum / 100.0);
    assert!(2 * turning > ticks, "seed {SEED:#x}: the profile was in force in {turning} of {ticks} ticks");
}

/// A tenth of the pot's radius, which left 1.6 % where 0.5 was the bound when the pitch alone was counted.
#[test]
fn deep_grooves_stay_within_the_bound() {
    let stroke = Stroke { rpm: 150.0, depth_m: 0.006, turns_in: 10.0, pitch: 0.025, turns: 40.0, ..Stroke::STILL };
    let mut grid = Wheel::new(360, 300, None);
    grid.stroke(&stroke);
    for (share, turns) in [(0.005, false), (0.03, true)] {
        let bound = ErrorBound::new(share).expect("it is in range");
        let mut both = Wheel::new(360, 300, Some(bound));
        both.stroke(&stroke);
        both.leave();
        let error = error(grid.surface(), both.surface(), stroke.depth_m);
        println!(
            "{error:.4} of the depth for {share}, {} of {} ticks as a profile",
            both.ticks_turning,
            stroke.ticks()
        );
        assert!(error <= f64::from(share), "{error:.4} for {share}");
        assert!((both.ticks_turning > stroke.ticks() / 4) == turns, "{} ticks as a profile", both.ticks_turning);
    }
}

#[test]
fn a_profile_that_nothing_moves_leaves_every_bit() {
    // less than what springs back under a contact of one element
    let stroke = Stroke { depth_m: 4e-6, ..Stroke::STILL };
    let mut wheel = Wheel::new(180, 200, Some(ErrorBound::default()));
    // out of round by less than a hundredth of what would be noticed
    for column in 0..180 {
        wheel.pot.surfaces_mut()[0].set_radius(column, 80, POT_RADIUS_M + 4e-9 * (column % 7) as f32);
    }
    let before = wheel.pot.digest();
    wheel.stroke(&stroke);
    assert!(wheel.ticks_turning > 0, "the profile was never in force");
    wheel.leave();
    assert_eq!(wheel.pot.digest(), before);
    assert!(wheel.changed.iter().all(|window| window.columns < 180), "a profile that did not move was written");
}

/// A round pot is the same to the profile and to the grid, whichever has it first.
#[test]
fn hand_over_keeps_the_volume() {
    let (mut wheel, entered) = turning(&Stroke::STILL);
    let before_m3 = wheel.pot.enclosed_volume_m3();
    wheel.leave();
    let change = wheel.pot.enclosed_volume_m3() / before_m3 - 1.0;
    // one tick was pressed, of less than a hundredth of a turn: 1e-7 of the pot, as much as a single f32 has
    assert!(change.abs() < 1e-6, "volume changed by {change:e} at tick {entered}");
}

#[test]
fn pot_keeps_its_volume_under_a_profile() {
    let mut wheel = Wheel::new(180, 200, Some(ErrorBound::default()));
    let before_m3 = wheel.pot.enclosed_volume_m3();
    wheel.stroke(&Stroke { pitch: 0.05, ..Stroke::STILL });
    wheel.leave();
    let windows = std::mem::take(&mut wheel.changed);
    wheel.pot.settle(windows.into_iter().map(|window| (0, window)));
    let change = wheel.pot.enclosed_volume_m3() / before_m3 - 1.0;
    // the height is an f32
    assert!(change.abs() < 1e-6, "volume changed by {change:e}");
}

/// Force on a tool that is held at a height until the profile has been in force for two turns, along the radius and up, N. Clay is 1.7 mm
/// wider than it may be at least, so that a tool 2 mm deep meets whatever is as narrow as that.
fn felt_beside_narrow_clay(z_m: f32) -> Vec2 {
    let stroke = Stroke::STILL;
    // eights of rows do not end with the rim
    let shape = GridShape::new(180, 203).expect("the grid is in range");
    let spec = PotSpec { shape, wall: Metres(0.029), keeps_volume: false, ..PotSpec::default() };
    let mut pot = Pot::new(spec).expect("half of the radius is the thickest wall, and this is less");
    let surface = &mut pot.surfaces_mut()[0];
    let radius_m = surface.bounds_m().0 + 0.0017;
    for (column, row) in (0..180).flat_map(|column| (0..203).map(move |row| (column, row))) {
        surface.set_radius(column, row, radius_m);
    }
    let lathe = Lathe::new(&pot.surfaces()[0], ErrorBound::default(), PlasticCsem::default());
    let (mut substep, mut lathe, mut turning) = (SubStep::for_grid(shape), lathe, 0.0);
    for tick in 0..2 * stroke.ticks() {
        let turned = tick as f32 * -stroke.tick_rad() / TAU;
        let depth_m = stroke.depth_m * (turned / stroke.turns_in).min(1.0);
        let press = stroke.press_at(tick, POT_RADIUS_M - radius_m + depth_m, z_m);
        match lathe.advance(&mut pot.surfaces_mut()[0], &press, stroke.tick_rad(), |_| {}) {
            Some(Contact { force_n, .. }) if turning > 2.0 * TAU => {
                return Vec2::new(force_n.truncate().length(), force_n.z);
            }
            Some(_) => turning -= stroke.tick_rad(),
            None => {
                substep.advance(&mut pot, &[press], MethodKind::Plastic, |_, _| {});
                turning = 0.0;
            }
        }
    }
    unreachable!("a tool that is held becomes a profile");
}

/// How strongly a tool is pushed away, level and up, is as on the grid. Whither it is pushed is up to a quarter of a turn old in the pot's frame.
#[test]
fn a_profile_carries_the_tool_as_the_grid_does() {
    for (depth_m, pitch) in [(0.001, 0.0), (0.002, 0.05), (0.003, 0.02)] {
        let stroke = Stroke { depth_m, pitch, ..Stroke::STILL };
        let [grid_n, profile_n] = [None, Some(ErrorBound::default())].map(|bound| {
            let mut wheel = Wheel::new(360, 300, bound);
            let turn = (TAU / -stroke.tick_rad()) as u32;
            let mut felt_n = Vec2::ZERO;
            for tick in 0..stroke.ticks() {
                let turns = wheel.tick(&stroke.press(tick), stroke.tick_rad());
                if tick + turn >= stroke.ticks() {
                    assert_eq!(turns, bound.is_some(), "tick {tick}");
                    felt_n += Vec2::new(wheel.felt_n.truncate().length(), wheel.felt_n.z) / turn as f32;
                }
            }
            felt_n
        });
        println!("{depth_m} m deep, P/2a {pitch}: {grid_n:.3} N on the grid, {profile_n:.3} N on the profile");
        assert!(grid_n.distance(profile_n) < 0.02 * grid_n.x, "{grid_n} N and {profile_n} N");
    }
}

/// Foot and rim are each other's mirror image, and a profile ends with both.
#[test]
fn profile_has_no_clay_beyond_the_rim() {
    let [foot_n, rim_n] = [0.0, PotSpec::default().height.0].map(felt_beside_narrow_clay);
    println!("{foot_n:.3?} N at the foot, {rim_n:.3?} N at the rim");
    let mirrored_n = foot_n * Vec2::new(1.0, -1.0);
    // the same sums over other rows; clay above the rim would bear as rows below it do, and push down
    assert!(rim_n.y > 0.0 && rim_n.distance(mirrored_n) < 0.01 * rim_n.length(), "{rim_n} N for {mirrored_n} N");
}

#[test]
fn profile_is_left_in_the_air_at_once() {
    let stroke = Stroke::STILL;
    let (mut wheel, entered) = turning(&stroke);
    let ticks = wheel.ticks_until_left(&stroke, entered, |tick| stroke.press_at(tick, -1e-3, 0.08), 10);
    assert_eq!(ticks, 0);
}

#[test]
fn profile_is_left_when_the_wheel_stops_or_turns_back() {
    for turned_rad in [0.0, -Stroke::STILL.tick_rad(), f32::NAN] {
        let stroke = Stroke::STILL;
        let (mut wheel, entered) = turning(&stroke);
        assert!(!wheel.tick(&stroke.press(entered), turned_rad), "still a profile at {turned_rad} rad a tick");
    }
}

/// 0.44·(P/2a)² is 1 % at P/2a = 0.15: a tool that goes along twice as fast has gone that far in half a turn, one that goes along
/// at half of it never has.
#[test]
fn profile_is_left_where_the_thread_is_too_coarse() {
    for (pitch, leaves) in [(0.3, true), (0.075, false)] {
        let stroke = Stroke::STILL;
        let (mut wheel, entered) = turning(&stroke);
        let per_tick_m = pitch * stroke.contact_m() * -stroke.tick_rad() / TAU;
        let feed = |tick: u32| stroke.press_at(tick, stroke.depth_m, 0.08 + per_tick_m * (tick - entered) as f32);
        let turn = (TAU / -stroke.tick_rad()) as u32;
        let ticks = wheel.ticks_until_left(&stroke, entered, feed, 3 * turn);
        assert_eq!(ticks < turn, leaves, "left after {ticks} of {turn} ticks a turn at P/2a = {pitch}");
    }
}

/// ± 30 % of the depth at the wheel's own speed makes a pot that is not round.
#[test]
fn profile_is_left_when_the_depth_swings_within_a_turn() {
    let stroke = Stroke::STILL;
    let (mut wheel, entered) = turning(&stroke);
    let swing = |tick: u32| {
        let turned_rad = (tick - entered) as f32 * stroke.tick_rad();
        stroke.press_at(tick, stroke.depth_m * (1.0 + 0.3 * turned_rad.sin()), 0.08)
    };
    let turn = (TAU / -stroke.tick_rad()) as u32;
    assert!(wheel.ticks_until_left(&stroke, entered, swing, turn) < turn);
}

#[test]
fn profile_is_left_before_a_mark_that_is_not_round() {
    let stroke = Stroke { pitch: 0.05, turns: 80.0, ..Stroke::STILL };
    let mut wheel = Wheel::new(180, 200, Some(ErrorBound::default()));
    let marked_row = 130;
    for column in 20..30 {
        wheel.pot.surfaces_mut()[0].set_radius(column, marked_row, POT_RADIUS_M - 1e-3);
    }
    let mut was_turning = false;
    for tick in 0..stroke.ticks() {
        let turns = wheel.tick(&stroke.press(tick), stroke.tick_rad());
        let mark_m = wheel.surface().row_z_m(marked_row) - stroke.press(tick).centre_m.z;
        if mark_m < stroke.tool_m {
            assert!(was_turning, "never a profile");
            assert!(!turns, "a profile {mark_m} m before the mark");
            return;
        }
        was_turning |= turns;
    }
    unreachable!("the stroke is long enough to come to the mark");
}

#[test]
fn bound_that_makes_no_sense_is_told() {
    for share in [0.0, -0.01, 0.5, f32::NAN, f32::INFINITY] {
        let fault = ErrorBound::new(share).expect_err("no such bound");
        assert!(fault.to_string().contains("choose one from 0.0001 to 0.2"), "{fault}");
    }
    assert!(ErrorBound::new(0.01).is_ok());
}
