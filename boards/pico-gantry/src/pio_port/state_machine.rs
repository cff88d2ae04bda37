//! Controls one state machine of PIO0 through its registers.

use embassy_rp::pac;
use embassy_rp::pac::PIO0;

use crate::chip;
use crate::pio_port::program::{STARVED_AT, forced, status_n};

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
        PIO0.ctrl().modify(|ctrl| ctrl.set_sm_restart(self.bit()));
        self.share_fifo(true);
        self.know_end(false);
        PIO0.txf(self.index).write_value(pulse_loops);
        self.force(forced::PULL);
        self.force(forced::SET_PULSE);
        self.force(forced::CLEAR_COUNT);
        self.force(forced::GO_TO_START);
        self.forget_halt();
    }

    pub fn index(&self) -> usize {
        self.index
    }

    pub fn enable(&self) {
        PIO0.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() | self.bit()));
    }

    /// Stops further edges. STEP keeps its level until an instruction is forced.
    pub fn disable(&self) {
        Self::disable_all([*self]);
    }

    /// Stops further edges of several, on the same cycle.
    pub fn disable_all(machines: impl IntoIterator<Item = Self>) {
        let bits = machines.into_iter().fold(0, |bits, machine| bits | machine.bit());
        PIO0.ctrl().modify(|ctrl| ctrl.set_sm_enable(ctrl.sm_enable() & !bits));
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
        PIO0.rxf(self.index).read()
    }

    /// True if it has run out of words.
    pub fn has_halted(&self) -> bool {
        PIO0.irq().read().irq() & self.bit() != 0
    }

    /// True if it has run out of words before the end was announced. It stays so until it is loaded again.
    pub fn has_starved(&self) -> bool {
        self.registers().addr().read().addr() == STARVED_AT
    }

    fn forget_halt(&self) {
        PIO0.irq().write(|flags| flags.set_irq(self.bit()));
    }

    /// Number of words in the FIFO.
    pub fn queued_words(&self) -> u32 {
        PIO0.flevel().read().0 >> (8 * self.index) & 0xF
    }

    /// Gives all eight places to words, or four to each direction. Both drop the content of the FIFOs.
    fn share_fifo(&self, words_only: bool) {
        self.registers().shiftctrl().modify(|shift| shift.set_fjoin_tx(!words_only));
        self.registers().shiftctrl().modify(|shift| shift.set_fjoin_tx(words_only));
    }

    fn force(&self, instruction: u16) {
        self.registers().instr().write(|slot| slot.set_instr(instruction));
    }

    fn registers(&self) -> pac::pio::StateMachine {
        PIO0.sm(self.index)
    }

    fn bit(&self) -> u8 {
        1 << self.index
    }
}
