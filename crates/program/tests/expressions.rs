//! The value of each kind of expression.

use isostep_trials::cases;
use proptest::prelude::*;

use crate::made::{error, lines};

/// The value of an expression, as a word has it.
fn value(expression: &str) -> String {
    let line = lines(&format!("#1=3 #2=1 #5=-2\nX{expression}")).remove(0);
    line.strip_prefix('X').unwrap().to_owned()
}

#[test]
fn every_operation_has_its_value() {
    for (expression, expected) in [
        ("[1 + 2]", "3"),
        ("[1 - 2]", "-1"),
        ("[3 * 2]", "6"),
        ("[1 / 4]", "0.25"),
        ("[2 ** 10]", "1024"),
        ("[2 * * 3]", "8"),
        ("[7 MOD 3]", "1"),
        ("[-7 MOD 3]", "2"),
        ("[7.5 mod -2]", "1.5"),
        ("[3 EQ #1]", "1"),
        ("[3 EQ 3.0000005]", "1"),
        ("[3 EQ 3.00001]", "0"),
        ("[3 NE 3.0000005]", "0"),
        ("[3 ne 4]", "1"),
        ("[4 GT 3]", "1"),
        ("[3 GT 3]", "0"),
        ("[3 GE 3.0000005]", "1"),
        ("[2 GE 3]", "0"),
        ("[2 LT 3]", "1"),
        ("[3 LT 3]", "0"),
        ("[3.0000005 LE 3]", "1"),
        ("[4 LE 3]", "0"),
        ("[2 AND -1]", "1"),
        ("[2 AND 0]", "0"),
        ("[0 OR 0.1]", "1"),
        ("[0 or 0]", "0"),
        ("[1 XOR 2]", "0"),
        ("[1 XOR 0]", "1"),
    ] {
        assert_eq!(value(expression), expected, "{expression}");
    }
}

#[test]
fn every_function_has_its_value() {
    for (expression, expected) in [
        ("ABS[-2.5]", "2.5"),
        ("ACOS[0.5]", "60"),
        ("ASIN[0.5]", "30"),
        ("ATAN[1]/[-1]", "135"),
        ("atan [ -1 ] / [ 0 ]", "-90"),
        ("COS[60]", "0.5"),
        ("COS[90]", "0"),
        ("EXP[1]", "2.718282"),
        ("FIX[2.8]", "2"),
        ("FIX[-2.8]", "-3"),
        ("FUP[2.8]", "3"),
        ("FUP[-2.8]", "-2"),
        ("LN[10]", "2.302585"),
        ("ROUND[2.5]", "3"),
        ("ROUND[-2.5]", "-3"),
        ("SIN[30]", "0.5"),
        ("SQRT[2]", "1.414214"),
        ("TAN[45]", "1"),
        ("EXISTS[#<_value>]", "1"),
        ("EXISTS[#<depth>]", "0"),
        ("EXISTS[##1]", "1"),
        ("EXISTS[#5420]", "0"),
        ("EXISTS[#99999]", "0"),
        ("EXISTS[#<_x>]", "0"),
    ] {
        assert_eq!(value(expression), expected, "{expression}");
    }
}

/// Of one rank from the left to the right; a sign belongs to its value.
#[test]
fn operations_are_carried_out_by_their_ranks() {
    for (expression, expected) in [
        ("[1 + 2 * 3]", "7"),
        ("[[1 + 2] * 3]", "9"),
        ("[2 * 3 ** 2]", "18"),
        ("[2 ** 3 ** 2]", "64"),
        ("[-2 ** 2]", "4"),
        ("[-#1 ** 2]", "9"),
        ("[2.0 / 3 * 1.5 - 5.5 / 11.0]", "0.5"),
        ("[10 - 4 - 3]", "3"),
        ("[[#1 + 2 * SIN[30]] MOD 3]", "1"),
        ("[1 + 1 EQ 2 AND 3 GT 2 + 2]", "0"),
        ("[1 LT 2 + 1]", "1"),
        ("[1 OR 1 AND 0]", "0"),
        ("[1 - -2]", "3"),
        ("[1 - - - 2]", "-1"),
        ("-[1+2]", "-3"),
        ("+#1", "3"),
        ("- #1", "-3"),
        ("##2", "3"),
        ("#[1+1]", "1"),
        ("[#1+2]", "5"),
        ("[1 2 + 3 . 5]", "15.5"),
        ("[#5LT#1]", "1"),
        ("[.5 + 1. + +0.25]", "1.75"),
    ] {
        assert_eq!(value(expression), expected, "{expression}");
    }
}

