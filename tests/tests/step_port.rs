//! The promises of every [`StepPort`], tested on every port of the simulator with every driver: edges at their
//! closed-form instants, exact counts, whole pulses, and a fault instead of a wrong step. `isostep_tests::cases` tests
//! the same for whole machines, on the emulated board too.

use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::pending;
use std::rc::Rc;

use embassy_futures::join::{join, join4};
use embassy_futures::poll_once;
use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Instant, Timer};
use isostep_motion::{
    AXES, Axis, ConfigError, Motor, Odometer, PortFault, Run, SecondMotor, Side, StartLine, StepPort, StreamItem,
    StreamQueue, Wiring,
};
use isostep_profile::{ACCEL_MAX_STEPS_S2, Limits};
use isostep_sim::time;
use isostep_sim::world::{Edge, Wire};
use isostep_sim::{Config, Port, Sim};
use isostep_tests::cases;
use isostep_tests::rig::{Rig as _, Simulated};
use oorandom::Rand32;

#[path = "step_port/rig.rs"]
mod rig;

use rig::{
    Chain, LIMITS, Plan, Rig, WIRED, carry_out, carry_out_all, carry_out_run, delayed, edges, let_go, rises, steps_of,
};

#[test]
fn every_step_leaves_at_its_instant_there_and_back() {
    for rig in Rig::all() {
        let moves = [(1, 500), (101, -501), (201, 1), (211, -1), (221, 2)];
        let moves = moves.map(|(at_ms, steps)| (Instant::from_millis(at_ms), Plan::new(steps)));
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            for (start, plan) in moves {
                carry_out(&mut port, plan, (start, Wiring::default()), &odometer).await.unwrap();
            }
            assert_eq!(odometer.position_steps(), 1);
        });
        rig.assert_plans(&edges(&world), &moves);
    }
}

#[test]
fn directions_can_be_inverted() {
    for rig in Rig::all() {
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let wiring = Wiring { direction_inverted: true, ..Wiring::default() };
            carry_out(&mut port, Plan::new(5), (Instant::from_millis(1), wiring), &odometer).await.unwrap();
            assert_eq!(odometer.position_steps(), 5);
        });
        assert_eq!(world.borrow().counted_steps()[0], -5, "{rig}");
    }
}

/// Three runs: of both motors, of the second alone, of the first alone, back. The count is that of the axis's steps.
#[test]
fn a_side_that_is_held_makes_no_step_and_the_other_makes_all() {
    for (rig, direction_inverted) in Rig::all().flat_map(|rig| [(rig, false), (rig, true)]) {
        let runs = [(1, 40, None), (51, 30, Some(Side::First)), (101, -20, Some(Side::Second)), (151, 10, None)];
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            for (at_ms, steps, held) in runs {
                let run = Run { second: Some(SecondMotor { direction_inverted, held }), ..WIRED };
                let items = Plan::new(steps).items(port.capabilities().tick_hz).chain([StreamItem::End]).collect();
                carry_out_run(&mut port, items, (Instant::from_millis(at_ms), run), &odometer).await.unwrap();
            }
            assert_eq!(odometer.position_steps(), 60);
        });
        let plans = runs.map(|(at_ms, steps, _)| (Instant::from_millis(at_ms), Plan::new(steps)));
        if !direction_inverted {
            rig.assert_plans(&edges(&world), &plans);
        }
        let [first, second] = [Motor::first(Axis::X), Motor::second(Axis::X)].map(|motor| rises(&world, motor));
        assert_eq!((first.len(), second.len()), (40 + 20 + 10, 40 + 30 + 10), "{rig}");
        assert_eq!((&first[..40], &first[60..]), (&second[..40], &second[70..]), "{rig}: at the same instants");
        let second_steps = if direction_inverted { -80 } else { 80 };
        let skewed_steps = world.borrow().second_place_steps().unwrap() - world.borrow().places_steps()[0];
        assert_eq!(skewed_steps, second_steps - 30, "{rig}");
    }
}

