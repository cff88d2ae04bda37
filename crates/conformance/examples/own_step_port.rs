//! A step port of your own, for any pins: it waits for each step with `Timer::at`, and makes the pulse by a blocking
//! delay. Two axes draw a line in a simulated machine.
//!
//! `TimerPort` does the same with one task for all axes, which costs less. `crates/conformance/tests/own_step_port.rs`
//! tests this port with the promises of all ports.
//!
//! Run it with `cargo run -p isostep-conformance --example own_step_port`.

use std::cell::RefCell;
use std::fmt;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_time::{Duration, Instant, TICK_HZ, Timer};
use embedded_hal::delay::DelayNs;
use isostep_conformance::{Bench, Ports, Rig};
use isostep_motion::{
    AXES, Axis, Capabilities, Direction, DriverTiming, MotorPins, Motors, PortFault, Run, StartBarrier, StepCounter,
    StepPort, StreamItem, StreamQueue, Wiring, ticks_covering,
};
use isostep_profile::{IntervalSplit, Limits, Segment, SpeedProfile, SyncMove};

/// From the instant at which all axes are let go to the start of their run: each task has gone on by then, and DIR has
/// been set up.
const LEAD: Duration = Duration::from_micros(500);
/// A step is made up to this late. Later ones would be bunched.
const LATE_MAX: Duration = Duration::from_micros(20);

/// One axis.
pub struct OwnPort<P, D> {
    pins: P,
    delay: D,
    capabilities: Capabilities,
    dir_high: bool,
    /// When STEP may rise.
    ready: Instant,
}

impl<P: MotorPins, D: DelayNs> OwnPort<P, D> {
    /// A port at rest, STEP and DIR low.
    pub fn new(pins: P, delay: D, timing: DriverTiming) -> Self {
        // A reading of the clock may be almost a tick old. DIR changes as soon as a pulse has ended.
        let mut capabilities = Capabilities::new(TICK_HZ as u32, timing);
        (capabilities.margin_ticks, capabilities.core_ns) = (1, 30_000);
        Self { pins, delay, capabilities, dir_high: false, ready: Instant::MIN }
    }

    /// Makes the steps of a segment. `last` is the instant of the step before.
    async fn make(
        &mut self,
        segment: &Segment,
        direction: Direction,
        (start, last): (Instant, &mut Option<Instant>),
        run: &Run<'_>,
    ) -> Result<(), PortFault> {
        let min = self.capabilities.period_min_ticks(run.motors.wiring) - self.capabilities.margin_ticks;
        self.face(direction, run.motors.wiring);
        for ticks in segment.ticks() {
            // Every instant counts from the start of the run, so nothing accumulates.
            let due = start + Duration::from_ticks(ticks);
            let interval = last.map_or(u64::MAX, |last| (due - last).as_ticks()).min(u32::MAX.into()) as u32;
            if interval < min {
                return Err(PortFault::TooFast { interval, min });
            }
            Timer::at(due.max(self.ready)).await;
            let late = Instant::now() - due;
            if late > LATE_MAX {
                return Err(PortFault::Late { late, max: LATE_MAX });
            }
            // Nothing is awaited from the rise to the fall: a run that is dropped cuts no pulse short.
            self.pins.set_step(true);
            run.step_counter.count(direction);
            self.delay.delay_ns(self.capabilities.pulse_ns(run.motors.wiring));
            self.pins.set_step(false);
            let Capabilities { tick_hz, timing, margin_ticks, .. } = self.capabilities;
            let low_ticks = ticks_covering(timing.step_low_ns, tick_hz) + margin_ticks;
            self.ready = Instant::now() + Duration::from_ticks(low_ticks.into());
            *last = Some(due);
        }
        Ok(())
    }

