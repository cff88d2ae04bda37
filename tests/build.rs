//! Writes a `#[test]` for each dialogue of `tests/dialogues` and each machine that it is for, so that `cargo test NAME` finds it.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=dialogues");
    let (mut simulated, mut emulated) = (String::new(), String::new());
    let mut files: Vec<_> =
        fs::read_dir("dialogues")?.map(|entry| Ok(entry?.path())).collect::<Result<_, Box<dyn Error>>>()?;
    files.sort();
    for path in files.iter().filter(|path| path.extension().is_some_and(|extension| extension == "txt")) {
        let (file, topic) = (path.file_name(), path.file_stem());
        let (file, topic) = file.zip(topic).ok_or("a file without a name")?;
        let text = fs::read_to_string(path)?;
        let of = |machine: &str| tests(&text, &file.display().to_string(), machine);
        module(&mut simulated, &topic.display().to_string(), &of("simulator"))?;
        module(&mut emulated, &topic.display().to_string(), &(of("board") + &of("timer-board")))?;
    }
    let folder = env::var("OUT_DIR")?;
    fs::write(Path::new(&folder).join("simulated.rs"), simulated)?;
    fs::write(Path::new(&folder).join("emulated.rs"), emulated)?;
    Ok(())
}

fn module(modules: &mut String, topic: &str, tests: &str) -> Result<(), Box<dyn Error>> {
    if !tests.is_empty() {
        writeln!(modules, "mod {topic} {{\n{tests}}}")?;
    }
    Ok(())
}

/// The tests of a machine in a file.
fn tests(text: &str, file: &str, machine: &str) -> String {
    let (ending, attributes, on) = match machine {
        "simulator" => ("", "#[test]", "Simulator"),
        "board" => ("", BOARD, "Board(isostep_sim::Port::Pio)"),
        _ => ("_by_the_timer_port", BOARD, "Board(isostep_sim::Port::Timer)"),
    };
    let dialogues = text.split("\n=== ").skip(1).chain(text.strip_prefix("=== "));
    let test = |dialogue: &str| {
        let machines = dialogue.lines().find_map(|line| line.strip_prefix("on: ")).unwrap_or("simulator");
        if !machines.split(' ').any(|name| name == machine) || !has_image(dialogue, machine) {
            return String::new();
        }
        let ending = if machines == machine { "" } else { ending };
        let name = dialogue.lines().next().unwrap_or_default();
        format!(
            "{attributes}\nfn {name}{ending}() {{\n    use isostep_tests::dialogue::{{On, carry_out_file}};\n    \
             carry_out_file({file:?}, {name:?}, On::{on});\n}}\n"
        )
    };
    dialogues.map(test).collect()
}

const BOARD: &str = "#[test]\n#[ignore = \"needs the firmware: cargo xtask test\"]";

/// True if there is an image for a dialogue: with three axes there is one of four, and not by the timer port.
fn has_image(dialogue: &str, machine: &str) -> bool {
    let is_four = env::var_os("CARGO_FEATURE_FOUR_AXES").is_some();
    is_four || machine == "board" || !dialogue.contains("\nwith four axes\n")
}
