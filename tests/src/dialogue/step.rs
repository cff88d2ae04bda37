//! One step of a dialogue, and how it is written.

use isostep_motion::{AXES, Axis, Contact, Motor};
use isostep_sim::drive::MotorData;
use isostep_sim::drivers::DriverFault;
use isostep_sim::faults::Fault;
use isostep_sim::plate::Plate;
use isostep_sim::tool::ToolOutput;
use isostep_sim::vfd::{VfdFault, VfdKind};
use isostep_sim::world::Wire;
use isostep_sim::{Board, Config, Port, SwitchFault};

use super::pattern::Numbers;

/// The wait after something was sent: what the machine may do in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wait {
    /// Nothing.
    None,
    /// To run for a time, ns.
    For(u64),
    /// To come to rest.
    Idle,
}

/// When an output has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// As soon as it was looked at.
    AtOnce,
    /// When a move had ended, counted from 1, without those of homing.
    WithMove(usize),
    /// At most 25 ms after the last step.
    AtStandstill,
}

/// The beginning of a machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// A new one, 50 ms after power-up.
    SwitchedOn,
    /// As that, and its welcome is heard.
    PoweredUp,
    /// As that, and then homed.
    Homed,
    /// The same one, after a loss of power.
    PowerCycle,
}

/// One step.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// The nature of the next machine.
    With(With),
    /// Another machine.
    Begin(Begin),
    /// Bytes for a console.
    Send { console: usize, bytes: Vec<u8>, wait: Wait },
    /// Time.
    Wait(Wait),
    /// A line that a console must have heard.
    Heard { console: usize, line: String },
    /// Nothing must have been heard.
    Silence,
    /// A status report and its parts.
    Report(Vec<String>),
    /// To run until something is heard, by milliseconds.
    UntilHeard,
    /// The machine's state, also the parts of it that no report tells.
    State(String),
    /// To run until the machine is in a state.
    Until(String),
    /// To run until an output of the tool is on, or off.
    UntilOutput(usize, bool),
    /// The time since the last step, in a unit of so many ns.
    Rested(Numbers, u64),
    /// A command of the emulated board.
    Emulator(String),
    /// A figure of the emulated board's summary, by its path, and what it must be.
    Figure(String, String),
    /// The accessories in the report that has the overrides.
    Accessories(String),
    /// A line that is refused with this error, and changes nothing.
    Unchanged { error: String, line: Vec<u8> },
    /// The steps since power-up or homing.
    Steps(Vec<Numbers>),
    /// The places of the carriages, steps from their switches.
    Places(Vec<Numbers>),
    /// They stand where they stood at the note.
    PlacesAsNoted,
    /// Remembers the steps and the time.
    Note,
    /// The steps since the note.
    Moved(Vec<Numbers>),
    /// No step was made since the note, in no direction.
    NoStepMade,
    /// The position that is reported is that of the steps.
    CountsAgree,
    /// No step was lost.
    NoStepLost,
    /// No edge was against the drivers' timing.
    NoViolation,
    /// The time since the note, in a unit of so many ns.
    Took(Numbers, u64),
    /// The number of moves that have begun, those of homing not counted.
    Moves(Numbers),
    /// The axes that have been homed, in order.
    Homings(String),
    /// The axes whose position is trusted.
    Trusted([bool; AXES]),
    /// The outputs of the tool.
    Tool([u16; 5]),
    /// One of the outputs of the tool, give or take so much.
    Output { index: usize, duty: u16, tolerance: u16 },
    /// No output of the tool has been on since power-up.
    ToolNeverOn,
    /// To run for a time, ns, and remember each change of the outputs.
    Watch(u64),
    /// The next change that was seen.
    Changed([u16; 5], Option<When>),
    /// True if the motors are energised.
    Motors(bool),
    /// A limit switch.
    Switch(Motor, SwitchFault),
    /// Something that a hand presses, bouncing or not.
    Press { wire: Wire, pressed: bool, bounces: bool },
    /// The wire of the emergency stop.
    Cut(bool),
    /// The plate that the probe touches.
    Plate(Option<PlatePlace>),
    /// Something that is wrong with a drive that closes its own loop.
    Drive(Motor, bool),
    /// The wire of its alarm.
    CutAlarm(Axis, bool),
    /// The fault of a UART driver.
    Driver(Motor, Option<DriverFault>),
    /// The setup of a UART driver.
    DriverIs(usize, Vec<String>),
    /// The fault of a VFD.
    Vfd(Option<VfdFault>),
    /// The output frequency of a VFD, Hz, within a hundredth; it drives its motor if that is not 0.
    VfdTurns(f64),
    /// Something that goes wrong, as `isostep sim --fault` has it.
    Fault(Fault),
    /// The host opens the console.
    Open,
    /// The flash refuses, or works again.
    FlashRefuses(bool),
    /// The board has seen the emergency stop pressed or released.
    StopSeen(bool),
    /// The board has cut the tool off.
    CutOff,
    /// The board has seen a reset byte that no console has read yet.
    ResetHeard,
}