    /// Sets DIR, whose hold time is over with the last pulse.
    fn face(&mut self, direction: Direction, wiring: Wiring) {
        let high = (direction == Direction::Positive) != wiring.direction_inverted;
        if high != self.dir_high {
            self.dir_high = high;
            self.pins.set_dir(high);
            self.delay.delay_ns(self.capabilities.timing.setup_ns);
        }
    }
}

impl<P: MotorPins, D: DelayNs> StepPort for OwnPort<P, D> {
    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        // The first item must be there before the run starts.
        let mut item = run.segments.receive().await;
        self.pins.begin(&run.motors);
        self.delay.delay_ns(self.capabilities.timing.setup_ns);
        // All axes are told the same instant, whenever their tasks go on.
        let start = run.start_barrier.armed().await + LEAD;
        run.start_barrier.begun(start);
        let mut last = None;
        loop {
            match item {
                StreamItem::Steps { segment, direction } => {
                    self.make(&segment, direction, (start, &mut last), &run).await?;
                }
                StreamItem::Rest { until_ticks } => Timer::at(start + Duration::from_ticks(until_ticks)).await,
                StreamItem::End => {
                    Timer::at(start).await;
                    return Ok(());
                }
            }
            // A port that has made all that it was given and gets no more cannot keep its instants.
            item = run.segments.try_receive().map_err(|_| PortFault::Underrun)?;
        }
    }
}

/// These ports, as the tests open them.
#[derive(Clone, Copy)]
pub struct OwnPorts;

impl Ports for OwnPorts {
    type Port = OwnPort<isostep_sim::port::AxisPins, isostep_sim::pin::Delay>;

    fn open(&self, bench: &mut Bench<'_>) -> [Self::Port; AXES] {
        Axis::ALL.map(|axis| OwnPort::new(bench.pins(axis), bench.delay(), bench.driver))
    }

    fn lead(&self) -> Duration {
        LEAD
    }
}

impl fmt::Display for OwnPorts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a port of your own")
    }
}

/// Plans a move of ten steps of X and five of Y, has the ports make them in virtual time, and prints them.
pub fn main() {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 100.0,
        accel_steps_s2: 500.0,
        decel_steps_s2: 500.0,
        jerk_steps_s3: f64::INFINITY,
    };
    let plan = SyncMove::plan([10, 5], &[limits; 2], IntervalSplit::Fastest, SpeedProfile::Trapezoid, None)
        .expect("these limits can be planned");
    let counted = Rc::new(RefCell::new([0; 2]));
    let counts = counted.clone();
    let world = Rig::new(OwnPorts, DriverTiming::DRV8825).run_all(|[mut x, mut y, ..], _| async move {
        let axes = [const { (StartBarrier::new(), StreamQueue::new(), StepCounter::new()) }; 2];
        for (index, (_, segments, _)) in axes.iter().enumerate() {
            for segment in plan.segments(index, TICK_HZ as u32) {
                segments.send(StreamItem::Steps { segment, direction: Direction::Positive }).await;
            }
            segments.send(StreamItem::End).await;
        }
        let [run_x, run_y] = axes.each_ref().map(|(start_barrier, segments, step_counter)| {
            Run::new(Motors::default(), start_barrier, segments, step_counter)
        });
        // The part of the coordinator: it lets all axes go at once, when all are armed.
        let let_go = async {
            for (line, ..) in &axes {
                line.wait_armed().await;
            }
            let now = Instant::now();
            axes.iter().for_each(|(line, ..)| line.go(now));
        };
        let (results, ()) = join(join(x.run(run_x), y.run(run_y)), let_go).await;
        assert_eq!(results, (Ok(()), Ok(())));
        counts.replace(axes.each_ref().map(|(.., step_counter)| step_counter.position_steps()));
    });
    for edge in &world.borrow().record().edges {
        println!("{:>7} us  {} to {}", edge.t_ns / 1_000, Axis::ALL[edge.axis], edge.position_steps);
    }
    assert_eq!(*counted.borrow(), [10, 5]);
}
