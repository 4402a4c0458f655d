//! A pot that is pressed by one or more tools, tick by tick.
//!
//! Owns how presses reach the clay and what is read of it; what is done with it is the scenarios' affair.
//! Invariant: nothing here is random and nothing reads a clock.

use glam::Vec3;
use pottery_shared::clay::{
    Contact, GridShape, Material, Method, MethodKind, Pot, PotSpec, Press, Strength, SubStep, Window,
};
use pottery_shared::tool::{Sphere, ToolSample};
use pottery_shared::units::{Metres, Seconds};

/// Mean pressure that clay bears at most under a tool at its surface, over its yield stress: 3, Tabor 1951.
const PRESSURE_OVER_YIELD: f64 = 3.0;
/// Mean pressure on the cross-section of a smooth sphere round which clay flows, over its undrained strength: 10.98, Randolph,
/// Martin and Hu 2000, who have 15.10 for a rough one.
const FLOW_OVER_STRENGTH: f64 = 10.98;

/// A pot, the method that deforms it and one clay.
pub(crate) struct Scene {
    pub(crate) pot: Pot,
    pub(crate) method: MethodKind,
    pub(crate) material: Material,
    pub(crate) step: Seconds,
    substep: SubStep,
    contacts: Vec<Contact>,
    /// What was pressed last, when it was one tool.
    last: Option<Press>,
    /// What changed since the pot settled, and how much of it before the last step.
    changed: Vec<(usize, Window)>,
    changed_before: usize,
}

impl Scene {
    /// The default pot on a grid, in steps of 1 ms.
    pub(crate) fn new(method: MethodKind, columns: u32, rows: u32) -> Self {
        let shape = GridShape::new(columns, rows).expect("a grid of the suite");
        Self::of(method, PotSpec { shape, ..PotSpec::default() })
    }

    pub(crate) fn of(method: MethodKind, spec: PotSpec) -> Self {
        let spec = PotSpec { keeps_volume: method.keeps_volume(), ..spec };
        Self {
            pot: Pot::new(spec).expect("a pot of the suite"),
            method,
            material: Material::default(),
            step: Seconds(1e-3),
            substep: SubStep::for_grid(spec.shape),
            contacts: Vec::new(),
            last: None,
            changed: Vec::new(),
            changed_before: 0,
        }
    }

    /// The same in clay of another time constant.
    pub(crate) fn with_viscosity(mut self, viscosity: Seconds) -> Self {
        self.material = Material { viscosity, ..self.material };
        self
    }

    /// The same in steps of another length.
    pub(crate) fn with_step(mut self, step: Seconds) -> Self {
        self.step = step;
        self
    }

    /// A tool at a place of this clay.
    pub(crate) fn tool(&self, radius_mm: f32, centre_m: Vec3) -> Press {
        let tool = Sphere::new(Metres::from_mm(radius_mm)).expect("a tool of the suite");
        let response = self.material.response(self.step);
        Press { dt: self.step, response, strength: self.material.strength, ..Press::held(tool, centre_m) }
    }

    /// A tool with its deepest point `depth_mm` under the untouched wall.
    pub(crate) fn pressed(&self, radius_mm: f32, depth_mm: f32, angle_rad: f32, z_mm: f32) -> Press {
        let distance_mm = self.pot.spec().radius.as_mm() + radius_mm - depth_mm;
        self.tool(radius_mm, around(distance_mm, angle_rad, z_mm))
    }

    /// One step under presses of which nobody says where they come from.
    pub(crate) fn advance(&mut self, presses: &[Press]) -> &[Contact] {
        let changed = &mut self.changed;
        self.changed_before = changed.len();
        let touched = |surface, window| changed.push((surface, window));
        let contacts = self.substep.advance(&mut self.pot, presses, self.method, touched);
        self.contacts.clear();
        self.contacts.extend_from_slice(contacts);
        &self.contacts
    }

    /// One step under one press.
    ///
    /// Our method is told where the tool comes from when it is no farther than a hand gets, as the studio does. The published
    /// methods are not: they know where a tool is, and of no way between.
    pub(crate) fn press(&mut self, press: Press) -> Contact {
        let reach_m = ToolSample::SPEED_MAX_M_S * self.step.0;
        let follows = |last: &Press| {
            last.tool == press.tool && last.side == press.side && last.centre_m.distance(press.centre_m) <= reach_m
        };
        let ours = self.method == MethodKind::Plastic;
        let before = self.last.replace(press).filter(|last| ours && follows(last));
        self.advance(&[Press { from_m: before.map(|last| last.centre_m), ..press }])[0]
    }

