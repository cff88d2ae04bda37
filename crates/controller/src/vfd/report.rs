//! How a VFD is, in words: news, refusals, and `$VFD`.

use core::fmt;

use isostep_console::{Fixed, Settings};

use super::types::Type;
use super::{Vfd, VfdKnown};
use crate::output::Message;

/// The health of a VFD.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VfdHealth {
    /// It has not been asked yet.
    Unknown,
    /// It does what it has to.
    Well,
    /// It does not answer.
    Silent,
    /// Its replies are disturbed.
    Garbled,
    /// Another device answers, or something else than was asked for.
    Other,
    /// It refuses what it is asked, with this exception.
    Refused(u8),
    /// It reports this fault.
    Tripped(u16),
    /// The spindle has not reached its speed in time.
    Late,
    /// The spindle has left its speed.
    Deviates,
    /// The spindle turns and is to stand.
    Runs,
}

impl VfdHealth {
    /// True if nobody has to be told when it is over.
    pub fn is_quiet(self) -> bool {
        self == Self::Unknown || self.is_of_speed()
    }

    /// True if it is about the spindle's speed, not about the VFD.
    pub fn is_of_speed(self) -> bool {
        matches!(self, Self::Late | Self::Deviates | Self::Runs)
    }
}

/// The words for a VFD with these settings: what is wrong with it, by which register, and the remedy.
struct VfdWords<'s>(VfdKnown, &'s Settings);

impl fmt::Display for VfdWords<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(VfdKnown { health, register, rpm, wanted_rpm, .. }, settings) = self;
        let whole = |value: f32| Fixed { value, decimals: 0 };
        let (rpm, wanted_rpm, address) = (whole(*rpm), whole(*wanted_rpm), settings.vfd_address);
        match health {
            VfdHealth::Unknown => f.write_str("the VFD has not been asked yet: try again"),
            VfdHealth::Well => f.write_str("the VFD is well"),
            VfdHealth::Silent => write!(
                f,
                "the VFD does not answer at address {address} (register {register:#06x}): switch it on, check A and B of its \
                 cable, its address ($476), baud rate ($374) and parity ($681)"
            ),
            VfdHealth::Garbled => write!(
                f,
                "replies of the VFD are garbled (register {register:#06x}): check its baud rate ($374), parity ($681), the shield \
                 of its cable, and ground"
            ),
            VfdHealth::Other => write!(
                f,
                "something else answers than address {address} (register {register:#06x}): give each device an address of its \
                 own, and raise $375 if the VFD is slow"
            ),
            VfdHealth::Refused(exception) => write!(
                f,
                "the VFD refuses register {register:#06x} with exception {exception}: choose its type ($395), and have it take \
                 run and frequency from RS-485"
            ),
            VfdHealth::Tripped(fault) => write!(
                f,
                "the VFD reports fault {fault} in register {register:#06x}: mend it by its manual, and reset the VFD"
            ),
            VfdHealth::Late => write!(
                f,
                "the spindle turns at {rpm} rpm (register {register:#06x}) and should have reached {wanted_rpm} rpm: correct S \
                 or $461, or raise $394"
            ),
            VfdHealth::Deviates => write!(
                f,
                "the spindle turns at {rpm} rpm (register {register:#06x}), not at {wanted_rpm} rpm within {} %: lower feed or \
                 depth, or raise $340",
                Fixed { value: settings.at_speed_percent, decimals: 1 }
            ),
            VfdHealth::Runs => write!(
                f,
                "the spindle turns at {rpm} rpm (register {register:#06x}) and is to stand: stop it at the VFD, which has to take \
                 run from RS-485 alone, or raise $394"
            ),
        }
    }
}

impl Vfd {
    /// Says how it is.
    pub fn say(&self, settings: &Settings, text: &mut Message) {
        text.say(VfdWords(self.known.get(), settings));
    }

    /// Says why it has locked the machine.
    pub fn say_failed(&self, settings: &Settings, text: &mut Message) {
        text.say(VfdWords(self.failed.get().unwrap_or(self.known.get()), settings));
    }

    /// Says after the welcome what is wrong with it, if so.
    pub fn say_trouble(&self, settings: &Settings, text: &mut Message) {
        if settings.spindle_type != self.served.get() {
            text.say(NOT_YET);
        } else if self.is_served() && !matches!(self.known.get().health, VfdHealth::Unknown | VfdHealth::Well) {
            self.say(settings, text);
        }
    }

    /// True if the spindle may turn, with a message if not.
    pub fn may_turn(&self, settings: &Settings, text: &mut Message) -> bool {
        match self.known.get().health {
            _ if settings.laser_mode => return true,
            _ if settings.spindle_type != self.served.get() => text.say(NOT_YET),
            _ if !self.is_served() => return true,
            VfdHealth::Well => return true,
            // By the next order it may do better.
            health if health.is_of_speed() => return true,
            _ => self.say(settings, text),
        }
        false
    }

    /// `$VFD`: how it is, what the spindle does, how often it was asked, and why it has locked the machine last.
    pub fn show(&self, settings: &Settings, text: &mut Message) {
        if !self.is_served() {
            text.say("no VFD is served: $395 chooses its type, and switching the board off and on puts that in force");
            return;
        }
        let VfdKnown { rpm, amperes, .. } = self.known.get();
        let name = Type::of(self.served.get(), settings).name;
        self.say(settings, text);
        text.say(format_args!(
            "VFD {name} at address {}: {} rpm, {}, asked {} times, {} times again",
            settings.vfd_address,
            Fixed { value: rpm, decimals: 0 },
            Amperes(amperes),
            self.exchanges.get(),
            self.repeats.get()
        ));
    }

    /// The rest of it, which is another message.
    pub fn show_failed(&self, settings: &Settings, text: &mut Message) {
        if let Some(failed) = self.failed.get() {
            text.say(format_args!("the last alarm of the VFD: {}", VfdWords(failed, settings)));
        }
    }
}

const NOT_YET: &str =
    "what turns the spindle ($395) changes when a board with a wire to the VFD is switched off and on: do that first";

/// A current, if it is known.
struct Amperes(Option<f32>);

impl fmt::Display for Amperes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(value) => write!(f, "{} A", Fixed { value, decimals: 2 }),
            None => f.write_str("current not reported"),
        }
    }
}
