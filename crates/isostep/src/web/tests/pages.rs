//! Several pages at a time.

use super::*;

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
    thread::sleep(crate::web::hub::REPORTED);
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
