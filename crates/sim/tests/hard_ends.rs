//! A carriage that is driven against a hard end, STEP by STEP, on a board whose driver shows the stall at the limit input.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::rc::Rc;

use embassy_time::Instant;
use isostep_sim::drivers::DriverFault;
use isostep_sim::executor::{Executor, Priority};
use isostep_sim::time::Clock;
use isostep_sim::world::{self, LossCause, Shared, Wire, World};
use isostep_sim::{Axis, Board, Config};
use tmc2209::reg::{CHOPCONF, GCONF, SGTHRS, TCOOLTHRS};
use tmc2209::{WritableRegister, WriteRequest};

const MICROSTEPS: i32 = 16;
/// A screw, which can start at the speed of these tests.
const STEPS_PER_MM: f32 = 400.0;
/// The end stop is 3 mm below the switch of X.
const END_STEPS: i32 = -1_200;
/// The interval of steps: 250 full steps a second, a `TSTEP` of 187, 10 mm/s.
const STEP_NS: u64 = 250_000;
const THRESHOLD: u32 = 50;
const TCOOLTHRS_CLOCKS: u32 = 300;
/// The distance that it backs off from the end.
const OFF_STEPS: i32 = 100;

/// X, whose carriage is driven by hand.
struct Driven {
    world: Shared,
    clock: Clock,
}

impl Driven {
    fn new(config: &Config) -> Self {
        let clock = Clock::new();
        Self::with(Rc::new(RefCell::new(World::new(clock.clone(), config))), clock)
    }

    fn with(world: Shared, clock: Clock) -> Self {
        let driven = Self { world, clock };
        driven.set(GCONF::from(1 << 6 | 1 << 7));
        driven.set(CHOPCONF::from(4 << 24 | 3));
        driven.set(SGTHRS::from(THRESHOLD));
        driven.set(TCOOLTHRS::from(TCOOLTHRS_CLOCKS));
        driven.world.borrow_mut().drive(Wire::Enable, false);
        driven
    }

    fn set<R: WritableRegister>(&self, register: R) {
        self.world.borrow_mut().exchange_with_drivers(WriteRequest::new(0, register).bytes());
    }

    /// A step away from the switch, or towards it.
    fn step(&self, away: bool) {
        self.clock.advance_to(self.clock.now_ns() + STEP_NS);
        let mut world = self.world.borrow_mut();
        world.drive(Wire::Dir(Axis::X.into()), away);
        world.drive(Wire::Step(Axis::X.into()), true);
        world.drive(Wire::Step(Axis::X.into()), false);
    }

    fn stalls(&self) -> bool {
        self.world.borrow().is_high(Wire::Limit(Axis::X.into()))
    }

    fn place(&self) -> i32 {
        self.world.borrow().places_steps()[0]
    }

    /// Goes towards the end until the limit input is high, and backs off. Returns the place.
    fn home(&self) -> i32 {
        let steps = (0..10_000).take_while(|_| !self.stalls()).map(|_| self.step(false)).count();
        assert!(steps < 10_000, "no stall");
        (0..OFF_STEPS).for_each(|_| self.step(true));
        self.place()
    }
}

/// X starts so many steps above its end.
fn config(above_steps: i32) -> Config {
    let board = Board::SkrPico;
    let mut config = Config { board, driver: board.driver(), keep_waves: false, ..Config::default() };
    config.diag[0] = true;
    config.settings.steps_per_mm[0] = STEPS_PER_MM;
    config.start_mm[0] = f64::from(END_STEPS + above_steps) / f64::from(STEPS_PER_MM);
    config
}

/// The places found by 100 homings on each of 16 machines, which differ in where full steps end, in steps from the end less
/// what was backed off: how far the field was ahead, negative.
fn places(load_noise: f64) -> Vec<BTreeSet<i32>> {
    let found = |phase| {
        let driven = Driven::new(&Config { load_noise, ..config(400 + phase) });
        let places = (0..100).map(|_| driven.home() - END_STEPS - OFF_STEPS).collect();
        assert_eq!(driven.world.borrow().record().losses, []);
        places
    };
    (0..MICROSTEPS).map(found).collect()
}

