//! One epoch of the search: what its jobs are, what it keeps, when it is over.

use super::pool::{Point, Pool};
use super::variables::Variables;

/// Local solves from random starts that open an epoch.
const OPENING_STARTS: usize = 16;
/// Jobs without improvement of the epoch's best by more than [`NOTICEABLE`] after which it ends. In traces of six epochs on the
/// paper's problem most improvements came within 130 jobs of the one before, and the longest wait that paid was 280.
const PATIENCE_JOBS: usize = 160;
/// Relative improvement that counts; a user cannot tell condition numbers closer than this.
pub(super) const NOTICEABLE: f64 = 1e-3;
/// Points this near to the best (in the logarithm) are polished: more than polishing gains (1 % to 2 %), so that no better
/// minimum is passed over because its local solve ended early.
const WORTH_POLISHING: f64 = 0.03;
/// Polishing runs on all asked samples and costs several hops: at most one job in so many.
const POLISHING_SHARE: usize = 4;
/// One job in so many shakes a good point slightly instead of leaving it.
const SHAKING_SHARE: usize = 8;
/// Hops go on beyond their first stage if that ended among the best two fifths of recent hops: in a trace of 400 local solves on
/// the paper's problem what improved an epoch's best was among those, and the first stage costs a quarter of the whole.
const PROMISING_SHARE: f64 = 0.4;
/// Hops that "recent" means, and that must have been seen before any is given up.
const RECENT_HOPS: usize = 64;
const FIRST_HOPS: usize = 16;

/// What a job is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Job {
    /// From a random start.
    Start,
    /// From a good point to another basin.
    Hop,
    /// Around a good point within its basin.
    Shake,
    /// Of the point at this place of the pool.
    Polish(usize),
}

/// What a job found.
#[derive(Debug, Clone)]
pub(super) struct Result {
    pub job: Job,
    pub point: Point,
    /// Smoothed criterion after the first stage of a hop that did not fall back.
    pub halfway: Option<f64>,
}

#[derive(Debug, Clone)]
pub(super) struct Epoch {
    pub pool: Pool,
    starts_left: usize,
    jobs_without_gain: usize,
    halfway: Vec<f64>,
}

impl Epoch {
    pub fn fresh() -> Self {
        Self::from_pool(Pool::default(), OPENING_STARTS)
    }

    pub fn of_champions(variables: &Variables, champions: &[Point]) -> Self {
        Self::from_pool(Pool::from_points(variables, champions.iter().cloned()), 0)
    }

    fn from_pool(pool: Pool, starts_left: usize) -> Self {
        Self {
            pool,
            starts_left,
            jobs_without_gain: 0,
            halfway: Vec::new(),
        }
    }

    /// The job at place `index` of the next round.
    pub fn job(&self, index: usize) -> Job {
        if self.starts_left > 0 || self.pool.best().is_none() {
            return Job::Start;
        }
        let polish = self.worth_polishing().nth(index / POLISHING_SHARE);
        match polish {
            Some(at) if index.is_multiple_of(POLISHING_SHARE) => Job::Polish(at),
            _ if index % SHAKING_SHARE == 1 => Job::Shake,
            _ => Job::Hop,
        }
    }

    fn worth_polishing(&self) -> impl Iterator<Item = usize> + '_ {
        let below = self.best() + WORTH_POLISHING;
        let points = self.pool.points().iter().enumerate();
        points.filter(move |(_, p)| !p.polished && p.value < below).map(|(at, _)| at)
    }

    pub fn best(&self) -> f64 {
        self.pool.best().map_or(f64::INFINITY, |p| p.value)
    }

    /// Value after the first stage of a hop up to which it goes on.
    pub fn promising(&self) -> f64 {
        if self.halfway.len() < FIRST_HOPS {
            return f64::INFINITY;
        }
        let mut recent = self.halfway[self.halfway.len().saturating_sub(RECENT_HOPS)..].to_vec();
        recent.sort_by(f64::total_cmp);
        recent[(PROMISING_SHARE * recent.len() as f64) as usize]
    }

    /// Takes a round's results in; tells whether the epoch is over.
    pub fn merge(&mut self, variables: &Variables, results: impl Iterator<Item = Result>) -> bool {
        let before = self.best();
        let mut jobs = 0;
        let mut found = Vec::new();
        for result in results {
            if let Job::Polish(at) = result.job {
                self.pool.mark_polished(at);
            }
            self.halfway.extend(result.halfway);
            found.push(result.point);
            jobs += 1;
        }
        self.pool.merge(variables, found);
        let opening = self.starts_left > 0;
        self.starts_left = self.starts_left.saturating_sub(jobs);
        self.jobs_without_gain = if opening || self.best() < before - NOTICEABLE {
            0
        } else {
            self.jobs_without_gain + jobs
        };
        self.jobs_without_gain >= PATIENCE_JOBS && self.pool.best().is_some_and(|p| p.polished)
    }
}
