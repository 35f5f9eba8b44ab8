//! What can be said of a formula before it is parsed: its words and signs, and what would be read in two ways.

use super::tree::Function;

/// Characters of an expression. A formula over a line is hard to check.
pub const MOST_CHARACTERS: usize = 300;
/// Parentheses within each other.
pub const MOST_NESTED: usize = 32;

/// A formula that the parser reads in one way: a sign at the beginning or after a parenthesis is a difference from zero, so that
/// `-x^2` is `-(x^2)`.
///
/// # Errors
/// What is wrong, and what to write instead.
pub fn prepared(text: &str) -> Result<String, (String, String)> {
    let tokens = split(text)?;
    check_nesting(&tokens)?;
    let mut plain = String::new();
    let mut at = 0;
    while at < tokens.len() {
        let before = at.checked_sub(1).map(|i| tokens[i]);
        let token = tokens[at];
        check_pair(before, token, tokens.get(at + 1).copied())?;
        match before {
            None | Some("(") if token == "-" => plain += "0-",
            None | Some("(") if token == "+" => {}
            Some("^") if token == "-" => {
                plain += &format!("(0-{})", tokens[at + 1]);
                at += 1;
            }
            _ => plain += token,
        }
        if token == "^" && tokens.get(after_operand(&tokens, at + 1)) == Some(&"^") {
            return Err((
                "has a power of a power without parentheses".into(),
                "write (a^b)^c or a^(b^c)".into(),
            ));
        }
        at += 1;
    }
    match plain.is_empty() {
        true => Err(("is empty".into(), "give a formula, for example k*sin(q2 - q0)".into())),
        false => Ok(plain),
    }
}

/// Names, numbers, operators and parentheses.
fn split(text: &str) -> Result<Vec<&str>, (String, String)> {
    if text.chars().count() > MOST_CHARACTERS {
        return Err((
            format!(
                "has {} characters, the most accepted is {MOST_CHARACTERS}",
                text.chars().count()
            ),
            "split it into several effects".into(),
        ));
    }
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            ' ' | '\t' => {
                rest = &rest[1..];
                continue;
            }
            'a'..='z' | 'A'..='Z' | '_' => rest.find(|c: char| !is_word(c)).unwrap_or(rest.len()),
            '0'..='9' | '.' => number_length(rest),
            '+' | '-' | '*' | '/' | '^' | '(' | ')' => 1,
            other => return Err(unexpected(other)),
        };
        if rest.starts_with("**") {
            return Err(("has `**`".into(), "write powers with ^".into()));
        }
        tokens.push(&rest[..length]);
        rest = &rest[length..];
    }
    Ok(tokens)
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Digits with a point and an exponent: `1`, `.5`, `2.5e-3`.
fn number_length(text: &str) -> usize {
    let digits = |from: usize| from + text[from..].bytes().take_while(u8::is_ascii_digit).count();
    let mut end = digits(0);
    if text[end..].starts_with('.') {
        end = digits(end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        let all = digits(end + 1 + sign);
        if all > end + 1 + sign {
            return all;
        }
    }
    end
}

fn unexpected(c: char) -> (String, String) {
    let hint = match c {
        ',' => "functions take one value; a decimal point is `.`",
        '·' | '×' => "write products with *",
        '−' => "write a minus with -",
        '=' => "give the right-hand side alone: the torque that is added",
        '[' | ']' | '{' | '}' => "use parentheses ( )",
        _ => "use numbers, names, + - * / ^ and parentheses",
    };
    (format!("has the character `{}`", c.escape_default()), hint.into())
}

fn check_nesting(tokens: &[&str]) -> Result<(), (String, String)> {
    let mut depth = 0usize;
    for token in tokens {
        match *token {
            "(" => depth += 1,
            ")" if depth == 0 => return Err(("closes a parenthesis that is not open".into(), "take it away".into())),
            ")" => depth -= 1,
            _ => {}
        }
        if depth > MOST_NESTED {
            let detail = format!("has more than {MOST_NESTED} parentheses within each other");
            return Err((detail, "take away those that are not needed".into()));
        }
    }
    match depth {
        0 => Ok(()),
        _ => Err((
            format!("has {depth} open parentheses at its end"),
            "close every parenthesis".into(),
        )),
    }
}

fn is_operator(token: &str) -> bool {
    matches!(token, "+" | "-" | "*" | "/" | "^")
}

fn is_function(token: &str) -> bool {
    Function::NAMED.iter().any(|(name, _)| *name == token)
}

fn is_name(token: &str) -> bool {
    token.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
}

/// Whether two tokens may stand beside each other.
fn check_pair(before: Option<&str>, token: &str, after: Option<&str>) -> Result<(), (String, String)> {
    let ends = |t: &str| !is_operator(t) && t != "(" && !is_function(t);
    let starts = |t: &str| !is_operator(t) && t != ")";
    let wrong = |detail: String, hint: &str| Err((detail, hint.to_string()));
    if is_function(token) && after != Some("(") {
        return wrong(
            format!("has `{token}` without parentheses"),
            "write the argument in parentheses: sin(q1)",
        );
    }
    if starts(token) && before.is_some_and(|b| is_name(b) && !is_function(b)) && token == "(" {
        let names: Vec<&str> = Function::NAMED.iter().map(|n| n.0).collect();
        return wrong(
            format!("calls `{}`, which is no function", before.unwrap_or_default()),
            &format!("functions are {}; a product needs *", names.join(", ")),
        );
    }
    if starts(token) && before.is_some_and(ends) {
        let detail = format!("has no operator between `{}` and `{token}`", before.unwrap_or_default());
        return wrong(detail, "write products with *");
    }
    let opens = before.is_none_or(|b| is_operator(b) || b == "(");
    let signs_exponent =
        before == Some("^") && token == "-" && after.is_some_and(|a| a.starts_with(|c: char| c.is_ascii_digit()));
    let signs = matches!(token, "+" | "-") && matches!(before, None | Some("("));
    if opens && is_operator(token) && !signs && !signs_exponent {
        let hint = "put a sign after an operator in parentheses: 2*(-q1)";
        return wrong(format!("has `{token}` where a value is expected"), hint);
    }
    if opens && token == ")" {
        return wrong("has `)` where a value is expected".into(), "complete what stands before it");
    }
    match after {
        None if is_operator(token) => wrong(format!("ends with `{token}`"), "complete it"),
        _ => Ok(()),
    }
}

/// The token after the operand that begins at `at`: a number, a name, a group, or a function with its group.
fn after_operand(tokens: &[&str], mut at: usize) -> usize {
    at += usize::from(tokens.get(at) == Some(&"-"));
    at += usize::from(tokens.get(at).is_some_and(|t| is_function(t)));
    let mut depth = 0usize;
    while let Some(token) = tokens.get(at) {
        at += 1;
        match *token {
            "(" => depth += 1,
            ")" => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            break;
        }
    }
    at
}
