//! The machine's settings, and the rules between them.

use crate::axes::{A, Z, of_each};
use crate::rotary::Rotary;
use crate::{AXES, Conflict, SettingError, ToolChange, axes, setting_table};

/// Maps a pulse width in us (0: as short as possible) to the highest step rate that the step outputs support, steps/s.
pub type Carries<'a> = &'a dyn Fn(u16) -> f32;

/// Speed profiles from this `$940` on define speed over displacement, so they can never leave standstill. The speed profiles are
/// defined by the profile crate, which this crate does not know; a test checks that this number fits them.
const FIRST_SPEED_PROFILE_OVER_DISPLACEMENT: u16 = 3;

/// The least travel of an axis that has an end.
pub(crate) const TRAVEL_LEAST_MM: f32 = 1.0;
const TURN_DEGREES: f32 = 360.0;
const DEFAULT_TRAVEL_MM: [f32; AXES] = of_each([350.0, 400.0, 100.0, 0.0]);

/// Every setting, as `$$` lists them. Values per axis are in the order X, Y, Z and, if there are four, A. Bit 0 of a mask
/// is X.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// `$0`: STEP is high for this long, or as long as the driver needs if that is longer.
    pub pulse_us: u16,
    /// `$1`: the motors stay energised for this long after a move; 255 means always.
    pub idle_delay_ms: u16,
    /// `$2`: axes whose STEP is active low.
    pub step_invert_mask: u16,
    /// `$3`: axes whose DIR is low for the positive direction.
    pub direction_invert_mask: u16,
    /// `$4`: ENABLE is active high.
    pub enable_invert: bool,
    /// `$5`: the limit switches open when pressed.
    pub limit_invert: bool,
    /// `$6`: the probe's input. Bit 0: the contact is high, not low. Bit 1: the input has no pull-up.
    pub probe_mask: u16,
    /// `$8`: axes whose second motor has the other level of DIR than the first.
    pub second_invert_mask: u16,
    /// `$10`: bit 0 reports machine position instead of work position, bit 1 adds the free buffers.
    pub report_mask: u16,
    /// `$11`: how far a corner may be rounded; 0 stops at every corner.
    pub junction_deviation_mm: f32,
    /// `$12`: how far the chords of an arc may deviate from it.
    pub arc_tolerance_mm: f32,
    /// `$13`: report positions and feeds in inches.
    pub report_inches: bool,
    /// `$20`: refuse targets outside the travel, once homed.
    pub soft_limits: bool,
    /// `$21`: stop when a switch closes.
    pub hard_limits: bool,
    /// `$22`: `$H` homes.
    pub homing: bool,
    /// `$23`: axes that home towards negative.
    pub homing_direction_mask: u16,
    /// `$24`: the slow approach that sets the zero.
    pub homing_latch_mm_min: f32,
    /// `$25`: the fast approach that finds the switch.
    pub homing_seek_mm_min: f32,
    /// `$26`: a switch must be steady for this long.
    pub homing_debounce_ms: u16,
    /// `$27`: distance from the switch to the zero; below the travel of every axis.
    pub homing_pull_off_mm: f32,
    /// `$28`: how far G73 goes up after a peck, and how far above the last depth the rapid of G83 ends.
    pub peck_clearance_mm: f32,
    /// `$30`: the S at which spindle or laser have full duty, `$36`.
    pub spindle_max_rpm: f32,
    /// `$31`: the S up to which spindle or laser have least duty, `$35`; below `$30`.
    pub spindle_min_rpm: f32,
    /// `$32`: the spindle is a laser.
    pub laser_mode: bool,
    /// `$33`: frequency of the pulse-width modulation (PWM) of spindle or laser.
    pub spindle_pwm_hz: f32,
    /// `$35`: PWM duty at `$31`; at most `$36`.
    pub pwm_least_percent: f32,
    /// `$36`: PWM duty at `$30`.
    pub pwm_full_percent: f32,
    /// `$100`-`$102`.
    pub steps_per_mm: [f32; AXES],
    /// `$110`-`$112`: top speed.
    pub max_rate_mm_min: [f32; AXES],
    /// `$120`-`$122`.
    pub accel_mm_s2: [f32; AXES],
    /// `$130`-`$132`: travel of an axis, which is from 0 to this.
    pub travel_mm: [f32; AXES],
    /// `$140`-`$142`: the current of a moving motor, effective (grblHAL's number).
    #[cfg(feature = "trinamic")]
    pub run_current_ma: [u16; AXES],
    /// `$150`-`$152`: microsteps of a full step, a power of two (grblHAL's number). If they change, `steps_per_mm` changes
    /// by the same factor.
    #[cfg(feature = "trinamic")]
    pub microsteps: [u16; AXES],
    /// `$170`-`$172`: how much farther from its switch the second motor of the axis stands than the first when the axis
    /// is square; below 0 it is the first that stands farther.
    pub square_offset_mm: [f32; AXES],
    /// `$200`-`$202`: SGTHRS, the half of the SG_RESULT at which a driver says that its motor stalls (grblHAL's number); 0
    /// as long as nobody has found it out.
    #[cfg(feature = "trinamic")]
    pub stall_threshold: [u16; AXES],
    /// `$210`-`$212`: the current of a motor that stands still (grblHAL's number).
    #[cfg(feature = "trinamic")]
    pub hold_percent: [u16; AXES],
    /// `$338`: axes whose drivers are set and watched (grblHAL's number).
    #[cfg(feature = "trinamic")]
    pub trinamic_mask: u16,
    /// `$339`: axes that have no limit switch, but home by a stall of their motor (grblHAL's number).
    #[cfg(feature = "trinamic")]
    pub stall_homing_mask: u16,
    /// `$340`: how far from its speed a spindle that reports it may turn (grblHAL's number, as all of a VFD's).
    pub at_speed_percent: f32,
    /// `$341`: what M6 does (grblHAL's number), see [`ToolChange`](crate::ToolChange).
    pub tool_change_mode: u16,
    /// `$342`: how far a tool goes down to be measured (grblHAL's number, as the next two).
    pub tool_probe_mm: f32,
    /// `$343`: the slow approach that measures it.
    pub tool_latch_mm_min: f32,
    /// `$344`: the fast approach before it, and the way back.
    pub tool_seek_mm_min: f32,
    /// `$349`: how far one motor of an axis with two motors may go alone to its switch.
    pub skew_max_mm: f32,
    /// `$374`: the baud rate of Modbus, as a number: see [`Settings::modbus_baud`].
    pub modbus_baud_index: u16,
    /// `$375`: the longest time from the end of a request to that of its reply.
    pub modbus_timeout_ms: u16,
    /// `$376`: bit 0 makes A a rotary axis: a degree stands wherever a millimetre does.
    #[cfg(feature = "four-axes")]
    pub rotary_mask: u16,
    /// `$701`: what F is in a move that turns a rotary axis. 0: the speed along all axes, a degree counted as a
    /// millimetre. Bit 0: the speed of the linear axes, if one of them moves. Bit 1: that, too, and where only a rotary
    /// axis moves F is in degrees also in inches mode.
    #[cfg(feature = "four-axes")]
    pub rotary_feed_mask: u16,
    /// `$394`: the time that the spindle takes to reach its speed; motion waits for it. For one that reports its speed, the longest
    /// time; 0 for 10 s.
    pub spin_up_s: f32,
    /// `$744`: axes whose drives have an alarm wired (grblHAL's number, as the next); one wire for all is X's.
    pub drive_alarm_mask: u16,
    /// `$745`: of these, axes whose alarm is a closed contact. That of the others is an open one, as grblHAL has it.
    pub drive_alarm_closed_mask: u16,
    /// `$395`: what turns the spindle, as a number: 0 for the PWM output, others for a VFD by Modbus.
    pub spindle_type: u16,
    /// `$461`: what a hertz of the VFD's output makes of speed.
    pub vfd_rpm_per_hz: u16,
    /// `$462` to `$464`: the registers of a generic VFD: run, set frequency, output frequency.
    pub vfd_registers: [u16; 3],
    /// `$465` to `$467`: what is written to the first of them: run clockwise, run counter-clockwise, stop.
    pub vfd_words: [u16; 3],
    /// `$468` and `$469`: the frequency to set is S times the first by the second.
    pub vfd_set_ratio: [f32; 2],
    /// `$470` and `$471`: the speed is what is read times the first by the second.
    pub vfd_read_ratio: [f32; 2],
    /// `$476`: the VFD's address.
    pub vfd_address: u16,
    /// `$681`: parity of Modbus: 0 none, 1 even, 2 odd.
    pub modbus_parity: u16,
    /// `$900`: accelerate, cruise and brake for three equal times (thirds) instead of as fast as the limits allow.
    pub interval_thirds: bool,
    /// `$940`: how speed changes on a ramp, as a number: trapezoid, S-curve, sine, linear, quadratic, sinusoidal,
    /// logarithmic.
    pub speed_profile: u16,
    /// `$901`: the axes in the order they home, as digits; see [`Settings::homing_order`].
    pub homing_order_digits: u16,
    /// `$902`: the feed-hold input is the switch of a safety door instead of a button.
    pub hold_input_is_door: bool,
    /// `$904`: how far G64 without P lets the path leave a corner; 0 for corners as with G61.
    pub blend_deviation_mm: f32,
    /// `$905`: the axis with a second motor, as a digit: 1 is X; 0 means none. See [`Settings::second_motor`].
    pub second_motor_axis: u16,
    /// `$907`: what the motors do for the axes to move: 0, each axis has its own; 1, crossed belts (CoreXY, H-bot), where the motor of X
    /// makes X + Y and that of Y makes X - Y.
    pub kinematics: u16,
    /// `$906`: the room behind a limit switch, in which a homing seek brakes; 0: it stops at once.
    pub switch_room_mm: f32,
    /// `$908`: axes whose drivers make 256 microsteps of the steps that they get.
    #[cfg(feature = "trinamic")]
    pub interpolate_mask: u16,
    /// `$909`: axes of those that home by stall whose motor, if it stalls at speed, stops the machine.
    #[cfg(feature = "trinamic")]
    pub stall_alarm_mask: u16,
    /// `$910`-`$912`: the speed at which an axis can start and stop without a ramp.
    pub start_rate_mm_min: [f32; AXES],
    /// `$920`-`$922`: deceleration; 0 means equal to the acceleration, see [`Settings::decel_mm_s2`].
    pub decel_or_0_mm_s2: [f32; AXES],
    /// `$930`-`$932`: jerk limit of the S-curve; 0 for none.
    pub jerk_or_0_mm_s3: [f32; AXES],
    /// `$950`-`$952`: each axis's shaper, as a number: none, ZV, MZV, ZVD, EI, box.
    pub shaper_kind: [u16; AXES],
    /// `$960`-`$962`: the frequency at which an axis's load rings.
    pub shaper_hz: [f32; AXES],
    /// `$970`-`$972`: its damping ratio.
    pub shaper_damping_ratio: [f32; AXES],
    /// `$980`-`$982`: up to this speed a driver chops by StealthChop, above it by SpreadCycle; 0 for SpreadCycle always.
    #[cfg(feature = "trinamic")]
    pub stealth_mm_min: [f32; AXES],
}

