//! The teacher's token as people see it: 52 characters of the join code's alphabet.
//!
//! Owns how it is written and read; makes no randomness and no hash.
//! Invariant: a token that was printed reads back as itself, also in lower case and without its dashes.

use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

use super::TeacherToken;
use super::code::{base32, digit};

/// Characters of five bits for 256 bits; the last one carries one bit.
const LENGTH: usize = 52;

/// Why a text is no teacher's token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokenError {
    /// A character that no token has.
    #[error("'{0}' stands in no token: tokens are made of digits and letters without I, L, O and U")]
    Character(char),
    /// Too short or too long.
    #[error("a teacher's token has {LENGTH} characters, this one has {0}")]
    Length(usize),
    /// Bits that no token has.
    #[error("a character of the token is not as it was shown; copy it again")]
    Rest,
}

impl fmt::Display for TeacherToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // a byte more, for the characters to be whole
        let mut bytes = [0; 33];
        bytes[..32].copy_from_slice(&self.0);
        for (at, character) in base32(&bytes).take(LENGTH).enumerate() {
            if at > 0 && at % 4 == 0 {
                f.write_str("-")?;
            }
            write!(f, "{character}")?;
        }
        Ok(())
    }
}

impl FromStr for TeacherToken {
    type Err = TokenError;

    fn from_str(text: &str) -> Result<Self, TokenError> {
        let mut digits = Vec::with_capacity(LENGTH);
        for character in text.trim().chars().filter(|character| !matches!(character, '-' | ' ')) {
            digits.push(digit(character).ok_or(TokenError::Character(character))?);
        }
        if digits.len() != LENGTH {
            return Err(TokenError::Length(digits.len()));
        }
        let bit = |at: usize| digits[at / 5] >> (4 - at % 5) & 1;
        if (256..5 * LENGTH).any(|at| bit(at) == 1) {
            return Err(TokenError::Rest);
        }
        let mut bytes = [0_u8; 32];
        for at in 0..256 {
            bytes[at / 8] |= (bit(at) as u8) << (7 - at % 8);
        }
        Ok(Self(bytes))
    }
}