#[test]
fn what_has_no_value_is_refused() {
    for (expression, problem) in [
        ("[1 / 0]", "1 is divided by zero: test the divisor by an o-if before"),
        ("[5 MOD [1 - 1]]", "5 is divided by zero: test the divisor by an o-if before"),
        ("[-2 ** 0.5]", "-2 ** 0.5: a negative number has whole powers only"),
        ("SQRT[-1]", "SQRT[-1] has no value: it takes 0 or more"),
        ("LN[0]", "LN[0] has no value: it takes more than 0"),
        ("ASIN[1.5]", "ASIN[1.5] has no value: it takes -1 to 1"),
        ("ACOS[-2]", "ACOS[-2] has no value: it takes -1 to 1"),
        ("EXP[1000]", "the result is no finite number: calculate with smaller ones"),
        ("[10 ** 8]", "1e8 is too large for a word: values are below 100,000,000"),
        ("[1 + 2", "a bracket is not closed: add ]"),
        ("[1 + 2 (note)", "a bracket is not closed: add ]"),
        ("[]", "`]` is no value: write a number, a parameter (#1, #<name>), [...], or a function such as SIN[30]"),
        ("[1 + * 2]", "`* 2]` is no value: "),
        ("[1.2.3]", "`1.2.3]` is no value: "),
        ("[SIN 30]", "`SIN 30]` is no value: "),
        (
            "[1 PLUS 2]",
            "`PLUS 2]` is no operation: use + - * / ** MOD, EQ NE GT GE LT LE, AND OR XOR, or close the bracket",
        ),
        ("ATAN[1]", "ATAN has two values: write ATAN[y]/[x]"),
        ("ATAN[1]/2", "a value in brackets belongs before `2`: write [...]"),
        ("EXISTS[5]", "EXISTS takes a parameter and not `5]`: write EXISTS[#<name>]"),
    ] {
        let reported = error(&format!("X{expression}"));
        assert!(reported.starts_with(&format!("line 1 `X{expression}`: {problem}")), "{expression}: {reported}");
    }
    let deep = |levels: usize| format!("X{}1{}", "[".repeat(levels), "]".repeat(levels));
    assert_eq!(lines(&deep(31)), ["X1"]);
    let nested = "values are nested more than 32 deep: calculate a part of them on a line before, into a parameter";
    for text in [deep(32), deep(100_000), format!("X[{}1]", "-".repeat(100_000)), format!("X{}1", "#".repeat(100_000))]
    {
        assert!(error(&text).ends_with(nested) && error(&text).len() < 300, "{}", error(&text));
    }
}

/// An expression, as text, as a tree, and the value of the tree.
#[derive(Clone, Debug)]
enum Tree {
    Number(i32),
    Minus(Box<Tree>),
    Two(Box<Tree>, &'static str, Box<Tree>),
}

impl Tree {
    fn any() -> impl Strategy<Value = Self> {
        let number = (-9..100_i32).prop_map(Self::Number);
        number.prop_recursive(5, 24, 2, |inner| {
            let words = prop::sample::select(vec!["+", "-", "*", "/", "MOD", "LT", "GE", "AND", "XOR"]);
            let two = (inner.clone(), words, inner.clone());
            prop_oneof![
                inner.prop_map(|one| Self::Minus(Box::new(one))),
                two.prop_map(|(left, word, right)| Self::Two(Box::new(left), word, Box::new(right))),
            ]
        })
    }

    fn rank(&self) -> u8 {
        match self {
            Self::Two(_, "AND" | "XOR", _) => 1,
            Self::Two(_, "LT" | "GE", _) => 2,
            Self::Two(_, "+" | "-", _) => 3,
            Self::Two(..) => 4,
            _ => 5,
        }
    }

    /// With brackets only where they are needed.
    fn text(&self, rank: u8) -> String {
        let text = match self {
            Self::Number(number) => number.to_string(),
            Self::Minus(one) => format!("-{}", one.text(6)),
            Self::Two(left, word, right) => {
                format!("{} {word} {}", left.text(self.rank()), right.text(self.rank() + 1))
            }
        };
        if self.rank() < rank || rank == 6 { format!("[{text}]") } else { text }
    }

    /// `None` where something is divided by zero.
    fn value(&self) -> Option<f64> {
        let truth = |holds: bool| Some(f64::from(i32::from(holds)));
        match self {
            Self::Number(number) => Some(f64::from(*number)),
            Self::Minus(one) => Some(-one.value()?),
            Self::Two(left, word, right) => {
                let (left, right) = (left.value()?, right.value()?);
                match *word {
                    "+" => Some(left + right),
                    "-" => Some(left - right),
                    "*" => Some(left * right),
                    "/" => (right != 0.0).then(|| left / right),
                    "MOD" => (right != 0.0).then(|| left.rem_euclid(right)),
                    "LT" => truth(left < right),
                    "GE" => truth(left >= right || (left - right).abs() < 1e-6),
                    "AND" => truth(left != 0.0 && right != 0.0),
                    _ => truth((left != 0.0) != (right != 0.0)),
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(500, 20_000), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_expression_has_the_value_of_its_tree(tree in Tree::any()) {
        let program = format!("X[{}]", tree.text(0));
        match tree.value().filter(|value| value.abs() < 1e8) {
            Some(value) => {
                let text = lines(&program).remove(0);
                let found: f64 = text[1..].parse().unwrap();
                prop_assert!((found - value).abs() <= 0.6e-6, "{program}: {found}, not {value}");
                prop_assert!(!text.contains(['e', 'E']) && text != "X-0", "{text}");
            }
            None => prop_assert!(["divided by zero", "too large"].iter().any(|words| error(&program).contains(words))),
        }
    }

    #[test]
    fn any_text_is_lines_or_an_error(
        text in "([GMXPLO#=o<> 0-9.\\[\\]*/+-]|sub|endsub|call|while|if|SIN|MOD|\n){0,60}|(o1 (sub|endsub|call|while|endwhile|if|endif|else|repeat|break|do) *\\[?#?1?\\]?\n){0,8}"
    ) {
        let source: Vec<&str> = text.lines().collect();
        if let Ok(lines) = isostep_program::plain_lines(&source) {
            let made: Vec<_> = lines.take(1_000).collect();
            prop_assert!(made.iter().flatten().all(|line| (1..=source.len()).contains(&line.number)));
        }
    }
}
