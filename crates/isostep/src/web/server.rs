//! The server: what is answered to whom.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::{Context, Result, anyhow};
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use tokio::sync::{mpsc, oneshot};
use tokio::time;

use super::access::Access;
use super::hub::{Hub, Wish};
use super::{Board, Page, session};

/// Time in which the machine is left when the server ends.
const END_PATIENCE: Duration = Duration::from_secs(5);

/// More than the text of a program, which is the longest message of a page.
const MESSAGE_BYTES_MAX: usize = 64 << 20;
/// What pages want and the hub has not seen to.
const WISHES_MAX: usize = 64;

/// State that all requests share.
struct Served {
    page: Page,
    access: Access,
    /// The hub, if there is a board.
    hub: Option<mpsc::Sender<(u64, Wish)>>,
    /// Pages that have asked for the board.
    visitors: AtomicU64,
}

/// A server that has its address.
pub struct Server {
    listener: TcpListener,
    at: SocketAddr,
    served: Arc<Served>,
    /// A board, and what pages want of it.
    board: Option<(Board, mpsc::Receiver<(u64, Wish)>)>,
}

impl Server {
    /// Takes an address; port 0 is any that is free.
    ///
    /// # Errors
    /// When it cannot be had.
    pub fn bind(page: Page, board: Option<Board>, at: SocketAddr) -> Result<Self> {
        let listener = TcpListener::bind(at).map_err(|error| trouble(at, &error))?;
        listener.set_nonblocking(true)?;
        let at = listener.local_addr()?;
        let (hub, wishes) = mpsc::channel(WISHES_MAX);
        let served =
            Served { page, access: Access::new(at)?, hub: board.is_some().then_some(hub), visitors: AtomicU64::new(0) };
        Ok(Self { listener, at, served: Arc::new(served), board: board.map(|board| (board, wishes)) })
    }

    /// The address to open in a browser. The token stands where browsers do not send it on.
    pub fn address(&self) -> String {
        let token = self.served.hub.as_ref().map(|_| format!("#operate&token={}", self.served.access.token()));
        format!("http://{}/{}", self.at, token.unwrap_or_default())
    }

    /// Serves until Ctrl-C, and leaves the board as a page does that is closed.
    ///
    /// # Errors
    /// When the system refuses what a server needs.
    pub fn run(self) -> Result<()> {
        self.serve_until(async { tokio::signal::ctrl_c().await.context("Ctrl-C cannot be waited for") })
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// When the system refuses what a server needs.
    pub fn serve(self) -> Result<()> {
        self.serve_until(std::future::pending())
    }

    pub(super) fn serve_until(self, end: impl Future<Output = Result<()>>) -> Result<()> {
        tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            let (ending, ends) = oneshot::channel();
            let hub = self.board.map(|(board, wishes)| tokio::spawn(Hub::new(board).run(wishes, ends)));
            tokio::select! {
                served = axum::serve(listener, router(self.served)).into_future() => served?,
                ended = end => ended?,
            }
            drop(ending);
            if let Some(hub) = hub {
                let _ = time::timeout(END_PATIENCE, hub).await;
            }
            Ok(())
        })
    }
}

fn trouble(at: SocketAddr, error: &std::io::Error) -> anyhow::Error {
    match error.kind() {
        ErrorKind::AddrInUse => {
            anyhow!("another program has port {} of {}: give another by --http-port", at.port(), at.ip())
        }
        ErrorKind::AddrNotAvailable => {
            anyhow!("{} is no address of this computer: --listen takes one by which others reach it", at.ip())
        }
        ErrorKind::PermissionDenied => {
            anyhow!("port {} is for the system: give one from 1024 on by --http-port", at.port())
        }
        _ => anyhow!("{at} cannot be listened at: {error}"),
    }
}

fn router(served: Arc<Served>) -> Router {
    Router::new()
        .route("/board.json", get(about_board))
        .route("/board", get(board))
        .fallback(get(file))
        .layer(middleware::from_fn_with_state(served.clone(), guard))
        .with_state(served)
}

/// Refuses wishes by another's name, and says to the browser what the page may do.
async fn guard(State(served): State<Arc<Served>>, request: Request, next: Next) -> Response {
    let mut answer = match served.access.check_host(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(why) => (StatusCode::FORBIDDEN, why).into_response(),
    };
    let policy = HeaderValue::from_str(served.page.policy()).unwrap_or(HeaderValue::from_static("default-src 'none'"));
    let fixed = |(name, value): (HeaderName, &'static str)| (name, HeaderValue::from_static(value));
    let headers = [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-cache"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ];
    answer.headers_mut().extend(headers.map(fixed).into_iter().chain([(header::CONTENT_SECURITY_POLICY, policy)]));
    answer
}

async fn file(State(served): State<Arc<Served>>, uri: Uri, headers: HeaderMap) -> Response {
    let accepts = headers.get(header::ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    let Some(file) = served.page.file(uri.path(), accepts) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let mut answer = ([(header::CONTENT_TYPE, file.media_type)], file.content.to_vec()).into_response();
    if let Some(encoding) = file.encoding {
        answer.headers_mut().insert(header::CONTENT_ENCODING, HeaderValue::from_static(encoding));
    }
    answer
}

/// Says whether there is a board. The page asks this of every server: among its files is one of that name, for those that have none.
async fn about_board(State(served): State<Arc<Served>>) -> Response {
    let words = format!("{{\"has_board\":{}}}", served.hub.is_some());
    ([(header::CONTENT_TYPE, "application/json")], words).into_response()
}

async fn board(State(served): State<Arc<Served>>, headers: HeaderMap, uri: Uri, upgrade: WebSocketUpgrade) -> Response {
    if let Err(why) = served.access.check_board(&headers, &uri) {
        return (StatusCode::FORBIDDEN, why).into_response();
    }
    upgrade.max_message_size(MESSAGE_BYTES_MAX).max_frame_size(MESSAGE_BYTES_MAX).on_upgrade(async move |page| {
        match &served.hub {
            None => session::refuse(page, "this server has no board").await,
            Some(hub) => session::run(page, served.visitors.fetch_add(1, Ordering::Relaxed), hub).await,
        }
    })
}
