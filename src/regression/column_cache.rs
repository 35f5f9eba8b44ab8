//! Columns of candidates that the motion alone decides: made, filtered and kept once, since every scan asks for them again.

use crate::effects::Column;
use crate::regression::settings::SETTINGS;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Columns of one shape, one list per stretch, as they enter the rows.
pub(crate) type Shaped = Vec<Vec<Column>>;

/// Which columns: code of the effect, form, joints, and the bits of the shape parameters.
pub(crate) type ColumnKey = (Box<str>, usize, Vec<usize>, Vec<u64>);

/// What has been made so far.
#[derive(Default)]
pub(crate) struct ColumnStore {
    kept: Mutex<Kept>,
}

#[derive(Default)]
struct Kept {
    columns: HashMap<ColumnKey, Arc<Shaped>>,
    numbers: usize,
}

impl ColumnStore {
    /// The columns called `key`, by `make` where they are not there yet.
    pub fn get(&self, key: ColumnKey, make: impl FnOnce() -> Shaped) -> Arc<Shaped> {
        if let Some(known) = self.lock().columns.get(&key) {
            return known.clone();
        }
        // Made without the lock: others go on, and who makes the same makes equal columns.
        let made = Arc::new(make());
        let numbers: usize = made.iter().flatten().flat_map(|c| c.rows.iter().map(|r| r.1.len())).sum();
        let mut kept = self.lock();
        if kept.numbers + numbers <= SETTINGS.cached_numbers && kept.columns.insert(key, made.clone()).is_none() {
            kept.numbers += numbers;
        }
        made
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
