//! The conversation with the machine: whose lines wait, which are under way, and what the machine has said of itself.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;

use crate::console::Status;
use crate::flight::WINDOW_BYTES;

/// The longest time that a machine takes to brake after a reset and to send its welcome.
const RESET_PATIENCE: Duration = Duration::from_secs(10);

/// Whose a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owner {
    /// A page's, by its number.
    Page(u64),
    /// A job's, by its number: one that has ended may have lines under way still.
    Job(u64),
}

/// A line with its end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    pub owner: Owner,
    pub bytes: Vec<u8>,
}

/// Sent instead of a line that is refused, so that its answer comes at its turn: the machine skips a comment.
const REFUSED: &[u8] = b"(refused: another page jogs)\n";

impl Line {
    /// It is not to be sent, and its owner is to hear so at its turn.
    pub fn refused(owner: Owner) -> Self {
        Self { owner, bytes: REFUSED.to_vec() }
    }

    /// See [`Line::refused`].
    pub fn is_refused(&self) -> bool {
        self.bytes == REFUSED
    }

    /// It is a jog.
    pub fn is_jog(&self) -> bool {
        self.bytes.get(..3).is_some_and(|begin| begin.eq_ignore_ascii_case(b"$J="))
    }

    /// It asks what a code means, which is printed as a message.
    pub fn asks_for_words(&self) -> bool {
        self.begins_with_any(b"EA")
    }

    /// It asks for something to be printed, and moves nothing.
    fn only_asks(&self) -> bool {
        self.begins_with_any(b"$#GIEA")
    }

    /// What it sets, as the machine lists it, if it is a setting.
    pub fn setting(&self) -> Option<&str> {
        let text = std::str::from_utf8(&self.bytes).ok()?.trim();
        let (number, _) = text.strip_prefix('$')?.split_once('=')?;
        (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(text)
    }

    fn begins_with_any(&self, commands: &[u8]) -> bool {
        matches!(self.bytes[..], [b'$', command, ..] if commands.contains(&command.to_ascii_uppercase()))
    }
}

/// A change of the tool, in which a person jogs and measures while the lines of the program wait.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Change {
    #[default]
    None,
    /// What is sent waits for the end of the change.
    Waits,
    /// What is sent is by hand, and answered before what waits.
    ByHand,
}

/// What was said and not answered.
#[derive(Default)]
pub struct Talk {
    /// Lines of pages that have not been sent.
    waiting: VecDeque<Line>,
    under_way: VecDeque<Line>,
    by_hand: VecDeque<Line>,
    change: Change,
    /// When the reset was sent whose welcome has not come. Lines of before the welcome are nobody's behind it.
    reset_at: Option<Instant>,
    /// The last report.
    pub status: Option<Status>,
}

impl Talk {
    /// A page's line, to be sent when there is room.
    pub fn push(&mut self, line: Line) {
        self.waiting.push_back(line);
    }

    /// The line to be sent now, if there is one: pages' lines go before this one of the job.
    pub fn next(&mut self, of_job: impl FnOnce() -> Option<Line>) -> Option<&Line> {
        self.reset_at.take_if(|at| at.elapsed() > RESET_PATIENCE);
        if self.reset_at.is_some() {
            return None;
        }
        let lane = if self.change == Change::ByHand { &mut self.by_hand } else { &mut self.under_way };
        let line = match self.waiting.front() {
            Some(line) if has_room(lane, line) => self.waiting.pop_front(),
            Some(_) => None,
            // In a change of the tool it would wait at best, and be taken for one by hand at worst.
            None if self.change != Change::None => None,
            None => of_job().filter(|line| has_room(lane, line)),
        };
        lane.push_back(line?);
        lane.back()
    }

    /// An answer has come: the line that it answers.
    pub fn answered(&mut self) -> Option<Line> {
        self.by_hand.pop_front().or_else(|| self.under_way.pop_front())
    }

    /// The line that is answered next.
    pub fn head(&self) -> Option<&Line> {
        self.by_hand.front().or_else(|| self.under_way.front())
    }

    /// A jog of this owner waits or is not answered.
    pub fn has_jogs(&self, owner: Owner) -> bool {
        let lanes = self.waiting.iter().chain(&self.by_hand).chain(&self.under_way);
        lanes.into_iter().any(|line| line.owner == owner && line.is_jog())
    }

    /// A line that may move the machine is not answered.
    pub fn may_move(&self) -> bool {
        self.by_hand.iter().chain(&self.under_way).any(|line| !line.only_asks())
    }

    /// Lines behind this are by hand. Returns false if the machine need not be told.
    pub fn begin_by_hand(&mut self) -> bool {
        let begins = self.change == Change::Waits;
        if begins {
            self.change = Change::ByHand;
        }
        begins
    }

    /// The machine has reported how it is.
    pub fn look(&mut self, status: Status) {
        match self.change {
            Change::None if status.is_tool() => self.change = Change::Waits,
            Change::Waits | Change::ByHand if !status.goes_on_changing() => self.change = Change::None,
            _ => {}
        }
        self.status = Some(status);
    }

