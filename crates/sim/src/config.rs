//! The configuration of a simulation: the machine, its faults, and how its console is used.

use std::fmt;

use embassy_time::Duration;
use isostep_console::Settings;
use isostep_controller::{DriverHardware, least_times};
use isostep_motion::{AXES, Axis, Contact, DriverTiming, LeastTimes};
use isostep_profile::fit_error_max_ticks;

use crate::drive::{Load, MotorData};
use crate::faults::Fault;
use crate::mechanics::Mechanics;
use crate::plant::SwitchFault;
use crate::plate::Plate;
use crate::springs::Springs;
use crate::vfd::{RAMP_HZ_S, VfdKind};

/// Clock of an RP2040.
pub(crate) const PIO_TICK_HZ: u32 = 125_000_000;

/// The board that the machine is like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Board {
    /// A Raspberry Pi Pico with bare drivers.
    #[default]
    Pico,
    /// A BIGTREETECH SKR Pico: four TMC2209 on a UART, see [`drivers`](crate::drivers).
    SkrPico,
}

impl Board {
    /// Both boards.
    pub const ALL: [Self; 2] = [Self::Pico, Self::SkrPico];
    /// The first axes, whose drivers' DIAG an SKR Pico's jumpers can lead to a limit input. That of the fourth driver would be on
    /// the emergency stop's.
    pub const JUMPERS: usize = if AXES < 3 { AXES } else { 3 };

    /// The timing of its drivers, if nothing else is said.
    pub fn driver(self) -> DriverTiming {
        match self {
            Self::Pico => DriverTiming::DRV8825,
            Self::SkrPico => DriverTiming::TMC2209,
        }
    }

    /// The UART drivers.
    pub(crate) fn uart_drivers(self) -> Option<DriverHardware> {
        (self == Self::SkrPico).then_some(DriverHardware { addresses: [0, 2, 1, 3], sense_milliohms: 110 })
    }
}

impl fmt::Display for Board {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pico => "pico",
            Self::SkrPico => "skr-pico",
        })
    }
}

/// The step port that drives the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Port {
    /// [`SimPort`](crate::port::SimPort), which stands for the firmware's default, `PioPort`: ticks of 8 ns.
    #[default]
    Pio,
    /// [`TimerPort`](isostep_motion::TimerPort): ticks of 1 us.
    Timer,
}

impl Port {
    /// Both ports.
    pub const ALL: [Self; 2] = [Self::Pio, Self::Timer];

    fn tick_hz(self) -> u32 {
        match self {
            Self::Pio => PIO_TICK_HZ,
            Self::Timer => embassy_time::TICK_HZ as u32,
        }
    }

    /// Length of a tick, to which instants are rounded, ns.
    pub fn tick_ns(self) -> f64 {
        1e9 / f64::from(self.tick_hz())
    }

    /// The largest distance of a step from its closed-form instant, ns: half a tick plus the error of a segment.
    pub fn tolerance_ns(self) -> f64 {
        (0.5 + fit_error_max_ticks(self.tick_hz())) * self.tick_ns()
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Pio => "pio",
            Self::Timer => "timer",
        })
    }
}

/// The way in which a program is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Streaming {
    /// One line at a time, each after the reply to the previous one.
    SendAndWait,
    /// As most senders do: lines are sent ahead while the bytes without a reply stay within this many.
    CharacterCounting {
        /// Size of the controller's receive buffer, bytes.
        window_bytes: usize,
    },
}

impl Streaming {
    /// Character counting over Grbl's receive buffer of 128 bytes.
    pub const GRBL: Self = Self::CharacterCounting { window_bytes: 128 };
}

/// The frame between the two motors of an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gantry {
    /// The lead of the second motor on the first while no motor holds the frame, mm away from the switches.
    pub skew_mm: f64,
    /// The distance by which the second motor stands farther from its switch than the first when the frame is square, mm: what
    /// a user has to find out, and to set as the offset.
    pub square_mm: f64,
    /// From this skew on the frame binds, mm: no motor skews it any more.
    pub binds_mm: f64,
}

