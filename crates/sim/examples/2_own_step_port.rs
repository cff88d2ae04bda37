//! A step port of your own: it makes the edges of one axis, here as lines of text.
//!
//! A board implements `StepPort` with its timers and pins. `cargo test -p isostep-tests --test step_port` shows what
//! each port has to keep to; the ports of this project are `TimerPort`, the RP2040's `PioPort` and the simulator's
//! `SimPort`.
//!
//! Run it with `cargo run -p isostep-sim --example 2_own_step_port`.

use std::cell::Cell;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_time::{Duration, Instant, Timer};
use isostep_motion::{
    Capabilities, Direction, DriverTiming, Odometer, PortFault, Run, StartLine, StepPort, StreamItem, StreamQueue,
    Wiring,
};
use isostep_profile::{IntervalLaw, Limits, SpeedLaw, SyncMove};
use isostep_sim::executor::{Executor, RunError};

/// Its clock is that of the tasks, a microsecond fine.
const TICK_HZ: u32 = 1_000_000;

/// Prints a line for every step.
struct PrintingPort;

impl StepPort for PrintingPort {
    fn capabilities(&self) -> Capabilities {
        Capabilities { tick_hz: TICK_HZ, timing: DriverTiming::DRV8825, margin_ticks: 1, core_ns: 0, turn_ticks: 1 }
    }

    async fn run(
        &mut self,
        _run: Run,
        start_line: &StartLine,
        segments: &StreamQueue,
        odometer: &Odometer,
    ) -> Result<(), PortFault> {
        // The first item must be there before the run starts. Then all axes start at once.
        let mut item = segments.receive().await;
        start_line.armed().await;
        let start = Instant::now();
        start_line.begun(start);
        loop {
            match item {
                StreamItem::Steps { segment, direction } => {
                    for ticks in segment.ticks() {
                        // Every instant counts from the start of the run, so nothing accumulates.
                        Timer::at(start + Duration::from_micros(ticks)).await;
                        odometer.count(direction);
                        println!("{:>9} us  step to {}", ticks, odometer.position_steps());
                    }
                }
                StreamItem::Rest { until_ticks } => Timer::at(start + Duration::from_micros(until_ticks)).await,
                StreamItem::End => return Ok(()),
            }
            // A port that has made all that it was given and gets no more cannot keep its instants.
            item = segments.try_receive().map_err(|_| PortFault::Underrun)?;
        }
    }
}

/// Plans ten steps and has the port make them in virtual time.
pub fn main() -> Result<(), RunError> {
    let limits = Limits {
        start_speed_steps_s: 0.0,
        top_speed_steps_s: 100.0,
        accel_steps_s2: 500.0,
        decel_steps_s2: 500.0,
        jerk_steps_s3: f64::INFINITY,
    };
    let plan = SyncMove::plan([10], &[limits], IntervalLaw::Fastest, SpeedLaw::Trapezoid, None)
        .expect("these limits can be planned");
    let made = Rc::new(Cell::new(0));
    let counted = made.clone();
    let mut executor = Executor::new();
    executor.spawn("axis", async move {
        let (queue, start_line, odometer) = (StreamQueue::new(), StartLine::new(), Odometer::new());
        for segment in plan.segments(0, TICK_HZ) {
            queue.send(StreamItem::Steps { segment, direction: Direction::Positive }).await;
        }
        queue.send(StreamItem::End).await;
        let let_go = async {
            start_line.wait_armed().await;
            start_line.go();
        };
        let run = Run { wiring: Wiring::default(), second: None };
        let (result, ()) = join(PrintingPort.run(run, &start_line, &queue, &odometer), let_go).await;
        assert_eq!(result, Ok(()));
        counted.set(odometer.position_steps());
    });
    executor.run_until_quiescent(Instant::from_secs(10))?;
    assert_eq!(made.get(), 10);
    Ok(())
}
