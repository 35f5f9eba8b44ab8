//! What a search is given, and what it tells and asks while it runs.

use crate::excitation::pool::{Point, Pool};
use crate::excitation::problem::Criterion;
use crate::excitation::report::StartReport;
use crate::excitation::variables::Variables;

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchOptions {
    /// Of every random number: the same seed gives the same answer.
    pub seed: u64,
    /// Random starts at least made before a search without limits may end.
    pub starts: usize,
    /// Evaluations of the criterion after which no new round begins; the count that makes a run repeatable to the bit.
    pub max_evaluations: Option<u64>,
    /// Local solves per round, at most so many run at the same time. Part of what makes a run repeatable.
    pub jobs_per_round: usize,
    /// Whether some outer limit (of time) will end the search. Without any limit it ends when it has converged.
    pub until_halted: bool,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            starts: 64,
            max_evaluations: None,
            jobs_per_round: 16,
            until_halted: false,
        }
    }
}

/// Why a search should end now.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Halt {
    /// The time limit was reached.
    TimeUp,
    /// It was cancelled.
    Cancelled,
}

/// What a running search tells and asks; called from many threads.
pub trait Control: Sync {
    /// Asked before every evaluation.
    fn halt(&self) -> Option<Halt>;
    /// Called after every local solve.
    fn progress(&self, progress: &Progress);
    /// Called after every round with what a search that continues from here would need.
    fn found(&self, _found: &Found) {}
    /// Asked at the beginning and at the end of every epoch for what other searches of the same problem have found since it was
    /// last asked. An answer that depends on how fast others are makes this search depend on it too.
    fn others(&self) -> Vec<Point> {
        Vec::new()
    }
}

/// What a search has found.
pub struct Found<'a> {
    /// Epochs that are over.
    pub epochs: usize,
    /// Evaluations of the criterion.
    pub evaluations: u64,
    pub(super) variables: &'a Variables,
    pub(super) champions: &'a [Point],
    pub(super) running: Option<&'a Point>,
}

impl Found<'_> {
    /// Logarithm of the criterion at the best point; infinite before the first.
    pub fn best(&self) -> f64 {
        self.all().map(|p| p.value).fold(f64::INFINITY, f64::min)
    }

    /// The champions and the best point of the running epoch: the best of each niche, best first.
    pub fn points(&self) -> Vec<Point> {
        Pool::from_points(self.variables, self.all().cloned()).points().to_vec()
    }

    fn all(&self) -> impl Iterator<Item = &Point> {
        self.champions.iter().chain(self.running)
    }
}

/// State of a running search.
#[derive(Debug, Clone, PartialEq)]
pub struct Progress {
    /// Value of the criterion at the best point so far (the condition number, not its logarithm); infinite before the first.
    pub best: f64,
    /// Starts that have ended.
    pub starts_finished: usize,
    /// Starts in all.
    pub starts: usize,
    /// Evaluations of the criterion up to now.
    pub evaluations: u64,
    /// Rounds that have ended.
    pub rounds_finished: usize,
    /// The random start that has just ended; `None` after local solves around known points.
    pub start: Option<StartReport>,
    /// What is minimised.
    pub criterion: Criterion,
}