/// The nature of a machine at power-up.
#[derive(Clone, Debug, PartialEq)]
pub enum With {
    /// A setting.
    Setting(u16, f32),
    /// The places of its carriages, mm.
    Start(Vec<f64>),
    /// Its step ports.
    Port(Port),
    /// A board whose drivers have a UART.
    SkrPico,
    /// An emergency stop that opens.
    NormallyClosed,
    /// A second console.
    SecondConsole,
    /// The baud rate of its consoles.
    Baud(u32),
    /// The time that its switches bounce, us.
    BounceUs(u32),
    /// A fault of a switch.
    Switch(Axis, SwitchFault),
    /// A plate.
    Plate(PlatePlace),
    /// The axes whose limit input is wired to their driver.
    Jumpers([bool; AXES]),
    /// A VFD.
    Vfd(VfdKind),
    /// A fault from the start.
    Fault(Fault),
    /// The variation of its motors' load, as a fraction of what would stall them.
    LoadNoise(f64),
    /// A button that is pressed, or an open door.
    Pressed(Wire),
    /// An option of the emulated board.
    Emulator(String),
    /// The emulated board's image for four axes.
    FourAxes,
    /// Drives that close their own loop.
    ClosedLoop,
    /// One wire for the alarms of all drives.
    OneAlarmWire,
    /// A frame between two motors that never binds.
    LooseFrame,
    /// Motors that follow any edge.
    RigidMotors,
}

impl With {
    fn read(text: &str) -> Result<Self, String> {
        if let Some((number, value)) = text.strip_prefix('$').and_then(|text| text.split_once('=')) {
            let setting = number.parse().ok().zip(value.parse().ok());
            let known = setting.filter(|&(number, value)| Config::default().settings.set(number, value));
            let (number, value) = known.ok_or_else(|| format!("`{text}` is no setting: write one as $110=2880"))?;
            return Ok(Self::Setting(number, value));
        }
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        Ok(match (word, rest) {
            ("start", "pressed") => Self::Pressed(Wire::Start),
            ("start", _) => {
                let mm: Option<Vec<f64>> = rest.split(' ').map(|mm| mm.parse().ok()).collect();
                let mm = mm.filter(|mm| mm.len() >= AXES.min(3));
                Self::Start(mm.ok_or_else(|| format!("`{rest}` is no place: write mm for each of the {AXES} axes"))?)
            }
            ("port", "timer") => Self::Port(Port::Timer),
            ("port", "pio") => Self::Port(Port::Pio),
            ("board", "skr-pico") => Self::SkrPico,
            ("emergency", "stop normally closed") => Self::NormallyClosed,
            ("second", "console") => Self::SecondConsole,
            ("baud", _) => Self::Baud(number(rest)?),
            ("bounce", _) => Self::BounceUs(number(rest.strip_suffix(" us").unwrap_or(rest))?),
            ("switch", _) => {
                let (motor, fault) = switch(rest)?;
                Self::Switch(motor.axis, fault)
            }
            ("plate", _) => Self::Plate(PlatePlace::read(rest)?),
            ("jumpers", _) => Self::Jumpers(axes(rest)),
            ("vfd", _) => {
                let kind = VfdKind::ALL.into_iter().find(|kind| kind.to_string() == rest);
                Self::Vfd(kind.ok_or_else(|| format!("`{rest}` is no VFD: use {:?}", VfdKind::ALL))?)
            }
            ("fault", _) => Self::Fault(fault(rest)?),
            ("load", _) => Self::LoadNoise(number(rest.strip_prefix("noise ").unwrap_or(rest))?),
            ("hold", "pressed") => Self::Pressed(Wire::Hold),
            ("emulator", _) => Self::Emulator(rest.to_owned()),
            ("four", "axes") => Self::FourAxes,
            ("closed", "loop") => Self::ClosedLoop,
            ("one", "alarm wire") => Self::OneAlarmWire,
            ("loose", "frame") => Self::LooseFrame,
            ("rigid", "motors") => Self::RigidMotors,
            _ => {
                return Err(format!(
                    "`{text}` is nothing a machine can have: use $n=v, start, port, board, emergency stop normally closed, \
                     second console, baud, bounce, switch, plate, jumpers, load noise, vfd, fault, hold pressed, start pressed, \
                     closed loop, one alarm wire, loose frame, rigid motors, four axes or emulator"
                ));
            }
        })
    }

