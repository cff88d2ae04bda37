//! The 1200-baud touch: how flashing tools ask a board on USB for its boot loader.
//!
//! # Design
//! A tool opens the port at 1200 baud and closes it. So the touch is 1200 baud *and* DTR down, whichever comes last, as
//! arduino-pico has it; pico-sdk takes the rate alone, and tools for it close the port as well. It is the safer one of the two:
//! a port that a program holds open has DTR up, so nobody pulls the machine from under a sender, and one who opens a
//! terminal at the wrong rate can still change it. After a bus reset, a cable pulled out, there is no rate.
//!
//! The CDC-ACM class tells of the rate only to those who own its endpoints, which the console does: hence a handler of
//! our own, which looks at the requests and leaves them to the class.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_usb::Handler;
use embassy_usb::control::{OutResponse, Recipient, Request, RequestType};

/// No sender uses this rate, and every tool knows it.
const TOUCH_BAUD: u32 = 1200;
const SET_LINE_CODING: u8 = 0x20;
const SET_CONTROL_LINE_STATE: u8 = 0x22;
const DTR: u16 = 1;

static TOUCHED: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Waits for a touch.
///
/// # Cancellation
/// Safe: a touch that comes meanwhile is known to the next call.
pub async fn touched() {
    TOUCHED.wait().await;
}

/// Looks at what the host asks of the serial port.
pub struct Touch {
    baud: u32,
    dtr: bool,
}

impl Touch {
    /// No rate yet.
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
