//! A step port whose edges leave by hardware: DMA carries a word per step, a PIO state machine times it.
//!
//! # Design
//! The processor only adds: it turns segments into waits, a block ahead. `stream` hands the blocks to DMA without a gap,
//! `program` makes edges of them, exact to the clock cycle. A state machine is armed with its first words in its FIFO. All
//! axes of a run wait so at one gate, and begin on the cycle on which it opens.
//!
//! # Deadline
//! A block must be written before the one before it has been sent: 256 us at 1,000,000 steps/s. Missing it starves the
//! state machine, which halts by itself before its next edge: a fault ([`PortFault::Underrun`]), never a stretched
//! interval.
//!
//! # Where the steps are
//! The state machine counts every edge as it makes it. While it runs that count is out of reach; the odometer then
//! follows what DMA has sent and the FIFO still holds, a step behind at most, and looks at least every
//! [`REPORT_EVERY`]. Once the machine is stopped, the count is read and is exact. Which way the edges go it does not count:
//! that is in the words, of which `tally` knows those on their way.
//!
//! # Set-up times
//! DIR changes with a step's word, after the last pulse, so what is left of the interval is its set-up time. Before the first
//! step of a run there is a lead, from the opening of the gate to the start of the run, as long as that.

mod gate;
mod interrupts;
mod program;
mod state_machine;
mod stream;
mod tally;

use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use embassy_rp::gpio::Level;
use embassy_rp::peripherals::PIO0;
use embassy_rp::pio::{Config, Direction as PinDirection, FifoJoin, LoadedProgram, Pin, Pio, ShiftDirection};
use embassy_time::{Duration, with_timeout};
use isostep_motion::{
    AXES, Brake, Capabilities, Direction, DriverTiming, Odometer, PortFault, Run, SegmentQueue, StartLine, StepPort,
    StreamItem, ticks_covering,
};
use isostep_profile::Segment;

use self::program::Words;
use self::state_machine::StateMachine;
use self::stream::{BLOCK_WORDS, Blocks, IN_FLIGHT_MAX_WORDS, Stream};
use self::tally::Tally;
use crate::pins::StepPins;
use crate::priority;

pub use PioPort as Port;

/// The state machines count cycles of the system clock.
const TICK_HZ: u32 = 125_000_000;
const TICKS_PER_US: u64 = TICK_HZ as u64 / 1_000_000;
/// An interval may be shorter than planned: by the rounding of both its ends, and by the fit of its segment.
const MARGIN_TICKS: u32 = 4;
/// A block is handed over when it is full, or holds as much motion as this. Less would leave too little time for the next.
const BLOCK_SPAN_TICKS: u64 = TICK_HZ as u64 / 500;
/// The odometer is at most this old.
const REPORT_EVERY: Duration = Duration::from_millis(10);
/// Where intervals are shorter, all that is on its way has gone by then, and every block that is sent is an occasion to
/// report. Half of that, as a segment's intervals are looked at in the mean.
const QUICK_TICKS: u64 = REPORT_EVERY.as_micros() * TICKS_PER_US / (2 * IN_FLIGHT_MAX_WORDS as u64);

const _: () =
    assert!(AXES <= program::AXES_MAX, "a PIO block has four state machines: step the other axes by a TimerPort");

// One more is in work, which may not have risen.
const _: () = assert!(IN_FLIGHT_MAX_WORDS < tally::IN_FLIGHT_MAX);

/// STEP and DIR of one axis by a state machine of PIO0.
pub struct PioPort {
    axis: usize,
    machine: StateMachine,
    stream: Stream,
    capabilities: Capabilities,
    /// What the last run was given.
    tally: Tally,
    /// Edges of it that rose.
    risen: u32,
}

