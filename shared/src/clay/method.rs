//! The one interface behind which the deformation methods stand.
//!
//! Owns what a method is told and what it answers; each method has its own file.
//! Invariant: a method reads the surface and writes only its footprint, so that presses of one sub-step do not see
//! each other.

use glam::Vec3;

use super::bending::nearest_turn;
use super::lanes::root;
use super::{Bend, Footprint, ImprovedCsem, OriginalCsem, Part, PlasticCsem, PlasticLaw, Pot, Press, Support, Surface};

/// What a press meets: the force on the tool and how much clay it touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Force of the clay on the tool, N, in the frame in which the press was given.
    pub force_n: Vec3,
    /// Number of elements in contact.
    pub elements: u32,
    /// Largest penetration, m.
    pub penetration_m: f32,
    /// What of the clay's push towards the pot's axis, or away from it, cancels itself out over the contact, N: nothing where a tool
    /// stands before a wall, much where a ring of clay holds it on all sides. Zero for the methods that know no pressure.
    pub held_n: f32,
    /// How the clay gives way elastically round the contact, for the method that has it.
    pub sink: Option<Sink>,
}

/// How far clay gives way while a tool presses on it, and springs back when it is gone.
///
/// `e(q²)` over the depth e₀ in the middle, with n and m its bowl:
/// - inside of the contact `1 − n·q² − m·q⁶`;
/// - outside on a core `(1 − n − m)·(Q − q²)/((Q − 1)·(1 + (q² − 1)/w))`, Q = 7.5. On a layer that slides on a rigid base and is twice as
///   thick as the contact's radius, an even pressure makes n = 0.35, m = 0.14 and w = 0.7, within 0.03 of the integral
///   `2p/E*·∫ a·J₁(ka)·J₀(kr)/k·(cosh 2kt − 1)/(sinh 2kt + 2kt) dk`; clay that flows on a thinner one gives way more evenly and
///   within narrower bounds (`PlasticLaw`);
/// - with nothing behind: n = 0.25, m = 0.113 and `1/(2q)·(1 + 1/(8q²) + 0.15/q⁸)` outside, a half-space's within 0.01
///   (Johnson 1985, section 3.4) and a free layer's within 0.06, its bending as a plate left to [`Sink::bend`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sink {
    /// Angle of its middle on the pot, rad, and height, m.
    pub angle_rad: f32,
    /// See `angle_rad`.
    pub z_m: f32,
    /// Radius of the clay there, m.
    pub radius_m: f32,
    /// Half axes of the contact along arc and height, m.
    pub half_arc_m: f32,
    /// See `half_arc_m`.
    pub half_height_m: f32,
    /// Depth in the middle e₀, m.
    pub depth_m: f32,
    /// What stands behind the clay.
    pub support: Support,
    /// The factors n and m inside of the contact.
    pub bowl: [f32; 2],
    /// The width w outside, in q².
    pub width: f32,
    /// Radial force on a wall with nothing behind it, over Young's modulus, positive towards the axis, m².
    pub load_m2: f32,
    /// By how much more it gives way than a wall that is as thick as it was made.
    pub softer: f32,
    /// What such a wall gives way beyond an elastic one, as it yields where it bends most, m; towards where the load is.
    pub hinge_m: f32,
}

impl Sink {
    const END: f32 = 7.5;

    /// How the whole wall bends with it, to be added to its depth; nothing on a backed wall.
    #[must_use]
    pub fn bend(&self, surface: &Surface) -> Option<Bend> {
        let patch_m = root(self.half_arc_m * self.half_height_m);
        surface
            .bending()
            .map(|bending| bending.under(self.load_m2 * self.softer, self.hinge_m, self.angle_rad, self.z_m, patch_m))
    }

