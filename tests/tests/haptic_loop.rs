//! The hand's 1000 ticks a second: what a tick may not do (allocate, wait), and what it gives to the hand when device or
//! clay make no sense.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::HapticLoop;
use pottery_client::boundary::{GuideNews, NetSide, boundary};
use pottery_client::device::{
    Axes, Calibration, Device, DeviceFault, DrivenDevice, Driver, Fit, Pace, Port, Reading, Reported, pointer,
};
use pottery_client::sound::Rub;
use pottery_shared::clay::{Conditions, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Support, Surface, Wheel};
use pottery_shared::haptics::{DeviceSpecs, Fault, Guidance, GuidanceMode, Haptics, Setup, Stages};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample, rack};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::allocations::{Counting, requests};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// What the test puts in the hand and what the hand feels.
#[derive(Debug, Default)]
struct Held {
    position_m: Option<Vec3>,
    force_n: Vec3,
    tool: Tool,
    orientation: Orientation,
}

struct TestDevice {
    held: Arc<Mutex<Held>>,
    specs: DeviceSpecs,
    stages: Stages,
}

impl Device for TestDevice {
    fn position(&mut self, _: f64) -> Option<Vec3> {
        self.held.lock().unwrap().position_m
    }

    fn tool(&self) -> Tool {
        self.held.lock().unwrap().tool
    }

    fn orientation(&self) -> Orientation {
        self.held.lock().unwrap().orientation
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.held.lock().unwrap().force_n = force_n;
    }

    fn specs(&self) -> DeviceSpecs {
        self.specs
    }

    fn setup(&self, _: f32) -> Setup {
        Setup { stages: self.stages, felt_share: 1.0, ..Setup::for_device(self.specs, 1.0) }
    }
}

/// A hand, its device and the network's end, ticked by the test.
struct Bench {
    hand: HapticLoop,
    net: NetSide,
    held: Arc<Mutex<Held>>,
    local: u64,
}

impl Bench {
    /// The tool is pressed where the test puts it, and what the clay answers is felt.
    fn new(specs: DeviceSpecs, method: MethodKind) -> Self {
        Self::with_stages(specs, method, Stages::EXACT)
    }

    fn with_stages(specs: DeviceSpecs, method: MethodKind, stages: Stages) -> Self {
        let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
        Self::at_clay(specs, Conditions { wheel, method, ..Conditions::default() }, stages)
    }

    fn at_clay(specs: DeviceSpecs, conditions: Conditions, stages: Stages) -> Self {
        Self::at_pot(PotSpec::default(), specs, conditions, stages)
    }

    fn at_pot(spec: PotSpec, specs: DeviceSpecs, conditions: Conditions, stages: Stages) -> Self {
        let field = Field::new(Pot::new(spec).unwrap(), Tick(0));
        let (side, net) = boundary(&Patch { field, conditions, rack: rack::standard() });
        let held = Arc::new(Mutex::new(Held::default()));
        let device = TestDevice { held: Arc::clone(&held), specs, stages };
        Self { hand: HapticLoop::new(Box::new(device), side), net, held, local: 0 }
    }

    /// Does a tick with the tool somewhere and returns the force on the hand.
    fn tick(&mut self, position_m: Option<Vec3>) -> Vec3 {
        self.local += 1;
        self.held.lock().unwrap().position_m = position_m;
        self.hand.tick(self.local);
        self.held.lock().unwrap().force_n
    }

    fn fault(&self) -> Option<Fault> {
        self.net.status().fault()
    }
}

const STRONG: DeviceSpecs = DeviceSpecs { peak_force_n: 1000.0, continuous_force_n: None, ..DeviceSpecs::OMNI };

/// A tool 3 mm in the clay that moves slowly up and down.
fn pressing(tick: u64) -> Vec3 {
    Vec3::new(0.069, 0.0, 0.1 + 0.03 * (tick as f32 * 2e-3).sin())
}