#[test]
fn pulses_are_as_wide_as_the_driver_or_the_wiring_asks() {
    for rig in Rig::all() {
        for asked_ns in [0, 2_000, 10_000] {
            let wiring = Wiring { pulse_ns: asked_ns, ..Wiring::default() };
            let world = rig.run(|mut port, _| async move {
                let start = Instant::from_millis(1);
                carry_out(&mut port, Plan::new(3), (start, wiring), &Odometer::new()).await.unwrap();
            });
            let world = world.borrow();
            let step = world.record().waves.iter().filter(|wave| wave.wire == Wire::Step(Axis::X.into()));
            let pulses: Vec<_> = step.skip_while(|wave| !wave.high).collect();
            let widths_ns: Vec<_> = pulses.chunks(2).map(|pulse| pulse[1].t_ns - pulse[0].t_ns).collect();
            assert_eq!(widths_ns, [u64::from(asked_ns.max(rig.driver.step_high_ns)); 3], "{rig}");
        }
    }
}

/// The run is dropped at 400 instants, a fixed interval apart, which fall all over the move and into its pulses. The
/// brake is on, as in a stopped machine.
#[test]
fn stopping_it_anywhere_leaves_the_exact_count_and_whole_pulses() {
    for rig in Rig::all() {
        for i in 0..400 {
            let world = rig.run(|mut port, clock| async move {
                let odometer = Odometer::new();
                let (start, brake) = (Instant::from_millis(1), port.brake());
                let cut = async {
                    clock.until(time::ns(start) + i * 177_013).await;
                    brake(true);
                };
                select(carry_out(&mut port, Plan::new(500), (start, Wiring::default()), &odometer), cut).await;
                let stopped_at = odometer.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(odometer.position_steps(), stopped_at, "{rig}, cut {i}");
                brake(false);
                let (start, back) = (Instant::now() + Duration::from_millis(1), Plan::new(-stopped_at - 3));
                carry_out(&mut port, back, (start, Wiring::default()), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), -3, "{rig}, cut {i}");
            });
            assert_eq!(world.borrow().counted_steps()[0], -3, "{rig}, cut {i}");
        }
    }
}

/// The port is let go at once, with the highest speed from the first step on. The driver's set-up times must still be
/// kept, and every step must be at its instant relative to the start that the port chose.
#[test]
fn a_port_starts_when_it_can_keep_its_first_step() {
    for rig in Rig::all() {
        let rate = f64::from(rig.capabilities().rate_max_steps_s(Wiring::default()));
        let limits = Limits { start_speed_steps_s: rate, top_speed_steps_s: rate, ..LIMITS };
        let plans = [1, -1, 1].map(|steps| Plan::within(steps, limits));
        let begun = Rc::new(RefCell::new(Vec::new()));
        let reported = begun.clone();
        let world = rig.run(|mut port, _| async move {
            for plan in plans {
                let (queue, start_line) = (StreamQueue::new(), StartLine::new());
                for item in plan.items(port.capabilities().tick_hz).chain([StreamItem::End]) {
                    queue.try_send(item).unwrap();
                }
                let odometer = Odometer::new();
                let run = port.run(WIRED, &start_line, &queue, &odometer);
                let (result, at) = join(run, let_go(&start_line, Instant::MIN)).await;
                assert_eq!((result, odometer.position_steps()), (Ok(()), plan.steps()), "{rig}");
                reported.borrow_mut().push((at, plan));
            }
        });
        rig.assert_plans(&edges(&world), &begun.take());
    }
}

#[test]
fn an_armed_port_makes_no_step_before_it_is_let_go() {
    for rig in Rig::all() {
        let start = Instant::from_secs(3_600);
        let world = rig.run(|mut port, _| async move {
            carry_out(&mut port, Plan::new(500), (start, Wiring::default()), &Odometer::new()).await.unwrap();
        });
        rig.assert_plans(&edges(&world), &[(start, Plan::new(500))]);
    }
}

/// The run is dropped at the start line, before the instant at which it would have been let go.
#[test]
fn a_run_dropped_before_its_start_makes_no_step() {
    for rig in Rig::all() {
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let late = (Instant::from_secs(1), Wiring::default());
            select(carry_out(&mut port, Plan::new(3), late, &odometer), Timer::after_millis(5)).await;
            Timer::after_secs(2).await;
            assert_eq!(odometer.position_steps(), 0, "{rig}");
            let again = (Instant::from_secs(3), Wiring::default());
            carry_out(&mut port, Plan::new(2), again, &odometer).await.unwrap();
            assert_eq!(odometer.position_steps(), 2, "{rig}");
        });
        rig.assert_plans(&edges(&world), &[(Instant::from_secs(3), Plan::new(2))]);
    }
}

