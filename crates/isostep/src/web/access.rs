//! Rights of requests: every page that is open in the user's browser can send requests to this server.

use anyhow::{Result, anyhow};
use axum::http::{HeaderMap, Uri, header};
use std::fmt::Write as _;
use std::net::SocketAddr;
use subtle::ConstantTimeEq;

const TOKEN_BYTES: usize = 16;

/// The names by which this server may be called, and the token for the board.
pub struct Access {
    hosts: Vec<String>,
    token: String,
}

impl Access {
    /// Access with a new token.
    ///
    /// # Errors
    /// When the system gives no random numbers.
    pub fn new(at: SocketAddr) -> Result<Self> {
        let mut random = [0; TOKEN_BYTES];
        getrandom::fill(&mut random).map_err(|error| anyhow!("the system gives no random numbers: {error}"))?;
        let token = random.iter().fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        });
        let mut hosts = vec![at.to_string()];
        if at.ip().is_loopback() {
            hosts.push(format!("localhost:{}", at.port()));
        }
        // Browsers leave the usual port out.
        let short = hosts.iter().filter_map(|host| Some(host.strip_suffix(":80")?.to_owned())).collect::<Vec<_>>();
        hosts.extend(short);
        Ok(Self { hosts, token })
    }

    /// The token that a page has to show for the board.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The server is called by its own name. By another's, a page of somebody else would count as ours: its name
    /// may lead here meanwhile (DNS rebinding).
    ///
    /// # Errors
    /// Why not, in words.
    pub fn check_host(&self, headers: &HeaderMap) -> Result<(), String> {
        let host = text(headers, header::HOST);
        let remedy = || format!("`{host}` is not how this server is called: use http://{}", self.hosts[0]);
        self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host)).then_some(()).ok_or_else(remedy)
    }

    /// The board is asked for by our page, and by somebody who knows the token.
    ///
    /// # Errors
    /// Why not, in words.
    pub fn check_board(&self, headers: &HeaderMap, uri: &Uri) -> Result<(), String> {
        let (origin, own) = (text(headers, header::ORIGIN), format!("http://{}", text(headers, header::HOST)));
        if !origin.eq_ignore_ascii_case(&own) {
            return Err(format!("a page of `{origin}` may not operate the board: use the page of {own}"));
        }
        let token = uri.query().and_then(|query| query.strip_prefix("token=")).unwrap_or_default();
        let is_known = bool::from(token.as_bytes().ct_eq(self.token.as_bytes()));
        is_known
            .then_some(())
            .ok_or_else(|| "the token is missing or old: open the address that the server printed".to_owned())
    }
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> &str {
    headers.get(name).and_then(|value| value.to_str().ok()).unwrap_or_default()
}