    /// Gives it to a simulated machine.
    pub fn change(&self, config: &mut Config) -> Result<(), String> {
        match *self {
            Self::Emulator(_) | Self::FourAxes => return Err("only the emulated board has this".to_owned()),
            Self::Setting(number, value) => assert!(config.settings.set(number, value), "it was read"),
            Self::Start(ref start_mm) => {
                config.start_mm[..start_mm.len().min(AXES)].copy_from_slice(&start_mm[..start_mm.len().min(AXES)])
            }
            Self::Port(port) => config.port = port,
            Self::SkrPico => (config.board, config.driver) = (Board::SkrPico, Board::SkrPico.driver()),
            Self::ClosedLoop => config.closed_loop = true,
            Self::OneAlarmWire => config.one_alarm_wire = true,
            Self::LooseFrame => config.gantry.binds_mm = 1_000.0,
            Self::RigidMotors => config.motor = MotorData::RIGID,
            Self::NormallyClosed => config.emergency_contact = Contact::NormallyClosed,
            Self::SecondConsole => config.second_console = true,
            Self::Baud(baud) => config.baud = Some(baud),
            Self::BounceUs(bounce_us) => config.bounce_us = bounce_us,
            Self::Jumpers(diag) => config.diag = diag,
            Self::LoadNoise(noise) => config.load_noise = noise,
            Self::Vfd(kind) => config.vfd = Some(kind),
            Self::Fault(fault) => config.faults.push(fault),
            // A hand is no part of the configuration.
            Self::Pressed(_) => {}
            Self::Switch(axis, fault) => config.switches[axis as usize] = fault,
            Self::Plate(place) => config.plate = place.plate(),
        }
        Ok(())
    }
}

/// So many mm above the switch of Z, which a machine of two axes has not; the probe comes from above, or from below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlatePlace {
    place_mm: f64,
    /// The probe comes from above.
    is_below: bool,
}

impl PlatePlace {
    fn read(text: &str) -> Result<Self, String> {
        let (place, is_below) = text.strip_suffix(" below").map_or((text, false), |place| (place, true));
        Ok(Self { place_mm: number(place)?, is_below })
    }

    pub fn plate(self) -> Option<Plate> {
        let axis = isostep_sim::Axis::ALL.get(2).copied()?;
        Some(Plate { axis, place_mm: self.place_mm, is_below: self.is_below })
    }
}

impl std::fmt::Display for PlatePlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Z,{},{}", self.place_mm, if self.is_below { "below" } else { "above" })
    }
}

fn number<T: std::str::FromStr>(text: &str) -> Result<T, String> {
    text.parse().map_err(|_| format!("`{text}` is no number: write one"))
}

/// A time, ns.
fn time(text: &str) -> Result<u64, String> {
    let (value, unit_ns) = text
        .split_once(' ')
        .and_then(|(value, unit)| Some((value.parse::<f64>().ok()?, unit_of(unit)?)))
        .ok_or_else(|| format!("`{text}` is no time: write one as `0.5 s`, `20 ms` or `87 us`"))?;
    Ok((value * unit_ns as f64).round() as u64)
}

/// Any of several times, and their unit, ns.
fn times(text: &str) -> Result<(Numbers, u64), String> {
    let read = text.split_once(' ').and_then(|(value, unit)| Some((Numbers::read(value)?, unit_of(unit)?)));
    read.ok_or_else(|| format!("`{text}` is no time: write one as `2000..2004 ms`"))
}

/// A unit, ns.
fn unit_of(name: &str) -> Option<u64> {
    match name {
        "s" => Some(1_000_000_000),
        "ms" => Some(1_000_000),
        "us" => Some(1_000),
        _ => None,
    }
}

fn axes(text: &str) -> [bool; AXES] {
    Axis::ALL.map(|axis| text.split(' ').any(|word| word == axis.to_string()))
}