impl Settings {
    /// The default machine: the papers' parking gantry on DRV8825 drivers.
    pub const DEFAULT: Self = Self {
        pulse_us: 2,
        idle_delay_ms: 255,
        step_invert_mask: 0,
        direction_invert_mask: 0,
        enable_invert: false,
        limit_invert: false,
        probe_mask: 0,
        second_invert_mask: 0,
        report_mask: 1,
        junction_deviation_mm: 0.01,
        arc_tolerance_mm: 0.002,
        report_inches: false,
        soft_limits: true,
        hard_limits: true,
        homing: true,
        homing_direction_mask: axes::ALL_AXES,
        homing_latch_mm_min: 60.0,
        homing_seek_mm_min: 600.0,
        homing_debounce_ms: 5,
        homing_pull_off_mm: 2.0,
        peck_clearance_mm: 1.0,
        spindle_max_rpm: 1000.0,
        spindle_min_rpm: 0.0,
        laser_mode: false,
        spindle_pwm_hz: 5000.0,
        pwm_least_percent: 0.0,
        pwm_full_percent: 100.0,
        steps_per_mm: [50.0; AXES],
        max_rate_mm_min: [2880.0; AXES],
        accel_mm_s2: [50.0; AXES],
        travel_mm: DEFAULT_TRAVEL_MM,
        #[cfg(feature = "trinamic")]
        run_current_ma: [800; AXES],
        #[cfg(feature = "trinamic")]
        microsteps: [16; AXES],
        square_offset_mm: [0.0; AXES],
        #[cfg(feature = "trinamic")]
        stall_threshold: [0; AXES],
        #[cfg(feature = "trinamic")]
        hold_percent: [50; AXES],
        #[cfg(feature = "trinamic")]
        trinamic_mask: axes::ALL_AXES,
        #[cfg(feature = "trinamic")]
        stall_homing_mask: 0,
        at_speed_percent: 5.0,
        tool_change_mode: 0,
        tool_probe_mm: 30.0,
        tool_latch_mm_min: 25.0,
        tool_seek_mm_min: 200.0,
        skew_max_mm: 10.0,
        modbus_baud_index: 2,
        modbus_timeout_ms: 50,
        #[cfg(feature = "four-axes")]
        rotary_mask: 1,
        #[cfg(feature = "four-axes")]
        rotary_feed_mask: 0,
        spin_up_s: 0.0,
        drive_alarm_mask: 0,
        drive_alarm_closed_mask: 0,
        spindle_type: 0,
        vfd_rpm_per_hz: 60,
        vfd_registers: [0x2000, 0x2001, 0x2103],
        vfd_words: [0x12, 0x22, 1],
        vfd_set_ratio: [100.0, 60.0],
        vfd_read_ratio: [60.0, 100.0],
        vfd_address: 1,
        modbus_parity: 0,
        interval_thirds: false,
        speed_profile: 0,
        homing_order_digits: if AXES > Z { 312 } else { 12 },
        hold_input_is_door: false,
        blend_deviation_mm: 0.01,
        second_motor_axis: 0,
        kinematics: 0,
        switch_room_mm: 0.0,
        #[cfg(feature = "trinamic")]
        interpolate_mask: axes::ALL_AXES,
        #[cfg(feature = "trinamic")]
        stall_alarm_mask: 0,
        start_rate_mm_min: [0.0; AXES],
        decel_or_0_mm_s2: [0.0; AXES],
        jerk_or_0_mm_s3: [500.0; AXES],
        shaper_kind: [0; AXES],
        shaper_hz: [40.0; AXES],
        shaper_damping_ratio: [0.05; AXES],
        #[cfg(feature = "trinamic")]
        stealth_mm_min: [0.0; AXES],
    };