#[test]
fn allocator_is_counted() {
    // one to take it and one to give it back
    assert_eq!(requests(|| drop(std::hint::black_box(Box::new(7)))), 2);
}

#[test]
fn tick_allocates_nothing() {
    let methods = [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic];
    for (method, stages) in methods.into_iter().flat_map(|method| [(method, Stages::EXACT), (method, Stages::WHOLE)]) {
        let mut bench = Bench::with_stages(DeviceSpecs::OMNI, method, stages);
        let mut touching = 0;
        for tick in 0..3000 {
            // pressed, lifted now and then, at times at a place that makes no sense
            let position = match tick % 500 {
                490..495 => None,
                495 => Some(Vec3::NAN),
                _ => Some(pressing(tick)),
            };
            if tick % 16 == 3 {
                // a teacher takes over, leads and lets go
                let mode = GuidanceMode::ALL[(tick / 300) as usize % 5];
                bench.net.tell(GuideNews::Guided((tick % 900 > 99).then_some(Guidance::new(mode, 1.0))));
                bench.net.tell(GuideNews::Teacher(Tick(bench.local), pressing(tick + 50)));
            }
            if tick % 100 == 7 {
                let through = Tick(bench.local.saturating_sub(20));
                bench.net.publish(|patch| patch.field = Field::new(Pot::new(PotSpec::default()).unwrap(), through));
            }
            let mut force = Vec3::ZERO;
            let asked = requests(|| force = bench.tick(position));
            assert_eq!(asked, 0, "{method:?}: tick {tick}");
            touching += u32::from(bench.net.status().elements() > 0);
            while bench.net.next_sample().is_some() {}
        }
        assert!(touching > 2000, "{method:?}: {touching} ticks in the clay");
    }
}

#[test]
fn tick_at_a_wall_that_others_hold_allocates_nothing() {
    let spec = PotSpec { support: Support::Hollow, ..PotSpec::default() };
    let mut bench = Bench::at_pot(spec, DeviceSpecs::OMNI, Conditions::default(), Stages::WHOLE);
    let mut forces_n = [0.0; 2];
    for tick in 0..1500_u64 {
        if tick % 100 == 7 {
            let through = Tick(bench.local.saturating_sub(20));
            let others = (0..tick / 300).map(|other| ToolSample {
                tick: through,
                tool: Tool::default(),
                orientation: Orientation::default(),
                centre: Position::nearest(Vec3::new(0.0402, 0.004 * other as f32, 0.1)).unwrap(),
                side: Side::Inside,
            });
            bench.net.publish(|patch| {
                patch.field = Field::new(Pot::new(spec).unwrap(), through);
                patch.field.set_beside(others);
            });
        }
        let mut force = Vec3::ZERO;
        let asked = requests(|| force = bench.tick(Some(Vec3::new(0.069, 0.0, 0.1))));
        assert_eq!(asked, 0, "tick {tick}");
        forces_n[usize::from(tick > 300)] = force.x;
        while bench.net.next_sample().is_some() {}
    }
    println!("{forces_n:.2?} N alone and with four fingers inside");
    assert!(forces_n[0] > 0.05 && forces_n[1] > 1.5 * forces_n[0], "{forces_n:?} N");
}

#[test]
fn tick_with_a_rib_that_turns_allocates_nothing() {
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        let mut bench = Bench::new(DeviceSpecs::OMNI, method);
        let mut touching = 0;
        for tick in 0..1500 {
            let time = tick as f32 * 1e-3;
            {
                let mut held = bench.held.lock().unwrap();
                held.tool = Tool::Convex(if tick % 300 < 250 { Shape::RIB } else { Shape::LOOP });
                held.orientation = Orientation::nearest([(5.0 * time).sin(), 0.2 * time, time]).unwrap();
            }
            if tick % 100 == 7 {
                let through = Tick(bench.local.saturating_sub(20));
                bench.net.publish(|patch| patch.field = Field::new(Pot::new(PotSpec::default()).unwrap(), through));
            }
            let asked = requests(|| {
                bench.tick(Some(pressing(tick)));
            });
            assert_eq!(asked, 0, "{method:?}: tick {tick}");
            touching += u32::from(bench.net.status().elements() > 0);
            while let Some(sample) = bench.net.next_sample() {
                assert!(sample.tool.sphere().is_none(), "tick {tick}");
            }
        }
        assert!(touching > 1000, "{method:?}: {touching} ticks in the clay");
    }
}

