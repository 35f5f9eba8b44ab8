//! Motions that are none, logs of few or no rows, positions beyond every arm.

use super::written::{Row, good_rows, lines, log, normal, rng};
use super::{Case, Expect, refused, try_all};
use serde_json::Value;

fn with(change: impl Fn(usize, &mut Row)) -> String {
    let mut rows = good_rows();
    rows.iter_mut().enumerate().for_each(|(s, row)| change(s, row));
    log(rows)
}

#[test]
fn an_arm_that_stands_still_is_said_to() {
    let mut cases = Vec::new();
    for (name, size, at) in [("at zero", 0.0, 0.0), ("elsewhere", 0.0, 1.2), ("encoder noise", 1e-5, -0.4)] {
        let mut random = rng(1);
        let rows = good_rows()
            .into_iter()
            .map(|[t, _, _, x, y]| [t, at + size * normal(&mut random), at - size * normal(&mut random), x, y]);
        cases.push(Case::identify(name, log(rows), refused(["no joint moves"])));
    }
    for joint in 0..2 {
        let text = with(|_, row| row[1 + joint] = 0.3);
        cases.push(Case::identify(
            format!("joint {joint} alone"),
            text,
            Expect::Result(|_| Ok(())),
        ));
    }
    let once = with(|s, row| (row[1], row[2]) = if s < 700 { (0.0, 0.0) } else { (0.5, 0.5) });
    cases.push(Case::identify(
        "one jump",
        once,
        Expect::Either(vec!["log.csv".into()], |_| Ok(())),
    ));
    try_all(&cases);
}

#[test]
fn logs_of_few_rows_or_none_are_refused_in_words() {
    let mut cases = Vec::new();
    for rows in [0, 1, 2, 3, 10, 15] {
        let text = log(good_rows().into_iter().take(rows));
        cases.push(Case::identify(format!("{rows} rows"), text, refused(["log.csv"])));
    }
    for (name, text) in [
        ("nothing", ""),
        ("a line end", "\n"),
        ("blank lines", "\n\n\n   \n"),
        ("a byte order mark", "\u{feff}"),
        ("a header", "time,q1,q2,tau1,tau2"),
        ("remarks", "# one\n# two\n"),
        ("no header", "0,0,0,0,0\n0.01,0,0,0,0\n"),
        ("other columns", "a,b,c\n1,2,3\n4,5,6\n"),
        ("a zero byte", "\0"),
        ("words", "this is no log\nat all\n"),
    ] {
        cases.push(Case::identify(name, text.into(), refused(["log.csv"])));
    }
    for (name, bad) in [
        ("words", "abc"),
        ("nothing", ""),
        ("nan", "nan"),
        ("inf", "inf"),
        ("1e999", "1e999"),
        ("ticks", "0x1f"),
    ] {
        let rows = good_rows()
            .into_iter()
            .map(|[t, _, b, x, y]| format!("{t:?},{bad},{b:?},{x:?},{y:?}"));
        cases.push(Case::identify(format!("all rows {name}"), lines(rows), refused(["line 2"])));
        let rows = good_rows().into_iter().enumerate().map(|(s, [t, a, b, x, y])| match s {
            500 => format!("{t:?},{a:?},{b:?},{x:?},{bad}"),
            _ => format!("{t:?},{a:?},{b:?},{x:?},{y:?}"),
        });
        cases.push(Case::identify(
            format!("one row {name}"),
            lines(rows),
            Expect::Result(drops_one),
        ));
    }
    let long = format!("time,q1,q2,tau1,tau2\n{}\n", "1".repeat(5 << 20));
    cases.push(Case::identify("a long line", long, refused(["log.csv"])));
    let wide = (0..100_000).map(|c| format!("c{c}")).collect::<Vec<_>>().join(",");
    cases.push(Case::identify("many columns", wide, refused(["log.csv"])));
    try_all(&cases);
}

fn drops_one(document: &Value) -> Result<(), String> {
    let report = &document["log_report"][0];
    match report["rows"].as_u64().zip(report["rows_used"].as_u64()) {
        Some((rows, used)) if rows == used + 1 => Ok(()),
        _ => Err(report.to_string()),
    }
}

#[test]
fn positions_beyond_every_arm_are_dropped_or_refused_with_their_line() {
    let mut cases = Vec::new();
    for value in [1e7, -1e20, 1e154, 1.7e308, -1.7e308] {
        for column in 1..5 {
            let size = if column > 2 {
                (value * 1e3f64).clamp(-1.7e308, 1.7e308)
            } else {
                value
            };
            let text = with(|s, row| row[column] = if s == 333 { size } else { row[column] });
            cases.push(Case::identify(
                format!("one {size:e} in column {column}"),
                text,
                Expect::Result(drops_one),
            ));
        }
        let text = with(|s, row| row[2] = if s % 3 == 0 { value } else { row[2] });
        cases.push(Case::identify(
            format!("a third {value:e}"),
            text,
            refused(["line 2", "`q2`", "columns"]),
        ));
    }
    try_all(&cases);
}