/// The ports of all axes, at rest, STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [PioPort; AXES] {
    static BLOCKS: [Blocks; AXES] = [const { [const { [const { AtomicU32::new(0) }; BLOCK_WORDS] }; 2] }; AXES];

    let Pio { mut common, mut sm0, mut sm1, mut sm2, .. } = Pio::new(pins.pio, interrupts::Irqs);
    let program = common.load_program(&program::steps());
    let (x, x_dir) = (common.make_pio_pin(pins.x), common.make_pio_pin(pins.x_dir));
    let (y, y_dir) = (common.make_pio_pin(pins.y), common.make_pio_pin(pins.y_dir));
    let (z, z_dir) = (common.make_pio_pin(pins.z), common.make_pio_pin(pins.z_dir));
    sm0.set_config(&config(&program, &x, &x_dir));
    sm1.set_config(&config(&program, &y, &y_dir));
    sm2.set_config(&config(&program, &z, &z_dir));
    sm0.set_pins(Level::Low, &[&x, &x_dir]);
    sm1.set_pins(Level::Low, &[&y, &y_dir]);
    sm2.set_pins(Level::Low, &[&z, &z_dir]);
    sm0.set_pin_dirs(PinDirection::Out, &[&x, &x_dir]);
    sm1.set_pin_dirs(PinDirection::Out, &[&y, &y_dir]);
    sm2.set_pin_dirs(PinDirection::Out, &[&z, &z_dir]);
    // Taken for ever: dropping the first four would give the pins back.
    core::mem::forget((common, sm0, sm1, sm2, pins.channels));
    priority::enable_pio_port();

    [0, 1, 2].map(|axis| PioPort::new(axis, &BLOCKS[axis], timing))
}

/// Of a state machine that steps on these pins.
fn config(
    program: &LoadedProgram<'static, PIO0>,
    step: &Pin<'static, PIO0>,
    dir: &Pin<'static, PIO0>,
) -> Config<'static, PIO0> {
    let mut config = Config::default();
    config.use_program(program, &[step]);
    config.set_out_pins(&[dir]);
    config.fifo_join = FifoJoin::TxOnly;
    config.shift_out.direction = ShiftDirection::Left;
    config
}

impl StepPort for PioPort {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn brake(&self) -> Brake {
        gate::brake
    }

    async fn run(
        &mut self,
        run: Run,
        start_line: &StartLine,
        segments: &SegmentQueue,
        odometer: &Odometer,
    ) -> Result<(), PortFault> {
        {
            let mut active = ActiveRun::new(self, run, start_line, odometer);
            active.emit(segments).await?;
            // Until the state machine has halted, by itself or because of a fault.
            active.until(|_| false).await;
        }
        if self.risen == self.tally.written_edges() { Ok(()) } else { Err(PortFault::Underrun) }
    }
}

impl PioPort {
    fn new(axis: usize, blocks: &'static Blocks, timing: DriverTiming) -> Self {
        let machine = StateMachine::new(axis);
        let stream = Stream::new(axis, machine.fifo_address(), blocks);
        // A pulse is whole cycles.
        let (margin_ticks, turn_ticks) = (MARGIN_TICKS, program::TURN_CYCLES + 1);
        let capabilities = Capabilities { tick_hz: TICK_HZ, timing, margin_ticks, turn_ticks };
        Self { axis, machine, stream, capabilities, tally: Tally::new(), risen: 0 }
    }
}

/// One run. However it ends, or is dropped, the state machine is stopped and its edges are counted.
struct ActiveRun<'a> {
    port: &'a mut PioPort,
    direction_inverted: bool,
    start_line: &'a StartLine,
    odometer: &'a Odometer,
    words: Words,
    period_min_ticks: u32,
    /// From the opening of the gate to the start of the run: DIR's set-up time.
    lead: Duration,
    has_started: bool,
    /// How many of the last words are steps of segments whose intervals are below [`QUICK_TICKS`], but for the segment under
    /// way; and whether all that is on its way is of that kind, that segment included: it needs no timer for each block then.
    quick_words: u32,
    is_quick: bool,
    /// Instant of the last step or rest written; at first, of the opening of the gate, modulo 2^64.
    last_ticks: u64,
    /// Edges that the odometer knows of, and where they have led.
    reported: u32,
    reported_steps: i32,
}

