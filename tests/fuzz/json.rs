//! JSON as a tree that can hold what no JSON may: names twice, numbers that are none, brackets without end.

use super::dice::Dice;
use super::tokens;
use serde_json::Value;

#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// A number, `true`, `null`, or whatever else stands for itself.
    Raw(String),
    Text(String),
    List(Vec<Node>),
    Fields(Vec<(String, Node)>),
}

/// Entries that a list may be blown up to: enough to make work that grows with the square of the length visible in seconds.
const LONGEST: usize = 30_000;

impl Node {
    pub fn of(value: &Value) -> Self {
        match value {
            Value::String(text) => Self::Text(text.clone()),
            Value::Array(items) => Self::List(items.iter().map(Self::of).collect()),
            Value::Object(fields) => Self::Fields(fields.iter().map(|(name, v)| (name.clone(), Self::of(v))).collect()),
            other => Self::Raw(other.to_string()),
        }
    }

    pub fn render(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) {
        match self {
            Self::Raw(token) => out.push_str(token),
            Self::Text(text) => out.push_str(&Value::from(text.as_str()).to_string()),
            Self::List(items) => {
                for (i, item) in items.iter().enumerate() {
                    out.push(if i == 0 { '[' } else { ',' });
                    item.write(out);
                }
                out.push_str(if items.is_empty() { "[]" } else { "]" });
            }
            Self::Fields(fields) => {
                for (i, (name, value)) in fields.iter().enumerate() {
                    out.push(if i == 0 { '{' } else { ',' });
                    out.push_str(&Value::from(name.as_str()).to_string());
                    out.push(':');
                    value.write(out);
                }
                out.push_str(if fields.is_empty() { "{}" } else { "}" });
            }
        }
    }

    fn is_leaf(&self) -> bool {
        matches!(self, Self::Raw(_) | Self::Text(_))
    }

    /// Leaves or branches in the order of the text.
    fn count(&self, leaves: bool) -> usize {
        let own = usize::from(self.is_leaf() == leaves);
        own + match self {
            Self::List(items) => items.iter().map(|n| n.count(leaves)).sum(),
            Self::Fields(fields) => fields.iter().map(|(_, n)| n.count(leaves)).sum(),
            _ => 0,
        }
    }

    fn at(&mut self, leaves: bool, index: &mut usize) -> Option<&mut Node> {
        if self.is_leaf() == leaves {
            if *index == 0 {
                return Some(self);
            }
            *index -= 1;
        }
        match self {
            Self::List(items) => items.iter_mut().find_map(|n| n.at(leaves, index)),
            Self::Fields(fields) => fields.iter_mut().find_map(|(_, n)| n.at(leaves, index)),
            _ => None,
        }
    }

    /// Changes one place. Half of all changes put another number in the place of one: what is asked stays a question, and is not
    /// refused at the door.
    pub fn mutate(&mut self, dice: &mut Dice) {
        if dice.chance(0.5) {
            return self.change_number(dice);
        }
        let mut other = self.clone();
        let leaves = dice.chance(0.65);
        let elsewhere = dice.chance(0.5);
        let piece = {
            let count = other.count(elsewhere);
            let mut index = dice.below(count);
            other.at(elsewhere, &mut index).map(|n| n.clone())
        };
        let count = self.count(leaves);
        let mut index = dice.below(count);
        if let Some(node) = self.at(leaves, &mut index) {
            node.change(piece.unwrap_or(Node::List(Vec::new())), dice);
        }
    }

    fn change_number(&mut self, dice: &mut Dice) {
        let mut numbers = Vec::new();
        self.numbers(&mut numbers);
        let at = dice.below(numbers.len());
        let Some(token) = numbers.get_mut(at) else { return };
        **token = match token.parse::<f64>() {
            Ok(value) if dice.chance(0.7) => tokens::shortest(tokens::changed(value, dice)),
            _ => tokens::number(dice),
        };
    }