impl Gantry {
    /// A frame that is square at rest, and whose switches are.
    pub const SQUARE: Self = Self { skew_mm: 0.0, square_mm: 0.0, binds_mm: 25.0 };
}

/// A simulated machine and how it is used. Equal configurations and programs give identical runs, to the byte.
#[derive(Clone, Debug)]
pub struct Config {
    /// The controller's settings at power-up. The machine's mechanics follow them, also when a program changes them.
    pub settings: Settings,
    /// The file that the settings come from, for [`replay`](Self::replay): its name and the settings in it.
    pub settings_file: Option<(String, Settings)>,
    /// Position of each carriage at power-up, mm from where its limit switch closes.
    pub start_mm: [f64; AXES],
    /// The gantry of an axis with two motors.
    pub gantry: Gantry,
    /// Faults of the limit switches.
    pub switches: [SwitchFault; AXES],
    /// The contact of the emergency stop.
    pub emergency_contact: Contact,
    /// Drives close their own loop: they alarm when steps are lost.
    pub closed_loop: bool,
    /// The alarms of all drives are on one wire; otherwise each axis has one.
    pub one_alarm_wire: bool,
    /// The plate that the probe touches.
    pub plate: Option<Plate>,
    /// The time for which the contacts of a switch may bounce, us; 0 for no bounce.
    pub bounce_us: u32,
    /// Largest deviation of a limit switch from its nominal position, mm to either side. It differs in each approach.
    pub switch_scatter_mm: f64,
    /// Seed of everything random: contact bounce, where switches close, and loads.
    pub seed: u64,
    /// The motor of all axes.
    pub motor: MotorData,
    /// The variation of the load of a motor that turns, to either side, as a part of what would stall it. UART drivers
    /// measure it; no step is lost by it.
    pub load_noise: f64,
    /// The load of each motor. If `None`, the usual load of an axis of that resolution: see [`Load::preset`].
    pub loads: [Option<Load>; AXES],
    /// The loads on springs, whose ringing is reported: see `ringing` of isostep-report. They change nothing else.
    pub springs: Springs,
    /// The width of a laser's beam at half its maximum, mm: for the picture of what it engraved.
    pub beam_mm: f64,
    /// The board.
    pub board: Board,
    /// The board's jumpers: the limit input of these axes is wired to their driver's DIAG, which is high for a stall, and not
    /// to their switch. Only where the drivers have a UART.
    pub diag: [bool; AXES],
    /// The VFD on the board's second wire.
    pub vfd: Option<VfdKind>,
    /// The acceleration and deceleration of the VFD's output, Hz/s.
    pub vfd_ramp_hz_s: f64,
    /// The port that makes the edges.
    pub port: Port,
    /// The times that moves last at least on the board.
    pub least_times: LeastTimes,
    /// Timing requirements of the drivers.
    pub driver: DriverTiming,
    /// The way in which a program is sent.
    pub streaming: Streaming,
    /// Interval between status requests while a program runs.
    pub poll_every: Option<Duration>,
    /// Virtual time after which a run is aborted.
    pub time_limit: Duration,
    /// Baud rate of the console, 8N1: a byte takes its time on the wire in both directions. If `None`, it takes no
    /// time.
    pub baud: Option<u32>,
    /// True if there is a second console, as a board has USB and a UART.
    pub second_console: bool,
    /// If set, tasks interrupt each other at the end of every critical section, as on a chip. Code of threads takes a
    /// random time of up to this many ns between two critical sections. If `None`, a task runs undisturbed until it
    /// waits, and takes no time.
    pub section_max_ns: Option<u32>,
    /// Faults and their times.
    pub faults: Vec<Fault>,
    /// Keep every edge, every change of a wire and every event. Not useful for a machine that runs for hours.
    pub keep_record: bool,
    /// If a record is kept, keep every change of a wire in it. These are most of the record of a long program.
    pub keep_waves: bool,
    /// No edges are made and nothing moves: the ports only wait for the duration of each segment. Useful to find how
    /// long a program takes; edges are not checked. For [`Port::Pio`] only.
    pub only_time: bool,
}