impl<'a> ActiveRun<'a> {
    /// The state machine waits at the gate.
    fn new(port: &'a mut PioPort, run: Run, start_line: &'a StartLine, odometer: &'a Odometer) -> Self {
        let capabilities = port.capabilities;
        let words = Words::with_pulse(ticks_covering(capabilities.pulse_ns(run.wiring), TICK_HZ));
        let lead = Duration::from_micros(capabilities.timing.setup_ns.div_ceil(1_000).into());
        port.tally = Tally::new();
        port.stream.clear();
        gate::close_gate();
        port.machine.load(words.pulse_loops());
        interrupts::expect_halt(port.axis);
        port.machine.enable();
        Self {
            port,
            direction_inverted: run.wiring.direction_inverted,
            start_line,
            odometer,
            words,
            period_min_ticks: capabilities.period_min_ticks(run.wiring),
            lead,
            has_started: false,
            quick_words: 0,
            is_quick: false,
            last_ticks: 0_u64.wrapping_sub(lead.as_micros() * TICKS_PER_US),
            reported: 0,
            reported_steps: 0,
        }
    }

    /// Writes all that the run is given.
    async fn emit(&mut self, segments: &SegmentQueue) -> Result<(), PortFault> {
        let mut item = segments.receive().await;
        loop {
            match item {
                StreamItem::Steps { segment, direction } => self.write(&segment, direction).await?,
                StreamItem::Rest { until_ticks } => self.rest_until(until_ticks).await?,
                StreamItem::End => break,
            }
            item = match segments.try_receive() {
                Ok(item) => item,
                Err(_) => self.wait_for_more(segments).await?,
            };
        }
        self.port.stream.hand_over();
        self.start().await;
        Ok(())
    }

    /// What comes next, when it is not there yet.
    async fn wait_for_more(&mut self, segments: &SegmentQueue) -> Result<StreamItem, PortFault> {
        // What is written must not wait for what is not compiled yet.
        self.port.stream.hand_over();
        self.start().await;
        loop {
            let item = with_timeout(REPORT_EVERY, segments.receive()).await;
            self.report();
            match item {
                Ok(StreamItem::End) => return Ok(StreamItem::End),
                // It comes too late.
                Ok(_) if self.port.machine.has_halted() => return Err(PortFault::Underrun),
                Ok(item) => return Ok(item),
                Err(_) => {}
            }
        }
    }

    /// Waits with the other axes until the run is started, unless it has been: its first words are with DMA. The first
    /// axis that is let go opens the gate of all.
    async fn start(&mut self) {
        if self.has_started {
            return;
        }
        self.start_line.armed().await;
        self.start_line.begun(gate::open_gate() + self.lead);
        self.has_started = true;
    }

    async fn write(&mut self, segment: &Segment, direction: Direction) -> Result<(), PortFault> {
        let wait = self.rest(segment.first_ticks().wrapping_sub(self.last_ticks)).await?;
        let high = (direction == Direction::Positive) != self.direction_inverted;
        let word = if self.port.tally.written_edges() == 0 {
            self.words.first_step(wait, high)
        } else {
            self.check(wait)?;
            self.words.step(wait, high)
        };
        if let Some(interval) = segment.interval_min_ticks() {
            self.check(interval)?;
        }
        self.note_pace(segment);
        self.await_room().await?;
        self.port.stream.room()[0].store(word, Ordering::Relaxed);
        self.wrote_steps(direction, 1);
        let (mut intervals, bias) = (segment.intervals(), self.words.bias(high));
        while intervals.len() > 0 {
            self.await_room().await?;
            let wrote = intervals.fill(self.port.stream.room(), bias);
            self.wrote_steps(direction, wrote);
        }
        self.last_ticks = segment.last_ticks();
        // About what the open block spans: near enough to tell enough from too little.
        if u64::from(self.port.stream.filled()) * u64::from(wait) >= BLOCK_SPAN_TICKS {
            self.port.stream.hand_over();
        }
        Ok(())
    }

