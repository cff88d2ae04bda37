//! The simulated world around the controller: wires, drivers, motors, carriages and switches, and a record of all
//! events.

mod belts;
mod drive_alarms;
mod inputs;
mod motor_world;
mod uart_drivers;

use std::cell::RefCell;
use std::rc::Rc;
use std::task::Waker;

use isostep_motion::{AXES, Axis, Event, GangedMotor, Machine, Motor as Moving};
use oorandom::Rand32;

use self::drive_alarms::DriveAlarms;
pub use self::inputs::bounce;
use self::inputs::{EmergencyStop, INPUTS, Input};
use self::motor_world::MotorWorld;
use self::uart_drivers::UartDrivers;
use crate::config::{Config, Gantry};
use crate::drive::{Load, MotorData};
use crate::drivers::{DriverFault, Tmc2209, Wire as DriverWires};
use crate::mechanics::{Mechanics, Wiring};
use crate::motor::Slip;
use crate::plant::SwitchFault;
use crate::plate::Plate;
pub use crate::record::{Edge, Loss, LossCause, Record, VfdFrame, Wave, Wire};
use crate::time::Clock;
use crate::tool::{ToolChange, ToolOutput};
use crate::vfd;
use crate::vfd::{OutsideVfd, Vfd, VfdFault};

/// Slips that follow each other within this time are one loss, ns.
const STALL_NS: u64 = 100_000_000;
/// No rotor swings for longer, ns.
const REST_NS: u64 = 1_000_000_000;

/// The index of the second motor.
const SECOND: usize = AXES;

/// The world; see the module. Pins, tasks and the simulation share it as [`Shared`].
pub struct World {
    clock: Clock,
    /// The first motors of the axes, then the second motor of one of them, if there is one.
    motors: Vec<MotorWorld>,
    gantry: Gantry,
    /// Limit switches in the order of the motors, then the others in the order of [`inputs::index`].
    inputs: [Input; INPUTS],
    limits_high_at_start: [bool; AXES],
    stop: EmergencyStop,
    drive_alarms: DriveAlarms,
    plate: Option<Plate>,
    /// The PWM duty and the other outputs of the tool, in the order of [`ToolOutput::ALL`].
    tool: [u16; ToolOutput::ALL.len()],
    random: Rand32,
    bouncer: Option<Waker>,
    record: Record,
    keep_record: bool,
    keep_waves: bool,
    steps: [u64; AXES],
    /// When the last edge was, ns since power-up.
    edge_ns: u64,
    /// The steps of each axis, by whichever motor, from power-up or since it was homed.
    counted_steps: [i32; AXES],
    mechanics: Mechanics,
    wiring: Wiring,
    /// The machine whose configuration the mechanics follow.
    machine: Option<Rc<Machine>>,
    uart_drivers: Option<UartDrivers>,
    vfd: Option<Vfd>,
    outside_vfd: Option<OutsideVfd>,
    motor: MotorData,
    loads: [Option<Load>; AXES],
    motion: Motion,
}

/// When the machine moved.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    /// The start of the first move, ns since power-up.
    first_ns: Option<u64>,
    /// The start of the last one.
    last_ns: u64,
    /// End of the plan of the last move that ended, s after the start of the first.
    lasted_s: f64,
}

/// The world of a simulation, shared.
pub type Shared = Rc<RefCell<World>>;

