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
//! [`REPORT_EVERY`]. Once the machine is stopped, the count is read and is exact.

mod gate;
mod interrupts;
mod program;
mod state_machine;
mod stream;

use core::future::poll_fn;
use core::sync::atomic::{AtomicU32, Ordering};
use core::task::Poll;

use embassy_rp::gpio::Output;
use embassy_rp::peripherals::PIO0;
use embassy_rp::pio::{Config, Direction as PinDirection, FifoJoin, LoadedProgram, Pin, Pio, ShiftDirection};
use embassy_time::{Duration, Instant, Timer, with_timeout};
use isostep_motion::{
    AXES, Brake, Capabilities, Direction, DriverTiming, Feed, Odometer, PortFault, Run, SegmentQueue, StartLine,
    StepPort, ticks_covering,
};
use isostep_profile::Segment;

use self::program::Words;
use self::state_machine::StateMachine;
use self::stream::{BLOCK_WORDS, Blocks, Stream};
use crate::pins::StepPins;
use crate::priority;

pub use PioPort as Port;

/// The state machines count cycles of the system clock.
const TICK_HZ: u32 = 125_000_000;
/// An interval may be shorter than planned: by the rounding of both its ends, and by the fit of its segment.
const MARGIN_TICKS: u32 = 4;
/// A block is handed over when it is full, or holds as much motion as this. Less would leave too little time for the next.
const BLOCK_SPAN_TICKS: u64 = TICK_HZ as u64 / 500;
/// The odometer is at most this old.
const REPORT_EVERY: Duration = Duration::from_millis(10);

const _: () =
    assert!(AXES <= program::AXES_MAX, "a PIO block has four state machines: step the other axes by a TimerPort");

/// STEP of one axis by a state machine of PIO0, its DIR by the processor.
pub struct PioPort {
    axis: usize,
    dir: Output<'static>,
    machine: StateMachine,
    stream: Stream,
    capabilities: Capabilities,
    /// Steps that the last run was given.
    given: u32,
    /// Steps of it that rose.
    risen: u32,
}

/// The ports of all axes, at rest, STEP and DIR low.
pub fn open(pins: StepPins, timing: DriverTiming) -> [PioPort; AXES] {
    static BLOCKS: [Blocks; AXES] = [const { [const { [const { AtomicU32::new(0) }; BLOCK_WORDS] }; 2] }; AXES];

    let Pio { mut common, mut sm0, mut sm1, mut sm2, .. } = Pio::new(pins.pio, interrupts::Irqs);
    let program = common.load_program(&program::steps());
    let (x, y, z) = (common.make_pio_pin(pins.x), common.make_pio_pin(pins.y), common.make_pio_pin(pins.z));
    sm0.set_config(&config(&program, &x));
    sm1.set_config(&config(&program, &y));
    sm2.set_config(&config(&program, &z));
    sm0.set_pin_dirs(PinDirection::Out, &[&x]);
    sm1.set_pin_dirs(PinDirection::Out, &[&y]);
    sm2.set_pin_dirs(PinDirection::Out, &[&z]);
    // Taken for ever: dropping the first four would give the pins back.
    core::mem::forget((common, sm0, sm1, sm2, pins.channels));
    priority::enable_pio_port();

    let [x_dir, y_dir, z_dir] = pins.dir;
    [
        PioPort::new(0, x_dir, &BLOCKS[0], timing),
        PioPort::new(1, y_dir, &BLOCKS[1], timing),
        PioPort::new(2, z_dir, &BLOCKS[2], timing),
    ]
}

/// Of a state machine that steps on `pin`.
fn config(program: &LoadedProgram<'static, PIO0>, pin: &Pin<'static, PIO0>) -> Config<'static, PIO0> {
    let mut config = Config::default();
    config.use_program(program, &[pin]);
    config.fifo_join = FifoJoin::TxOnly;
    config.shift_out.direction = ShiftDirection::Right;
    // `mov x, status` tells whether the FIFO holds less than one word.
    config.status_n = 1;
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
            let mut underway = Underway::new(self, run, start_line, odometer);
            underway.feed(segments).await?;
            // Until the state machine has halted, by itself or because of a fault.
            underway.until(|_| false).await;
        }
        if self.risen == self.given { Ok(()) } else { Err(PortFault::Underrun) }
    }
}

impl PioPort {
    fn new(axis: usize, dir: Output<'static>, blocks: &'static Blocks, timing: DriverTiming) -> Self {
        let machine = StateMachine::new(axis);
        let stream = Stream::new(axis, machine.fifo_address(), blocks);
        let capabilities = Capabilities { tick_hz: TICK_HZ, timing, margin_ticks: MARGIN_TICKS };
        Self { axis, dir, machine, stream, capabilities, given: 0, risen: 0 }
    }

    /// Sets DIR; from when on a step may rise.
    fn turn(&mut self, run: &Run) -> Instant {
        let high = (run.direction == Direction::Positive) != run.wiring.direction_inverted;
        self.dir.set_level(high.into());
        // The clock's reading may be almost a microsecond old.
        let setup_us = u64::from(self.capabilities.timing.setup_ns.div_ceil(1_000)) + 1;
        Instant::now() + Duration::from_micros(setup_us)
    }
}

/// One run. However it ends, or is dropped, the state machine is stopped and its edges are counted.
struct Underway<'a> {
    port: &'a mut PioPort,
    run: Run,
    start_line: &'a StartLine,
    odometer: &'a Odometer,
    words: Words,
    period_min_ticks: u32,
    /// When DIR has been set up.
    turned_at: Instant,
    has_started: bool,
    /// Instant of the last step written.
    last_ticks: u64,
    /// Words without a step written so far.
    rests: u32,
    /// Steps the odometer knows of.
    reported: u32,
}

