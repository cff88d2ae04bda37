//! The server with a client of its own, and a simulated machine or a scripted one on a pseudo-terminal.
#![expect(clippy::disallowed_methods, reason = "a client waits for a machine that is paced to the wall clock")]

use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::thread;
use std::time::Duration;

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

    /// Reads until `words` have come, of the board or of the server.
    fn hear(&mut self, words: &str) -> String {
        let stopwatch = Stopwatch::start();
        let mut heard = String::new();
        while !heard.contains(words) {
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?} in {heard:?}");
            match self.0.read() {
                Ok(Message::Binary(bytes)) => heard += std::str::from_utf8(&bytes).unwrap(),
                Ok(Message::Text(text)) => heard += &format!("<<{}>>", text.as_str()),
                Ok(_) | Err(tungstenite::Error::Io(_)) => {}
                Err(error) => panic!("{error} after {heard:?}"),
            }
        }
        heard
    }

    /// Asks for reports until one has these words.
    fn ask(&mut self, words: &str) {
        let stopwatch = Stopwatch::start();
        loop {
            self.say(b"?");
            if self.hear(">\r\n").contains(words) {
                return;
            }
            assert!(stopwatch.elapsed_s() < PATIENCE_S, "no {words:?}");
        }
    }
}

#[test]
fn the_page_is_served_with_its_policy_and_nothing_else_is() {
    let (host, _) = served("files", None);
    let own = format!("Host: {host}\r\n");
    let index = get(&host, "/", &own);
    assert!(index.starts_with("HTTP/1.1 200") && index.ends_with(INDEX), "{index}");
    for header in [
        "content-type: text/html; charset=utf-8\r\n",
        "content-security-policy: default-src 'none'; frame-ancestors 'none'\r\n",
        "x-content-type-options: nosniff\r\n",
        "cross-origin-opener-policy: same-origin\r\n",
        "cache-control: no-cache\r\n",
    ] {
        assert!(index.contains(header), "no {header} in {index}");
    }
    assert!(get(&host, "/programs/a.nc", &own).ends_with("\r\n\r\nG0 X1"));
    assert!(get(&host, "/board.json", &own).ends_with("{\"has_board\":false}"));
    for path in
        ["/../Cargo.toml", "/%2e%2e/Cargo.toml", "/programs/../../../etc/passwd", "//etc/passwd", "/none", "/programs"]
    {
        let answer = get(&host, path, &own);
        assert!(answer.starts_with("HTTP/1.1 404"), "{path}: {answer}");
        assert!(answer.contains("content-security-policy: "), "{path}: {answer}");
    }
}

#[test]
fn what_is_compressed_is_sent_to_those_who_read_it() {
    let (host, _) = served("gzip", None);
    let gzip = get(&host, "/main.js", &format!("Host: {host}\r\nAccept-Encoding: deflate, gzip\r\n"));
    assert!(gzip.contains("content-encoding: gzip\r\n") && gzip.contains("text/javascript"), "{gzip}");
    assert!(gzip.ends_with("compressed"), "{gzip}");
    let brotli = get(&host, "/main.js", &format!("Host: {host}\r\nAccept-Encoding: gzip, br;q=1\r\n"));
    assert!(brotli.contains("content-encoding: br\r\n") && brotli.ends_with("smaller"), "{brotli}");
    let plain = get(&host, "/main.js", &format!("Host: {host}\r\n"));
    assert!(plain.ends_with("\r\n\r\n1") && !plain.contains("content-encoding"), "{plain}");
}

#[test]
fn a_server_goes_by_its_own_name_alone() {
    let (host, _) = served("host", None);
    let port = host.rsplit(':').next().unwrap();
    assert!(get(&host, "/", &format!("Host: LocalHost:{port}\r\n")).starts_with("HTTP/1.1 200"));
    for (headers, name) in [
        (format!("Host: evil.example:{port}\r\n"), format!("evil.example:{port}")),
        ("Host: 127.0.0.1\r\n".to_owned(), "127.0.0.1".to_owned()),
    ] {
        let answer = get(&host, "/", &headers);
        assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
        assert!(answer.contains(&format!("`{name}` is not how this server is called: use http://{host}")), "{answer}");
    }
}

