//! How numbers and addresses of a settings file are read, so that who writes something else is told what to write.
//!
//! Owns what a whole number is and its words; what stands where is the file's affair.
//! Invariant: what is told can be written in its place.

use std::net::SocketAddr;

use serde::de::{Deserialize as _, Deserializer, Error as _};
use toml::Value;

/// Most of what is counted without a bound of its own.
pub(crate) const MOST: u32 = 1_000_000_000;

/// A whole number from `LEAST` to `MOST`.
///
/// # Errors
/// Whatever else stands there.
pub(crate) fn whole<'de, D: Deserializer<'de>, T: From<u32>, const LEAST: u32, const MOST: u32>(
    from: D,
) -> Result<T, D::Error> {
    let written = Value::deserialize(from)?.as_integer().and_then(|number| u32::try_from(number).ok());
    let number = written.filter(|number| (LEAST..=MOST).contains(number));
    number.map(T::from).ok_or_else(|| D::Error::custom(format!("choose a whole number from {LEAST} to {MOST}")))
}

/// A number, whose range is looked at later.
///
/// # Errors
/// Whatever else stands there.
pub(crate) fn number<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f32>, D::Error> {
    match Value::deserialize(from)? {
        Value::Float(number) => Ok(Some(number as f32)),
        Value::Integer(number) => Ok(Some(number as f32)),
        _ => Err(D::Error::custom("write a number, such as 2.5")),
    }
}

/// An address to listen on.
///
/// # Errors
/// Whatever else stands there.
pub(crate) fn address<'de, D: Deserializer<'de>>(from: D) -> Result<Option<SocketAddr>, D::Error> {
    let written = Value::deserialize(from)?;
    crate::address(written.as_str().unwrap_or_default()).map(Some).map_err(D::Error::custom)
}
