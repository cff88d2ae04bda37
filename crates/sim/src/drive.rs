//! The drive of an axis: a motor and what it moves. Its margins follow from physics; `docs/motors.md` has the arithmetic.
//!
//! # Physics
//! The field of a stepper turns by the microstep, and the rotor is drawn after it as by a spring. With the lag δ in
//! electrical radians (a full step is π/2) the torque is T(ω) sin δ. Up to the corner speed, T is the holding torque
//! over √2, because in microsteps the two phases share the current as sine and cosine. Beyond, the supply no longer
//! drives the whole current through the windings, and T falls as 1/ω. Friction and a drag that grows with the speed
//! work against it. Where the lag exceeds two full steps, the torque draws the rotor to the next place where it is in
//! phase: it has lost four full steps.
//!
//! The simulator integrates that from edge to edge. What it does is known in closed form for three cases, which are here:
//! [`accel_mm_s2`](Drive::accel_mm_s2), [`spare_mm_s2`](Drive::spare_mm_s2) and [`jump_mm_s`](Drive::jump_mm_s).

use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::fmt;
use std::str::FromStr;

/// Full steps of a revolution.
const FULL_STEPS: f64 = 200.0;
/// Pairs of poles: electrical radians per radian.
const POLE_PAIRS: f64 = FULL_STEPS / 4.0;
/// Friction as a share of the torque: bearings, guides, detent.
const FRICTION: f64 = 0.1;
/// At this multiple of the corner speed no torque is left.
const GONE_CORNERS: f64 = 2.0;
/// The share of the torque that an acceleration may ask for at once: x of 1 + √(1 - x²) = x (π - asin x).
const SUDDEN: f64 = 0.724_6;
/// From this many steps/mm on, an axis has a screw rather than a belt.
const SCREW_STEPS_PER_MM: f64 = 200.0;

/// The data of a motor's datasheet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorData {
    /// Holding torque with both phases at full current, N m.
    pub holding_nm: f64,
    /// Inertia of the rotor, g cm².
    pub rotor_g_cm2: f64,
    /// The speed from which its supply cannot drive the whole current through it, revolutions/s.
    pub corner_rev_s: f64,
}

impl MotorData {
    /// A common NEMA 17 of 40 mm length at 24 V.
    pub const NEMA_17: Self = Self { holding_nm: 0.4, rotor_g_cm2: 54.0, corner_rev_s: 12.0 };
    /// A motor that follows any edge.
    pub const RIGID: Self = Self { holding_nm: f64::INFINITY, ..Self::NEMA_17 };
}

impl fmt::Display for MotorData {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{}", self.holding_nm, self.rotor_g_cm2, self.corner_rev_s)
    }
}

impl FromStr for MotorData {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [holding_nm, rotor_g_cm2, corner_rev_s] = positive(text)
            .ok_or("three numbers above 0: holding torque in N m, inertia of the rotor in g cm2, and revolutions/s up to which the torque is whole, such as 0.4,54,12")?;
        Ok(Self { holding_nm, rotor_g_cm2, corner_rev_s })
    }
}

/// Numbers above 0, with commas between them.
fn positive<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    text.split(',').map(number).collect::<Option<Vec<f64>>>()?.try_into().ok()
}

/// The load of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Travel per revolution: the circumference of a pulley, or the lead of a screw, mm.
    pub mm_per_rev: f64,
    /// The mass that moves with the axis, kg.
    pub mass_kg: f64,
    /// Inertia of what turns with the rotor, kg m².
    pub turning_kg_m2: f64,
}

impl Load {
    /// 2 kg on a belt, about 40 mm a revolution: a pulley of 20 teeth.
    const BELT: Self = Self { mm_per_rev: 40.0, mass_kg: 2.0, turning_kg_m2: 0.0 };
    /// 10 kg on a screw with a lead of about 4 mm, 8 mm thick and 400 mm long.
    const SCREW: Self = Self { mm_per_rev: 4.0, mass_kg: 10.0, turning_kg_m2: 1.3e-6 };
    /// A screw is coarser where it would turn faster than this, revolutions/s, up to the coarsest lead, mm.
    const SCREW_REV_S: f64 = 10.0;
    const SCREW_LEAD_MAX_MM: f64 = 16.0;

