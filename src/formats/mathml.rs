//! Formulas of laws as MathML, which browsers set by themselves.

/// A formula as laws write it (`k*(q1 + r*q3)^2`) as MathML; `None` for what is no such formula.
pub fn mathml(text: &str) -> Option<String> {
    let plain: Vec<char> = text.chars().filter(|c| *c != ' ').collect();
    let mut reader = Reader { text: &plain, at: 0 };
    let sum = reader.sum()?;
    (reader.at == plain.len()).then(|| format!("<math><mrow>{sum}</mrow></math>"))
}

/// Recursive descent over sums, products, powers, and functions of one argument.
struct Reader<'a> {
    text: &'a [char],
    at: usize,
}

fn operator(sign: &str) -> String {
    format!("<mo>{sign}</mo>")
}

fn fenced(inner: &str, [open, close]: [&str; 2]) -> String {
    format!("<mrow><mo stretchy=\"false\">{open}</mo>{inner}<mo stretchy=\"false\">{close}</mo></mrow>")
}

/// What `fenced` puts around a parenthesis.
const PARENTHESIS: [&str; 2] = ["<mrow><mo stretchy=\"false\">(</mo>", "<mo stretchy=\"false\">)</mo></mrow>"];

/// Whether a factor is a function with a name.
fn is_function(factor: &str) -> bool {
    factor
        .split_once("</mi>")
        .is_some_and(|(name, rest)| name.starts_with("<mi>") && rest.starts_with(APPLIED))
}

/// Between a function and what it is applied to.
const APPLIED: &str = "<mo>\u{2061}</mo>";

/// A parenthesis without its signs: above and below a bar they say nothing.
fn opened(text: &str) -> &str {
    let [open, close] = PARENTHESIS;
    text.strip_prefix(open).and_then(|t| t.strip_suffix(close)).unwrap_or(text)
}

impl Reader<'_> {
    fn next(&self) -> Option<char> {
        self.text.get(self.at).copied()
    }

    fn takes(&mut self, c: char) -> bool {
        let yes = self.next() == Some(c);
        self.at += usize::from(yes);
        yes
    }

    fn sum(&mut self) -> Option<String> {
        let mut sum = if self.takes('-') { operator("−") } else { String::new() };
        sum += &self.product()?;
        loop {
            let sign = if self.takes('+') {
                "+"
            } else if self.takes('-') {
                "−"
            } else {
                return Some(sum);
            };
            sum += &operator(sign);
            sum += &self.product()?;
        }
    }

    /// Factors side by side; what stands before a bar is the numerator.
    fn product(&mut self) -> Option<String> {
        let mut product = self.power()?;
        let mut factors = 1;
        loop {
            if self.takes('*') {
                product += &operator("\u{2062}");
                let factor = self.power()?;
                // Without a space `a sin q` is read as `asin q`.
                product += if is_function(&factor) {
                    "<mspace width=\"0.17em\"/>"
                } else {
                    ""
                };
                product += &factor;
                factors += 1;
            } else if self.takes('/') {
                let above = if factors == 1 { opened(&product) } else { &product };
                let below = self.power()?;
                product = format!("<mfrac><mrow>{above}</mrow><mrow>{}</mrow></mfrac>", opened(&below));
            } else {
                return Some(product);
            }
        }
    }

    fn power(&mut self) -> Option<String> {
        if self.takes('-') {
            return Some(operator("−") + &self.power()?);
        }
        let base = match self.takes('(') {
            true => fenced(&self.closed()?, ["(", ")"]),
            false => self.word()?,
        };
        match self.takes('^') {
            true if self.takes('(') => Some(format!("<msup>{base}<mrow>{}</mrow></msup>", self.closed()?)),
            true => Some(format!("<msup>{base}{}</msup>", self.word()?)),
            false => Some(base),
        }
    }

    /// What stands before a closing parenthesis.
    fn closed(&mut self) -> Option<String> {
        let inner = self.sum()?;
        self.takes(')').then_some(inner)
    }

    fn word(&mut self) -> Option<String> {
        let from = self.at;
        while self.next().is_some_and(|c| c.is_ascii_alphanumeric() || c == '.' || c == '_') {
            self.at += 1;
        }
        let word: String = self.text[from..self.at].iter().collect();
        if word.is_empty() {
            return None;
        }
        if word.parse::<f64>().is_ok() {
            return Some(format!("<mn>{word}</mn>"));
        }
        if !self.takes('(') {
            return Some(symbol(&word));
        }
        let inner = self.closed()?;
        Some(match word.as_str() {
            "sqrt" => format!("<msqrt>{inner}</msqrt>"),
            "abs" => fenced(&inner, ["|", "|"]),
            name => format!("<mi>{name}</mi>{APPLIED}{}", fenced(&inner, ["(", ")"])),
        })
    }
}

/// `q4` with its number below, `qd4` with a dot, `q_A2` with the joint below, Greek letters by their names.
fn symbol(name: &str) -> String {
    if let Some((head @ ("q" | "qd" | "qdd"), joint)) = name.split_once('_') {
        return format!("<msub>{}<mtext>{joint}</mtext></msub>", symbol(head));
    }
    let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = &name[letters.len()..];
    let letter = match letters {
        "phi" => "<mi>φ</mi>".to_string(),
        "rho" => "<mi>ρ</mi>".to_string(),
        "qd" => "<mover><mi>q</mi><mo>˙</mo></mover>".to_string(),
        "qdd" => "<mover><mi>q</mi><mo>¨</mo></mover>".to_string(),
        "pi" => "<mi>π</mi>".to_string(),
        other => format!("<mi>{other}</mi>"),
    };
    match number {
        "" => letter,
        number => format!("<msub>{letter}<mn>{number}</mn></msub>"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_of_laws_are_set() {
        let set = mathml("a*sin(2*q4 + phi)*sign(qd12)").unwrap();
        for part in [
            "<msub><mi>q</mi><mn>4</mn></msub>",
            "<mi>φ</mi>",
            "<msub><mover><mi>q</mi><mo>˙</mo></mover><mn>12</mn></msub>",
            "<mi>sign</mi>",
        ] {
            assert!(set.contains(part), "{part} not in {set}");
        }
        let spring = mathml("0.5*k*(q1 + r*q3 - c)^2").unwrap();
        assert!(spring.contains("<msup><mrow>") && spring.contains("<mn>0.5</mn>"), "{spring}");
        assert!(
            mathml("k*abs(qdd1)^(-s_1)")
                .unwrap()
                .contains("<mrow><mo>−</mo><msub><mi>s_</mi>")
        );
        assert!(
            mathml("k*q_A2 + d*qd")
                .unwrap()
                .contains("<msub><mi>q</mi><mtext>A2</mtext></msub>")
        );
        let hose = mathml("a*tanh((q1 + r*q3)/c)*(a + b)/(2)").unwrap();
        assert!(hose.contains("<mspace width=\"0.17em\"/><mi>tanh</mi>"), "{hose}");
        assert_eq!(hose.matches("<mo stretchy=\"false\">").count(), 4, "{hose}");
        assert!(mathml("b*sin(u)/sqrt(1 - rho*cos(u))").unwrap().contains("<msqrt>"));
        for text in [set, spring] {
            assert!(roxmltree::Document::parse(&text).is_ok(), "{text}");
        }
    }

    #[test]
    fn what_is_no_formula_is_none() {
        for text in ["", "a*", "(q1", "q1)", "<b>", "a b("] {
            assert_eq!(mathml(text), None, "{text}");
        }
    }
}