impl World {
    /// A world with carriages and switches as `config` places them, and drivers disabled.
    pub fn new(clock: Clock, config: &Config) -> Self {
        let machine_config = isostep_controller::config(&config.settings);
        let (mechanics, wiring) = (config.mechanics(&machine_config), Wiring::of(&machine_config));
        let motors = Axis::ALL.into_iter().map(Moving::first).chain(wiring.second.map(Moving::second));
        let motors: Vec<_> = motors.map(|motor| MotorWorld::new(motor, config, &mechanics, &wiring)).collect();
        let uart_drivers = UartDrivers::new(config);
        let mut inputs = inputs::all(wiring.second);
        for (index, motor) in motors.iter().enumerate() {
            let diag = uart_drivers.as_ref().and_then(|uart_drivers| uart_drivers.diag(index));
            inputs[index].high = diag.unwrap_or(motor.switch.is_closed() == wiring.switches_open);
        }
        let drive_alarms = DriveAlarms::new(config);
        for axis in Axis::ALL {
            inputs[inputs::index(Wire::DriveAlarm(axis))].high = drive_alarms.is_high(axis, wiring.second);
        }
        let random = Rand32::new(config.seed);
        let limits_high_at_start = std::array::from_fn(|axis| inputs[axis].high);
        let mut world = Self {
            clock,
            motors,
            gantry: config.gantry,
            inputs,
            limits_high_at_start,
            stop: EmergencyStop { contact: config.emergency_contact, is_pressed: false, is_cut: false },
            drive_alarms,
            plate: config.plate,
            tool: [0; ToolOutput::ALL.len()],
            random,
            bouncer: None,
            record: Record::default(),
            keep_record: config.keep_record,
            keep_waves: config.keep_record && config.keep_waves,
            steps: [0; AXES],
            edge_ns: 0,
            counted_steps: [0; AXES],
            mechanics,
            wiring,
            machine: None,
            uart_drivers,
            vfd: config.vfd.map(|kind| Vfd::new(kind).with_ramp(config.vfd_ramp_hz_s)),
            outside_vfd: None,
            motor: config.motor,
            loads: config.loads,
            motion: Motion::default(),
        };
        world.refresh_probe();
        world.set_hand_input(Wire::EmergencyStop, false);
        world
    }

    /// The axis that has a second motor.
    pub(crate) fn second_axis(&self) -> Option<Axis> {
        self.wiring.second
    }

    /// Makes the mechanics follow the configuration of `machine`, which is checked each time an axis begins to move.
    pub fn follow(&mut self, machine: Rc<Machine>) {
        self.machine = Some(machine);
    }

    /// Sets an output of the controller.
    pub fn drive(&mut self, wire: Wire, high: bool) {
        let t_ns = self.clock.now_ns();
        let violations = &mut self.record.violations;
        match wire {
            Wire::Step(motor) => {
                let Some(index) = motor_index(&self.wiring, motor) else { return };
                if self.motors[index].inputs.set_step(t_ns, high, violations) {
                    self.step(t_ns, index);
                }
            }
            Wire::Dir(motor) => {
                let Some(index) = motor_index(&self.wiring, motor) else { return };
                self.motors[index].inputs.set_dir(t_ns, high, violations);
            }
            Wire::Enable => {
                let is_on = high == self.wiring.enable_high;
                self.motors.iter_mut().for_each(|motor| motor.inputs.set_enabled(t_ns, is_on, violations));
                if !is_on {
                    self.spring_back(t_ns);
                }
                self.drive_alarms.enable(t_ns, is_on);
                self.refresh_drive_alarms();
            }
            _ => unreachable!("an input of the controller"),
        }
        self.note_wave(Wave { t_ns, wire, high });
    }

    /// Sets an output of the tool.
    pub(crate) fn drive_tool(&mut self, output: ToolOutput, duty: u16) {
        if let (Some(vfd), ToolOutput::Enable) = (&mut self.vfd, output) {
            vfd.set_enabled(self.clock.now_ns(), duty > 0);
        }
        if std::mem::replace(&mut self.tool[output as usize], duty) != duty && self.keep_record {
            self.record.tool.push(ToolChange { t_ns: self.clock.now_ns(), output, duty });
        }
    }

    /// The duties of the tool's outputs, of 65,535, in the order of [`ToolOutput::ALL`].
    pub fn tool(&self) -> [u16; ToolOutput::ALL.len()] {
        self.tool
    }

    fn note_wave(&mut self, wave: Wave) {
        if self.keep_waves {
            self.record.waves.push(wave);
        }
    }

