//! Verbs whose output is not read to its end, as with `| head`, and verbs whose output cannot be written.

use std::process::{Command, Stdio};

const PARKING: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../programs/parking.nc");
const TABLE: [&str; 5] = ["profile", "--speed-profile=trapezoid", "--steps=400", "--top-speed=2400", "--accel=2500"];

fn verb(arguments: &[&str]) -> Command {
    let mut verb = Command::new(env!("CARGO_BIN_EXE_isostep"));
    verb.args(arguments).stdin(Stdio::null());
    verb
}

/// Runs the verb with both outputs going into a pipe that nobody reads any more.
fn ends_well_unread(arguments: &[&str]) {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = verb(arguments).stdout(writer.try_clone().unwrap()).stderr(writer).status().unwrap();
    assert!(status.success(), "{arguments:?}: {status}");
}

#[test]
fn a_table_that_nobody_reads() {
    ends_well_unread(&TABLE);
}

#[test]
fn a_run_of_a_program_that_nobody_watches() {
    ends_well_unread(&["sim", PARKING]);
}

#[test]
fn a_list_that_nobody_reads() {
    ends_well_unread(&["console", "--list"]);
}

#[test]
fn help_and_version_that_nobody_reads() {
    ends_well_unread(&["--help"]);
    ends_well_unread(&["check", "--help"]);
    ends_well_unread(&["--version"]);
}

/// A tool that is installed is called in folders that have no programs.
#[test]
fn a_program_is_built_in() {
    let output = verb(&["sim"]).current_dir(std::env::temp_dir()).output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{printed}");
    assert!(
        printed.starts_with("programs/parking.nc (built in) in virtual time\nSEED=1  again: isostep sim --seed 1\n"),
        "{printed}"
    );
    let again = verb(&["sim", PARKING, "--seed", "1"]).output().unwrap();
    let behind = |text: &str| text.split_once("homing").unwrap().1.to_owned();
    assert_eq!(behind(&printed), behind(&String::from_utf8(again.stdout).unwrap()));
}

/// A run is repeated with the options that its report was drawn with.
#[test]
fn the_width_of_the_beam_is_reported() {
    let printed = about("beam.nc", "$32=1\nM4 S800\nG1 X5 F600\nM2\n", &["sim", "--beam", "0.3"]);
    assert!(printed.contains(" --beam 0.3\n"), "{printed}");
}

#[test]
fn jumpers_for_diag_are_reported_and_refused_where_no_driver_has_a_uart() {
    let program = "G1 X5 F600\nM2\n";
    let printed = about("diag.nc", program, &["sim", "--board", "skr-pico", "--diag", "Y,x"]);
    assert!(printed.contains(" --board skr-pico --diag X,Y\n"), "{printed}");
    let printed = about("no-diag.nc", program, &["sim", "--diag", "X"]);
    assert_eq!(printed, "error: --diag: the drivers of a pico have no UART: use --board skr-pico\n");
}

/// A folder that `isostep web` takes for a page.
fn page(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("isostep-page-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(
        folder.join("index.html"),
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'self'\">",
    )
    .unwrap();
    folder
}