#[test]
fn a_board_is_for_our_page_with_its_token() {
    let (host, token) = served("gate", Some(Path::new("/dev/none")));
    assert_eq!(token.len(), 32);
    let own = format!("http://{host}");
    let refused = |origin: &str, query: &str| Client::from(&host, origin, query).err().unwrap();
    for origin in ["http://evil.example", "null", "", &format!("https://{host}"), "http://127.0.0.1"] {
        let words = refused(origin, &format!("?token={token}"));
        assert!(words.starts_with("403") && words.contains("may not operate the board"), "{origin}: {words}");
    }
    let (wrong, longer) = (format!("?token={}", "0".repeat(32)), format!("?token={token}0"));
    for query in ["", "?token=", &wrong, &longer, &format!("?token={}", &token[1..])] {
        let words = refused(&own, query);
        assert!(words.starts_with("403") && words.contains("the token is missing or old"), "{query}: {words}");
    }
    let mut client = Client::open(&host, &token);
    assert!(client.hear(">>").starts_with("<</dev/none: there is no such port"));
    assert_ne!(served("other", Some(Path::new("/dev/none"))).1, token);
}

#[test]
fn one_page_at_a_time_has_the_board_and_the_next_takes_it_over() {
    while_running(20.0, |path| {
        let (host, token) = served("turn", Some(path));
        let mut first = Client::open(&host, &token);
        first.hear("Grbl 1.1");
        let first = thread::spawn(move || {
            // Longer than the second waits for its turn.
            for _ in 0..40 {
                first.ask("<Idle");
                thread::sleep(Duration::from_millis(100));
            }
            first
        });
        let mut second = Client::open(&host, &token);
        assert_eq!(second.hear(">>"), "<<another page has the board: close that one, then connect again>>");
        drop(first.join().unwrap());
        let mut third = Client::open(&host, &token);
        third.hear("Grbl 1.1");
        third.ask("<Idle");
    });
}

#[test]
fn a_jog_is_cancelled_and_a_program_held_when_the_page_goes() {
    for (line, state) in [("$J=G91 X300 F600\n", "Idle"), ("G1 X300 F600\nG1 X0\n", "Hold:0")] {
        let (_, closing) = while_running(1.0, |path| {
            let (host, token) = served("gone", Some(path));
            let mut client = Client::open(&host, &token);
            client.hear("Grbl 1.1");
            client.say(line.as_bytes());
            client.ask("|MPos:1.");
            drop(client);
            let mut next = Client::open(&host, &token);
            next.ask(&format!("<{state}|"));
        });
        assert_eq!(closing.state, state);
        assert!((50..2500).contains(&closing.position_steps[0]), "{:?}", closing.position_steps);
    }
}

#[test]
fn a_server_that_ends_holds_the_program_and_tells_the_page() {
    let (_, closing) = while_running(1.0, |path| {
        let (server, host, token) = bound("ends", Some(path));
        let (end, ended) = tokio::sync::oneshot::channel();
        let running = thread::spawn(move || server.serve_until(async { Ok(ended.await?) }));
        let mut client = Client::open(&host, &token);
        client.hear("Grbl 1.1");
        client.say(b"G1 X300 F600\n");
        client.ask("|MPos:1.");
        end.send(()).unwrap();
        client.hear("<<the server has ended");
        running.join().unwrap().unwrap();
        let (host, token) = served("ended", Some(path));
        Client::open(&host, &token).ask("<Hold:0|");
    });
    assert_eq!(closing.state, "Hold:0");
}

/// A page on a computer that sleeps closes nothing.
#[test]
fn a_page_that_answers_no_ping_has_gone() {
    let (_, closing) = while_running(1.0, |path| {
        let (host, token) = served("asleep", Some(path));
        let mut client = Client::open(&host, &token);
        client.hear("Grbl 1.1");
        client.say(b"$J=G91 X300 F600\n");
        client.ask("<Jog");
        // It answers pings only while it reads.
        let mut next = Client::open(&host, &token);
        next.ask("<Idle|");
    });
    assert!((50..5000).contains(&closing.position_steps[0]), "{:?}", closing.position_steps);
}

/// The bytes that go to a board once its page has gone. The page has said this, and has heard `before`; the board answers each `?`
/// that comes later by the next of `answers`, and then by the last.
fn last_bytes(name: &str, said: &[u8], before: &str, answers: &[&[u8]]) -> String {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served(name, Some(pty.path()));
    let mut client = Client::open(&host, &token);
    client.say(said);
    let wait = || thread::sleep(Duration::from_millis(1));
    let mut heard = Vec::new();
    while heard.len() < said.len() {
        pty.look().unwrap();
        heard.extend(pty.read().unwrap());
        wait();
    }
    if !before.is_empty() {
        pty.write(before.as_bytes()).unwrap();
        client.hear(before);
    }
    drop(client);
    let (stopwatch, mut answers, mut sent) = (Stopwatch::start(), answers.iter().peekable(), Vec::new());
    // Longer than the server waits for an answer.
    while stopwatch.elapsed_s() < 1.6 {
        pty.look().unwrap();
        let bytes = pty.read().unwrap();
        for _ in bytes.iter().filter(|&&byte| byte == b'?') {
            let answer = answers.next().expect("an answer");
            pty.write(answer).unwrap();
            if answers.peek().is_none() {
                answers = std::slice::from_ref(answer).iter().peekable();
            }
        }
        sent.extend(bytes);
        wait();
    }
    sent.escape_ascii().to_string()
}

