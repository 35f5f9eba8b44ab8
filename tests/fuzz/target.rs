//! What mutated inputs are given to: commands of the program as users call them, and the use cases that only HTTP has.

use super::bases;
use dynident::app::{CancelFlag, Error, LogFile, ModelFiles, inspect, motion};
use dynident::cli::run_with;
use dynident::documents::shipped::Shipped;
use dynident::documents::{NoExcitations, read_identify_request, read_motion_request, read_validate_request};
use dynident::formats::{ModelFormat, Parsed, parse, robot_file};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Target {
    BaseParameters,
    Inspect,
    Identify,
    Validate,
    Excite,
    Simulate,
    Motion,
    Settings,
    /// Exports of a stored model, also into a URDF file of one's own.
    Model,
    /// Panics, aborts and endless loops on demand: shows that they are seen.
    Itself,
}

impl Target {
    /// Those that stand for the program.
    pub const ALL: [Target; 9] = [
        Target::BaseParameters,
        Target::Inspect,
        Target::Identify,
        Target::Validate,
        Target::Excite,
        Target::Simulate,
        Target::Motion,
        Target::Settings,
        Target::Model,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Target::BaseParameters => "base_parameters",
            Target::Inspect => "inspect",
            Target::Identify => "identify",
            Target::Validate => "validate",
            Target::Excite => "excite",
            Target::Simulate => "simulate",
            Target::Motion => "motion",
            Target::Settings => "settings",
            Target::Model => "model",
            Target::Itself => "itself",
        }
    }

    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().chain([Target::Itself]).find(|t| t.name() == name)
    }
}

/// How the program took an input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Taken {
    Accepted,
    /// With these words.
    Refused(String),
}

/// Where the parts of an input are, and where results go.
pub struct Folders {
    pub input: PathBuf,
    pub output: PathBuf,
}

impl Folders {
    fn part(&self, name: &str) -> Option<String> {
        let path = self.input.join(name);
        path.exists().then(|| path.display().to_string())
    }

    fn result(&self, name: &str) -> String {
        self.output.join(name).display().to_string()
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.input.join(name)).unwrap_or_else(|_| b"{}".to_vec())
    }
}

/// Runs one input through; an error is what users must never see: one of the program's own, or a result that it cannot read
/// again.
pub fn run(target: Target, folders: &Folders) -> Result<Taken, String> {
    match target {
        Target::Inspect => taken(look(folders)),
        Target::Motion => taken(move_robot(folders)),
        Target::Itself => itself(&folders.read("what")),
        _ => {
            let ended = command(&arguments(target, folders))?;
            if target != Target::Identify {
                return Ok(ended);
            }
            read_again(folders)?;
            // There is a result, if no model of bodies.
            Ok(if folders.output.join("result.json").exists() {
                Taken::Accepted
            } else {
                ended
            })
        }
    }
}

fn command(arguments: &[String]) -> Result<Taken, String> {
    match run_with(std::iter::once("dynident").chain(arguments.iter().map(String::as_str))) {
        Ok(0 | 3 | 4) => Ok(Taken::Accepted),
        Ok(2) => Ok(Taken::Refused("usage".into())),
        Ok(status) => Err(format!("internal: exit status {status}")),
        Err(error) => taken(Err(error)),
    }
}

fn taken(result: Result<(), Error>) -> Result<Taken, String> {
    match result {
        Ok(()) => Ok(Taken::Accepted),
        Err(error) if error.code.exit_status() == 2 => Ok(Taken::Refused(words_of(&error))),
        Err(error) => Err(format!("internal: {error}")),
    }
}

fn words_of(error: &Error) -> String {
    let fields: Vec<String> = error.errors.iter().map(ToString::to_string).collect();
    format!("{}; {}", error.detail, fields.join("; "))
}

/// The command line for the parts that are there.
fn arguments(target: Target, folders: &Folders) -> Vec<String> {
    let mut all = vec![target.name().replace('_', "-")];
    let mut give = |flag: &str, value: Option<String>| {
        if let Some(value) = value {
            all.extend([flag.to_string(), value]);
        }
    };
    let request = folders.part(bases::REQUEST);
    match target {
        Target::BaseParameters => give("--robot", folders.part(bases::ROBOT)),
        Target::Settings => {
            all = vec![
                "config".into(),
                "--config".into(),
                folders.part(bases::SETTINGS).unwrap_or_default(),
            ];
            return all;
        }
        Target::Model => {
            // Standing first, and alone where nothing else is known of it.
            all.extend(folders.part(bases::MODEL));
            all.extend(["urdf", "xml", "sdf", "csv", "c", "py"].iter().flat_map(|ending| {
                let file = folders.result(&format!("model.{ending}"));
                ["--out".to_string(), file]
            }));
            all.extend(
                folders
                    .part(bases::OWN_URDF)
                    .into_iter()
                    .flat_map(|own| ["--patch-urdf".to_string(), own]),
            );
        }
        Target::Validate => {
            give("--model", folders.part(bases::MODEL));
            give("--request", request);
            give("--log", folders.part(bases::LOG));
            give("--out", Some(folders.result("result.json")));
        }
        Target::Identify => {
            give("--robot", folders.part(bases::ROBOT));
            give("--request", request);
            give("--log", folders.part(bases::LOG));
            give("--validation", folders.part(bases::VALIDATION));
            give("--effects", folders.part(bases::EFFECTS));
            for (flag, file) in [
                ("--out", "result.json"),
                ("--model", "model.json"),
                ("--urdf", "model.urdf"),
                ("--report", "report.html"),
                ("--plots", "plots"),
            ] {
                give(flag, Some(folders.result(file)));
            }
        }
        Target::Excite => {
            give("--robot", folders.part(bases::ROBOT));
            give("--request", request);
            give("--model", folders.part(bases::MODEL));
            give("--given", folders.part(bases::GIVEN));
            for (flag, file) in [
                ("--out", "design.json"),
                ("--trajectory", "motion.csv"),
                ("--plot", "motion.svg"),
            ] {
                give(flag, Some(folders.result(file)));
            }
        }
        _ => {
            give("--robot", folders.part(bases::ROBOT));
            give("--request", request);
            give("--out", Some(folders.result("log.csv")));
        }
    }
    let extra = std::fs::read_to_string(folders.input.join("arguments")).unwrap_or_default();
    all.extend(extra.lines().map(str::to_string));
    all
}