    fn numbers<'a>(&'a mut self, into: &mut Vec<&'a mut String>) {
        match self {
            Self::Raw(token) if token.parse::<f64>().is_ok() => into.push(token),
            Self::List(items) => items.iter_mut().for_each(|n| n.numbers(into)),
            Self::Fields(fields) => fields.iter_mut().for_each(|(_, n)| n.numbers(into)),
            _ => {}
        }
    }

    fn change(&mut self, piece: Node, dice: &mut Dice) {
        if dice.chance(0.08) {
            *self = replacement(piece, dice);
            return;
        }
        match self {
            Self::Raw(token) => *token = tokens::another(token, dice),
            Self::Text(text) => change_text(text, dice),
            Self::List(items) => change_list(items, piece, dice),
            Self::Fields(fields) => change_fields(fields, piece, dice),
        }
        // A number may have become a word: no JSON, and most of what could be tried is then not reached.
        if let Self::Raw(token) = self
            && serde_json::from_str::<Value>(token).is_err()
            && dice.chance(0.7)
        {
            *self = Self::Text(std::mem::take(token));
        }
    }
}

/// A value of another kind.
fn replacement(piece: Node, dice: &mut Dice) -> Node {
    match dice.below(9) {
        0 => Node::Raw("null".into()),
        1 => Node::Raw("true".into()),
        2 => Node::List(Vec::new()),
        3 => Node::Fields(Vec::new()),
        4 => Node::Text(tokens::word(dice)),
        5 => Node::Raw(tokens::number(dice)),
        // Around the depth that readers accept, and far beyond it.
        6 => {
            let depth = [90, 99, 101, 127, 129, 5_000, 200_000][dice.below(7)];
            Node::Raw(format!("{}{}", "[".repeat(depth), "]".repeat(depth)))
        }
        7 => {
            let depth = [60, 101, 3_000][dice.below(3)];
            Node::Raw(format!("{}1{}", "{\"a\":".repeat(depth), "}".repeat(depth)))
        }
        _ => piece,
    }
}

fn change_text(text: &mut String, dice: &mut Dice) {
    match dice.below(5) {
        0 => text.push_str(&tokens::word(dice)),
        1 => text.make_ascii_uppercase(),
        2 => {
            text.pop();
        }
        _ => *text = tokens::word(dice),
    }
}

fn change_list(items: &mut Vec<Node>, piece: Node, dice: &mut Dice) {
    let at = dice.below(items.len());
    match dice.below(9) {
        0 => items.clear(),
        1 if !items.is_empty() => drop(items.remove(at)),
        2 if !items.is_empty() => items.insert(at, items[at].clone()),
        3 => items.insert(at, piece),
        4 if items.len() > 1 => items.swap(at, 0),
        5 => items.truncate(at),
        6 if !items.is_empty() => items.extend(vec![items[at].clone(); 1 + dice.below(20)]),
        7 if !items.is_empty() && dice.chance(0.2) => items.resize([200, 2_000, LONGEST][dice.below(3)], items[at].clone()),
        _ => items.push(Node::Raw(tokens::number(dice))),
    }
}

fn change_fields(fields: &mut Vec<(String, Node)>, piece: Node, dice: &mut Dice) {
    let at = dice.below(fields.len());
    let other = dice.below(fields.len());
    match dice.below(9) {
        0 | 1 if !fields.is_empty() => drop(fields.remove(at)),
        2 if !fields.is_empty() => fields.push((fields[at].0.clone(), piece)),
        3 if !fields.is_empty() => fields.push(fields[at].clone()),
        4 if !fields.is_empty() => fields[at].0 = tokens::word(dice),
        // Values that belong to other names: the right kind, the wrong place.
        5 | 6 if fields.len() > 1 && at != other => {
            let value = fields[at].1.clone();
            fields[other].1 = value;
        }
        7 if !fields.is_empty() => fields[at].1 = Node::Raw("null".into()),
        _ => fields.push((tokens::word(dice), piece)),
    }
}