fn fault(text: &str) -> Result<Fault, String> {
    text.parse().map_err(|error| format!("`{text}`: {error}"))
}

fn motors() -> impl Iterator<Item = Motor> {
    Axis::ALL.into_iter().flat_map(|axis| [Motor::first(axis), Motor::second(axis)])
}

fn motor(name: &str) -> Result<Motor, String> {
    let motor = motors().find(|motor| motor.to_string() == name);
    motor.ok_or_else(|| format!("`{name}` is no motor: use an axis, or Y2 for a second motor"))
}

fn output(name: &str) -> Option<usize> {
    ToolOutput::ALL.iter().position(|output| output.to_string() == name)
}

fn numbers(text: &str) -> Result<Vec<Numbers>, String> {
    let each = |word: &str| Numbers::read(word).ok_or_else(|| format!("`{word}` is no number: write one, or `5..7`"));
    let numbers = text.split(' ').map(each).collect::<Result<Vec<_>, _>>()?;
    // Other images have a fourth axis, and those that are not named are at 0.
    if numbers.len() < AXES.min(3) || numbers.len() > 4 {
        return Err(format!("`{text}` has {} numbers: write one for each of the {AXES} axes", numbers.len()));
    }
    Ok(numbers)
}

fn switch(text: &str) -> Result<(Motor, SwitchFault), String> {
    let (name, state) =
        text.split_once(' ').ok_or_else(|| format!("`{text}`: which switch, and closed, open or normal?"))?;
    let motor = motor(name)?;
    let fault = match state {
        "closed" => SwitchFault::StuckClosed,
        "open" => SwitchFault::StuckOpen,
        "normal" => SwitchFault::None,
        _ => return Err(format!("`{state}` is no state of a switch: use closed, open or normal")),
    };
    Ok((motor, fault))
}

/// The outputs, at the full duty or at percents of it.
fn tool(text: &str) -> Result<[u16; 5], String> {
    let mut duties = [0; 5];
    for word in text.split(' ').filter(|&word| word != "off") {
        let (name, percent) = word.trim_end_matches('%').split_once('=').unwrap_or((word, "100"));
        let index = output(name)
            .ok_or_else(|| format!("`{word}` is no output: use off, pwm, pwm=50%, enable, direction, flood, mist"))?;
        duties[index] = (number::<f64>(percent)? / 100.0 * f64::from(u16::MAX)).round() as u16;
    }
    Ok(duties)
}

fn one_output(text: &str) -> Result<Step, String> {
    let known = text.split_once(' ').and_then(|(name, duty)| Some((output(name)?, duty)));
    let (index, duty) = known.ok_or_else(|| format!("`{text}` is no output: write one as `enable on` or `pwm 50%`"))?;
    let (tolerance, duty) = duty.strip_prefix('~').map_or((0, duty), |duty| (1, duty));
    let percent = match duty {
        "on" => "100",
        "off" => "0",
        duty => duty,
    };
    Ok(Step::Output { index, duty: tool(&format!("pwm={percent}"))?[0], tolerance })
}

fn changed(text: &str) -> Result<Step, String> {
    let (text, when) = if let Some(text) = text.strip_suffix(" at once") {
        (text, Some(When::AtOnce))
    } else if let Some(text) = text.strip_suffix(" at standstill") {
        (text, Some(When::AtStandstill))
    } else if let Some((text, count)) = text.split_once(" with move ") {
        (text, Some(When::WithMove(number(count)?)))
    } else {
        (text, None)
    };
    Ok(Step::Changed(tool(text)?, when))
}

/// Something that is wrong with a drive, or the wire of its alarm.
fn drive(text: &str) -> Result<Step, String> {
    let (name, state) = text.split_once(' ').unwrap_or((text, ""));
    let motor = motor(name)?;
    match state {
        "alarms" => Ok(Step::Drive(motor, true)),
        "well" => Ok(Step::Drive(motor, false)),
        "wire cut" => Ok(Step::CutAlarm(motor.axis, true)),
        "wire mended" => Ok(Step::CutAlarm(motor.axis, false)),
        _ => Err(format!("`{state}` is nothing that a drive can have: use alarms, well, wire cut or wire mended")),
    }
}

