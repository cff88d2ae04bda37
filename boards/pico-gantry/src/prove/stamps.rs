//! The stampers, and the windows into which DMA puts their stamps.
//!
//! # Design
//! Two stampers are on the free state machines of PIO1. The third has that of the fourth motor, which a proving image
//! does not drive, and the 6 instructions that the step program leaves. DMA fills a window for each. The third cannot
//! skip: its window is a ring, of which the last round remains when all have been counted.
//!
//! A stamper whose window is full stops at its next edge, because nothing takes what it pushes. That loses nothing that
//! was asked for. A FIFO that is full while the window is not has lost time: then the stamps are said to be lost.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use embassy_rp::pac::dma::regs::CtrlTrig;
use embassy_rp::pac::dma::vals::{DataSize, TreqSel};
use embassy_rp::pac::pio::Pio;
use embassy_rp::pac::pio::regs::SmPinctrl;
use embassy_rp::pac::{DMA, PIO0, PIO1};

use super::program::{self, EARLY, LATE, LATE_CYCLES, SHORT_ORIGIN, SKIPPING_ORIGIN, forced};
use crate::chip;

/// Stamps of a window.
pub const WINDOW: usize = 512;
/// The window's bytes, as a power of 2: what DMA takes for the size of a ring.
const RING_BITS: u8 = (WINDOW * size_of::<u32>()).ilog2() as u8;

/// The number of stampers.
pub const STAMPERS: usize = 3;
static ALL: [Stamper; STAMPERS] = [
    Stamper::new(PIO1, 2, 8, TreqSel::PIO1_RX2, false),
    Stamper::new(PIO1, 3, 9, TreqSel::PIO1_RX3, false),
    Stamper::new(PIO0, 3, 10, TreqSel::PIO0_RX3, true),
];

/// DMA lets a ring begin only at a multiple of its size.
#[repr(align(2048))]
struct Window([AtomicU32; WINDOW]);

static WINDOWS: [Window; STAMPERS] = [const { Window([const { AtomicU32::new(0) }; WINDOW]) }; STAMPERS];

/// The number of edges to be skipped when they were armed last.
static SKIP: AtomicU32 = AtomicU32::new(0);

struct Stamper {
    pio: Pio,
    state_machine: usize,
    channel: usize,
    dreq: TreqSel,
    /// It has the program that cannot skip.
    is_short: bool,
    /// It looks in the cycles between, since it was armed last.
    is_late: AtomicBool,
    /// The number of stamps that DMA was to take then.
    asked: AtomicU32,
}

/// Loads the programs. The stampers do nothing until they are armed.
pub fn start() {
    for (pio, origin, program) in [(PIO1, SKIPPING_ORIGIN, program::skipping()), (PIO0, SHORT_ORIGIN, program::short())]
    {
        for (address, &instruction) in (usize::from(origin)..).zip(&program.code) {
            pio.instr_mem(address).write(|slot| slot.set_instr_mem(program::moved(instruction, origin)));
        }
    }
}

/// Arms all stampers, each on a pad, with empty windows. They begin when the marker rises, and it has to be low now.
/// Those that can skip skip as many edges after the first.
pub fn arm(pads: [u8; STAMPERS], skip: u32) {
    SKIP.store(skip, Ordering::Relaxed);
    for (index, (stamper, pad)) in ALL.iter().zip(pads).enumerate() {
        stamper.is_late.store(pads[..index].contains(&pad) && !stamper.is_short, Ordering::Relaxed);
        stamper.arm(pad, skip, &WINDOWS[index]);
    }
}

/// The stamps of a stamper since it was armed: their number, the number of the edge of the first, from 1, and
/// whether time was lost.
pub struct Stamps {
    index: usize,
    /// Edges of which a stamp has left the FIFO.
    taken: u32,
    pub has_lost: bool,
}

impl Stamps {
    /// Of the stamper with this index.
    pub fn of(index: usize) -> Self {
        let (taken, has_lost) = ALL[index].taken();
        Self { index, taken, has_lost }
    }

    pub fn count(&self) -> usize {
        self.taken.min(WINDOW as u32) as usize
    }

    pub fn first_edge(&self) -> u32 {
        1 + self.taken - self.count() as u32
    }

    /// The cycle since all began at which the edge of a stamp was seen. The stamps are counted from 0.
    #[cold]
    pub fn seen_cycles(&self, stamp: usize) -> u32 {
        let stamp = stamp as u32;
        let late = u32::from(ALL[self.index].is_late.load(Ordering::Relaxed));
        let at = |edge: u32| WINDOWS[self.index].0[edge as usize % WINDOW].load(Ordering::Relaxed);
        let seen = if ALL[self.index].is_short {
            let edge = self.first_edge() - 1 + stamp;
            program::short_seen_cycles(at(edge), edge)
        } else {
            program::seen_cycles(at(stamp), stamp, SKIP.load(Ordering::Relaxed))
        };
        seen + LATE_CYCLES * late
    }
}

