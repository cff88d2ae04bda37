//! `isostep web`: serves the page on this computer, and lends it a board.
//!
//! ```text
//! browser -- HTTP -------- Access -- Page: its files, in memory
//!         -- WebSocket --- Access -- Session -- Hub: pages and a job share the board -- Cable -- the serial port
//! ```

mod access;
mod cable;
mod hub;
mod job;
mod message;
mod page;
mod server;
mod session;
mod talk;
#[cfg(all(test, unix))]
mod tests;

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use anyhow::{Result, ensure};

pub use page::Page;
pub use server::Server;

use crate::console::port;

const HTTP_PORT: u16 = 8000;
const BAUD: u32 = 115_200;

/// Serve the page: programs on the simulated machine, and a board to operate
#[derive(clap::Args)]
#[command(after_help = "\
It serves this computer alone, until Ctrl-C. With --port it prints an address with a token, new each time: whoever has it can
operate the board, several pages at a time. When a page is closed, its jog is cancelled. A program that it has sent goes on.

Examples:
  isostep web --open                                   the page, http://127.0.0.1:8000, in the browser
  isostep web --port                                   and the board: the one USB device 2e8a:000a or 2e8a:0009
  isostep web --port /dev/ttyACM0                      and the board on this port
  isostep web --port --listen 192.168.1.5              for other computers too: not encrypted, see docs/security.md
  isostep web --page target/web --port /tmp/isostep    a page of `cargo xtask web`, and the machine of `isostep sim --pty`")]
pub struct Args {
    /// Serve the page in this folder, not that in the tool
    #[arg(long, value_name = "FOLDER")]
    page: Option<PathBuf>,
    #[command(flatten)]
    serving: Serving,
}

/// The ways to serve the page.
#[derive(clap::Args, Default, PartialEq, Eq)]
pub struct Serving {
    /// Let the page operate the board on this port [without a name: the board on USB]
    #[arg(long, value_name = "PORT", num_args = 0..=1)]
    port: Option<Option<String>>,
    /// With --port: bits a second; a USB port has its own [default: 115200]
    #[arg(long, value_name = "N", requires = "port", value_parser = clap::value_parser!(u32).range(300..=4_000_000))]
    baud: Option<u32>,
    /// The address of this computer at which others may have the page [default: 127.0.0.1, for this computer alone]
    #[arg(long, value_name = "ADDRESS", value_parser = address)]
    listen: Option<IpAddr>,
    /// Open the page in the browser. With a board its address has a token, which other programs would see: click on it instead
    #[arg(long, conflicts_with = "port")]
    open: bool,
    /// The port of HTTP [default: 8000]
    #[arg(long, value_name = "N")]
    http_port: Option<u16>,
}

impl Serving {
    /// Nothing is asked for but the page, for this computer alone.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// An address of this computer. `localhost` is one in every browser.
fn address(text: &str) -> Result<IpAddr, String> {
    match text.parse() {
        Ok(address) => Ok(address),
        Err(_) if text.eq_ignore_ascii_case("localhost") => Ok(IpAddr::V4(Ipv4Addr::LOCALHOST)),
        Err(_) => {
            Err("an address of this computer, such as 192.168.1.5 (`ip address` lists them), or localhost".to_owned())
        }
    }
}

/// A board that the page may operate: its port, and bits a second.
pub struct Board {
    port: Option<String>,
    baud: u32,
}

impl Board {
    /// The board on this port; without a name the only one on USB, whatever its port is called when it is asked for.
    pub fn new(port: Option<String>, baud: u32) -> Self {
        Self { port, baud }
    }

    /// The name of its port, which is there.
    fn name(&self) -> Result<String> {
        match &self.port {
            None => port::find_board(),
            Some(name) => port::find(name).map(|()| name.clone()),
        }
    }
}

/// Runs the verb.
pub fn run(args: Args) -> Result<()> {
    let page = args.page.map_or_else(Page::own, |folder| Page::read(&folder))?;
    serve(page, args.serving)
}

/// Serves a page until Ctrl-C.
///
/// # Errors
/// When the address cannot be had, or no board is found.
pub fn serve(page: Page, serving: Serving) -> Result<()> {
    let board = serving.port.map(|port| Board::new(port, serving.baud.unwrap_or(BAUD)));
    let name = board.as_ref().map(Board::name).transpose()?;
    let at = serving.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST));
    ensure!(!at.is_unspecified(), "{at} is no address to type: name the one by which others reach this computer");
    let server = Server::bind(page, board, SocketAddr::new(at, serving.http_port.unwrap_or(HTTP_PORT)))?;
    println!("{} until Ctrl-C", server.address());
    if let Some(name) = name {
        println!("whoever has this address may operate the board on {name}");
    }
    if !at.is_loopback() {
        println!("nothing on the way is encrypted: use it in a network that you trust");
    }
    crate::screen::finish()?;
    if serving.open
        && let Err(why) = open::that_detached(server.address())
    {
        eprintln!("note: no browser was opened ({why}): open {} yourself", server.address());
    }
    server.run()
}