    /// The load of an axis of this resolution: a belt below 200 steps/mm, otherwise a screw.
    pub fn preset(steps_per_mm: f64, top_mm_s: f64) -> Self {
        let preset = if steps_per_mm < SCREW_STEPS_PER_MM { Self::BELT } else { Self::SCREW };
        let mut load =
            Self { mm_per_rev: microsteps(steps_per_mm, preset.mm_per_rev) * FULL_STEPS / steps_per_mm, ..preset };
        while preset == Self::SCREW
            && top_mm_s > Self::SCREW_REV_S * load.mm_per_rev
            && 2.0 * load.mm_per_rev <= Self::SCREW_LEAD_MAX_MM
        {
            load.mm_per_rev *= 2.0;
        }
        load
    }
}

impl fmt::Display for Load {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{}", self.mm_per_rev, self.mass_kg)
    }
}

impl FromStr for Load {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [mm_per_rev, mass_kg] =
            positive(text).ok_or("two numbers above 0: mm per revolution and kg that move, such as 40,2")?;
        let preset = if mm_per_rev > Self::SCREW_LEAD_MAX_MM { Self::BELT } else { Self::SCREW };
        Ok(Self { mm_per_rev, mass_kg, ..preset })
    }
}

/// The power of two of microsteps that makes a revolution about this long.
fn microsteps(steps_per_mm: f64, mm_per_rev: f64) -> f64 {
    (steps_per_mm * mm_per_rev / FULL_STEPS).log2().round().clamp(0.0, 8.0).exp2()
}

/// A motor, what it moves, and its microsteps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// The torque in microsteps, N m.
    torque_nm: f64,
    /// All that it turns and moves, as an inertia at its shaft, kg m².
    inertia_kg_m2: f64,
    corner_rev_s: f64,
    mm_per_rev: f64,
    microsteps: f64,
}

impl Drive {
    /// The drive of an axis with `steps_per_mm`.
    pub fn new(motor: MotorData, load: Load, steps_per_mm: f64) -> Self {
        let reflected_kg_m2 = load.mass_kg * (load.mm_per_rev * 1e-3 / TAU).powi(2);
        Self {
            torque_nm: motor.holding_nm * FRAC_1_SQRT_2,
            inertia_kg_m2: motor.rotor_g_cm2 * 1e-7 + load.turning_kg_m2 + reflected_kg_m2,
            corner_rev_s: motor.corner_rev_s,
            mm_per_rev: load.mm_per_rev,
            microsteps: steps_per_mm * load.mm_per_rev / FULL_STEPS,
        }
    }

    /// True if it follows any edge.
    pub(crate) fn is_rigid(&self) -> bool {
        self.torque_nm.is_infinite()
    }

    /// Microsteps per full step.
    pub fn microsteps(&self) -> f64 {
        self.microsteps
    }

    /// Travel per revolution, mm.
    pub fn mm_per_rev(&self) -> f64 {
        self.mm_per_rev
    }

    /// All that it turns and moves, as an inertia at its shaft, kg m².
    pub fn inertia_kg_m2(&self) -> f64 {
        self.inertia_kg_m2
    }

    /// The speed up to which the torque is whole, full steps/s.
    pub(crate) fn corner_full_s(&self) -> f64 {
        self.corner_rev_s * FULL_STEPS
    }

    /// The acceleration by the whole torque, full steps/s².
    pub(crate) fn pull_full_s2(&self) -> f64 {
        self.torque_nm / self.inertia_kg_m2 * FULL_STEPS / TAU
    }

    /// The deceleration by friction, full steps/s².
    pub(crate) fn friction_full_s2(&self) -> f64 {
        FRICTION * self.pull_full_s2()
    }