/// The places where the carriages stand at power-up, mm from their switches.
const START_MM: [f64; AXES] = *[35.0, 40.0, 15.0, 15.0].first_chunk().expect("there are four axes at most");

impl Default for Config {
    fn default() -> Self {
        Self {
            settings: Settings::DEFAULT,
            settings_file: None,
            start_mm: START_MM,
            gantry: Gantry::SQUARE,
            switches: [SwitchFault::None; AXES],
            emergency_contact: Contact::default(),
            closed_loop: false,
            one_alarm_wire: false,
            plate: None,
            bounce_us: 1_000,
            switch_scatter_mm: 0.0,
            seed: 1,
            motor: MotorData::NEMA_17,
            load_noise: 0.0,
            loads: [None; AXES],
            springs: Springs::default(),
            // Of a common diode laser.
            beam_mm: 0.1,
            board: Board::default(),
            diag: [false; AXES],
            vfd: None,
            vfd_ramp_hz_s: RAMP_HZ_S,
            port: Port::default(),
            least_times: least_times::RP2040,
            driver: DriverTiming::DRV8825,
            streaming: Streaming::GRBL,
            poll_every: None,
            time_limit: Duration::from_secs(24 * 3600),
            baud: None,
            second_console: false,
            section_max_ns: None,
            faults: Vec::new(),
            keep_record: true,
            keep_waves: true,
            only_time: false,
        }
    }
}

impl Config {
    /// Position of the carriage of `axis` at power-up, steps from where its switch closes.
    pub fn start_steps(&self, axis: usize) -> i32 {
        self.steps(axis, self.start_mm[axis])
    }

    /// The end stops of `axis`, steps from where its switch closes.
    pub(crate) fn end_stops_steps(&self, axis: usize) -> (i32, i32) {
        self.mechanics(&isostep_controller::config(&self.settings)).end_stops_steps[axis]
    }

    /// The mechanics of this machine with the controller's `config`.
    pub(crate) fn mechanics(&self, config: &isostep_motion::Config) -> Mechanics {
        Mechanics::of(config, self.motor, self.loads)
    }

    /// Checks that every carriage can be at its start position.
    ///
    /// # Errors
    /// [`StartOutside`] with the valid range.
    pub fn check(&self) -> Result<(), StartOutside> {
        for axis in 0..AXES {
            let (low, high) = self.end_stops_steps(axis);
            let per_mm = f64::from(self.settings.steps_per_mm[axis]);
            let (asked_mm, min_mm, max_mm) = (self.start_mm[axis], f64::from(low) / per_mm, f64::from(high) / per_mm);
            if !(min_mm..=max_mm).contains(&asked_mm) {
                return Err(StartOutside { axis, asked_mm, min_mm, max_mm });
            }
        }
        Ok(())
    }