impl Stamper {
    const fn new(pio: Pio, state_machine: usize, channel: usize, dreq: TreqSel, is_short: bool) -> Self {
        let (is_late, asked) = (AtomicBool::new(false), AtomicU32::new(0));
        Self { pio, state_machine, channel, dreq, is_short, is_late, asked }
    }

    fn arm(&self, pad: u8, skip: u32, window: &Window) {
        self.enable(false);
        self.empty();
        let (origin, program, entry) = if self.is_short {
            (SHORT_ORIGIN, program::short(), EARLY)
        } else {
            let entry = if self.is_late.load(Ordering::Relaxed) { LATE } else { EARLY };
            (SKIPPING_ORIGIN, program::skipping(), entry)
        };
        let registers = self.pio.sm(self.state_machine);
        registers.clkdiv().write(|divider| divider.set_int(1));
        registers.execctrl().write(|exec| {
            exec.set_wrap_bottom(origin + program.wrap.target);
            exec.set_wrap_top(origin + program.wrap.source);
            exec.set_jmp_pin(pad);
        });
        // The step program's side-set would take part of an instruction's delay.
        registers.pinctrl().write_value(SmPinctrl(0));
        self.share_fifo(false);
        self.pio.txf(self.state_machine).write_value(skip);
        self.force(forced::PULL);
        self.share_fifo(true);
        for instruction in [forced::STAMP_FIRST, forced::BEGIN, forced::go_to(origin + entry)] {
            self.force(instruction);
        }
        self.pio.fdebug().write(|debug| debug.set_rxstall(self.bit()));
        self.fill(window, if self.is_short { skip + WINDOW as u32 } else { WINDOW as u32 });
        self.enable(true);
    }

    /// Starts or stops it. The register is shared with the state machines of the axes.
    #[inline(never)]
    fn enable(&self, on: bool) {
        cortex_m::interrupt::free(|_| {
            self.pio.ctrl().modify(|ctrl| {
                let others = ctrl.sm_enable() & !self.bit();
                ctrl.set_sm_enable(if on { others | self.bit() } else { others });
            });
        });
    }

    /// Ends what DMA does for it.
    fn empty(&self) {
        DMA.chan_abort().write(|channels| channels.set_chan_abort(1 << self.channel));
        while DMA.ch(self.channel).ctrl_trig().read().busy() {}
    }

    /// Has DMA put its next `count` stamps into the window, again and again from the beginning.
    fn fill(&self, window: &Window, count: u32) {
        let channel = DMA.ch(self.channel);
        channel.read_addr().write_value(self.pio.rxf(self.state_machine).as_ptr() as u32);
        channel.write_addr().write_value(window.0.as_ptr() as u32);
        chip::set_transfers(channel, count);
        self.asked.store(count, Ordering::Relaxed);
        channel.ctrl_trig().write(|ctrl: &mut CtrlTrig| {
            ctrl.set_en(true);
            ctrl.set_data_size(DataSize::SIZE_WORD);
            ctrl.set_incr_write(true);
            ctrl.set_ring_sel(true);
            ctrl.set_ring_size(RING_BITS);
            ctrl.set_treq_sel(self.dreq);
            ctrl.set_irq_quiet(true);
            // To itself: to none.
            ctrl.set_chain_to(self.channel as u8);
        });
    }

    /// The number of stamps that DMA has taken, and whether the stamper had to wait for it before it had taken all.
    fn taken(&self) -> (u32, bool) {
        let left = chip::transfers_left(DMA.ch(self.channel));
        let has_waited = self.pio.fdebug().read().rxstall() & self.bit() != 0;
        (self.asked.load(Ordering::Relaxed) - left, has_waited && left > 0)
    }

    /// Gives all places of the FIFO to stamps, or half of them. Both drop its content.
    fn share_fifo(&self, stamps_only: bool) {
        self.pio.sm(self.state_machine).shiftctrl().write(|shift| {
            shift.set_autopush(true);
            shift.set_fjoin_rx(stamps_only);
        });
    }

    fn force(&self, instruction: u16) {
        self.pio.sm(self.state_machine).instr().write(|slot| slot.set_instr(instruction));
    }

    fn bit(&self) -> u8 {
        1 << self.state_machine
    }
}
