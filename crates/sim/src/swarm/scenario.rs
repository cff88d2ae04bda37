//! Makes a scenario from a seed: a machine, and what is done to it.

use std::fmt;

use isostep_console::{SETTING_TABLE, Settings};
use isostep_motion::{AXES, Axis, Contact, Motor};
use oorandom::Rand64;

use super::Random;
use super::drivers::{self, Failing};
use super::drives;
use super::lines::Lines;
use super::vfd;
use crate::config::{Config, Gantry, Port};
use crate::faults::Trouble;
use crate::plant::SwitchFault;
use crate::plate::Plate;
use crate::sim::Stimulus;
use crate::vfd::VfdFault;

/// The axis along which it probes: Z, if there is one.
pub(super) const PROBED: Axis = Axis::ALL[if AXES > 2 { 2 } else { AXES - 1 }];
/// Number of acts of a scenario.
const ACTS: std::ops::Range<u64> = 8..60;

/// An act on the machine or its surroundings.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Sends a line on the console with this index.
    Line(usize, String),
    /// Sends bytes in one packet: real-time bytes, or a line damaged by a bad link.
    Bytes(usize, Vec<u8>),
    /// Resets the machine and checks that everything sent before is forgotten.
    Reset {
        /// The console with this index sends the reset byte.
        by: usize,
        /// The bytes that the other sends before that.
        early: &'static [u8],
        /// The bytes that it sends after that, if it has not been told of the reset by then.
        late: &'static [u8],
        /// The time from one to the next, us.
        apart_us: u64,
    },
    /// Lets time pass, us.
    Wait(u64),
    /// Lets time pass until the machine is at rest, at most some seconds.
    Rest,
    /// Applies a fault for this time, us.
    Fault(Trouble, u64),
    /// Drivers fail, in this order.
    Drivers(Vec<Failing>),
    /// The drive of this motor is in alarm, for which there is a reason as long as this, us.
    Drive(Motor, u64),
    /// This is wrong with the VFD, or with its wire, for so long, us.
    Vfd(VfdFault, u64),
    /// Applies a stimulus after this many more critical sections, if tasks are interrupted.
    Between(u64, Stimulus),
    /// Opens the first console, as a host does.
    Open,
    /// Cuts the power: during an operation of the flash, if this many more operations begin within some time.
    PowerCut(u64),
}

impl Act {
    /// True if it is a fault and not normal use.
    pub(super) fn is_fault(&self) -> bool {
        match self {
            Self::Fault(..)
            | Self::Drivers(_)
            | Self::Drive(..)
            | Self::Vfd(..)
            | Self::Between(..)
            | Self::Reset { .. }
            | Self::Open
            | Self::PowerCut(_) => true,
            Self::Bytes(_, bytes) => bytes.contains(&0x18) || bytes.ends_with(b"\n"),
            Self::Line(..) | Self::Wait(_) | Self::Rest => false,
        }
    }
}

impl fmt::Display for Act {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(console, line) => write!(f, "console {console} sends {line}"),
            Self::Bytes(console, bytes) => write!(f, "console {console} sends bytes {}", bytes.escape_ascii()),
            Self::Reset { by, early, late, apart_us } => {
                let (early, late) = (early.escape_ascii(), late.escape_ascii());
                write!(
                    f,
                    "console {by} resets; {apart_us} us before and after that the other sends `{early}`, `{late}`"
                )
            }
            Self::Wait(us) => write!(f, "wait {us} us"),
            Self::Rest => write!(f, "wait until it rests"),
            Self::Fault(trouble, us) => write!(f, "{trouble} for {us} us"),
            Self::Drivers(failings) => {
                let words = failings.iter().map(ToString::to_string).collect::<Vec<_>>();
                f.write_str(&words.join(", "))
            }
            Self::Drive(motor, us) => write!(f, "{} for {us} us", Trouble::Alarm(*motor)),
            Self::Vfd(fault, us) => write!(f, "{} for {us} us", Trouble::Vfd(*fault)),
            Self::Between(sections, stimulus) => write!(f, "after {sections} critical sections {stimulus:?}"),
            Self::Open => write!(f, "a host opens console 0"),
            Self::PowerCut(operations) => {
                write!(f, "the power goes, after {operations} operations of the flash at most")
            }
        }
    }
}

