//! What a user should know about how a description was read.

use super::INPUT_LIMITS;

/// Notes in the order in which they came up, no more than anybody reads.
#[derive(Debug, Clone, Default)]
pub struct Notes {
    kept: Vec<String>,
    further: usize,
}

impl Notes {
    /// Adds a note.
    pub fn push(&mut self, note: impl Into<String>) {
        if self.kept.len() < INPUT_LIMITS.notes {
            self.kept.push(note.into());
        } else {
            self.further += 1;
        }
    }

    /// Adds several notes.
    pub fn extend(&mut self, notes: impl IntoIterator<Item = String>) {
        notes.into_iter().for_each(|n| self.push(n));
    }

    /// The list; where it was cut, its last entry says how many are missing.
    pub fn into_list(mut self) -> Vec<String> {
        if self.further > 0 {
            self.kept.push(format!("and {} further notes of these kinds", self.further));
        }
        self.kept
    }
}

/// Names in quotation marks, the first few of many.
pub(super) fn some_of(names: &[&str]) -> String {
    const SHOWN: usize = 8;
    let shown: Vec<String> = names.iter().take(SHOWN).map(|n| format!("`{n}`")).collect();
    match names.len().saturating_sub(SHOWN) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
