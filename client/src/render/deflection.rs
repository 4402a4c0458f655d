//! How far a hollow wall gives way under the tools at it, as it is seen.
//!
//! Owns a coarse map of the wall. What gives way springs back, so that it is in no radius and nobody is told of it: everybody finds it
//! from the clay and from the tools as they are drawn, so that those two fit each other in every picture. Knows no device and no clock.
//! Invariant: it changes pictures and no clay.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::Quat;
use pottery_shared::clay::{Conditions, GridShape, Pot, Press, SubStep};
use pottery_shared::tool::{ConvexTool, Tool};
use pottery_shared::units::Tick;

use super::ToolView;

/// How far the wall of a pot has given way, and what finds it.
///
/// The studio's own method tells how a hollow wall bends under all tools at once ([`pottery_shared::clay::Bend`]); on a core, and with the
/// published methods, nothing does.
#[derive(Clone, Debug)]
pub struct Deflection {
    /// Towards the axis, `[columns][rows]`, m.
    towards_axis_m: Vec<f32>,
    /// The same with its slopes from angle to angle, m/rad, and from foot to rim, m/m; the last is none.
    texels: Vec<[f32; 4]>,
    presses: Vec<Press>,
    /// Made when a tool is first at a wall that bends: it is as large as the pot.
    feeler: Option<(GridShape, SubStep)>,
    is_any: bool,
    stamp: u64,
}

impl Default for Deflection {
    /// Of a wall that nobody is at.
    fn default() -> Self {
        let places = Self::COLUMNS * Self::ROWS;
        Self {
            towards_axis_m: vec![0.0; places],
            texels: vec![[0.0; 4]; places],
            presses: Vec::new(),
            feeler: None,
            is_any: false,
            stamp: 0,
        }
    }
}

impl Deflection {
    /// Places round the pot, four millimetres apart on a usual one: of its bend under a ball of 12 mm, 4 mm deep, straight lines between them
    /// miss half a hundredth.
    pub const COLUMNS: usize = 96;
    /// Places from the foot to the rim.
    pub const ROWS: usize = 64;
    /// What bends by less is not drawn, m.
    const SEEN_M: f32 = 2e-6;

    /// Finds how the wall stands with `tools` where they are drawn, under the conditions of a tick; convex ones are of the `rack`.
    pub fn follow<'a>(
        &mut self,
        pot: &Pot,
        (conditions, now): (&Conditions, Tick),
        rack: &Arc<[ConvexTool]>,
        tools: impl IntoIterator<Item = &'a ToolView>,
    ) {
        self.is_any = false;
        if pot.bending().is_none() {
            return;
        }
        self.presses.clear();
        let (phase, material) = (conditions.phase(now), conditions.material.at(now));
        let back = Quat::from_rotation_z(-phase.radians() as f32);
        self.presses.extend(tools.into_iter().map(|view| {
            let centre_m = phase.pot_from_room(view.centre_m);
            Press {
                orientation: match view.tool {
                    Tool::Sphere(_) => Quat::IDENTITY,
                    Tool::Convex(_) => back * view.turn,
                },
                side: view.side,
                response: material.response(Tick::PERIOD),
                strength: material.strength,
                ..Press::held(view.tool, centre_m)
            }
        }));
        if self.presses.is_empty() {
            return;
        }
        let shape = pot.spec().shape;
        let make = || (shape, SubStep::with_rack(shape, Arc::clone(rack)));
        self.feeler = self.feeler.take().filter(|(made_for, _)| *made_for == shape);
        let (_, feeler) = self.feeler.get_or_insert_with(make);
        feeler.swap_rack(&mut Arc::clone(rack));
        let outer = &pot.surfaces()[0];
        let contacts = feeler.feel_together(pot, &self.presses, conditions.method);
        let bends = contacts.iter().filter_map(|contact| contact.sink?.bend(outer));
        self.towards_axis_m.fill(0.0);
        bends.for_each(|bend| bend.add_to(&mut self.towards_axis_m, Self::ROWS, outer.height_m()));
        self.is_any = self.towards_axis_m.iter().any(|moved_m| moved_m.abs() > Self::SEEN_M);
        if self.is_any {
            self.stamp += 1;
            self.find_slopes(outer.height_m());
        }
    }

    /// Central differences; foot and rim look one way only.
    fn find_slopes(&mut self, height_m: f32) {
        let (columns, rows) = (Self::COLUMNS, Self::ROWS);
        let (column_rad, row_m) = (TAU / columns as f32, height_m / (rows - 1) as f32);
        for column in 0..columns {
            let [before, own, after] =
                [columns - 1, 0, 1].map(|step| &self.towards_axis_m[(column + step) % columns * rows..][..rows]);
            let texels = &mut self.texels[column * rows..][..rows];
            for (row, texel) in texels.iter_mut().enumerate() {
                let (below, above) = (row.saturating_sub(1), (row + 1).min(rows - 1));
                let around = (after[row] - before[row]) / (2.0 * column_rad);
                let upwards = (own[above] - own[below]) / ((above - below) as f32 * row_m);
                *texel = [own[row], around, upwards, 0.0];
            }
        }
    }

    /// Whether any of it is to be seen.
    #[must_use]
    pub const fn is_any(&self) -> bool {
        self.is_any
    }

    /// How far the wall has moved towards the axis at an angle of the pot, rad, and a share of its height, m: as it is drawn.
    #[must_use]
    pub fn at_m(&self, angle_rad: f32, up: f32) -> f32 {
        if !self.is_any {
            return 0.0;
        }
        let place = (angle_rad / TAU).rem_euclid(1.0) * Self::COLUMNS as f32;
        let row = up.clamp(0.0, 1.0) * (Self::ROWS - 1) as f32;
        let low = (row as usize).min(Self::ROWS - 2);
        let [left, right] = [0, 1].map(|step| {
            let column = (place as usize + step) % Self::COLUMNS;
            let column_m = &self.towards_axis_m[column * Self::ROWS + low..];
            column_m[0] + (column_m[1] - column_m[0]) * (row - low as f32)
        });
        left + (right - left) * place.fract()
    }

    /// Changes whenever a picture of it would, as long as there is any.
    pub(super) const fn stamp(&self) -> u64 {
        self.stamp
    }

    /// `[columns][rows]`.
    pub(super) fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }
}