    /// The command line that repeats this run of `program`, as far as the command line has options for it. No name
    /// stands for the program that is run when none is named.
    pub fn replay(&self, program: &str) -> String {
        let default = Self::default();
        let program = if program.is_empty() { String::new() } else { format!(" {program}") };
        let mut line = format!("isostep sim{program} --seed {}", self.seed);
        let mut said = default.settings;
        if let Some((file, settings)) = &self.settings_file {
            line += &format!(" --settings {file}");
            said = *settings;
        }
        if self.start_mm != default.start_mm {
            line += &format!(" --start {}", self.start_mm.map(|mm| mm.to_string()).join(","));
        }
        if self.gantry.skew_mm != default.gantry.skew_mm {
            line += &format!(" --skew {}", self.gantry.skew_mm);
        }
        if self.motor != default.motor {
            line += &format!(" --motor {}", self.motor);
        }
        for (axis, load) in Axis::ALL.into_iter().zip(self.loads) {
            line += &load.map_or(String::new(), |load| format!(" --load {axis}={load}"));
        }
        for (axis, fault) in Axis::ALL.into_iter().zip(self.switches) {
            if fault != SwitchFault::None {
                line += &format!(" --switch {axis}={fault}");
            }
        }
        if self.emergency_contact == Contact::NormallyClosed {
            line += " --estop nc";
        }
        if self.springs != default.springs {
            line += &format!(" --ringing {}", self.springs);
        }
        if self.beam_mm != default.beam_mm {
            line += &format!(" --beam {}", self.beam_mm);
        }
        if let Some(plate) = self.plate {
            line += &format!(" --probe-plate {plate}");
        }
        if self.settings.interval_thirds != said.interval_thirds {
            line += if self.settings.interval_thirds { " --intervals thirds" } else { " --intervals fastest" };
        }
        if self.settings.speed_profile != said.speed_profile {
            line += &format!(" --speed-profile {}", isostep_controller::config(&self.settings).speed_profile);
        }
        if self.board != default.board {
            line += &format!(" --board {}", self.board);
        }
        if self.diag != default.diag {
            let wired = Axis::ALL.into_iter().filter(|&axis| self.diag[axis as usize]);
            line += &format!(" --diag {}", wired.map(|axis| axis.to_string()).collect::<Vec<_>>().join(","));
        }
        if self.port != default.port {
            line += &format!(" --port {}", self.port);
        }
        for fault in &self.faults {
            line += &format!(" --fault {fault}");
        }
        line
    }

    fn steps(&self, axis: usize, mm: f64) -> i32 {
        (mm * f64::from(self.settings.steps_per_mm[axis])).round() as i32
    }
}

/// The start position of a carriage is beyond its end stops.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{}: start place {asked_mm} mm is beyond the end stops at {min_mm} and {max_mm} mm from its switch", Axis::ALL[*.axis])]
#[non_exhaustive]
pub struct StartOutside {
    /// Index of the axis.
    pub axis: usize,
    /// The start position asked for.
    pub asked_mm: f64,
    /// The lower end stop.
    pub min_mm: f64,
    /// The upper end stop.
    pub max_mm: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_replay_line_names_what_differs() {
        let mut config = Config { seed: 7, ..Config::default() };
        assert_eq!(config.replay("a.nc"), "isostep sim a.nc --seed 7");
        config.start_mm = [1.5, 2.0, 3.0];
        config.gantry.skew_mm = -2.5;
        config.switches[1] = SwitchFault::StuckOpen;
        config.settings.interval_thirds = true;
        config.settings.speed_profile = 1;
        config.board = Board::SkrPico;
        (config.diag[0], config.diag[1]) = (true, true);
        config.port = Port::Timer;
        config.emergency_contact = Contact::NormallyClosed;
        let line = "isostep sim a.nc --seed 7 --start 1.5,2,3 --skew -2.5 --switch Y=stuck-open --estop nc --intervals thirds \
                    --speed-profile s-curve --board skr-pico --diag X,Y --port timer";
        assert_eq!(config.replay("a.nc"), line);
        let settings_file = Some(("m.txt".to_owned(), Settings { speed_profile: 1, ..Settings::DEFAULT }));
        let config = Config { settings_file, motor: "1.2,300,10".parse().unwrap(), ..Config::default() };
        let config = Config { loads: [None, Some("5,8".parse().unwrap()), None], beam_mm: 0.25, ..config };
        let config = Config { springs: "y:35:0.05,X:40:0.1".parse().unwrap(), ..config };
        let line = "isostep sim a.nc --seed 1 --settings m.txt --motor 1.2,300,10 --load Y=5,8 --ringing X:40:0.1,Y:35:0.05 --beam 0.25 --speed-profile trapezoid";
        assert_eq!(config.replay("a.nc"), line);
    }

    #[test]
    fn a_start_beyond_an_end_stop_is_refused_with_the_range() {
        let config = Config { start_mm: [0.0, 500.0, 0.0], ..Config::default() };
        let message = "Y: start place 500 mm is beyond the end stops at -3 and 405 mm from its switch";
        assert_eq!(config.check().unwrap_err().to_string(), message);
    }
}
