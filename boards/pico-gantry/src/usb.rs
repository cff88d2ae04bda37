//! The console on USB: a CDC-ACM serial port.
//!
//! # Design
//! A serial port does not know whether anyone is listening, and Grbl never waits for its reader. So a host that stops
//! reading costs the console one time-out. After that, replies are discarded until the endpoint is free again. Replies
//! are also discarded until the port is opened (DTR) or written to, so that whoever opens it finds the welcome line and
//! nothing old.

use core::pin::pin;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::Spawner;
use embassy_rp::peripherals::USB;
use embassy_rp::usb::{Driver, InterruptHandler};
use embassy_rp::{Peri, bind_interrupts};
use embassy_time::{Duration, with_timeout};
use embassy_usb::class::cdc_acm::{BufferedReceiver, CdcAcmClass, CdcAcmError, ControlChanged, Sender, State};
use embassy_usb::{Builder, Config, UsbDevice};
use embedded_io_async::{ErrorType, Read, Write};
use isostep_motion::cold_path;
use static_cell::StaticCell;

use crate::chip;
use crate::reset_listener::ResetListener;
use crate::touch::Touch;

bind_interrupts!(struct Irqs {
    USBCTRL_IRQ => ResetListener, InterruptHandler<USB>;
});

type RpDriver = Driver<'static, USB>;

/// Raspberry Pi's.
const VENDOR_ID: u16 = 0x2E8A;
const PACKET_BYTES: usize = 64;
/// After a full packet, an empty one would be needed before the data reaches the host's program.
const CHUNK_BYTES: usize = PACKET_BYTES - 1;
/// A host polls the endpoint every millisecond. One that has not done so for this long is gone.
const HOST_PATIENCE: Duration = Duration::from_millis(200);

/// A program has opened the port or written to it.
static IS_OPEN: AtomicBool = AtomicBool::new(false);

/// The serial port: both directions and the modem lines.
pub struct UsbPort {
    pub rx: UsbRx,
    pub tx: Tx,
    pub lines: Lines,
}

/// Starts the device and returns its port.
pub fn open(spawner: Spawner, usb: Peri<'static, USB>) -> UsbPort {
    static DESCRIPTORS: StaticCell<[[u8; 128]; 3]> = StaticCell::new();
    static RX: StaticCell<[u8; PACKET_BYTES]> = StaticCell::new();
    static STATE: StaticCell<State> = StaticCell::new();
    static TOUCH: StaticCell<Touch> = StaticCell::new();
    let [configuration, bos, control] = DESCRIPTORS.init([[0; 128]; 3]);
    let mut builder = Builder::new(Driver::new(usb, Irqs), config(), configuration, bos, &mut [], control);
    // Before the class, which does not pass requests on.
    builder.handler(TOUCH.init(Touch::new()));
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_BYTES as u16);
    let (sender, receiver, control) = class.split_with_control();
    let rx = UsbRx { receiver: receiver.into_buffered(RX.init([0; PACKET_BYTES])) };
    spawner.spawn(run(builder.build()).unwrap());
    UsbPort { rx, tx: Tx { sender, stalled: false }, lines: Lines { control } }
}

/// Requests of the host to the device itself may wait: it does so when it is connected and when a program opens the port,
/// and waits for the answer.
#[embassy_executor::task]
async fn run(mut device: UsbDevice<'static, RpDriver>) -> ! {
    cold_path(pin!(device.run())).await
}

fn config() -> Config<'static> {
    let mut config = Config::new(VENDOR_ID, chip::USB_PRODUCT_ID);
    config.manufacturer = Some("Isostep");
    config.product = Some(chip::USB_PRODUCT);
    config.serial_number = Some("ISOSTEP-1");
    config
}

/// Receives what the host sends.
pub struct UsbRx {
    receiver: BufferedReceiver<'static, RpDriver>,
}

impl UsbRx {
    /// Waits until the host has configured the device.
    ///
    /// # Cancellation
    /// Safe: it changes nothing.
    pub async fn wait_connection(&mut self) {
        self.receiver.wait_connection().await;
    }
}

impl ErrorType for UsbRx {
    type Error = CdcAcmError;
}

impl Read for UsbRx {
    async fn read(&mut self, buffer: &mut [u8]) -> Result<usize, CdcAcmError> {
        let count = self.receiver.read(buffer).await?;
        IS_OPEN.store(true, Ordering::Relaxed);
        Ok(count)
    }
}

/// Sends to the host, if the host reads.
pub struct Tx {
    sender: Sender<'static, RpDriver>,
    /// True if the last packet was discarded.
    stalled: bool,
}

impl Tx {
    /// True if the host took the packet in time.
    async fn send(&mut self, packet: &[u8], patience: Duration) -> bool {
        with_timeout(patience, self.sender.write_packet(packet)).await.is_ok()
    }
}

impl ErrorType for Tx {
    type Error = CdcAcmError;
}

impl Write for Tx {
    /// Never waits longer than `HOST_PATIENCE`. What the host does not take counts as written.
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, CdcAcmError> {
        let chunk = &bytes[..bytes.len().min(CHUNK_BYTES)];
        if IS_OPEN.load(Ordering::Relaxed) {
            if self.stalled {
                // The host reads again but has half a line: end it, so that the next one is whole.
                self.stalled = !self.send(b"\r\n", Duration::MIN).await;
            }
            self.stalled = self.stalled || !self.send(chunk, HOST_PATIENCE).await;
        }
        Ok(chunk.len())
    }

    async fn flush(&mut self) -> Result<(), CdcAcmError> {
        Ok(())
    }
}

/// The modem control lines.
pub struct Lines {
    control: ControlChanged<'static>,
}

impl Lines {
    /// Waits until a program opens the port: DTR rises.
    ///
    /// # Cancellation
    /// Safe, but the next call does not see a rise that comes in between.
    pub async fn dtr_rises(&self) {
        let mut was_high = self.control.dtr();
        loop {
            self.control.control_changed().await;
            let is_high = self.control.dtr();
            if is_high != was_high {
                IS_OPEN.store(is_high, Ordering::Relaxed);
            }
            if is_high && !was_high {
                return;
            }
            was_high = is_high;
        }
    }
}