/// A machine and what is done to it.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The machine.
    pub config: Config,
    /// The acts, in order.
    pub acts: Vec<Act>,
}

impl Scenario {
    /// The scenario of this seed.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let mut random = Random(Rand64::new(seed.into()));
        let config = random.config(seed);
        let acts = random.acts(&config);
        let scenario = drivers::with_uart_drivers(seed, Self { config, acts });
        vfd::with_vfd(seed, drives::with_drives(seed, scenario))
    }

    /// The machine in one line: the settings that differ from the default machine's, as `$n=v`.
    #[must_use]
    pub fn machine(&self) -> String {
        let Config {
            settings,
            board,
            port,
            baud,
            second_console,
            section_max_ns,
            bounce_us,
            emergency_contact,
            vfd,
            vfd_ramp_hz_s,
            ..
        } = &self.config;
        let mut text = format!("machine: {board}, {port} port, switches bounce {bounce_us} us");
        text += match emergency_contact {
            Contact::NormallyOpen => "",
            Contact::NormallyClosed => ", the emergency stop opens",
        };
        text += if self.config.closed_loop { ", drives of a closed loop" } else { "" };
        text += if self.config.one_alarm_wire { ", one alarm wire" } else { "" };
        text += &vfd.map_or(String::new(), |vfd| format!(", a VFD {vfd} of {vfd_ramp_hz_s} Hz/s"));
        text += if *second_console { ", two consoles" } else { ", one console" };
        text += &baud.map_or(String::new(), |baud| format!(" at {baud} baud"));
        text += &section_max_ns
            .map_or(String::new(), |ns| format!(", tasks interrupt each other (up to {ns} ns a section)"));
        for number in SETTING_TABLE.iter().flat_map(|setting| setting.numbers()) {
            let (value, default) = (settings.get(number), Settings::DEFAULT.get(number));
            if let Some(value) = value.filter(|_| value != default) {
                text += &format!(" ${number}={value}");
            }
        }
        text
    }

    /// The same scenario with only these acts, by index.
    #[must_use]
    pub fn keeping(&self, kept: &[usize]) -> Self {
        let acts = kept.iter().filter_map(|&index| self.acts.get(index).cloned()).collect();
        Self { config: self.config.clone(), acts }
    }
}

/// Parts of a scenario.
impl Random {
    pub(super) fn axis(&mut self) -> Axis {
        self.of(&Axis::ALL)
    }

    /// A motor; of the second ones all but one at most are not there.
    pub(super) fn motor(&mut self) -> Motor {
        let axis = self.axis();
        if self.one_in(4) { Motor::second(axis) } else { Motor::first(axis) }
    }

    fn config(&mut self, seed: u64) -> Config {
        let port = self.of(&[Port::Pio, Port::Pio, Port::Timer]);
        let settings = self.settings(port);
        let start_mm =
            std::array::from_fn(|axis| f64::from(settings.travel_mm[axis]) * (0.3 + 0.4 * self.0.rand_float()));
        let plate_mm = f64::from(settings.travel_mm[PROBED as usize]) * 0.2;
        let gantry = self.gantry();
        Config {
            settings,
            start_mm,
            gantry,
            port,
            seed,
            emergency_contact: if seed.is_multiple_of(2) { Contact::NormallyOpen } else { Contact::NormallyClosed },
            plate: self.one_in(2).then_some(Plate { axis: PROBED, place_mm: plate_mm, is_below: true }),
            bounce_us: self.of(&[0, 500, 1_000]),
            baud: self.of(&[None, None, Some(115_200)]),
            second_console: self.one_in(2),
            section_max_ns: self.of(&[None, Some(0), Some(2_000), Some(20_000)]),
            keep_waves: false,
            ..Config::default()
        }
    }

    /// A gantry that is out of square by less than what the skew limit allows.
    fn gantry(&mut self) -> Gantry {
        let skew_mm = self.of(&[0.0, 0.0, 1.3, -1.3, 3.0, -3.0]);
        Gantry { skew_mm, square_mm: self.of(&[0.0, 0.5, -1.5]), binds_mm: 12.0 }
    }

