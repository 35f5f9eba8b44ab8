//! The part of OMG IDL that ROS 2 writes messages in: modules, structs, sequences, arrays by typedef.

use super::definition::{Count, Field, Kind, Number};
use std::collections::HashMap;

/// Every struct of a text, by its name with modules; what is not understood ends the reading.
pub(super) fn structs(text: &str) -> Vec<(String, Vec<Field>)> {
    let mut reader = Reader {
        tokens: tokens(text),
        at: 0,
        types: HashMap::new(),
        found: Vec::new(),
    };
    let mut modules: Vec<String> = Vec::new();
    while let Some(token) = reader.next() {
        let understood = match token.as_str() {
            "struct" => reader.structure(&modules),
            "typedef" => reader.typedef(),
            "module" => {
                modules.extend(reader.next());
                reader.next().map(|_| ())
            }
            "}" => {
                modules.pop();
                Some(())
            }
            "@" => {
                reader.annotation();
                Some(())
            }
            "const" => {
                reader.skip_to(";");
                Some(())
            }
            _ => Some(()),
        };
        if understood.is_none() {
            break;
        }
    }
    reader.found
}

/// Words and signs, without comments, directives, and what stands in quotes.
fn tokens(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    let lines = text.lines().filter(|l| !l.trim_start().starts_with('#'));
    let text = lines.collect::<Vec<_>>().join("\n");
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        if c.is_alphanumeric() || c == '_' || c == ':' {
            let mut word = c.to_string();
            while let Some(next) = chars.next_if(|n| n.is_alphanumeric() || *n == '_' || *n == ':') {
                word.push(next);
            }
            all.push(word);
        } else if c == '"' {
            let mut escaped = false;
            for inner in chars.by_ref() {
                if inner == '"' && !escaped {
                    break;
                }
                escaped = inner == '\\' && !escaped;
            }
        } else if c == '/' && chars.peek() == Some(&'/') {
            chars.by_ref().find(|n| *n == '\n');
        } else if c == '/' && chars.peek() == Some(&'*') {
            let mut before = ' ';
            for inner in chars.by_ref() {
                if before == '*' && inner == '/' {
                    break;
                }
                before = inner;
            }
        } else if !c.is_whitespace() {
            all.push(c.to_string());
        }
    }
    all
}

struct Reader {
    tokens: Vec<String>,
    at: usize,
    /// What typedefs stand for.
    types: HashMap<String, (Kind, Count)>,
    found: Vec<(String, Vec<Field>)>,
}

impl Reader {
    fn next(&mut self) -> Option<String> {
        let token = self.tokens.get(self.at).cloned();
        self.at += 1;
        token
    }

    fn peek(&self) -> &str {
        self.tokens.get(self.at).map_or("", String::as_str)
    }

    fn skip_to(&mut self, end: &str) {
        while self.next().is_some_and(|t| t != end) {}
    }

    /// `@name` or `@name ( … )`.
    fn annotation(&mut self) {
        self.next();
        if self.peek() == "(" {
            let mut depth = 0;
            while let Some(token) = self.next() {
                depth += i32::from(token == "(") - i32::from(token == ")");
                if depth == 0 {
                    break;
                }
            }
        }
    }

    fn structure(&mut self, modules: &[String]) -> Option<()> {
        let name = self.next()?;
        if self.next()? != "{" {
            return None;
        }
        let mut fields = Vec::new();
        while self.peek() != "}" {
            if self.peek() == "@" {
                self.next();
                self.annotation();
                continue;
            }
            let (kind, count) = self.kind()?;
            let (name, count) = self.named(count)?;
            fields.push(Field { name, kind, count });
        }
        self.next();
        let full: Vec<&str> = modules.iter().map(String::as_str).chain([name.as_str()]).collect();
        self.found.push((full.join("/"), fields));
        Some(())
    }

    fn typedef(&mut self) -> Option<()> {
        let (kind, count) = self.kind()?;
        let (name, count) = self.named(count)?;
        self.types.insert(name, (kind, count));
        Some(())
    }

    /// A name, the size of an array where there is one, and the sign at the end.
    fn named(&mut self, count: Count) -> Option<(String, Count)> {
        let name = self.next()?;
        let mut count = count;
        while self.peek() == "[" {
            self.next();
            let size: usize = self.next()?.parse().ok()?;
            count = match count {
                Count::One => Count::Fixed(size),
                Count::Fixed(inner) => Count::Fixed(inner.checked_mul(size)?),
                Count::Many => return None,
            };
            self.next();
        }
        (self.next()? == ";").then_some((name, count))
    }

    fn kind(&mut self) -> Option<(Kind, Count)> {
        let word = self.next()?;
        let number = |n| Some((Kind::Number(n), Count::One));
        match word.as_str() {
            "sequence" => {
                self.next();
                let (kind, inner) = self.kind()?;
                self.skip_to(">");
                (inner == Count::One).then_some((kind, Count::Many))
            }
            "string" | "wstring" => {
                if self.peek() == "<" {
                    self.skip_to(">");
                }
                let kind = if word == "string" { Kind::Text } else { Kind::WideText };
                Some((kind, Count::One))
            }
            "boolean" => number(Number::Bool),
            "octet" | "char" | "uint8" => number(Number::Uint(1)),
            "int8" => number(Number::Int(1)),
            "short" | "int16" => number(Number::Int(2)),
            "uint16" => number(Number::Uint(2)),
            "int32" => number(Number::Int(4)),
            "uint32" => number(Number::Uint(4)),
            "int64" => number(Number::Int(8)),
            "uint64" => number(Number::Uint(8)),
            "float" => number(Number::Float(4)),
            "double" => number(Number::Float(8)),
            "long" => number(Number::Int(self.long())),
            "unsigned" => {
                let size = if self.next()? == "short" { 2 } else { self.long() };
                number(Number::Uint(size))
            }
            name => Some(
                self.types
                    .get(name.rsplit("::").next()?)
                    .cloned()
                    .unwrap_or_else(|| (Kind::Message(name.to_string()), Count::One)),
            ),
        }
    }

    /// Size of `long`, or of `long long`, whose first word is read.
    fn long(&mut self) -> u8 {
        if self.peek() == "long" {
            self.next();
            return 8;
        }
        4
    }
}
