//! Definitions of ROS messages: which fields lie in a message, in which order.
//!
//! `.msg` text (ROS 1 and 2) and `.idl` (ROS 2), as recordings carry them: the message's own definition and those that it uses,
//! parted by lines of `=`.

use super::idl;
use std::collections::HashMap;

/// How a number lies in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Bool,
    Int(u8),
    Uint(u8),
    Float(u8),
}

impl Number {
    /// Bytes.
    pub fn size(self) -> usize {
        match self {
            Self::Bool => 1,
            Self::Int(size) | Self::Uint(size) | Self::Float(size) => size as usize,
        }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    Number(Number),
    Text,
    /// Text of two bytes a letter.
    WideText,
    /// Seconds and nanoseconds.
    Time,
    /// Another message, by its name.
    Message(String),
}

/// How often a field lies in a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    One,
    Fixed(usize),
    /// As often as the message says.
    Many,
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    pub name: String,
    pub kind: Kind,
    pub count: Count,
}

/// A message with all that it uses: `messages` by number, the first is the message itself.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Definition {
    pub messages: Vec<Vec<Resolved>>,
}

/// A field whose message is known by its number.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Resolved {
    pub name: String,
    pub kind: ResolvedKind,
    pub count: Count,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ResolvedKind {
    Number(Number),
    Text,
    WideText,
    Time,
    Message(usize),
}

/// Messages that one definition may use; the largest of ROS use a few dozen.
const MOST_MESSAGES: usize = 500;
/// Fields of all of them.
const MOST_FIELDS: usize = 20_000;

/// Definitions that recordings of ROS 2 before Iron do not carry: those of the packages that measured quantities are sent by.
const WELL_KNOWN: &str = include_str!("well_known.msg");

impl Definition {
    /// Of the message `name` (`sensor_msgs/msg/Imu`), from the text that a recording has of it; without any, if it is well known.
    /// `None` where a message that is used is not defined, or nothing is understood.
    pub fn read(name: &str, text: &str) -> Option<Self> {
        let mut known = HashMap::new();
        sections(WELL_KNOWN, "", &mut known)?;
        sections(text, &plain(name), &mut known)?;
        let mut definition = Self { messages: Vec::new() };
        let mut order = vec![plain(name)];
        let mut at = 0;
        while at < order.len() {
            let fields = known.get(&order[at])?;
            let package = order[at].split('/').next().unwrap_or_default().to_string();
            let mut resolved = Vec::with_capacity(fields.len());
            for field in fields {
                resolved.push(Resolved {
                    name: field.name.clone(),
                    kind: resolve(&field.kind, &package, &known, &mut order)?,
                    count: field.count,
                });
            }
            definition.messages.push(resolved);
            at += 1;
            if order.len() > MOST_MESSAGES {
                return None;
            }
        }
        Some(definition)
    }
}

fn resolve(kind: &Kind, package: &str, known: &HashMap<String, Vec<Field>>, order: &mut Vec<String>) -> Option<ResolvedKind> {
    let name = match kind {
        Kind::Number(n) => return Some(ResolvedKind::Number(*n)),
        Kind::Text => return Some(ResolvedKind::Text),
        Kind::WideText => return Some(ResolvedKind::WideText),
        Kind::Time => return Some(ResolvedKind::Time),
        Kind::Message(name) => plain(name),
    };
    let full = match name.as_str() {
        "builtin_interfaces/Time" | "builtin_interfaces/Duration" => return Some(ResolvedKind::Time),
        "Header" => "std_msgs/Header".to_string(),
        _ if name.contains('/') => name,
        _ => format!("{package}/{name}"),
    };
    known.get(&full)?;
    let at = order.iter().position(|o| *o == full).unwrap_or_else(|| {
        order.push(full);
        order.len() - 1
    });
    Some(ResolvedKind::Message(at))
}

/// `sensor_msgs/msg/Imu`, `sensor_msgs::msg::Imu` and `sensor_msgs::msg::dds_::Imu_` are one message.
fn plain(name: &str) -> String {
    let parts = name
        .split(['/', ':'])
        .filter(|p| !p.is_empty() && !["msg", "dds_"].contains(p));
    let joined = parts.collect::<Vec<_>>().join("/");
    let is_dds = name.contains("dds_");
    joined.strip_suffix('_').filter(|_| is_dds).unwrap_or(&joined).to_string()
}

