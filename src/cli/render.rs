//! What people and programs see.

use crate::app::{Error, Problem};
use crate::io::DesignDocument;
use std::fmt::Write;

/// To standard error: a problem document with `--json`, else lines for people.
pub fn print_error(error: &Error, json: bool) {
    if json {
        eprintln!(
            "{}",
            serde_json::to_string(&Problem::from(error)).expect("a problem is plain data")
        );
        return;
    }
    eprintln!("error[{}]: {}", error.code.name(), error.detail);
    for problem in &error.errors {
        eprintln!("  {problem}");
    }
    if let Some(hint) = &error.hint {
        eprintln!("hint: {hint}");
    }
}

/// A design in a few lines.
pub fn summary(design: &DesignDocument) -> String {
    let mut text = String::new();
    let search = &design.search;
    let _ = writeln!(text, "{}: {}", design.robot, design.status);
    if let Some(reason) = &design.reason {
        let _ = writeln!(text, "  {reason}");
    }
    if let Some(c) = &design.criteria {
        let _ = writeln!(text, "  condition number  {:.3}", c.condition_number);
        let _ = writeln!(text, "  D-optimality      {:.4e}", c.d_optimality);
        let _ = writeln!(text, "  A-optimality      {:.4e}", c.a_optimality);
        let _ = writeln!(text, "  I-optimality      {:.4e}", c.i_optimality);
    }
    let tightest = design.margins.iter().min_by(|a, b| a.margin.total_cmp(&b.margin));
    if let Some(m) = tightest {
        let percent = 100.0 * m.margin;
        let _ = writeln!(
            text,
            "  tightest limit    {} {} ({}), {percent:.2} % left",
            m.joint, m.quantity, m.side
        );
    }
    let _ = writeln!(
        text,
        "  {} evaluations in {:.1} s, seed {}",
        search.evaluations, search.elapsed_s, search.seed
    );
    for note in &design.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    text
}
