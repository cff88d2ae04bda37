//! A figure of a paper compared with ours.

use serde::Serialize;

/// The papers that are reproduced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Paper {
    /// Frequency over the step index.
    #[serde(rename = "Fonseca-Campos 2023")]
    Frequency,
    /// Linear speed over time.
    #[serde(rename = "Stoychitch 2018")]
    Linear,
    /// The parking gantry.
    #[serde(rename = "Forero 2023")]
    Gantry,
}

impl Paper {
    /// The paper's short name, authors and title.
    pub fn title(self) -> &'static str {
        match self {
            Self::Frequency => {
                "Fonseca-Campos 2023: Fonseca-Campos and others (2023), Implementation in Microcontrollers of an Algorithm for the \
                 Simple Generation of Speed Profiles in a Stepper Motor"
            }
            Self::Linear => {
                "Stoychitch 2018: Stoychitch (2018), Generate stepper motor linear speed profile in real time"
            }
            Self::Gantry => {
                "Forero 2023: Forero, Ramírez and Blanco (2023), Design of a Trapezoidal Motion Profile to the Physical \
                 Implementation of a 3P Cartesian Robot Prototype"
            }
        }
    }
}

/// The source of the paper's value in a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// The value is printed in the paper.
    Printed,
    /// The paper prints the method; running it here gives the value.
    Method,
}

impl Basis {
    /// The word for it in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Method => "its method",
        }
    }
}

/// A number in the row's unit, or a statement in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// A number in the row's unit.
    Number(f64),
    /// A statement in words.
    Words(String),
}

/// One figure: the paper's value, ours, and the difference. A figure that a paper shows only as a picture has no row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The paper.
    pub paper: Paper,
    /// The place of the figure in the paper.
    pub place: &'static str,
    /// The quantity that is compared.
    pub quantity: String,
    /// The unit of the numbers.
    pub unit: &'static str,
    /// The source of `theirs`.
    pub basis: Basis,
    /// The paper's value.
    pub theirs: Cell,
    /// Our value.
    pub ours: Cell,
    /// Our value minus the paper's, or whether both statements agree.
    pub difference: Cell,
    #[serde(skip)]
    decimals: usize,
}

/// The quantity that a row compares, without its values.
pub struct Question {
    paper: Paper,
    place: &'static str,
    quantity: String,
    unit: &'static str,
    decimals: usize,
}

impl Paper {
    /// A quantity that is compared in words.
    pub fn asks(self, place: &'static str, quantity: impl Into<String>) -> Question {
        Question { paper: self, place, quantity: quantity.into(), unit: "", decimals: 0 }
    }
}

impl Question {
    /// Makes it a number in `unit`, of which ours is shown with `decimals` decimals.
    pub fn number(self, unit: &'static str, decimals: usize) -> Self {
        Self { unit, decimals, ..self }
    }

    /// A row for which the paper prints the value `theirs`.
    pub fn printed(self, theirs: f64, ours: f64) -> Row {
        self.row(Basis::Printed, [theirs, ours, ours - theirs].map(Cell::Number))
    }

    /// A row for which the paper's method, run here, gives `theirs`.
    pub fn by_method(self, theirs: f64, ours: f64) -> Row {
        self.row(Basis::Method, [theirs, ours, ours - theirs].map(Cell::Number))
    }

    /// A row for which the paper states `theirs` and we find `ours`; `agrees` says whether both mean the same.
    pub fn says(self, theirs: &str, ours: impl Into<String>, agrees: bool) -> Row {
        let difference = if agrees { "none" } else { "differs" };
        self.row(Basis::Printed, [theirs.to_owned(), ours.into(), difference.to_owned()].map(Cell::Words))
    }

    fn row(self, basis: Basis, cells: [Cell; 3]) -> Row {
        let Self { paper, place, quantity, unit, decimals } = self;
        let [theirs, ours, difference] = cells;
        Row { paper, place, quantity, unit, basis, theirs, ours, difference, decimals }
    }
}

impl Row {
    /// The paper's value. A printed value is shown as printed, a computed one with as many decimals as ours.
    pub fn theirs_text(&self) -> String {
        self.text(&self.theirs, |value| match self.basis {
            Basis::Printed => value.to_string(),
            Basis::Method => format!("{value:.*}", self.decimals),
        })
    }

    /// Our value.
    pub fn ours_text(&self) -> String {
        self.text(&self.ours, |value| format!("{value:.*}", self.decimals))
    }

    /// Our value minus the paper's, with its sign.
    pub fn difference_text(&self) -> String {
        self.text(&self.difference, |value| signed(value, self.decimals))
    }

    /// True if the figure is stated in words.
    pub fn is_words(&self) -> bool {
        matches!(self.ours, Cell::Words(_))
    }

    /// The words, or the number with its unit.
    fn text(&self, cell: &Cell, number: impl Fn(f64) -> String) -> String {
        match cell {
            Cell::Number(value) => format!("{} {}", number(*value), self.unit).trim_end().to_owned(),
            Cell::Words(words) => words.clone(),
        }
    }
}

/// The number with its sign, or `0` if all its digits are zeros.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = format!("{value:+.decimals$}");
    if text.chars().any(|digit| ('1'..='9').contains(&digit)) { text } else { "0".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(row: &Row) -> [String; 3] {
        [row.theirs_text(), row.ours_text(), row.difference_text()]
    }

    #[test]
    fn a_difference_is_ours_less_the_papers() {
        let row = Paper::Gantry.asks("Table 1", "decelerating").number("s", 3).printed(6.8, 4.5);
        assert_eq!(texts(&row), ["6.8 s", "4.500 s", "-2.300 s"]);
        let row = Paper::Gantry.asks("eq 12", "cruise").number("s", 3).by_method(4.725, 4.725_000_1);
        assert_eq!(texts(&row), ["4.725 s", "4.725 s", "0 s"]);
    }

    #[test]
    fn words_are_the_same_or_not() {
        let row = |agrees| Paper::Frequency.asks("VI.F", "least").says("sinusoidal", "linear", agrees);
        assert_eq!(texts(&row(false)), ["sinusoidal", "linear", "differs"]);
        assert_eq!(row(true).difference_text(), "none");
        assert!(row(true).is_words());
    }

    #[test]
    fn json_has_numbers_as_numbers() {
        let row = Paper::Frequency.asks("VI.G", "saved").number("%", 2).printed(10.0, 9.91);
        let json = serde_json::to_value(&row).unwrap();
        assert_eq!(
            (&json["paper"], &json["theirs"], &json["basis"]),
            (&"Fonseca-Campos 2023".into(), &10.0.into(), &"printed".into())
        );
    }
}
