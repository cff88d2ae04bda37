//! What expressions calculate with: operations between two values, and functions of one.

use std::f64::consts::PI;

use crate::Problem;
use crate::cursor::Cursor;
use crate::number::{SAME, shown};

/// Degrees of a radian.
const DEGREES: f64 = 180.0 / PI;

/// An operation between two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Power,
    Times,
    Over,
    Modulo,
    Plus,
    Minus,
    Equal,
    NotEqual,
    Greater,
    GreaterOrEqual,
    Less,
    LessOrEqual,
    And,
    Or,
    Xor,
}

impl Operation {
    /// Its words and its rank: of two operations the one of the higher rank is carried out first. `**` stands before `*`, of which it is
    /// made.
    const ALL: [(&str, Self, u8); 15] = [
        ("**", Self::Power, 5),
        ("*", Self::Times, 4),
        ("/", Self::Over, 4),
        ("mod", Self::Modulo, 4),
        ("+", Self::Plus, 3),
        ("-", Self::Minus, 3),
        ("eq", Self::Equal, 2),
        ("ne", Self::NotEqual, 2),
        ("gt", Self::Greater, 2),
        ("ge", Self::GreaterOrEqual, 2),
        ("lt", Self::Less, 2),
        ("le", Self::LessOrEqual, 2),
        ("and", Self::And, 1),
        ("or", Self::Or, 1),
        ("xor", Self::Xor, 1),
    ];

    /// The operation that comes and its rank. The cursor goes behind it.
    pub fn take(cursor: &mut Cursor<'_>) -> Option<(Self, u8)> {
        let found = Self::ALL.into_iter().find(|(word, ..)| cursor.take_word(word));
        found.map(|(_, operation, rank)| (operation, rank))
    }

    pub fn apply(self, left: f64, right: f64) -> Result<f64, Problem> {
        let is_same = (left - right).abs() < SAME;
        let holds = |condition: bool| f64::from(u8::from(condition));
        Ok(match self {
            Self::Power if left < 0.0 && libm::floor(right) != right => {
                return Err(Problem::PowerOfNegative(shown(left), shown(right)));
            }
            Self::Power => libm::pow(left, right),
            Self::Times => left * right,
            Self::Over | Self::Modulo if right == 0.0 => return Err(Problem::DivisionByZero(shown(left))),
            Self::Over => left / right,
            Self::Modulo => {
                let rest = libm::fmod(left, right);
                if rest < 0.0 { rest + right.abs() } else { rest }
            }
            Self::Plus => left + right,
            Self::Minus => left - right,
            Self::Equal => holds(is_same),
            Self::NotEqual => holds(!is_same),
            Self::Greater => holds(left > right),
            Self::GreaterOrEqual => holds(left >= right || is_same),
            Self::Less => holds(left < right),
            Self::LessOrEqual => holds(left <= right || is_same),
            Self::And => holds(left != 0.0 && right != 0.0),
            Self::Or => holds(left != 0.0 || right != 0.0),
            Self::Xor => holds((left != 0.0) != (right != 0.0)),
        })
    }
}

/// A function of one value; [`Atan`](Self::Atan) has two, and [`Exists`](Self::Exists) a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Abs,
    Acos,
    Asin,
    Atan,
    Cos,
    Exists,
    Exp,
    Fix,
    Fup,
    Ln,
    Round,
    Sin,
    Sqrt,
    Tan,
}

impl Function {
    const ALL: [(&str, Self); 14] = [
        ("abs", Self::Abs),
        ("acos", Self::Acos),
        ("asin", Self::Asin),
        ("atan", Self::Atan),
        ("cos", Self::Cos),
        ("exists", Self::Exists),
        ("exp", Self::Exp),
        ("fix", Self::Fix),
        ("fup", Self::Fup),
        ("ln", Self::Ln),
        ("round", Self::Round),
        ("sin", Self::Sin),
        ("sqrt", Self::Sqrt),
        ("tan", Self::Tan),
    ];

    /// The function that comes, with its bracket. The cursor goes to the bracket.
    pub fn take(cursor: &mut Cursor<'_>) -> Option<Self> {
        let is_next = |word: &str| {
            let mut ahead = *cursor;
            (ahead.take_word(word) && ahead.peek() == Some(b'[')).then_some(ahead)
        };
        let (ahead, function) =
            Self::ALL.into_iter().find_map(|(word, function)| is_next(word).map(|ahead| (ahead, function)))?;
        *cursor = ahead;
        Some(function)
    }

    /// The value at `of`, for functions of one value.
    pub fn apply(self, of: f64) -> Result<f64, Problem> {
        let within = |name: &'static str| {
            if of.abs() <= 1.0 { Ok(of) } else { Err(Problem::OutOfRange(name, shown(of), "-1 to 1")) }
        };
        Ok(match self {
            Self::Abs => of.abs(),
            Self::Acos => libm::acos(within("ACOS")?) * DEGREES,
            Self::Asin => libm::asin(within("ASIN")?) * DEGREES,
            Self::Cos => libm::cos(of / DEGREES),
            Self::Exp => libm::exp(of),
            Self::Fix => libm::floor(of),
            Self::Fup => libm::ceil(of),
            Self::Ln if of <= 0.0 => return Err(Problem::OutOfRange("LN", shown(of), "more than 0")),
            Self::Ln => libm::log(of),
            Self::Round => libm::round(of),
            Self::Sin => libm::sin(of / DEGREES),
            Self::Sqrt if of < 0.0 => return Err(Problem::OutOfRange("SQRT", shown(of), "0 or more")),
            Self::Sqrt => libm::sqrt(of),
            Self::Tan => libm::tan(of / DEGREES),
            Self::Atan | Self::Exists => unreachable!("these are read by the expression"),
        })
    }

    /// The angle of `y` over `x`, degrees.
    pub fn atan(y: f64, x: f64) -> f64 {
        libm::atan2(y, x) * DEGREES
    }
}
