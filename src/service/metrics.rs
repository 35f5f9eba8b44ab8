//! What Prometheus reads.

use super::child::Death;
use super::store::{Claimed, Store, now_us};
use crate::app::Error;
use prometheus_client::encoding::EncodeLabelSet;
use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::{Histogram, exponential_buckets};
use prometheus_client::registry::Registry;
use std::time::Duration;

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct Route {
    method: String,
    route: String,
    status: u16,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfKind {
    kind: String,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfState {
    state: String,
    class: String,
}

/// Counters of this process, and the state of the queue as the database has it.
pub struct Metrics {
    registry: Registry,
    requests: Family<Route, Counter>,
    latency: Family<OfRoute, Histogram>,
    jobs: Family<OfState, Gauge>,
    waited: Family<OfKind, Histogram>,
    worked: Family<OfKind, Histogram>,
    lost_leases: Counter,
    child_deaths: Family<OfReason, Counter>,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfReason {
    reason: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Hash, EncodeLabelSet)]
struct OfRoute {
    route: String,
}

/// From a millisecond to an hour.
fn seconds() -> Histogram {
    Histogram::new(exponential_buckets(0.001, 4.0, 12))
}

impl Default for Metrics {
    fn default() -> Self {
        let mut metrics = Self {
            registry: Registry::with_prefix("dynident"),
            requests: Family::default(),
            latency: Family::new_with_constructor(seconds),
            jobs: Family::default(),
            waited: Family::new_with_constructor(seconds),
            worked: Family::new_with_constructor(seconds),
            lost_leases: Counter::default(),
            child_deaths: Family::default(),
        };
        let registry = &mut metrics.registry;
        registry.register("http_requests", "Requests answered", metrics.requests.clone());
        registry.register(
            "http_request_seconds",
            "Time to the head of the answer",
            metrics.latency.clone(),
        );
        registry.register("jobs", "Jobs in the database", metrics.jobs.clone());
        registry.register(
            "job_wait_seconds",
            "Time from the request to the worker",
            metrics.waited.clone(),
        );
        registry.register("job_work_seconds", "Time in the hands of a worker", metrics.worked.clone());
        registry.register(
            "lost_leases",
            "Jobs that another worker took because this one was too slow to keep them",
            metrics.lost_leases.clone(),
        );
        registry.register(
            "child_deaths",
            "Processes that died of the work of a job or request, or were ended at a limit",
            metrics.child_deaths.clone(),
        );
        metrics
    }
}

impl Metrics {
    pub fn answered(&self, method: &str, route: &str, status: u16, time: Duration) {
        let labels = Route {
            method: method.to_string(),
            route: route.to_string(),
            status,
        };
        self.requests.get_or_create(&labels).inc();
        let labels = OfRoute {
            route: route.to_string(),
        };
        self.latency.get_or_create(&labels).observe(time.as_secs_f64());
    }

    pub fn claimed(&self, job: &Claimed) {
        let waited = (now_us() - job.created_us).max(0) as f64 * 1e-6;
        let labels = OfKind {
            kind: job.kind.name().to_string(),
        };
        self.waited.get_or_create(&labels).observe(waited);
    }

    pub fn done(&self, job: &Claimed, time: Duration) {
        let labels = OfKind {
            kind: job.kind.name().to_string(),
        };
        self.worked.get_or_create(&labels).observe(time.as_secs_f64());
    }

    pub fn child_died(&self, death: &Death) {
        self.child_deaths.get_or_create(&OfReason { reason: death.reason() }).inc();
    }

    pub fn lost_lease(&self) {
        self.lost_leases.inc();
    }

    /// The exposition format (OpenMetrics text).
    pub async fn text(&self, store: &Store) -> Result<String, Error> {
        self.jobs.clear();
        for (state, class, count) in store.counts().await? {
            self.jobs.get_or_create(&OfState { state, class }).set(count);
        }
        let mut text = String::new();
        encode(&mut text, &self.registry).expect("strings take all that is written");
        Ok(text)
    }
}
