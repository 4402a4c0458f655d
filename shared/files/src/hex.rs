//! 32 bytes, a hash say, as the 64 hexadecimal digits that files have them in.
//!
//! Invariant: what was written is read as the same bytes.

use core::fmt::Write as _;

/// The digits, small ones.
#[must_use]
pub fn to_hex(bytes: &[u8; 32]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("a string takes everything");
        text
    })
}

/// The bytes; none of what are not 64 digits.
///
/// ```
/// use pottery_files::hex::{from_hex, to_hex};
///
/// assert_eq!(from_hex(&to_hex(&[0x5A; 32])), Some([0x5A; 32]));
/// assert_eq!(from_hex("5a"), None);
/// ```
#[must_use]
pub fn from_hex(text: &str) -> Option<[u8; 32]> {
    let digits: Option<Vec<u8>> = text.chars().map(|digit| Some(digit.to_digit(16)? as u8)).collect();
    let digits = digits.filter(|digits| digits.len() == 64)?;
    let bytes: Vec<u8> = digits.as_chunks::<2>().0.iter().map(|[high, low]| high << 4 | low).collect();
    bytes.try_into().ok()
}
