//! A step port whose edges are made by hardware: DMA transfers one word per step, and a PIO state machine times it.
//!
//! # Design
//! The processor only adds: it turns segments into waits, one buffer ahead. `stream` passes the buffers to DMA without a
//! gap, and `program` turns them into edges, exact to the clock cycle. A state machine is armed when its first words
//! are in its FIFO. All axes of a run wait at one start barrier in this state, and begin on the cycle on which it opens.
//!
//! # Deadline
//! A buffer must be written before the previous one has been sent: 384 us at 1,000,000 steps/s. If it is late, the state
//! machine runs out of words, sets the inhibit for all axes and halts by itself before its next edge. That is a fault
//! ([`PortFault::Underrun`]), never a stretched interval. The last item of a run has the same deadline: it announces the
//! end, after which an empty FIFO is none too early.
//!
//! # Where the steps are
//! The state machine counts every edge as it makes it. While it runs, this count cannot be read. The step counter is then
//! derived from what DMA has sent and the FIFO still holds. It lags by one step at most and is updated at least every
//! [`REPORT_EVERY`]. Once the machine has stopped, the count is read and is exact. The count does not include the
//! direction of the edges. The direction is in the words, and `tally` keeps it for those on their way.
//!
//! # Two motors
//! The second motor of an axis has a state machine of its own, which runs the same program on its own pins and gets the
//! same words. Both begin on the cycle on which the start barrier opens, so their edges stay on the same cycles, and an inhibit
//! stops both between the same two edges. Both count. If the counts differ it is a fault: never a gantry that is out of
//! square without a word. A ganged motor that is held has its STEP forced low at the pad (`pads`).
//!
//! # Set-up times
//! DIR changes with a step's word, after the last pulse, so the rest of the interval is its set-up time. Before the
//! first step of a run there is a lead of the same length, from the opening of the start barrier to the start of the run.

mod barrier;
mod interrupts;
mod pads;
mod program;
mod state_machine;
mod stream;
mod tally;

use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use embassy_futures::select::{Either, select};
use embassy_rp::gpio::Level;
use embassy_rp::pio::{
    self, Config, Direction as PinDirection, FifoJoin, Instance, LoadedProgram, Pin, Pio, ShiftDirection,
};
use embassy_time::{Duration, with_timeout};
use isostep_motion::{
    AXES, Capabilities, Direction, DriverTiming, Inhibit, Motors, PortFault, Run, StartBarrier, StepCounter, StepPort,
    StreamItem, StreamQueue, ticks_covering,
};
use isostep_profile::Segment;

use self::program::Words;
use self::state_machine::StateMachine;
use self::stream::{BUFFER_WORDS, Buffers, IN_FLIGHT_MAX_WORDS, Stream};
use self::tally::Tally;
use crate::pins::{SECOND, StepPins};
use crate::{chip, priority};

pub use PioPort as Port;

pub use self::barrier::inhibit_all;

/// The state machines count cycles of the system clock.
const TICK_HZ: u32 = chip::CLOCK_HZ;
const TICKS_PER_US: u64 = TICK_HZ as u64 / 1_000_000;
/// The time by which an interval may be shorter than planned, because both its ends are rounded and its segment is fitted.
const MARGIN_TICKS: u32 = 4;
/// A buffer is handed over when it is full or holds this much motion. With less, there would be too little time for the
/// next.
const BUFFER_SPAN_TICKS: u32 = TICK_HZ / 500;
/// The step counter is never older than this.
const REPORT_EVERY: Duration = Duration::from_millis(10);
/// The interval below which all words on their way are sent within `REPORT_EVERY`. Then the end of each
/// buffer is often enough to report. The factor 2 is there because only the mean interval of a segment is checked.
const QUICK_TICKS: u32 = (REPORT_EVERY.as_micros() * TICKS_PER_US) as u32 / (2 * IN_FLIGHT_MAX_WORDS);

const _: () =
    assert!(AXES <= program::AXES_MAX, "a PIO block has four state machines: step the other axes by a TimerPort");

// One more word is in the state machine; its edge may not have risen yet.
const _: () = assert!(IN_FLIGHT_MAX_WORDS < tally::IN_FLIGHT_MAX);

/// Drives STEP and DIR of one axis with a state machine of PIO0, and those of the second motor with another, of PIO2 if it is the fifth.
pub struct PioPort {
    axis: usize,
    machine: StateMachine,
    /// The axis had the second motor in the last run.
    is_doubled: bool,
    stream: Stream,
    capabilities: Capabilities,
    /// The record of the last run's words.
    tally: Tally,
    /// Edges of the last run that rose; whether a state machine ran out of words before its end, and whether both motors
    /// made the same edges.
    risen: u32,
    has_starved: bool,
    is_agreed: bool,
}

