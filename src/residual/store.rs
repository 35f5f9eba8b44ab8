//! Columns of candidates that the motion alone decides: made, filtered and kept once, since every scan asks for them again.

use super::candidate::Candidate;
use crate::effects::Column;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Columns of one shape, one list per stretch, as they enter the rows.
pub(crate) type Shaped = Vec<Vec<Column>>;

/// Which columns: effect, form, joints, and the bits of the shape parameters.
type Key = (&'static str, usize, Vec<usize>, Vec<u64>);

/// What has been made so far.
#[derive(Default)]
pub(crate) struct ColumnStore {
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    columns: HashMap<Key, Arc<Shaped>>,
    numbers: usize,
}

/// Numbers kept at most (128 MB): all columns of seven joints with 4,000 rows. What goes beyond is made anew each time.
const MOST_NUMBERS: usize = 16 << 20;

impl ColumnStore {
    /// The columns of `candidate` at `shape`, by `make` where they are not there yet.
    pub fn get(&self, candidate: &Candidate, shape: &[f64], make: impl FnOnce() -> Shaped) -> Arc<Shaped> {
        let bits = shape.iter().map(|v| v.to_bits()).collect();
        let key = (candidate.effect.code(), candidate.form, candidate.joints.clone(), bits);
        if let Some(known) = self.lock().columns.get(&key) {
            return known.clone();
        }
        // Made without the lock: others go on, and who makes the same makes equal columns.
        let made = Arc::new(make());
        let numbers: usize = made.iter().flatten().flat_map(|c| c.rows.iter().map(|r| r.1.len())).sum();
        let mut kept = self.lock();
        if kept.numbers + numbers <= MOST_NUMBERS && kept.columns.insert(key, made.clone()).is_none() {
            kept.numbers += numbers;
        }
        made
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
