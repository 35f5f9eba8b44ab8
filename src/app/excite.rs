//! Design an excitation trajectory.

use crate::excitation::{Control, Found, Halt, Point, Progress, search_from};
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

/// What connects a search with its earlier life and with those beside it; see [`Control::found`] and [`Control::others`].
pub trait Exchange: Sync {
    fn found(&self, found: &Found);
    fn others(&self) -> Vec<Point>;
}

/// Searches until the search itself ends, its time limit is over, or `cancel` is set; the last two are honoured within a second and
/// keep the best trajectory found.
///
/// `observe` is told after every local solve, from many threads.
pub fn excite(request: &ExcitationRequest, cancel: &CancelFlag, observe: &(dyn Fn(&Progress) + Sync)) -> Excited {
    excite_beside(request, None, cancel, observe)
}

/// [`excite`], going on from what `exchange` knows, and telling it what is found.
pub fn excite_beside(
    request: &ExcitationRequest,
    exchange: Option<&dyn Exchange>,
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Progress) + Sync),
) -> Excited {
    let started = Instant::now();
    let clock = Clock {
        deadline: started + Duration::from_secs_f64(request.search.time_limit_s),
        cancel,
        exchange,
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
    exchange: Option<&'a dyn Exchange>,
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

    fn found(&self, found: &Found) {
        if let Some(exchange) = self.exchange {
            exchange.found(found);
        }
    }

    fn others(&self) -> Vec<Point> {
        self.exchange.map_or_else(Vec::new, Exchange::others)
    }
}