#[test]
fn a_tool_that_has_not_come_to_the_hand_is_not_in_it() {
    let mut bench = Bench::new(STRONG, MethodKind::Plastic);
    settle(&mut bench);
    while bench.net.next_sample().is_some() {}
    bench.held.lock().unwrap().tool = Tool::Convex(Shape(4));
    for _ in 0..20 {
        assert_eq!(bench.tick(Some(pressing(0))), Vec3::ZERO);
        assert_eq!((bench.fault(), bench.net.status().tool_m()), (None, None));
    }
    assert_eq!(bench.net.next_sample(), None);
    bench.held.lock().unwrap().tool = Tool::default();
    assert!(bench.tick(Some(pressing(0))).length() > 0.1);
}

/// Publishes a reading a millisecond and hears the force.
struct Busy;

impl Driver for Busy {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        port.found("busy".into(), Reported::default());
        let mut pace = Pace::new();
        while !port.is_closing() {
            let position_m = port.force_n() * 1e-3;
            port.publish(Reading { position_m, velocity_m_s: Some(Vec3::X), buttons: 1 });
            pace.wait();
        }
        Ok(())
    }
}

#[test]
fn device_with_a_driver_allocates_nothing_in_the_tick() {
    let calibration = Calibration::new(Axes::YUp, Vec3::ZERO);
    let fit = Fit { middle_m: Vec3::ZERO, scale: 2.0 };
    let mut device = DrivenDevice::open(Busy, calibration, DeviceSpecs::OMNI, pointer().1).unwrap();
    let monitor = device.monitor();
    let (mut heard, mut tick) = (0, 0);
    let begin = Instant::now();
    while heard < 200 {
        assert!(begin.elapsed() < Duration::from_secs(30), "{heard} readings");
        let seconds = begin.elapsed().as_secs_f64();
        tick += 1;
        let mut place = None;
        let asked = requests(|| {
            match tick % 50 {
                7 => monitor.fit_to(fit),
                17 => monitor.set_fitting(true),
                27 => monitor.set_fitting(false),
                _ => {}
            }
            place = device.position(seconds);
            device.set_rub(Rub { force_n: 1.0, slip_m_s: 0.1, wetness: 0.3 });
            device.set_force(Vec3::splat(device.velocity().map_or(0.0, |velocity| velocity.x)));
            std::hint::black_box((device.buttons(), device.tool(), device.orientation()));
        });
        assert_eq!(asked, 0);
        heard += u32::from(place.is_some());
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn handing_over_clay_allocates_nothing() {
    let shape = PotSpec::default().shape;
    let mut source = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
    let mut target = source.clone();
    let sample = ToolSample {
        tick: Tick(5),
        tool: Tool::default(),
        orientation: Orientation::default(),
        centre: pottery_shared::tool::Position::nearest(pressing(0)).unwrap(),
        side: Side::Outside,
    };
    source.press(&sample, &Conditions::default(), &mut SubStep::for_grid(shape), None);
    assert!(source.pot() != target.pot());
    assert_eq!(requests(|| target.copy_from(&source)), 0);
    assert!(source.pot() == target.pot() && source.through() == target.through());
    // what is not rounded yet is rounded by both at the next snapshot
    source.advance(Tick(100));
    target.advance(Tick(100));
    assert!(source.pot() == target.pot());
}

/// A hand that starts from rest this far from still clay with this acceleration, m and m/s²: what it feels, tick by tick from the start on.
fn starting(gap_m: f32, acceleration_m_s2: f32, from: u64, rests: bool) -> (Vec<(u64, f32)>, Vec<f32>) {
    let mut bench = Bench::at_clay(STRONG, Conditions::default(), Stages::EXACT);
    let rest_m = Vec3::new(PotSpec::default().radius.0 + Sphere::default().radius().0 + gap_m, 0.0, 0.1);
    let mut felt = Vec::new();
    while bench.local < from + 25 {
        if rests && bench.hand.is_idle() {
            bench.local += HapticLoop::IDLE_TICKS - 1;
        }
        let seconds = (bench.local + 1).saturating_sub(from) as f32 * 1e-3;
        // as the device would report it, or not move at all
        let at_m = rest_m - Vec3::X * (0.5 * acceleration_m_s2 * seconds * seconds).min(gap_m + 0.002);
        let force_n = bench.tick(Some(at_m));
        if bench.local >= from {
            felt.push((bench.local, force_n.length()));
        }
        while bench.net.next_sample().is_some() {}
    }
    let radii_m = bench.hand.hand().field().pot().surfaces()[0].radii_m().to_vec();
    (felt, radii_m)
}

#[test]
fn first_contact_of_a_hand_that_rested_is_felt_as_that_of_one_that_did_not() {
    // as fast as a hand can start; from touching the clay almost to farther than it comes while the loop rests
    for (gap_m, acceleration_m_s2) in [(20e-6, 50.0), (100e-6, 50.0), (400e-6, 50.0), (2e-3, 50.0), (100e-6, 5.0)] {
        for from in 1200..1200 + HapticLoop::IDLE_TICKS {
            let (awake, one) = starting(gap_m, acceleration_m_s2, from, false);
            let (rested, other) = starting(gap_m, acceleration_m_s2, from, true);
            assert!(rested.len() < awake.len(), "it did not rest");
            // the clay yields as fast as it is pressed, which is all that is left of the difference
            for (tick, force_n) in &rested {
                let (_, as_awake_n) = awake.iter().find(|(other, _)| other == tick).unwrap();
                assert!((force_n - as_awake_n).abs() <= 1e-3 * as_awake_n, "{gap_m} m: {rested:?} and {awake:?}");
            }
            // nor does it come as a greater jump
            let jump_n = |felt: &[(u64, f32)]| felt.windows(2).map(|two| two[1].1 - two[0].1).fold(0.0, f32::max);
            assert!(jump_n(&rested) <= 1.001 * jump_n(&awake), "{gap_m} m: {rested:?} and {awake:?}");
            let apart_m: Vec<f32> = one.iter().zip(&other).map(|(one, other)| (one - other).abs()).collect();
            let most_m = apart_m.iter().copied().fold(0.0, f32::max);
            // what lies a hair beside the middle between two steps may be rounded to either
            let pressed = one.iter().filter(|radius_m| **radius_m != PotSpec::default().radius.0).count();
            let rounded = apart_m.iter().filter(|apart_m| **apart_m >= 1e-6).count();
            assert!(
                most_m < Surface::STEP_M + 1e-6 && rounded * 200 < pressed,
                "{gap_m} m, tick {from}: {rounded} of {pressed} elements are up to {most_m} m apart"
            );
            let mean_m = apart_m.iter().sum::<f32>() / pressed as f32;
            assert!(mean_m < 10e-9, "{gap_m} m, tick {from}: the pots are {mean_m} m apart on average");
        }
    }
}

#[test]
fn a_tool_that_rests_is_told_of_four_times_a_second_and_goes_on_from_where_it_rested() {
    for every in [1, HapticLoop::IDLE_TICKS] {
        let mut bench = Bench::at_clay(STRONG, Conditions::default(), Stages::EXACT);
        let rest_m = Vec3::new(PotSpec::default().radius.0 + Sphere::default().radius().0 + 1e-3, 0.0, 0.1);
        let mut told = Vec::new();
        while bench.local < 2003 {
            if bench.hand.is_idle() {
                bench.local += every - 1;
            }
            assert_eq!(requests(|| _ = bench.tick(Some(rest_m))), 0, "it allocates");
            told.extend(std::iter::from_fn(|| bench.net.next_sample()));
        }
        assert!(told.windows(2).all(|two| two[1].tick.since(two[0].tick) <= 253), "it falls silent");
        let rests = told.iter().filter(|sample| (1001..=2000).contains(&sample.tick.0)).count();
        assert!((3..=4).contains(&rests), "{rests} samples in a second");

        let last = *told.last().unwrap();
        bench.held.lock().unwrap().tool = Sphere::of_micrometres(9_000).unwrap().into();
        bench.local += every - 1;
        bench.tick(Some(rest_m));
        let changed: Vec<_> = std::iter::from_fn(|| bench.net.next_sample()).collect();
        assert!(changed.iter().any(|sample| sample.tool != last.tool), "another tool is told of at once");
        bench.held.lock().unwrap().tool = last.tool;
        bench.tick(Some(rest_m));
        assert_eq!(bench.net.next_sample().map(|sample| sample.tool), Some(last.tool));
        bench.tick(Some(rest_m));
        assert!(bench.net.next_sample().is_none(), "it rests on");

        bench.local += every - 1;
        bench.tick(Some(rest_m - Vec3::X * 2e-3));
        let [rested, moved] = [0; 2].map(|_| bench.net.next_sample().unwrap());
        assert!(rested.centre == last.centre && moved.centre != last.centre && moved.follows(&rested), "{moved:?}");
        assert!(bench.net.next_sample().is_none() && bench.hand.hand().field().pot().digest() != 0);
        // and from then on it tells of every tick
        bench.tick(Some(rest_m - Vec3::X * 2e-3));
        assert!(bench.net.next_sample().is_some_and(|sample| sample.follows(&moved)));
    }
}

#[test]
fn what_the_hand_pressed_is_what_it_sends() {
    for (method, stages) in [(MethodKind::Improved, Stages::EXACT), (MethodKind::Plastic, Stages::WHOLE)] {
        let mut bench = Bench::with_stages(STRONG, method, stages);
        let mut mirror = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
        let conditions = Conditions {
            wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0))),
            method,
            ..Conditions::default()
        };
        let mut substep = SubStep::for_grid(PotSpec::default().shape);
        for tick in 0..400 {
            bench.tick(Some(pressing(tick)));
            let sample = bench.net.next_sample().unwrap();
            assert_eq!(sample.tick, Tick(bench.local));
            mirror.press(&sample, &conditions, &mut substep, None);
            assert!(bench.net.next_sample().is_none());
        }
        assert_eq!(bench.hand.hand().field().pot().digest(), mirror.pot().digest(), "{method:?}");
    }
}