/// After the first segments nothing comes for a second. Every port notices that when a step would be too late, not when the
/// next segments come.
#[test]
fn running_dry_is_a_fault_and_nothing_rises_after_it() {
    for rig in Rig::all() {
        let (start, plan) = (Instant::from_millis(1), Plan::new(500));
        let noticed = Rc::new(Cell::new(0));
        let noting = noticed.clone();
        let world = rig.run(|mut port, _| async move {
            let (queue, start_line, odometer) = (StreamQueue::new(), StartLine::new(), Odometer::new());
            let mut items = plan.items(port.capabilities().tick_hz);
            let fed: i32 = items.by_ref().take(3).inspect(|item| queue.try_send(*item).unwrap()).map(steps_of).sum();
            let item = async {
                let_go(&start_line, start).await;
                Timer::after_secs(1).await;
                for item in items {
                    queue.send(item).await;
                }
                pending::<Infallible>().await
            };
            let Either::First(result) = select(port.run(WIRED, &start_line, &queue, &odometer), item).await;
            assert!(matches!(result, Err(PortFault::Underrun | PortFault::Late { .. })), "{rig}: {result:?}");
            assert_eq!(odometer.position_steps(), fed, "{rig}");
            noting.set(time::ns(Instant::now()));
        });
        let edges = edges(&world);
        let last = edges.last().unwrap().t_ns;
        assert!(noticed.get() <= last + 250_000, "{rig}: the last edge at {last} ns, noticed at {} ns", noticed.get());
        assert!(last < time::ns(start) + 100_000_000, "{rig}: nothing but what was given in time");
    }
}

#[test]
fn steps_that_are_too_close_for_the_pulses_end_in_a_fault_not_in_a_cut_pulse() {
    for rig in Rig::all() {
        let count = Rc::new(RefCell::new(0));
        let counted = count.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            // At 20,000 steps/s steps are 50 us apart.
            let wiring = Wiring { pulse_ns: 60_000, ..Wiring::default() };
            let result = carry_out(&mut port, Plan::new(2_000), (Instant::from_millis(1), wiring), &odometer).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            counted.replace(odometer.position_steps());
        });
        let count = count.take();
        assert!(count > 0, "{rig}: the slow steps are made");
        assert_eq!(edges(&world).len() as i32, count, "{rig}");
    }
}

#[test]
fn the_highest_rate_it_claims_works_from_rest_and_the_next_is_refused() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        let rate = f64::from(capabilities.rate_max_steps_s(Wiring::default()));
        // The ramp has at least 500 steps.
        let accel = (rate * rate / 1_000.0).min(ACCEL_MAX_STEPS_S2);
        let limits = Limits {
            start_speed_steps_s: 0.0,
            top_speed_steps_s: rate,
            accel_steps_s2: accel,
            decel_steps_s2: accel,
            jerk_steps_s3: f64::INFINITY,
        };
        let moves = [2_000, -2_001].map(|steps| Plan::within(steps, limits));
        let moves = [1, 101].map(Instant::from_millis).into_iter().zip(moves).collect::<Vec<_>>();
        let carried_out = moves.clone();
        let world = rig.run(|mut port, _| async move {
            for (start, plan) in carried_out {
                carry_out(&mut port, plan, (start, Wiring::default()), &Odometer::new()).await.unwrap();
            }
        });
        rig.assert_plans(&edges(&world), &moves);

        let mut config = Sim::new(&Config::default()).machine().config();
        config.wiring = [Wiring::default(); AXES];
        config.limits = [limits; AXES];
        assert_eq!(config.check([Some(capabilities); AXES]), Ok(()), "{rig}");
        config.limits[2].top_speed_steps_s = rate + 1.0;
        let refused = config.check([Some(capabilities); AXES]);
        assert!(
            matches!(refused, Err(ConfigError::Rate { axis: Axis::Z, max, .. }) if max == rate),
            "{rig}: {refused:?}"
        );
    }
}

/// Three steps in three hours. An hour is 4.5e11 ticks of 8 ns, far beyond 32 bits.
#[test]
fn steps_may_be_an_hour_apart() {
    for rig in Rig::all() {
        let limits = Limits { top_speed_steps_s: 1.0, accel_steps_s2: 1.0, decel_steps_s2: 1.0, ..LIMITS };
        let moves = [(Instant::from_millis(1), Plan::beside(10_800, 3, limits))];
        let world = rig.run(|mut port, _| async move {
            let [(start, plan)] = moves;
            carry_out(&mut port, plan, (start, Wiring::default()), &Odometer::new()).await.unwrap();
        });
        rig.assert_plans(&edges(&world), &moves);
    }
}

