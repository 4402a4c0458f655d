//! The constants of the studio's own clay, and what follows from a contact's measures alone: pressure, elastic depth, rim.
//!
//! Owns every figure of the law that was fitted; knows no grid, no element and no tool.
//! Invariant: whatever the contact, its pressure is at least that at which clay begins to flow, before folding and sliding take from it, and shares are within 0 and 1.

use super::Support;

/// Least slope that the law has been seen with: a flat of one element has none.
pub(super) const SLOPE_MIN: f32 = 0.02;
/// Pressure at which clay begins to flow under a blunt tool, over its yield stress: 1.1, Johnson 1985.
const HARDNESS_MIN: f32 = 1.1;
/// The contact's radius over the clay's thickness from which on the base behind the clay tells.
const LAYER_BEGIN: f32 = 0.5;
/// Factor of −q² of the elastic depth on a thick layer, and the least that a thin one has been seen with.
const NEAR: f32 = 0.35;
const NEAR_MIN: f32 = -0.4;
/// Width of the sink on a thick layer, in q².
const SINK_WIDTH_MAX: f32 = 0.7;
/// By how much more than `slide_steep_from` the square of the slope is where half of what a steep sliding tool is borne less by is reached.
const STEEP_HALF: f32 = 0.1;
/// Largest depth of a bite that makes its rim narrower, as slope times half axis over thickness: the strokes of 2 mm have as much.
const DEEP_MAX: f32 = 0.5;
/// Largest share that rises, with what an open side adds: the finite elements go to 0.68, and a rim that gave back all would grow before
/// a sliding tool without end.
const RISES_MAX: f32 = 0.75;
/// Longest reach along the arc, over √(R·t), from which on a wall folds no later: that of a ball of 30 mm some 5 mm deep inside. One of 40 mm, which
/// reaches farther, bears at 4 and 6 mm what this has it bear, within 7 %.
const WIDEST: f32 = 1.1;
/// Fifth power of the force on a hollow wall, over that at which it folds, at which half of all that clay on it weakens is reached: the
/// finite elements go beyond, and clay that went on weakening would let a tool through.
const FOLDS_HALF: f32 = 1.4;
/// Most by which a rim is uneven, where a tool is more than half as wide as the pot: no data are beyond a third.
const AROUND_MAX: f32 = 0.5;

