//! The hub: it alone talks to the board, for all pages and for the job. It has the board as long as a page is there or a job runs.
//!
//! ```text
//! page -- Session --+                      +-- Talk: whose lines are under way
//! page -- Session --+-- Hub: one task -----+-- Job: a program that goes on without pages
//!                                          +-- Cable: the serial port
//! ```

use std::collections::BTreeMap;
use std::time::Duration;

use axum::extract::ws::Message;
use isostep_console::Error;
use isostep_console::realtime::{self, Realtime};
use isostep_sim::stream::asked_tool;
use tokio::sync::mpsc::{Receiver, Sender};
use tokio::sync::oneshot;
use tokio::time::{self, Instant, MissedTickBehavior};

use super::Board;
use super::cable::Cable;
use super::job::{Job, State};
use super::message::Told;
use super::talk::{Line, Owner, Talk};
use crate::console::Status;

/// The machine is asked how it is so often.
const ASK_EVERY: Duration = Duration::from_millis(200);
/// Questions of pages that come sooner after another are answered by the next report.
const ASKED_APART: Duration = Duration::from_millis(100);
/// Pages are told of the job's progress so often.
const TELL_EVERY: Duration = Duration::from_millis(200);
/// Time that a board may take to say what it does. One that says nothing may move.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// A board that has said nothing for so long has answered all that it was asked.
const SILENCE: Duration = Duration::from_millis(100);
/// A report that is older than this may be of before a jog.
pub const REPORTED: Duration = Duration::from_millis(400);
/// Time that pages may take to hear why the server ends.
const GOODBYE: Duration = Duration::from_secs(2);

const STATUS: u8 = b'?';
const HOLD: u8 = b'!';
const RESET: u8 = 0x18;
const JOG_CANCEL: u8 = 0x85;

/// What a page wants of the hub.
pub enum Wish {
    /// The board; this is where the page hears.
    Come(Sender<Message>),
    /// These bytes are for the board.
    Send(Vec<u8>),
    /// This program is to be sent, or why it must not be.
    Start(Box<Result<Job, String>>),
    /// The program of the job.
    Program,
    /// Nothing: it has gone.
    Go,
}

/// A page that has the board.
struct Page {
    heard: Sender<Message>,
    /// What the board has said to it, and is not passed on yet.
    said: Vec<u8>,
    /// A line of it that has not ended yet.
    partial: Vec<u8>,
}

/// See above.
pub struct Hub {
    board: Board,
    cable: Option<Cable>,
    pages: BTreeMap<u64, Page>,
    talk: Talk,
    /// The last job, which may have ended.
    job: Option<Job>,
    /// How many jobs there have been.
    jobs: u64,
    asked_at: Instant,
    /// What pages know of the job, and since when.
    told: (Option<(State, usize)>, Instant),
    /// The page that has jogged last, and when it asked for it.
    jogs: Option<(u64, Instant)>,
    /// The message of M6, and whether the machine has waited for the tool since.
    tool: Option<(String, bool)>,
    /// The alarm of which the words come next has just been raised.
    is_alarm_new: bool,
    /// Why the board does not take what it was sent.
    trouble: Option<String>,
}

impl Hub {
    /// Nobody has the board.
    pub fn new(board: Board) -> Self {
        Self {
            board,
            cable: None,
            pages: BTreeMap::new(),
            talk: Talk::default(),
            job: None,
            jobs: 0,
            asked_at: Instant::now(),
            told: (None, Instant::now()),
            jogs: None,
            tool: None,
            is_alarm_new: false,
            trouble: None,
        }
    }