/// The fault of a driver, or its setup.
fn driver(text: &str) -> Result<Step, String> {
    let (name, rest) = text.split_once(' ').unwrap_or((text, ""));
    let motor = motor(name)?;
    if let Some(words) = rest.strip_prefix("is ") {
        let driver = if motor == Motor::from(motor.axis) { motor.axis as usize } else { AXES };
        return Ok(Step::DriverIs(driver, words.split(' ').map(str::to_owned).collect()));
    }
    let fault = DriverFault::ALL.into_iter().find(|fault| fault.to_string() == rest);
    if fault.is_none() && rest != "well" {
        let known = DriverFault::ALL.map(|fault| fault.to_string()).join(", ");
        return Err(format!("`{rest}` is nothing that a driver can have: use well, {known}, or `is 16-microsteps`"));
    }
    Ok(Step::Driver(motor, fault))
}

/// The fault of a VFD, or how it turns.
fn vfd(text: &str) -> Result<Step, String> {
    if let Some(hz) = text.strip_prefix("turns ").and_then(|hz| hz.strip_suffix(" Hz")) {
        return number(hz).map(Step::VfdTurns);
    }
    let fault = VfdFault::ALL.into_iter().find(|fault| fault.to_string() == text);
    if fault.is_none() && text != "well" {
        let known = VfdFault::ALL.map(|fault| fault.to_string()).join(", ");
        return Err(format!("`{text}` is nothing that a VFD can have: use well, {known}, or `turns 200 Hz`"));
    }
    Ok(Step::Vfd(fault))
}

fn press(word: &str, rest: &str) -> Result<Step, String> {
    let wire = match word {
        "probe" => Wire::Probe,
        "hold" => Wire::Hold,
        "start" => Wire::Start,
        _ => Wire::EmergencyStop,
    };
    let (state, bounces) = rest.strip_suffix(", bouncing").map_or((rest, false), |state| (state, true));
    match state {
        "pressed" => Ok(Step::Press { wire, pressed: true, bounces }),
        "released" => Ok(Step::Press { wire, pressed: false, bounces }),
        "wire cut" if wire == Wire::EmergencyStop => Ok(Step::Cut(true)),
        "wire mended" if wire == Wire::EmergencyStop => Ok(Step::Cut(false)),
        _ => Err(format!("`{rest}`: use pressed or released, and `, bouncing` where its contacts do")),
    }
}

