//! Work of a request that takes longer than a few milliseconds: off the threads that serve, and ended when nobody waits for it
//! any more.

use super::problem::internal_error;
use super::state::Service;
use crate::app::{CancelFlag, Code, Error};
use std::thread::available_parallelism;

/// Bytes that are read or written as JSON in a few milliseconds: above this the work is taken elsewhere.
const SMALL: usize = 64 << 10;

/// Sets a flag when it goes: with the request that waited, when its client has left.
struct CancelOnDrop(CancelFlag);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.cancel();
    }
}

/// How many such pieces of work run at the same time: one for each core, and one more, so that a long one leaves room on a small
/// machine.
pub(super) fn places() -> usize {
    available_parallelism().map_or(1, usize::from) + 1
}

impl Service {
    /// Does `work` on a thread that may take its time, when one of a bounded number of places is free. The flag that it is handed
    /// is set when the client leaves or the server stops; work that may take long looks at it.
    ///
    /// # Errors
    /// Those of the work; `shutting_down`; `internal` for a panic.
    pub(super) async fn blocking<T: Send + 'static>(
        &self,
        work: impl FnOnce(&CancelFlag) -> Result<T, Error> + Send + 'static,
    ) -> Result<T, Error> {
        let place = self.interactive().acquire_owned().await.map_err(|_| internal_error())?;
        let cancel = CancelFlag::default();
        let on_drop = CancelOnDrop(cancel.clone());
        let mut working = tokio::task::spawn_blocking(move || {
            // Until the work has ended, whoever still waits for it.
            let _place = place;
            work(&cancel)
        });
        let done = loop {
            // Listening before looking: a server that closes in between is heard of.
            let news = self.work().notified();
            tokio::pin!(news);
            news.as_mut().enable();
            if self.is_closing() {
                on_drop.0.cancel();
                break working.await;
            }
            tokio::select! {
                done = &mut working => break done,
                () = news => {}
            }
        };
        done.map_err(|_| internal_error())?
    }
}

/// What becomes of work that was ended: a client that is still there hears that the server stops.
pub(super) fn ended() -> Error {
    Error::new(Code::ShuttingDown, "the server is shutting down")
}

/// Does `work` on so many bytes at once where they are few, else on a thread that may take its time.
pub(super) async fn sized<T: Send + 'static>(bytes: usize, work: impl FnOnce() -> T + Send + 'static) -> Result<T, Error> {
    match bytes <= SMALL {
        true => Ok(work()),
        false => tokio::task::spawn_blocking(work).await.map_err(|_| internal_error()),
    }
}

/// A stored JSON document.
pub(super) async fn read_stored<T: serde::de::DeserializeOwned + Send + 'static>(bytes: Vec<u8>) -> Result<T, Error> {
    let read = sized(bytes.len(), move || serde_json::from_slice(&bytes)).await?;
    read.map_err(|_| internal_error())
}

#[cfg(test)]
mod tests {
    use super::super::config::Config;
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;
    use tokio::time::{sleep, timeout};

    fn go_on(cancel: &CancelFlag) -> Result<(), Error> {
        match cancel.is_cancelled() {
            true => Err(ended()),
            false => Ok(()),
        }
    }

    /// Work that goes on until it is cancelled, and reports when it began and ended.
    fn endless(events: mpsc::Sender<&'static str>) -> impl FnOnce(&CancelFlag) -> Result<(), Error> + Send + 'static {
        move |cancel| {
            events.send("begun").unwrap();
            while !cancel.is_cancelled() {
                std::thread::sleep(Duration::from_millis(1));
            }
            events.send("ended").unwrap();
            go_on(cancel)
        }
    }

    fn next(events: &mpsc::Receiver<&'static str>) -> &'static str {
        events.recv_timeout(Duration::from_secs(20)).expect("events in time")
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn work_ends_when_its_client_leaves() {
        let service = Service::open(Config::default()).await.unwrap();
        let (tell, events) = mpsc::channel();
        assert!(
            timeout(Duration::from_millis(50), service.blocking(endless(tell)))
                .await
                .is_err()
        );
        assert_eq!((next(&events), next(&events)), ("begun", "ended"));
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn work_ends_when_the_server_stops() {
        let service = Service::open(Config::default()).await.unwrap();
        let (tell, events) = mpsc::channel();
        let other = service.clone();
        let working = tokio::spawn(async move { other.blocking(endless(tell)).await });
        assert_eq!(next(&events), "begun");
        service.close();
        assert_eq!(working.await.unwrap().unwrap_err().code, Code::ShuttingDown);
    }

    #[tokio::test(flavor = "multi_thread")]
    async fn no_more_than_the_places_work_at_the_same_time() {
        let service = Service::open(Config::default()).await.unwrap();
        let (tell, events) = mpsc::channel();
        let start = || {
            let (service, tell) = (service.clone(), tell.clone());
            tokio::spawn(async move { service.blocking(endless(tell)).await })
        };
        let all: Vec<_> = (0..=places()).map(|_| start()).collect();
        (0..places()).for_each(|_| assert_eq!(next(&events), "begun"));
        sleep(Duration::from_millis(50)).await;
        assert!(events.try_recv().is_err(), "one more than there are places has begun");
        service.close();
        for one in all {
            assert!(one.await.unwrap().is_err());
        }
    }

    #[tokio::test]
    async fn a_panic_is_an_error_of_this_request() {
        let service = Service::open(Config::default()).await.unwrap();
        let failed = service.blocking::<()>(|_| panic!("inside")).await;
        assert_eq!(failed.unwrap_err().code, Code::Internal);
    }
}