#[test]
fn force_is_the_same_to_the_bit_with_a_network_of_200_ms_and_5_percent_loss_and_with_none() {
    let conditions =
        Conditions { wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0))), ..Conditions::default() };
    let [mut near, mut far] =
        [(); 2].map(|()| Bench::with_stages(DeviceSpecs::OMNI, MethodKind::Plastic, Stages::WHOLE));
    // what the server has made of the samples comes back a round trip later, sixty times a second, and not always
    let mut confirmed = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
    let mut substep = SubStep::for_grid(PotSpec::default().shape);
    let mut sent = std::collections::VecDeque::new();
    let mut dice = pottery_tests::dice::Dice::new(0x200);
    let (mut felt, mut arrived) = (0, 0);
    for tick in 0..3000 {
        let forces = [near.tick(Some(pressing(tick))), far.tick(Some(pressing(tick)))];
        assert_eq!(forces[0].to_array().map(f32::to_bits), forces[1].to_array().map(f32::to_bits), "tick {tick}");
        felt += u32::from(forces[0].length() > 0.1);
        near.net.next_sample().unwrap();
        sent.push_back(far.net.next_sample().unwrap());
        if sent.len() > 200 {
            confirmed.press(&sent.pop_front().unwrap(), &conditions, &mut substep, None);
        }
        if tick % 17 == 0 && tick > 200 && !dice.chance(0.05) {
            far.net.publish(|patch| patch.field.copy_from(&confirmed));
            arrived += 1;
        }
    }
    assert!(felt > 2500 && arrived > 100, "{felt} ticks in the clay, {arrived} corrections");
}

