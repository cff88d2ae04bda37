//! From the settings, in the user's units, to the coordinator's configuration.

use core::ops::RangeInclusive;

use embassy_time::Duration;
use isostep_console::{Settings, length};
use isostep_motion::{
    AXES, Axis, Capabilities, Config, Contact, Direction, Duties, HomingConfig, Kinematics, Level, Squared, ToolConfig,
    Wiring, beside_steps, whole_steps,
};
use isostep_profile::shaper::{Shaper, ShaperKind};
use isostep_profile::{IntervalSplit, Limits, SpeedProfile};

/// `$1=255`: the motors stay energised.
const IDLE_DELAY_FOREVER_MS: u16 = 255;

/// The message about settings that the machine refuses although they have passed the console's checks.
pub(crate) const UNWORKABLE: &str = "the machine cannot work with these settings";

/// Bits of `$6`.
const PROBE_INVERTED: u16 = 1;
const PROBE_NOT_PULLED_UP: u16 = 2;

/// The coordinator's configuration from `settings`. Whether it works is decided by [`Config::check`].
#[must_use]
pub fn config(settings: &Settings) -> Config {
    let masked = |mask: u16| Axis::ALL.map(|axis| mask & (1 << axis as u16) != 0);
    Config {
        limits: core::array::from_fn(|axis| limits(settings, axis)),
        kinematics: if settings.has_crossed_belts() { Kinematics::CoreXy } else { Kinematics::Cartesian },
        steps_per_mm: settings.steps_per_mm.map(f64::from),
        travel_mm: core::array::from_fn(|axis| settings.reach_mm(axis).into()),
        is_endless: core::array::from_fn(|axis| settings.is_endless(axis)),
        junction_deviation_mm: settings.junction_deviation_mm.into(),
        interval_split: IntervalSplit::ALL[usize::from(settings.interval_thirds).min(IntervalSplit::ALL.len() - 1)],
        speed_profile: SpeedProfile::ALL[usize::from(settings.speed_profile).min(SpeedProfile::ALL.len() - 1)],
        shapers: core::array::from_fn(|axis| shaper(settings, axis)),
        hard_limits: settings.hard_limits,
        wiring: masked(settings.direction_invert_mask)
            .map(|direction_inverted| Wiring { direction_inverted, pulse_ns: pulse_ns(settings.pulse_us) }),
        enable_inverted: settings.enable_invert,
        switches_inverted: settings.limit_invert,
        drive_alarms: drive_alarms(settings),
        idle_delay: (settings.idle_delay_ms != IDLE_DELAY_FOREVER_MS)
            .then(|| Duration::from_millis(settings.idle_delay_ms.into())),
        tool: tool_config(settings),
        probe_inverted: settings.probe_mask & PROBE_INVERTED != 0,
        probe_pulled_up: settings.probe_mask & PROBE_NOT_PULLED_UP == 0,
        hold_is_door: settings.hold_input_is_door,
        homing: HomingConfig {
            order: settings.homing_order().map(|index| index.map(|index| Axis::ALL[index])),
            towards: masked(settings.homing_direction_mask)
                .map(|negative| if negative { Direction::Negative } else { Direction::Positive }),
            seek_mm_s: f64::from(settings.homing_seek_mm_min) / 60.0,
            room_mm: settings.switch_room_mm.into(),
            latch_mm_s: f64::from(settings.homing_latch_mm_min) / 60.0,
            pull_off_mm: settings.homing_pull_off_mm.into(),
            debounce: Duration::from_millis(settings.homing_debounce_ms.into()),
            #[cfg(feature = "trinamic")]
            by_stall: masked(settings.stall_homing_mask),
            #[cfg(not(feature = "trinamic"))]
            by_stall: [false; AXES],
        },
        squared: settings.second_motor().map(|axis| Squared {
            axis: Axis::ALL[axis],
            direction_inverted: settings.second_invert_mask & (1 << axis) != 0,
            offset_mm: settings.square_offset_mm[axis].into(),
            skew_max_mm: settings.skew_max_mm.into(),
        }),
    }
}