/// The ports of all axes, at rest, with STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [PioPort; AXES] {
    static BUFFERS: [Buffers; AXES] = [const { [const { [const { AtomicU32::new(0) }; BUFFER_WORDS] }; 2] }; AXES];

    let (step, dir) = (pins.step, pins.dir);
    let Pio { mut common, mut sm0, mut sm1, mut sm2, mut sm3, .. } = Pio::new(pins.pio.0, interrupts::Irqs);
    let program = common.load_program(&program::steps());
    prepare(&mut sm0, &program, common.make_pio_pin(step.0), common.make_pio_pin(dir.0));
    prepare(&mut sm1, &program, common.make_pio_pin(step.1), common.make_pio_pin(dir.1));
    prepare(&mut sm2, &program, common.make_pio_pin(step.2), common.make_pio_pin(dir.2));
    prepare(&mut sm3, &program, common.make_pio_pin(step.3), common.make_pio_pin(dir.3));
    // Never dropped: dropping the first five would release the pins.
    core::mem::forget((common, sm0, sm1, sm2, sm3, pins.channels));
    #[cfg(five_motors)]
    {
        let Pio { mut common, mut sm0, .. } = Pio::new(pins.pio.1, interrupts::FifthIrqs);
        let program = common.load_program(&program::steps_before());
        prepare(&mut sm0, &program, common.make_pio_pin(step.4), common.make_pio_pin(dir.4));
        core::mem::forget((common, sm0));
    }
    priority::enable_pio_port();

    core::array::from_fn(|axis| PioPort::new(axis, &BUFFERS[axis], timing))
}

/// Prepares a state machine to drive these pins, which are low until then.
fn prepare<P: Instance, const NUMBER: usize>(
    machine: &mut pio::StateMachine<'static, P, NUMBER>,
    program: &LoadedProgram<'static, P>,
    step: Pin<'static, P>,
    dir: Pin<'static, P>,
) {
    let mut config = Config::default();
    config.use_program(program, &[&step]);
    config.set_out_pins(&[&dir]);
    config.fifo_join = FifoJoin::TxOnly;
    config.shift_out.direction = ShiftDirection::Left;
    machine.set_config(&config);
    machine.set_pins(Level::Low, &[&step, &dir]);
    machine.set_pin_dirs(PinDirection::Out, &[&step, &dir]);
}

impl StepPort for PioPort {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn inhibit(&self) -> Inhibit {
        barrier::inhibit
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        {
            let mut active = PioRun::new(self, run.motors, run.start_barrier, run.step_counter);
            let emitted = active.emit(run.segments).await;
            if emitted.is_err() {
                // The other axes do not wait until this one has counted. A state machine that runs dry has set the inhibit
                // itself.
                barrier::inhibit(true);
                return emitted;
            }
            // Wait until the state machine has halted, by itself or because of a fault.
            active.until(|_| false).await;
        }
        let is_whole = self.risen == self.tally.written_edges();
        if is_whole && self.is_agreed && !self.has_starved { Ok(()) } else { Err(PortFault::Underrun) }
    }
}

impl PioPort {
    fn new(axis: usize, buffers: &'static Buffers, timing: DriverTiming) -> Self {
        let machine = StateMachine::new(axis);
        let stream = Stream::new(axis, buffers);
        // A pulse is a whole number of cycles.
        let mut capabilities = Capabilities::new(TICK_HZ, timing);
        (capabilities.margin_ticks, capabilities.turn_ticks) = (MARGIN_TICKS, program::TURN_CYCLES + 1);
        Self {
            axis,
            machine,
            is_doubled: false,
            stream,
            capabilities,
            tally: Tally::new(),
            risen: 0,
            has_starved: false,
            is_agreed: true,
        }
    }

    /// The state machines that make the steps of the run.
    fn machines(&self) -> impl Iterator<Item = StateMachine> + use<> {
        [self.machine, StateMachine::new(SECOND)].into_iter().take(1 + usize::from(self.is_doubled))
    }

    /// True if a state machine has run out of words. Both do on the same cycle, unless something is wrong.
    #[inline(never)]
    fn has_halted(&self) -> bool {
        self.machines().any(|machine| machine.has_halted())
    }
}

