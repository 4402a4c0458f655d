//! What the pot is shown as: raw clay, or as it may look once it is fired and glazed.
//!
//! Owns the materials' figures; the shader in `body.wgsl` makes the pixels of them.
//! Invariant: a finish changes no clay, only its picture.

use bytemuck::{Pod, Zeroable};

/// A look of the pot.
///
/// Colours are by eye after what potters call them; what is physical is how a glaze lies. It is a layer of glass that is
/// thicker in hollows and thinner on edges, and light fades in it by the law of Beer and Lambert.
///
/// ```
/// use pottery_client::render::Finish;
///
/// assert_eq!(Finish::from_name("celadon"), Some(Finish::Celadon));
/// assert_eq!(Finish::default(), Finish::Clay);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Finish {
    /// Clay as it is on the wheel, wet or dry.
    #[default]
    Clay,
    /// Fired once and bare.
    Biscuit,
    /// A thin green glaze over pale stoneware that pools in grooves.
    Celadon,
    /// A dark iron glaze that breaks to rust on edges.
    Tenmoku,
    /// An opaque white glaze, through which the body shows where it is thin.
    TinWhite,
    /// A clear blue glaze over porcelain.
    Cobalt,
}

/// `struct Finish` of `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct FinishUniform {
    body: [f32; 3],
    is_fired: f32,
    absorbed: [f32; 3],
    opacity: f32,
    scattered: [f32; 3],
    gloss: f32,
}

impl Finish {
    /// All of them, in the order in which they are offered.
    pub const ALL: [Self; 6] = [Self::Clay, Self::Biscuit, Self::Celadon, Self::Tenmoku, Self::TinWhite, Self::Cobalt];

    /// Its name on the command line and in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clay => "clay",
            Self::Biscuit => "biscuit",
            Self::Celadon => "celadon",
            Self::Tenmoku => "tenmoku",
            Self::TinWhite => "tin-white",
            Self::Cobalt => "cobalt",
        }
    }

    /// The one of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|finish| finish.name() == name)
    }

    /// The next one, and after the last the first.
    #[must_use]
    pub fn next(self) -> Self {
        let at = Self::ALL.iter().position(|finish| *finish == self).unwrap_or(0);
        Self::ALL[(at + 1) % Self::ALL.len()]
    }

    /// Linear RGB and shares; absorption for a glaze of usual thickness.
    pub(super) const fn uniform(self) -> FinishUniform {
        const BARE: FinishUniform = FinishUniform {
            body: [0.62, 0.30, 0.17],
            is_fired: 1.0,
            absorbed: [0.0; 3],
            opacity: 0.0,
            scattered: [0.0; 3],
            gloss: 0.0,
        };
        match self {
            Self::Clay => FinishUniform { is_fired: 0.0, ..BARE },
            Self::Biscuit => BARE,
            Self::Celadon => FinishUniform {
                body: [0.66, 0.64, 0.58],
                absorbed: [0.62, 0.22, 0.42],
                opacity: 0.25,
                scattered: [0.62, 0.75, 0.66],
                gloss: 1.0,
                ..BARE
            },
            Self::Tenmoku => {
                FinishUniform { body: [0.46, 0.27, 0.15], absorbed: [2.5, 3.6, 4.4], opacity: 0.0, gloss: 1.15, ..BARE }
            }
            Self::TinWhite => FinishUniform {
                body: [0.52, 0.26, 0.15],
                absorbed: [0.01, 0.02, 0.05],
                opacity: 2.6,
                scattered: [0.80, 0.78, 0.73],
                gloss: 0.85,
                ..BARE
            },
            Self::Cobalt => FinishUniform {
                body: [0.80, 0.79, 0.76],
                absorbed: [2.3, 1.35, 0.30],
                opacity: 0.0,
                gloss: 1.1,
                ..BARE
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_finish_has_a_name_and_comes_round() {
        let mut finish = Finish::default();
        for expected in Finish::ALL {
            assert_eq!(finish, expected);
            assert_eq!(Finish::from_name(finish.name()), Some(finish));
            finish = finish.next();
        }
        assert_eq!(finish, Finish::default());
    }
}