    /// True if an input of the controller is high.
    pub fn is_high(&self, wire: Wire) -> bool {
        self.inputs[inputs::index(wire)].high
    }

    /// The levels of the limit inputs at power-up.
    pub fn limits_high_at_start(&self) -> [bool; AXES] {
        self.limits_high_at_start
    }

    /// The numbers of times that an input has risen and fallen.
    pub(crate) fn flanks(&self, wire: Wire) -> (u32, u32) {
        let input = &self.inputs[inputs::index(wire)];
        (input.rises, input.falls)
    }

    /// Wakes `waker` when an input changes.
    pub(crate) fn wake_on_change(&mut self, wire: Wire, waker: &Waker) {
        let wakers = &mut self.inputs[inputs::index(wire)].wakers;
        if !wakers.iter().any(|known| known.will_wake(waker)) {
            wakers.push(waker.clone());
        }
    }

    /// Presses or releases the emergency stop or a button, or sets the probe's contact by hand.
    pub fn set_hand_input(&mut self, wire: Wire, pressed: bool) {
        let high = match wire {
            Wire::EmergencyStop => {
                self.stop.is_pressed = pressed;
                self.stop.is_high()
            }
            Wire::Probe => pressed == self.wiring.probe_opens,
            _ => !pressed,
        };
        self.set_input(inputs::index(wire), high);
    }

    /// Cuts the wire of the emergency stop, or mends it.
    pub fn cut_emergency_stop(&mut self, is_cut: bool) {
        self.stop.is_cut = is_cut;
        self.set_input(inputs::index(Wire::EmergencyStop), self.stop.is_high());
    }

    /// Something begins to be wrong with a drive that closes its own loop, or is mended: it stays in alarm until it is reset.
    pub fn set_drive(&mut self, motor: Moving, is_wrong: bool) {
        if let Some(index) = motor_index(&self.wiring, motor) {
            self.drive_alarms.set(index, is_wrong);
            self.refresh_drive_alarms();
        }
    }

    /// Cuts the wire of an axis's alarm, or mends it; that of X, where one is for all.
    pub fn cut_drive_alarm(&mut self, axis: Axis, is_cut: bool) {
        self.drive_alarms.cut(axis, is_cut);
        self.refresh_drive_alarms();
    }

    fn refresh_drive_alarms(&mut self) {
        for axis in Axis::ALL {
            let high = self.drive_alarms.is_high(axis, self.wiring.second);
            self.set_input(inputs::index(Wire::DriveAlarm(axis)), high);
        }
    }

    /// Sets or removes the plate that the probe can touch.
    pub fn set_plate(&mut self, plate: Option<Plate>) {
        self.plate = plate;
        self.refresh_probe();
    }

    fn refresh_probe(&mut self) {
        let touches = self.plate.is_some_and(|plate| {
            let index = plate.axis as usize;
            plate.is_touched(self.motors[index].carriage.place_steps(), self.mechanics.steps_per_mm[index])
        });
        self.set_hand_input(Wire::Probe, touches);
    }

    /// Sets or clears a fault of the limit switch of a motor. A motor that is not there has none.
    pub fn set_switch(&mut self, motor: impl Into<Moving>, fault: SwitchFault) {
        if let Some(index) = motor_index(&self.wiring, motor.into()) {
            self.motors[index].switch.set_fault(fault);
            self.refresh_limit(index);
        }
    }

    /// Blocks a motor, so that it makes no step, or releases it.
    pub(crate) fn set_stalled(&mut self, motor: Moving, is_stalled: bool) {
        if let Some(index) = motor_index(&self.wiring, motor) {
            self.motors[index].is_stalled = is_stalled;
        }
    }

    /// Sets or mends what is wrong with a UART driver. One that is off or has switched its motor off makes no step.
    pub fn set_driver(&mut self, motor: Moving, fault: Option<DriverFault>) {
        if let (Some(index), Some(uart_drivers)) = (motor_index(&self.wiring, motor), &mut self.uart_drivers) {
            uart_drivers.wire[index].set_fault(fault);
        }
        self.refresh_diags();
    }

