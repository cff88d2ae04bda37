//! The health of a driver, by its reports, and the remedy.

use tmc2209::reg::DRV_STATUS;

use super::exchange::Failure;

/// The health of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Health {
    /// It has not been asked yet.
    Unknown,
    /// It does what it has to.
    Well,
    /// It warns of its temperature.
    Hot,
    /// A coil of its motor seems open.
    OpenCoil,
    /// It has stopped the machine by its output, and reports nothing else.
    Stalled,
    /// It does not answer.
    Silent,
    /// It answers, and does not take what it is set to.
    NotTaken,
    /// It had lost its supply, and so its settings and its place between two full steps.
    Restarted,
    /// Its supply is too low, and its motor off.
    Undervoltage,
    /// It was too hot, and has switched its motor off.
    Overheated,
    /// It has found a short, and has switched its motor off.
    Shorted,
}

impl Health {
    /// The health by the flags of a driver that has failed since it was asked last, if so, or has too little voltage (`is_low`),
    /// without those of open coils: these are true only of a moving motor.
    pub fn judge(failed: Option<Self>, is_low: bool, status: &DRV_STATUS) -> Self {
        if is_shorted(status) {
            Self::Shorted
        } else if status.ot() {
            Self::Overheated
        } else if is_low {
            Self::Undervoltage
        } else if let Some(failed) = failed {
            failed
        } else if status.otpw() {
            Self::Hot
        } else {
            Self::Well
        }
    }

    /// The motor may not be where its steps say, so the machine must stop.
    pub fn stops(self) -> bool {
        !matches!(self, Self::Unknown | Self::Well | Self::Hot | Self::OpenCoil | Self::Stalled)
    }

    /// Its words for a report, and the remedy.
    pub fn words(self) -> (&'static str, &'static str) {
        match self {
            Self::Unknown => ("not asked yet", ""),
            Self::Well => ("well", ""),
            Self::Hot => ("hot", "cool it, or lower its current ($140-$142)"),
            Self::OpenCoil => ("sees an open coil", "switch the supply off, check the motor's plug and cable"),
            Self::Stalled => (
                "has reported a stall of its motor",
                "free it, or lower $120-$122 or $200-$202; $909 says which axes are watched",
            ),
            Self::Silent => {
                ("does not answer", "switch the motors' supply on, check the board; $338 leaves an axis out")
            }
            Self::NotTaken => ("does not take its settings", "switch the motors' supply off and on"),
            Self::Restarted => ("had lost its supply, and was set again", "check the motors' supply"),
            Self::Undervoltage => ("has too little voltage, its motor is off", "check the motors' supply"),
            Self::Overheated => ("was too hot, its motor was off", "cool it, or lower its current ($140-$142)"),
            Self::Shorted => ("has found a short, its motor is off", "switch the supply off, check motor and cable"),
        }
    }
}

/// True if a driver keeps its motor off.
pub fn is_off(status: &DRV_STATUS) -> bool {
    is_shorted(status) || status.ot()
}

/// True if it does so because of a short, which it keeps until it is switched off.
pub fn is_shorted(status: &DRV_STATUS) -> bool {
    status.s2ga() || status.s2gb() || status.s2vsa() || status.s2vsb()
}

impl From<Failure> for Health {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Silent => Self::Silent,
            Failure::NotTaken => Self::NotTaken,
        }
    }
}
