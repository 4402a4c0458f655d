//! The join code that people type: the room, and which server it may be.
//!
//! Owns the alphabet and its forgiving reading; makes no randomness of its own.
//! Invariant: a code that was printed reads back as itself, also in lower case and without its dashes.

use alloc::string::String;
use core::fmt;
use core::str::FromStr;

/// Crockford's base 32: no I, L, O or U to be mistaken.
const ALPHABET: &[u8; 32] = b"0123456789ABCDEFGHJKMNPQRSTVWXYZ";
const ROOM_LENGTH: usize = 8;
const PRINT_LENGTH: usize = 16;

/// Eight characters for the room; sixteen more, where given, are the first 80 bits of the SHA-256 of the server's
/// certificate, so that nobody in between can pretend to be it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JoinCode {
    room: String,
    print: Option<[u8; 10]>,
}

/// Why a text is no join code.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum JoinCodeError {
    /// A character that no code has.
    #[error("'{0}' stands in no join code: codes are made of digits and letters without I, L, O and U")]
    Character(char),
    /// Too short or too long.
    #[error("a join code has 8 or 24 characters, this one has {0}")]
    Length(usize),
}

impl JoinCode {
    /// Bytes of the certificate's SHA-256 in a code.
    pub const PRINT_BYTES: usize = 10;

    /// The code of the room that 40 random bits name, on the server with this certificate.
    #[must_use]
    pub fn new(random: [u8; 5], certificate_sha256: &[u8; 32]) -> Self {
        Self { room: Self::room_of(random), print: None }.on_server(certificate_sha256)
    }

    /// The room's part of the code that 40 random bits name.
    #[must_use]
    pub fn room_of(random: [u8; 5]) -> String {
        base32(&random).collect()
    }

    /// The same room on the server with this certificate.
    #[must_use]
    pub fn on_server(mut self, certificate_sha256: &[u8; 32]) -> Self {
        self.print = certificate_sha256.first_chunk().copied();
        self
    }

    /// The room's part.
    #[must_use]
    pub fn room(&self) -> &str {
        &self.room
    }

    /// The certificate's part, when the code has one.
    #[must_use]
    pub const fn print(&self) -> Option<&[u8; Self::PRINT_BYTES]> {
        self.print.as_ref()
    }
}

/// Characters of five bits each, highest first.
pub(super) fn base32(bytes: &[u8]) -> impl Iterator<Item = char> + '_ {
    (0..bytes.len() * 8 / 5).map(move |at| {
        let value = (0..5).fold(0_usize, |value, bit| {
            let bit = at * 5 + bit;
            value << 1 | usize::from(bytes[bit / 8] >> (7 - bit % 8) & 1)
        });
        char::from(ALPHABET[value])
    })
}

/// The value of a character, also of one that was mistaken for another.
pub(super) fn digit(character: char) -> Option<usize> {
    let upper = match character.to_ascii_uppercase() {
        'I' | 'L' => '1',
        'O' => '0',
        other => other,
    };
    ALPHABET.iter().position(|&known| char::from(known) == upper)
}

impl fmt::Display for JoinCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let print = self.print.iter().flat_map(|print| base32(print));
        for (at, character) in self.room.chars().chain(print).enumerate() {
            if at > 0 && at % 4 == 0 {
                f.write_str("-")?;
            }
            write!(f, "{character}")?;
        }
        Ok(())
    }
}

impl FromStr for JoinCode {
    type Err = JoinCodeError;

    fn from_str(text: &str) -> Result<Self, JoinCodeError> {
        let mut digits = alloc::vec::Vec::with_capacity(ROOM_LENGTH + PRINT_LENGTH);
        for character in text.chars().filter(|character| !matches!(character, '-' | ' ')) {
            digits.push(digit(character).ok_or(JoinCodeError::Character(character))?);
        }
        if digits.len() != ROOM_LENGTH && digits.len() != ROOM_LENGTH + PRINT_LENGTH {
            return Err(JoinCodeError::Length(digits.len()));
        }
        let (room, print) = digits.split_at(ROOM_LENGTH);
        let room = room.iter().map(|&digit| char::from(ALPHABET[digit])).collect();
        if print.is_empty() {
            return Ok(Self { room, print: None });
        }
        let mut bytes = [0_u8; Self::PRINT_BYTES];
        for bit in 0..bytes.len() * 8 {
            let set = print[bit / 5] >> (4 - bit % 5) & 1 == 1;
            bytes[bit / 8] |= u8::from(set) << (7 - bit % 8);
        }
        Ok(Self { room, print: Some(bytes) })
    }
}
