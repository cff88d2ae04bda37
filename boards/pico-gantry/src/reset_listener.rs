//! Detects a second reset byte from the USB host before the console runs.
//!
//! # Design
//! The console reads in thread mode, and waits while the axes write their blocks: up to 0.1 ms at full speed. But a
//! packet is in the USB controller's memory from its arrival until the driver has read it. So this searches for the
//! byte in the interrupt that reports the packet. If the machine is still braking for an earlier reset, it is stopped
//! at once. The console reads the same byte later and does the rest. A machine that has already been stopped is not
//! affected by that.
#![expect(unsafe_code, reason = "interrupt handlers are unsafe, and a packet is read where the hardware has put it")]

use embassy_rp::interrupt::typelevel::{Handler, USBCTRL_IRQ};
use embassy_rp::pac::usb_dpram::vals::EpControlEndpointType;
use embassy_rp::pac::{USB, USB_DPRAM};

use crate::guard;

/// Grbl's soft reset, ctrl-X.
const RESET: u8 = 0x18;
/// Endpoint 0 carries no data; there are fifteen others.
const ENDPOINTS: core::ops::Range<usize> = 1..16;
const PACKET_BYTES: usize = 64;

/// Must be bound before the driver's own handler, which acknowledges the packets.
pub struct ResetListener;

impl Handler<USBCTRL_IRQ> for ResetListener {
    // SAFETY: it only reads registers and packets, and reports to the machine, which is allowed in any context.
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
