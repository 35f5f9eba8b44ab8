//! Numbers that no person can read in what people read.

use super::child::files_of;
use super::target::Folders;
use flate2::read::MultiGzDecoder;
use std::io::Read;
use std::path::Path;

/// More digits in a row than a double has, its exponent written out: a number that nobody formatted.
const MOST_DIGITS: usize = 40;

/// The first `NaN`, infinity or endless number in the results or in the words of a refusal, unless the input has it as well; or a
/// picture that is no XML.
pub fn unprintable(folders: &Folders, refused: &str) -> Option<String> {
    let mut input: Option<String> = None;
    let words = ("error".to_string(), refused.as_bytes().to_vec());
    std::iter::once(words)
        .chain(walk(&folders.output))
        .into_iter()
        .find_map(|(name, content)| {
            if name.ends_with(".png") {
                return None;
            }
            let text = String::from_utf8_lossy(&content);
            if name.ends_with(".svg")
                && let Err(e) = roxmltree::Document::parse(&text)
            {
                return Some(format!("unprintable: {name} is no XML: {e}"));
            }
            let token = odd_word(&text)?.to_lowercase();
            let given = input.get_or_insert_with(|| all_text(&folders.input));
            (!given.contains(&token)).then(|| format!("unprintable: {name} has {token}"))
        })
}

/// What the input says, unpacked and in whatever encoding.
fn all_text(folder: &Path) -> String {
    // `why` stands beside inputs that were kept and says what was found.
    let files = files_of(folder).into_iter().filter(|(name, _)| name != "why");
    let texts = files.map(|(_, content)| {
        let mut unpacked = Vec::new();
        // What is cut off is read as far as it goes.
        let _ = MultiGzDecoder::new(&content[..])
            .take(MOST_UNPACKED)
            .read_to_end(&mut unpacked);
        let plain = [content, unpacked].concat();
        // UTF-16 is ASCII with a zero beside every letter.
        let ascii: Vec<u8> = plain.iter().copied().filter(|b| *b != 0).collect();
        String::from_utf8_lossy(&ascii).to_lowercase()
    });
    texts.collect()
}

const MOST_UNPACKED: u64 = 16 << 20;

fn walk(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = files_of(folder);
    let plots = folder.join("plots");
    if plots.is_dir() {
        all.extend(files_of(&plots));
    }
    all
}

/// A word that stands for no number, or a number that is too long.
fn odd_word(text: &str) -> Option<&str> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let is_odd = |word: &&str| {
        let digits = || word.len() > MOST_DIGITS && word.bytes().all(|b| b.is_ascii_digit());
        matches!(*word, "NaN" | "inf" | "Infinity") || digits()
    };
    words.into_iter().find(is_odd)
}