    /// The machine waits for a person.
    pub fn waits(&self) -> bool {
        self.change != Change::None || self.status.as_ref().is_some_and(Status::is_held)
    }

    /// A reset is sent: the machine forgets all lines.
    pub fn reset(&mut self) {
        self.forget();
        self.reset_at = Some(Instant::now());
    }

    /// The machine begins anew.
    pub fn begin(&mut self) {
        self.forget();
        self.reset_at = None;
    }

    fn forget(&mut self) {
        self.waiting.clear();
        self.under_way.clear();
        self.by_hand.clear();
        self.change = Change::None;
    }

    /// This owner's lines that wait are sent no more.
    pub fn forget_waiting(&mut self, owner: Owner) {
        self.waiting.retain(|line| line.owner != owner);
    }

    /// Jogs of this owner that wait are cancelled. An empty line has their answer, at its turn.
    pub fn cancel_jogs(&mut self, owner: Owner) {
        self.waiting
            .iter_mut()
            .filter(|line| line.owner == owner && line.is_jog())
            .for_each(|line| line.bytes = b"\n".to_vec());
    }
}

/// A line that is longer than the window is sent when no other is under way.
fn has_room(lane: &VecDeque<Line>, line: &Line) -> bool {
    lane.is_empty() || lane.iter().map(|sent| sent.bytes.len()).sum::<usize>() + line.bytes.len() <= WINDOW_BYTES
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Owner = Owner::Page(1);
    const B: Owner = Owner::Page(2);
    const JOB: Owner = Owner::Job(1);

    fn line(owner: Owner, text: &str) -> Line {
        Line { owner, bytes: format!("{text}\n").into_bytes() }
    }

    /// What is sent by a job that has more lines.
    fn sent(talk: &mut Talk) -> Vec<String> {
        std::iter::from_fn(|| talk.next(|| Some(line(JOB, "G1X1"))).map(text)).collect()
    }

    fn text(line: &Line) -> String {
        String::from_utf8_lossy(&line.bytes).trim_end().to_owned()
    }

    fn report(talk: &mut Talk, state: &str) {
        talk.look(Status { state: state.to_owned(), place: vec![0.0; 3] });
    }

    #[test]
    fn pages_and_the_job_share_one_window_and_pages_go_first() {
        let mut talk = Talk::default();
        talk.push(line(A, &"(".repeat(99)));
        talk.push(line(B, "$G"));
        assert_eq!(sent(&mut talk), [&*"(".repeat(99), "$G", "G1X1", "G1X1", "G1X1", "G1X1", "G1X1"]);
        talk.push(line(B, "$$"));
        assert_eq!(sent(&mut talk), [""; 0], "there is no room");
        assert_eq!(talk.answered().map(|line| line.owner), Some(A));
        assert_eq!(sent(&mut talk)[0], "$$");
        assert_eq!(talk.head().map(|line| line.owner), Some(B));
    }

    #[test]
    fn a_line_by_hand_is_answered_before_the_jobs_which_wait() {
        let mut talk = Talk::default();
        assert_eq!(sent(&mut talk).len(), WINDOW_BYTES / 5);
        report(&mut talk, "Tool");
        assert!(talk.waits());
        assert!(talk.begin_by_hand() && !talk.begin_by_hand(), "the machine is told once");
        talk.push(line(A, "$TPW"));
        assert_eq!(sent(&mut talk), ["$TPW"], "it has a window of its own");
        report(&mut talk, "Jog");
        assert_eq!(talk.answered().map(|line| line.owner), Some(A));
        assert_eq!(talk.answered().map(|line| line.owner), Some(JOB));
        assert_eq!(sent(&mut talk), [""; 0]);
        report(&mut talk, "Run");
        assert_eq!(sent(&mut talk), ["G1X1"]);
        assert!(!talk.begin_by_hand());
    }

    #[test]
    fn a_reset_forgets_lines_of_all_and_so_does_the_welcome() {
        let mut talk = Talk::default();
        talk.push(line(A, "G0X1"));
        sent(&mut talk);
        talk.reset();
        assert_eq!(talk.head(), None);
        talk.push(line(B, "G0X2"));
        assert_eq!(sent(&mut talk), [""; 0], "its page forgets it when it hears the welcome");
        talk.begin();
        assert_eq!(talk.next(|| None), None);
    }

    #[test]
    fn a_jog_that_is_cancelled_before_it_was_sent_is_answered_at_its_turn() {
        let mut talk = Talk::default();
        for owner in [A, B] {
            talk.push(line(owner, "$J=X1"));
        }
        talk.push(line(A, "$G"));
        talk.cancel_jogs(A);
        let sent: Vec<_> = std::iter::from_fn(|| talk.next(|| None).map(text)).collect();
        assert_eq!(sent, ["", "$J=X1", "$G"]);
    }
}