    /// Deceleration per axis. Where the setting is 0, it is the acceleration.
    pub fn decel_mm_s2(&self) -> [f32; AXES] {
        core::array::from_fn(|axis| match self.decel_or_0_mm_s2[axis] {
            0.0 => self.accel_mm_s2[axis],
            decel_mm_s2 => decel_mm_s2,
        })
    }

    /// Axis indices in the order they home; fewer than there are axes if A does not home.
    pub fn homing_order(&self) -> [Option<usize>; AXES] {
        let mut order = [None; AXES];
        let mut left = self.homing_order_digits;
        for place in order.iter_mut().rev() {
            *place = usize::from(left % 10).checked_sub(1);
            left /= 10;
        }
        order
    }

    /// True if `axis` is rotary: it is in degrees then.
    pub fn is_rotary(&self, axis: usize) -> bool {
        axis == A && self.rotary().is_on
    }

    /// The meaning of A.
    #[cfg(feature = "four-axes")]
    pub(crate) fn rotary(&self) -> Rotary {
        Rotary {
            is_on: self.rotary_mask & 1 != 0,
            feed_is_linear: self.rotary_feed_mask != 0,
            feed_is_degrees: self.rotary_feed_mask & 2 != 0,
        }
    }

    #[cfg(not(feature = "four-axes"))]
    #[expect(clippy::unused_self, reason = "it needs the settings if there is a fourth axis")]
    pub(crate) fn rotary(&self) -> Rotary {
        Rotary::default()
    }

