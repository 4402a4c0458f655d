//! What a teacher's hand does to a student's, stage by stage: how much, until when, and where a tool is pressed that both hold.
//!
//! Through a bad network it is tried in `src/stability/guided.rs`.

use std::path::Path;
use std::process::Command;

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Guidance, GuidanceMode, Haptics, Setup, Stages, Touch};
use pottery_shared::tool::Position;
use pottery_shared::units::{Seconds, Tick};
use pottery_tests::programs::program;
use pottery_tests::stability::WAYS;

const DT: Seconds = Seconds(1e-3);
const AT_M: Vec3 = Vec3::new(0.1, 0.0, 0.1);

/// A guided hand whose device does as it is told.
struct Hand {
    chain: Haptics,
    tick: u64,
    pressed: Option<Position>,
}

impl Hand {
    fn guided(guidance: Guidance) -> Self {
        let mut chain = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 0.2));
        chain.guide(Some(guidance));
        Self { chain, tick: 0, pressed: None }
    }

    /// The same once a teacher has led for a while, who pays for what is felt: nothing is granted.
    fn paid_for(guidance: Guidance) -> Self {
        let mut hand = Self::guided(guidance);
        for tick in 0..400_u16 {
            // 0.3 m/s up and down, far away: 4 N·s/m take 144 mJ in 0.4 s, more than is kept
            let up_m = 3e-4 * f32::from(if tick % 200 < 100 { tick % 100 } else { 100 - tick % 100 });
            hand.tick(AT_M, Some(AT_M + Vec3::Z * (0.05 + up_m)));
        }
        hand
    }

    /// A tick with the device here and the teacher there; the force.
    fn tick(&mut self, device_m: Vec3, teacher_m: Option<Vec3>) -> Vec3 {
        self.tick += 1;
        if let Some(teacher_m) = teacher_m {
            self.chain.hear_teacher(Tick(self.tick), teacher_m);
        }
        self.chain.follow_teacher(Tick(self.tick), DT);
        self.pressed = self.chain.accept(Some(device_m), None, DT);
        let touch = self.pressed.map(|centre| Touch { centre, ..Touch::default() });
        touch.map_or(Vec3::ZERO, |touch| self.chain.render(&touch))
    }

    fn ticks(&mut self, ticks: u32, device_m: Vec3, teacher_m: Vec3) -> Vec3 {
        (0..ticks).fold(Vec3::ZERO, |_, _| self.tick(device_m, Some(teacher_m)))
    }
}

fn lead(strength: f32) -> Guidance {
    Guidance::new(GuidanceMode::Lead, strength)
}

#[test]
fn a_led_hand_is_drawn_to_the_teacher_by_no_more_than_a_quarter_of_what_its_device_gives() {
    let mut before_n = 0.0;
    for apart_m in [0.002, 0.005, 0.02, 0.1] {
        let force_n = Hand::paid_for(lead(1.0)).ticks(300, AT_M, AT_M + Vec3::Z * apart_m);
        assert!(force_n.z > before_n && force_n.z < 0.25 * DeviceSpecs::OMNI.peak_force_n, "{apart_m} m: {force_n}");
        assert!(force_n.truncate().length() < 1e-6, "straight towards her: {force_n}");
        before_n = force_n.z;
    }
    let half_n = Hand::paid_for(lead(0.5)).ticks(300, AT_M, AT_M + Vec3::Z * 0.1).z;
    assert!((half_n / before_n - 0.5).abs() < 0.01, "strength is a factor: {half_n} of {before_n}");
}

#[test]
fn nothing_is_felt_of_a_teacher_who_has_given_nothing() {
    for (way, guidance) in WAYS {
        let mut hand = Hand::guided(guidance);
        let felt_n = hand.ticks(3000, AT_M, AT_M + Vec3::Z * 0.02);
        assert_eq!((felt_n, hand.chain.guided().map(|guided| guided.stored_j)), (Vec3::ZERO, Some(0.0)), "{way}");
    }
}

