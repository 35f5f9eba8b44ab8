//! Recordings that are no text, by the libraries of their formats.
//!
//! Everything that a file states of itself (sizes, counts, nesting) is held against a limit before memory is taken for it.

mod arrays;
mod bag;
mod bag_folder;
mod definition;
mod generic;
mod idl;
mod matlab;
mod mcap;
mod messages;
mod npz;
mod parquet;
mod rosbag2;

use super::LogError;
use super::kind::Kind;
use super::reader::broken;
use super::sheet::Sheet;
use super::unpack::Bytes;
use crate::model::INPUT_LIMITS;
use std::io::Read;

/// Opens a file of the kind that its first bytes say.
pub(super) fn open<'a>(file: &str, kind: Kind, mut bytes: Bytes<'a>) -> Result<Box<dyn Sheet + 'a>, LogError> {
    Ok(match kind {
        Kind::Npz => {
            let all = whole(file, &mut bytes)?;
            match bag_folder::open(file, &all)? {
                Some(bag) => Box::new(bag),
                None => Box::new(npz::Npz::open(file, all)?),
            }
        }
        Kind::Parquet => Box::new(parquet::Parquet::open(file, whole(file, &mut bytes)?)?),
        Kind::Matlab => Box::new(matlab::open(file, &whole(file, &mut bytes)?)?),
        Kind::Mcap => Box::new(mcap::open(file, &mut bytes)?),
        _ => Box::new(rosbag2::open(file, &mut bytes)?),
    })
}

/// All of a file that is read by jumping about in it.
fn whole(file: &str, bytes: &mut Bytes) -> Result<Vec<u8>, LogError> {
    let limit = INPUT_LIMITS.log_in_memory;
    let mut all = Vec::new();
    bytes.take(limit + 1).read_to_end(&mut all).map_err(|e| broken(file, 0, &e))?;
    if all.len() as u64 > limit {
        return Err(too_large(file, "bytes", limit));
    }
    Ok(all)
}

fn too_large(file: &str, what: &'static str, limit: u64) -> LogError {
    LogError::TooLarge {
        file: file.to_string(),
        what,
        limit,
    }
}

/// Numbers that all columns of one file may have together.
const MOST_NUMBERS: usize = INPUT_LIMITS.log_numbers;
