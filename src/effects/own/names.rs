//! Names in formulas: what they can be, and what they say.

use super::tree::Function;

/// Characters of a name of an effect or parameter.
pub const MOST_NAME: usize = 64;

/// Why a formula can have no parameter or channel of this name; `None` where it can.
pub fn name_fault(name: &str) -> Option<String> {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let first = name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    if !first || !name.chars().all(word) || name.len() > MOST_NAME {
        return Some("is no name in an expression".into());
    }
    let taken = name == "pi" || Function::NAMED.iter().any(|(f, _)| *f == name) || numbered(name).is_some();
    taken.then(|| format!("`{name}` has a meaning in expressions already"))
}

/// Order and number of `q1`, `qd1`, `qdd1`.
fn numbered(name: &str) -> Option<(usize, &str)> {
    let rest = name.strip_prefix('q')?;
    let number = rest.trim_start_matches('d');
    let order = rest.len() - number.len();
    let digits = number.starts_with(|c: char| ('1'..='9').contains(&c)) && number.bytes().all(|b| b.is_ascii_digit());
    (digits && order <= 2).then_some((order, number))
}

/// What a name says if it is no parameter and no channel: position (order 0), speed (1) or acceleration (2) of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Said<'a> {
    /// `q1`, `qd1`, `qdd1`.
    Numbered { order: usize, number: &'a str },
    /// `q_A2`, `qd_A2`, `qdd_A2`.
    Named { order: usize, joint: &'a str },
    /// `q`, `qd`, `qdd`: of the joint that the effect acts on.
    Own { order: usize },
}

pub fn said(name: &str) -> Option<Said<'_>> {
    if let Some((order, number)) = numbered(name) {
        return Some(Said::Numbered { order, number });
    }
    let (head, joint) = name.split_once('_').map_or((name, None), |(head, joint)| (head, Some(joint)));
    let order = ["q", "qd", "qdd"].iter().position(|h| *h == head)?;
    Some(joint.map_or(Said::Own { order }, |joint| Said::Named { order, joint }))
}