impl<'a> Underway<'a> {
    /// Sets DIR; the state machine waits at the gate.
    fn new(port: &'a mut PioPort, run: Run, start_line: &'a StartLine, odometer: &'a Odometer) -> Self {
        port.given = 0;
        let turned_at = port.turn(&run);
        let words = Words::with_pulse(ticks_covering(port.capabilities.pulse_ns(run.wiring), TICK_HZ));
        port.stream.clear();
        gate::close_gate();
        port.machine.load(words.pulse_loops(), run.steps);
        interrupts::expect_halt(port.axis);
        port.machine.enable();
        let period_min_ticks = port.capabilities.period_min_ticks(run.wiring);
        Self {
            port,
            run,
            start_line,
            odometer,
            words,
            period_min_ticks,
            turned_at,
            has_started: false,
            last_ticks: 0,
            rests: 0,
            reported: 0,
        }
    }

    async fn feed(&mut self, segments: &SegmentQueue) -> Result<(), PortFault> {
        while self.port.given < self.run.steps {
            let feed = match segments.try_receive() {
                Ok(feed) => feed,
                Err(_) => {
                    // What is written must not wait for what is not compiled yet.
                    self.port.stream.hand_over();
                    self.start().await;
                    segments.receive().await
                }
            };
            match feed {
                Feed::Steps(segment) => {
                    self.write(&segment, self.port.given == 0).await?;
                    self.port.given += segment.steps();
                }
                Feed::Rest { until_ticks } => self.rest_until(until_ticks).await?,
                Feed::End => break,
            }
        }
        self.port.stream.hand_over();
        self.start().await;
        Ok(())
    }

    /// Waits with the other axes until the run is started, unless it has been: its first words are with DMA. The first
    /// axis that is let go opens the gate of all.
    async fn start(&mut self) {
        if self.has_started {
            return;
        }
        Timer::at(self.turned_at).await;
        self.start_line.armed().await;
        self.start_line.begun(gate::open_gate());
        self.has_started = true;
    }

    async fn write(&mut self, segment: &Segment, is_first: bool) -> Result<(), PortFault> {
        let wait = self.rest(segment.first_ticks() - self.last_ticks).await?;
        if is_first {
            self.push(self.words.first_step(wait)).await?;
        } else {
            self.check(wait)?;
            self.push(self.words.step(wait)).await?;
        }
        if let Some(interval) = segment.interval_min_ticks() {
            self.check(interval)?;
        }
        let mut intervals = segment.intervals();
        while intervals.len() > 0 {
            self.await_room().await?;
            let wrote = intervals.fill(self.port.stream.room(), self.words.bias());
            self.port.stream.wrote(wrote);
        }
        self.last_ticks = segment.last_ticks();
        // About what the open block spans: near enough to tell enough from too little.
        if u64::from(self.port.stream.filled()) * u64::from(wait) >= BLOCK_SPAN_TICKS {
            self.port.stream.hand_over();
        }
        Ok(())
    }

    /// Makes no step until then.
    async fn rest_until(&mut self, ticks: u64) -> Result<(), PortFault> {
        let wait = self.rest(ticks - self.last_ticks).await?;
        self.push(self.words.rest(wait)).await?;
        self.rests += 1;
        self.last_ticks = ticks;
        self.port.stream.hand_over();
        Ok(())
    }

    /// Rests until what is left of the ticks up to the next step fits into its word.
    async fn rest(&mut self, mut ticks: u64) -> Result<u32, PortFault> {
        while ticks > u64::from(program::WAIT_MAX_CYCLES) {
            self.push(self.words.rest(program::WAIT_MAX_CYCLES / 2)).await?;
            self.rests += 1;
            ticks -= u64::from(program::WAIT_MAX_CYCLES / 2);
        }
        Ok(ticks as u32)
    }

    fn check(&self, interval: u32) -> Result<(), PortFault> {
        // The margin is for intervals that rounding and fit make shorter than planned.
        let min = self.period_min_ticks - MARGIN_TICKS;
        if interval < min { Err(PortFault::TooFast { interval, min }) } else { Ok(()) }
    }

    async fn push(&mut self, word: u32) -> Result<(), PortFault> {
        self.await_room().await?;
        self.port.stream.room()[0].store(word, Ordering::Relaxed);
        self.port.stream.wrote(1);
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
            if let Ok(held) = with_timeout(REPORT_EVERY, waiting).await {
                self.report();
                return held;
            }
            self.report();
        }
    }

    /// Tells the odometer what must have risen: all that was sent, but what the FIFO holds and the one in work.
    fn report(&mut self) {
        let sent = self.port.stream.sent_words();
        let begun = sent.saturating_sub(self.port.machine.queued_words());
        self.count(begun.saturating_sub(self.rests + 1));
    }

    fn count(&mut self, risen: u32) {
        if risen > self.reported {
            self.odometer.advance(self.run.direction, risen - self.reported);
            self.reported = risen;
        }
    }

    /// No further edge; a pulse that has begun is finished. Then the count is exact.
    fn stop(&mut self) {
        self.port.machine.disable();
        self.port.stream.clear();
        cortex_m::asm::delay(self.words.pulse_cycles());
        self.port.risen = self.port.machine.risen(self.run.steps);
        self.count(self.port.risen);
    }
}

impl Drop for Underway<'_> {
    fn drop(&mut self) {
        self.stop();
    }
}
