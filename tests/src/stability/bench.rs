//! The studio's own loop on its own clay, with a device that is told where to be.
//!
//! Owns the device and the loop's other end; what is done with them is the scenarios' affair.
//! Invariant: a tick is the studio's: nothing of it is made anew here.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, Vec3};
use pottery_client::HapticLoop;
use pottery_client::boundary::{NetSide, boundary};
use pottery_client::device::Device;
use pottery_shared::clay::{Conditions, Method, MethodKind, Phase, Pot, PotSpec, Support, Wheel};
use pottery_shared::haptics::{Coupling, DeviceSpecs, Setup};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::snapshot::Author;
use pottery_shared::tool::{Side, Tool, ToolSample};
use pottery_shared::units::{Metres, Rpm, Seconds, Tick};

use super::mechanism::{Grip, Mechanism};
use super::plane::stages;

/// What is held, and by what.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene {
    pub(super) method: MethodKind,
    pub(super) specs: DeviceSpecs,
    pub(super) support: Support,
    /// A pot of 30 mm with a wall of 4 mm instead of the usual one.
    pub(super) is_narrow: bool,
    pub(super) rpm: f32,
    pub(super) delay_s: f64,
    /// The coupling, where it is not to be tuned from the specs.
    pub(super) coupling: Option<Coupling>,
}

impl Scene {
    /// A PHANToM Omni on a backed pot that stands still.
    pub(super) const fn of(method: MethodKind) -> Self {
        Self {
            method,
            specs: DeviceSpecs::OMNI,
            support: Support::Backed,
            is_narrow: false,
            rpm: 0.0,
            delay_s: 0.0,
            coupling: None,
        }
    }
}

#[derive(Debug, Default)]
struct Held {
    position_m: Option<Vec3>,
    force_n: Vec3,
}

/// The other end of a device that is told where to be.
#[derive(Clone, Debug, Default)]
pub(super) struct Told(Arc<Mutex<Held>>);

impl Told {
    /// Puts the device somewhere, or takes it away.
    pub(super) fn put(&self, device_m: Option<Vec3>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).position_m = device_m;
    }

    /// What it was given last, N.
    pub(super) fn force_n(&self) -> Vec3 {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).force_n
    }
}

struct ToldDevice {
    told: Told,
    setup: Setup,
    tool: Tool,
}

/// A device of a scene, with a tool in it, and what tells it where to be.
pub(super) fn told_device(scene: &Scene, tool: Tool) -> (Box<dyn Device>, Told) {
    let setup = Setup {
        stages: stages(scene.method),
        delay: Seconds(scene.delay_s as f32),
        coupling: scene.coupling,
        ..Setup::for_device(scene.specs, scene.method.felt_share())
    };
    let told = Told::default();
    (Box::new(ToldDevice { told: told.clone(), setup, tool }), told)
}

impl Device for ToldDevice {
    fn position(&mut self, _: f64) -> Option<Vec3> {
        self.told.0.lock().unwrap_or_else(PoisonError::into_inner).position_m
    }

    fn tool(&self) -> Tool {
        self.tool
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.told.0.lock().unwrap_or_else(PoisonError::into_inner).force_n = force_n;
    }

    fn specs(&self) -> DeviceSpecs {
        self.setup.specs
    }

    fn setup(&self, _: f32) -> Setup {
        self.setup
    }
}

/// What came of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    /// What the device was given, N, and where it then was, m.
    pub(super) force_n: Vec3,
    pub(super) at_m: DVec3,
    /// How fast the hand moved after it, m/s, and the work that the force did on it so far, J.
    pub(super) speed_m_s: f64,
    pub(super) work_j: f64,
    /// Where the tool was, m, and on which side of the middle of a wall that stands still.
    pub(super) tool_m: Option<Vec3>,
    pub(super) stood: Option<Side>,
}

impl Felt {
    pub(super) fn of(mechanism: &Mechanism, force_n: Vec3, work_j: f64) -> Self {
        let (at_m, velocity_m_s) = mechanism.motion();
        Self { force_n, at_m, speed_m_s: velocity_m_s.length(), work_j, tool_m: None, stood: None }
    }

