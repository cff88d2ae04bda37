//! The server with a client of its own, and a simulated machine or a scripted one on a pseudo-terminal.
#![expect(clippy::disallowed_methods, reason = "a client waits for a machine that is paced to the wall clock")]

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
    assert!(client.hear(">>").starts_with("<<{\"is\":\"ended\",\"why\":\"/dev/none: there is no such port"));
    assert_ne!(served("other", Some(Path::new("/dev/none"))).1, token);
}

#[test]
fn a_jog_is_cancelled_and_a_program_held_when_the_page_goes() {
    for (line, state) in [("$J=G91 X300 F600\n", "Idle"), ("G1 X300 F600\nG1 X0\n", "Hold:0")] {
        let (_, closing) = while_running(1.0, |path| {
            let (host, token) = served("gone", Some(path));
            let mut client = Client::open(&host, &token);
            client.hear("Grbl 1.1");
            client.say(line.as_bytes());
            client.ask_x();
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
    for is_job in [false, true] {
        let (_, closing) = while_running(1.0, |path| {
            let (server, host, token) = bound("ends", Some(path));
            let (end, ended) = tokio::sync::oneshot::channel();
            let running = thread::spawn(move || server.serve_until(async { Ok(ended.await?) }));
            let mut client = Client::open(&host, &token);
            client.hear("Grbl 1.1");
            if is_job {
                client.start("G1 X300 F300\n");
            } else {
                client.say(b"G1 X300 F300\n");
            }
            client.ask_x();
            end.send(()).unwrap();
            client.hear("the server has ended");
            running.join().unwrap().unwrap();
            let (host, token) = served("ended", Some(path));
            Client::open(&host, &token).ask("<Hold:0|");
        });
        assert_eq!(closing.state, "Hold:0");
    }
}

/// A page whose script hangs, and one on a computer that sleeps, close nothing.
#[test]
fn a_page_that_answers_no_question_has_gone_and_its_jog_is_cancelled() {
    let (_, closing) = while_running(1.0, |path| {
        let (host, token) = served("asleep", Some(path));
        let mut client = Client::open(&host, &token);
        client.hear("Grbl 1.1");
        client.say(b"$J=G91 X300 F600\n");
        client.ask("<Jog");
        // It answers only while it reads.
        let mut next = Client::open(&host, &token);
        next.ask("<Idle|");
        client.hear("this page has not answered for 2 s");
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
    let said = String::from_utf8_lossy(said).replace('?', "");
    reads(&mut pty, &said);
    if !before.is_empty() {
        pty.write(before.as_bytes()).unwrap();
        client.hear(before.trim_start());
    }
    drop(client);
    let (stopwatch, mut answers, mut sent) = (Stopwatch::start(), answers.iter().peekable(), Vec::new());
    // Longer than the server waits for an answer.
    while stopwatch.elapsed_s() < 1.6 {
        pty.look().unwrap();
        // Before the page went the server may have asked for a report itself.
        let mut bytes = pty.read().unwrap();
        if sent.is_empty() {
            bytes.drain(..bytes.iter().position(|&byte| byte == 0x85).unwrap_or(bytes.len()));
        }
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
    assert_eq!(last_bytes("query", b"$$\n", "", &[IDLE.as_bytes()]), r"\x85??", "it moves nothing");
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
fn each_page_hears_its_own_answers_and_all_hear_reports() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("two", Some(pty.path()));
    let (mut first, mut second) = (Client::open(&host, &token), Client::open(&host, &token));
    first.say(b"$G\n");
    reads(&mut pty, "$G\n");
    second.say(b"$E20\nG0 X");
    reads(&mut pty, "$E20\n");
    first.say(b"G0 X1\n");
    reads(&mut pty, "G0 X1\n");
    second.say(b"2\n");
    reads(&mut pty, "G0 X2\n");
    let said = "[GC:G0 G54]\r\nok\r\n[MSG:words]\r\nok\r\nerror:20\r\nok\r\n[MSG:for all]\r\n";
    pty.write(format!("{said}{IDLE}").as_bytes()).unwrap();
    assert_eq!(first.hear(">\r\n"), format!("[GC:G0 G54]\r\nok\r\nerror:20\r\n[MSG:for all]\r\n{IDLE}"));
    assert_eq!(second.hear(">\r\n"), format!("[MSG:words]\r\nok\r\nok\r\n[MSG:for all]\r\n{IDLE}"));
}

#[test]
fn a_setting_that_one_page_changes_is_told_to_the_others() {
    while_running(20.0, |path| {
        let (host, token) = served("set", Some(path));
        let (mut first, mut second) = (Client::open(&host, &token), Client::open(&host, &token));
        // The welcome may have come before the second.
        second.ask("<Idle");
        first.say(b"$110=0\n$110=2000\n");
        let heard = second.hear("$110=2000\r\n");
        assert!(!heard.contains("$110=0\r\n") && !heard.contains("ok\r\n"), "{heard}");
        assert!(!first.hear("ok\r\n").contains("$110=2000\r\n"));
    });
}

/// Only the jog of the page that goes is cancelled, also if the machine answers it later.
#[test]
fn a_page_that_goes_leaves_the_jog_of_another() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("jogs", Some(pty.path()));
    let (mut first, mut second) = (Client::open(&host, &token), Client::open(&host, &token));
    let third = Client::open(&host, &token);
    first.say(b"$J=X1F1\n");
    reads(&mut pty, "$J=X1F1\n");
    drop(third);
    first.say(b"$G\n");
    assert_eq!(reads(&mut pty, "$G\n"), "$G\n");
    drop(first);
    reads(&mut pty, "\u{85}");
    pty.write(b"ok\r\nok\r\n").unwrap();
    reads(&mut pty, "\u{85}");
    second.say(b"$$\n");
    reads(&mut pty, "$$\n");
    pty.write(b"ok\r\n").unwrap();
    assert_eq!(second.hear("ok\r\n"), "ok\r\n");
}

#[test]
fn one_page_jogs_at_a_time_and_only_its_own_letting_go_counts() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("turns", Some(pty.path()));
    let (mut first, mut second) = (Client::open(&host, &token), Client::open(&host, &token));
    first.say(b"$J=X1F1\n");
    reads(&mut pty, "$J=X1F1\n");
    pty.write(b"ok\r\n<Jog|MPos:0,0,0|FS:0,0>\r\n").unwrap();
    second.hear(">\r\n");
    second.say(b"$J=Y1F1\n\x85$G\n");
    let sent = reads(&mut pty, "$G\n");
    assert!(
        sent.contains("(refused: another page jogs)\n") && !sent.contains('Y') && !sent.contains('\u{85}'),
        "{sent}"
    );
    pty.write(b"ok\r\nok\r\n").unwrap();
    assert_eq!(second.hear("ok\r\n"), "[MSG:Another page jogs: wait until it lets go]\r\nerror:8\r\nok\r\n");
    first.say(b"\x85");
    reads(&mut pty, "\u{85}");
    // A report that was made before the jog says Idle too.
    thread::sleep(super::hub::REPORTED);
    pty.write(IDLE.as_bytes()).unwrap();
    second.hear(">\r\n");
    second.say(b"$J=Y1F1\n\x85");
    let sent = reads(&mut pty, "\u{85}");
    assert!(sent.contains("$J=Y1F1\n"), "{sent}");
}

#[test]
fn pages_that_ask_for_reports_do_not_ask_more_often_together() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("often", Some(pty.path()));
    let mut clients: Vec<_> = (0..4).map(|_| Client::open(&host, &token)).collect();
    let (stopwatch, mut asked) = (Stopwatch::start(), 0);
    while stopwatch.elapsed_s() < 1.0 {
        clients.iter_mut().for_each(|client| client.say(b"?"));
        pty.look().unwrap();
        asked += pty.read().unwrap().iter().filter(|&&byte| byte == b'?').count();
        thread::sleep(Duration::from_millis(5));
    }
    assert!((2..=11).contains(&asked), "{asked}");
}

/// Lines of a job, 1 mm each.
fn millimetres(count: usize) -> String {
    format!("G21 G91 F600\n{}", "G1 X1\n".repeat(count))
}

#[test]
fn a_job_goes_on_when_its_page_is_closed_and_a_page_that_comes_finds_its_line() {
    while_running(4.0, |path| {
        let (host, token) = served("goes-on", Some(path));
        let mut first = Client::open(&host, &token);
        first.hear("Grbl 1.1");
        first.start(&millimetres(150));
        assert!(
            first
                .hear("\"state\":\"sending\"")
                .contains(r#"{"is":"job","name":"a.nc","lines":151,"answered":0,"last":0,"line":1,"#)
        );
        first.ask("<Run");
        drop(first);
        let mut second = Client::open(&host, &token);
        let found = second.hear(">>");
        assert!(found.contains("\"state\":\"sending\"") && !found.contains("\"line\":1,"), "{found}");
        second.want(json!({"do": "start", "name": "b.nc", "program": "G0 X1"}));
        second.hear("\"is\":\"refused\",\"why\":\"a.nc is being sent, line ");
        second.want(json!({"do": "program"}));
        second.hear("{\"is\":\"program\",\"name\":\"a.nc\",\"text\":\"G21 G91 F600\\nG1 X1\\n");
        let done = second.hear("\"state\":\"done\"");
        assert!(!done.contains("ok\r\n"), "the answers are the job's: {done}");
        second.ask("|MPos:150.000,");
        drop(second);
        let last = Client::open(&host, &token).hear(">>");
        assert!(last.contains("\"line\":null,\"end\":151,\"state\":\"done\",\"words\":\"Done: 151 lines.\""), "{last}");
    });
}

#[test]
fn a_program_that_must_not_be_sent_is_refused_in_words() {
    while_running(20.0, |path| {
        let (host, token) = served("refuses", Some(path));
        let mut client = Client::open(&host, &token);
        client.hear("Grbl 1.1");
        for (program, why) in [
            ("(nothing)\n", "the program has no line for the machine"),
            ("G0 X1 !\n", "line 1: '!' is a real-time command"),
        ] {
            client.start(program);
            client.hear(&format!("{{\"is\":\"refused\",\"why\":\"{why}"));
        }
        client.say(b"$SLP\n");
        client.ask("<Sleep");
        client.want(json!({"do": "start", "name": "a.nc", "program": "G0 X1"}));
        client.hear("a program is begun in Idle or Check, and the state is Sleep");
    });
}

#[test]
fn a_refused_line_an_alarm_and_a_reset_end_a_job_in_words_for_all_pages() {
    while_running(1.0, |path| {
        let (host, token) = served("ends-job", Some(path));
        let (mut first, mut second) = (Client::open(&host, &token), Client::open(&host, &token));
        // The welcome may have come before the second.
        second.ask("<Idle");
        first.start("G21 G91\n(none)\nG42 X1\nG1 X50 F1200\n");
        let heard = second.hear("Grbl 1.1");
        assert!(heard.contains("Stopped: line 3 `G42 X1` was refused. error:20: "), "{heard}");
        first.start(&millimetres(200));
        first.ask("<Run");
        second.say(b"!\x18");
        first.hear("\"state\":\"stopped\",\"words\":\"Stopped by a reset, line ");
        first.hear("Grbl 1.1");
        second.hear("Grbl 1.1");
        second.start("G21 G91\nG38.2 Z-2 F300\nG1 X1\n");
        first.hear("\"words\":\"Stopped by an alarm, line 2 was next to be answered: ALARM:5: ");
        second.say(b"$X\n");
        second.hear("ok\r\n");
    });
}

#[test]
fn a_board_that_is_unplugged_ends_the_job() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("job-unplugged", Some(pty.path()));
    let mut client = Client::open(&host, &token);
    client.say(b"$G\n");
    reads(&mut pty, "$G\n");
    pty.write(format!("{IDLE}ok\r\n").as_bytes()).unwrap();
    client.hear("ok\r\n");
    client.want(json!({"do": "start", "name": "a.nc", "program": "G0 X1\nG0 X2\n"}));
    reads(&mut pty, "N1G0X1\nN2G0X2\n");
    drop(pty);
    let words = client.hear("\"is\":\"ended\"");
    assert!(words.contains("Stopped, line 1 was next to be answered: the board is gone ("), "{words}");
}

/// The answers to lines behind an alarm may come before it.
#[test]
fn a_locked_machine_ends_the_job_by_the_alarm_that_comes_or_by_the_refusal() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("locked", Some(pty.path()));
    let mut client = Client::open(&host, &token);
    client.say(b"$G\n");
    reads(&mut pty, "$G\n");
    pty.write(format!("{IDLE}ok\r\n").as_bytes()).unwrap();
    client.hear("ok\r\n");
    let program = "G38.2 X-9 F60\nG0 X2\n";
    client.want(json!({"do": "start", "name": "a.nc", "program": program}));
    reads(&mut pty, "N2G0X2\n");
    pty.write(b"error:9\r\nerror:9\r\nALARM:1\r\n").unwrap();
    client.hear("Stopped by an alarm, line 1 was next to be answered: ALARM:1: ");
    pty.write(IDLE.as_bytes()).unwrap();
    client.hear(IDLE);
    client.want(json!({"do": "start", "name": "a.nc", "program": program}));
    let sent = reads(&mut pty, "N2G0X2\n");
    assert!(!sent.contains('\u{18}'), "an alarm needs no reset: {sent:?}");
    pty.write(b"error:9\r\nerror:9\r\n<Jog|MPos:0,0,0|FS:0,0>\r\n").unwrap();
    client.hear("Stopped: line 1 `G38.2 X-9 F60` was refused. error:9: ");
    reads(&mut pty, "!\u{18}");
}

#[test]
fn a_change_of_the_tool_is_made_by_hand_while_the_job_waits() {
    let mut pty = Pty::open(None).unwrap();
    let (host, token) = served("tool", Some(pty.path()));
    let mut first = Client::open(&host, &token);
    first.say(b"$G\n");
    reads(&mut pty, "$G\n");
    pty.write(format!("{IDLE}ok\r\n").as_bytes()).unwrap();
    first.hear("ok\r\n");
    let rest = "G0 X1\n".repeat(30);
    first.want(json!({"do": "start", "name": "a.nc", "program": format!("T1 M6\n{rest}")}));
    let sent = reads(&mut pty, "N16G0X1\n");
    let m6 = "[MSG:M6: put in tool 1, measure it ($TPW), then ~]\r\n";
    let tool = IDLE.replace("Idle", "Tool");
    pty.write(format!("{m6}ok\r\n{tool}").as_bytes()).unwrap();
    first.hear("\"state\":\"waiting\"");
    let mut second = Client::open(&host, &token);
    assert!(second.hear(m6).contains("\"answered\":1,\"last\":1,\"line\":2,\"end\":31,\"state\":\"waiting\""));
    second.say(b"\xA3$TPW\n");
    assert_eq!(reads(&mut pty, "\n"), "\u{a3}$TPW\n", "nothing of the job is sent in between");
    first.say(b"\xA3$J=X1F9\n");
    assert_eq!(reads(&mut pty, "\n"), "$J=X1F9\n", "the machine is told once");
    pty.write(b"ok\r\nerror:15\r\n").unwrap();
    second.hear("ok\r\n");
    first.hear("error:15\r\n");
    second.say(b"~");
    reads(&mut pty, "~");
    let lines = sent.lines().count() - 1;
    pty.write(format!("{RUN}{}", "ok\r\n".repeat(lines)).as_bytes()).unwrap();
    reads(&mut pty, "N31G0X1\n");
    pty.write(format!("{}{IDLE}", "ok\r\n".repeat(30 - lines)).as_bytes()).unwrap();
    first.hear("Done: 31 lines.");
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
