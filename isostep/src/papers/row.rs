//! A figure of a paper beside ours.

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
    /// Who wrote what.
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

/// Where the paper's side of a row comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Basis {
    /// It stands in the paper.
    Printed,
    /// The paper prints the method; run here, it gives this.
    Method,
}

impl Basis {
    /// As a word of the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Printed => "printed",
            Self::Method => "its method",
        }
    }
}

/// A number in the row's unit, or what is said.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Cell {
    /// In the row's unit.
    Number(f64),
    /// In words.
    Words(String),
}

/// One figure: the paper's, ours, and how far apart they are. Where a paper only has a picture there is no row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Whose.
    pub paper: Paper,
    /// Where it stands there.
    pub place: &'static str,
    /// What it is.
    pub quantity: String,
    /// Of numbers.
    pub unit: &'static str,
    /// Where `theirs` comes from.
    pub basis: Basis,
    /// The paper's.
    pub theirs: Cell,
    /// Ours.
    pub ours: Cell,
    /// Ours less the paper's, or whether both say the same.
    pub difference: Cell,
    #[serde(skip)]
    decimals: usize,
}

/// What a row asks.
pub struct Question {
    paper: Paper,
    place: &'static str,
    quantity: String,
    unit: &'static str,
    decimals: usize,
}

impl Paper {
    /// A figure in words.
    pub fn asks(self, place: &'static str, quantity: impl Into<String>) -> Question {
        Question { paper: self, place, quantity: quantity.into(), unit: "", decimals: 0 }
    }
}

impl Question {
    /// A number of `unit`, ours to `decimals`.
    pub fn number(self, unit: &'static str, decimals: usize) -> Self {
        Self { unit, decimals, ..self }
    }

    /// The paper prints `theirs`.
    pub fn printed(self, theirs: f64, ours: f64) -> Row {
        self.row(Basis::Printed, [theirs, ours, ours - theirs].map(Cell::Number))
    }

    /// The paper's method, run here, gives `theirs`.
    pub fn by_method(self, theirs: f64, ours: f64) -> Row {
        self.row(Basis::Method, [theirs, ours, ours - theirs].map(Cell::Number))
    }

    /// The paper says `theirs`; we find `ours`, which is the same or is not.
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
    /// The paper's side as the paper prints it, or to as many decimals as ours.
    pub fn theirs_text(&self) -> String {
        self.text(&self.theirs, |value| match self.basis {
            Basis::Printed => value.to_string(),
            Basis::Method => format!("{value:.*}", self.decimals),
        })
    }

    /// Our side.
    pub fn ours_text(&self) -> String {
        self.text(&self.ours, |value| format!("{value:.*}", self.decimals))
    }

    /// Ours less the paper's, with its sign.
    pub fn difference_text(&self) -> String {
        self.text(&self.difference, |value| signed(value, self.decimals))
    }

    /// Whether it is said in words.
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

/// With a sign, unless it is shown as nothing but zeros.
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