#[test]
fn hand_comes_to_corrected_clay_with_its_own_latest_samples_on_it() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    let conditions = Conditions {
        wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0))),
        method: MethodKind::Original,
        ..Conditions::default()
    };
    let mut substep = SubStep::for_grid(PotSpec::default().shape);
    // what somebody else did to the clay, which the hand does not know
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let press = Press { turning: 1, response: 0.5, ..Press::held(Sphere::default(), Vec3::new(-0.069, 0.0, 0.05)) };
    substep.advance(&mut pot, &[press], MethodKind::Original, |_, _| {});
    let mut corrected = Field::new(pot, Tick(300));
    let mut late = Vec::new();
    for tick in 0..340 {
        bench.tick(Some(pressing(tick)));
        late.extend(bench.net.next_sample().filter(|sample| sample.tick > Tick(300)));
    }
    assert_eq!(late.len(), 40);
    bench.net.publish(|patch| patch.field.copy_from(&corrected));
    for tick in 340..370 {
        bench.tick(Some(pressing(tick)));
        late.push(bench.net.next_sample().unwrap());
    }
    for sample in &late {
        corrected.press(sample, &conditions, &mut substep, None);
    }
    // 40 samples behind, it gains at least three a tick
    assert_eq!(bench.hand.hand().field().pot().digest(), corrected.pot().digest());
}

