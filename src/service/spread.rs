//! One design on many workers: idle ones search for it with other random numbers, and the best of all is the result.
//!
//! Each searches for itself and hears of what the others have found when an epoch of its own ends ([`super::exchange`]): their
//! evaluations add up without waiting for each other, and a worker that is lost takes nothing with it but its own. A search that
//! is limited by a number of evaluations is not spread: it gives the same answer everywhere.

use super::child::{Advance, JobTask, ShareOf, Task};
use super::exchange::Link;
use super::progress::Latest;
use super::state::Service;
use super::store::{Claimed, Share, Spent};
use super::work::{Class, Input, JobKind, JobOutcome, Request};
use super::worker::{Course, Ending, NEWS, in_time};
use crate::app::{CancelFlag, Code, Error};
use crate::documents::ExcitationRequest;
use serde_json::{Value, json};
use std::time::Duration;
use tokio::time::{Instant, MissedTickBehavior, interval, sleep};

/// Time that a share keeps for handing in before the search is over.
const HANDING_IN: Duration = Duration::from_secs(1);
/// How long the search waits for shares that are about to come in: their handing in, and the time until they hear that it is
/// over.
const GATHERING: Duration = Duration::from_secs(3);
/// Odd constants take every number to another seed: of the golden ratio, as in SplitMix64, and of the next of its generalisations
/// (Roberts), so that shares and later lives do not meet.
const EVERY_SHARE: u64 = 0x9e37_79b9_7f4a_7c15;
const EVERY_LIFE: u64 = 0xc13f_a9a9_02a6_328f;
/// How often a share is written down, and asked whether there is other work.
const LOOK_AGAIN: Duration = Duration::from_millis(500);

/// Whether other workers may search for this request.
pub fn may_be_shared(request: &Request, long: bool) -> bool {
    match request {
        Request::Excite(r) => long && r.is_single() && r.search.options.max_evaluations.is_none(),
        _ => false,
    }
}

/// Adds what the shares have done to the progress of the search.
pub async fn with_shares(service: &Service, job: &Claimed, progress: Value) -> Value {
    let shares = service.store().shares(&job.id, job.lease);
    let Ok(shares) = in_time(LOOK_AGAIN, shares).await else {
        return progress;
    };
    let mut progress = progress;
    if let Some(own) = progress["evaluations"].as_i64() {
        progress["evaluations"] = json!(own + shares.evaluations);
    }
    let best = [progress["best"].as_f64(), shares.best]
        .into_iter()
        .flatten()
        .reduce(f64::min);
    progress["best"] = json!(best);
    progress
}

/// Ends the shares of a search and takes in what they found: the document of the best, with the work of all, and of earlier
/// lives.
pub async fn gather(service: &Service, job: &Claimed, outcome: &JobOutcome, before: Spent) -> Result<Vec<u8>, Error> {
    let own = &outcome.document;
    let store = service.store();
    let mut shares = store.shares(&job.id, job.lease).await?;
    if shares.results.is_empty() && shares.outstanding == 0 && before == Spent::default() {
        return Ok(own.to_vec());
    }
    store.spread(&job.id, job.lease, Duration::ZERO).await?;
    let until = Instant::now() + GATHERING;
    while shares.outstanding > 0 && Instant::now() < until {
        sleep(NEWS).await;
        shares = store.shares(&job.id, job.lease).await?;
    }
    let mut own: Value = serde_json::from_slice(own).unwrap_or_default();
    let spent = &mut own["search"];
    spent["evaluations"] = json!(spent["evaluations"].as_u64().unwrap_or(0) + before.evaluations);
    spent["elapsed_s"] = json!(spent["elapsed_s"].as_f64().unwrap_or(0.0) + before.time.as_secs_f64());
    let mut documents = vec![own];
    for hash in &shares.results {
        match service.files().read(hash).await {
            Ok(document) => documents.push(serde_json::from_slice(&document).unwrap_or_default()),
            Err(error) if error.code == Code::StorageUnavailable => return Err(error),
            // What is missing will not come: the design does not wait for it.
            Err(error) => tracing::warn!(job = job.id, %error, "a share is left out"),
        }
    }
    Ok(best_of(documents).to_string().into_bytes())
}

/// Lets a search go on where an earlier life of it, that took `before`, had come: in the time that is left, and with other random
/// numbers, which would lead to the same points again.
pub fn go_on(search: &mut ExcitationRequest, before: Advance) {
    search.search.time_limit_s = (search.search.time_limit_s - before.seconds).max(0.0);
    search.search.options.seed ^= (before.lease as u64).wrapping_mul(EVERY_LIFE);
}

/// The best of several documents of one design; how the search ended is that of the first.
fn best_of(documents: Vec<Value>) -> Value {
    let reached = |d: &Value| {
        let minimised = d["criteria"]["minimised"].as_str()?;
        let value = d["criteria"][minimised].as_f64();
        // The one that the search wants large.
        if minimised == "rival_evidence" {
            value.map(|v| 1.0 / v)
        } else {
            value
        }
    };
    let value = |d: &Value| reached(d).unwrap_or(f64::INFINITY);
    let sum = |field: &str| documents.iter().filter_map(|d| d["search"][field].as_u64()).sum::<u64>();
    let (evaluations, rounds, searches) = (sum("evaluations"), sum("rounds"), documents.len());
    let starts: Vec<Value> = documents
        .iter()
        .filter_map(|d| d["starts"].as_array())
        .flatten()
        .cloned()
        .collect();
    let first = documents.first().cloned().unwrap_or_default();
    let mut best = documents
        .into_iter()
        .reduce(|a, b| if value(&b) < value(&a) { b } else { a })
        .unwrap_or_default();
    if value(&first).is_finite() {
        best["status"] = first["status"].clone();
    }
    best["search"] = first["search"].clone();
    best["search"]["evaluations"] = json!(evaluations);
    best["search"]["rounds"] = json!(rounds);
    best["search"]["searches"] = json!(searches);
    best["request"] = first["request"].clone();
    best["starts"] = json!(starts);
    best
}

