//! Controls one state machine through its registers: one of PIO0, or the first of PIO2 for a fifth motor.

use embassy_rp::pac::PIO0;
use embassy_rp::pac::dma::vals::TreqSel;
use embassy_rp::pac::pio;

use crate::chip;
use crate::pio_port::program::{STARVED_AT, forced, status_n};

/// The state machines of a block.
pub const MACHINES: usize = 4;

/// The first request of PIO2 in DMA's numbers, after eight each of the other blocks (RP2350 datasheet, 12.6.4.1).
const PIO2_TX0: u8 = 16;

/// The state machine of a motor: with the index of its axis, or the second motor's. The axis's port uses it, and that of
/// the second motor only if its axis has that motor in the run. All are used at one priority, so what they share needs
/// no lock.
#[derive(Clone, Copy)]
pub struct StateMachine {
    index: usize,
}

impl StateMachine {
    pub const fn new(index: usize) -> Self {
        Self { index }
    }

    /// Resets the state machine to the start of the program, halted and with an empty FIFO. The next pulses have
    /// `pulse_loops`.
    pub fn load(&self, pulse_loops: u32) {
        self.disable();
        self.block().ctrl().modify(|ctrl| ctrl.set_sm_restart(self.bit()));
        self.share_fifo(true);
        self.know_end(false);
        self.block().txf(self.place()).write_value(pulse_loops);
        self.force(forced::PULL);
        self.force(forced::SET_PULSE);
        self.force(forced::CLEAR_COUNT);
        self.force(forced::GO_TO_START);
        self.forget_halt();
    }

    pub fn enable(&self) {
        self.block().ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | self.bit()));
    }

    /// Stops further edges. STEP keeps its level until an instruction is forced.
    pub fn disable(&self) {
        Self::disable_all([*self]);
    }

    /// Stops further edges of several, on the same cycle.
    pub fn disable_all(machines: impl IntoIterator<Item = Self>) {
        let bits = machines.into_iter().fold(0_u8, |bits, machine| bits | 1 << machine.index);
        PIO0.ctrl().modify(|ctrl| {
            ctrl.set_sm_enable(ctrl.sm_enable() & !bits);
            // PIO2 is the block before, as they are a ring.
            #[cfg(five_motors)]
            {
                ctrl.set_prev_pio_mask(bits >> MACHINES);
                ctrl.set_nextprev_sm_disable(true);
            }
        });
    }

    /// From now on an empty FIFO is the end of the run. Before, it is a fault, at which the machine sets the inhibit.
    pub fn announce_end(&self) {
        self.know_end(true);
    }

    fn know_end(&self, is_known: bool) {
        chip::set_status_below(self.registers(), status_n(is_known));
    }

    /// The number of edges that have risen since it was loaded, modulo 2^32. Lowers STEP and drops the content of the FIFO, so
    /// disable the state machine first.
    pub fn risen(&self) -> u32 {
        self.share_fifo(false);
        self.force(forced::GET_COUNT);
        self.force(forced::PUSH);
        self.block().rxf(self.place()).read()
    }

    /// True if it has run out of words.
    pub fn has_halted(&self) -> bool {
        self.block().irq().read().irq() & self.bit() != 0
    }

    /// True if it has run out of words before the end was announced. It stays so until it is loaded again.
    pub fn has_starved(&self) -> bool {
        self.registers().addr().read().addr() == STARVED_AT
    }

    fn forget_halt(&self) {
        self.block().irq().write(|flags| flags.set_irq(self.bit()));
    }

    /// Number of words in the FIFO.
    pub fn queued_words(&self) -> u32 {
        self.block().flevel().read().0 >> (8 * self.place()) & 0xF
    }

    /// Gives all eight places to words, or four to each direction. Both drop the content of the FIFOs.
    fn share_fifo(&self, words_only: bool) {
        self.registers().shiftctrl().modify(|shift| shift.set_fjoin_tx(!words_only));
        self.registers().shiftctrl().modify(|shift| shift.set_fjoin_tx(words_only));
    }

    fn force(&self, instruction: u16) {
        self.registers().instr().write(|slot| slot.set_instr(instruction));
    }

    /// Where DMA writes the words.
    pub fn fifo_address(&self) -> u32 {
        self.block().txf(self.place()).as_ptr() as u32
    }

    /// By which its FIFO asks DMA for words.
    pub fn request(&self) -> TreqSel {
        let first = if self.index < MACHINES { TreqSel::PIO0_TX0 as u8 } else { PIO2_TX0 };
        TreqSel::from_bits(first + self.place() as u8)
    }

    fn registers(&self) -> pio::StateMachine {
        self.block().sm(self.place())
    }

    /// The block that it is in.
    pub fn block(&self) -> pio::Pio {
        #[cfg(five_motors)]
        if self.index >= MACHINES {
            return embassy_rp::pac::PIO2;
        }
        PIO0
    }

    /// Its number in the block.
    fn place(&self) -> usize {
        self.index % MACHINES
    }

    /// Its bit in the block's registers.
    pub fn bit(&self) -> u8 {
        1 << self.place()
    }
}
