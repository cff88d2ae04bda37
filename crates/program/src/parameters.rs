//! The parameters of a program: numbers by number or by name.

use std::collections::BTreeMap;

use crate::Problem;
use crate::number::{shown, whole};

/// Parameters up to this number are the program's.
const OWN_MAX: usize = 5_000;
/// Parameters up to this number are what a subroutine is called with.
pub(crate) const ARGUMENTS_MAX: usize = 30;
/// Numbers from 5001 up to this one are the machine's.
const MACHINE_MAX: i64 = 5_602;

/// What the machine's parameters are, each up to a number.
const OF_MACHINE: [(i64, &str); 11] = [
    (5_020, "reserved"),
    (5_029, "where the machine stands"),
    (5_060, "reserved"),
    (5_070, "what a probe has found"),
    (5_160, "the tool's length"),
    (5_199, "a place of G28 or G30"),
    (5_219, "an offset of G92"),
    (5_398, "a work offset"),
    (5_399, "an input"),
    (5_419, "the tool and its measures"),
    (5_428, "where the machine stands"),
];

/// The names that LinuxCNC gives to what its machine knows.
const NAMES_OF_MACHINE: &str = " \
    _vmajor _vminor _motion_mode _plane _ccomp _metric _imperial _absolute _incremental _inverse_time _units_per_minute \
    _units_per_rev _coord_system _tool_offset _retract_r_plane _retract_old_z _spindle_rpm_mode _spindle_css_mode \
    _ijk_absolute_mode _lathe_diameter_mode _lathe_radius_mode _spindle_on _spindle_cw _mist _flood _speed_override \
    _feed_override _adaptive_feed _feed_hold _feed _rpm _x _y _z _a _b _c _u _v _w _abs_x _abs_y _abs_z _abs_a _abs_b _abs_c \
    _abs_u _abs_v _abs_w _current_tool _current_pocket _selected_tool _selected_pocket _task _remap_level ";

/// Names that a program reads and does not set.
const READ_ONLY: [&str; 4] = ["_value", "_value_returned", "_call_level", "_line"];

/// A parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Parameter {
    /// `#5`
    Numbered(usize),
    /// `#<depth>`, in lower case and without blanks. One that begins with `_` is global.
    Named(String),
}

impl Parameter {
    /// The parameter of this number.
    pub fn of_number(number: f64) -> Result<Self, Problem> {
        let Some(index) = whole(number) else { return Err(Problem::NumberNotWhole(shown(number))) };
        match index {
            1..=MACHINE_MAX if index as usize <= OWN_MAX => Ok(Self::Numbered(index as usize)),
            1..=MACHINE_MAX => {
                let what = OF_MACHINE.iter().find(|(last, _)| index <= *last).map_or("reserved", |(_, what)| what);
                Err(Problem::OfMachine(format!("#{index}"), what))
            }
            _ => Err(Problem::NumberOutOfRange(index)),
        }
    }

    fn words(&self) -> String {
        match self {
            Self::Numbered(number) => format!("#{number}"),
            Self::Named(name) => format!("#<{name}>"),
        }
    }
}

/// What a subroutine has for itself.
#[derive(Default)]
struct Scope {
    named: BTreeMap<String, f64>,
    /// The first parameters of the caller.
    saved: Option<[f64; ARGUMENTS_MAX]>,
}

/// The values of all parameters.
pub(crate) struct Parameters {
    /// By number, from 1. Those never set are 0.
    numbered: Vec<f64>,
    global: BTreeMap<String, f64>,
    /// That of the main program, and of each subroutine that has been called.
    scopes: Vec<Scope>,
    /// The line that is carried out, from 1.
    pub line: usize,
}

impl Parameters {
    pub fn new() -> Self {
        let global = [("_value", 0.0), ("_value_returned", 0.0)].map(|(name, value)| (name.to_owned(), value));
        Self { numbered: vec![0.0; OWN_MAX], global: BTreeMap::from(global), scopes: vec![Scope::default()], line: 0 }
    }

    pub fn get(&self, parameter: &Parameter) -> Result<f64, Problem> {
        self.find(parameter).ok_or_else(|| match parameter {
            Parameter::Named(name) if is_of_machine(name) => {
                Problem::OfMachine(parameter.words(), "what LinuxCNC's machine says of itself")
            }
            _ => Problem::NeverSet(parameter.words()),
        })
    }

    /// True if it has a value.
    pub fn exists(&self, parameter: &Parameter) -> bool {
        self.find(parameter).is_some()
    }

    fn find(&self, parameter: &Parameter) -> Option<f64> {
        match parameter {
            Parameter::Numbered(number) => Some(self.numbered[number - 1]),
            Parameter::Named(name) => match name.as_str() {
                "_line" => Some(self.line as f64),
                "_call_level" => Some(self.depth() as f64),
                _ => self.names(name).get(name).copied(),
            },
        }
    }

    fn names(&self, name: &str) -> &BTreeMap<String, f64> {
        if name.starts_with('_') { &self.global } else { &self.scopes[self.depth()].named }
    }

    /// Whether the program may set it.
    pub fn may_set(parameter: &Parameter) -> Result<(), Problem> {
        match parameter {
            Parameter::Named(name) if is_of_machine(name) || READ_ONLY.contains(&name.as_str()) => {
                Err(Problem::ReadOnly(parameter.words()))
            }
            _ => Ok(()),
        }
    }

    pub fn set(&mut self, parameter: Parameter, value: f64) {
        let depth = self.depth();
        match parameter {
            Parameter::Numbered(number) => self.numbered[number - 1] = value,
            Parameter::Named(name) if name.starts_with('_') => drop(self.global.insert(name, value)),
            Parameter::Named(name) => drop(self.scopes[depth].named.insert(name, value)),
        }
    }

    /// The number of subroutines that have been called and not left.
    pub fn depth(&self) -> usize {
        self.scopes.len() - 1
    }

    /// Begins a subroutine. With `arguments` #1 to #30 are its own; those without an argument are 0.
    pub fn enter(&mut self, arguments: Option<&[f64]>) {
        let saved = arguments.map(|arguments| {
            let own = &mut self.numbered[..ARGUMENTS_MAX];
            let saved = std::array::from_fn(|index| own[index]);
            own.fill(0.0);
            own[..arguments.len()].copy_from_slice(arguments);
            saved
        });
        self.scopes.push(Scope { named: BTreeMap::new(), saved });
    }

    /// Ends the subroutine that was begun last.
    pub fn leave(&mut self) {
        if let Some(saved) = self.scopes.pop().and_then(|scope| scope.saved) {
            self.numbered[..ARGUMENTS_MAX].copy_from_slice(&saved);
        }
    }

    /// Notes what a subroutine returns.
    pub fn returned(&mut self, value: Option<f64>) {
        self.global.insert("_value".to_owned(), value.unwrap_or(0.0));
        self.global.insert("_value_returned".to_owned(), f64::from(u8::from(value.is_some())));
    }
}

fn is_of_machine(name: &str) -> bool {
    name.starts_with("_ini[") || name.starts_with("_hal[") || NAMES_OF_MACHINE.contains(&format!(" {name} "))
}