    /// Serves pages until the server ends, each by its number, and leaves the machine then. When this future is dropped, the machine is
    /// left as it is.
    pub async fn run(mut self, mut wishes: Receiver<(u64, Wish)>, mut ending: oneshot::Receiver<()>) {
        let mut ticks = time::interval(ASK_EVERY / 2);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                wish = wishes.recv() => match wish {
                    Some((page, wish)) => self.obey(page, wish).await,
                    None => return,
                },
                heard = hear(&mut self.cable) => match heard {
                    Ok(lines) => lines.iter().for_each(|line| self.hear(line)),
                    Err(why) => self.trouble = Some(why),
                },
                _ = ticks.tick() => self.ask(ASK_EVERY),
                _ = &mut ending => return self.end().await,
            }
            self.fill();
            self.tell_job();
            for gone in self.pass_on() {
                self.leave(gone).await;
            }
            if let Some(why) = self.trouble.take() {
                self.lose(&why);
            }
            if self.pages.is_empty() && self.job.as_ref().is_none_or(Job::is_over) {
                (self.cable, self.tool) = (None, None);
            }
        }
    }

    async fn obey(&mut self, page: u64, wish: Wish) {
        match wish {
            Wish::Come(heard) => self.welcome(page, heard),
            Wish::Send(bytes) => bytes.into_iter().for_each(|byte| self.take(page, byte)),
            Wish::Start(job) => {
                if let Err(why) = self.start(*job) {
                    self.tell(page, &Told::Refused { why: &why });
                }
            }
            Wish::Program => {
                if let (Some(Job { name, text, before, .. }), Some(page)) = (&self.job, self.pages.get(&page)) {
                    let _ = page.heard.try_send(Told::Program { name, text, before }.message());
                }
            }
            Wish::Go => self.leave(page).await,
        }
    }

    /// Lends a page the board, and tells it of the job.
    fn welcome(&mut self, number: u64, heard: Sender<Message>) {
        let mut page = Page { heard, said: Vec::new(), partial: Vec::new() };
        if self.cable.is_none() {
            match Cable::open(&self.board) {
                Ok(cable) => (self.cable, self.talk) = (Some(cable), Talk::default()),
                Err(error) => return dismiss(&page, &format!("{error:#}")),
            }
        }
        if let Some(job) = &self.job {
            let _ = page.heard.try_send(Told::Job(job.now()).message());
        }
        page.said = self.tool.iter().flat_map(|(message, _)| format!("{message}\r\n").into_bytes()).collect();
        self.pages.insert(number, page);
        println!("a page has the board{}", self.others());
    }

    /// How many pages there are, if it is not one.
    fn others(&self) -> String {
        match self.pages.len() {
            1 => String::new(),
            count => format!(", {count} pages have it now"),
        }
    }

    /// A byte of a page: those that act at once go at once, lines when there is room.
    fn take(&mut self, number: u64, byte: u8) {
        let owner = Owner::Page(number);
        match realtime::classify(byte) {
            None => {
                let Some(page) = self.pages.get_mut(&number) else { return };
                page.partial.push(byte);
                if matches!(byte, b'\n' | b'\r') {
                    let line = Line { owner, bytes: std::mem::take(&mut page.partial) };
                    self.take_line(number, line);
                }
            }
            Some(Realtime::Status) => self.ask(ASKED_APART),
            Some(Realtime::Reset) => self.reset(),
            Some(Realtime::ToolChange) if !self.talk.begin_by_hand() => {}
            Some(Realtime::JogCancel) if self.another_jogs(number) => {}
            Some(at_once) => {
                if at_once == Realtime::JogCancel {
                    self.talk.cancel_jogs(owner);
                }
                self.send(&[byte]);
            }
        }
    }

    fn take_line(&mut self, number: u64, mut line: Line) {
        if line.is_jog() && self.another_jogs(number) {
            line = Line::refused(line.owner);
        } else if line.is_jog() {
            self.jogs = Some((number, Instant::now()));
        }
        self.talk.push(line);
        self.fill();
    }

    /// Another page jogs. Until it has let go and the machine rests, jogs of this page are refused, and a jog is not cancelled by it.
    fn another_jogs(&self, number: u64) -> bool {
        let Some((page, since)) = self.jogs.filter(|(page, _)| *page != number) else { return false };
        let says_jog = self.talk.status.as_ref().is_some_and(|status| status.state == "Jog");
        says_jog || since.elapsed() < REPORTED || self.talk.has_jogs(Owner::Page(page))
    }

    /// Sends what there is room for.
    fn fill(&mut self) {
        let number = self.jobs;
        while self.cable.is_some() {
            let job = &self.job;
            let of_job = || Some(Line { owner: Owner::Job(number), bytes: job.as_ref()?.next()?.to_vec() });
            let Some(Line { owner, bytes }) = self.talk.next(of_job).cloned() else { return };
            if let (Owner::Job(_), Some(job)) = (owner, &mut self.job) {
                job.go_on();
            }
            self.send(&bytes);
        }
    }

    fn send(&mut self, bytes: &[u8]) {
        if let Some(cable) = &mut self.cable
            && let Err(why) = cable.send(bytes)
        {
            self.trouble.get_or_insert(why);
        }
    }

    /// Asks how the machine is, unless that was asked a short time ago.
    fn ask(&mut self, apart: Duration) {
        if self.asked_at.elapsed() >= apart {
            self.asked_at = Instant::now();
            self.send(&[STATUS]);
        }
    }

    /// The machine forgets all lines of all pages, and of the job.
    fn reset(&mut self) {
        self.send(&[RESET]);
        self.talk.reset();
        self.forget();
    }

    fn forget(&mut self) {
        self.pages.values_mut().for_each(|page| page.partial.clear());
        self.tool = None;
        self.job.iter_mut().for_each(Job::reset);
    }

    fn start(&mut self, job: Result<Job, String>) -> Result<(), String> {
        let job = job?;
        if let Some(now) = self.job.as_ref().filter(|job| !job.is_over()) {
            return Err(format!("{} is being sent, {}: wait for its end, or stop it", now.name, now.place()));
        }
        let state = self.talk.status.as_ref().map_or("not known yet", |status| &status.state);
        if !["Idle", "Check"].contains(&state) {
            return Err(format!("a program is begun in Idle or Check, and the state is {state}"));
        }
        println!("{} is sent", job.name);
        (self.job, self.jobs, self.tool) = (Some(job), self.jobs + 1, None);
        self.tell_job_now();
        Ok(())
    }

    /// Passes a line of the board on to those whom it concerns.
    fn hear(&mut self, line: &str) {
        if line == "ok" || line.starts_with("error:") {
            return self.answer(line);
        }
        if line.starts_with('<') {
            Status::read(line).into_iter().for_each(|status| self.look(status));
        } else if line.starts_with("Grbl ") {
            self.talk.begin();
            self.forget();
        } else if line.starts_with("ALARM:") {
            self.job.iter_mut().for_each(|job| job.alarm(line));
            self.is_alarm_new = true;
        } else if let Some(page) = self.printed_for(line) {
            return self.say_to(page, line);
        }
        if line.strip_prefix("[MSG:").and_then(asked_tool).is_some() {
            self.tool = Some((line.to_owned(), false));
            // Pages name the tool by the line that asks for it.
            self.tell_job_now();
        }
        self.say(line);
    }

    fn answer(&mut self, answer: &str) {
        let Some(line) = self.talk.answered() else { return };
        if let (Some(setting), "ok") = (line.setting(), answer) {
            self.say_to_others(line.owner, setting);
        }
        match line.owner {
            Owner::Page(number) if line.is_refused() => {
                self.say_to(number, "[MSG:Another page jogs: wait until it lets go]");
                self.say_to(number, &format!("error:{}", Error::NotIdle.code()));
            }
            Owner::Page(number) if self.pages.contains_key(&number) => self.say_to(number, answer),
            // It was in the machine when its page went.
            Owner::Page(_) if line.is_jog() => self.send(&[JOG_CANCEL]),
            Owner::Page(_) => {}
            Owner::Job(number) => {
                let job = self.job.as_mut().filter(|_| number == self.jobs);
                if job.is_some_and(|job| !job.answer(answer)) {
                    self.stop();
                }
            }
        }
    }

    fn look(&mut self, status: Status) {
        self.talk.look(status.clone());
        let waits = self.talk.waits();
        self.tool.take_if(|(_, has_waited)| !waits && *has_waited);
        self.tool.iter_mut().for_each(|(_, has_waited)| *has_waited |= waits);
        if self.job.as_mut().is_some_and(|job| !job.look(&status, waits)) {
            self.stop();
        }
    }

    /// Lines behind one that was refused are on their way: the machine forgets them.
    fn stop(&mut self) {
        self.send(&[HOLD]);
        self.reset();
    }

    /// The page that has asked for this to be printed. Messages are for all, except the words that a page asks for.
    fn printed_for(&mut self, line: &str) -> Option<u64> {
        let is_of_alarm = std::mem::take(&mut self.is_alarm_new);
        let head = self.talk.head()?;
        let is_asked_for = !line.starts_with("[MSG:") || head.asks_for_words() && !is_of_alarm;
        match head.owner {
            Owner::Page(number) if is_asked_for && self.pages.contains_key(&number) => Some(number),
            _ => None,
        }
    }

    fn say(&mut self, line: &str) {
        for page in self.pages.values_mut() {
            page.say(line);
        }
    }

    /// A setting that has changed is known to its page by the answer, and to others by this.
    fn say_to_others(&mut self, owner: Owner, line: &str) {
        let others = self.pages.iter_mut().filter(|(number, _)| Owner::Page(**number) != owner);
        others.for_each(|(_, page)| page.say(line));
    }

    fn say_to(&mut self, page: u64, line: &str) {
        self.pages.get_mut(&page).into_iter().for_each(|page| page.say(line));
    }

    fn tell(&mut self, page: u64, told: &Told<'_>) {
        if let Some(page) = self.pages.get_mut(&page) {
            let _ = page.pass_on() && page.heard.try_send(told.message()).is_ok();
        }
    }

    /// Tells pages of the job if its state has changed, or if it has come on since some time.
    fn tell_job(&mut self) {
        let Some(now) = self.job.as_ref().map(Job::now) else { return };
        let (known, since) = self.told;
        let is_new = known.is_none_or(|(state, _)| state != now.state);
        if known != Some((now.state, now.answered)) && (is_new || since.elapsed() >= TELL_EVERY) {
            self.tell_job_now();
        }
        if let Some(job) = self.job.as_ref().filter(|job| is_new && job.is_over()) {
            println!("{}: {}", job.name, job.words());
        }
    }

    fn tell_job_now(&mut self) {
        let Some(job) = &self.job else { return };
        let now = job.now();
        self.told = (Some((now.state, now.answered)), Instant::now());
        let message = Told::Job(now).message();
        for page in self.pages.values_mut() {
            let _ = page.pass_on() && page.heard.try_send(message.clone()).is_ok();
        }
    }

    /// Passes on what the board has said. Returns the pages that do not take it.
    fn pass_on(&mut self) -> Vec<u64> {
        self.pages.iter_mut().filter_map(|(&number, page)| (!page.pass_on()).then_some(number)).collect()
    }

    /// A page has gone: its jog is cancelled, unless another page jogs.
    async fn leave(&mut self, number: u64) {
        if self.pages.remove(&number).is_none() {
            return;
        }
        self.talk.forget_waiting(Owner::Page(number));
        if self.pages.is_empty() || self.jogs.is_some_and(|(page, _)| page == number) {
            self.send(&[JOG_CANCEL]);
        }
        match self.job.as_ref().filter(|job| !job.is_over()) {
            Some(job) if self.pages.is_empty() => println!("the page has gone: {} goes on, {}", job.name, job.place()),
            _ if self.pages.is_empty() => println!("the page has gone: {}", self.hold().await),
            _ => println!("a page has gone{}", self.others()),
        }
    }

    /// Nobody looks at the machine any more: unless it is idle, it is held. Says what was done.
    async fn hold(&mut self) -> &'static str {
        if self.trouble.is_some() {
            return "the board is gone too";
        }
        if time::timeout(LAST_WORDS, self.is_idle()).await.unwrap_or(false) {
            return "the machine was idle";
        }
        self.send(&[HOLD]);
        "a jog is cancelled, a program held"
    }

    /// The machine says that it is idle, twice: the first report may be an answer to a page, and of a time before its last line.
    async fn is_idle(&mut self) -> bool {
        if !self.says_idle().await {
            return false;
        }
        while let Ok(Ok(lines)) = time::timeout(SILENCE, hear(&mut self.cable)).await {
            lines.iter().for_each(|line| self.hear(line));
        }
        self.says_idle().await
    }

    /// Asks whether the machine is idle, and whether it has answered every line that may move it.
    async fn says_idle(&mut self) -> bool {
        self.talk.status = None;
        self.send(&[STATUS]);
        while self.talk.status.is_none()
            && let Ok(lines) = hear(&mut self.cable).await
        {
            lines.iter().for_each(|line| self.hear(line));
        }
        !self.talk.may_move() && self.talk.status.as_ref().is_some_and(|status| status.state == "Idle")
    }

    /// The board is gone, and with it every page's session, and the job.
    fn lose(&mut self, why: &str) {
        println!("the board is gone: {why}");
        self.job.iter_mut().for_each(|job| job.lose(&format!("the board is gone ({why}).")));
        self.tell_job();
        self.cable = None;
        let words = format!("the board is gone ({why}): plug it in, then connect again");
        std::mem::take(&mut self.pages).values().for_each(|page| dismiss(page, &words));
    }

    /// The server ends: the machine is left as by a page that goes, also if a job runs.
    async fn end(mut self) {
        if self.cable.is_some() {
            self.send(&[JOG_CANCEL]);
            let done = self.hold().await;
            let job = self.job.as_ref().filter(|job| !job.is_over());
            let words = job.map_or_else(String::new, |job| format!("; {} has not ended, {}", job.name, job.place()));
            println!("ending: {done}{words}");
        }
        for page in self.pages.values() {
            dismiss(page, "the server has ended: start it again, and open the address that it prints");
        }
        let closed = async {
            for page in self.pages.values() {
                page.heard.closed().await;
            }
        };
        let _ = time::timeout(GOODBYE, closed).await;
    }
}

impl Page {
    fn say(&mut self, line: &str) {
        self.said.extend(line.bytes().chain(*b"\r\n"));
    }

    /// Passes on what the board has said. Returns false if the page does not take it: it has gone, or does not read.
    fn pass_on(&mut self) -> bool {
        self.said.is_empty() || self.heard.try_send(Message::binary(std::mem::take(&mut self.said))).is_ok()
    }
}

/// Says to a page why it has no board. A page that has gone already needs no words.
fn dismiss(page: &Page, why: &str) {
    let _ = page.heard.try_send(Told::Ended { why }.message());
    let _ = page.heard.try_send(Message::Close(None));
}

/// What the board says next; nothing as long as nobody has it. When this future is dropped, nothing is lost.
async fn hear(cable: &mut Option<Cable>) -> Result<Vec<String>, String> {
    match cable {
        Some(cable) => cable.hear().await,
        None => std::future::pending().await,
    }
}