#[test]
fn help_fades_from_a_hand_that_follows_well_and_comes_back_when_it_does_not() {
    let mut hand = Hand::guided(lead(1.0));
    let assistance = |hand: &Hand| hand.chain.guided().map_or(0.0, |guided| guided.assistance);
    // within a millimetre for two time constants: exp(−2), to the steps of a forgetting factor of 1 − 1/2000
    hand.ticks(4000, AT_M, AT_M + Vec3::Z * 0.0005);
    assert!((assistance(&hand) - (-2.0_f32).exp()).abs() < 1e-3, "{}", assistance(&hand));
    hand.ticks(4000, AT_M, AT_M + Vec3::Z * 0.006);
    assert!(assistance(&hand) > 0.88, "{}", assistance(&hand));
    // halfway between none and all of it
    hand.ticks(20_000, AT_M, AT_M + Vec3::Z * 0.003);
    assert!((assistance(&hand) - 0.5).abs() < 1e-3, "{}", assistance(&hand));
}

#[test]
fn a_tool_in_two_hands_is_pressed_between_them_round_the_axis_and_never_through_the_pot() {
    for share in [0.25, 0.5, 1.0_f32] {
        let mut hand = Hand::guided(Guidance::new(GuidanceMode::Share, share));
        // a third of a turn apart, both outside of a pot of 60 mm
        let (sin, cos) = (std::f32::consts::TAU / 3.0).sin_cos();
        let (own_m, other_m) = (Vec3::new(0.08, 0.0, 0.1), Vec3::new(0.1 * cos, 0.1 * sin, 0.14));
        for _ in 0..1000 {
            hand.tick(own_m, Some(other_m));
            let pressed_m = hand.pressed.map_or(Vec3::ZERO, |pressed| pressed.point_m());
            assert!(pressed_m.truncate().length() > 0.0799, "{share}: {pressed_m}");
        }
        let pressed_m = hand.pressed.map_or(Vec3::ZERO, |pressed| pressed.point_m());
        let angle = pressed_m.y.atan2(pressed_m.x);
        // places are rounded to 10 µm
        assert!((pressed_m.truncate().length() - (0.08 + 0.02 * share)).abs() < 2e-5, "{share}: {pressed_m}");
        assert!((angle - std::f32::consts::TAU / 3.0 * share).abs() < 2e-4, "{share}: {angle}");
        assert!((pressed_m.z - (0.1 + 0.04 * share)).abs() < 1e-5, "{share}: {pressed_m}");
    }
}

#[test]
fn whoever_takes_over_comes_gradually_and_lets_go_with_the_tool_lifted() {
    let mut hand = Hand::guided(Guidance::TAKE_OVER);
    let other_m = AT_M + Vec3::Z * 0.05;
    let mut last_m = AT_M;
    for _ in 0..1000 {
        hand.tick(AT_M, Some(other_m));
        let pressed_m = hand.pressed.map_or(Vec3::ZERO, |pressed| pressed.point_m());
        // 50 mm in 0.4 s is 0.125 mm a tick, and places are rounded to 10 µm
        assert!(pressed_m.distance(last_m) < 0.14e-3, "{last_m} to {pressed_m}");
        last_m = pressed_m;
    }
    assert!(last_m.distance(other_m) < 2e-5, "{last_m}");
    hand.chain.guide(None);
    let lifted =
        (0..1000).take_while(|_| hand.tick(AT_M, Some(other_m)) == Vec3::ZERO && hand.pressed.is_none()).count();
    // samples are joined over a few ticks only: after a tenth of a second nothing is drawn through the clay
    assert!((99..=101).contains(&lifted), "{lifted} ticks");
    assert_eq!(hand.pressed.map(|pressed| pressed.point_m()), Position::nearest(AT_M).map(|at| at.point_m()));
}

#[test]
fn a_teacher_who_is_seen_is_not_felt_and_neither_is_one_without_the_stage() {
    let teacher_m = AT_M + Vec3::Z * 0.02;
    let seen = Hand::guided(Guidance::new(GuidanceMode::Point, 1.0)).ticks(300, AT_M, teacher_m);
    assert_eq!(seen, Vec3::ZERO);
    let setup = Setup::for_device(DeviceSpecs::OMNI, 0.2);
    let stages = Stages { guidance: false, ..Stages::WHOLE };
    let mut hand = Hand { chain: Haptics::new(Setup { stages, ..setup }), tick: 0, pressed: None };
    hand.chain.guide(Some(Guidance::TAKE_OVER));
    assert_eq!((hand.ticks(1000, AT_M, teacher_m), hand.chain.guided()), (Vec3::ZERO, None));
    assert_eq!(hand.pressed, Position::nearest(AT_M));
}