/// One run. When it ends or is dropped, for any reason, the state machine is stopped and its edges are counted.
struct PioRun<'a> {
    port: &'a mut PioPort,
    direction_inverted: bool,
    start_barrier: &'a StartBarrier,
    step_counter: &'a StepCounter,
    words: Words,
    period_min_ticks: u32,
    /// From the opening of the start barrier to the start of the run: the set-up time of DIR.
    lead: Duration,
    has_started: bool,
    /// The number of the last words that are steps of consecutive segments whose mean interval is below [`QUICK_TICKS`]; and
    /// whether that holds for all words on their way. Then buffers end so often that the step counter needs no timer.
    quick_words: u32,
    is_quick: bool,
    /// Instant of the last written step or rest, modulo 2^64. At first, that of the opening of the start barrier.
    last_ticks: u64,
    /// Edges that the step counter has counted, and the position in steps that they lead to.
    reported: u32,
    reported_steps: i32,
}

impl<'a> PioRun<'a> {
    /// Arms the state machine, which then waits at the start barrier.
    fn new(
        port: &'a mut PioPort,
        motors: Motors,
        start_barrier: &'a StartBarrier,
        step_counter: &'a StepCounter,
    ) -> Self {
        let capabilities = port.capabilities;
        let words = Words::with_pulse(ticks_covering(capabilities.pulse_ns(motors.wiring), TICK_HZ));
        let lead = Duration::from_micros(capabilities.timing.setup_ns.div_ceil(1_000).into());
        port.tally = Tally::new();
        port.stream.clear();
        port.is_doubled = motors.second.is_some();
        port.stream.double(port.is_doubled);
        if port.is_doubled {
            interrupts::double(port.axis);
        }
        pads::set(port.axis, &motors);
        barrier::close_barrier();
        for machine in port.machines() {
            machine.load(words.pulse_loops());
            interrupts::expect_halt(machine);
            machine.enable();
        }
        Self {
            port,
            direction_inverted: motors.wiring.direction_inverted,
            start_barrier,
            step_counter,
            words,
            period_min_ticks: capabilities.period_min_ticks(motors.wiring),
            lead,
            has_started: false,
            quick_words: 0,
            is_quick: false,
            last_ticks: 0_u64.wrapping_sub(lead.as_micros() * TICKS_PER_US),
            reported: 0,
            reported_steps: 0,
        }
    }

