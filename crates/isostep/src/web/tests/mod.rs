//! The server with a client of its own, and a simulated machine or a scripted one on a pseudo-terminal.
#![expect(clippy::disallowed_methods, reason = "a client waits for a machine that is paced to the wall clock")]

mod files;
mod job;
mod leaving;
mod pages;

use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::thread;
use std::time::Duration;

use serde_json::json;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

use super::{Board, Page, Server};
use crate::pty::Pty;
use crate::pty::tests::while_running;
use crate::stopwatch::Stopwatch;

const PATIENCE_S: f64 = 20.0;
const INDEX: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'\">";

fn page(name: &str) -> Page {
    let folder = std::env::temp_dir().join(format!("isostep-page-{name}-{}", std::process::id()));
    fs::create_dir_all(folder.join("programs")).unwrap();
    fs::write(folder.join("index.html"), INDEX).unwrap();
    fs::write(folder.join("main.js"), "1").unwrap();
    fs::write(folder.join("main.js.gz"), "compressed").unwrap();
    fs::write(folder.join("main.js.br"), "smaller").unwrap();
    fs::write(folder.join("programs").join("a.nc"), "G0 X1").unwrap();
    let page = Page::read(&folder).unwrap();
    fs::remove_dir_all(folder).unwrap();
    page
}

/// A server, the host by which it is called, and the token.
fn bound(name: &str, port: Option<&Path>) -> (Server, String, String) {
    let board = port.map(|port| Board::new(Some(port.display().to_string()), 115_200));
    let server = Server::bind(page(name), board, SocketAddr::from((Ipv4Addr::LOCALHOST, 0))).unwrap();
    let address = server.address();
    let (host, rest) = address.strip_prefix("http://").unwrap().split_once('/').unwrap();
    (server, host.to_owned(), rest.rsplit('=').next().unwrap_or_default().to_owned())
}

/// The same, with the server running until the tests end.
fn served(name: &str, port: Option<&Path>) -> (String, String) {
    let (server, host, token) = bound(name, port);
    thread::spawn(move || server.serve());
    (host, token)
}

/// The answer to a request, headers and all.
fn get(host: &str, path: &str, headers: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// A page's side of the board.
struct Client(WebSocket<TcpStream>);

impl Client {
    fn open(host: &str, token: &str) -> Self {
        Self::from(host, &format!("http://{host}"), &format!("?token={token}")).unwrap()
    }

    fn from(host: &str, origin: &str, query: &str) -> Result<Self, String> {
        let mut request = format!("ws://{host}/board{query}").into_client_request().unwrap();
        request.headers_mut().insert("origin", origin.parse().unwrap());
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
        match tungstenite::client(request, stream) {
            Ok((socket, _)) => Ok(Self(socket)),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(format!("{} {}", answer.status(), String::from_utf8_lossy(answer.body().as_ref().unwrap())))
            }
            Err(error) => panic!("{error}"),
        }
    }

    fn say(&mut self, bytes: &[u8]) {
        self.0.send(Message::binary(bytes.to_vec())).unwrap();
    }

    fn want(&mut self, what: serde_json::Value) {
        self.0.send(Message::text(what.to_string())).unwrap();
    }

    fn start(&mut self, program: &str) {
        self.ask("<Idle");
        self.want(json!({"do": "start", "name": "a.nc", "program": program}));
    }

    /// Reads until `words` have come, of the board or of the server, and answers that it is there.
    fn hear(&mut self, words: &str) -> String {
        let stopwatch = Stopwatch::start();
        let mut heard = String::new();
        while !heard.contains(words) {
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?} in {heard:?}");
            match self.0.read() {
                Ok(Message::Binary(bytes)) => heard += std::str::from_utf8(&bytes).unwrap(),
                Ok(Message::Text(text)) if text.as_str() == "{\"is\":\"alive?\"}" => {
                    // The server may have closed meanwhile.
                    let _ = self.0.send(Message::text("{\"do\":\"alive\"}"));
                }
                Ok(Message::Text(text)) => heard += &format!("<<{}>>", text.as_str()),
                Ok(_) | Err(tungstenite::Error::Io(_)) => {}
                Err(error) => panic!("{error} after {heard:?}"),
            }
        }
        heard
    }

    /// Asks for reports until one has these words.
    fn ask(&mut self, words: &str) {
        self.ask_until(words, |report| report.contains(words));
    }

    /// Asks for reports until X has passed 1 mm.
    fn ask_x(&mut self) {
        let x = |report: &str| report.split("|MPos:").nth(1)?.split(',').next()?.parse::<f64>().ok();
        self.ask_until("1 mm", |report| x(report).is_some_and(|x| x >= 1.0));
    }

    fn ask_until(&mut self, words: &str, is_it: impl Fn(&str) -> bool) {
        let stopwatch = Stopwatch::start();
        loop {
            self.say(b"?");
            if is_it(&self.hear(">\r\n")) {
                return;
            }
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?}");
        }
    }
}

/// Waits until a scripted board has these bytes, beside the `?` of the server. Returns what it has.
fn reads(pty: &mut Pty, text: &str) -> String {
    let (stopwatch, mut heard) = (Stopwatch::start(), String::new());
    while !heard.contains(text) {
        assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {text:?} in {heard:?}");
        pty.look().unwrap();
        let bytes = pty.read().unwrap();
        heard.extend(bytes.iter().filter(|&&byte| byte != b'?').map(|&byte| char::from(byte)));
        thread::sleep(Duration::from_millis(1));
    }
    heard
}

const IDLE: &str = "<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n";
const RUN: &str = "<Run|MPos:0.000,0.000,0.000|FS:0,0>\r\n";