#[test]
fn what_disturbs_is_bounded_and_the_same_every_time_and_errors_are_driven_farther() {
    let forces = |mode| {
        let mut hand = Hand::paid_for(Guidance::new(mode, 1.0));
        (0..3000).map(|_| hand.tick(AT_M, Some(AT_M - Vec3::Z * 0.005))).collect::<Vec<_>>()
    };
    let noise = forces(GuidanceMode::Noise);
    let mean = noise.iter().sum::<Vec3>() / noise.len() as f32;
    let most = noise.iter().map(|force_n| force_n.length()).fold(0.0, f32::max);
    assert!(most > 0.3 && most < 0.25 * DeviceSpecs::OMNI.peak_force_n, "{most} N");
    // two dozen directions in three seconds
    assert!(mean.length() < 0.3 * most, "{mean}");
    assert_eq!(noise, forces(GuidanceMode::Noise));
    let repelled_n = forces(GuidanceMode::Repel)[2999];
    assert!(repelled_n.z > 0.2, "away from a teacher below: {repelled_n}");
}

#[test]
fn whatever_is_heard_of_a_teacher_the_force_stays_a_number_and_a_hand_that_hears_nothing_is_left_alone() {
    for guidance in WAYS.map(|(_, guidance)| guidance) {
        let mut hand = Hand::guided(guidance);
        assert_eq!(hand.tick(AT_M, None), Vec3::ZERO, "nothing was heard yet");
        let odd = [Vec3::NAN, Vec3::splat(f32::INFINITY), Vec3::splat(9.0), Vec3::ZERO, AT_M, -AT_M];
        for place in 0..600 {
            let force_n = hand.tick(AT_M, Some(odd[place % odd.len()]));
            assert!(
                force_n.is_finite() && force_n.length() <= DeviceSpecs::OMNI.peak_force_n,
                "{guidance:?}: {force_n}"
            );
        }
        // half a second of silence, and what was felt is gone
        let felt: Vec<_> = (0..700).map(|_| hand.tick(AT_M, None)).collect();
        assert_eq!(felt[600..].iter().copied().sum::<Vec3>(), Vec3::ZERO, "{guidance:?}");
    }
    assert_eq!(Guidance::new(GuidanceMode::Lead, f32::NAN).strength(), 0.0);
    assert_eq!(Guidance::new(GuidanceMode::Lead, 7.0).strength(), 1.0);
    let numbers = GuidanceMode::ALL.map(|mode| GuidanceMode::from_number(mode.number()));
    assert_eq!(numbers, GuidanceMode::ALL.map(Some));
    assert_eq!(GuidanceMode::from_number(5), None);
}

#[test]
fn who_leads_feels_the_damper_that_pays_for_it() {
    let mut chain = Haptics::new(Setup::for_device(DeviceSpecs::OMNI, 0.2));
    chain.lead(true);
    let mut force_n = Vec3::ZERO;
    for tick in 0..500_u16 {
        // 50 mm/s upwards
        let centre = chain.accept(Some(AT_M + Vec3::Z * 5e-5 * f32::from(tick)), None, DT);
        force_n = centre.map_or(Vec3::ZERO, |centre| chain.render(&Touch { centre, ..Touch::default() }));
    }
    // 4 N·s/m; steps of the encoder make the speed uneven
    assert!((force_n.z + 0.2).abs() < 0.08 && force_n.truncate().length() < 1e-6, "{force_n}");
}

#[test]
fn program_prints_and_writes_every_way_of_guiding_in_every_hand() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("guidance-program");
    let mut command = Command::new(program("accuracy-chart"));
    let output = command.arg("guidance").arg("--out").arg(&folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = std::fs::read_to_string(folder.join("guidance.csv")).unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap(), table);
    assert_eq!(table.lines().count(), 1 + WAYS.len() * 3 * 2);
    assert!(std::fs::metadata(folder.join("guidance.png")).unwrap().len() > 10_000);
}