    /// Settings of a machine small enough to be homed quickly.
    fn settings(&mut self, port: Port) -> Settings {
        let fastest_mm_s = if port == Port::Pio { 200.0 } else { 60.0 };
        let mut settings = Settings {
            junction_deviation_mm: self.of(&[0.0, 0.01, 0.05]),
            soft_limits: !self.one_in(4),
            hard_limits: !self.one_in(4),
            homing_direction_mask: self.below(1 << AXES) as u16,
            homing_latch_mm_min: 120.0,
            homing_seek_mm_min: 1_200.0,
            homing_pull_off_mm: self.of(&[0.5, 1.0, 2.0]),
            direction_invert_mask: self.below(1 << AXES) as u16,
            limit_invert: self.one_in(4),
            enable_invert: self.one_in(4),
            idle_delay_ms: self.of(&[255, 255, 0, 25]),
            laser_mode: self.one_in(3),
            hold_input_is_door: self.one_in(3),
            spin_up_s: self.of(&[0.0, 0.0, 0.1]),
            interval_thirds: self.one_in(4),
            speed_profile: self.of(&[0, 0, 0, 1, 2, 3, 4, 5, 6]),
            report_mask: self.of(&[1, 3]),
            second_motor_axis: self.of(&[0, 0, 1, 2, 3]).min(AXES as u16),
            second_invert_mask: self.below(1 << AXES) as u16,
            ..Settings::DEFAULT
        };
        for axis in 0..AXES {
            settings.steps_per_mm[axis] = self.of(&[50.0, 80.0, 160.0]);
            settings.travel_mm[axis] = self.of(&[12.0, 20.0, 40.0]);
            settings.max_rate_mm_min[axis] = (self.between(10.0, fastest_mm_s) * 60.0).round() as f32;
            settings.accel_mm_s2[axis] = self.between(50.0, 2_000.0).round() as f32;
            settings.decel_or_0_mm_s2[axis] = self.of(&[0.0, 0.0, 300.0]);
            settings.jerk_or_0_mm_s3[axis] = self.of(&[0.0, 2_000.0, 50_000.0]);
            settings.start_rate_mm_min[axis] = self.of(&[0.0, 60.0]);
            settings.square_offset_mm[axis] = self.of(&[0.0, 0.5, -1.5]);
        }
        // The machines with the largest deviation go round corners by blends, as far as their speed profile has any.
        if settings.junction_deviation_mm == 0.05 {
            settings.blend_deviation_mm = 0.05;
            (settings.interval_thirds, settings.start_rate_mm_min) = (false, [0.0; AXES]);
            settings.speed_profile = if settings.speed_profile < 3 { 0 } else { settings.speed_profile };
        }
        if settings.speed_profile == 0 && self.one_in(2) {
            for axis in 0..AXES {
                settings.shaper_kind[axis] = self.below(6) as u16;
                settings.shaper_hz[axis] = self.between(10.0, 500.0).round() as f32;
                settings.shaper_damping_ratio[axis] = self.of(&[0.0, 0.05, 0.2, 0.5]);
            }
        }
        if settings.speed_profile >= 3 {
            settings.start_rate_mm_min = [60.0; AXES];
        }
        if self.one_in(4) && settings.second_motor().is_none_or(|axis| axis > 1) {
            (settings.kinematics, settings.steps_per_mm[1]) = (1, settings.steps_per_mm[0]);
        }
        settings
    }

    fn acts(&mut self, config: &Config) -> Vec<Act> {
        let mut lines = Lines::new(&config.settings);
        let mut acts = Vec::new();
        if !self.one_in(5) {
            acts.push(Act::Line(0, "$H".to_owned()));
            if !self.one_in(4) {
                acts.push(Act::Rest);
                lines.is_homed = true;
            }
        }
        for _ in 0..self.0.rand_range(ACTS) {
            self.act(config, &mut lines, &mut acts);
        }
        acts
    }

    fn act(&mut self, config: &Config, lines: &mut Lines, acts: &mut Vec<Act>) {
        let console = usize::from(config.second_console && self.one_in(3));
        match self.below(33) {
            0..14 => acts.push(Act::Line(console, lines.next(self))),
            14..19 => acts.push(Act::Wait(self.between(1.0, 2e6) as u64)),
            19 => acts.push(Act::Rest),
            20..25 => acts.push(Act::Bytes(console, self.real_time())),
            25 => acts.push(Act::Bytes(console, self.spoilt(lines))),
            26..29 => acts.push(self.fault()),
            29 if config.section_max_ns.is_some() => acts.push(self.stimulus()),
            30 if self.one_in(3) => acts.push(Act::Open),
            31 if self.one_in(3) => acts.push(Act::PowerCut(self.below(6))),
            32 => self.reset(config, lines, acts),
            _ => acts.push(Act::Bytes(console, b"~".to_vec())),
        }
    }

