//! A name of a type stands for one thing in all that ships, so a reader who has met it knows what it means.

use std::collections::BTreeMap;

use isostep_architecture::{files, read, root};

/// The packages of which the gantry's images are made.
const SHIPPING: [&str; 7] = [
    "crates/profile",
    "crates/motion",
    "crates/console",
    "crates/controller",
    "boards/pico-gantry",
    "boards/rp2040-floats",
    "boards/rp2350-floats",
];

/// Names that two files declare for one thing.
const ONE_THING: [&str; 3] = [
    // A crate's README, whose examples are compiled as tests.
    "Readme", // The change of a driver, of which there is none without UART drivers.
    "News",   // Of the one chip and of the other.
    "VectorAlignment",
];

/// The name of the type that a line declares, unless it is one of a function or a trait.
fn declared(line: &str) -> Option<&str> {
    let is_local = line.starts_with(' ') && !line.trim_start().starts_with("pub ");
    let mut words = line.trim_start().split(' ').skip_while(|word| word.starts_with("pub") || *word == "unsafe");
    let is_type = matches!(words.next()?, "struct" | "enum" | "union" | "trait" | "type");
    let name = words.next()?.split(|c: char| !c.is_alphanumeric()).next()?;
    // A type that an alias narrows down keeps its name.
    let is_narrowed = line.split_once(" = ").is_some_and(|(_, of)| of.contains(&format!("{name}<")));
    (is_type && !is_local && !is_narrowed && !ONE_THING.contains(&name)).then_some(name)
}

/// The names that several of these files declare, with the places.
fn declared_twice(texts: &[(String, String)]) -> Vec<String> {
    let mut places = BTreeMap::<_, BTreeMap<_, _>>::new();
    for (file, text) in texts {
        for (line, name) in (1..).zip(text.lines().map(declared)) {
            name.map(|name| places.entry(name).or_default().insert(file, line));
        }
    }
    places.retain(|_, files| files.len() > 1);
    places.iter().map(|(name, files)| format!("{name}: {files:?}")).collect()
}

#[test]
fn a_name_of_a_type_stands_for_one_thing() {
    let is_source = |path: &str| path.ends_with(".rs") && !path.ends_with("tests.rs");
    let all = SHIPPING.iter().flat_map(|package| files(&root().join(package).join("src")));
    let texts = all.map(|file| (file.strip_prefix(root()).unwrap().display().to_string(), read(&file)));
    let texts: Vec<_> = texts.filter(|(file, _)| is_source(file)).collect();
    let count = texts.iter().flat_map(|(_, text)| text.lines()).filter_map(declared).count();
    assert!(count > 300, "{count}");
    assert_eq!(declared_twice(&texts), [""; 0], "rename one of them in the words of the field, or make them one");
}

#[test]
fn a_name_for_two_things_is_found() {
    let found = |texts: [&str; 2]| {
        let files = ["a.rs", "b.rs"].map(str::to_owned).into_iter();
        declared_twice(&files.zip(texts.map(str::to_owned)).collect::<Vec<_>>())
    };
    assert_eq!(found(["\npub struct Door<'a> {", "pub(super) enum Door {"]), [r#"Door: {"a.rs": 2, "b.rs": 1}"#]);
    assert_eq!(found(["pub unsafe trait Door {", "codes! {\n    pub enum Door {\n"]).len(), 1, "that of a macro, too");
    assert_eq!(found(["struct Door;\nimpl Door {", "    struct Door;\n/// struct Door\nuse Door;"]), [""; 0]);
    assert_eq!(found(["pub struct Door<T> {", "type Door = other::Door<u8>;"]), [""; 0], "for one parameter");
    assert_eq!(found(["#[cfg(a)]\ntype Door = A;\n#[cfg(b)]\ntype Door = B;", ""]), [""; 0], "by features");
}
