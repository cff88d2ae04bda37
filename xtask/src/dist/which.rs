//! The table of a release: which of its files is for whom.

use std::fmt::Write as _;

use clap::ValueEnum;

use super::name;
use crate::variant::{Axes, Board, Contact, Driver, Port, Variant};

/// A table of these images in Markdown, with what stands in its columns.
pub fn table(variants: &[Variant]) -> String {
    let mut text = format!(
        "# Which file\n\n\
         The firmware of Isostep {}. Hold BOOTSEL while you plug in the board (on an SKR Pico set the jumper BOOT and press RESET),\n\
         and copy one file onto the drive that appears, RPI-RP2, or RP2350 of a Pico 2. Files with `prove` in their names measure the\n\
         board by `isostep prove`, and never energise a motor. Of the emergency stop `nc` is the safer one, and of the port `pio` the faster one.\n\
         `sha256sum --check SHA256SUMS` says whether the files are as they were made.\n\n",
        env!("CARGO_PKG_VERSION")
    );
    let heads =
        [["file", "board", "driver", "axes", "estop", "port"].map(str::to_owned), ["---"; 6].map(str::to_owned)];
    for cells in heads.into_iter().chain(variants.iter().map(|&variant| cells(variant))) {
        let [file, board, driver, axes, estop, port] = cells;
        let _ = writeln!(text, "| {file:<55} | {board:<8} | {driver:<7} | {axes:<4} | {estop:<5} | {port:<5} |");
    }
    text += "\n";
    text += &meanings::<Board>("board");
    text += &meanings::<Driver>("driver");
    text += &meanings::<Axes>("axes");
    text += &meanings::<Contact>("estop");
    text + &meanings::<Port>("port")
}

/// The row of an image: its values of the options of `cargo xtask flash`.
fn cells(variant: Variant) -> [String; 6] {
    let driver = if variant.prove { "none".to_owned() } else { value(variant.driver()) };
    let file = format!("`{}`", name(variant));
    [file, value(variant.board), driver, value(variant.axes), value(variant.estop), value(variant.port)]
}

fn value(option: impl ValueEnum) -> String {
    option.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

/// The meaning of an option's values, in the words of its help.
fn meanings<T: ValueEnum>(option: &str) -> String {
    let values = T::value_variants().iter().filter_map(T::to_possible_value);
    let meanings = values.map(|value| format!("`{}`: {}", value.get_name(), value.get_help().unwrap_or_default()));
    format!("- **{option}**: {}\n", meanings.collect::<Vec<_>>().join("; "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_says_for_whom_a_file_is_and_each_value_is_explained() {
        let skr_pico = Variant { board: Board::SkrPico, estop: Contact::Nc, axes: Axes::Four, ..Variant::default() };
        let pico_2 = Variant { board: Board::Pico2, ..Variant::default() };
        let proving = [Board::Pico, Board::Pico2].map(|board| Variant::proving(board, Port::Timer));
        let text = table(&[Variant::default(), pico_2, skr_pico, proving[0], proving[1]]);
        let rows = text.lines().filter(|line| line.starts_with("| `"));
        let rows: Vec<_> = rows.map(|row| row.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
        let version = env!("CARGO_PKG_VERSION");
        let expected = [
            format!("| `isostep-{version}-pio-drv8825.uf2` | pico | drv8825 | 3 | no | pio |"),
            format!("| `isostep-{version}-pio-pico2-drv8825.uf2` | pico2 | drv8825 | 3 | no | pio |"),
            format!("| `isostep-{version}-pio-skr-pico-estop-nc-4-axes.uf2` | skr-pico | tmc2209 | 4 | nc | pio |"),
            format!("| `isostep-{version}-prove-timer.uf2` | pico | none | 3 | no | timer |"),
            format!("| `isostep-{version}-prove-timer-pico2.uf2` | pico2 | none | 3 | no | timer |"),
        ];
        assert_eq!(rows, expected);
        for words in [
            "`pico2`: A Raspberry Pi Pico 2, or another board with an RP2350A",
            "`skr-pico`: A BIGTREETECH SKR Pico V1.0",
            "`tmc2209`: STEP high and low 104 ns each",
            "`4`: X, Y, Z and A, which may be rotary",
            "`nc`: normally closed: open while it is pressed",
            "`timer`: the processor",
        ] {
            assert!(text.contains(words), "{words} is not in {text}");
        }
    }
}