/// The contacts of the axes' drives.
fn drive_alarms(settings: &Settings) -> [Option<Contact>; AXES] {
    core::array::from_fn(|axis| {
        let is_in = |mask: u16| mask & (1 << axis) != 0;
        let closes = is_in(settings.drive_alarm_closed_mask);
        let contact = if closes { Contact::NormallyOpen } else { Contact::NormallyClosed };
        is_in(settings.drive_alarm_mask).then_some(contact)
    })
}

/// The shaper of an axis.
fn shaper(settings: &Settings, axis: usize) -> Shaper {
    Shaper {
        kind: ShaperKind::ALL[usize::from(settings.shaper_kind[axis]).min(ShaperKind::ALL.len() - 1)],
        natural_hz: settings.shaper_hz[axis].into(),
        damping_ratio: settings.shaper_damping_ratio[axis].into(),
    }
}

/// The tool's configuration from `settings`.
fn tool_config(settings: &Settings) -> ToolConfig {
    let duty = |percent: f32| Level::of_ratio(percent / 100.0).of_65535();
    let least = Level::of_ratio(settings.spindle_min_rpm / settings.spindle_max_rpm);
    ToolConfig {
        laser: settings.laser_mode,
        duties: Duties::new(least, duty(settings.pwm_least_percent), duty(settings.pwm_full_percent)),
        pwm_hz: settings.spindle_pwm_hz as u32,
        spin_up: Duration::from_millis((settings.spin_up_s * 1e3) as u64),
        reports_speed: settings.has_vfd(),
    }
}

/// Setting `$0`, ns.
fn pulse_ns(pulse_us: u16) -> u32 {
    u32::from(pulse_us) * 1_000
}

/// The highest step rate that every known port carries with pulses of `pulse_us`, steps/s: what [`Settings::check`] asks for.
#[must_use]
pub fn carries_steps_s(ports: [Option<Capabilities>; AXES], pulse_us: u16) -> f32 {
    let wiring = Wiring { pulse_ns: pulse_ns(pulse_us), ..Wiring::default() };
    ports.iter().flatten().map(|port| port.rate_max_steps_s(wiring) as f32).fold(f32::INFINITY, f32::min)
}

fn limits(settings: &Settings, axis: usize) -> Limits {
    let steps_per_mm = f64::from(settings.steps_per_mm[axis]);
    let steps_s = |mm_min: [f32; AXES]| f64::from(mm_min[axis]) / 60.0 * steps_per_mm;
    let steps_s2 = |mm_s2: [f32; AXES]| f64::from(mm_s2[axis]) * steps_per_mm;
    Limits {
        start_speed_steps_s: steps_s(settings.start_rate_mm_min),
        top_speed_steps_s: steps_s(settings.max_rate_mm_min),
        accel_steps_s2: steps_s2(settings.accel_mm_s2),
        decel_steps_s2: steps_s2(settings.decel_mm_s2()),
        jerk_steps_s3: match settings.jerk_or_0_mm_s3[axis] {
            0.0 => f64::INFINITY,
            jerk_mm_s3 => f64::from(jerk_mm_s3) * steps_per_mm,
        },
    }
}

/// The part of a configuration that every line needs. A whole configuration would take long to copy.
#[derive(Clone)]
pub(crate) struct Geometry {
    steps_per_pm: [f64; AXES],
    /// The places that each axis can go to once it is homed, steps.
    pub travel_steps: [RangeInclusive<i32>; AXES],
}

impl Geometry {
    #[cold]
    pub fn of(config: &Config) -> Self {
        let steps_per_pm = config.steps_per_mm.map(|per_mm| per_mm / length::PM_PER_MM);
        Self { steps_per_pm, travel_steps: Axis::ALL.map(|axis| config.travel_steps(axis)) }
    }

    /// The distance of a place from its whole steps.
    pub fn offsets(&self, place_pm: [i64; AXES]) -> [i8; AXES] {
        core::array::from_fn(|axis| beside_steps(place_pm[axis] as f64, self.steps_per_pm[axis]))
    }

    /// A place in whole steps, rounded to the nearest.
    pub fn steps(&self, place_pm: [i64; AXES]) -> [i32; AXES] {
        core::array::from_fn(|axis| whole_steps(place_pm[axis] as f64, self.steps_per_pm[axis]))
    }
}
