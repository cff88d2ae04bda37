//! A second reset byte from the USB host, heard before the console gets to run.
//!
//! # Design
//! The console reads in thread mode, and waits there while the axes write their blocks: up to 0.1 ms at full speed. But a
//! packet lies in the USB controller's memory from the moment it has come until the driver has read it. So this looks
//! for the byte in the interrupt that tells of the packet, and if the machine still brakes for a reset before it, stops it
//! there and then. The console comes upon the same byte later and does the rest; a machine that has been stopped does not
//! mind.
#![expect(unsafe_code, reason = "interrupt handlers are unsafe, and a packet is read where the hardware has put it")]

use embassy_rp::interrupt::typelevel::{Handler, USBCTRL_IRQ};
use embassy_rp::pac::usb_dpram::vals::EpControlEndpointType;
use embassy_rp::pac::{USB, USB_DPRAM};

use crate::guard;

/// Grbl's soft reset, ctrl-X.
const RESET: u8 = 0x18;
/// Endpoint 0 carries no data, and there are fifteen others.
const ENDPOINTS: core::ops::Range<usize> = 1..16;
const PACKET_BYTES: usize = 64;

/// To be bound before the driver's own handler, which takes note of the packets.
pub struct ResetListener;

impl Handler<USBCTRL_IRQ> for ResetListener {
    // SAFETY: only reads registers and packets, and tells the machine, which may be told from any context.
    unsafe fn on_interrupt() {
        let arrived = USB.buff_status().read();
        if ENDPOINTS.filter(|&endpoint| arrived.ep_out(endpoint)).any(carries_reset) {
            guard::reset_heard();
        }
    }
}

fn carries_reset(endpoint: usize) -> bool {
    let control = USB_DPRAM.ep_out_control(endpoint - 1).read();
    if control.endpoint_type() != EpControlEndpointType::BULK {
        return false;
    }
    let start = usize::from(control.buffer_address());
    let length = usize::from(USB_DPRAM.ep_out_buffer_control(endpoint).read().length(0)).min(PACKET_BYTES);
    let memory = USB_DPRAM.as_ptr().cast::<u8>();
    // SAFETY: the driver keeps a packet's buffer within the controller's 4 KiB of memory, where any byte may be read.
    (start..start + length).any(|offset| unsafe { memory.add(offset).read_volatile() } == RESET)
}
