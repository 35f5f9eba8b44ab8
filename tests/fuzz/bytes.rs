//! Changes that know no grammar.

use super::dice::Dice;
use super::tokens;

pub fn mutate(bytes: &mut Vec<u8>, dice: &mut Dice) {
    let at = dice.below(bytes.len());
    let run = dice.run(bytes.len(), 64);
    match dice.below(8) {
        0 => bytes.truncate(at),
        1 if !bytes.is_empty() => bytes[at] ^= 1 << dice.below(8),
        2 if !bytes.is_empty() => bytes[at] = dice.bits() as u8,
        3 => drop(bytes.drain(run)),
        4 => bytes.extend_from_within(run),
        5 => {
            let copy = bytes[run].to_vec();
            bytes.splice(at..at, copy);
        }
        6 => drop(bytes.splice(at..at, tokens::word(dice).into_bytes())),
        _ => drop(bytes.splice(at..at, tokens::number(dice).into_bytes())),
    }
}
