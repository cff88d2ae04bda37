//! Starts: of all axes at one instant, not before they are let go, and so that the first step can be kept.

use std::cell::RefCell;
use std::pin::Pin;
use std::rc::Rc;

use embassy_futures::join::join;
use embassy_futures::select::select;
use embassy_time::{Duration, Instant, Timer};
use isostep_motion::{AXES, Run, StartBarrier, StepCounter, StepPort, StreamItem, StreamQueue, Wiring};
use isostep_profile::Limits;

use crate::plan::{LIMITS, Plan, delayed, steps_of};
use crate::rig::{Ports, Rig, WIRED, carry_out, edges, let_go};

/// The data that an axis shares with the part of the coordinator.
type Link = (StartBarrier, StreamQueue, StepCounter);

/// The axes are let go at one instant, and their tasks go on one after the other, 40 us apart. Some have to set DIR.
pub fn all_axes_start_at_one_instant(ports: impl Ports) {
    for rig in Rig::all(ports) {
        for steps in [3, -3] {
            let links = Rc::new([const { (StartBarrier::new(), StreamQueue::new(), StepCounter::new()) }; AXES]);
            let world = rig.run_tasks(|ports, _| {
                let mut tasks: Vec<Pin<Box<dyn Future<Output = ()>>>> = Vec::new();
                for (axis, port) in ports.into_iter().enumerate() {
                    // Every second axis has DIR as it is at power-up.
                    let plan = Plan::new(if axis % 2 == 0 { steps } else { -steps });
                    tasks.push(Box::pin(make(port, plan, axis, links.clone())));
                }
                tasks.push(Box::pin(let_all_go(rig.to_string(), links)));
                tasks
            });
            let edges = edges(&world);
            assert_eq!(edges.len(), 3 * AXES, "{rig}");
            for step in edges.chunks(AXES) {
                assert!(step.iter().all(|edge| edge.t_ns == step[0].t_ns), "{rig}: {step:?}");
            }
        }
    }
}

/// Makes the steps of one axis.
async fn make(mut port: impl StepPort, plan: Plan, axis: usize, links: Rc<[Link; AXES]>) {
    let (start_barrier, segments, step_counter) = &links[axis];
    for item in plan.items(port.capabilities().tick_hz).chain([StreamItem::End]) {
        segments.send(item).await;
    }
    assert_eq!(port.run(Run::new(WIRED, start_barrier, segments, step_counter)).await, Ok(()));
}

/// Lets all axes go, as soon as all are armed.
async fn let_all_go(rig: String, links: Rc<[Link; AXES]>) {
    for (line, ..) in links.iter() {
        line.wait_armed().await;
    }
    let at = Instant::now();
    for (line, ..) in links.iter() {
        line.go(at);
        Timer::after_micros(40).await;
    }
    let start = links[0].0.wait_begun().await;
    for (line, ..) in &links[1..] {
        assert_eq!(line.wait_begun().await, start, "{rig}: the axes start apart");
    }
}

/// The port is let go at once, with the highest speed from the first step on. The driver's set-up times must still be
/// kept, and every step must be at its instant relative to the start that the port chose.
pub fn a_port_starts_when_it_can_keep_its_first_step(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let rate = f64::from(rig.capabilities().rate_max_steps_s(Wiring::default()));
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let plans = [1, -1, 1].map(|steps| Plan::within(steps, limits));
        let begun = Rc::new(RefCell::new(Vec::new()));
        let reported = begun.clone();
        let world = rig.run(|mut port, _| async move {
            for plan in plans {
                let (queue, start_barrier) = (StreamQueue::new(), StartBarrier::new());
                for item in plan.items(port.capabilities().tick_hz).chain([StreamItem::End]) {
                    queue.try_send(item).unwrap();
                }
                let step_counter = StepCounter::new();
                let run = Run::new(WIRED, &start_barrier, &queue, &step_counter);
                let (result, at) = join(port.run(run), let_go(&start_barrier, Instant::MIN)).await;
                assert_eq!((result, step_counter.position_steps()), (Ok(()), plan.steps()), "{rig}");
                reported.borrow_mut().push((at - ports.lead(), plan));
            }
        });
        rig.assert_plans(&edges(&world), &begun.take());
    }
}

/// It waits for an hour.
pub fn an_armed_port_makes_no_step_before_it_is_let_go(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let start = Instant::from_secs(3_600);
        let (world, _) = rig.makes(vec![(start, Plan::new(500))], WIRED);
        rig.assert_plans(&edges(&world), &[(start, Plan::new(500))]);
    }
}

/// The run is dropped at the start barrier, before the instant at which it would have been let go.
pub fn a_run_dropped_before_its_start_makes_no_step(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let world = rig.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            let late = (Instant::from_secs(1), WIRED);
            select(carry_out(&mut port, Plan::new(3), late, &step_counter), Timer::after_millis(5)).await;
            Timer::after_secs(2).await;
            assert_eq!(step_counter.position_steps(), 0, "{rig}");
            let again = (Instant::from_secs(3), WIRED);
            carry_out(&mut port, Plan::new(2), again, &step_counter).await.unwrap();
            assert_eq!(step_counter.position_steps(), 2, "{rig}");
        });
        rig.assert_plans(&edges(&world), &[(Instant::from_secs(3), Plan::new(2))]);
    }
}

/// An axis without steps that rests many times, once or not at all; and a step after minutes of rests. The run must
/// begin and end normally, and not before it is let go.
pub fn an_axis_may_rest_throughout_its_run(ports: impl Ports) {
    const STEP_AT_S: u64 = 120;
    for rig in Rig::all(ports) {
        let tick_hz = u64::from(rig.capabilities().tick_hz);
        let rests = |count: u64| (1..=count).map(move |k| StreamItem::Rest { until_ticks: k * tick_hz * 15 / 1_000 });
        let step = Plan::new(-1).items(tick_hz as u32).map(|item| delayed(item, STEP_AT_S * tick_hz));
        let late = rests(STEP_AT_S * 66).chain(step).collect::<Vec<_>>();
        let start = Instant::from_secs(1);
        for items in [vec![], rests(1).collect(), rests(1_000).collect(), late.clone(), vec![]] {
            let makes = items.iter().copied().map(steps_of).sum::<i32>();
            let world = rig.run(|mut port, _| async move {
                let step_counter = StepCounter::new();
                let items: Vec<_> = items.into_iter().chain([StreamItem::End]).collect();
                carry_out(&mut port, items, (start, WIRED), &step_counter).await.unwrap();
                assert!(Instant::now() >= start, "{rig}: it ended before it began");
                assert_eq!(step_counter.position_steps(), makes, "{rig}");
                // A second run reverses the direction.
                let at = (Instant::now() + Duration::from_millis(1), WIRED);
                carry_out(&mut port, Plan::new(2), at, &step_counter).await.unwrap();
                assert_eq!(step_counter.position_steps(), makes + 2, "{rig}");
            });
            assert_eq!(world.borrow().counted_steps()[0], makes + 2, "{rig}");
        }
    }
}