/// Presses until the force is steady and returns it.
fn settle(bench: &mut Bench) -> f32 {
    let force = (0..200).map(|_| bench.tick(Some(pressing(0)))).last().unwrap();
    assert!(force.length() > 0.1, "{force} N");
    assert_eq!(bench.fault(), None);
    force.length()
}

/// Does as many sound ticks as a fault lasts: no force until the last of them, then the force is back.
fn assert_recovers(bench: &mut Bench, position_m: Vec3, fault: Fault, before_n: f32) {
    for tick in 1..Haptics::RECOVERY_TICKS {
        let force = bench.tick(Some(position_m));
        assert_eq!((force, bench.fault()), (Vec3::ZERO, Some(fault)), "sound tick {tick} after it");
    }
    let force = bench.tick(Some(position_m)).length();
    assert_eq!(bench.fault(), None);
    assert!(force > 0.1 && force <= before_n * 1.5, "{force} N, {before_n} N before the fault");
}

#[test]
fn place_that_makes_no_sense_turns_the_force_off_until_places_are_sound_again() {
    let nowhere = [
        Vec3::NAN,
        Vec3::new(0.069, f32::NAN, 0.1),
        Vec3::splat(f32::INFINITY),
        Vec3::new(0.069, 0.0, f32::NEG_INFINITY),
        Vec3::new(1.001, 0.0, 0.1),
        Vec3::splat(f32::MAX),
    ];
    for odd in nowhere {
        let mut bench = Bench::new(STRONG, MethodKind::Original);
        let before_n = settle(&mut bench);
        let clay = bench.hand.hand().field().pot().digest();
        for _ in 0..3 {
            assert_eq!(bench.tick(Some(odd)), Vec3::ZERO, "{odd}");
            assert_eq!(bench.fault(), Some(Fault::Position), "{odd}");
            assert_eq!((bench.net.status().force_n(), bench.net.status().elements()), (0.0, 0));
        }
        // the fault's ticks press nothing
        let through = bench.hand.hand().field().through();
        assert!(through < Tick(bench.local) && bench.hand.hand().field().pot().digest() == clay);
        assert_recovers(&mut bench, pressing(0), Fault::Position, before_n);
    }
}

