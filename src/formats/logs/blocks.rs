//! A file, a block of whole lines at a time: while some threads turn one batch of blocks into columns, another takes up the
//! columns of the batch before and reads (and unpacks) the next.

use super::rows::{Part, RowShape};
use crate::model::INPUT_LIMITS;
use memchr::{memchr_iter, memrchr};
use rayon::prelude::*;
use std::io::{self, Read};

/// Bytes that one thread parses at a time: a millisecond's work, which stays in the cache together with its columns.
const BLOCK: usize = 1 << 18;
/// Longest line that is read.
const LONGEST_LINE: usize = INPUT_LIMITS.log_line;

/// Why reading ended before the file did.
pub(super) enum Broken {
    Io(io::Error),
    LongLine,
}

/// A break, and the lines that were read before it.
pub(super) struct Break {
    pub lines: u64,
    pub reason: Broken,
}

/// Hands the parts of `bytes` to `take` in their order, each with the number of lines before it, until it refuses.
pub(super) fn for_each_part<E: Send>(
    bytes: &mut (impl Read + Send),
    shape: &RowShape,
    mut take: impl FnMut(&mut Part, u64) -> Result<(), E> + Send,
    broken: impl FnOnce(Break) -> E,
) -> Result<(), E> {
    let mut lines = 0;
    let mut hand_over = |blocks: &mut Vec<Block>| {
        blocks.iter_mut().try_for_each(|block| {
            let before = lines;
            lines += block.part.line_count;
            take(&mut block.part, before)
        })
    };
    let mut carry = Vec::new();
    let mut parsed = Vec::new();
    let mut batch = Batch::read(bytes, &mut carry, Vec::new());
    loop {
        let parse = || {
            batch
                .blocks
                .par_iter_mut()
                .for_each(|block| shape.parse(&mut block.text, &mut block.part))
        };
        let beside = || {
            hand_over(&mut parsed)?;
            // Their buffers are free again: a log goes through a few blocks, however long it is.
            let spare = std::mem::take(&mut parsed);
            Ok(batch.end.is_none().then(|| Batch::read(bytes, &mut carry, spare)))
        };
        let ((), next) = rayon::join(parse, beside);
        parsed = batch.blocks;
        match (next?, batch.end) {
            (Some(next), _) => batch = next,
            (None, end) => {
                hand_over(&mut parsed)?;
                return match end {
                    Some(End::Broken(reason, unread)) => Err(broken(Break {
                        lines: lines + unread,
                        reason,
                    })),
                    _ => Ok(()),
                };
            }
        }
    }
}

/// Some whole lines and their rows.
#[derive(Default)]
struct Block {
    text: Vec<u8>,
    part: Part,
}

/// Two blocks for every thread.
struct Batch {
    blocks: Vec<Block>,
    /// `None` where more follows.
    end: Option<End>,
}

enum End {
    File,
    /// After so many lines of text that is in no block.
    Broken(Broken, u64),
}

impl Batch {
    /// Reads into the buffers of `spare` as long as there are any.
    fn read(bytes: &mut impl Read, carry: &mut Vec<u8>, mut spare: Vec<Block>) -> Self {
        let wanted = 2 * rayon::current_num_threads();
        let mut blocks = Vec::with_capacity(wanted);
        while blocks.len() < wanted {
            let mut block = spare.pop().unwrap_or_default();
            let end = match fill(&mut block.text, bytes, carry) {
                Ok(true) => None,
                Ok(false) => Some(End::File),
                Err((reason, lines)) => Some(End::Broken(reason, lines)),
            };
            if end.is_some() {
                return Self { blocks, end };
            }
            blocks.push(block);
        }
        Self { blocks, end: None }
    }
}

/// Fills `text` with whole lines, or what is left at the end of the file; false when nothing is. `carry` has the beginning of the
/// line that the block before cut.
fn fill(text: &mut Vec<u8>, bytes: &mut impl Read, carry: &mut Vec<u8>) -> Result<bool, (Broken, u64)> {
    text.clear();
    text.append(carry);
    loop {
        let from = text.len();
        text.reserve(BLOCK);
        let read = bytes.by_ref().take(BLOCK as u64).read_to_end(text);
        if let Err(e) = read {
            let lines = memchr_iter(b'\n', text).count() as u64;
            return Err((Broken::Io(e), lines));
        }
        if text.len() == from {
            return Ok(!text.is_empty());
        }
        if let Some(end) = memrchr(b'\n', &text[from..]) {
            carry.extend_from_slice(&text[from + end + 1..]);
            text.truncate(from + end + 1);
            return Ok(true);
        }
        if text.len() > LONGEST_LINE {
            return Err((Broken::LongLine, 0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape() -> RowShape {
        RowShape::of_fields(b',', 3, Some(0), vec![1, 2])
    }

    fn read(text: &str) -> (Vec<f64>, Vec<Vec<f64>>, usize) {
        let (mut time, mut columns, mut bad) = (Vec::new(), vec![Vec::new(); 2], 0);
        let take = |part: &mut Part, _: u64| {
            time.extend_from_slice(&part.time);
            columns
                .iter_mut()
                .zip(&part.columns)
                .for_each(|(c, p)| c.extend_from_slice(p));
            bad += part.garbage.count;
            Ok::<(), ()>(())
        };
        for_each_part(&mut text.as_bytes(), &shape(), take, |_| ()).unwrap();
        (time, columns, bad)
    }

    #[test]
    fn prop_blocks_and_their_seams_lose_nothing() {
        // Several batches of blocks, seams within rows.
        let rows = 60 * BLOCK / 20;
        let mut text = String::new();
        for i in 0..rows {
            text += &format!("{i},{},{}\n", 2 * i, 3 * i + 1);
        }
        let (time, columns, bad) = read(&text);
        assert_eq!((time.len(), bad), (rows, 0));
        assert!(
            (0..rows).all(|i| time[i] == i as f64 && columns[0][i] == 2.0 * i as f64 && columns[1][i] == 3.0 * i as f64 + 1.0)
        );
    }

    #[test]
    fn prop_quotes_comments_and_empty_lines_are_read_as_tables_are() {
        let text = "# a comment\n\n0,\"1\",2\r\n\"3\",\"4\",5\n6,\"7,8\n9,10,11";
        let (time, columns, bad) = read(text);
        assert_eq!(
            (time, columns, bad),
            (vec![0.0, 3.0, 9.0], vec![vec![1.0, 4.0, 10.0], vec![2.0, 5.0, 11.0]], 1)
        );
    }

    #[test]
    fn prop_a_line_without_end_is_refused_before_it_fills_the_memory() {
        let mut endless = io::repeat(b'1');
        let found = for_each_part(
            &mut endless,
            &shape(),
            |_, _| Ok(()),
            |b| matches!(b.reason, Broken::LongLine),
        );
        assert_eq!(found, Err(true));
    }
}