    /// A line that waits, mostly behind a move; then a reset, mostly by the other console.
    fn reset(&mut self, config: &Config, lines: &mut Lines, acts: &mut Vec<Act>) {
        let consoles = 1 + u64::from(config.second_console);
        let waiting = self.below(consoles) as usize;
        if !self.one_in(3) {
            // Otherwise most lines would be refused, in an alarm or behind homing.
            acts.extend([Act::Rest, Act::Line(waiting, "$X".to_owned())]);
        }
        for _ in 0..self.below(4) {
            acts.push(Act::Line(self.below(consoles) as usize, lines.movement(self)));
        }
        let line =
            self.of(&["G4 P0.3", "M0", "M6 T1", "M3 S500", "M8", "G10 L20 P1 X0", "G38.3 Z0 F300", "$C", "$RST=#"]);
        acts.push(Act::Line(waiting, line.to_owned()));
        if self.one_in(2) {
            acts.push(Act::Line(waiting, lines.next(self)));
        }
        acts.push(Act::Wait(self.between(1.0, 3e5) as u64));
        let by = if self.one_in(4) { waiting } else { consoles as usize - 1 - waiting };
        let early = self.of::<&[u8]>(&[b"", b"G91 G0 X", b"G91 G0 Y1\nM"]);
        let late = self.of::<&[u8]>(&[b"", b"8\n", b"1\nG91 G0 X1\nM0\nX", b"1", b"6 T2\nG4 P0.1\n"]);
        acts.push(Act::Reset { by, early, late, apart_us: self.between(1.0, 1_000.0) as u64 });
        // A reset while homing locks the machine.
        acts.push(Act::Line(by, "$X".to_owned()));
    }

    /// Real-time bytes in any order, some of them in one packet.
    fn real_time(&mut self) -> Vec<u8> {
        let common = b"!!~~~??\x18\x85\x84\x90\x91\x92\x93\x94\x95\x96\x97\x99\x9a\x9b\x9e\xa0\xa1";
        let count = self.of(&[1, 1, 1, 2, 3]);
        (0..count).map(|_| self.of(common)).collect()
    }

    /// A line of which a link has dropped, doubled or changed bytes.
    fn spoilt(&mut self, lines: &mut Lines) -> Vec<u8> {
        let damage = self.below(3);
        let mut spoilt = Vec::new();
        for byte in lines.next(self).bytes() {
            let hit = self.one_in(5);
            match damage {
                0 if hit => {}
                1 if hit => spoilt.extend([byte, byte]),
                2 if hit => spoilt.push(byte ^ 1 << self.below(8)),
                _ => spoilt.push(byte),
            }
        }
        spoilt.push(b'\n');
        spoilt
    }

    fn fault(&mut self) -> Act {
        let trouble = match self.below(20) {
            0..3 => Trouble::EmergencyStop,
            3 => Trouble::BrokenEmergencyStop,
            4..7 => Trouble::Limit(self.motor()),
            7 => Trouble::Broken(self.motor()),
            8..10 => Trouble::Chatter(self.motor()),
            10..13 => Trouble::Hold,
            13 => Trouble::Start,
            14 => Trouble::Probe,
            15 => Trouble::Stall(self.motor()),
            16 => Trouble::Starve,
            _ => Trouble::Deaf,
        };
        let longest_us = if trouble == Trouble::Starve { 50_000.0 } else { 500_000.0 };
        Act::Fault(trouble, self.between(10.0, longest_us) as u64)
    }

    fn stimulus(&mut self) -> Act {
        let stimulus = match self.below(6) {
            0 => Stimulus::EmergencyStop,
            1 => Stimulus::Switch(self.axis(), SwitchFault::StuckClosed),
            _ => Stimulus::Bytes(self.real_time()),
        };
        Act::Between(self.between(1.0, 3_000.0) as u64, stimulus)
    }
}
