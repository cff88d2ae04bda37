//! Writes a `#[test]` for each dialogue of `tests/dialogues`, so that `cargo test NAME` finds it.

use std::error::Error;
use std::fmt::Write;
use std::path::Path;
use std::{env, fs};

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=dialogues");
    let mut tests = String::new();
    let mut files: Vec<_> =
        fs::read_dir("dialogues")?.map(|entry| Ok(entry?.path())).collect::<Result<_, Box<dyn Error>>>()?;
    files.sort();
    for path in files.iter().filter(|path| path.extension().is_some_and(|extension| extension == "txt")) {
        let (file, topic) = (path.file_name(), path.file_stem());
        let (file, topic) = file.zip(topic).ok_or("a file without a name")?;
        writeln!(tests, "mod {} {{", topic.display())?;
        for name in fs::read_to_string(path)?.lines().filter_map(|line| line.strip_prefix("=== ")) {
            writeln!(tests, "#[test]\nfn {name}() {{ isostep_tests::dialogue::carry_out_file({file:?}, {name:?}); }}")?;
        }
        writeln!(tests, "}}")?;
    }
    fs::write(Path::new(&env::var("OUT_DIR")?).join("dialogues.rs"), tests)?;
    Ok(())
}
