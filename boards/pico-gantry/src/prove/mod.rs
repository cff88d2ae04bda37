//! The proving image: the gantry's firmware that measures itself, for `isostep prove`.
//!
//! # Design
//! Ports, tasks and priorities are those of the image that people use. What is added does nothing until it is asked, by
//! `$PROVE` on a console, except two things, which cost some cycles: the core reads the clock when it falls asleep and wakes
//! (`asleep`), and a reset byte from USB pulls a pad low (`pads`).
//!
//! The motors of a board that proves never move: ENABLE stays off. The fourth motor, its switch and its state machines
//! give way to the stampers (`stamps`). Settings have a place of their own in the flash.

mod asleep;
mod cache;
mod cycles;
mod frames;
mod motors_off;
mod pads;
mod program;
mod stamps;
mod waits;

use core::fmt::Write;
use core::sync::atomic::{AtomicU32, Ordering};

use embassy_executor::Spawner;
use embassy_rp::pac::SYSINFO;
use embassy_rp::rom_data;
use embassy_time::{Duration, Instant};
use isostep_controller::Error;
use isostep_motion::AXES;

pub use self::asleep::run;
pub use self::motors_off::MotorsOff;
pub use self::pads::press as reset_seen;
use self::stamps::{STAMPERS, Stamps, WINDOW};
use crate::chip;
use crate::flash::Flash;
use crate::pins::ProvePins;

const _: () = assert!(AXES == 3, "a proving image has three axes: the pins of a fourth motor are not driven");

/// Of what `$PROVE` answers.
const VERSION: u32 = 1;
/// Stamps of a page: each is 8 digits and a space at most.
const STAMPS_PER_PAGE: usize = 24;
const PORT: &str = if cfg!(feature = "timer-port") { "TIMER" } else { "PIO" };

/// When the consoles were ready, us since the clocks were.
static READY_US: AtomicU32 = AtomicU32::new(0);
/// The board's own number, by halves.
static BOARD_ID: [AtomicU32; 2] = [const { AtomicU32::new(0) }; 2];

/// Starts what measures.
pub fn start(spawner: Spawner, pins: ProvePins, mut flash: Flash) -> Flash {
    cycles::start(cortex_m::Peripherals::take().unwrap().SYST);
    stamps::start();
    pads::start(pins);
    spawner.spawn(pads::press_later().unwrap());
    let id = flash.board_id();
    BOARD_ID[0].store((id >> 32) as u32, Ordering::Relaxed);
    BOARD_ID[1].store(id as u32, Ordering::Relaxed);
    flash
}

/// Notes that the consoles are ready.
pub fn ready() {
    READY_US.store(Instant::now().as_micros() as u32, Ordering::Relaxed);
}

/// Answers `$PROVE`; see `isostep_controller::Prove`.
#[inline(never)]
pub fn answer(words: &str, page: usize, text: &mut dyn Write) -> Result<bool, Error> {
    let Some(request) = words.strip_prefix('=') else {
        return if words.is_empty() { written(identity(text)) } else { Err(Error::UnknownStatement) };
    };
    let mut fields = request.split(',');
    match fields.next() {
        Some("ARM") => arm(&mut fields).map(|()| false),
        Some("READ") => read(number(fields.next())?, page, text),
        Some("COLD") => {
            chip::prove::empty_cache();
            pads::press();
            Ok(false)
        }
        Some("OUT") => out(fields.next()).map(|()| false),
        Some("LOAD") => written(pair(text, "LOAD", asleep::take_us())),
        Some("MASK") => written(writeln!(text, "[MASK:{}]\r", waits::begin_or_end())),
        Some("CACHE") => {
            let [hit, cold, uncached] = cache::read_cost_hundredths();
            written(writeln!(text, "[CACHE:{hit},{cold},{uncached}]\r"))
        }
        Some("COUNT") => written(pair(text, "COUNT", cache::take_counters())),
        Some("FRAME") => written(pair(text, "FRAME", frames::next().ok_or(Error::NotIdle)?)),
        Some("PAD") => written(pair(text, "PAD", pads::sample(pad(fields.next())?))),
        _ => Err(Error::UnknownStatement),
    }
}

fn identity(text: &mut dyn Write) -> core::fmt::Result {
    let [high, low] = BOARD_ID.each_ref().map(|half| half.load(Ordering::Relaxed));
    writeln!(text, "[PROVE:{VERSION}]\r")?;
    writeln!(text, "[ID:{high:08X}{low:08X}]\r")?;
    writeln!(text, "[CHIP:{:08X},{}]\r", SYSINFO.chip_id().read().0, rom_data::rom_version_number())?;
    writeln!(text, "[PORT:{PORT}]\r")?;
    writeln!(text, "[WINDOW:{WINDOW}]\r")?;
    writeln!(text, "[READY:{}]\r", READY_US.load(Ordering::Relaxed))
}

fn arm<'w>(fields: &mut impl Iterator<Item = &'w str>) -> Result<(), Error> {
    let mut pads = [0; STAMPERS];
    for place in &mut pads {
        *place = pad(fields.next())?;
    }
    let skip = number(fields.next())?;
    pads::mark(false);
    stamps::arm(pads, skip);
    pads::mark(true);
    Ok(())
}

/// Pulls OUT low, at once or after some microseconds, or lets it go.
fn out(after_us: Option<&str>) -> Result<(), Error> {
    if after_us.is_none() {
        pads::release();
        return Ok(());
    }
    match number(after_us)? {
        0 => pads::press(),
        us => pads::press_after(Duration::from_micros(us.into())),
    }
    Ok(())
}

/// Prints a page of what a stamper has stamped.
fn read(stamper: u32, page: usize, text: &mut dyn Write) -> Result<bool, Error> {
    let index = usize::try_from(stamper).ok().filter(|&index| index < STAMPERS).ok_or(Error::BadNumber)?;
    let stamps = Stamps::of(index);
    let count = stamps.count();
    let head = |text: &mut dyn Write| {
        let lost = u32::from(stamps.has_lost);
        writeln!(text, "[STAMPS:{index},{},{count},{lost}]\r", stamps.first_edge())
    };
    let line = |text: &mut dyn Write, begin: usize, end: usize| {
        write!(text, "[S:")?;
        for stamp in begin..end {
            let before = if stamp == 0 { 0 } else { stamps.seen_cycles(stamp - 1) };
            let space = if stamp == begin { "" } else { " " };
            write!(text, "{space}{:x}", stamps.seen_cycles(stamp).wrapping_sub(before))?;
        }
        writeln!(text, "]\r")
    };
    let Some(line_number) = page.checked_sub(1) else { return written(head(text)).map(|_| count > 0) };
    let begin = line_number * STAMPS_PER_PAGE;
    let end = (begin + STAMPS_PER_PAGE).min(count);
    written(line(text, begin, end)).map(|_| end < count)
}

fn pair(text: &mut dyn Write, name: &str, [first, second]: [u32; 2]) -> core::fmt::Result {
    writeln!(text, "[{name}:{first},{second}]\r")
}

/// The last page.
fn written(result: core::fmt::Result) -> Result<bool, Error> {
    result.map(|()| false).map_err(|_| Error::BadNumber)
}

fn number(field: Option<&str>) -> Result<u32, Error> {
    field.and_then(|field| field.parse().ok()).ok_or(Error::BadNumber)
}

fn pad(field: Option<&str>) -> Result<u8, Error> {
    number(field).and_then(|pad| u8::try_from(pad).ok().filter(|&pad| pad < pads::PADS).ok_or(Error::BadNumber))
}