    fn note_pace(&mut self, segment: &Segment) {
        let lasts_ticks = segment.last_ticks().wrapping_sub(self.last_ticks);
        let is_quick = lasts_ticks < QUICK_TICKS * u64::from(segment.steps());
        self.is_quick = is_quick && self.quick_words >= IN_FLIGHT_MAX_WORDS;
        self.quick_words = if is_quick { self.quick_words.saturating_add(segment.steps()) } else { 0 };
    }

    fn wrote_steps(&mut self, direction: Direction, words: usize) {
        self.port.stream.wrote(words);
        self.port.tally.write_steps(direction == Direction::Negative, words as u32);
    }

    /// Makes no step until then.
    async fn rest_until(&mut self, ticks: u64) -> Result<(), PortFault> {
        let wait = self.rest(ticks.wrapping_sub(self.last_ticks)).await?;
        self.push_rest(wait).await?;
        self.last_ticks = ticks;
        self.port.stream.hand_over();
        Ok(())
    }

    /// Rests until what is left of the ticks up to the next step fits into its word.
    async fn rest(&mut self, mut ticks: u64) -> Result<u32, PortFault> {
        while ticks > u64::from(program::WAIT_MAX_CYCLES) {
            self.push_rest(program::WAIT_MAX_CYCLES / 2).await?;
            ticks -= u64::from(program::WAIT_MAX_CYCLES / 2);
        }
        Ok(ticks as u32)
    }

    fn check(&self, interval: u32) -> Result<(), PortFault> {
        // The margin is for intervals that rounding and fit make shorter than planned.
        let min = self.period_min_ticks - MARGIN_TICKS;
        if interval < min { Err(PortFault::TooFast { interval, min }) } else { Ok(()) }
    }

    async fn push_rest(&mut self, cycles: u32) -> Result<(), PortFault> {
        (self.quick_words, self.is_quick) = (0, false);
        self.await_room().await?;
        self.port.stream.room()[0].store(self.words.rest(cycles), Ordering::Relaxed);
        self.port.stream.wrote(1);
        self.port.tally.write_rest();
        Ok(())
    }

    /// Waits for a place to write to.
    async fn await_room(&mut self) -> Result<(), PortFault> {
        if self.port.stream.is_full() {
            self.port.stream.hand_over();
        }
        if self.port.stream.has_room() {
            return Ok(());
        }
        self.start().await;
        if self.until(Stream::has_room).await { Ok(()) } else { Err(PortFault::Underrun) }
    }

    /// Waits until `holds`, which is true, or the state machine has halted, which is false.
    async fn until(&mut self, holds: fn(&mut Stream) -> bool) -> bool {
        loop {
            let axis = self.port.axis;
            let waiting = poll_fn(|context| {
                interrupts::WAKERS[axis].register(context.waker());
                if holds(&mut self.port.stream) {
                    return Poll::Ready(true);
                }
                if self.port.machine.has_halted() { Poll::Ready(false) } else { Poll::Pending }
            });
            let held = if self.is_quick { Ok(waiting.await) } else { with_timeout(REPORT_EVERY, waiting).await };
            self.report();
            if let Ok(held) = held {
                return held;
            }
        }
    }

    /// Tells the odometer what must have risen: all that was sent, but what the FIFO holds and the one in work.
    fn report(&mut self) {
        let sent = self.port.stream.sent_words();
        let done = sent.saturating_sub(self.port.machine.queued_words() + 1);
        self.count(self.port.tally.edges_of(done));
    }

    fn count(&mut self, risen: u32) {
        // Two looks at registers do not happen at once: it may seem fewer.
        if risen.wrapping_sub(self.reported) as i32 > 0 {
            let steps = self.port.tally.steps_after(risen);
            self.odometer.advance(steps.wrapping_sub(self.reported_steps));
            (self.reported, self.reported_steps) = (risen, steps);
        }
    }

    /// No further edge; a pulse that has begun is finished. Then the count is exact.
    fn stop(&mut self) {
        self.port.machine.disable();
        self.port.stream.clear();
        cortex_m::asm::delay(self.words.pulse_cycles());
        self.port.risen = self.port.machine.risen();
        self.count(self.port.risen);
    }
}

impl Drop for ActiveRun<'_> {
    fn drop(&mut self) {
        self.stop();
    }
}
