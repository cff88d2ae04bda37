//! A page that has the board, by a WebSocket: bytes are the board's, both ways; a text says why it ends.

use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use tokio::sync::watch;
use tokio::time::{self, MissedTickBehavior};

use super::Board;
use super::cable::Cable;

/// A page answers each ping, unless its computer sleeps or the network is gone.
const PING_EVERY: Duration = Duration::from_millis(500);
const PINGS_UNANSWERED_MAX: u32 = 4;
/// Time that a page may take to read what the board says.
const SEND_PATIENCE: Duration = Duration::from_secs(2);

/// Why a page has the board no more.
enum End {
    PageGone,
    BoardGone(String),
    ServerEnds,
}

/// Lends the board to this page until one of them is gone, or the server ends.
pub async fn run(mut page: WebSocket, board: &Board, ending: watch::Receiver<bool>) {
    let mut cable = match Cable::open(board) {
        Ok(cable) => cable,
        Err(error) => return refuse(page, &format!("{error:#}")).await,
    };
    println!("a page has the board");
    match pass(&mut page, &mut cable, ending).await {
        End::BoardGone(why) => {
            println!("the board is gone: {why}");
            refuse(page, &format!("the board is gone ({why}): plug it in, then connect again")).await;
        }
        End::PageGone => println!("the page has gone: {}", cable.leave().await),
        End::ServerEnds => {
            println!("ending: {}", cable.leave().await);
            refuse(page, "the server has ended: start it again, and open the address that it prints").await;
        }
    }
}

/// Says why there is no board, and closes.
pub async fn refuse(mut page: WebSocket, why: &str) {
    let words = async {
        page.send(Message::text(why)).await?;
        page.send(Message::Close(None)).await
    };
    // A page that has gone already needs no words.
    let _ = time::timeout(SEND_PATIENCE, words).await;
}

async fn pass(page: &mut WebSocket, cable: &mut Cable, mut ending: watch::Receiver<bool>) -> End {
    let mut pings = time::interval(PING_EVERY);
    pings.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut unanswered = 0;
    loop {
        let said = tokio::select! {
            heard = page.recv() => match heard {
                Some(Ok(Message::Binary(bytes))) => match cable.send(&bytes) {
                    Ok(()) => None,
                    Err(why) => return End::BoardGone(why),
                },
                Some(Ok(Message::Close(_)) | Err(_)) | None => return End::PageGone,
                Some(Ok(Message::Pong(_))) => { unanswered = 0; None }
                Some(Ok(_)) => None,
            },
            heard = cable.hear() => match heard {
                Ok(bytes) => Some(Message::binary(bytes)),
                Err(why) => return End::BoardGone(why),
            },
            _ = pings.tick() => {
                unanswered += 1;
                Some(Message::Ping(Default::default()))
            }
            _ = ending.wait_for(|ends| *ends) => return End::ServerEnds,
        };
        if unanswered > PINGS_UNANSWERED_MAX {
            return End::PageGone;
        }
        if let Some(said) = said
            && !matches!(time::timeout(SEND_PATIENCE, page.send(said)).await, Ok(Ok(())))
        {
            return End::PageGone;
        }
    }
}
