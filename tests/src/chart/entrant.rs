//! The table of what is compared: the studio's methods and the yardsticks.
//!
//! A row is all that a method or a yardstick needs to stand in every file and picture.
//! Invariant: names are unique; a row's colour and mark follow from its place.

use pottery_shared::clay::{self, GridShape, MethodKind, PotSpec};

use super::ChartError;
use super::cases::{FINGER, Support};
use crate::dent::{Dent, DentError, Dented, Pressing};
use crate::yardstick::{free_form, greens, literal, long_elements};

/// What answers a press.
#[derive(Clone, Copy, Debug)]
pub enum Model {
    /// A method of the studio, which can be advanced step by step.
    Method(MethodKind),
    /// A yardstick, which is asked for a whole dent.
    Yardstick {
        /// The dent.
        dent: fn(&Dent) -> Result<Dented, DentError>,
        /// Most columns of a grid on which it is asked: more would take too long.
        columns_max: u32,
        /// One step with a tool at an angle, depth and height, m, on clay that turns, for one that can be advanced.
        step: Option<Step>,
    },
}

/// One step of a tool as [`Pressing::step`] has it.
pub type Step = fn(&mut Pressing, f32, f32, f32, i8) -> f32;

/// A row of the table.
#[derive(Clone, Copy, Debug)]
pub struct Entrant {
    /// Its name in files.
    pub name: &'static str,
    /// Its name in pictures and prose.
    pub title: &'static str,
    /// What it is.
    pub model: Model,
    /// Supports of the wall that it takes into account; a method is pressed on the others too, a yardstick is not.
    pub supports: &'static [Support],
    /// When to choose it, as a sentence.
    pub choose: &'static str,
}

/// What is compared.
pub const ENTRANTS: &[Entrant] = &[
    Entrant {
        name: "ours",
        title: "ours",
        model: Model::Method(MethodKind::Plastic),
        supports: &[Support::Backed, Support::Hollow, Support::Finger],
        choose: "Choose it by default: it is the only one whose clay holds a still tool, springs back, rises round the dent \
                 and pushes back with the force of clay.",
    },
    Entrant {
        name: "original",
        title: "original CSEM",
        model: Model::Method(MethodKind::Original),
        supports: &[],
        choose: "Choose it on a machine too slow for anything else, or to compare with the first paper: it takes the tool's \
                 shape and nothing more, all displaced clay vanishes, and a tool that rests sinks without end.",
    },
    Entrant {
        name: "improved",
        title: "improved CSEM",
        model: Model::Method(MethodKind::Improved),
        supports: &[],
        choose: "Choose it to compare with the second paper, or for its look: edges become round, but on a backed wall the \
                 clay beside a dent sinks where real clay rises.",
    },
    Entrant {
        name: "literal",
        title: "improved CSEM, literal",
        model: Model::Yardstick {
            dent: literal::press,
            // on finer ones the hole runs away, and a step with it
            columns_max: 360,
            step: Some(literal::step),
        },
        supports: &[Support::Backed],
        choose: "A yardstick for what the second paper costs as it is written: every hull of every boundary element by itself, \
                 and dents that grow with the resolution.",
    },
    Entrant {
        name: "free-form",
        title: "free-form deformation",
        model: Model::Yardstick { dent: free_form::press, columns_max: 1440, step: None },
        supports: &[Support::Backed],
        choose: "A yardstick for drawing shapes: it has neither a force nor a material, and rings between its control points.",
    },
    Entrant {
        name: "long-elements",
        title: "long elements",
        model: Model::Yardstick { dent: long_elements::press, columns_max: 1440, step: None },
        supports: &[Support::Backed, Support::Hollow],
        choose: "A yardstick for soft bodies that are full of liquid: all of it springs back, so that nothing can be shaped.",
    },
    Entrant {
        name: "greens",
        title: "Green's functions",
        model: Model::Yardstick {
            dent: greens::press,
            // it solves on no finer grid
            columns_max: 360,
            step: None,
        },
        supports: &[Support::Backed, Support::Hollow],
        choose: "A yardstick for what is elastic, and exact there; nothing stays when the tool has gone.",
    },
];

impl Entrant {
    /// The method, when it is one.
    #[must_use]
    pub const fn method(&self) -> Option<MethodKind> {
        match self.model {
            Model::Method(method) => Some(method),
            Model::Yardstick { .. } => None,
        }
    }

    /// Whether it is asked for dents on a grid.
    #[must_use]
    pub const fn takes(&self, grid: GridShape) -> bool {
        match self.model {
            Model::Method(_) => true,
            Model::Yardstick { columns_max, .. } => grid.columns() <= columns_max,
        }
    }

    /// Whether it is asked for dents with a support of the wall.
    #[must_use]
    pub fn stands_on(&self, support: Support) -> bool {
        self.method().is_some() || self.supports.contains(&support)
    }

    /// The dent that it makes in a wall with a support.
    ///
    /// # Errors
    /// [`ChartError`] when the press makes no sense.
    pub fn dent(&self, dent: &Dent, support: Support) -> Result<Dented, ChartError> {
        // who does not know of a finger inside takes the wall as backed
        let is_known = self.supports.contains(&support);
        let is_free = support == Support::Hollow || support == Support::Finger && is_known;
        let behind = if is_free { clay::Support::Hollow } else { clay::Support::Backed };
        let finger = (support == Support::Finger && is_known).then_some(FINGER);
        let dent = Dent { pot: PotSpec { support: behind, ..dent.pot }, finger, ..*dent };
        Ok(match self.model {
            Model::Method(method) => Dent { method, ..dent }.press()?,
            Model::Yardstick { dent: press, .. } => press(&dent)?,
        })
    }
}

/// What of the table can be advanced step by step, with its place in it, the method that makes its pot and its own step.
pub fn stepping() -> impl Iterator<Item = (usize, MethodKind, Step)> {
    ENTRANTS.iter().enumerate().filter_map(|(row, entrant)| match entrant.model {
        Model::Method(method) => Some((row, method, Pressing::step as Step)),
        Model::Yardstick { step, .. } => Some((row, MethodKind::Original, step?)),
    })
}

/// The methods of the table with their places in it.
pub fn methods() -> impl Iterator<Item = (usize, MethodKind)> {
    ENTRANTS.iter().enumerate().filter_map(|(row, entrant)| Some((row, entrant.method()?)))
}
