//! The kinds of input that once stopped the program or lost a result, each with generated members, on the command line and over
//! HTTP.
//!
//! `tests/data` has one file of every kind; here are their relatives: other depths, cycles, scales, encodings, containers.
//! Whatever the input is, the answer is a result or a refusal in words (exit status 2, 422), in seconds, without a number that is
//! none.

mod containers;
mod documents;
mod motions;
mod robots;
#[path = "../support/server.rs"]
mod server;
mod stamps;
mod torques;
mod uploads;
mod ways;
mod written;

use serde_json::Value;

/// What a member of a class is given to.
pub enum Work {
    /// Robot and what is asked of it.
    Excite,
    Identify,
    /// The robot alone.
    Read,
}

/// One input.
pub struct Case {
    pub name: String,
    pub work: Work,
    pub robot: RobotFile,
    pub request: Value,
    /// File name and content.
    pub logs: Vec<(String, Vec<u8>)>,
    pub expect: Expect,
}

/// A robot as people hand it over.
#[derive(Clone)]
pub enum RobotFile {
    Named(&'static str),
    Json(String),
    Urdf(Vec<u8>),
    Mjcf(String),
}

/// What may come of a case.
pub enum Expect {
    /// Refused, with all of these words.
    Refused(Vec<String>),
    /// A result of which this holds.
    Result(fn(&Value) -> Result<(), String>),
    /// Either: refused with the words, or a result.
    Either(Vec<String>, fn(&Value) -> Result<(), String>),
}

pub fn refused<const N: usize>(words: [&str; N]) -> Expect {
    Expect::Refused(words.map(String::from).to_vec())
}

/// What came of it.
#[derive(Debug)]
pub enum Answer {
    Refused(String),
    Done(Value),
}

impl Case {
    pub fn identify(name: impl Into<String>, log: String, expect: Expect) -> Self {
        Self {
            name: name.into(),
            work: Work::Identify,
            robot: RobotFile::Named("planar_two_link"),
            // Most say nothing about what the model lacks.
            request: serde_json::json!({"feasible": {"method": "none"}, "trace": false}),
            logs: vec![("log.csv".into(), log.into_bytes())],
            expect,
        }
    }

    pub fn read(name: impl Into<String>, robot: RobotFile, expect: Expect) -> Self {
        Self {
            name: name.into(),
            work: Work::Read,
            robot,
            request: serde_json::json!({}),
            logs: Vec::new(),
            expect,
        }
    }

    /// With a diagnosis.
    pub fn traced(self) -> Self {
        self.asking(serde_json::json!({"feasible": {"method": "none"}}))
    }

    /// Whether the input itself has such a word, which the answer may then show.
    fn gives(&self, word: &str) -> bool {
        let word = word.to_lowercase();
        // Recordings in binary have such numbers without such words.
        let of_log = |(name, content): &(String, Vec<u8>)| {
            !name.ends_with(".csv") || String::from_utf8_lossy(content).to_lowercase().contains(&word)
        };
        let of_robot = match &self.robot {
            RobotFile::Json(text) | RobotFile::Mjcf(text) => text.to_lowercase().contains(&word),
            RobotFile::Urdf(bytes) => String::from_utf8_lossy(bytes).to_lowercase().contains(&word),
            RobotFile::Named(_) => false,
        };
        of_robot || self.logs.iter().any(of_log)
    }

    pub fn asking(self, request: Value) -> Self {
        Self { request, ..self }
    }

    fn judge(&self, answer: &Answer) -> Result<(), String> {
        let says = |words: &Vec<String>, said: &String| match words.iter().find(|w| !said.contains(*w)) {
            Some(word) => Err(format!("`{word}` is not said: {said}")),
            None => Ok(()),
        };
        match (answer, &self.expect) {
            (Answer::Refused(said), Expect::Refused(words) | Expect::Either(words, _)) => says(words, said),
            (Answer::Done(document), Expect::Result(holds) | Expect::Either(_, holds)) => holds(document),
            (Answer::Refused(said), Expect::Result(_)) => Err(format!("refused: {said}")),
            (Answer::Done(document), Expect::Refused(_)) => Err(format!(
                "accepted: {}",
                document.to_string().chars().take(600).collect::<String>()
            )),
        }
    }
}

/// Seconds that any of these small inputs may take at most, on a machine that does other things too.
const LONGEST: f64 = 20.0;

/// Tries all cases in both ways, and tells of all that failed.
pub fn try_all(cases: &[Case]) {
    assert!(!cases.is_empty());
    let ways: [&dyn ways::Way; 2] = [&ways::CommandLine::new(), &ways::Http::new()];
    let mut failed = Vec::new();
    for case in cases {
        for way in ways {
            let start = std::time::Instant::now();
            let judged = way.answer(case).and_then(|answer| case.judge(&answer));
            let seconds = start.elapsed().as_secs_f64();
            if let Err(why) = judged {
                failed.push(format!("{} ({}): {why}", case.name, way.name()));
            } else if seconds > LONGEST {
                failed.push(format!("{} ({}): took {seconds:.1} s", case.name, way.name()));
            }
        }
    }
    assert!(failed.is_empty(), "{} failed:\n{}", failed.len(), failed.join("\n"));
}