/// A stall is reported where a full step ends: there the load is above the threshold from two thirds of a full step ahead on.
/// Noise decides whether it is reported there or a full step later, on machines whose full steps end that far ahead.
#[test]
fn a_stall_is_reported_at_the_same_place_or_where_noise_hides_it_a_full_step_later() {
    // Of the reading alone, whose noise is a thirtieth of a full step, and of the load, from 0.52 to 0.76 of a full step.
    for (load_noise, scattering) in [(0.0, 0..=1), (0.2, 3..=4)] {
        let places = places(load_noise);
        let scattered = places.iter().filter(|places| places.len() > 1);
        assert!(scattering.contains(&scattered.clone().count()), "{places:?}");
        for places in scattered {
            assert_eq!(places.last().unwrap() - places.first().unwrap(), MICROSTEPS, "{places:?}");
        }
        let all: BTreeSet<_> = places.into_iter().flatten().collect();
        assert!(all.iter().all(|place| (-29..=-8).contains(place)), "{all:?}");
    }
}

#[test]
fn a_carriage_that_is_driven_on_loses_four_full_steps_at_a_time() {
    let driven = Driven::new(&config(10));
    driven.set(TCOOLTHRS::from(0));
    for _ in 0..10 + 10 * MICROSTEPS {
        // However slowly, it is one loss.
        driven.clock.advance_to(driven.clock.now_ns() + 10 * STEP_NS);
        driven.step(false);
    }
    let losses = driven.world.borrow().record().losses.clone();
    assert_eq!(losses.len(), 1, "{losses:?}");
    assert_eq!((losses[0].cause, losses[0].steps), (LossCause::EndStop, 8 * MICROSTEPS.unsigned_abs()));
    // The field is two full steps ahead, and comes back.
    (0..OFF_STEPS).for_each(|_| driven.step(true));
    assert_eq!(driven.place(), END_STEPS + OFF_STEPS - 2 * MICROSTEPS);
    assert_eq!(driven.world.borrow().drift_steps()[0], 8 * MICROSTEPS);
}

/// When DIAG falls after the motor was stopped by a stall, ns after the last step.
fn falls_after_ns(tcoolthrs: u32) -> u64 {
    let mut executor = Executor::new();
    let clock = executor.clock().clone();
    let config = Config { keep_waves: true, ..config(20) };
    let world = Rc::new(RefCell::new(World::new(clock.clone(), &config)));
    executor.spawn_at(Priority::World, "bounce", world::bounce(world.clone()));
    let driven = Driven::with(world.clone(), clock.clone());
    driven.set(TCOOLTHRS::from(tcoolthrs));
    executor.spawn("drive", async move {
        for due_ns in (0..).map(|step| 1_000_000 + step * STEP_NS).take_while(|_| !driven.stalls()) {
            clock.until(due_ns).await;
            driven.world.borrow_mut().drive(Wire::Step(Axis::X.into()), true);
            driven.world.borrow_mut().drive(Wire::Step(Axis::X.into()), false);
        }
    });
    executor.run_until_quiescent(Instant::from_secs(1)).unwrap();
    let world = world.borrow();
    let limit: Vec<_> = world.record().waves.iter().filter(|wave| wave.wire == Wire::Limit(Axis::X.into())).collect();
    let [rose, fell] = limit[..] else { panic!("{limit:?}") };
    assert!(rose.high && !fell.high);
    assert_eq!(rose.t_ns, world.record().edges.last().unwrap().t_ns);
    fell.t_ns - rose.t_ns
}

#[test]
fn diag_falls_when_the_motor_is_slower_than_tcoolthrs_or_stands() {
    // A step is of 16 1/256 steps, each of TCOOLTHRS clocks of 12 MHz at most.
    assert_eq!(falls_after_ns(300), 301 * 16 * 1_000 / 12 + 1);
    assert_eq!(falls_after_ns(0xF_FFFF), 20_000_000);
}

#[test]
fn the_limit_input_shows_diag_where_a_jumper_wires_it_and_else_the_switch() {
    let shown = |diag| {
        let mut config = config(1_250);
        config.diag[0] = diag;
        let driven = Driven::new(&config);
        driven.set(TCOOLTHRS::from(0));
        let mut shown = vec![driven.stalls()];
        (0..100).for_each(|_| driven.step(false));
        shown.push(driven.stalls());
        driven.world.borrow_mut().set_driver(Axis::X.into(), Some(DriverFault::Overheated));
        shown.push(driven.stalls());
        driven.world.borrow_mut().set_driver(Axis::X.into(), None);
        shown.push(driven.stalls());
        shown
    };
    assert_eq!(shown(true), [false, false, true, false], "an error of the driver");
    assert_eq!(shown(false), [true, false, false, false], "the switch, which is closed below 0");
}
