//! Stops: at any instant no pulse is cut short, and the count is exact.

use std::cell::RefCell;
use std::rc::Rc;

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use isostep_motion::{Motors, StepCounter, StepPort, Wiring};
use isostep_sim::time;
use isostep_sim::world::Edge;
use oorandom::Rand32;

use crate::plan::{Chain, Plan, SEED};
use crate::rig::{Ports, Rig, WIRED, carry_out, edges};

/// The run is dropped at 400 instants, a fixed interval apart, which fall all over the move and into its pulses. The
/// inhibit is on, as in a stopped machine.
pub fn stopping_it_anywhere_leaves_the_exact_count_and_whole_pulses(ports: impl Ports) {
    for rig in Rig::all(ports) {
        for i in 0..400 {
            let world = rig.run(|mut port, clock| async move {
                let step_counter = StepCounter::new();
                let (start, inhibit) = (Instant::from_millis(1), port.inhibit());
                let cut = async {
                    clock.until(time::ns(start) + i * 177_013).await;
                    inhibit(true);
                };
                select(carry_out(&mut port, Plan::new(500), (start, WIRED), &step_counter), cut).await;
                let stopped_at = step_counter.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(step_counter.position_steps(), stopped_at, "{rig}, cut {i}");
                inhibit(false);
                let (start, back) = (Instant::now() + Duration::from_millis(1), Plan::new(-stopped_at - 3));
                carry_out(&mut port, back, (start, WIRED), &step_counter).await.unwrap();
                assert_eq!(step_counter.position_steps(), -3, "{rig}, cut {i}");
            });
            assert_eq!(world.borrow().counted_steps()[0], -3, "{rig}, cut {i}");
        }
    }
}

/// The run is stopped in the middle of a random chain, with the inhibit on, and dropped. DIR is inverted in every second
/// case.
pub fn stopping_it_between_reversals_leaves_the_exact_count(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let mut random = Rand32::new(SEED);
        for i in 0..200 {
            let chain = Chain::random(&mut random, &rig.capabilities(), 12);
            let start = Instant::from_millis(1);
            let lasts_ns = (1_000_000_000 * chain.end_ticks / u64::from(chain.tick_hz)) as u32;
            let (stop_ns, items) = (time::ns(start) + u64::from(random.rand_range(0..lasts_ns)), chain.items());
            let inverted = i % 2 == 1;
            let wiring = Wiring { direction_inverted: inverted, ..Wiring::default() };
            let motors = Motors { wiring, ..WIRED };
            let world = rig.run(|mut port, clock| async move {
                let (step_counter, inhibit) = (StepCounter::new(), port.inhibit());
                let cut = async {
                    clock.until(stop_ns).await;
                    inhibit(true);
                };
                select(carry_out(&mut port, items, (start, motors), &step_counter), cut).await;
                let stopped_at = step_counter.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(step_counter.position_steps(), stopped_at, "{rig}, SEED={SEED}, stop {i}");
                inhibit(false);
                let back = Plan::new(-stopped_at - 2_000);
                carry_out(&mut port, back, (Instant::now(), motors), &step_counter).await.unwrap();
                assert_eq!(step_counter.position_steps(), -2_000, "{rig}, SEED={SEED}, stop {i}");
            });
            let seen = world.borrow().counted_steps()[0];
            assert_eq!(seen, if inverted { 2_000 } else { -2_000 }, "{rig}, SEED={SEED}, stop {i}");
        }
    }
}

/// While the port runs, the step counter must show a position that the edges had within the last 10 ms.
pub fn the_count_follows_through_reversals(ports: impl Ports) {
    for rig in Rig::all(ports) {
        let mut random = Rand32::new(SEED);
        let chain = Chain::random(&mut random, &rig.capabilities(), 60);
        let (start, items) = (Instant::from_millis(1), chain.items());
        let looks = Rc::new(RefCell::new(Vec::new()));
        let noted = looks.clone();
        let world = rig.run(|mut port, _| async move {
            let step_counter = StepCounter::new();
            let look = async {
                loop {
                    Timer::after_micros(random.rand_range(100..5_000).into()).await;
                    noted.borrow_mut().push((time::ns(Instant::now()), step_counter.position_steps()));
                }
            };
            let run = carry_out(&mut port, items, (start, WIRED), &step_counter);
            let Either::First(result) = select(run, look).await;
            result.unwrap();
        });
        let edges = edges(&world);
        assert!(looks.borrow().len() > 20, "{rig}");
        for &(now_ns, steps) in looks.borrow().iter() {
            // A step may rise at the very instant at which the step counter is read.
            let seen = edges.iter().take_while(|edge| edge.t_ns <= now_ns);
            let (old, recent): (Vec<&Edge>, Vec<&Edge>) = seen.partition(|edge| edge.t_ns + 10_000_000 < now_ns);
            let was = old.last().map_or(0, |edge| edge.position_steps);
            let is_recent = was == steps || recent.iter().any(|edge| edge.position_steps == steps);
            assert!(is_recent, "{rig}, SEED={SEED}: {steps} steps at {now_ns} ns");
        }
    }
}
