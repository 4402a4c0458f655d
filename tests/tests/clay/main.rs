//! What the clay does: methods, tools and walls, each against an equation, a law or a reference.

mod bending;
mod clay_laws;
mod folding;
mod golden;
mod hollow;
mod idle_pot;
mod lathe;
mod material;
mod merge;
mod methods;
mod narrow_tools;
mod orientation;
mod pinch;
mod polygonal_presses;
mod polygonal_tools;
mod reference;
mod resample;
mod targets;
mod unfitted;
mod wheel;
mod wide;
