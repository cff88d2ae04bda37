//! Reads values: numbers, parameters, expressions in brackets, and functions.

use crate::cursor::Cursor;
use crate::number::shown;
use crate::operation::{Function, Operation};
use crate::parameters::{Parameter, Parameters};
use crate::{NESTED_VALUES_MAX, Problem};

/// Reads values from a line, with the parameters as they are before it.
pub(crate) struct Reader<'t, 'p> {
    pub cursor: Cursor<'t>,
    parameters: &'p Parameters,
    /// Values that are being read, one in another.
    nested: usize,
}

impl<'t, 'p> Reader<'t, 'p> {
    pub fn new(cursor: Cursor<'t>, parameters: &'p Parameters) -> Self {
        Self { cursor, parameters, nested: 0 }
    }

    /// Reads a value.
    pub fn value(&mut self) -> Result<f64, Problem> {
        self.nested += 1;
        if self.nested > NESTED_VALUES_MAX {
            return Err(Problem::NestedValues);
        }
        let value = self.one_value()?;
        self.nested -= 1;
        if value.is_finite() { Ok(value) } else { Err(Problem::NotFinite) }
    }

    fn one_value(&mut self) -> Result<f64, Problem> {
        if is_number(self.cursor) {
            return self.number();
        }
        match self.cursor.peek() {
            Some(b'[') => self.expression(),
            Some(b'#') => {
                let parameter = self.parameter()?;
                self.parameters.get(&parameter)
            }
            Some(b'+') => {
                self.cursor.next();
                self.value()
            }
            Some(b'-') => {
                self.cursor.next();
                self.value().map(|value| -value)
            }
            _ => match Function::take(&mut self.cursor) {
                Some(function) => self.function(function),
                None => Err(Problem::NoValue(self.cursor.rest())),
            },
        }
    }

    /// Reads an expression in brackets.
    pub fn expression(&mut self) -> Result<f64, Problem> {
        self.open()?;
        let value = self.chain(1)?;
        if self.cursor.take(b']') {
            return Ok(value);
        }
        Err(if self.cursor.is_over() { Problem::NotClosed } else { Problem::NoOperation(self.cursor.rest()) })
    }

    /// Values and the operations of at least this rank between them, from the left to the right.
    fn chain(&mut self, rank: u8) -> Result<f64, Problem> {
        let mut left = self.value()?;
        loop {
            let before = self.cursor;
            match Operation::take(&mut self.cursor) {
                Some((operation, own)) if own >= rank => left = operation.apply(left, self.chain(own + 1)?)?,
                _ => {
                    self.cursor = before;
                    return Ok(left);
                }
            }
        }
    }

    fn function(&mut self, function: Function) -> Result<f64, Problem> {
        if function == Function::Exists {
            self.open()?;
            let exists = match self.parameter() {
                Err(Problem::NumberOutOfRange(_) | Problem::OfMachine(..)) => false,
                parameter => self.parameters.exists(&parameter?),
            };
            let exists = f64::from(u8::from(exists));
            return if self.cursor.take(b']') { Ok(exists) } else { Err(Problem::NotClosed) };
        }
        let value = self.expression()?;
        if function != Function::Atan {
            return function.apply(value);
        }
        if !self.cursor.take(b'/') {
            return Err(Problem::NoSlash);
        }
        Ok(Function::atan(value, self.expression()?))
    }

    fn open(&mut self) -> Result<(), Problem> {
        if self.cursor.take(b'[') { Ok(()) } else { Err(Problem::NoBracket(self.cursor.rest())) }
    }

    /// Reads `#` and what stands for the parameter behind it.
    pub fn parameter(&mut self) -> Result<Parameter, Problem> {
        if !self.cursor.take(b'#') {
            return Err(Problem::NoParameter(self.cursor.rest()));
        }
        if self.cursor.peek() != Some(b'<') {
            return Parameter::of_number(self.value()?);
        }
        name(&mut self.cursor).map(Parameter::Named)
    }

    fn number(&mut self) -> Result<f64, Problem> {
        let start = self.cursor;
        let mut text = String::new();
        while let Some(byte @ (b'0'..=b'9' | b'.' | b'+' | b'-')) = self.cursor.peek()
            && (text.is_empty() || !matches!(byte, b'+' | b'-'))
        {
            text.push(byte.into());
            self.cursor.next();
        }
        text.parse().map_err(|_| Problem::NoValue(start.rest()))
    }
}

/// Reads a name in `<>`, in lower case and without blanks.
pub(crate) fn name(cursor: &mut Cursor<'_>) -> Result<String, Problem> {
    let start = *cursor;
    cursor.next();
    let mut bytes = Vec::new();
    loop {
        match cursor.next() {
            Some(b'>') if !bytes.is_empty() => return Ok(String::from_utf8_lossy(&bytes).into_owned()),
            None | Some(b'>') => return Err(Problem::BadName(start.rest())),
            Some(byte) => bytes.push(byte),
        }
    }
}

/// True if a plain number comes, with or without a sign.
pub(crate) fn is_number(mut cursor: Cursor<'_>) -> bool {
    let _ = cursor.take(b'+') || cursor.take(b'-');
    cursor.peek().is_some_and(|byte| byte.is_ascii_digit() || byte == b'.')
}

/// The value of a parameter, or of anything that has to be at least 0 and whole, as a count.
pub(crate) fn count(value: f64, of: &'static str, most: u32) -> Result<u32, Problem> {
    let whole = crate::number::whole(value).and_then(|whole| u32::try_from(whole).ok());
    whole.filter(|whole| *whole <= most).ok_or_else(|| Problem::BadCount { of, value: shown(value), most })
}
