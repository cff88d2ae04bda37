//! Tests the page in Chromium: on the simulated machine, and on the emulated board behind `isostep web`.

use std::fs;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use anyhow::{Context, Result};
use isostep::web::{Board, Page, Server};
use isostep_report::listing::Listing;
use isostep_sim::{Config, trace};

use crate::process::{self, announce};
#[cfg(unix)]
use crate::toolchain::cargo;
use crate::{toolchain, workspace};

/// Chromium by the names that it has on systems.
const CHROMIUMS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// The packages that the user has to install before the page can be tested; `None` if it can.
pub fn missing() -> Option<&'static str> {
    chromium().is_none().then_some("install Chromium, on Debian by `apt-get install chromium`")
}

/// Runs the tests of the page on this folder.
pub fn test(page: &Path) -> Result<()> {
    let shots = workspace::target_dir().join("web-shots");
    let native = workspace::target_dir().join("web-parking.csv");
    write_native_trace(&native)?;
    let listed = workspace::target_dir().join("web-listed.txt");
    write_native_listing(&listed)?;
    let address = served(page, None)?;
    let mut tests = tests(&address, &shots)?;
    tests.arg("--trace").arg(native).arg("--listed").arg(listed);
    with_emulated_board(page, &mut tests, |tests| {
        announce(&format!("the page in Chromium, pictures in {}", workspace::shown(&shots)));
        process::run(tests)
    })?;
    test_faults(page, &address, &shots)
}

/// The tests of the page at this address.
fn tests(address: &str, shots: &Path) -> Result<Command> {
    let mut tests = Command::new("node");
    tests.arg(workspace::root().join("web").join("test").join("page.mjs"));
    tests.arg("--chromium").arg(found()?).arg("--page").arg(address).arg("--shots").arg(shots);
    Ok(tests)
}

/// Tests faults of one part alone, for which the board and the server are processes of their own.
#[cfg(unix)]
fn test_faults(page: &Path, address: &str, shots: &Path) -> Result<()> {
    announce("the tool, which serves the page");
    process::run(cargo("build").args(["--package", "isostep", "--bin", "isostep"]))?;
    announce("faults with the emulated board");
    let mut tests = tests(address, shots)?;
    tests.arg("--server").arg(workspace::target_dir().join("debug").join("isostep")).arg("--folder").arg(page);
    tests.arg("--emulator").arg(std::env::current_exe()?).args(["--only", "fault: "]);
    process::run(&mut tests)
}

#[cfg(not(unix))]
fn test_faults(_: &Path, _: &str, _: &Path) -> Result<()> {
    Ok(())
}

/// Tells the tests where the page is that has the emulated board.
#[cfg(unix)]
fn with_emulated_board(page: &Path, tests: &mut Command, run: impl FnOnce(&mut Command) -> Result<()>) -> Result<()> {
    use crate::variant::Variant;
    use crate::{build, clients, node};
    use isostep::pty::{self, Emulated};

    /// Near the switches, so that homing is short.
    const START: &str = "--start=2,2,2";

    node::prepare()?;
    build::firmware(Variant::default())?;
    announce("the emulated board");
    let power_up = || Emulated::start(clients::emulator().arg(START), true, &[]);
    pty::while_running(1.0, power_up, |port| {
        let board = Board::new(Some(port.display().to_string()), BAUD);
        run(tests.arg("--board").arg(served(page, Some(board))?))
    })?;
    Ok(())
}

/// A USB port has its own speed.
#[cfg(unix)]
const BAUD: u32 = 115_200;

/// Windows has no pseudo-terminals, which the board would be behind.
#[cfg(not(unix))]
fn with_emulated_board(_: &Path, tests: &mut Command, run: impl FnOnce(&mut Command) -> Result<()>) -> Result<()> {
    run(tests)
}

/// Serves the page until this process ends, and returns its address.
pub fn served(page: &Path, board: Option<Board>) -> Result<String> {
    let server = Server::bind(Page::read(page)?, board, SocketAddr::from((Ipv4Addr::LOCALHOST, 0)))?;
    let address = server.address();
    thread::spawn(move || server.serve());
    Ok(address)
}

/// The trace that the page's must equal.
fn write_native_trace(to: &Path) -> Result<()> {
    let program = fs::read(workspace::root().join("programs").join("parking.nc"))?;
    let outcome = isostep_sim::run(&program, &Config { keep_waves: false, ..Config::default() })?;
    let file = fs::File::create(to).with_context(|| format!("cannot write {}", to.display()))?;
    Ok(trace::write(&outcome.edges, file)?)
}

/// What `isostep check --settings --write` takes of a listing, which the page must take too.
fn write_native_listing(to: &Path) -> Result<()> {
    let text = fs::read(workspace::root().join("crates/report/tests/listings/longmill-mk3.txt"))?;
    let listing = Listing::read("longmill-mk3.txt", &text, &Config::default());
    fs::write(to, listing.text()).with_context(|| format!("cannot write {}", to.display()))
}

/// The path of Chromium.
pub fn found() -> Result<PathBuf> {
    chromium().with_context(|| missing().unwrap_or_default())
}

fn chromium() -> Option<PathBuf> {
    let found = toolchain::path_dirs().flat_map(|dir| CHROMIUMS.map(|name| dir.join(name)));
    found.into_iter().find(|binary| binary.is_file())
}