/// Seed of the random chains.
const SEED: u64 = 11;

#[test]
fn moves_there_and_back_in_one_run_are_exact() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        for steps in [1, 2, 16, 100] {
            let chain = Chain::random(&mut random, &rig.capabilities(), steps);
            let (start, items, net) = (Instant::from_millis(1), chain.items(), chain.steps());
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                carry_out_all(&mut port, items, (start, Wiring::default()), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), net, "{rig}, SEED={SEED}");
            });
            rig.assert_edges(&edges(&world), chain.instants_ns(start));
        }
    }
}

/// Steps as close as the port accepts in one direction.
#[test]
fn steps_to_and_fro_may_be_as_close_as_others() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        for pulse_ns in [0, 3_000] {
            let wiring = Wiring { pulse_ns, ..Wiring::default() };
            let chain = Chain::to_and_fro(capabilities.tick_hz, 1_001, capabilities.period_min_ticks(wiring));
            let (start, items) = (Instant::from_millis(1), chain.items());
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                carry_out_all(&mut port, items, (start, wiring), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), 1, "{rig}");
            });
            rig.assert_edges(&edges(&world), chain.instants_ns(start));
        }
    }
}

/// Steps closer by a quarter. The run must end by a fault, no pulse may be cut short, and DIR's times must be kept.
#[test]
fn steps_to_and_fro_that_are_too_close_are_refused() {
    for rig in Rig::all() {
        let capabilities = rig.capabilities();
        let period_ticks = capabilities.period_min_ticks(Wiring::default()) * 3 / 4;
        let chain = Chain::to_and_fro(capabilities.tick_hz, 2_000, period_ticks);
        let (start, items) = (Instant::from_millis(1), chain.items());
        let counted = Rc::new(RefCell::new(0));
        let reported = counted.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let result = carry_out_all(&mut port, items, (start, Wiring::default()), &odometer).await;
            assert!(matches!(result, Err(PortFault::TooFast { .. } | PortFault::Late { .. })), "{rig}: {result:?}");
            reported.replace(odometer.position_steps());
        });
        assert_eq!(world.borrow().counted_steps()[0], counted.take(), "{rig}");
    }
}

/// The run is stopped in the middle of a random chain, with the brake on, and dropped. DIR is inverted in every second
/// case.
#[test]
fn stopping_it_between_reversals_leaves_the_exact_count() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        for i in 0..200 {
            let chain = Chain::random(&mut random, &rig.capabilities(), 12);
            let start = Instant::from_millis(1);
            let lasts_ns = (1_000_000_000 * chain.end_ticks / u64::from(chain.tick_hz)) as u32;
            let (stop_ns, items) = (time::ns(start) + u64::from(random.rand_range(0..lasts_ns)), chain.items());
            let inverted = i % 2 == 1;
            let wiring = Wiring { direction_inverted: inverted, ..Wiring::default() };
            let world = rig.run(|mut port, clock| async move {
                let (odometer, brake) = (Odometer::new(), port.brake());
                let cut = async {
                    clock.until(stop_ns).await;
                    brake(true);
                };
                select(carry_out_all(&mut port, items, (start, wiring), &odometer), cut).await;
                let stopped_at = odometer.position_steps();
                Timer::after_millis(1).await;
                assert_eq!(odometer.position_steps(), stopped_at, "{rig}, SEED={SEED}, stop {i}");
                brake(false);
                let back = Plan::new(-stopped_at - 2_000);
                carry_out(&mut port, back, (Instant::now(), wiring), &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), -2_000, "{rig}, SEED={SEED}, stop {i}");
            });
            let seen = world.borrow().counted_steps()[0];
            assert_eq!(seen, if inverted { 2_000 } else { -2_000 }, "{rig}, SEED={SEED}, stop {i}");
        }
    }
}

