//! How long and how widely to search.

use crate::documents::cursor::{Cursor, Fields};
use crate::documents::requests;
use crate::excitation::SearchOptions;

/// How long and how widely to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Starts, seed and greatest number of evaluations, as the core takes them.
    pub options: SearchOptions,
    /// Time after which the best trajectory found is handed back (s).
    pub time_limit_s: f64,
}

/// A day: longer searches are mistakes in the unit.
const LONGEST_SEARCH_S: f64 = 86_400.0;
/// Time limit where neither time nor evaluations are limited: the search ends by itself when it has converged, usually before.
const DEFAULT_TIME_LIMIT_S: f64 = 60.0;
/// Local solves that may wait for each other at the end of a round; beyond this the rounds are too few to learn from each other.
const MOST_JOBS: u64 = 1024;
/// Largest whole number that every JSON program carries exactly.
const LARGEST_SEED: u64 = (1 << 53) - 1;

pub(super) fn read_search(fields: &Fields) -> Search {
    let search = fields.optional("search").and_then(|c| c.fields_of::<requests::Search>());
    let field = |name: &str| search.as_ref().and_then(|f| f.nullable(name));
    let time_limit_s = field("time_limit_s").and_then(|c| read_time_limit(&c));
    let max_evaluations = field("max_evaluations").and_then(|c| c.whole(1, LARGEST_SEED));
    let defaults = SearchOptions::default();
    let options = SearchOptions {
        seed: field("seed").and_then(|c| c.whole(0, LARGEST_SEED)).unwrap_or(defaults.seed),
        starts: field("starts")
            .and_then(|c| c.whole(1, 100_000))
            .unwrap_or(defaults.starts as u64) as usize,
        max_evaluations,
        jobs_per_round: field("jobs_per_round")
            .and_then(|c| c.whole(1, MOST_JOBS))
            .unwrap_or(defaults.jobs_per_round as u64) as usize,
        // Time that was asked for is used; time that was not is saved once the search has converged.
        until_halted: time_limit_s.is_some(),
    };
    // A count of evaluations makes a run repeatable; a clock that nobody asked for must not cut it short.
    let unasked = if max_evaluations.is_some() {
        LONGEST_SEARCH_S
    } else {
        DEFAULT_TIME_LIMIT_S
    };
    Search {
        options,
        time_limit_s: time_limit_s.unwrap_or(unasked),
    }
}

fn read_time_limit(cursor: &Cursor) -> Option<f64> {
    let limit = cursor.number()?;
    if !(limit > 0.0 && limit <= LONGEST_SEARCH_S) {
        let detail = format!("is {limit}; a time limit is above zero and at most {LONGEST_SEARCH_S} s");
        cursor.complain(detail);
    }
    Some(limit)
}
