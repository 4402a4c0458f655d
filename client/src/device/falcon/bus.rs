//! USB as the system has it, through `nusb`: no C library, no driver of the maker's.
//!
//! Invariant: a transfer for reading stays under way until something has come, so that a late packet is not lost.

use std::time::Duration;

use nusb::transfer::{Bulk, Completion, ControlOut, ControlType, In, Out, Recipient, TransferError};
use nusb::{Endpoint, Interface, MaybeFuture};

use super::DEVICE;
use super::usb::{Bus, FALCON, Usb, UsbFault};
use crate::device::DeviceFault;

const OUT: u8 = 0x02;
const IN: u8 = 0x81;
/// How long the device may take for a request or for taking bytes.
const PATIENCE: Duration = Duration::from_secs(1);

/// The machine's own USB.
#[derive(Clone, Copy, Debug, Default)]
pub struct UsbBus;

fn falcons() -> Result<Vec<nusb::DeviceInfo>, DeviceFault> {
    let listed = nusb::list_devices().wait().map_err(|error| DeviceFault::NotFound {
        device: DEVICE,
        reason: format!("USB cannot be looked at ({error})"),
        remedy: "check that this machine has USB and lets you use it".into(),
    })?;
    Ok(listed.filter(|device| (device.vendor_id(), device.product_id()) == FALCON).collect())
}

impl Bus for UsbBus {
    fn count(&mut self) -> Result<usize, DeviceFault> {
        Ok(falcons()?.len())
    }

    fn open(&mut self, number: usize) -> Result<Box<dyn Usb>, DeviceFault> {
        // it was counted just now
        let gone = || DeviceFault::Gone { device: DEVICE, reason: UsbFault::Gone.to_string() };
        let falcon = falcons()?.into_iter().nth(number).ok_or_else(gone)?;
        let refused = |error: nusb::Error| DeviceFault::Unusable {
            device: DEVICE,
            reason: error.to_string(),
            remedy: "end other programs that use it; on Linux, a udev rule has to let you use USB device 0403:cb48"
                .into(),
        };
        let device = falcon.open().wait().map_err(refused)?;
        // the system may have taken it for a serial port
        let interface = device.detach_and_claim_interface(0).wait().map_err(refused)?;
        let output = interface.endpoint::<Bulk, Out>(OUT).map_err(refused)?;
        let input = interface.endpoint::<Bulk, In>(IN).map_err(refused)?;
        Ok(Box::new(Opened { interface, output, input }))
    }
}

#[derive(Debug)]
struct Opened {
    interface: Interface,
    output: Endpoint<Bulk, Out>,
    input: Endpoint<Bulk, In>,
}

fn fault(error: TransferError) -> UsbFault {
    match error {
        TransferError::Disconnected => UsbFault::Gone,
        error => UsbFault::Transfer(error.to_string()),
    }
}

fn status(completion: &Completion) -> Result<(), UsbFault> {
    completion.status.map_err(fault)
}

impl Usb for Opened {
    fn request(&mut self, number: u8, value: u16) -> Result<(), UsbFault> {
        let request = ControlOut {
            control_type: ControlType::Vendor,
            recipient: Recipient::Device,
            request: number,
            value,
            index: 0,
            data: &[],
        };
        self.interface.control_out(request, PATIENCE).wait().map_err(fault)
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), UsbFault> {
        status(&self.output.transfer_blocking(bytes.to_vec().into(), PATIENCE))
    }

    fn read(&mut self, into: &mut [u8; 64], patience: Duration) -> Result<usize, UsbFault> {
        if self.input.pending() == 0 {
            let buffer = self.input.allocate(into.len());
            self.input.submit(buffer);
        }
        let Some(completion) = self.input.wait_next_complete(patience) else { return Ok(0) };
        status(&completion)?;
        let bytes = &completion.buffer[..completion.actual_len];
        into[..bytes.len()].copy_from_slice(bytes);
        Ok(bytes.len())
    }
}