#[test]
fn a_page_is_not_served_for_a_port_that_is_not_there() {
    let folder = page("nope");
    let output = verb(&["web", "--http-port", "0", "--port", "/dev/nope", "--page"]).arg(&folder).output().unwrap();
    let printed = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(
        printed.starts_with("error: /dev/nope: there is no such port: `isostep console --list` shows them"),
        "{printed}"
    );
    std::fs::remove_dir_all(folder).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn a_page_is_served_without_a_browser_too() {
    use std::io::{BufRead, BufReader};
    let folder = page("open");
    let mut server = verb(&["web", "--http-port", "0", "--listen", "localhost", "--open", "--page"]);
    server.arg(&folder).env("PATH", "").stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut server = server.spawn().unwrap();
    let line = |output: &mut dyn std::io::Read| BufReader::new(output).lines().next().unwrap().unwrap();
    let reported = line(server.stdout.as_mut().unwrap());
    let address = reported.strip_suffix(" until Ctrl-C").unwrap();
    assert!(address.starts_with("http://127.0.0.1:"), "{reported}");
    let noted = line(server.stderr.as_mut().unwrap());
    assert!(
        noted.starts_with("note: no browser was opened (") && noted.ends_with(&format!("): open {address} yourself")),
        "{noted}"
    );
    let host = address.strip_prefix("http://").unwrap().trim_end_matches('/');
    std::net::TcpStream::connect(host).unwrap();
    server.kill().unwrap();
    server.wait().unwrap();
    std::fs::remove_dir_all(folder).unwrap();
}

/// Writes `program` to a file, and returns what the verb prints about it, errors too.
fn about(name: &str, program: &str, arguments: &[&str]) -> String {
    let path = std::env::temp_dir().join(format!("isostep-{}-{name}", std::process::id()));
    std::fs::write(&path, program).unwrap();
    let (verb_name, options) = arguments.split_first().unwrap();
    let output = verb(&[verb_name, path.to_str().unwrap()]).args(options).output().unwrap();
    std::fs::remove_file(path).unwrap();
    String::from_utf8([output.stdout, output.stderr].concat()).unwrap()
}

/// The same options place a plate for both verbs, and both tell where it was touched.
#[test]
fn a_touch_of_the_plate_is_printed_by_check_and_sim() {
    for name in ["check", "sim"] {
        let arguments = [name, "--start", "35,40,15", "--probe-plate", "Z,12.5,below"];
        let printed = about(&format!("probe-{name}.nc"), "G21 G91\nG38.2 Z-10 F60\nG0 Z2\nM2\n", &arguments);
        assert!(printed.contains("line 2: [PRB:0.000,0.000,-2.500:1]\n"), "{printed}");
    }
}

#[test]
fn a_dark_pierce_is_printed_by_check_and_sim() {
    for name in ["check", "sim"] {
        let printed = about(&format!("pierce-{name}.nc"), "$32=1\nM3 S800\nG4 P0.5\nG1 X5 F600\nM5\nM2\n", &[name]);
        assert!(
            printed.contains("the laser does not pierce at line 3: it is dark wherever nothing moves"),
            "{printed}"
        );
    }
}

/// The first run that README shows is what a first run prints.
#[test]
fn the_readme_shows_what_is_printed() {
    let readme = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../README.md")).unwrap();
    let printed = String::from_utf8(verb(&["sim"]).output().unwrap().stdout).unwrap();
    let sample = readme.split_once("```\nprograms/parking.nc").unwrap().1.split_once("```").unwrap().0;
    let mut lines = sample.lines().skip(1).filter(|line| line.trim() != "...");
    assert!(lines.clone().count() > 6);
    assert!(lines.all(|line| printed.lines().any(|printed| printed == line)), "{sample}\nin\n{printed}");
}

/// Runs the verb with its output going to a full disk.
#[cfg(target_os = "linux")]
#[track_caller]
fn says_that_the_disk_is_full(arguments: &[&str]) {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = verb(arguments).stdout(full).stderr(Stdio::piped()).output().unwrap();
    let reported = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {reported}");
    let error =
        "error: what is printed here cannot be written to standard output: No space left on device (os error 28)\n";
    assert!(reported.ends_with(error), "{arguments:?}: {reported}");
    assert!(!reported.contains("panicked"), "{arguments:?}: {reported}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_by_every_verb_that_prints() {
    let folder = std::env::temp_dir().join(format!("isostep-full-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    std::fs::write(file("grbl.csv"), "program,A_s\nshort.nc,100\n").unwrap();
    std::fs::write(file("short.nc"), "G0 X1\nM2\n").unwrap();
    says_that_the_disk_is_full(&TABLE);
    says_that_the_disk_is_full(&["sim", PARKING]);
    says_that_the_disk_is_full(&["check", PARKING]);
    says_that_the_disk_is_full(&["times", folder.to_str().unwrap(), &file("grbl.csv")]);
    says_that_the_disk_is_full(&["papers", "--report", folder.to_str().unwrap()]);
    says_that_the_disk_is_full(&["console", "--list"]);
    says_that_the_disk_is_full(&["--help"]);
    says_that_the_disk_is_full(&["sim", "--help"]);
    says_that_the_disk_is_full(&["--version"]);
    std::fs::remove_dir_all(folder).unwrap();
}

/// The user could not know the port of such a machine.
#[cfg(target_os = "linux")]
#[test]
fn a_machine_whose_port_cannot_be_reported_does_not_start() {
    says_that_the_disk_is_full(&["sim", "--pty", "--for-s", "1000000"]);
}