/// Looks for a search to share, and shares it until it is over or there is work of one's own; whether there was one.
pub async fn help(service: &Service) -> bool {
    let lease = service.config().lease;
    let taken = in_time(lease, service.store().take_share(service.worker(), lease)).await;
    let Ok(Some(share)) = taken else { return false };
    tracing::info!(
        job = share.job,
        number = share.number,
        "searching for another worker's design"
    );
    let ended = search(service, &share).await;
    let (result, evaluations) = ended.unwrap_or_else(|error| {
        tracing::warn!(job = share.job, %error, "a share failed");
        (None, 0)
    });
    let end = service
        .store()
        .end_share(&share, service.worker(), result.as_deref(), evaluations);
    if let Err(error) = in_time(lease, end).await {
        tracing::warn!(job = share.job, %error, "a share could not be handed in");
    }
    true
}

/// Other random numbers, and all the time that is left.
pub fn set_apart(request: &mut ExcitationRequest, share: ShareOf) {
    let options = &mut request.search.options;
    options.seed ^= (share.number as u64).wrapping_mul(EVERY_SHARE);
    options.until_halted = true;
    request.search.time_limit_s = share.seconds;
}

async fn task(service: &Service, share: &Share) -> Result<Task, Error> {
    let input: Input =
        serde_json::from_slice(&service.files().read(&share.input).await?).map_err(|_| super::problem::internal_error())?;
    Ok(Task::Job(Box::new(JobTask {
        kind: JobKind::Excitation,
        input,
        logs: Vec::new(),
        validation: Vec::new(),
        most_rows: 0,
        long: true,
        nice: true,
        advance: Advance::default(),
        share: Some(ShareOf {
            number: share.number,
            seconds: share.left.saturating_sub(HANDING_IN).as_secs_f64(),
        }),
    })))
}

async fn search(service: &Service, share: &Share) -> Result<(Option<String>, u64), Error> {
    let (cancel, news) = (CancelFlag::default(), Latest::default());
    let link = Link::of_share(service, &share.job, share.lease, share.number);
    let mut child = service.child().await?;
    child.begin(task(service, share).await?);
    let course = Course {
        service,
        cancel: &cancel,
        link: Some(&link),
        news: &news,
        job: None,
    };
    let mut so_far = (0, None);
    let ending = {
        let mut work = std::pin::pin!(course.follow(&mut child));
        let mut ticks = interval(LOOK_AGAIN);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tokio::select! {
                ending = &mut work => break ending,
                _ = ticks.tick() => {
                    if let Some(progress) = news.take().0 {
                        so_far = (progress["evaluations"].as_u64().unwrap_or(0), progress["best"].as_f64());
                    }
                    link.write(false).await;
                    if !goes_on(service, share, so_far).await {
                        cancel.cancel();
                    }
                }
            }
        }
    };
    let outcome = match ending {
        Ending::Done(outcome) => outcome,
        Ending::Failed(error) => return Err(error),
        Ending::Died(death) => return Err(death.error("the search")),
        Ending::Deaf => return Err(Error::new(Code::NoResult, "the search did not end when it was asked to")),
    };
    service.children().give_back(child);
    let found = outcome.found.unwrap_or_default();
    let result = match found.is_feasible {
        true => Some(service.files().put(&outcome.document).await?),
        false => None,
    };
    Ok((result, found.evaluations))
}

/// Whether the search wants this share still, and this worker has nothing else to do.
async fn goes_on(service: &Service, share: &Share, (evaluations, best): (u64, Option<f64>)) -> bool {
    let store = service.store();
    let time = service.config().lease;
    let renew = store.renew_share(share, service.worker(), time, evaluations, best);
    let wanted = in_time(time / 3, renew).await;
    let other_work = in_time(time / 3, store.may_claim(Class::Long, service.config().running_per_robot))
        .await
        .unwrap_or(false);
    // While the database is away the search goes on: it may be back before the time is over.
    wanted.unwrap_or(true) && !other_work && !service.is_closing()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_document_wins_and_the_work_adds_up() {
        let document = |value: f64, status: &str| {
            json!({"status": status, "criteria": {"minimised": "condition_number", "condition_number": value},
                "search": {"seed": 1, "evaluations": 10, "rounds": 2}, "starts": [1], "request": {"seed": status}})
        };
        let none = json!({"status": "Infeasible", "criteria": null, "search": {"evaluations": 5, "rounds": 1}, "starts": []});
        let best = best_of(vec![
            document(70.0, "BudgetExhausted"),
            document(60.0, "Cancelled"),
            none.clone(),
        ]);
        assert_eq!(best["criteria"]["condition_number"], 60.0);
        assert_eq!(
            (&best["status"], &best["search"]["evaluations"]),
            (&json!("BudgetExhausted"), &json!(25))
        );
        assert_eq!(
            (&best["starts"], &best["request"]["seed"]),
            (&json!([1, 1]), &json!("BudgetExhausted"))
        );
        // Only a share found a trajectory: then its word counts.
        assert_eq!(
            best_of(vec![none, document(60.0, "BudgetExhausted")])["status"],
            "BudgetExhausted"
        );
    }
}