/// The constants of the law, all without unit.
///
/// The first twelve are fitted to finite-element dents of a backed wall by `accuracy-chart fit`: spheres of 8, 12
/// and 20 mm, 1 to 4 mm deep, pots of 40 and 60 mm, walls of 5 to 12 mm, E/σ_y from 25 to 125; other spheres, pots and clays are held
/// out. What a quick press raises less is fitted by it to what a slow one leaves. The nine of sliding are fitted to balls of 12 and 20 mm drawn
/// along such a wall 1 and 2 mm deep; a ball of 16 mm is held out. The seven of walls are fitted by it to the forces on balls of 12 to 40 mm pressed up
/// to 6 mm into hollow pots, from outside and from inside, and to the pots' shapes. The last four say nothing of clay: they are fitted to what balls of 8
/// to 35 mm bear on three coarse grids and on the finest one, with balls of 10, 16 and 26 mm held out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticLaw {
    /// Indentation pressure over yield stress of clay that flows wholly, under a tool without slope on a thick wall; Tabor 1951
    /// has 2.8 for a half-space.
    pub hardness: f32,
    /// What of it a slope of 1 at the contact's edge takes: a deep ball is borne by less, Mesarovic and Fleck 1999.
    pub hardness_by_slope: f32,
    /// What of it a contact takes that is as wide as the clay is thick: a layer on a slippery base is squeezed out.
    pub hardness_by_layer: f32,
    /// Strain over yield strain at which half of it is reached.
    pub hardness_strain: f32,
    /// Elastic depth over that of an even pressure on a layer.
    pub recovery: f32,
    /// By how much less it falls towards the edge for each unit by which the contact's radius over the layer's thickness is beyond a half.
    pub recovery_by_layer: f32,
    /// Factor of −q⁶ in its fall.
    pub recovery_edge: f32,
    /// Width of the sink outside of the contact, in q², where the contact is as wide as the clay is thick.
    pub sink_width: f32,
    /// Share of what yields that rises beside it under a tool that strains clay much.
    pub rim_rises: f32,
    /// Strain over yield strain at which 1 − 1/e of that share rises.
    pub rim_strain: f32,
    /// Width Q − 1 of the rim, in q².
    pub rim_width: f32,
    /// By how much more the rim rises to the sides where the pot curves away, over curvature of pot and tool.
    pub rim_around: f32,
    /// Share of the rim that a ball does not raise which is in before the clay has yielded: on a slower way in it would press that down again.
    pub rim_ahead: f32,
    /// Share of the elastic depth that is left at the bottom of a groove.
    pub slide_bottom: f32,
    /// Share of what yields that rises beside a sliding tool, in place of `rim_rises`.
    pub slide_rises: f32,
    /// By how much more strain counts for the rim of a sliding tool.
    pub slide_strain: f32,
    /// Share that rises of what else would not, over how far the contact leans to one side: beside a groove clay is open.
    pub slide_open: f32,
    /// Share of the pressure that this takes.
    pub slide_soft: f32,
    /// Share of the pressure that a much steeper contact takes than `slide_steep_from`.
    pub slide_steep: f32,
    /// Square of the slope at the contact's edge from which on it takes any.
    pub slide_steep_from: f32,
    /// By how much a deep bite makes the rim of a sliding tool narrower, over the square of how deep it is.
    pub slide_narrow: f32,
    /// By how much greater the force against the motion of a sliding tool is than its contact's shape makes it.
    pub slide_heap: f32,
    /// By how much larger the force is at which a hollow wall folds than that at which a plate does, over that, for each √(R·t) by which the tool
    /// reaches farther along the arc into the wall as it was than a part of that: under a point a wall folds about the point, under a long tool about a
    /// line as well.
    pub wall_wider: f32,
    /// That part.
    pub wall_wider_from: f32,
    /// By how much more a hollow wall gives way than an elastic one where the force on it is that at which it folds.
    pub wall_softer: f32,
    /// What clay on a core bears over what it bears there, less 1, for each unit of the fifth power of that force: clay that is strained by
    /// bending has less left for the tool.
    pub wall_weaker: f32,
    /// Share of what is pressed into a hollow wall by which its other skin goes along, for each unit by which the force is over a part of that at
    /// which the wall folds.
    pub wall_follows: f32,
    /// That part.
    pub wall_follows_from: f32,
    /// Share of what a hollow wall gives way more than an elastic one by that stays: a wall that has folded.
    pub wall_stays: f32,
    /// What a sum over columns leaves out at a side of a contact of what the column next to the outermost bears, where the outermost is only grazed:
    /// of quadrature, and not of clay.
    pub side_grazed: f32,
    /// By how much more that is for each part of the next one's that the outermost bears.
    pub side_by_part: f32,
    /// The same for that part's cube.
    pub side_by_cube: f32,
    /// By how much `side_by_part` is more for each column over which pressure rises at the edge.
    pub side_by_ramp: f32,
}

impl PlasticLaw {
    /// What `accuracy-chart fit` found.
    pub const FITTED: Self = Self {
        hardness: 2.662,
        hardness_by_slope: 0.195,
        hardness_by_layer: 0.204,
        hardness_strain: 4.488,
        recovery: 1.160,
        recovery_by_layer: 0.509,
        recovery_edge: 0.273,
        sink_width: 0.159,
        rim_rises: 0.594,
        rim_strain: 40.988,
        rim_width: 2.533,
        rim_around: 0.837,
        rim_ahead: 0.497,
        slide_bottom: 0.358,
        slide_rises: 0.491,
        slide_strain: 5.764,
        slide_open: 0.751,
        slide_soft: 0.295,
        slide_steep: 0.260,
        slide_steep_from: 0.345,
        slide_narrow: 3.231,
        slide_heap: 0.328,
        wall_wider: 1.784,
        wall_wider_from: 0.425,
        wall_softer: 0.221,
        wall_weaker: 0.49,
        wall_follows: 1.634,
        wall_follows_from: 0.409,
        wall_stays: 0.589,
        side_grazed: 0.112,
        side_by_part: -0.732,
        side_by_cube: 1.413,
        side_by_ramp: 0.396,
    };

    /// H/σ_y for a strain over the yield strain, the tool's slope at the edge of the contact, and the contact's radius over the
    /// clay's thickness.
    pub(super) fn hardness(&self, strain: f32, slope: f32, layer: f32) -> f32 {
        let flowing = self.hardness - self.hardness_by_slope * slope * slope - self.hardness_by_layer * layer;
        (flowing * strain / (strain + self.hardness_strain)).max(HARDNESS_MIN)
    }

