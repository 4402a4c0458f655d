//! One sub-step of the clay: every press evaluated against the same field, then merged symmetrically.
//!
//! Owns the scratch memory, so that a step allocates nothing once it has seen its number of presses.
//! Invariant: the result depends neither on the order of the presses nor on who makes them.

use alloc::vec::Vec;

use glam::Vec3;

use super::{Contact, Footprint, GridShape, Material, Method, Pot, Strength, Surface, Window};
use crate::tool::{Side, Sphere};
use crate::units::Tick;

/// A tool held at one place for one sub-step, in the pot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// The tool.
    pub tool: Sphere,
    /// Its centre on the pot, m.
    pub centre_m: Vec3,
    /// On which side of the wall it works.
    pub side: Side,
    /// Which way the clay turns under it: −1, 0 or 1.
    pub turning: i8,
    /// Share of the penetration that yields in this step, from [`super::Material::response`].
    pub response: f32,
    /// How strong the clay is, for the methods that ask.
    pub strength: Strength,
}

impl Press {
    /// A tool held outside of a still pot of the default clay for one tick.
    #[must_use]
    pub fn held(tool: Sphere, centre_m: Vec3) -> Self {
        let material = Material::default();
        Self {
            tool,
            centre_m,
            side: Side::Outside,
            turning: 0,
            response: material.response(Tick::PERIOD),
            strength: material.strength,
        }
    }
}

/// Scratch memory and result of one sub-step.
///
/// A Jacobi step: with Δᵢ the displacement that press i asks for on its own, an element moves by
/// `min(0, minᵢ Δᵢ) + max(0, maxᵢ Δᵢ)`, the strongest push inwards and the strongest outwards. Minimum and maximum are
/// commutative, associative and idempotent also in floating point, so order and identity cannot matter.
#[derive(Clone, Debug, Default)]
pub struct SubStep {
    footprints: Vec<Footprint>,
    contacts: Vec<Contact>,
    /// Merged pushes of the surface at hand, `[columns][rows]`, m; all zero between sub-steps.
    inward_m: Vec<f32>,
    outward_m: Vec<f32>,
}

impl SubStep {
    /// Scratch for presses on grids of up to `shape`; the first use with more presses than ever before allocates.
    #[must_use]
    pub fn for_grid(shape: GridShape) -> Self {
        Self {
            footprints: alloc::vec![Footprint::for_grid(shape)],
            contacts: Vec::with_capacity(1),
            inward_m: alloc::vec![0.0; shape.elements()],
            outward_m: alloc::vec![0.0; shape.elements()],
        }
    }

    /// Advances `pot` by one step under `presses` and tells `touched` of every window that changed.
    ///
    /// `touched` is called with the number of the surface and a window of it. Returns one contact a press, in order;
    /// its force adds up over the surfaces.
    pub fn advance(
        &mut self,
        pot: &mut Pot,
        presses: &[Press],
        method: impl Method,
        mut touched: impl FnMut(usize, Window),
    ) -> &[Contact] {
        self.contacts.clear();
        self.contacts.resize(presses.len(), Contact::default());
        for (number, surface) in pot.surfaces_mut().iter_mut().enumerate() {
            while self.footprints.len() < presses.len() {
                self.footprints.push(Footprint::for_grid(surface.shape()));
            }
            let footprints = &mut self.footprints[..presses.len()];
            for ((press, footprint), total) in presses.iter().zip(&mut *footprints).zip(&mut self.contacts) {
                let contact = method.press(surface, press, footprint);
                total.force_n += contact.force_n;
                total.elements += contact.elements;
                total.penetration_m = total.penetration_m.max(contact.penetration_m);
                total.sink = contact.sink;
            }
            if let [alone] = footprints {
                surface.displace(alone);
            } else {
                self.merge(surface, presses.len());
            }
            for footprint in &self.footprints[..presses.len()] {
                if !footprint.window().is_empty() {
                    touched(number, footprint.window());
                }
            }
        }
        &self.contacts
    }

    fn merge(&mut self, surface: &mut Surface, presses: usize) {
        let shape = surface.shape();
        let rows = shape.rows() as usize;
        let elements = shape.elements().max(self.inward_m.len());
        self.inward_m.resize(elements, 0.0);
        self.outward_m.resize(elements, 0.0);
        for footprint in &self.footprints[..presses] {
            let window = footprint.window();
            for (local, column) in window.grid_columns(shape).enumerate() {
                let start = column as usize * rows + window.first_row as usize;
                let inward = &mut self.inward_m[start..];
                let outward = &mut self.outward_m[start..];
                for ((&delta, inward), outward) in footprint.column(local as u32).iter().zip(inward).zip(outward) {
                    *inward = inward.min(delta);
                    *outward = outward.max(delta);
                }
            }
        }
        for footprint in &self.footprints[..presses] {
            let window = footprint.window();
            for column in window.grid_columns(shape) {
                for row in window.first_row..window.first_row + window.rows {
                    let index = column as usize * rows + row as usize;
                    let delta = self.inward_m[index] + self.outward_m[index];
                    // cleared, so that an overlapping footprint finds the element done
                    self.inward_m[index] = 0.0;
                    self.outward_m[index] = 0.0;
                    if delta != 0.0 {
                        surface.set_radius(column, row, surface.column_m(column)[row as usize] + delta);
                    }
                }
            }
        }
    }
}