    /// True if a motor's driver, if it has a UART, has switched it off, or is switched off itself.
    pub fn is_driver_off(&self, motor: Moving) -> bool {
        let uart_drivers = motor_index(&self.wiring, motor).zip(self.uart_drivers.as_ref());
        uart_drivers.is_some_and(|(index, uart_drivers)| uart_drivers.wire[index].is_off())
    }

    /// The bytes that the board hears on the wire of its drivers when it sends this; nothing if they have no UART.
    pub fn exchange_with_drivers(&mut self, sent: &[u8]) -> Vec<u8> {
        let now_ns = self.clock.now_ns();
        let heard =
            self.uart_drivers.as_mut().map(|uart_drivers| uart_drivers.exchange(now_ns, sent)).unwrap_or_default();
        self.refresh_diags();
        heard
    }

    /// The VFD, as it is now.
    pub fn vfd(&mut self) -> Option<&mut Vfd> {
        let now_ns = self.clock.now_ns();
        self.vfd.iter_mut().for_each(|vfd| vfd.advance(now_ns));
        self.vfd.as_mut()
    }

    pub(crate) fn connect_vfd(&mut self, outside: OutsideVfd) {
        self.outside_vfd = Some(outside);
    }

    /// What is replied to a frame, and after how many ns, if anything is.
    pub(crate) fn exchange_with_vfd(&mut self, sent: &[u8]) -> Option<(Vec<u8>, u64)> {
        if let Some(outside) = &mut self.outside_vfd {
            return Some((outside(sent), vfd::ANSWERS_NS)).filter(|(reply, _)| !reply.is_empty());
        }
        let now_ns = self.clock.now_ns();
        self.vfd()?.hear(now_ns, sent)
    }

    /// Notes a frame on the wire to the VFD.
    pub(crate) fn note_vfd_frame(&mut self, frame: VfdFrame) {
        if self.keep_record {
            self.record.vfd.push(frame);
        }
    }

    /// Sets or mends what is wrong with the VFD.
    pub fn set_vfd(&mut self, fault: Option<VfdFault>) {
        self.vfd().into_iter().for_each(|vfd| vfd.set_fault(fault));
    }

    /// The UART drivers, as they are set.
    pub fn drivers(&self) -> Option<&DriverWires> {
        self.uart_drivers.as_ref().map(|uart_drivers| &uart_drivers.wire)
    }

    /// The lead of the second motor on the first, mm away from their switches, by how the frame is when square;
    /// `None` without a second motor.
    pub fn skew_mm(&self) -> Option<f64> {
        let second = self.motors.get(SECOND)?;
        let ahead_steps = second.carriage.place_steps() - self.motors[second.axis as usize].carriage.place_steps();
        Some(f64::from(ahead_steps) / self.mechanics.steps_per_mm[second.axis as usize] - self.gantry.square_mm)
    }

    /// Without motors that hold it, the frame takes the shape that it has at rest.
    fn spring_back(&mut self, t_ns: u64) {
        if let Some(skew_mm) = self.skew_mm() {
            let axis = self.motors[SECOND].axis;
            let steps = (self.gantry.skew_mm - skew_mm) * self.mechanics.steps_per_mm[axis as usize];
            self.motors[SECOND].carriage.shift(steps.round() as i32);
            self.carriage_moved(t_ns, SECOND);
        }
    }

    /// True if a step of a motor would skew a frame further that is so skewed that it binds. Two motors that move together
    /// do so one after the other, which is a step of skew.
    fn binds(&self, index: usize, direction: i32) -> bool {
        let Some(skew_mm) = self.skew_mm().filter(|_| self.motors[index].axis == self.motors[SECOND].axis) else {
            return false;
        };
        let step_mm = 1.0 / self.mechanics.steps_per_mm[self.motors[index].axis as usize];
        let ahead = f64::from(direction * self.motors[index].away) * if index == SECOND { 1.0 } else { -1.0 };
        skew_mm * ahead > 0.0 && skew_mm.abs() >= self.gantry.binds_mm + step_mm
    }