    /// The force at which a hollow wall folds under a tool that reaches into it, as it was, so many times √(R·t) to either side along the arc, over
    /// that at which a plate does.
    pub(super) fn folds_from(&self, reach: f32) -> f32 {
        1.0 + self.wall_wider * (reach.min(WIDEST) - self.wall_wider_from).max(0.0)
    }

    /// What is left of the pressure on a hollow wall, for the fifth power of the force on it over that at which it folds.
    pub(super) fn unfolded(&self, folds: f32) -> f32 {
        1.0 / (1.0 + self.wall_weaker / (1.0 / folds + 1.0 / FOLDS_HALF))
    }

    /// By how much of a dent the other skin of a wall goes along, from the fifth power of how near it is to folding.
    pub(super) fn follows(&self, folds: f32) -> f32 {
        let near = libm::powf(folds, 0.2);
        (self.wall_follows * (near - self.wall_follows_from)).clamp(0.0, 1.0)
    }

    /// The factors of −q² and −q⁶ of the elastic depth inside of a contact.
    pub(super) fn bowl(&self, support: Support, layer: f32) -> [f32; 2] {
        match support {
            Support::Backed => {
                let flatter = self.recovery_by_layer * (layer - LAYER_BEGIN).max(0.0);
                [(NEAR - flatter).max(NEAR_MIN), self.recovery_edge]
            }
            Support::Hollow => [0.25, 0.113],
        }
    }

    /// Width of the sink outside of a contact, in q².
    pub(super) fn sink_width(&self, layer: f32) -> f32 {
        (self.sink_width / (layer * layer).max(1e-6)).min(SINK_WIDTH_MAX)
    }

    /// What is left of the pressure under a tool that slides by a share, has a slope at its edge and leans to an open side.
    pub(super) fn bears(&self, sliding: f32, slope: f32, open: f32) -> f32 {
        let steeper = (slope * slope - self.slide_steep_from).max(0.0);
        (1.0 - self.slide_soft * open) * (1.0 - self.slide_steep * sliding * steeper / (steeper + STEEP_HALF))
    }

    /// Width of the rim, in q², under a tool that slides by a share and has a slope at the edge of a contact whose shorter half axis is `layer`
    /// times as long as the clay is thick: clay that flows aside from a deep bite stands up steeply, since the wall lets it go no further.
    pub(super) fn rim_width(&self, sliding: f32, slope: f32, layer: f32) -> f32 {
        let deep = (slope * layer).min(DEEP_MAX);
        self.rim_width / (1.0 + self.slide_narrow * sliding * deep * deep)
    }

    /// Share of what yields now that comes back as a rim, under a tool that slides by a share and leans to an open side.
    pub(super) fn rim_share(&self, strain: f32, sliding: f32, open: f32) -> f32 {
        let part = strain * (1.0 + (self.slide_strain - 1.0) * sliding) / self.rim_strain;
        let rises = self.rim_rises + (self.slide_rises - self.rim_rises) * sliding;
        let share = rises * (1.0 - libm::expf(-part));
        (share + (1.0 - share) * (self.slide_open * open).min(1.0)).min(RISES_MAX)
    }

    /// What is left of the rim under a tool that is ahead of the clay by so much.
    pub(super) fn left_of_rim(&self, ahead: f32) -> f32 {
        1.0 - self.rim_ahead * ahead
    }

    /// By how much more the rim rises along the arc than along the height: the pot's slope across half a contact over the
    /// tool's is the ratio of their curvatures.
    pub(super) fn around(&self, pot_slope: f32, tool_slope: f32) -> f32 {
        (self.rim_around * pot_slope / tool_slope.max(SLOPE_MIN)).min(AROUND_MAX)
    }
}

impl Default for PlasticLaw {
    fn default() -> Self {
        Self::FITTED
    }
}

/// Elastic depth under the middle of an even pressure p on a disc of radius a, over p/E*, on a layer of thickness t that
/// slides on a rigid base, from a and `a/t`, m.
///
/// `2a/(1 + 0.62·a/t + 0.38·(a/t)²)`: within 2 % of the integral `2a·∫ J₁(ka)/k·(cosh 2kt − 1)/(sinh 2kt + 2kt) dk` for a/t
/// up to 1.3; for a thick layer it is Boussinesq's 2a.
pub(super) fn layer_depth_m(radius_m: f32, layer: f32) -> f32 {
    2.0 * radius_m / (1.0 + layer * (0.62 + 0.38 * layer))
}
