//! The 1200-baud touch: how flashing tools ask a board on USB for its boot loader.
//!
//! # Design
//! A tool opens the port at 1200 baud and closes it. So the touch is 1200 baud *and* DTR low, in either order, as in
//! arduino-pico. pico-sdk needs the rate only, but the tools for it also close the port. Requiring both is safer: a
//! port that a program holds open has DTR high, so no other program can restart the machine under a sender. Someone who
//! opens a terminal at the wrong rate can still change it. After a bus reset, as when a cable was pulled out, there is
//! no rate.
//!
//! The CDC-ACM class reports the rate only to the owner of its endpoints, which is the console. So this is a handler of
//! our own, which looks at the requests and leaves them to the class.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_usb::Handler;
use embassy_usb::control::{OutResponse, Recipient, Request, RequestType};

/// No sender uses this rate, and every flashing tool knows it.
const TOUCH_BAUD: u32 = 1200;
const SET_LINE_CODING: u8 = 0x20;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
const DTR: u16 = 1;

static TOUCHED: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Waits for a touch.
///
/// # Cancellation
/// Safe: the next call returns for a touch that comes in between.
pub async fn touched() {
    TOUCHED.wait().await;
}

/// Observes the host's requests to the serial port.
pub struct Touch {
    baud: u32,
    dtr: bool,
}

impl Touch {
    /// Initially there is no rate.
    pub const fn new() -> Self {
        Self { baud: 0, dtr: false }
    }
}

impl Handler for Touch {
    fn reset(&mut self) {
        *self = Self::new();
    }

    fn control_out(&mut self, request: Request, data: &[u8]) -> Option<OutResponse> {
        if (request.request_type, request.recipient) != (RequestType::Class, Recipient::Interface) {
            return None;
        }
        match (request.request, data.first_chunk()) {
            (SET_LINE_CODING, Some(&baud)) => self.baud = u32::from_le_bytes(baud),
            (SET_CONTROL_LINE_STATE, _) => self.dtr = request.value & DTR != 0,
            _ => return None,
        }
        if self.baud == TOUCH_BAUD && !self.dtr {
            TOUCHED.signal(());
        }
        None
    }
}