const IDLE: &str = "<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n";
const RUN: &str = "<Run|MPos:0.000,0.000,0.000|FS:0,0>\r\n";

#[test]
fn a_machine_that_is_idle_is_not_held_and_one_that_is_silent_is() {
    let leaving = |name, answer: &[u8]| last_bytes(name, b"$$\n", "ok\r\n", &[answer]);
    assert_eq!(leaving("idle", IDLE.as_bytes()), r"\x85??");
    assert_eq!(leaving("run", RUN.as_bytes()), r"\x85?!");
    assert_eq!(leaving("silent", b""), r"\x85?!");
}

/// A report that the page has heard is of earlier.
#[test]
fn a_machine_that_was_idle_when_the_page_last_asked_is_asked_anew() {
    let before = format!("{IDLE}ok\r\n");
    assert_eq!(last_bytes("anew", b"?G1X9F60\n", &before, &[RUN.as_bytes()]), r"\x85?!");
    assert_eq!(last_bytes("anew-idle", b"?G1X9F60\n", &before, &[IDLE.as_bytes()]), r"\x85??");
}

#[test]
fn a_machine_that_is_idle_is_held_while_a_line_is_not_answered() {
    assert_eq!(last_bytes("line", b"G1X9F60\n", "", &[IDLE.as_bytes()]), r"\x85?!");
    assert_eq!(last_bytes("second", b"G1X9F60\nG1X0\n", "ok\r\n", &[IDLE.as_bytes()]), r"\x85?!");
    let welcome = "\r\nGrbl 1.1h ['$' for help]\r\n";
    assert_eq!(last_bytes("reset", b"G1X9F60\n\x18", welcome, &[IDLE.as_bytes()]), r"\x85??", "the line is forgotten");
}

/// The page has asked just before it went: the answer comes later, and tells of the time before the line.
#[test]
fn an_answer_to_the_page_is_not_taken_for_one_to_the_server() {
    let late = format!("{IDLE}ok\r\n");
    let answers = [late.as_bytes(), RUN.as_bytes()];
    assert_eq!(last_bytes("late", b"?G1X9F60\n", "", &answers), r"\x85??!");
}

/// The line is in the machine before it moves.
#[test]
fn a_line_of_a_page_that_goes_at_once_is_held() {
    let (_, closing) = while_running(1.0, |path| {
        let (host, token) = served("at-once", Some(path));
        let mut client = Client::open(&host, &token);
        client.hear("Grbl 1.1");
        client.ask("<Idle|");
        client.say(b"G1 X300 F600\n");
        drop(client);
        let mut next = Client::open(&host, &token);
        next.ask("<Hold:0|");
    });
    assert_eq!(closing.state, "Hold:0");
    assert!(closing.position_steps[0] < 500, "{:?}", closing.position_steps);
}

#[test]
fn a_board_that_is_unplugged_is_reported_and_taken_again() {
    let folder = std::env::temp_dir().join(format!("isostep-unplugged-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let link = folder.join("port");
    let mut pty = Pty::open(Some(&link)).unwrap();
    let (host, token) = served("unplugged", Some(&link));
    let mut client = Client::open(&host, &token);
    client.say(b"?");
    while !pty.read().unwrap().contains(&b'?') {
        thread::sleep(Duration::from_millis(1));
    }
    drop(pty);
    let words = client.hear(">>");
    assert!(words.contains("the board is gone (") && words.contains("plug it in, then connect again"), "{words}");
    let mut pty = Pty::open(Some(&link)).unwrap();
    let mut client = Client::open(&host, &token);
    client.say(b"?");
    while !pty.read().unwrap().contains(&b'?') {
        thread::sleep(Duration::from_millis(1));
    }
    drop(pty);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn what_cannot_be_served_is_reported_with_its_remedy() {
    let taken = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let refused = |at: SocketAddr| Server::bind(page("taken"), None, at).err().unwrap().to_string();
    let words = refused(taken.local_addr().unwrap());
    assert!(words.starts_with("another program has port ") && words.contains("--http-port"), "{words}");
    let words = refused("192.0.2.1:8000".parse().unwrap());
    assert!(words.starts_with("192.0.2.1 is no address of this computer"), "{words}");
    if option_env!("ISOSTEP_PAGE").is_none() {
        let none = Page::own().err().unwrap().to_string();
        assert!(none.contains("built without the page") && none.contains("cargo xtask web --install"), "{none}");
    }
    let none = Page::read(Path::new("/dev")).err().unwrap().to_string();
    assert!(none.contains("/dev has no page in it") && none.contains("cargo xtask web"), "{none}");
}
