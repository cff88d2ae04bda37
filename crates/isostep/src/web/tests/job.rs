//! A program that the server sends.

use super::*;

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
