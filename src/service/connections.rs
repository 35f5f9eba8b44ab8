//! Connections: accepted up to a limit, each with time limits on everything that the client may leave undone.
//!
//! A client that stops half way (slow-loris) holds a connection for a bounded time only: hyper closes one whose header is not
//! complete, or that stays idle between two requests, after `header_timeout`; a body that stalls is an error of that body after
//! `idle_timeout`, and so is a client that does not take its answer.

use super::config::Config;
use axum::Router;
use axum::body::Body;
use axum::extract::{ConnectInfo, Request};
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::{GracefulShutdown, Watcher};
use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;
use tokio_io_timeout::TimeoutStream;
use tower::ServiceExt;
use tower_http::timeout::TimeoutBody;

/// Open answers may be finished for so long after the end of the server was asked for; systemd and container engines wait 30 s
/// and 10 s before they kill.
const GRACE: Duration = Duration::from_secs(8);
/// Pauses after the system has refused a connection (no file handle, no memory): the shortest is not noticed, the longest is no
/// load.
const PAUSES: [Duration; 2] = [Duration::from_millis(10), Duration::from_secs(1)];
/// File handles that are not for connections: of a database three for each of eight connections, of the runtime, of child
/// processes.
const OTHER_HANDLES: u64 = 96;
/// File handles of one connection: its socket, and a file that it reads or writes.
const HANDLES_PER_CONNECTION: u64 = 2;
/// A machine with very few handles serves that many all the same.
const FEWEST_CONNECTIONS: u64 = 8;

/// Serves connections of `listener` until `shutdown` resolves; then takes no further ones and hands back when open answers are
/// finished, or cut off after a few seconds.
pub(super) async fn serve_connections(
    listener: TcpListener,
    router: Router,
    config: &Config,
    shutdown: impl Future<Output = ()>,
) {
    let places = Arc::new(Semaphore::new(places(config.most_connections)));
    let (graceful, mut tasks) = (GracefulShutdown::new(), JoinSet::new());
    let serving = Serving {
        router,
        header_timeout: config.header_timeout,
        idle_timeout: config.idle_timeout,
    };
    tokio::pin!(shutdown);
    loop {
        tokio::select! {
            (stream, peer, place) = next(&listener, &places) => {
                tasks.spawn(serving.clone().serve(stream, peer, place, graceful.watcher()));
            }
            Some(_) = tasks.join_next() => {}
            () = &mut shutdown => break,
        }
    }
    drop(listener);
    if tokio::time::timeout(GRACE, graceful.shutdown()).await.is_err() {
        tracing::warn!(connections = tasks.len(), "connections that did not end are cut off");
    }
    tasks.shutdown().await;
}

/// The next connection, when there is a place for it.
async fn next(listener: &TcpListener, places: &Arc<Semaphore>) -> (TcpStream, SocketAddr, OwnedSemaphorePermit) {
    let place = places.clone().acquire_owned().await.expect("the semaphore is never closed");
    let mut pause = PAUSES[0];
    loop {
        match listener.accept().await {
            Ok((stream, peer)) => return (stream, peer, place),
            // The client left before it was accepted.
            Err(e) if is_of_connection(&e) => {}
            Err(e) => {
                tracing::error!(error = %e, "no connection can be accepted; those that are open are served, and it is tried again");
                tokio::time::sleep(pause).await;
                pause = (2 * pause).min(PAUSES[1]);
            }
        }
    }
}

fn is_of_connection(e: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
    matches!(e.kind(), ConnectionAborted | ConnectionRefused | ConnectionReset)
}

/// How connections are served.
#[derive(Clone)]
struct Serving {
    router: Router,
    header_timeout: Duration,
    idle_timeout: Duration,
}

impl Serving {
    async fn serve(self, stream: TcpStream, peer: SocketAddr, _place: OwnedSemaphorePermit, watcher: Watcher) {
        // Events are small and go out at once.
        let _ = stream.set_nodelay(true);
        let mut stream = TimeoutStream::new(stream);
        stream.set_write_timeout(Some(self.idle_timeout));
        let answer = service_fn(move |request: hyper::Request<Incoming>| {
            let mut request: Request = request.map(|body| Body::new(TimeoutBody::new(self.idle_timeout, body)));
            request.extensions_mut().insert(ConnectInfo(peer));
            self.router.clone().oneshot(request)
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(self.header_timeout)
            .serve_connection(TokioIo::new(Box::pin(stream)), answer);
        if let Err(error) = watcher.watch(connection).await {
            tracing::debug!(%peer, %error, "the connection ended");
        }
    }
}

/// How many connections the file handles of this process allow, at most `wanted`; raises the soft limit on handles where that is
/// too low.
fn places(wanted: usize) -> usize {
    let needed = OTHER_HANDLES + HANDLES_PER_CONNECTION * wanted as u64;
    let Some(handles) = handles(needed) else { return wanted };
    let allowed = (handles.saturating_sub(OTHER_HANDLES) / HANDLES_PER_CONNECTION).max(FEWEST_CONNECTIONS) as usize;
    if allowed < wanted {
        tracing::warn!(
            handles,
            connections = allowed,
            "the limit on open files allows fewer connections than configured"
        );
    }
    wanted.min(allowed)
}

/// File handles that this process may have, raised towards `needed` as far as it may raise them; `None` for no limit.
#[cfg(unix)]
fn handles(needed: u64) -> Option<u64> {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let now = limit.current?;
    let raised = limit.maximum.map_or(needed, |most| needed.min(most));
    if raised <= now {
        return Some(now);
    }
    let new = Rlimit {
        current: Some(raised),
        maximum: limit.maximum,
    };
    Some(if setrlimit(Resource::Nofile, new).is_ok() {
        raised
    } else {
        now
    })
}

#[cfg(not(unix))]
fn handles(_: u64) -> Option<u64> {
    None
}