    /// Depth at a place of the pot, without the wall's bending, m.
    #[must_use]
    pub fn depth_at_m(&self, angle_rad: f32, z_m: f32) -> f32 {
        let away = nearest_turn(angle_rad - self.angle_rad);
        let (across, up) = (away * self.radius_m / self.half_arc_m, (z_m - self.z_m) / self.half_height_m);
        let q2 = across * across + up * up;
        let [near, edge] = self.bowl;
        let share = if q2 < 1.0 {
            1.0 - q2 * (near + edge * q2 * q2)
        } else if self.support == Support::Hollow {
            let over = 1.0 / q2;
            0.5 * root(over) * (1.0 + over * (0.125 + 0.15 * over * over * over))
        } else if q2 < Self::END {
            (1.0 - near - edge) * (Self::END - q2) / ((Self::END - 1.0) * (1.0 + (q2 - 1.0) / self.width))
        } else {
            0.0
        };
        share * self.depth_m
    }
}

/// A way for clay to answer a press.
pub trait Method {
    /// Evaluates one press against the surface that it meets and writes the displacement it asks for.
    ///
    /// The footprint is empty afterwards when nothing is touched.
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact;

    /// The same press when it is the only one and the pot has one skin with columns of whole eights: clay goes at once to where the footprint
    /// would have taken it, and of the footprint only the window counts afterwards.
    fn displace(&self, pot: &mut Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let contact = self.press(pot, press, footprint);
        pot.surfaces_mut()[0].displace(footprint);
        contact
    }

    /// What a press meets, when nobody asks what it would displace; the footprint means nothing afterwards.
    fn feel(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        self.press(pot, press, footprint)
    }

    /// Lets the presses of one sub-step, each with a footprint of its own, find how far they bend a wall together, before they are
    /// evaluated one by one. A method whose presses know nothing of each other has nothing to do.
    fn brace(&self, _pot: &Pot, _presses: &[Part], _footprints: &mut [Footprint]) {}

    /// Whether clay that is pressed away is still there: what does not rise beside the tool makes the pot higher.
    fn keeps_volume(&self) -> bool {
        false
    }
}

/// The methods one can choose from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MethodKind {
    /// Circular Sector Element Method without interaction of neighbours.
    Original,
    /// The same with local propagation of the response.
    Improved,
    /// The studio's own: elastic up to yield, plastic beyond, displaced clay returned as a rim.
    #[default]
    Plastic,
}

impl MethodKind {
    /// Its number in messages and files.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Original => 0,
            Self::Improved => 1,
            Self::Plastic => 2,
        }
    }

    /// Its name, as people write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Original => "original",
            Self::Improved => "improved",
            Self::Plastic => "plastic",
        }
    }

    /// The method of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Original, Self::Improved, Self::Plastic].into_iter().find(|method| method.name() == name)
    }

    /// The method of a number; the default one for a number that means nothing here.
    #[must_use]
    pub const fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Original,
            1 => Self::Improved,
            _ => Self::Plastic,
        }
    }

    /// Force to feel for each newton of the clay's.
    ///
    /// The published methods give tenths of a newton. Clay as strong as the reference's needs 12 N for a dent of 2 mm,
    /// where a small device has 3.3 N: 1:5 lets it press that deep.
    #[must_use]
    pub const fn felt_share(self) -> f32 {
        match self {
            Self::Original | Self::Improved => 1.0,
            Self::Plastic => 0.2,
        }
    }

    /// The method itself.
    #[must_use]
    pub fn method(self) -> &'static dyn Method {
        match self {
            Self::Original => &OriginalCsem,
            Self::Improved => &ImprovedCsem,
            Self::Plastic => &PlasticCsem { law: PlasticLaw::FITTED },
        }
    }
}

impl Method for MethodKind {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        self.method().press(pot, press, footprint)
    }

    fn displace(&self, pot: &mut Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        self.method().displace(pot, press, footprint)
    }

    fn feel(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        self.method().feel(pot, press, footprint)
    }

    fn brace(&self, pot: &Pot, presses: &[Part], footprints: &mut [Footprint]) {
        self.method().brace(pot, presses, footprints);
    }

    fn keeps_volume(&self) -> bool {
        self.method().keeps_volume()
    }
}
