//! The hand's loop at 1 to 10 kHz: the ticks stay what they are, and between them the force follows the device.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::{Arc, Mutex};

use glam::Vec3;
use pottery_client::boundary::{NetSide, boundary};
use pottery_client::device::{Device, HandModel, SimulatedDevice};
use pottery_client::stroke::Stroke;
use pottery_client::{HapticLoop, LoopRate};
use pottery_shared::clay::{Conditions, Method, MethodKind, Phase, Pot, PotSpec, Wheel};
use pottery_shared::haptics::{DeviceSpecs, Setup};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::{Orientation, Tool, rack};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::allocations::{Counting, requests};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const THOUSANDS: [u64; 5] = [1, 2, 4, 8, 10];

fn rate(thousands: u64) -> LoopRate {
    (thousands * 1000).to_string().parse().unwrap()
}

/// Where a hand was and what it felt, turn by turn.
#[derive(Debug, Default)]
struct Noted {
    places_m: Vec<Vec3>,
    forces_n: Vec<Vec3>,
}

/// A device that notes what goes through it.
struct Noting {
    within: SimulatedDevice,
    noted: Arc<Mutex<Noted>>,
}

impl Device for Noting {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let place_m = self.within.position(seconds);
        self.noted.lock().unwrap().places_m.extend(place_m);
        place_m
    }

    fn tool(&self) -> Tool {
        self.within.tool()
    }

    fn orientation(&self) -> Orientation {
        self.within.orientation()
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.noted.lock().unwrap().forces_n.push(force_n);
        self.within.set_force(force_n);
    }

    fn specs(&self) -> DeviceSpecs {
        self.within.specs()
    }

    fn setup(&self, share_of_small: f32) -> Setup {
        self.within.setup(share_of_small)
    }
}

/// A hand that means to go 20 mm in within half a second and holds on there.
const HOLDS_ON: &str = "t_s,x_mm,y_mm,z_mm\n0,74,0,100\n0.5,52,0,100\n4,52,0,110\n";

fn pressed_by_a_hand(method: MethodKind, thousands: u64) -> (HapticLoop, NetSide, Arc<Mutex<Noted>>) {
    pressed(method, thousands, HandModel::default(), HOLDS_ON)
}

/// On a wheel of 60 rpm.
fn pressed(
    method: MethodKind,
    thousands: u64,
    hand: HandModel,
    stroke: &str,
) -> (HapticLoop, NetSide, Arc<Mutex<Noted>>) {
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method, ..Conditions::default() };
    let spec = PotSpec { keeps_volume: method.keeps_volume(), ..PotSpec::default() };
    let field = Field::new(Pot::new(spec).unwrap(), Tick(0));
    let (side, net) = boundary(&Patch { field, conditions, rack: rack::standard() });
    let stroke = Stroke::parse(stroke).unwrap();
    let noted = Arc::new(Mutex::new(Noted::default()));
    let within = SimulatedDevice::new(Arc::new(stroke), hand);
    let device = Noting { within, noted: Arc::clone(&noted) };
    (HapticLoop::new(Box::new(device), side).at(rate(thousands)), net, noted)
}