#[test]
fn jump_turns_the_force_off_until_the_tool_moves_like_a_hand_again() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    let before_n = settle(&mut bench);
    let elsewhere = pressing(0) + Vec3::new(0.0, 0.0, 0.05);
    assert_eq!(bench.tick(Some(elsewhere)), Vec3::ZERO);
    assert_eq!(bench.fault(), Some(Fault::Jump));
    // fresh clay there, so the force is that of the first touch
    assert_recovers(&mut bench, elsewhere, Fault::Jump, before_n.max(STRONG.peak_force_n));
    // a fast hand is no jump
    let step = Vec3::new(0.0, 0.0, 0.9 * Haptics::JUMP_M);
    for tick in 1..8_u8 {
        bench.tick(Some(elsewhere - step * f32::from(tick)));
        assert_eq!(bench.fault(), None, "step {tick}");
    }
}

#[test]
fn device_that_disappears_gives_no_force_until_it_is_back() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    let before_n = settle(&mut bench);
    for _ in 0..50 {
        assert_eq!(bench.tick(None), Vec3::ZERO);
        // a tool put aside is no fault, and not pressed
        assert_eq!((bench.fault(), bench.net.status().tool_m()), (None, None));
    }
    let force = bench.tick(Some(pressing(0))).length();
    assert!(force > 0.1 && force <= before_n * 1.5, "{force} N, {before_n} N before");
}

#[test]
fn lifted_tool_feels_nothing() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    settle(&mut bench);
    bench.net.status().lift(true);
    assert_eq!(bench.tick(Some(pressing(0))), Vec3::ZERO);
    bench.net.status().lift(false);
    assert!(bench.tick(Some(pressing(0))).length() > 0.1);
}

#[test]
fn switched_off_the_force_is_gone_at_the_next_tick_and_comes_back_by_the_ramp() {
    let mut bench = Bench::with_stages(DeviceSpecs::OMNI, MethodKind::Plastic, Stages::WHOLE);
    let before_n = (0..400).map(|tick| bench.tick(Some(pressing(tick)))).last().unwrap().length();
    assert!(before_n > 1.0, "{before_n} N");
    while bench.net.next_sample().is_some() {}
    bench.net.status().switch_force_off(true);
    for tick in 400..700 {
        assert_eq!(bench.tick(Some(pressing(tick))), Vec3::ZERO, "tick {tick}");
        // the tool stays in the clay, and everybody sees it
        assert!(bench.fault().is_none() && bench.net.status().elements() > 0, "tick {tick}");
        assert!(bench.net.next_sample().is_some() && bench.net.status().tool_m().is_some(), "tick {tick}");
        assert!(bench.net.status().is_force_off() && bench.net.status().force_n() == 0.0);
    }
    bench.net.status().switch_force_off(false);
    let mut given = Vec3::ZERO;
    for tick in 700..1100 {
        let force = bench.tick(Some(pressing(tick)));
        // 100 N/s, and what an `f32` of some newtons rounds
        assert!((force - given).length() <= 0.1 + 1e-5, "tick {tick}: {force} N after {given} N");
        given = force;
    }
    assert!(given.length() > 0.5 * before_n, "{given} N, {before_n} N before");
}