/// While the port runs, the odometer must show a position that the edges had within the last 10 ms.
#[test]
fn the_count_follows_through_reversals() {
    for rig in Rig::all() {
        let mut random = Rand32::new(SEED);
        let chain = Chain::random(&mut random, &rig.capabilities(), 60);
        let (start, items) = (Instant::from_millis(1), chain.items());
        let looks = Rc::new(RefCell::new(Vec::new()));
        let noted = looks.clone();
        let world = rig.run(|mut port, _| async move {
            let odometer = Odometer::new();
            let look = async {
                loop {
                    Timer::after_micros(random.rand_range(100..5_000).into()).await;
                    noted.borrow_mut().push((time::ns(Instant::now()), odometer.position_steps()));
                }
            };
            let run = carry_out_all(&mut port, items, (start, Wiring::default()), &odometer);
            let Either::First(result) = select(run, look).await;
            result.unwrap();
        });
        let edges = edges(&world);
        assert!(looks.borrow().len() > 20, "{rig}");
        for &(now_ns, steps) in looks.borrow().iter() {
            // A step may rise at the very instant at which the odometer is read.
            let seen = edges.iter().take_while(|edge| edge.t_ns <= now_ns);
            let (old, recent): (Vec<&Edge>, Vec<&Edge>) = seen.partition(|edge| edge.t_ns + 10_000_000 < now_ns);
            let was = old.last().map_or(0, |edge| edge.position_steps);
            let is_recent = was == steps || recent.iter().any(|edge| edge.position_steps == steps);
            assert!(is_recent, "{rig}, SEED={SEED}: {steps} steps at {now_ns} ns");
        }
    }
}

/// An axis without steps that rests many times, once or not at all; and a step after minutes of rests. The run must
/// begin and end normally, and not before it is let go.
#[test]
fn an_axis_may_rest_throughout_its_run() {
    const STEP_AT_S: u64 = 120;
    for rig in Rig::all() {
        let tick_hz = u64::from(rig.capabilities().tick_hz);
        let rests = |count: u64| (1..=count).map(move |k| StreamItem::Rest { until_ticks: k * tick_hz * 15 / 1_000 });
        let step = Plan::new(-1).items(tick_hz as u32).map(|item| delayed(item, STEP_AT_S * tick_hz));
        let late = rests(STEP_AT_S * 66).chain(step).collect::<Vec<_>>();
        let start = Instant::from_secs(1);
        for items in [vec![], rests(1).collect(), rests(1_000).collect(), late.clone(), vec![]] {
            let makes = items.iter().copied().map(steps_of).sum::<i32>();
            let world = rig.run(|mut port, _| async move {
                let odometer = Odometer::new();
                let items = items.into_iter().chain([StreamItem::End]).collect();
                carry_out_all(&mut port, items, (start, Wiring::default()), &odometer).await.unwrap();
                assert!(Instant::now() >= start, "{rig}: it ended before it began");
                assert_eq!(odometer.position_steps(), makes, "{rig}");
                // A second run reverses the direction.
                let at = (Instant::now() + Duration::from_millis(1), Wiring::default());
                carry_out(&mut port, Plan::new(2), at, &odometer).await.unwrap();
                assert_eq!(odometer.position_steps(), makes + 2, "{rig}");
            });
            assert_eq!(world.borrow().counted_steps()[0], makes + 2, "{rig}");
        }
    }
}

#[test]
fn machines_keep_count_whenever_they_are_stopped() {
    Port::ALL.into_iter().for_each(|port| cases::stops_leave_the_exact_count(Simulated(port)));
}

#[test]
fn machines_make_single_steps_and_many_of_all_axes_there_and_back() {
    Port::ALL.into_iter().for_each(|port| cases::moves_there_and_back_are_exact(Simulated(port)));
}

#[test]
fn machines_take_as_long_as_planned_over_single_steps() {
    Port::ALL.into_iter().for_each(|port| cases::single_steps_take_as_long_as_planned(Simulated(port), 3.0));
}

#[test]
fn machines_make_every_speed_law() {
    for port in Port::ALL {
        cases::every_law_is_exact(Simulated(port), Simulated(port).pace(), 1);
    }
}

#[test]
fn machines_make_the_highest_rate_their_ports_take() {
    // These are 248,015 and 200,000 steps/s at 50 steps/mm.
    for (port, top_mm_min) in [(Port::Pio, 297_618), (Port::Timer, 240_000)] {
        cases::the_highest_rate_is_made(Simulated(port), top_mm_min);
    }
}

/// A run may be stopped between arming and the start. What was signalled for it must not start the next one.
#[test]
fn a_start_line_forgets_an_earlier_run() {
    let line = StartLine::new();
    assert!(poll_once(line.armed()).is_pending(), "nobody has let it go");
    line.go();
    line.begun(Instant::from_ticks(1));
    line.reset();
    assert!(poll_once(line.wait_armed()).is_pending(), "armed for the run before");
    assert!(poll_once(line.wait_begun()).is_pending(), "begun in the run before");
    assert!(poll_once(line.armed()).is_pending(), "let go for the run before");
}