/// Reads every definition in `text`; the first, if it has no heading, is that of `first`. `None` beyond all limits.
fn sections(text: &str, first: &str, known: &mut HashMap<String, Vec<Field>>) -> Option<()> {
    let is_border = |line: &str| line.len() >= 8 && line.bytes().all(|b| b == b'=');
    let mut name = first.to_string();
    let mut body = String::new();
    let mut fields = 0;
    let mut close = |name: &str, body: &str, is_idl: bool| {
        if is_idl || body.contains("module ") && body.contains("struct ") {
            let found = idl::structs(body);
            fields += found.iter().map(|(_, f)| f.len()).sum::<usize>();
            known.extend(found.into_iter().map(|(name, f)| (plain(&name), f)));
        } else if !name.is_empty() && !body.trim().is_empty() {
            let found = msg_fields(body);
            fields += found.len();
            known.insert(name.to_string(), found);
        }
        (fields <= MOST_FIELDS).then_some(())
    };
    let mut is_idl = false;
    for line in text.lines().map(str::trim) {
        if is_border(line) {
            close(&name, &body, is_idl)?;
            (name, body, is_idl) = (String::new(), String::new(), false);
        } else if let Some(heading) = line.strip_prefix("MSG:") {
            name = plain(heading.trim());
        } else if let Some(heading) = line.strip_prefix("IDL:") {
            (name, is_idl) = (plain(heading.trim()), true);
        } else {
            body.push_str(line);
            body.push('\n');
        }
    }
    close(&name, &body, is_idl)
}

/// Fields of a `.msg` file; constants are no fields.
fn msg_fields(body: &str) -> Vec<Field> {
    let line = |line: &str| {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (kind, rest) = line.split_once(char::is_whitespace)?;
        let name = rest.split_whitespace().next()?;
        if rest
            .split_once('=')
            .is_some_and(|(before, _)| before.split_whitespace().count() == 1)
        {
            return None;
        }
        let (kind, count) = match kind.split_once('[') {
            None => (kind, Count::One),
            Some((kind, size)) => match size.trim_end_matches(']') {
                "" => (kind, Count::Many),
                size if size.starts_with("<=") => (kind, Count::Many),
                size => (kind, Count::Fixed(size.parse().ok()?)),
            },
        };
        Some(Field {
            name: name.to_string(),
            kind: msg_kind(kind.split("<=").next()?),
            count,
        })
    };
    body.lines().filter_map(line).collect()
}

fn msg_kind(word: &str) -> Kind {
    Kind::Number(match word {
        "bool" => Number::Bool,
        "byte" | "uint8" | "char" => Number::Uint(1),
        "int8" => Number::Int(1),
        "int16" => Number::Int(2),
        "uint16" => Number::Uint(2),
        "int32" => Number::Int(4),
        "uint32" => Number::Uint(4),
        "int64" => Number::Int(8),
        "uint64" => Number::Uint(8),
        "float32" => Number::Float(4),
        "float64" => Number::Float(8),
        "string" => return Kind::Text,
        "wstring" => return Kind::WideText,
        "time" | "duration" => return Kind::Time,
        other => return Kind::Message(other.to_string()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(definition: &Definition, of: usize) -> Vec<&str> {
        definition.messages[of].iter().map(|f| f.name.as_str()).collect()
    }

    #[test]
    fn fields_are_read_from_msg_and_idl_alike() {
        let msg = "# mine\nstd_msgs/Header header\nfloat64[6] tau # N m\nint32 MODE_A=1\nstring<=8 name \"x\"\nPart[] parts\nuint8 flag 3\n\
                   ================================================================================\nMSG: my_msgs/Part\nfloat32 x 1.0\nbool[<=4] on\n";
        let idl = "================================================================================\nIDL: my_msgs/msg/Thing\n\
                   #include \"std_msgs/msg/Header.idl\"\nmodule my_msgs { module msg {\n  typedef double double__6[6];\n  module Thing_Constants { const long MODE_A = 1; };\n\
                   @verbatim (language=\"comment\", text=\"a struct { of } words\")\n struct Thing {\n std_msgs::msg::Header header; // first\n\
                   @unit (value=\"N m\") double__6 tau;\n string<8> name;\n sequence<my_msgs::msg::Part> parts;\n @default (value=3) uint8 flag; }; }; };\n\
                   ================================================================================\nIDL: my_msgs/msg/Part\n\
                   module my_msgs { module msg { struct Part { float x; sequence<boolean, 4> on; }; }; };\n";
        let one = Definition::read("my_msgs/msg/Thing", msg).unwrap();
        let other = Definition::read("my_msgs/msg/Thing", idl).unwrap();
        assert_eq!(one, other);
        assert_eq!(names(&one, 0), ["header", "tau", "name", "parts", "flag"]);
        assert_eq!(one.messages[0][1].count, Count::Fixed(6));
        assert_eq!(Definition::read("my_msgs/msg/Thing", "Unknown x\n"), None);
        assert!(
            Definition::read("geometry_msgs/msg/WrenchStamped", "").is_some(),
            "it is well known"
        );
    }
}