    /// Notes an event of the coordinator.
    pub(crate) fn on_event(&mut self, event: Event) {
        if self.keep_record {
            self.note_event(event);
        }
        match event {
            Event::Homed { axis } => {
                if self.is_crossed(axis as usize) {
                    return self.zero_belt(axis);
                }
                self.counted_steps[axis as usize] = 0;
                for motor in self.motors.iter_mut().filter(|motor| motor.axis == axis) {
                    motor.counted_steps = 0;
                    motor.zero_steps = motor.carriage.place_steps();
                }
            }
            Event::Run { start, .. } => self.motion.begin(crate::time::ns(start)),
            Event::RunEnd { plan_s, .. } => self.motion.end(plan_s),
            _ => {}
        }
    }

    /// Notes the configuration that the next run is planned with.
    pub(crate) fn on_config(&mut self, config: isostep_motion::Config) {
        if self.keep_record {
            self.record.moves.plan_by(config);
        }
    }

    fn note_event(&mut self, event: Event) {
        let t_ns = self.clock.now_ns();
        self.record.moves.take(t_ns, self.edge_ns, event);
        let is_other = matches!(event, Event::State(_) | Event::Homing { .. } | Event::Homed { .. });
        if is_other {
            self.record.events.push((t_ns, event));
        }
    }

    /// Time from the start of the first move to the end of the last one's plan, s.
    pub fn motion_s(&self) -> f64 {
        self.motion.lasted_s
    }

    /// True position of each carriage, in steps from where its switch closes.
    pub fn places_steps(&self) -> [i32; AXES] {
        std::array::from_fn(|axis| self.motors[axis].carriage.place_steps())
    }

    /// The same of the second motor, if there is one.
    pub fn second_place_steps(&self) -> Option<i32> {
        self.motors.get(SECOND).map(|motor| motor.carriage.place_steps())
    }

    /// Position of each carriage when its switch last closed, in steps from the switch's nominal position.
    pub(crate) fn closed_at_steps(&self) -> [i32; AXES] {
        std::array::from_fn(|axis| self.motors[axis].switch.closed_at_steps())
    }

    /// The steps counted per axis, from power-up or since it was homed.
    pub fn counted_steps(&self) -> [i32; AXES] {
        self.counted_steps
    }

    /// Distance of each carriage from its position by the count.
    pub fn drift_steps(&self) -> [i32; AXES] {
        let half_up = |half_steps: i32| (half_steps + half_steps.signum()) / 2;
        std::array::from_fn(|axis| match self.is_crossed(axis) {
            true => half_up(self.belt_drift_half_steps(axis)),
            false => self.motors[axis].drift_steps(),
        })
    }

    /// The same of the second motor, if there is one.
    pub(crate) fn second_drift_steps(&self) -> Option<i32> {
        self.motors.get(SECOND).map(MotorWorld::drift_steps)
    }

    /// The distance of the field of each first motor beyond an end stop that blocks the carriage.
    pub(crate) fn ahead_steps(&self) -> [i32; AXES] {
        std::array::from_fn(|axis| self.motors[axis].carriage.ahead_steps())
    }

    /// The steps made per axis in both directions, since power-up.
    pub fn steps(&self) -> [u64; AXES] {
        self.steps
    }

    /// Everything recorded so far.
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// Takes the record; the world continues with an empty one.
    pub(crate) fn take_record(&mut self) -> Record {
        std::mem::take(&mut self.record)
    }

    /// Takes what nothing can change any more; the world continues with the rest. Without edges, what has begun has.
    pub(crate) fn take_settled(&mut self, only_time: bool, tolerance_ns: f64) -> Record {
        let edge_ns = if only_time { self.clock.now_ns() } else { self.edge_ns };
        self.record.take_settled(edge_ns, tolerance_ns)
    }

