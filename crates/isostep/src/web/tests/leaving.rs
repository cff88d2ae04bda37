//! What becomes of the machine when a page goes, the server ends, or the board is gone.

use super::*;

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
