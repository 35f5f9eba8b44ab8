//! Design an excitation trajectory.

use crate::excitation::{Control, Halt, Progress, search_from};
use crate::io::{DesignDocument, ExcitationRequest};
use crate::trajectory::FourierSeries;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A switch that ends a running job; clones are the same switch.
#[derive(Debug, Clone, Default)]
pub struct CancelFlag(Arc<AtomicBool>);

impl CancelFlag {
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// A finished design.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    pub document: DesignDocument,
    /// `None` where the problem is infeasible.
    pub series: Option<FourierSeries>,
}

/// Searches until the search itself ends, its time limit is over, or `cancel` is set; the last two are honoured within a second and
/// keep the best trajectory found.
///
/// `observe` is told after every local solve, from many threads.
pub fn excite(request: &ExcitationRequest, cancel: &CancelFlag, observe: &(dyn Fn(&Progress) + Sync)) -> Excited {
    let started = Instant::now();
    let clock = Clock {
        deadline: started + Duration::from_secs_f64(request.search.time_limit_s),
        cancel,
        observe,
    };
    let run = || search_from(&request.problem, &request.search.options, request.earlier.as_ref(), &clock);
    // Threads of its own: in a shared pool a search whose time is up would wait for the local solves of another.
    let design = match rayon::ThreadPoolBuilder::new().build() {
        Ok(pool) => pool.install(run),
        Err(_) => run(),
    };
    let document = DesignDocument::new(request, &design, started.elapsed().as_secs_f64());
    Excited {
        document,
        series: design.criteria.map(|_| design.series),
    }
}

/// Brings the clock to a search that knows none.
struct Clock<'a> {
    deadline: Instant,
    cancel: &'a CancelFlag,
    observe: &'a (dyn Fn(&Progress) + Sync),
}

impl Control for Clock<'_> {
    fn halt(&self) -> Option<Halt> {
        if self.cancel.is_cancelled() {
            return Some(Halt::Cancelled);
        }
        (Instant::now() >= self.deadline).then_some(Halt::TimeUp)
    }

    fn progress(&self, progress: &Progress) {
        (self.observe)(progress);
    }
}
