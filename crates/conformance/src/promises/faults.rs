//! Faults: what cannot be made at its instant is not made, and no step after it.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::select::{Either, select};
use embassy_time::{Instant, Timer};
use isostep_motion::{Motors, PortFault, Run, StartBarrier, StepCounter, StepPort, StreamQueue, Wiring};
use isostep_sim::time;

use crate::plan::{Chain, Plan, steps_of};
use crate::rig::{Ports, Rig, WIRED, carry_out, edges, let_go};

/// After the first segments nothing comes for a second. Every port notices that when a step would be too late, not when the
/// next segments come.
pub fn running_dry_is_a_fault_and_nothing_rises_after_it(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let (start, plan) = (Instant::from_millis(1), Plan::new(500));
        let noticed = Rc::new(Cell::new(0));
        let noting = noticed.clone();
        let world = rig.run(|mut port, _| async move {
            let (queue, start_barrier, step_counter) = (StreamQueue::new(), StartBarrier::new(), StepCounter::new());
            let mut items = plan.items(port.capabilities().tick_hz);
            let fed: i32 = items.by_ref().take(3).inspect(|item| queue.try_send(*item).unwrap()).map(steps_of).sum();
            let item = async {
                let_go(&start_barrier, start).await;
                Timer::after_secs(1).await;
                for item in items {
                    queue.send(item).await;
                }
                pending::<Infallible>().await
            };
            let run = Run::new(WIRED, &start_barrier, &queue, &step_counter);
            let Either::First(result) = select(port.run(run), item).await;
            assert!(matches!(result, Err(PortFault::Underrun | PortFault::Late { .. })), "{rig}: {result:?}");
            assert_eq!(step_counter.position_steps(), fed, "{rig}");
            noting.set(time::ns(Instant::now()));
        });
        let edges = edges(&world);
        let last = edges.last().unwrap().t_ns;
        assert!(noticed.get() <= last + 250_000, "{rig}: the last edge at {last} ns, noticed at {} ns", noticed.get());
        assert!(last < time::ns(start) + 100_000_000, "{rig}: nothing but what was given in time");
    }
}

/// The pulses are longer than the steps are apart.
pub fn steps_that_are_too_close_for_the_pulses_end_in_a_fault_not_in_a_cut_pulse(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let count = Rc::new(RefCell::new(0));
        let counted = count.clone();
        let world = rig.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            // At 20,000 steps/s steps are 50 us apart.
            let wiring = Wiring { pulse_ns: 60_000, ..Wiring::default() };
            let at = (Instant::from_millis(1), Motors { wiring, ..WIRED });
            let result = carry_out(&mut port, Plan::new(2_000), at, &step_counter).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            counted.replace(step_counter.position_steps());
        });
        let count = count.take();
        assert!(count > 0, "{rig}: the slow steps are made");
        assert_eq!(edges(&world).len() as i32, count, "{rig}");
    }
}

/// Steps closer by a quarter. The run must end by a fault, no pulse may be cut short, and DIR's times must be kept.
pub fn steps_to_and_fro_that_are_too_close_are_refused(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let capabilities = rig.capabilities();
        let period_ticks = capabilities.period_min_ticks(Wiring::default()) * 3 / 4;
        let chain = Chain::to_and_fro(capabilities.tick_hz, 2_000, period_ticks);
        let (start, items) = (Instant::from_millis(1), chain.items());
        let counted = Rc::new(RefCell::new(0));
        let reported = counted.clone();
        let world = rig.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            let result = carry_out(&mut port, items, (start, WIRED), &step_counter).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            reported.replace(step_counter.position_steps());
        });
        assert_eq!(world.borrow().counted_steps()[0], counted.take(), "{rig}");
    }
}