/// Steps are accepted up to 208 us late, which is half a period of the default machine's top speed. Until shortly before the
/// step that is late the port knows that none is due.
#[test]
fn a_step_that_is_too_late_by_microseconds_is_a_fault() {
    let slow = Limits { top_speed_steps_s: 500.0, accel_steps_s2: 10_000.0, decel_steps_s2: 10_000.0, ..LIMITS };
    for (late_us, is_made) in [(100, true), (200, true), (215, false), (300, false), (1_000, false)] {
        let rig = Rig { port: Port::Timer, driver: isostep_motion::DriverTiming::DRV8825 };
        rig.run(move |mut port, _| async move {
            let (start, plan) = (Instant::from_millis(1), Plan::within(60, slow));
            let (queue, start_line, odometer) = (StreamQueue::new(), StartLine::new(), Odometer::new());
            let mut items = plan.items(port.capabilities().tick_hz);
            let fed: i32 = items.by_ref().take(1).inspect(|item| queue.try_send(*item).unwrap()).map(steps_of).sum();
            let due_ns = plan.instants_ns(start).nth(fed as usize).unwrap().0;
            let until_ticks = (due_ns as u64 - time::ns(start)) / 1_000 - 5;
            queue.try_send(StreamItem::Rest { until_ticks }).unwrap();
            let feed = async {
                let_go(&start_line, start).await;
                Timer::at(Instant::from_micros(due_ns as u64 / 1_000 + late_us)).await;
                for item in items.chain([StreamItem::End]) {
                    queue.send(item).await;
                }
                pending::<Infallible>().await
            };
            let Either::First(result) = select(port.run(WIRED, &start_line, &queue, &odometer), feed).await;
            if is_made {
                assert_eq!(result, Ok(()), "{late_us} us late");
            } else {
                assert!(matches!(result, Err(PortFault::Late { .. })), "{late_us} us late: {result:?}");
            }
        });
    }
}

/// The tasks of the axes may get no time while steps are due, so the task that makes the steps stops all axes itself, at
/// the instant at which it notices that one is late.
#[test]
fn a_step_that_is_too_late_stops_all_axes() {
    const LATE: Duration = Duration::from_millis(1);
    let rig = Rig { port: Port::Timer, driver: isostep_motion::DriverTiming::DRV8825 };
    let noticed = Rc::new(Cell::new(None));
    let noting = noticed.clone();
    let world = rig.run_all(|[mut x, mut y, _], _| async move {
        let (start, plan) = (Instant::from_millis(1), Plan::new(3_000));
        let (queues, odometers) = ([const { StreamQueue::new() }; 2], [const { Odometer::new() }; 2]);
        let lines = [const { StartLine::new() }; 2];
        let items = plan.items(x.capabilities().tick_hz);
        let mut steps = 0;
        let (in_time, late): (Vec<_>, Vec<_>) = items.clone().partition(|&item| {
            steps += steps_of(item);
            steps < 1_500
        });
        let made: i32 = in_time.iter().copied().map(steps_of).sum();
        let due_ns = plan.instants_ns(start).nth(made as usize).unwrap().0;
        let feed_late = async {
            send_all(&queues[0], in_time.into_iter()).await;
            Timer::at(Instant::from_nanos(due_ns as u64) + LATE).await;
            send_all(&queues[0], late.into_iter()).await;
        };
        let go = join(let_go(&lines[0], start), let_go(&lines[1], start));
        let others =
            join4(y.run(WIRED, &lines[1], &queues[1], &odometers[1]), feed_late, send_all(&queues[1], items), go);
        let fault = async {
            let result = x.run(WIRED, &lines[0], &queues[0], &odometers[0]).await;
            assert!(matches!(result, Err(PortFault::Late { .. })), "{result:?}");
            noting.set(Some(time::ns(Instant::now())));
            Timer::after_millis(20).await;
        };
        assert!(matches!(select(fault, others).await, Either::First(())));
    });
    let noticed_ns = noticed.get().unwrap();
    let last = edges(&world).last().copied().unwrap();
    assert_eq!(last.axis, Axis::Y as usize);
    assert!((noticed_ns - 100_000..=noticed_ns).contains(&last.t_ns), "{last:?}, noticed at {noticed_ns} ns");
}

async fn send_all(queue: &StreamQueue, items: impl Iterator<Item = StreamItem>) {
    for item in items {
        queue.send(item).await;
    }
}