/// The bytes of a text in which `\x18` stands for a byte, and `{100 X}` for a hundred times X.
fn bytes(text: &str) -> Result<Vec<u8>, String> {
    if let Some((before, behind)) = text.split_once('{') {
        let repeated = behind.split_once('}').and_then(|(inside, behind)| Some((inside.split_once(' ')?, behind)));
        let counted = repeated.and_then(|((count, what), behind)| Some((count.parse().ok()?, what, behind)));
        let (count, what, behind) =
            counted.ok_or_else(|| format!("`{{{behind}` is nothing repeated: write it as `{{100 X}}`"))?;
        return Ok([bytes(before)?, bytes(what)?.repeat(count), bytes(behind)?].concat());
    }
    let mut parts = text.split("\\x");
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let byte = part.get(..2).and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(byte.ok_or_else(|| format!("`\\x{part}` is no byte: write one as `\\x18`"))?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    Ok(bytes)
}

fn exchange(console: usize, sign: &str, rest: &str) -> Result<Step, String> {
    let line = || Ok::<_, String>([bytes(rest)?, b"\n".to_vec()].concat());
    let send = |bytes, wait| Ok(Step::Send { console, bytes, wait });
    match sign {
        ">" => send(line()?, Wait::Idle),
        ">>" => send(line()?, Wait::None),
        "!" => send(bytes(rest)?, Wait::For(1_000_000)),
        "!!" => send(bytes(rest)?, Wait::None),
        _ => Ok(Step::Heard { console, line: rest.to_owned() }),
    }
}

impl Step {
    /// Reads a line.
    pub fn read(text: &str) -> Result<Self, String> {
        let (word, rest) = text.split_once(' ').unwrap_or((text, ""));
        Ok(match (word, rest) {
            (">" | ">>" | "!" | "!!" | "<", _) => exchange(0, word, rest)?,
            ("2>" | "2>>" | "2!" | "2!!" | "2<", _) => exchange(1, &word[1..], rest)?,
            ("with", _) => Self::With(With::read(rest)?),
            ("switched", "on") => Self::Begin(Begin::SwitchedOn),
            ("powered", "up") => Self::Begin(Begin::PoweredUp),
            ("homed", "") => Self::Begin(Begin::Homed),
            ("power", "off and on") => Self::Begin(Begin::PowerCycle),
            ("wait", _) => Self::Wait(Wait::For(time(rest)?)),
            ("until", "idle") => Self::Wait(Wait::Idle),
            ("until", "heard") => Self::UntilHeard,
            ("until", _) if rest.starts_with("output ") => match one_output(&rest[7..])? {
                Self::Output { index, duty, .. } => Self::UntilOutput(index, duty > 0),
                other => other,
            },
            ("until", _) => Self::Until(rest.to_owned()),
            ("state", _) => Self::State(rest.to_owned()),
            ("accessories", _) => Self::Accessories(rest.to_owned()),
            ("silence", "") => Self::Silence,
            ("report", "") => {
                return Err("a report of nothing: write what it must have, as `report Idle FS:0,0`".to_owned());
            }
            ("report", _) => Self::Report(rest.split(' ').map(str::to_owned).collect()),
            ("unchanged", _) => {
                let (error, line) = rest.split_once(' ').unwrap_or((rest, ""));
                Self::Unchanged { error: error.to_owned(), line: bytes(line)? }
            }
            ("steps", _) => Self::Steps(numbers(rest)?),
            ("places", "as noted") => Self::PlacesAsNoted,
            ("places", _) => Self::Places(numbers(rest)?),
            ("note", "") => Self::Note,
            ("no", "step made") => Self::NoStepMade,
            ("no", "step lost") => Self::NoStepLost,
            ("no", "violation") => Self::NoViolation,
            ("counts", "agree") => Self::CountsAgree,
            ("moved", _) => Self::Moved(numbers(rest)?),
            ("took", _) => times(rest).map(|(numbers, unit_ns)| Self::Took(numbers, unit_ns))?,
            ("rested", _) => times(rest).map(|(numbers, unit_ns)| Self::Rested(numbers, unit_ns))?,
            ("moves", _) => {
                Self::Moves(Numbers::read(rest).ok_or_else(|| format!("`{rest}` is no number: write one"))?)
            }
            ("homed", _) => Self::Homings(rest.to_owned()),
            ("trusted", _) => Self::Trusted(axes(rest)),
            ("tool", "never on") => Self::ToolNeverOn,
            ("tool", _) => Self::Tool(tool(rest)?),
            ("output", _) => one_output(rest)?,
            ("watch", _) => Self::Watch(time(rest)?),
            ("changed", _) => changed(rest)?,
            ("drive", _) => drive(rest)?,
            ("driver", _) => driver(rest)?,
            ("vfd", _) => vfd(rest)?,
            ("fault", _) => Self::Fault(fault(rest)?),
            ("motors", "on" | "off") => Self::Motors(rest == "on"),
            ("switch", _) => {
                let (motor, fault) = switch(rest)?;
                Self::Switch(motor, fault)
            }
            ("emergency", _) => press(word, rest.strip_prefix("stop ").unwrap_or(rest))?,
            ("probe" | "hold" | "start", _) => press(word, rest)?,
            ("plate", "none") => Self::Plate(None),
            ("plate", _) => Self::Plate(Some(PlatePlace::read(rest)?)),
            ("emulator", _) => Self::Emulator(rest.to_owned()),
            ("figure", _) => {
                let (path, value) =
                    rest.split_once(' ').ok_or_else(|| format!("`{rest}`: which figure, and what must it be?"))?;
                Self::Figure(path.to_owned(), value.to_owned())
            }
            ("console", "opened") => Self::Open,
            ("flash", "refuses" | "mended") => Self::FlashRefuses(rest == "refuses"),
            ("board", "sees the emergency stop pressed" | "sees the emergency stop released") => {
                Self::StopSeen(rest.ends_with("pressed"))
            }
            ("board", "cuts the tool off") => Self::CutOff,
            ("board", "sees a reset") => Self::ResetHeard,
            _ => {
                return Err(format!(
                    "`{text}` is no step: use one of > >> ! !! < with homed powered-up switched-on power-off-and-on wait until \
                     silence report state accessories unchanged steps places note moved took rested moves no-step-made no-step-lost no-violation \
                     counts-agree trusted tool output watch changed motors switch drive driver vfd fault flash emergency-stop \
                     probe hold start plate console board emulator figure, as tests/dialogues/README.md says"
                ));
            }
        })
    }
}