    /// True if places on `axis` are reported in inches.
    pub(crate) fn reports_inches(&self, axis: usize) -> bool {
        self.report_inches && !self.is_rotary(axis)
    }

    /// The unit of lengths along `axis`.
    pub fn unit(&self, axis: usize) -> &'static str {
        if self.is_rotary(axis) { "degrees" } else { "mm" }
    }

    /// True if `axis` has no end of its travel: a rotary axis of which `$133` is 0.
    pub fn is_endless(&self, axis: usize) -> bool {
        self.is_rotary(axis) && self.travel_mm[axis] == 0.0
    }

    /// The distance that an axis goes until it has been everywhere: its travel, or one turn if it has no end.
    pub fn reach_mm(&self, axis: usize) -> f32 {
        if self.is_endless(axis) { TURN_DEGREES } else { self.travel_mm[axis] }
    }

    /// The index of the axis that has a second motor.
    pub fn second_motor(&self) -> Option<usize> {
        usize::from(self.second_motor_axis).checked_sub(1)
    }

    /// True if two motors move X and Y together.
    pub fn has_crossed_belts(&self) -> bool {
        self.kinematics == 1
    }

    /// True if the axis homes by a switch.
    pub(crate) fn seeks_switch(&self, axis: usize) -> bool {
        #[cfg(feature = "trinamic")]
        let by_stall = self.stall_homing_mask & (1 << axis) != 0;
        #[cfg(not(feature = "trinamic"))]
        let by_stall = false;
        self.homing_order().contains(&Some(axis)) && !by_stall
    }

    /// True if a VFD turns the spindle, so that it reports its speed. A laser is on the PWM output.
    pub fn has_vfd(&self) -> bool {
        self.spindle_type != 0 && !self.laser_mode
    }

    /// Setting `$374`, baud.
    pub fn modbus_baud(&self) -> u32 {
        match self.modbus_baud_index {
            ..=2 => 9_600,
            3 => 19_200,
            4 => 38_400,
            5.. => 115_200,
        }
    }

    /// What M6 does.
    pub fn tool_change(&self) -> ToolChange {
        ToolChange::of(self.tool_change_mode)
    }

    /// The value of setting `number`, as `$$` prints it; flags are 0 or 1.
    pub fn get(&self, number: u16) -> Option<f32> {
        let (setting, axis) = setting_table::find(number)?;
        Some(setting.value(self, axis))
    }

    /// These settings with one of them changed. Whether they work together is another matter, see [`check`](Self::check):
    /// so a listing can be sent back line by line, whatever was set before. `$22=0` also turns off `$20`, as in Grbl. Other
    /// microsteps (`$150`) change the steps per millimetre, so that a millimetre stays one.
    ///
    /// # Errors
    /// The fault of the value by itself.
    pub fn with(mut self, number: u16, value: f32) -> Result<Self, SettingError> {
        let (setting, axis) = setting_table::find(number).ok_or(SettingError::Unknown { number })?;
        setting.check(&self, number, value)?;
        #[cfg(feature = "trinamic")]
        let microsteps = self.microsteps[axis];
        setting.set(&mut self, axis, value);
        #[cfg(feature = "trinamic")]
        if setting.number == setting_table::MICROSTEPS && self.microsteps[axis].is_power_of_two() {
            self.steps_per_mm[axis] *= f32::from(self.microsteps[axis]) / f32::from(microsteps.max(1));
        }
        if number == setting_table::HOMING && !self.homing {
            self.soft_limits = false;
        }
        self.check_values()?;
        Ok(self)
    }

    /// Sets setting `number` to a stored value without checking it; returns `false` if there is no such setting. See
    /// [`check_ranges`](Self::check_ranges).
    pub fn set(&mut self, number: u16, value: f32) -> bool {
        setting_table::find(number).is_some_and(|(setting, axis)| {
            setting.set(self, axis, value);
            true
        })
    }

    /// Checks each value by itself: that it is in the range of its row, that the homing order names X, Y and Z once each, and
    /// A once at most, that microsteps are a power of two, that an axis that cannot be rotary has a travel, and that the speed
    /// profiles are not left out. [`with`](Self::with) ensures that, [`set`](Self::set) does not.
    ///
    /// # Errors
    /// The first value that cannot be.
    pub fn check_ranges(&self) -> Result<(), SettingError> {
        setting_table::TABLE.iter().try_for_each(|setting| {
            let mut numbers = setting.numbers().enumerate();
            numbers.try_for_each(|(axis, number)| setting.check(self, number, setting.value(self, axis)))
        })?;
        self.check_values()
    }

    /// The rules for values by themselves that are no ranges.
    fn check_values(&self) -> Result<(), SettingError> {
        if !self.homes_each_once() {
            return Err(SettingError::HomingOrder { digits: self.homing_order_digits });
        }
        #[cfg(feature = "trinamic")]
        if let Some(axis) = (0..AXES).find(|&axis| !self.microsteps[axis].is_power_of_two()) {
            return Err(SettingError::Microsteps { axis, microsteps: self.microsteps[axis] });
        }
        match (0..AXES).find(|&axis| axis != A && !self.has_travel(axis)) {
            Some(axis) => {
                let (number, value, unit) = (130 + axis as u16, self.travel_mm[axis], self.unit(axis));
                Err(SettingError::TooLow { number, value, min: TRAVEL_LEAST_MM, unit })
            }
            None => Ok(()),
        }
    }

    /// Checks the rules between settings, with step outputs that support `carries`. Nothing may move with settings that break
    /// one.
    ///
    /// # Errors
    /// The first broken rule.
    pub fn check(&self, carries: Carries<'_>) -> Result<(), Conflict<'_>> {
        Conflict::first(self, carries).map_or(Ok(()), Err)
    }

    /// True if the homing order names X, Y and Z once each, and A once at most.
    fn homes_each_once(&self) -> bool {
        let order = self.homing_order();
        let times = |axis: usize| order.iter().filter(|&&homes| homes == Some(axis)).count();
        let named = (0..AXES).all(|axis| times(axis) == 1 || axis == A && times(axis) == 0);
        // A digit that is no axis, or a 0 among the others, makes another number of the same axes.
        named && order.iter().skip_while(|homes| homes.is_none()).all(|homes| homes.is_some_and(|axis| axis < AXES))
    }

    /// True if the axis has a travel, or needs none.
    pub(crate) fn has_travel(&self, axis: usize) -> bool {
        self.travel_mm[axis] >= TRAVEL_LEAST_MM || self.is_endless(axis)
    }

    /// The offset of the axis's second motor; 0 if it has none.
    pub(crate) fn offset_mm(&self, axis: usize) -> f32 {
        if self.second_motor() == Some(axis) { self.square_offset_mm[axis] } else { 0.0 }
    }

    /// True if the speed profile needs a start speed.
    pub(crate) fn needs_start(&self) -> bool {
        self.speed_profile >= FIRST_SPEED_PROFILE_OVER_DISPLACEMENT
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self::DEFAULT
    }
}