    /// Writes all items of the run.
    async fn emit(&mut self, segments: &StreamQueue) -> Result<(), PortFault> {
        let mut item = segments.receive().await;
        loop {
            match item {
                StreamItem::Steps { segment, direction } => self.write(&segment, direction).await?,
                StreamItem::Rest { until_ticks } => self.rest_until(until_ticks).await?,
                StreamItem::End => {
                    self.port.machines().for_each(|machine| machine.announce_end());
                    break;
                }
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

    /// Waits for the next item when it is not there yet.
    async fn wait_for_more(&mut self, segments: &StreamQueue) -> Result<StreamItem, PortFault> {
        // Words that are written must not wait for segments that are not compiled yet.
        self.port.stream.hand_over();
        self.start().await;
        loop {
            let item = with_timeout(REPORT_EVERY, select(segments.receive(), self.halted())).await;
            self.report();
            match item {
                // The item comes too late, or none has come.
                Ok(_) if self.port.has_halted() => return Err(PortFault::Underrun),
                Ok(Either::First(item)) => return Ok(item),
                Ok(Either::Second(())) | Err(_) => {}
            }
        }
    }

    /// Waits with the other axes until the run is started; returns at once if it has been. The first words are with DMA
    /// by then. The first axis that continues opens the start barrier for all.
    async fn start(&mut self) {
        if self.has_started {
            return;
        }
        self.start_barrier.armed().await;
        self.start_barrier.begun(barrier::open_barrier() + self.lead);
        self.has_started = true;
    }

    async fn write(&mut self, segment: &Segment, direction: Direction) -> Result<(), PortFault> {
        let wait_ticks = segment.first_ticks().wrapping_sub(self.last_ticks);
        // Most steps follow each other without a rest.
        let is_near = wait_ticks <= u64::from(program::WAIT_MAX_CYCLES);
        let wait = if is_near { wait_ticks as u32 } else { self.rest(wait_ticks).await? };
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
        let last_ticks = segment.last_ticks();
        self.note_pace(segment.steps(), last_ticks);
        let (mut intervals, bias) = (segment.intervals(), self.words.bias(high));
        self.await_room().await?;
        let room = self.port.stream.room();
        room[0].store(word, Ordering::Relaxed);
        let mut wrote = 1 + intervals.fill(&room[1..], bias);
        loop {
            self.wrote_steps(direction, wrote);
            if intervals.len() == 0 {
                break;
            }
            self.await_room().await?;
            wrote = intervals.fill(self.port.stream.room(), bias);
        }
        self.last_ticks = last_ticks;
        // An estimate of the time that the open buffer lasts, which is accurate enough for this decision.
        if self.port.stream.filled().wrapping_mul(wait.min(BUFFER_SPAN_TICKS)) >= BUFFER_SPAN_TICKS {
            self.port.stream.hand_over();
        }
        Ok(())
    }

    /// Notes how fast the next `steps` steps are, which end at `last_ticks`.
    fn note_pace(&mut self, steps: u32, last_ticks: u64) {
        let lasts_ticks = last_ticks.wrapping_sub(self.last_ticks);
        // A segment of more steps is made so quickly that it does not matter.
        let quick_ticks = QUICK_TICKS * steps.min(u32::MAX / QUICK_TICKS);
        let is_quick = lasts_ticks < u64::from(quick_ticks);
        self.is_quick = is_quick && self.quick_words >= IN_FLIGHT_MAX_WORDS;
        self.quick_words = if is_quick { self.quick_words.saturating_add(steps) } else { 0 };
    }

    fn wrote_steps(&mut self, direction: Direction, words: usize) {
        self.port.stream.wrote(words);
        self.port.tally.write_steps(direction == Direction::Negative, words as u32);
    }

    /// Makes no step until `ticks`.
    async fn rest_until(&mut self, ticks: u64) -> Result<(), PortFault> {
        let wait = self.rest(ticks.wrapping_sub(self.last_ticks)).await?;
        self.push_rest(wait).await?;
        self.last_ticks = ticks;
        self.port.stream.hand_over();
        Ok(())
    }

    /// Writes rests until the remaining ticks up to the next step fit into its word; returns these.
    async fn rest(&mut self, mut ticks: u64) -> Result<u32, PortFault> {
        while ticks > u64::from(program::WAIT_MAX_CYCLES) {
            self.push_rest(program::WAIT_MAX_CYCLES / 2).await?;
            ticks -= u64::from(program::WAIT_MAX_CYCLES / 2);
        }
        Ok(ticks as u32)
    }

    fn check(&self, interval: u32) -> Result<(), PortFault> {
        // The margin allows for intervals that rounding and fit make shorter than planned.
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

    /// Waits for a free place to write to.
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

    /// Waits until the state machine has halted.
    async fn halted(&self) {
        let axis = self.port.axis;
        poll_fn(|context| {
            interrupts::WAKERS[axis].register(context.waker());
            if self.port.has_halted() { Poll::Ready(()) } else { Poll::Pending }
        })
        .await;
    }

    /// Waits until `holds` returns true (returns true), or the state machine has halted (returns false).
    async fn until(&mut self, holds: fn(&mut Stream) -> bool) -> bool {
        loop {
            let axis = self.port.axis;
            let waiting = poll_fn(|context| {
                interrupts::WAKERS[axis].register(context.waker());
                if holds(&mut self.port.stream) {
                    return Poll::Ready(true);
                }
                if self.port.has_halted() { Poll::Ready(false) } else { Poll::Pending }
            });
            let held = if self.is_quick { Ok(waiting.await) } else { with_timeout(REPORT_EVERY, waiting).await };
            self.report();
            if let Ok(held) = held {
                return held;
            }
        }
    }

    /// Reports to the step counter the edges that must have risen: all words sent, except those in the FIFO and the one in
    /// the state machine.
    fn report(&mut self) {
        let sent = self.port.stream.sent_words();
        let done = sent.saturating_sub(self.port.machine.queued_words() + 1);
        self.count(self.port.tally.edges_of(done));
    }

    fn count(&mut self, risen: u32) {
        // The registers are not read at the same instant, so the count may seem to decrease.
        if risen.wrapping_sub(self.reported) as i32 > 0 {
            let steps = self.port.tally.steps_after(risen);
            self.step_counter.advance(steps.wrapping_sub(self.reported_steps));
            (self.reported, self.reported_steps) = (risen, steps);
        }
    }

    /// Stops further edges and lets a pulse that has begun finish. Then the count is exact.
    fn stop(&mut self) {
        StateMachine::disable_all(self.port.machines());
        self.port.stream.clear();
        cortex_m::asm::delay(self.words.pulse_cycles());
        self.port.has_starved = self.port.machines().any(|machine| machine.has_starved());
        self.port.risen = self.port.machine.risen();
        self.port.is_agreed = !self.port.is_doubled || StateMachine::new(SECOND).risen() == self.port.risen;
        self.count(self.port.risen);
    }
}

impl Drop for PioRun<'_> {
    fn drop(&mut self) {
        self.stop();
    }
}