    /// Elements that the last step changed, or looked at to change them.
    pub(crate) fn worked_at(&self) -> u64 {
        let windows = self.changed[self.changed_before..].iter();
        windows.map(|(_, window)| u64::from(window.columns) * u64::from(window.rows)).sum()
    }

    /// Books what was pressed away since it last did, as the studio does at its snapshots.
    pub(crate) fn settle(&mut self) {
        self.pot.settle(self.changed.drain(..));
        self.changed_before = 0;
    }

    /// Radii of the elements of the outer surface, m.
    pub(crate) fn radii_m(&self) -> &[f32] {
        self.pot.surfaces()[0].radii_m()
    }

    pub(crate) fn untouched_m(&self) -> f32 {
        self.pot.spec().radius.0
    }

    /// How much deeper than the untouched wall the deepest element lies, m.
    pub(crate) fn deepest_m(&self) -> f64 {
        f64::from(self.untouched_m() - self.radii_m().iter().copied().fold(f32::MAX, f32::min))
    }

    /// Volume between the untouched wall and every element that lies deeper, m³.
    pub(crate) fn dent_m3(&self) -> f64 {
        let first = f64::from(self.untouched_m());
        let deeper = self.radii_m().iter().map(|&radius| f64::from(radius)).filter(|&radius| radius < first);
        deeper.map(|radius| 0.5 * (first * first - radius * radius)).sum::<f64>() * self.element_rad_m()
    }

    /// Area of an element over its radius, m.
    pub(crate) fn element_rad_m(&self) -> f64 {
        let surface = &self.pot.surfaces()[0];
        f64::from(surface.shape().column_angle_rad()) * f64::from(surface.row_height_m())
    }

    /// Number of radii that are out of their bounds or not a number.
    pub(crate) fn misplaced(&self) -> usize {
        let (low, high) = self.pot.surfaces()[0].bounds_m();
        self.radii_m().iter().filter(|radius| !(low..=high).contains(radius)).count()
    }

    /// A figure, or infinity when the clay is out of bounds or a force of the last step is no number.
    pub(crate) fn unless_broken(&self, figure: f64) -> f64 {
        let sound =
            self.contacts.iter().all(|contact| contact.force_n.is_finite() && contact.penetration_m.is_finite());
        if sound && self.misplaced() == 0 { figure } else { f64::INFINITY }
    }
}

/// A point at a distance from the axis, m.
pub(crate) fn around(distance_mm: f32, angle_rad: f32, z_mm: f32) -> Vec3 {
    Vec3::new(distance_mm * angle_rad.cos(), distance_mm * angle_rad.sin(), z_mm) * 1e-3
}

/// The force that clay bears at most on a sphere that is wholly in it, N; its yield stress is √3 times its strength.
pub(crate) fn flow_n(press: &Press) -> f64 {
    let radius_m = f64::from(press.tool.sphere().map_or(0.0, |sphere| sphere.radius().0));
    let strength_pa = f64::from(press.strength.yield_pa) / 3.0_f64.sqrt();
    FLOW_OVER_STRENGTH * strength_pa * std::f64::consts::PI * radius_m * radius_m
}

/// The force that clay bears at most on an area of its surface, N.
pub(crate) fn bearing_n(strength: Strength, area_m2: f64) -> f64 {
    PRESSURE_OVER_YIELD * f64::from(strength.yield_pa) * area_m2
}

/// The larger of two figures; what is no number is larger than any, so that it does not vanish among others.
pub(crate) const fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || other.is_nan() { f64::INFINITY } else { one.max(other) }
}

/// The smaller of two figures; what is no number is smaller than any.
pub(crate) const fn smaller(one: f64, other: f64) -> f64 {
    if one.is_nan() || other.is_nan() { f64::NEG_INFINITY } else { one.min(other) }
}

/// Most over least, less 1, in percent.
pub(crate) fn spread_percent(figures: &[f64]) -> f64 {
    let least = figures.iter().copied().fold(f64::INFINITY, smaller);
    let most = figures.iter().copied().fold(f64::NEG_INFINITY, larger);
    (most / least - 1.0) * 100.0
}
