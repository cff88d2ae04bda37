//! A page that has the board, by a WebSocket.

use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use tokio::sync::mpsc::{self, Receiver, Sender};
use tokio::task;
use tokio::time::{self, MissedTickBehavior};

use super::hub::Wish;
use super::job::Job;
use super::message::{Asked, Told};

/// The script of a page answers each question, unless it hangs, its computer sleeps or the network is gone.
const ASK_EVERY: Duration = Duration::from_millis(500);
const UNANSWERED_MAX: u32 = 4;
/// Time that a page may take to read what the board says.
const SEND_PATIENCE: Duration = Duration::from_secs(2);
/// Messages that are kept for a page.
const AHEAD: usize = 1024;
/// More bytes than a page sends to the board at once.
const BYTES_MAX: usize = 4096;

const HANGS: &str = "this page has not answered for 2 s, because its script or its computer slept: connect again";
const UNKNOWN: &str = "the server does not understand this page: load it again";

/// Lends the board to this page until one of them is gone, or the server ends. When this future is dropped, the hub finds that the page does
/// not hear any more.
pub async fn run(mut page: WebSocket, number: u64, hub: &Sender<(u64, Wish)>) {
    let (said, heard) = mpsc::channel(AHEAD);
    // A hub that has ended needs to know of nobody.
    let _ = hub.send((number, Wish::Come(said))).await;
    let why = pass(&mut page, number, hub, heard).await;
    let _ = hub.send((number, Wish::Go)).await;
    if let Some(why) = why {
        refuse(page, why).await;
    }
}

/// Says why there is no board, and closes.
pub async fn refuse(mut page: WebSocket, why: &str) {
    for message in [Told::Ended { why }.message(), Message::Close(None)] {
        // A page that has gone already needs no words.
        let _ = time::timeout(SEND_PATIENCE, page.send(message)).await;
    }
}

/// Passes on what the page and the hub say to each other. Returns why the page is to be refused, if it is.
async fn pass(
    page: &mut WebSocket,
    number: u64,
    hub: &Sender<(u64, Wish)>,
    mut heard: Receiver<Message>,
) -> Option<&'static str> {
    let mut questions = time::interval(ASK_EVERY);
    questions.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut unanswered = 0;
    loop {
        let said = tokio::select! {
            heard = page.recv() => match heard {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return None,
                Some(Ok(message @ (Message::Binary(_) | Message::Text(_)))) => {
                    unanswered = 0;
                    match request(message).await {
                        Err(why) => return Some(why),
                        Ok(request) => if let Some(request) = request { hub.send((number, request)).await.ok()? },
                    }
                    continue;
                }
                Some(Ok(_)) => continue,
            },
            said = heard.recv() => said?,
            _ = questions.tick() => {
                unanswered += 1;
                if unanswered > UNANSWERED_MAX {
                    return Some(HANGS);
                }
                Told::IsAlive.message()
            }
        };
        let is_last = matches!(said, Message::Close(_));
        if !matches!(time::timeout(SEND_PATIENCE, page.send(said)).await, Ok(Ok(()))) || is_last {
            return None;
        }
    }
}

/// What a page asks for by a message.
async fn request(message: Message) -> Result<Option<Wish>, &'static str> {
    match message {
        Message::Binary(bytes) if bytes.len() <= BYTES_MAX => Ok(Some(Wish::Send(bytes.to_vec()))),
        Message::Text(text) => Ok(match serde_json::from_str(&text).map_err(|_| UNKNOWN)? {
            Asked::Alive => None,
            Asked::Program => Some(Wish::Program),
            // A long program takes its time, in which others are served.
            Asked::Start { name, program, before } => {
                let job = task::spawn_blocking(move || Job::read(name, program, before)).await;
                Some(Wish::Start(Box::new(job.map_err(|error| error.to_string()).flatten())))
            }
        }),
        _ => Err(UNKNOWN),
    }
}