#[test]
fn the_clay_is_the_same_at_every_rate_and_the_force_follows_the_hand() {
    for method in [MethodKind::Plastic, MethodKind::Original] {
        let mut at_a_thousand = None;
        for thousands in THOUSANDS {
            let (mut hand, mut net, noted) = pressed_by_a_hand(method, thousands);
            let mut samples = 0;
            for turn in 1..=3000 * thousands {
                hand.turn(turn);
                let sent = std::iter::from_fn(|| net.next_sample()).count();
                // a sample a tick, and none between two
                assert_eq!(sent, usize::from(turn % thousands == 0), "{method:?} at {thousands} kHz: turn {turn}");
                samples += sent;
            }
            let dented_m3 = hand.hand().field().pot().surfaces()[0]
                .radii_m()
                .iter()
                .map(|radius_m| f64::from(0.06 - radius_m).max(0.0))
                .sum::<f64>();
            let noted = noted.lock().unwrap();
            assert_eq!((samples, noted.forces_n.len()), (3000, 3000 * thousands as usize));
            let last = noted.forces_n.len() / 3;
            let mean_n =
                |forces: &[Vec3]| forces.iter().map(|force| f64::from(force.x)).sum::<f64>() / forces.len() as f64;
            let force_n = mean_n(&noted.forces_n[2 * last..]);
            assert!(force_n > 0.5, "{method:?} at {thousands} kHz: the hand feels {force_n} N");
            let (dented, felt) = *at_a_thousand.get_or_insert((dented_m3, force_n));
            println!("{method:?} at {thousands} kHz: dented {:.4}, force {:.4}", dented_m3 / dented, force_n / felt);
            // what is wanted of a loop: 2 %
            assert!((dented_m3 / dented - 1.0).abs() < 0.02, "{method:?} at {thousands} kHz: {dented_m3} and {dented}");
            assert!((force_n / felt - 1.0).abs() < 0.02, "{method:?} at {thousands} kHz: {force_n} N and {felt} N");
        }
    }
}

/// Where round the pot two dents lie, in turns from one to the other against the wheel: from the deepest place of each, the middle of what
/// lies within a sixth of a turn.
fn turns_between(hand: &HapticLoop) -> f64 {
    let surface = &hand.hand().field().pot().surfaces()[0];
    let columns = surface.shape().columns();
    let dent = |column: u32| surface.column_m(column).iter().map(|radius_m| f64::from(0.06 - radius_m).max(0.0)).sum();
    let dents: Vec<f64> = (0..columns).map(dent).collect();
    let near = i64::from(columns) / 6;
    let around = |middle: u32, by: i64| (i64::from(middle) + by).rem_euclid(columns.into()) as usize;
    let deepest = |left_out: Option<u32>| {
        let is_left_out =
            |column: u32| left_out.is_some_and(|middle| (-near..=near).any(|by| around(middle, by) == column as usize));
        (0..columns)
            .filter(|&column| !is_left_out(column))
            .max_by(|&a, &b| dents[a as usize].total_cmp(&dents[b as usize]))
            .unwrap()
    };
    let middle = |deepest: u32| {
        let (weights, moments) = (-near..=near).fold((0.0, 0.0), |(weights, moments), by| {
            let dent = dents[around(deepest, by)];
            (weights + dent, moments + dent * by as f64)
        });
        assert!(weights > 0.0, "there is no dent");
        f64::from(deepest) + moments / weights
    };
    let first = deepest(None);
    let apart = (middle(first) - middle(deepest(Some(first)))) / f64::from(columns);
    // three quarters of a turn one way are one quarter the other
    1.0 - apart.rem_euclid(1.0).min((-apart).rem_euclid(1.0))
}

