//! The pot on its wheel: radius grids, the wheel's angle, and the methods that deform the clay.
//!
//! Knows no network and no device. A pot is a set of [`Surface`]s; how many is known in here only.
//! Invariant: every radius is finite and within its surface's bounds after every sub-step.

mod ball;
mod bending;
mod conditions;
mod contact;
mod covering;
mod digest;
mod ellipse;
mod faceted;
mod folds;
mod form;
mod grid;
mod improved;
mod joint;
mod lathe;
mod law;
mod looks;
mod material;
mod method;
mod original;
mod plastic;
mod pot;
mod profile;
mod rays;
mod resample;
mod rim;
mod schedule;
mod series;
mod sides;
mod solid;
mod substep;
mod surface;
mod target;
mod unbent;
mod uptake;
mod wall;
mod wheel;
mod window;

use crate::lanes;
pub use crate::lanes::Vectors;
pub(crate) use crate::lanes::with_vectors;
pub use bending::{Bend, WallBending};
pub use conditions::Conditions;
pub use digest::Digest;
pub use form::Form;
pub use grid::{GridError, GridShape};
pub use improved::ImprovedCsem;
pub use lathe::{BoundError, ErrorBound, Lathe};
pub use law::PlasticLaw;
pub use material::{Material, MaterialError, Preset, Strength, Wetness};
pub use method::{Contact, Method, MethodKind, Sink};
pub use original::OriginalCsem;
pub use plastic::PlasticCsem;
pub use pot::{Pot, PotError, PotSpec, Skin, Support};
pub use resample::ResolutionError;
pub use schedule::Schedule;
pub use solid::{Triangle, closed_solid, floor_row};
pub use substep::{Part, Press, SubStep};
pub use surface::Surface;
pub use target::{Deviation, Target};
pub use wheel::{Phase, Wheel};
pub use window::{Footprint, Window};
