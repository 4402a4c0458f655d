//! How a Falcon is woken up: FTDI's line settings, the boot loader's greeting, and the user's own firmware file.
//!
//! Sequence from libnifalcon's `FalconCommLibUSB.cpp` and `FalconFirmware.cpp`. No firmware comes with this program.
//! Invariant: firmware is taken for loaded only when every byte of it was echoed.

use std::time::{Duration, Instant};

use super::usb::{Usb, UsbFault};
use super::{DEVICE, gone};
use crate::device::DeviceFault;

/// FTDI's requests.
const RESET: u8 = 0;
const MODEM: u8 = 1;
const FLOW: u8 = 2;
const BAUD: u8 = 3;
const DATA: u8 = 4;
const LATENCY: u8 = 9;
const PURGE_IN: u16 = 1;
const PURGE_OUT: u16 = 2;
const DTR_LOW: u16 = 0x100;
const DTR_HIGH: u16 = 0x101;
const RTS_LOW: u16 = 0x200;
/// 9600, 140,000 and the firmware's own speed, as FTDI's divisors.
const DIVISOR_GREETING: u16 = 0x4138;
const DIVISOR_FIRMWARE: u16 = 0x15;
const DIVISOR_NORMAL: u16 = 0x2;
const EIGHT_BITS: u16 = 8;

const GREETING: [u8; 3] = [0x0a, 0x43, 0x0d];
const GREETED: [u8; 4] = [0x0a, 0x44, 0x2c, 0x0d];
const READY: u8 = 0x41;
/// Greetings after which there is no boot loader.
const GREETINGS_MAX: usize = 100;
/// Bytes of firmware sent at once: with two modem bytes the echo fills a USB packet.
const CHUNK_BYTES: usize = 62;
/// How long an answer of the boot loader may take.
const PATIENCE: Duration = Duration::from_millis(500);
/// Largest firmware file, bytes; the one of 2009 has 29 kB.
pub const FIRMWARE_BYTES_MAX: usize = 256 << 10;

/// Sets the line as the firmware uses it.
pub(super) fn set_normal(usb: &mut dyn Usb) -> Result<(), UsbFault> {
    for (number, value) in [(LATENCY, 1), (BAUD, DIVISOR_NORMAL), (RESET, PURGE_IN), (RESET, PURGE_OUT)] {
        usb.request(number, value)?;
    }
    Ok(())
}

/// Sends the firmware to the boot loader and leaves the line as the firmware uses it.
pub(super) fn load(usb: &mut dyn Usb, firmware: &[u8]) -> Result<(), DeviceFault> {
    greet(usb)?;
    for (chunk, bytes) in firmware.chunks(CHUNK_BYTES).enumerate() {
        usb.write(bytes).map_err(gone)?;
        let echo = read_bytes(usb, bytes.len(), PATIENCE).map_err(gone)?;
        if let Some(at) = (0..bytes.len()).find(|at| echo.get(*at) != bytes.get(*at)) {
            return Err(DeviceFault::Protocol {
                device: DEVICE,
                expected: "an echo of the firmware",
                found: match echo.get(at) {
                    Some(byte) => format!("{byte:#04x} for byte {}", chunk * CHUNK_BYTES + at),
                    None => format!("nothing for byte {}", chunk * CHUNK_BYTES + at),
                },
            });
        }
    }
    set_normal(usb).map_err(gone)
}

/// Brings the boot loader to where it takes firmware.
fn greet(usb: &mut dyn Usb) -> Result<(), DeviceFault> {
    let line = [
        (RESET, PURGE_IN),
        (RESET, PURGE_OUT),
        (LATENCY, 16),
        (BAUD, DIVISOR_GREETING),
        (DATA, EIGHT_BITS),
        (FLOW, 0),
        (MODEM, RTS_LOW),
        (MODEM, DTR_LOW),
        (MODEM, DTR_HIGH),
    ];
    for (number, value) in line {
        usb.request(number, value).map_err(gone)?;
    }
    let mut greeted = false;
    let begin = Instant::now();
    for _ in 0..GREETINGS_MAX {
        usb.write(&GREETING).map_err(gone)?;
        // some systems put a zero before it
        let answer = read_bytes(usb, GREETED.len(), PATIENCE).map_err(gone)?;
        greeted = answer.ends_with(&GREETED) || answer.strip_prefix(&[0]).is_some_and(|rest| GREETED.starts_with(rest));
        if greeted || begin.elapsed() > 4 * PATIENCE {
            break;
        }
    }
    if !greeted {
        return Err(DeviceFault::Protocol {
            device: DEVICE,
            expected: "its boot loader's greeting",
            found: "none; unplug its power for a moment".into(),
        });
    }
    usb.request(MODEM, DTR_LOW).map_err(gone)?;
    usb.request(BAUD, DIVISOR_FIRMWARE).map_err(gone)?;
    usb.write(&[READY]).map_err(gone)?;
    let answer = read_bytes(usb, 1, PATIENCE).map_err(gone)?;
    if answer.last() != Some(&READY) {
        return Err(DeviceFault::Protocol {
            device: DEVICE,
            expected: "0x41, ready for firmware",
            found: format!("{answer:02x?}"),
        });
    }
    Ok(())
}

/// Reads until `count` bytes have come besides the modem bytes, or none more in time.
fn read_bytes(usb: &mut dyn Usb, count: usize, patience: Duration) -> Result<Vec<u8>, UsbFault> {
    let (mut bytes, mut packet) = (Vec::new(), [0; 64]);
    let begin = Instant::now();
    while bytes.len() < count && begin.elapsed() < patience {
        let read = usb.read(&mut packet, patience)?;
        bytes.extend_from_slice(packet.get(2..read).unwrap_or_default());
    }
    Ok(bytes)
}
