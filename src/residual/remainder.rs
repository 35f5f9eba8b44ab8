//! What no effect explains, and what it depends on.

use super::Remainder;
use super::candidate::Candidate;
use super::select::{Selected, Threshold};
use super::system::Data;

pub(crate) fn examine(_data: &Data, selected: Selected, _fixed: usize, _candidates: &[Candidate], _threshold: &Threshold) -> (Selected, Option<Remainder>) {
    (selected, None)
}
