//! Words on their way to a state machine: two buffers in RAM and two DMA channels in ping-pong.
//!
//! # Design
//! While DMA sends one buffer to the FIFO, the other is filled. A buffer that is handed over is armed in its own channel,
//! and the running channel is chained to it, so the FIFO sees no gap. A channel that is not chained to another stops
//! after its buffer, so nothing is sent that was not written.
//!
//! The second motor of an axis has two channels of its own, which read the same buffers. They are paced by its own FIFO. A
//! buffer is filled again when both have sent it.

use core::sync::atomic::AtomicU32;

use embassy_rp::pac::DMA;
use embassy_rp::pac::dma::Channel;
use embassy_rp::pac::dma::regs::CtrlTrig;
use embassy_rp::pac::dma::vals::DataSize;

use super::state_machine::StateMachine;
use crate::chip;
use crate::pins::SECOND;

/// Words per buffer: at 1,000,000 steps/s a buffer is filled every 384 us. Where a segment begins, filling takes the
/// longest, and all axes may begin one at the same time.
pub const BUFFER_WORDS: usize = 384;

/// The most words that can be written but not begun: two buffers and a FIFO.
pub const IN_FLIGHT_MAX_WORDS: u32 = 2 * BUFFER_WORDS as u32 + 8;

/// The buffers that DMA reads. They are atomics because DMA reads them concurrently.
pub type Buffers = [[AtomicU32; BUFFER_WORDS]; 2];

/// The stream of words of one axis.
pub struct Stream {
    axis: usize,
    /// The second motor gets the words too.
    is_doubled: bool,
    buffers: &'static Buffers,
    /// The number of words that each buffer's channel has been armed with.
    armed: [Option<u32>; 2],
    /// The buffer that is being filled, and the number of its words so far.
    filling: usize,
    filled: usize,
    /// Words handed over since the stream was cleared.
    handed_over: u32,
}

impl Stream {
    /// A stream to the FIFO of state machine `axis`.
    pub fn new(axis: usize, buffers: &'static Buffers) -> Self {
        Self { axis, is_doubled: false, buffers, armed: [None; 2], filling: 0, filled: 0, handed_over: 0 }
    }

    /// Sets whether the second motor gets the words too. The stream has been cleared.
    pub fn double(&mut self, is_doubled: bool) {
        self.is_doubled = is_doubled;
    }

    fn feeds(&self) -> impl Iterator<Item = FifoFeed> + use<> {
        [FifoFeed(self.axis), FifoFeed(SECOND)].into_iter().take(1 + usize::from(self.is_doubled))
    }

    /// The bits of all channels that send this buffer.
    #[inline(always)]
    fn bits(&self, buffer: usize) -> u32 {
        FifoFeed(self.axis).bit(buffer) | if self.is_doubled { FifoFeed(SECOND).bit(buffer) } else { 0 }
    }

    /// Stops all channels and discards all words.
    pub fn clear(&mut self) {
        let mask = self.bits(0) | self.bits(1);
        DMA.inte(1).modify(|enabled| *enabled &= !mask);
        for feed in self.feeds() {
            feed.channel(0).al1_ctrl().write_value(0);
            feed.channel(1).al1_ctrl().write_value(0);
        }
        DMA.chan_abort().write(|abort| abort.set_chan_abort(mask as u16));
        while u32::from(DMA.chan_abort().read().chan_abort()) & mask != 0 {}
        // An aborted channel may raise its completion interrupt (erratum RP2040-E13).
        DMA.intr(0).write_value(mask);
        (self.armed, self.filling, self.filled, self.handed_over) = ([None; 2], 0, 0, 0);
    }

    /// True if there is a free place to write to. If not, the axis's waker is woken when there is one.
    pub fn has_room(&mut self) -> bool {
        if self.armed[self.filling].is_some() && self.is_sent(self.filling) {
            DMA.intr(0).write_value(self.bits(self.filling));
            self.armed[self.filling] = None;
        }
        self.armed[self.filling].is_none() && self.filled < BUFFER_WORDS
    }

