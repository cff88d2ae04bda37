//! The start of a machine's axes: at one instant, or the machine stops.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use embassy_time::{Duration, Instant, TICK_HZ, Timer};
use embedded_hal::digital::{ErrorType, OutputPin};
use isostep_motion::coordinator::{self, PlanMemory};
use isostep_motion::{
    AXES, Alarm, Axis, Capabilities, Contact, DriverTiming, Event, Finish, Machine, Motion, Move, PortFault, Run,
    State, StepPort, StreamItem, axis,
};
use isostep_sim::executor::{Executor, Priority};

/// A port without pins, which waits for each step with `Timer::at`. Its task goes on some time after it was let go.
struct Port {
    delay: Duration,
    /// True if it starts when it goes on, whatever the others do; otherwise a while after all were let go.
    starts_alone: bool,
}

impl StepPort for Port {
    fn capabilities(&self) -> Capabilities {
        Capabilities::new(TICK_HZ as u32, DriverTiming::DRV8825)
    }

    async fn run(&mut self, run: Run<'_>) -> Result<(), PortFault> {
        let mut item = run.segments.receive().await;
        let let_go = run.start_barrier.armed().await;
        Timer::after(self.delay).await;
        let start = if self.starts_alone { Instant::now() } else { let_go + Duration::from_millis(1) };
        run.start_barrier.begun(start);
        loop {
            match item {
                StreamItem::Steps { segment, direction } => {
                    for ticks in segment.ticks() {
                        Timer::at(start + Duration::from_ticks(ticks)).await;
                        run.step_counter.count(direction);
                    }
                }
                StreamItem::Rest { until_ticks } => Timer::at(start + Duration::from_ticks(until_ticks)).await,
                StreamItem::End => return Ok(()),
            }
            item = run.segments.try_receive().map_err(|_| PortFault::Underrun)?;
        }
    }
}

/// The motors are always energised.
struct Enable;

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Moves all axes by 100 steps. The ports go on 40 us apart.
fn moved(starts_alone: bool) -> (State, [i32; AXES], Vec<Event>) {
    let config = isostep_controller::config(&isostep_controller::Settings::DEFAULT);
    let machine: &'static Machine = Box::leak(Box::new(Machine::new(config, Contact::NormallyOpen)));
    let mut executor = Executor::new();
    let events = Rc::new(RefCell::new(Vec::new()));
    for (index, axis) in Axis::ALL.into_iter().enumerate() {
        let mut port = Port { delay: Duration::from_micros(40 * index as u64), starts_alone };
        executor.spawn_at(Priority::P2, "axis", async move { axis::run(machine, axis, &mut port).await });
    }
    let noted = events.clone();
    executor.spawn("coordinator", async move {
        let mut memory = Box::new(PlanMemory::new());
        let least_times = isostep_controller::least_times::RP2040;
        let on_event = |event| noted.borrow_mut().push(event);
        coordinator::run(machine, &mut memory, &least_times, Enable, on_event).await;
    });
    executor.spawn("program", async move {
        let motion = Motion::Move(Move::to([100; AXES]));
        machine.submit(motion).await.unwrap();
    });
    executor.run_until_quiescent(Instant::from_secs(10)).unwrap();
    (machine.state(), machine.position_steps(), events.take())
}

#[test]
fn axes_that_start_apart_stop_the_machine() {
    let (state, position_steps, events) = moved(true);
    let fault = PortFault::Apart { by: Duration::from_micros(40) };
    assert_eq!(state, State::Alarm(Alarm::LateStep { axis: Axis::Y }));
    let ends = |event: &&Event| matches!(event, Event::RunEnd { .. });
    let Some(Event::RunEnd { finish, .. }) = events.iter().find(ends) else { panic!("{events:?}") };
    assert_eq!(*finish, Finish::Fault { axis: Axis::Y, fault });
    assert!(position_steps.iter().all(|steps| *steps < 100), "{position_steps:?}");
}

#[test]
fn axes_whose_tasks_go_on_apart_start_at_one_instant() {
    let (state, position_steps, events) = moved(false);
    assert_eq!((state, position_steps), (State::Idle, [100; AXES]), "{events:?}");
}
