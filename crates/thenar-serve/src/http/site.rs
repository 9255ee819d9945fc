//! State that all connections share.

use super::connection_limiter::ConnectionPermit;
use super::guard::{self, Admission, Refusal};
use super::options::RequestLimits;
use super::reply::{self, Reply};
use super::session;
use super::session_slots::SessionSlots;
use super::token::{Token, WrongTokens};
use crate::hub::Hub;
use crate::page::Asset;
use hyper::body::Incoming;
use hyper::{Method, Request, StatusCode};
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::AtomicU32;
use std::time::Duration;
use tokio::sync::watch;

/// The answer to who may ask, as too many others do.
const FULL: Refusal = Refusal(StatusCode::SERVICE_UNAVAILABLE, "Too many connections.");

/// Delay of the answer to one wrong guess too many.
const SLOW: Duration = Duration::from_secs(1);

/// The clients that are let in.
#[derive(Debug)]
pub enum Access {
    /// Clients on this computer.
    Loopback,
    /// Clients that have the token.
    Lan {
        /// The token.
        token: Token,
        /// The name of the cookie that carries it. Cookies do not tell ports apart, names do.
        cookie: String,
        /// Wrong tokens so far.
        wrong_tokens: WrongTokens,
    },
}

/// State that all connections share.
#[derive(Debug)]
pub struct Site {
    /// The way to the simulation.
    pub hub: Hub,
    /// The page's files by path.
    pub assets: BTreeMap<String, Asset>,
    /// The clients that are let in.
    pub access: Access,
    /// Limits on what clients may do.
    pub limits: RequestLimits,
    /// Places of sessions.
    pub session_slots: SessionSlots,
    /// The number of the last client.
    pub clients: AtomicU32,
    /// Turns true when the server ends.
    pub stopping: watch::Receiver<bool>,
}

impl Site {
    /// Waits until the server ends.
    pub async fn stopped(&self) {
        // Gone without a word counts too.
        let _ = self.stopping.clone().wait_for(|stop| *stop).await;
    }

    /// Answers one request.
    pub async fn answer(
        self: Arc<Self>,
        peer: IpAddr,
        place: Arc<ConnectionPermit>,
        mut request: Request<Incoming>,
    ) -> Result<Reply, Infallible> {
        let upgrade = hyper::upgrade::on(&mut request);
        let (request, _) = request.into_parts();
        let mut reply = match guard::admit(&self, peer, &request) {
            Ok(_) if !place.admit(&self.limits) => reply::refuse(&FULL),
            Err(refusal) => {
                if refusal == guard::TOO_MANY {
                    tokio::time::sleep(SLOW).await;
                }
                reply::refuse(&refusal)
            }
            Ok(_) if ![Method::GET, Method::HEAD].contains(&request.method) => {
                reply::wrong_method()
            }
            Ok(Admission::Pairing) => reply::pair(&self.access),
            Ok(Admission::Granted) => match request.uri.path() {
                "/live" => session::open(&self, &request, upgrade),
                _ => reply::file(&self, &request),
            },
        };
        reply::protect(&mut reply, &request.headers);
        Ok(reply)
    }
}