    /// Follows the rotors up to now.
    pub fn settle(&mut self) {
        self.follow_rotors(self.clock.now_ns());
    }

    /// Follows the rotors until they stand still, so that the overshoot of an abrupt stop is recorded. No edge may come
    /// after it.
    pub(crate) fn come_to_rest(&mut self) {
        self.follow_rotors(self.clock.now_ns() + REST_NS);
    }

    fn follow_rotors(&mut self, t_ns: u64) {
        for index in 0..self.motors.len() {
            self.follow_rotor(t_ns, index);
        }
        self.refit();
    }

    /// Makes the mechanics follow the machine's configuration, which changes only while nothing moves.
    fn refit(&mut self) {
        let Some(machine) = &self.machine else { return };
        let mechanics = Mechanics::of(&machine.config(), self.motor, self.loads);
        if mechanics == self.mechanics {
            return;
        }
        for motor in &mut self.motors {
            let index = motor.axis as usize;
            let scale = mechanics.steps_per_mm[index] / self.mechanics.steps_per_mm[index];
            motor.refit(scale, mechanics.drives[index], mechanics.end_stops_steps[index], mechanics.turn_steps[index]);
        }
        self.mechanics = mechanics;
    }

    fn step(&mut self, t_ns: u64, index: usize) {
        let axis = self.motors[index].axis as usize;
        let dir_high = if index == SECOND { self.wiring.second_dir_high } else { self.wiring.dir_high[axis] };
        let direction = self.motors[index].inputs.direction() * dir_high;
        self.follow_rotor(t_ns, index);
        if self.motors[index].motor.has_paused(t_ns) {
            self.refit();
        }
        self.count(t_ns, index, direction);
        let (is_crossed, binds) = (self.is_crossed(index), self.binds(index, direction));
        let driver = self.uart_drivers.as_ref().map(|uart_drivers| &uart_drivers.wire[index]);
        let is_off = driver.is_some_and(Tmc2209::is_off) || self.drive_alarms.is_in_alarm(index);
        let microsteps = driver.map(|driver| driver.microsteps().into());
        let this = &mut self.motors[index];
        let (from_steps, hindrance) = (this.carriage.place_steps(), this.hindrance(binds, is_off));
        let lost = match is_crossed {
            true => self.turn_belt(t_ns, index, direction, hindrance),
            false => this.turn(t_ns, direction, hindrance, microsteps),
        };
        let has_moved = self.motors[index].carriage.place_steps() != from_steps;
        match lost {
            Some((cause, steps)) => self.lose(t_ns, index, cause, steps),
            None => self.motors[index].losing = false,
        }
        if has_moved && !is_crossed {
            self.carriage_moved(t_ns, index);
        }
        // The belts hold a motor at an end stop at once.
        let held = lost.filter(|_| is_crossed).map(|_| LossCause::Stalled);
        self.drivers_step(t_ns, index, direction, hindrance.or(held));
    }

    /// Counts a step of a motor. It is one of its axis, unless the first motor has made the same.
    fn count(&mut self, t_ns: u64, index: usize, direction: i32) {
        let axis = self.motors[index].axis as usize;
        let is_same = index == SECOND && self.motors[axis].stepped_ns == Some(t_ns);
        let this = &mut self.motors[index];
        this.counted_steps += direction;
        this.stepped_ns = Some(t_ns);
        if is_same {
            return;
        }
        self.counted_steps[axis] += direction;
        self.steps[axis] += 1;
        self.edge_ns = t_ns;
        if self.keep_record {
            self.record.edges.push(Edge { t_ns, axis, direction, position_steps: self.counted_steps[axis] });
        }
    }