#[test]
fn what_is_heard_follows_the_slip_and_goes_on_without_force() {
    let mut bench = Bench::with_stages(DeviceSpecs::OMNI, MethodKind::Plastic, Stages::WHOLE);
    bench.tick(Some(Vec3::new(0.1, 0.0, 0.1)));
    assert_eq!(bench.net.status().rub(), Rub::default());
    bench.tick(None);
    let mut slip_m_s = 0.0;
    for tick in 0..300 {
        bench.tick(Some(pressing(tick)));
        if tick >= 200 {
            slip_m_s += bench.net.status().rub().slip_m_s / 100.0;
        }
    }
    let held = bench.net.status().rub();
    // 60 rpm at some 70 mm, and the tool goes up at 50 mm/s; from tick to tick it is up to a seventh more or less
    assert!(held.force_n > 0.5 && (0.43..0.46).contains(&slip_m_s), "{held:?}, slip {slip_m_s} m/s");
    assert!((held.slip_m_s / slip_m_s - 1.0).abs() < 0.2, "{held:?}, slip {slip_m_s} m/s");
    assert!((held.wetness - 0.27).abs() < 1e-3, "{held:?}");
    bench.net.status().switch_force_off(true);
    bench.tick(Some(pressing(300)));
    assert!(bench.net.status().rub().force_n > 0.5 && bench.net.status().force_n() == 0.0);
    // a tool that goes round with the clay does not rub it
    for tick in 0..300 {
        let angle = tick as f32 * 1e-3 * std::f32::consts::TAU;
        bench.tick(Some(Vec3::new(0.069 * angle.cos(), 0.069 * angle.sin(), 0.1)));
    }
    let along = bench.net.status().rub();
    // places are rounded to 10 µm, which is 10 mm/s in a tick
    assert!(along.slip_m_s < 0.05 && bench.net.status().elements() > 0, "{along:?}");
}

#[test]
fn too_large_a_force_is_shortened_and_keeps_its_direction() {
    let weak = DeviceSpecs { peak_force_n: 0.3, ..STRONG };
    let (mut strong, mut limited) = (Bench::new(STRONG, MethodKind::Improved), Bench::new(weak, MethodKind::Improved));
    let mut shortened = 0;
    for tick in 0..1000 {
        let depth = 0.004 * (tick as f32 * 5e-3).sin();
        let position = Some(pressing(tick) - Vec3::new(depth, 0.0, 0.0));
        let (full, found) = (strong.tick(position), limited.tick(position));
        // both forces are of f32, so their lengths are known to 1e-7 of themselves
        let peak = weak.peak_force_n * (1.0 + 1e-6);
        assert!(found.length() <= peak, "tick {tick}: {} N", found.length());
        if full.length() > weak.peak_force_n {
            shortened += 1;
            assert!(found.length() > weak.peak_force_n * 0.999, "tick {tick}: {found} N of {full} N");
            assert!(found.normalize().dot(full.normalize()) > 1.0 - 1e-6, "tick {tick}: {found} N of {full} N");
        } else {
            assert_eq!(found, full, "tick {tick}");
        }
    }
    assert!((100..1000).contains(&shortened), "{shortened} ticks beyond the peak");
}

#[test]
fn device_without_limits_gives_no_force_and_the_session_goes_on() {
    for peak_force_n in [0.0, f32::NAN, -3.3, f32::INFINITY] {
        let mut bench = Bench::new(DeviceSpecs { peak_force_n, ..STRONG }, MethodKind::Original);
        for tick in 0..200 {
            assert_eq!(bench.tick(Some(pressing(tick))), Vec3::ZERO, "{peak_force_n} N");
            assert_eq!(bench.fault(), Some(Fault::Specs));
        }
    }
}

#[test]
fn force_pushes_out_of_the_clay() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    let force = bench.tick(Some(pressing(0)));
    assert!(force.x > 0.0, "{force} N");
}

#[test]
fn full_ring_loses_samples_without_force_and_counts_them() {
    let mut bench = Bench::new(STRONG, MethodKind::Original);
    let in_the_air = Vec3::new(0.3, 0.0, 0.1);
    let mut pressed = 0;
    for _ in 0..5000 {
        bench.tick(Some(in_the_air));
        pressed += 1;
    }
    let lost = bench.net.status().lost_samples();
    let mut fetched = 0;
    while bench.net.next_sample().is_some() {
        fetched += 1;
    }
    assert_eq!((fetched + lost, bench.net.status().ticks()), (pressed, pressed));
    assert!(lost > 0, "the ring never filled");
    // what was lost is not pressed either, or the hand would feel what nobody else sees
    assert_eq!(bench.hand.hand().field().through(), Tick(fetched));
}
