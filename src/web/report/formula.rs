//! Expressions of base parameters as MathML, which browsers set by themselves.

use super::html::{Cell, escaped};

/// The name of a parameter: `MYR2` with its link below. Anything else as it is.
pub(super) fn name(text: &str) -> Cell {
    Cell(symbol(text).map_or_else(|| escaped(text), |s| format!("<math>{s}</math>")))
}

/// `MY2 + 0.42 (M3 + M4)`: one formula per term, so that lines break between terms.
pub(super) fn expression(text: &str) -> Cell {
    let terms: Option<Vec<String>> = terms(text).iter().map(|term| formula(term)).collect();
    Cell(terms.map_or_else(|| escaped(text), |terms| terms.join(" ")))
}

/// Cut before every sign.
fn terms(text: &str) -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = vec![Vec::new()];
    let spaced = text.replace('(', " ( ").replace(')', " ) ");
    for token in spaced.split_whitespace() {
        // A sign may stand alone or right before the first term.
        let (sign, rest) = match token.strip_prefix('-') {
            Some(rest) => (Some("−"), rest),
            None if token == "+" => (Some("+"), ""),
            None => (None, token),
        };
        if let Some(sign) = sign {
            all.push(vec![sign.to_string()]);
        }
        if !rest.is_empty() {
            all.last_mut().expect("is never empty").push(rest.to_string());
        }
    }
    all.retain(|term| !term.is_empty());
    all
}

/// `None` for what is no expression.
fn formula(term: &[String]) -> Option<String> {
    let one = |token: &String| match token.as_str() {
        "+" | "−" => Some(format!("<mo form=\"infix\">{token}</mo>")),
        "(" | ")" => Some(format!("<mo stretchy=\"false\">{token}</mo>")),
        number if number.parse::<f64>().is_ok() => Some(format!("<mn>{number}</mn><mo>\u{2062}</mo>")),
        other => symbol(other),
    };
    let parts: Option<String> = term.iter().map(one).collect();
    parts.map(|p| format!("<math>{p}</math>"))
}

/// Capitals and a number.
fn symbol(text: &str) -> Option<String> {
    let at = text.find(|c: char| c.is_ascii_digit())?;
    let (letters, index) = text.split_at(at);
    let is_symbol =
        !letters.is_empty() && letters.bytes().all(|b| b.is_ascii_uppercase()) && index.bytes().all(|b| b.is_ascii_digit());
    // Single letters would be slanted twice, by MathML and by the style sheet, which slants names of several letters.
    is_symbol.then(|| format!("<msub><mi mathvariant=\"normal\">{letters}</mi><mn>{index}</mn></msub>"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_keep_every_term() {
        let Cell(math) = expression("-MY2 + 0.42 (M3 + M4) - 1.5e-7 XX10");
        let math = math.replace(" mathvariant=\"normal\"", "");
        assert_eq!(math.matches("<math>").count(), 4);
        for part in [
            "<mo form=\"infix\">−</mo><msub><mi>MY</mi><mn>2</mn></msub>",
            "<mn>0.42</mn>",
            "<mo stretchy=\"false\">(</mo><msub><mi>M</mi><mn>3</mn></msub>",
            "<msub><mi>M</mi><mn>4</mn></msub><mo stretchy=\"false\">)</mo>",
            "<mn>1.5e-7</mn>",
            "<msub><mi>XX</mi><mn>10</mn></msub>",
        ] {
            assert!(math.contains(part), "{part} not in {math}");
        }
        assert!(roxmltree::Document::parse(&format!("<p>{math}</p>")).is_ok());
    }

    #[test]
    fn words_stay_words() {
        assert_eq!(expression("constant torque <x>").0, "constant torque &lt;x&gt;");
        assert_eq!(name("offset A1").0, "offset A1");
    }
}