#[test]
fn the_wheel_turns_as_far_between_two_presses_at_every_rate_and_for_every_hand() {
    // in and out within 0.2 s, and 0.75 s later once more
    const TWICE: &str = "t_s,x_mm,y_mm,z_mm\n0,80,0,100\n0.25,80,0,100\n0.35,50,0,100\n0.45,80,0,100\n1,80,0,100\n1.1,50,0,100\n1.2,80,0,100\n";
    let usual = HandModel::default();
    let light = HandModel { mass_kg: 0.12, damping_n_s_per_m: 1.5, stiffness_n_per_m: 100.0, ..usual };
    let firm = HandModel { mass_kg: 0.35, damping_n_s_per_m: 9.0, stiffness_n_per_m: 1000.0, ..usual };
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        for (name, model) in [("light", light), ("standard", usual), ("firm", firm)] {
            // a loop that comes to every fourth or second tick alone, and those that turn more often
            let slow = [(1, 4), (1, 2)];
            let mut at_a_thousand = None;
            for (thousands, every) in THOUSANDS.map(|thousands| (thousands, 1)).into_iter().chain(slow) {
                let (mut hand, mut net, _) = pressed(method, thousands, model, TWICE);
                for turn in (0..1500 * thousands).step_by(every) {
                    hand.turn(turn);
                    while net.next_sample().is_some() {}
                }
                let rpm = 60.0 * turns_between(&hand) / 0.75;
                let usual = *at_a_thousand.get_or_insert(rpm);
                let hertz = 1000 * thousands / every as u64;
                println!("{method:?}, {name} hand, {hertz} Hz: the wheel turns at {rpm:.2} rpm");
                // what is wanted of a loop: 2 %
                assert!((rpm / 60.0 - 1.0).abs() < 0.02, "{method:?}, {name} hand, {hertz} Hz: {rpm} rpm");
                assert!((rpm / usual - 1.0).abs() < 0.02, "{method:?}, {name} hand, {hertz} Hz: {rpm} and {usual} rpm");
            }
        }
    }
}

#[test]
fn the_clay_sounds_the_same_at_every_rate() {
    // up the wall at 40 mm/s, which is a tenth of what the clay goes round with
    let rises = "t_s,x_mm,y_mm,z_mm\n0,74,0,60\n0.5,56,0,60\n2.5,56,0,140\n";
    let mut at_a_thousand = None;
    for thousands in THOUSANDS {
        let (mut hand, mut net, _) = pressed(MethodKind::Plastic, thousands, HandModel::default(), rises);
        let mut slips_m_s = Vec::new();
        for turn in 1..=2400 * thousands {
            hand.turn(turn);
            while net.next_sample().is_some() {}
            let rub = net.status().rub();
            if turn % thousands == 0 && rub.force_n > 0.0 {
                slips_m_s.push(f64::from(rub.slip_m_s));
            }
        }
        assert!(slips_m_s.len() > 1000, "{} ticks with clay at {thousands} kHz", slips_m_s.len());
        let mean_m_s = slips_m_s.iter().sum::<f64>() / slips_m_s.len() as f64;
        let wanted_m_s = *at_a_thousand.get_or_insert(mean_m_s);
        // what is wanted of a loop: 2 %
        assert!((mean_m_s / wanted_m_s - 1.0).abs() < 0.02, "{thousands} kHz: {mean_m_s} m/s, not {wanted_m_s} m/s");
    }
}

#[test]
fn between_two_ticks_the_force_changes_and_nothing_is_allocated() {
    let (mut hand, mut net, noted) = pressed_by_a_hand(MethodKind::Plastic, 4);
    let mut changed = 0;
    for turn in 1..=4000 {
        let room = Noted { places_m: Vec::with_capacity(8), forces_n: Vec::with_capacity(8) };
        let before = std::mem::replace(&mut *noted.lock().unwrap(), room);
        let asked = requests(|| hand.turn(turn));
        assert_eq!(asked, 0, "turn {turn}");
        let now = noted.lock().unwrap().forces_n.last().copied();
        changed += usize::from(turn % 4 != 0 && before.forces_n.last().copied() != now);
        while net.next_sample().is_some() {}
    }
    // three quarters of the turns lie between, and most of them in clay
    assert!(changed > 1000, "the force changed in {changed} turns between ticks");
}

#[test]
fn rates_that_cannot_be_are_refused_with_those_that_can() {
    for text in ["0", "999", "1500", "11000", "fast", "-1000", "nan", "4294968000"] {
        let refused = text.parse::<LoopRate>().unwrap_err().to_string();
        assert!(refused.contains("1000 to 10000") && refused.contains(text), "{refused}");
    }
    for thousands in 1..=10 {
        assert_eq!(rate(thousands).turns_a_tick(), thousands);
    }
    assert_eq!(LoopRate::default(), rate(1));
}