/// The request with the robot of its own file in it, as the command line puts it there.
fn with_robot(folders: &Folders) -> Result<Parsed, Error> {
    let mut request = parse(&folders.read(bases::REQUEST))?;
    if folders.part(bases::ROBOT).is_some()
        && let Some(fields) = request.value.as_object_mut()
    {
        let robot = robot_file(&folders.read(bases::ROBOT))?;
        fields.insert("robot".into(), robot.value);
        request.problems.extend(robot.problems);
    }
    Ok(request)
}

/// `POST /identify/preview`.
fn look(folders: &Folders) -> Result<(), Error> {
    let request =
        read_identify_request(&with_robot(folders)?, &Shipped, &NoExcitations).map_err(|e| Error::invalid("the request", e))?;
    let logs = |name: &str| {
        folders
            .part(name)
            .map(|path| LogFile::at(Path::new(&path)))
            .into_iter()
            .collect::<Vec<_>>()
    };
    let seen = inspect(&request, &logs(bases::LOG), &logs(bases::VALIDATION), &CancelFlag::default())?;
    keep(folders, &json!(seen));
    Ok(())
}

/// `POST /motion`.
fn move_robot(folders: &Folders) -> Result<(), Error> {
    let request = read_motion_request(&with_robot(folders)?, &Shipped).map_err(|e| Error::invalid("the request", e))?;
    keep(folders, &json!(motion(&request, &CancelFlag::default())));
    Ok(())
}

fn keep(folders: &Folders, document: &Value) {
    std::fs::write(folders.output.join("result.json"), document.to_string()).expect("temporary files can be written");
}

/// Models that an identification wrote are read by what comes next.
fn read_again(folders: &Folders) -> Result<(), String> {
    let unreadable = |what: &str, detail: String| format!("unreadable: the {what} model is refused: {detail}");
    let json = std::fs::read(folders.output.join("model.json"));
    if let Ok(bytes) = json {
        let model = parse(&bytes).map_err(|e| unreadable("JSON", e.to_string()))?;
        let request = Parsed {
            value: json!({"model": model.value}),
            problems: Vec::new(),
        };
        let read = read_validate_request(&request, &Shipped, &NoExcitations);
        read.map_err(|e| unreadable("JSON", e.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")))?;
        let files = ModelFiles::of_json(request.value["model"].clone()).map_err(|e| unreadable("JSON", e.to_string()))?;
        for (name, format) in ModelFormat::ALL {
            if files.text(format).is_empty() {
                return Err(unreadable(name, "it is empty".into()));
            }
        }
        let own = files.text(ModelFormat::Urdf);
        // Refused where gravity along another axis stands in a joint of its own there; it only must not fail.
        let _ = files.patched(&own, None, None);
    }
    let urdf = folders.output.join("model.urdf");
    if urdf.exists() {
        let arguments = ["base-parameters", "--robot", &urdf.display().to_string()].map(str::to_string);
        if let Taken::Refused(words) = command(&arguments)? {
            return Err(unreadable("URDF", words));
        }
    }
    Ok(())
}

fn itself(what: &[u8]) -> Result<Taken, String> {
    match what {
        b"panic" => panic!("as asked"),
        b"abort" => std::process::abort(),
        b"endless" => loop {
            std::hint::spin_loop();
        },
        b"deep" => Ok(Taken::Refused(deep(1).to_string())),
        b"memory" => {
            // Written to, or the system never hands it out.
            let all = std::hint::black_box(vec![1u8; 400 << 20]);
            Ok(Taken::Refused(all[all.len() / 2].to_string()))
        }
        b"internal" => Err("internal: as asked".into()),
        _ => Ok(Taken::Accepted),
    }
}

/// Ends when the stack does.
fn deep(depth: u64) -> u64 {
    if depth == u64::MAX {
        return 0;
    }
    let here = std::hint::black_box([depth; 64]);
    1 + std::hint::black_box(deep(here[0] + 1)) + here[63]
}