    /// The free places, to be written in order; call [`wrote`](Self::wrote) afterwards.
    #[inline(always)]
    pub fn room(&self) -> &'static [AtomicU32] {
        &self.buffers[self.filling][self.filled..]
    }

    #[inline(always)]
    pub fn wrote(&mut self, words: usize) {
        self.filled += words;
    }

    /// Words written since the last buffer was handed over.
    pub fn filled(&self) -> u32 {
        self.filled as u32
    }

    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.filled == BUFFER_WORDS
    }

    /// Hands over the words that have been written, if any.
    pub fn hand_over(&mut self) {
        if self.filled == 0 {
            return;
        }
        let (buffer, other) = (self.filling, 1 - self.filling);
        self.arm(buffer);
        for feed in self.feeds() {
            if self.armed[other].is_some() {
                feed.channel(other).al1_ctrl().write_value(feed.control(other, Some(buffer)).0);
            }
            // The other channel may have finished before it was chained to this one. Then nothing has started this one.
            if !feed.is_busy(other) && !feed.is_busy(buffer) && !feed.is_sent(buffer) {
                DMA.multi_chan_trigger().write(|trigger| trigger.set_multi_chan_trigger(feed.bit(buffer) as u16));
            }
        }
        self.handed_over += self.filled as u32;
        (self.filling, self.filled) = (other, 0);
    }

    fn arm(&mut self, buffer: usize) {
        let words = self.filled as u32;
        for feed in self.feeds() {
            let channel = feed.channel(buffer);
            channel.read_addr().write_value(self.buffers[buffer].as_ptr() as u32);
            channel.write_addr().write_value(StateMachine::new(feed.0).fifo_address());
            chip::set_transfers(channel, words);
            channel.al1_ctrl().write_value(feed.control(buffer, None).0);
        }
        self.armed[buffer] = Some(words);
        // The words must be in RAM before DMA reads them.
        cortex_m::asm::dmb();
        DMA.inte(1).modify(|enabled| *enabled |= self.bits(buffer));
    }

    /// Words that have reached the axis's FIFO since the stream was cleared. Never more than the true number.
    pub fn sent_words(&self) -> u32 {
        let feed = FifoFeed(self.axis);
        let waiting = |buffer: usize| match self.armed[buffer] {
            None => 0,
            Some(_) if feed.is_sent(buffer) => 0,
            Some(_) if feed.is_busy(buffer) => chip::transfers_left(feed.channel(buffer)),
            Some(words) => words,
        };
        self.handed_over - waiting(0) - waiting(1)
    }

    #[inline(always)]
    fn is_sent(&self, buffer: usize) -> bool {
        let bits = self.bits(buffer);
        DMA.intr(0).read() & bits == bits
    }
}

/// The way of the words to the FIFO of the state machine with this index: the two channels `2 * index` and the next one,
/// one for each buffer.
#[derive(Clone, Copy)]
struct FifoFeed(usize);

impl FifoFeed {
    #[inline(always)]
    fn channel(self, buffer: usize) -> Channel {
        DMA.ch(2 * self.0 + buffer)
    }

    /// The bit of a buffer's channel in the shared registers of DMA.
    #[inline(always)]
    fn bit(self, buffer: usize) -> u32 {
        1 << (2 * self.0 + buffer)
    }

    /// The control word of `buffer`'s channel, which starts the channel of buffer `next` when it ends.
    fn control(self, buffer: usize, next: Option<usize>) -> CtrlTrig {
        let mut control = CtrlTrig(0);
        control.set_en(true);
        control.set_high_priority(true);
        control.set_data_size(DataSize::SIZE_WORD);
        control.set_incr_read(true);
        control.set_treq_sel(StateMachine::new(self.0).request());
        // A channel that is chained to itself starts no other.
        control.set_chain_to((2 * self.0 + next.unwrap_or(buffer)) as u8);
        control
    }

    #[inline(always)]
    fn is_sent(self, buffer: usize) -> bool {
        DMA.intr(0).read() & self.bit(buffer) != 0
    }

    #[inline(always)]
    fn is_busy(self, buffer: usize) -> bool {
        self.channel(buffer).ctrl_trig().read().busy()
    }
}