    /// Follows the rotor of a motor up to now.
    fn follow_rotor(&mut self, t_ns: u64, index: usize) {
        let this = &mut self.motors[index];
        let Some(Slip { t_ns: slipped_ns, steps, asked_steps_s, has_overshot }) = this.motor.advance(t_ns) else {
            return;
        };
        this.losing = slipped_ns.saturating_sub(this.slipped_ns) <= STALL_NS;
        this.slipped_ns = t_ns;
        if self.is_crossed(index) {
            self.shift_belt(t_ns, index, steps);
        } else {
            let this = &mut self.motors[index];
            this.carriage.shift(this.away * steps);
        }
        let cause = if has_overshot {
            LossCause::Overshoot { from_steps_s: asked_steps_s }
        } else {
            LossCause::PullOut { asked_steps_s }
        };
        self.lose(slipped_ns, index, cause, steps.unsigned_abs());
        self.carriage_moved(t_ns, index);
    }

    /// Records lost steps. Consecutive ones of an axis become one entry.
    fn lose(&mut self, t_ns: u64, index: usize, cause: LossCause, steps: u32) {
        if !matches!(cause, LossCause::Disabled | LossCause::DriverOff) {
            self.drive_alarms.lose(index);
            self.refresh_drive_alarms();
        }
        let axis = self.motors[index].axis as usize;
        let continues = std::mem::replace(&mut self.motors[index].losing, true);
        let last = self.record.losses.iter_mut().rfind(|loss| loss.axis == axis);
        match last {
            Some(loss) if continues && std::mem::discriminant(&loss.cause) == std::mem::discriminant(&cause) => {
                loss.steps += steps;
            }
            _ => self.record.losses.push(Loss { t_ns, axis, cause, steps }),
        }
    }

    fn carriage_moved(&mut self, t_ns: u64, index: usize) {
        let this = &mut self.motors[index];
        this.switch.follow(this.carriage.place_steps(), t_ns, &mut self.random);
        if this.switch.next_flip_ns().is_some() {
            self.bouncer.take().into_iter().for_each(Waker::wake);
        }
        self.refresh_limit(index);
        if self.plate.is_some_and(|plate| plate.axis as usize == index) {
            self.refresh_probe();
        }
    }

    /// A limit input shows its switch, or a driver's DIAG if that is wired to it.
    fn refresh_limit(&mut self, index: usize) {
        let diag = self.uart_drivers.as_ref().and_then(|uart_drivers| uart_drivers.diag(index));
        let is_closed = self.motors[index].switch.is_closed();
        self.set_input(index, diag.unwrap_or(is_closed == self.wiring.switches_open));
    }

    fn set_input(&mut self, index: usize, high: bool) {
        let input = &mut self.inputs[index];
        if input.high == high {
            return;
        }
        input.high = high;
        *if high { &mut input.rises } else { &mut input.falls } += 1;
        input.wakers.drain(..).for_each(Waker::wake);
        let wire = input.wire;
        self.note_wave(Wave { t_ns: self.clock.now_ns(), wire, high });
    }

    fn next_flip_ns(&self) -> Option<u64> {
        let flips_ns = self.motors.iter().filter_map(|motor| motor.switch.next_flip_ns());
        flips_ns.chain(self.next_stall_end_ns()).min()
    }

    fn flip(&mut self) {
        let now_ns = self.clock.now_ns();
        self.uart_drivers.iter_mut().for_each(|uart_drivers| uart_drivers.follow(now_ns));
        for index in 0..self.motors.len() {
            self.motors[index].switch.settle(now_ns);
            self.refresh_limit(index);
        }
    }
}

impl Motion {
    fn begin(&mut self, start_ns: u64) {
        self.first_ns.get_or_insert(start_ns);
        self.last_ns = start_ns;
    }

    fn end(&mut self, plan_s: f64) {
        let first_ns = self.first_ns.unwrap_or(self.last_ns);
        self.lasted_s = (self.last_ns - first_ns) as f64 * 1e-9 + plan_s;
    }
}

/// The index of a motor, if it is there.
fn motor_index(wiring: &Wiring, motor: Moving) -> Option<usize> {
    match motor.ganged {
        GangedMotor::First => Some(motor.axis as usize),
        GangedMotor::Second => (wiring.second == Some(motor.axis)).then_some(SECOND),
    }
}
