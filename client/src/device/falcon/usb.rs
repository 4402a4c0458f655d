//! The few things the Falcon's driver needs of USB, so that a scripted Falcon can stand in their place.
//!
//! Invariant: nothing here knows what the bytes mean.

use std::fmt::Debug;
use std::time::Duration;

use crate::device::DeviceFault;

/// The maker's and the product's number.
pub const FALCON: (u16, u16) = (0x0403, 0xcb48);

/// What went wrong on the way.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UsbFault {
    /// The device is no longer there.
    #[error("it is no longer on the bus")]
    Gone,
    /// Anything else, in the system's words.
    #[error("{0}")]
    Transfer(String),
}

/// An opened Falcon.
pub trait Usb: Send + Debug {
    /// A vendor's request to the device with the given number and value (FTDI's `0x40`, index 0, no data).
    ///
    /// # Errors
    /// [`UsbFault`].
    fn request(&mut self, number: u8, value: u16) -> Result<(), UsbFault>;

    /// Sends bytes to endpoint 0x02.
    ///
    /// # Errors
    /// [`UsbFault`].
    fn write(&mut self, bytes: &[u8]) -> Result<(), UsbFault>;

    /// Fetches one USB packet of at most 64 bytes from endpoint 0x81, with the two modem bytes that each begins with; 0 when
    /// none came in time.
    ///
    /// # Errors
    /// [`UsbFault`].
    fn read(&mut self, into: &mut [u8; 64], patience: Duration) -> Result<usize, UsbFault>;
}

/// Where Falcons are plugged in.
pub trait Bus: Send + 'static {
    /// How many there are.
    ///
    /// # Errors
    /// [`DeviceFault`] when the bus cannot be looked at.
    fn count(&mut self) -> Result<usize, DeviceFault>;

    /// Opens the n-th.
    ///
    /// # Errors
    /// [`DeviceFault`] with what to do.
    fn open(&mut self, number: usize) -> Result<Box<dyn Usb>, DeviceFault>;
}