    /// The same with a tool beside clay of a wheel that stands still.
    pub(super) fn beside(self, pot: &Pot, tool_m: Option<Vec3>) -> Self {
        Self { tool_m, stood: tool_m.map(|tool_m| pot.side_of(tool_m)), ..self }
    }
}

/// The loop.
pub(super) struct Bench {
    hand: HapticLoop,
    pub(super) net: NetSide,
    told: Told,
    local: u64,
    resolution_m: f64,
    delay_s: f64,
}

impl Bench {
    /// Where the standard tool just touches the wall, m.
    pub(super) const TOUCHING_M: Vec3 = Vec3::new(0.072, 0.0, 0.1);

    pub(super) fn new(scene: &Scene) -> Self {
        Self::with(scene, Tool::default())
    }

    /// The same with another tool in the hand.
    pub(super) fn with(scene: &Scene, tool: Tool) -> Self {
        Self::on(scene, tool, Self::pot(scene))
    }

    /// The same on a pot as a room has it: its radii are whole steps of what travels.
    pub(super) fn of_a_room(scene: &Scene) -> Self {
        let mut pot = Self::pot(scene);
        // whoever takes its snapshots begins so
        drop(Author::new(&mut pot));
        Self::on(scene, Tool::default(), pot)
    }

    fn on(scene: &Scene, tool: Tool, pot: Pot) -> Self {
        let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(scene.rpm)));
        let conditions = Conditions { wheel, method: scene.method, ..Conditions::default() };
        let (side, net) = boundary(&Patch {
            field: Field::new(pot, Tick(0)),
            conditions,
            rack: pottery_shared::tool::rack::standard(),
        });
        let (device, told) = told_device(scene, tool);
        Self {
            hand: HapticLoop::new(device, side),
            net,
            told,
            local: 0,
            resolution_m: f64::from(scene.specs.resolution_m),
            delay_s: scene.delay_s,
        }
    }

    /// Its measures.
    pub(super) fn spec(scene: &Scene) -> PotSpec {
        let spec = PotSpec { keeps_volume: scene.method.keeps_volume(), support: scene.support, ..PotSpec::default() };
        if !scene.is_narrow {
            return spec;
        }
        PotSpec { radius: Metres::from_mm(30.0), wall: Metres::from_mm(4.0), ..spec }
    }

    /// The pot on which a scene begins.
    pub(super) fn pot(scene: &Scene) -> Pot {
        Pot::new(Self::spec(scene)).expect("a pot of the suite")
    }

    /// The pot as it is.
    pub(super) fn clay(&self) -> &Pot {
        self.hand.hand().field().pot()
    }

    /// The number of the last tick.
    pub(super) const fn local(&self) -> u64 {
        self.local
    }

    /// Does a tick with the device somewhere; the force on the hand, N, and what was pressed.
    pub(super) fn tick(&mut self, device_m: Option<Vec3>) -> (Vec3, Option<ToolSample>) {
        self.local += 1;
        self.told.put(device_m);
        self.hand.tick(self.local);
        (self.told.force_n(), self.net.next_sample())
    }

    /// Lets ticks go by undone.
    pub(super) const fn stall(&mut self, ticks: u64) {
        self.local += ticks;
    }

    /// Puts the device into a hand that means to be somewhere at every second, and tells what it feels for so many ticks.
    pub(super) fn hold(&mut self, grip: Grip, ticks: u32, meant_m: impl Fn(f64) -> Vec3) -> Vec<Felt> {
        let mut mechanism = Mechanism::at_rest(grip, meant_m(0.0), self.resolution_m, self.delay_s);
        let mut work_j = 0.0;
        (0..ticks)
            .map(|tick| {
                let device_m = mechanism.reported_m();
                let (force_n, _) = self.tick(Some(device_m));
                work_j += mechanism.pass(force_n, meant_m(f64::from(tick) * 1e-3), 1e-3);
                Felt::of(&mechanism, force_n, work_j).beside(self.clay(), self.net.status().tool_m())
            })
            .collect()
    }
}