    /// The deceleration by drag per speed, 1/s.
    pub(crate) fn drag_per_s(&self) -> f64 {
        self.drag_nm_s() / self.inertia_kg_m2
    }

    /// Its natural frequency about a place in phase, rad/s.
    pub(crate) fn natural_rad_s(&self) -> f64 {
        (self.torque_nm * POLE_PAIRS / self.inertia_kg_m2).sqrt()
    }

    /// The torque at this speed, N m.
    fn torque_at_nm(&self, rev_s: f64) -> f64 {
        self.torque_nm * (self.corner_rev_s / rev_s).min(1.0)
    }

    /// The drag is what leaves no torque at a multiple of the corner speed.
    fn drag_nm_s(&self) -> f64 {
        let gone_rev_s = GONE_CORNERS * self.corner_rev_s;
        (self.torque_at_nm(gone_rev_s) - FRICTION * self.torque_nm) / (gone_rev_s * TAU)
    }

    /// Friction and drag at this speed, N m.
    fn load_nm(&self, rev_s: f64) -> f64 {
        FRICTION * self.torque_nm + self.drag_nm_s() * rev_s * TAU
    }

    /// The acceleration by this torque, mm/s².
    fn by_torque_mm_s2(&self, nm: f64) -> f64 {
        nm / self.inertia_kg_m2 * self.mm_per_rev / TAU
    }

    /// The acceleration that it takes at this speed however it comes, mm/s²; negative where no torque is left.
    ///
    /// If an acceleration begins at once, as in a trapezoid, the rotor swings beyond the lag that it needs, so that it
    /// may ask for 72 % of the torque only.
    pub fn accel_mm_s2(&self, speed_mm_s: f64) -> f64 {
        let rev_s = speed_mm_s / self.mm_per_rev;
        self.by_torque_mm_s2(SUDDEN * self.torque_at_nm(rev_s) - self.load_nm(rev_s))
    }

    /// The acceleration at which it pulls out at this speed, however gently it comes, mm/s².
    pub fn spare_mm_s2(&self, speed_mm_s: f64) -> f64 {
        let rev_s = speed_mm_s / self.mm_per_rev;
        self.by_torque_mm_s2(self.torque_at_nm(rev_s) - self.load_nm(rev_s))
    }

    /// The speed from which it starts at once, and by which its speed may jump, mm/s.
    ///
    /// The field runs ahead of the rotor by the jump; what moves then must be less than the spring takes up to where it
    /// yields: ½ δ̇² = ω₀² (1 + √(1 - x²) - x (π - asin x)), with the load's share x of the torque.
    pub fn jump_mm_s(&self) -> f64 {
        if self.is_rigid() {
            return f64::INFINITY;
        }
        let jump_mm_s = |share: f64| {
            let work = 1.0 + (1.0 - share * share).sqrt() - share * (PI - share.asin());
            let electrical_rad_s = self.natural_rad_s() * (2.0 * work.max(0.0)).sqrt();
            electrical_rad_s / (POLE_PAIRS * TAU) * self.mm_per_rev
        };
        // On the way the rotor turns at half the speed in the mean.
        let rev_s = jump_mm_s(FRICTION) / 2.0 / self.mm_per_rev;
        jump_mm_s(self.load_nm(rev_s) / self.torque_nm)
    }

    /// The speed at which it has half the acceleration of standstill, mm/s: a top speed with a margin.
    pub fn top_mm_s(&self) -> f64 {
        let (mut low, mut high) = (0.0, GONE_CORNERS * self.corner_rev_s * self.mm_per_rev);
        for _ in 0..60 {
            let middle = (low + high) / 2.0;
            let is_below = self.accel_mm_s2(middle) > self.accel_mm_s2(0.0) / 2.0;
            *(if is_below { &mut low } else { &mut high }) = middle;
        }
        low
    }

    /// The speed at which no torque is left, mm/s.
    pub fn gone_mm_s(&self) -> f64 {
        GONE_CORNERS * self.corner_rev_s * self.mm_per_rev
    }
}
