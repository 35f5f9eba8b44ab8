//! Names of columns: units within them, and the names that well-known programs give to the quantities of joints.
//!
//! Names are compared by their last component, without separators and in lower case: `actual_q_0`, `field.position0`,
//! `/joint_states/panda_joint1/position`, `axisQMsr_LBR_iiwa_1` and `q[3]` each name a quantity and a joint. Commanded, desired
//! and target values are never taken: they say nothing of the robot.

use super::columns::{Quantity, TimeUnit};

/// A column, and what its name says of its unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Named {
    /// As the file has it.
    pub name: String,
    /// Without its unit.
    pub stem: String,
    pub unit: Option<String>,
    /// Columns of one stream have their rows in common; a table is one stream.
    pub stream: usize,
    /// Whether the column is of something that is not known to be about joints: where others have a quantity, it is not looked
    /// for here.
    pub is_other: bool,
}

impl Named {
    /// Takes the unit from the name: `q1 [rad]`, `tau1 (Nm)`, `time_ms`.
    pub fn new(name: &str, stream: usize) -> Self {
        let (stem, unit) = split_unit(name);
        Self {
            name: name.to_string(),
            stem: stem.to_string(),
            unit: unit.map(str::to_string),
            stream,
            is_other: false,
        }
    }

    /// A name that is no text of a person: it has no unit.
    #[cfg_attr(not(feature = "formats"), allow(dead_code))]
    pub fn plain(name: String, stream: usize) -> Self {
        Self {
            stem: name.clone(),
            name,
            unit: None,
            stream,
            is_other: false,
        }
    }

    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.stem == name
    }
}

/// Units at the end of a name without brackets; single letters are more often names of joints.
const SUFFIXES: &[&str] = &[
    "deg", "rad", "rev", "deg/s", "rad/s", "rpm", "nm", "mnm", "knm", "ms", "us", "ns", "sec", "mm",
];

fn split_unit(name: &str) -> (&str, Option<&str>) {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}')] {
        if let Some(inner) = name.strip_suffix(close)
            && let Some(at) = inner.rfind(open)
        {
            let (stem, unit) = (inner[..at].trim_end_matches([' ', '_', '/']), inner[at + 1..].trim());
            // `q[3]` is a number, `position[A1]` a joint.
            if !stem.is_empty() && is_unit(unit) {
                return (stem, Some(unit));
            }
        }
    }
    if let Some((stem, unit)) = name.rsplit_once(['_', ' '])
        && SUFFIXES.contains(&unit.to_ascii_lowercase().as_str())
        && !stem.is_empty()
    {
        return (stem.trim_end_matches([' ', '_', '/']), Some(unit));
    }
    (name, None)
}

/// Whether a text in brackets is meant as a unit: one that is known, or a word without digits that is no plain name.
fn is_unit(text: &str) -> bool {
    factor(text).is_some() || time_unit(text).is_some() || ["%", "°C", "degC", "ticks", "counts", "inc"].contains(&text)
}

/// A unit without its decorations: `N·m`, `N*m`, `N m` and `Nm` are one.
fn plain(unit: &str) -> String {
    unit.chars()
        .filter(|c| !matches!(c, ' ' | '·' | '*' | '.' | '⋅' | '-'))
        .collect::<String>()
        .replace("^1", "")
        .replace(['µ', 'μ'], "u")
}

/// What a unit is times SI, and the quantity that it is a unit of; `A` is a torque as soon as a scale stands beside it.
pub(super) fn factor(unit: &str) -> Option<(Quantity, f64)> {
    use Quantity::{Position, Torque, Velocity};
    use std::f64::consts::PI;
    Some(match plain(unit).as_str() {
        "rad" | "Rad" | "RAD" | "radian" | "radians" | "m" => (Position, 1.0),
        "deg" | "Deg" | "DEG" | "degree" | "degrees" | "°" | "Grad" => (Position, PI / 180.0),
        "rev" | "turns" => (Position, 2.0 * PI),
        "mm" => (Position, 1e-3),
        "rad/s" | "rad/sec" | "rads1" | "m/s" => (Velocity, 1.0),
        "deg/s" | "deg/sec" | "°/s" | "degs1" => (Velocity, PI / 180.0),
        "rpm" | "1/min" => (Velocity, PI / 30.0),
        "mm/s" => (Velocity, 1e-3),
        "Nm" | "nm" | "NM" | "N" => (Torque, 1.0),
        "mNm" | "mnm" => (Torque, 1e-3),
        "kNm" | "knm" | "kN" => (Torque, 1e3),
        "A" | "amp" | "ampere" => (Torque, 1.0),
        "mA" => (Torque, 1e-3),
        _ => return None,
    })
}

/// Whether a unit is one of currents.
pub(super) fn is_current(unit: &str) -> bool {
    matches!(plain(unit).as_str(), "A" | "mA" | "amp" | "ampere")
}

pub(super) fn time_unit(unit: &str) -> Option<TimeUnit> {
    Some(match plain(unit).as_str() {
        "s" | "sec" | "secs" | "second" | "seconds" | "S" => TimeUnit::Seconds,
        "ms" | "msec" | "milliseconds" => TimeUnit::Milliseconds,
        "us" | "usec" | "microseconds" => TimeUnit::Microseconds,
        "ns" | "nsec" | "nanoseconds" => TimeUnit::Nanoseconds,
        _ => return None,
    })
}

/// Names of measured quantities, most telling first. One with `*` at its end may be followed by the name of a robot.
const POSITIONS: &[&str] = &[
    "actualq",
    "axisqmsr*",
    "measuredjointposition",
    "measuredjointpositions",
    "msrjntpos",
    "actualjointposition",
    "actualjointpositions",
    "actualposition",
    "actualpositions",
    "measuredposition",
    "measuredpositions",
    "qmeasured",
    "measuredq",
    "qmsr",
    "qmeas",
    "qactual",
    "qact",
    "q",
    "jointposition",
    "jointpositions",
    "jointpos",
    "jntpos",
    "position",
    "positions",
    "pos",
    "jointangle",
    "jointangles",
    "angle",
    "angles",
];
const VELOCITIES: &[&str] = &[
    "actualqd",
    "axisqdmsr*",
    "measuredjointvelocity",
    "measuredjointvelocities",
    "msrjntvel",
    "actualjointvelocity",
    "actualjointvelocities",
    "actualvelocity",
    "actualvelocities",
    "measuredvelocity",
    "measuredvelocities",
    "qdmeasured",
    "measuredqd",
    "qdmsr",
    "qdmeas",
    "dqmeas",
    "qdactual",
    "qd",
    "dq",
    "qdot",
    "jointvelocity",
    "jointvelocities",
    "jointvel",
    "jntvel",
    "velocity",
    "velocities",
    "vel",
    "jointspeed",
    "jointspeeds",
];
const TORQUES: &[&str] = &[
    "actualcurrentastorque",
    "axistaumsr*",
    "measuredjointtorque",
    "measuredjointtorques",
    "msrjnttrq",
    "measuredtorque",
    "measuredtorques",
    "actualjointtorque",
    "actualjointtorques",
    "actualtorque",
    "actualtorques",
    "tauj",
    "taumeasured",
    "measuredtau",
    "taumsr",
    "taumeas",
    "tauactual",
    "tau",
    "jointtorque",
    "jointtorques",
    "jnttrq",
    "torque",
    "torques",
    "trq",
    "jointeffort",
    "jointefforts",
    "actualeffort",
    "effort",
    "efforts",
];
const CURRENTS: &[&str] = &[
    "actualcurrent",
    "actualcurrents",
    "measuredcurrent",
    "measuredcurrents",
    "motorcurrent",
    "motorcurrents",
    "jointcurrent",
    "jointcurrents",
    "current",
    "currents",
];
/// Names of time, beside those with a unit behind them.
const TIMES: &[&str] = &[
    "time",
    "t",
    "timestamp",
    "stamp",
    "times",
    "seconds",
    "sec",
    "secs",
    "zeit",
    "clock",
    "rosbagtimestamp",
    "headerstamp",
    "fieldheaderstamp",
    "elapsed",
    "elapsedtime",
    "tout",
    "controltime",
    "logtime",
];

/// Lower case, and without what separates words.
fn squeezed(name: &str) -> String {
    name.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// The column of every joint for `quantity`, by the names of known programs: all of them from one group of names, or nothing.
/// Currents stand for torques where `currents` says that they are converted.
pub(super) fn known(names: &[Named], quantity: Quantity, joints: &[String], currents: bool) -> Option<Vec<usize>> {
    let words = match quantity {
        Quantity::Position => POSITIONS,
        Quantity::Velocity => VELOCITIES,
        Quantity::Torque if currents => CURRENTS,
        Quantity::Torque => TORQUES,
    };
    let find = |others: bool| {
        words.iter().find_map(|word| {
            let members: Vec<(usize, Member)> = names
                .iter()
                .enumerate()
                .filter(|(_, name)| name.is_other == others)
                .filter_map(|(at, name)| Some((at, Member::from_name(&name.stem, joints)?)))
                .filter(|(_, member)| member.is_of(word))
                .collect();
            let mut groups: Vec<(usize, &str)> = members.iter().map(|(at, m)| (names[*at].stream, m.prefix.as_str())).collect();
            groups.sort_unstable();
            groups.dedup();
            let whole = |(stream, prefix): &(usize, &str)| {
                let group: Vec<(usize, &Member)> = members
                    .iter()
                    .filter(|(at, m)| names[*at].stream == *stream && m.prefix == *prefix)
                    .map(|(at, m)| (*at, m))
                    .collect();
                complete(&group, joints.len())
            };
            let found: Vec<Vec<usize>> = groups.iter().filter_map(whole).collect();
            match found.as_slice() {
                [one] => Some(one.clone()),
                // Of several recordings of one quantity none can be chosen.
                _ => None,
            }
        })
    };
    find(false).or_else(|| find(true))
}

/// One column per joint: by name, or by numbers from one or from zero.
fn complete(group: &[(usize, &Member)], count: usize) -> Option<Vec<usize>> {
    let of = |wanted: Index| {
        let mut all = group.iter().filter(|(_, m)| m.index == wanted);
        let first = all.next()?;
        all.next().is_none().then_some(first.0)
    };
    let all = |index: &dyn Fn(usize) -> Index| (0..count).map(|j| of(index(j))).collect::<Option<Vec<usize>>>();
    all(&Index::Joint)
        .or_else(|| all(&Index::Number))
        .or_else(|| all(&|j| Index::Number(j + 1)))
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Index {
    Joint(usize),
    Number(usize),
}

/// What a name says: where it belongs, which quantity it is, and of which joint.
#[derive(Debug, Clone, PartialEq)]
struct Member {
    prefix: String,
    key: String,
    index: Index,
}

impl Member {
    fn from_name(name: &str, joints: &[String]) -> Option<Self> {
        let (rest, index) = joint_within(name, joints).or_else(|| number_within(name))?;
        let rest = rest.trim_matches(|c: char| matches!(c, '/' | '.' | '_' | ' ' | '[' | ']' | '(' | ')' | ':' | '-'));
        let (prefix, key) = rest.rsplit_once(['/', '.', ':']).unwrap_or(("", rest));
        // `q_d` is what libfranka desires, not the velocity `qd`.
        if key.to_ascii_lowercase().ends_with("_d") {
            return None;
        }
        Some(Self {
            prefix: squeezed(prefix),
            key: squeezed(key),
            index,
        })
    }

    fn is_of(&self, word: &str) -> bool {
        match word.strip_suffix('*') {
            Some(start) => self.key.starts_with(start),
            None => self.key == word,
        }
    }
}

/// The name without the longest name of a joint that stands in it by itself.
fn joint_within(name: &str, joints: &[String]) -> Option<(String, Index)> {
    let (at, joint, j) = joints
        .iter()
        .enumerate()
        .filter(|(_, joint)| !joint.is_empty())
        .filter_map(|(j, joint)| Some((alone(name, joint)?, joint, j)))
        .max_by_key(|(_, joint, _)| joint.len())?;
    let rest = format!("{} {}", &name[..at], &name[at + joint.len()..]);
    // `/joint_states/A1/position` and `/joint_states/position/A1` say the same.
    Some((
        rest.replace("/ /", "/").replace(". .", ".").trim_end_matches(' ').to_string(),
        Index::Joint(j),
    ))
}

fn alone(name: &str, joint: &str) -> Option<usize> {
    let is_edge = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric());
    name.match_indices(joint)
        .map(|(at, _)| at)
        .filter(|&at| is_edge(name[..at].chars().next_back()) && is_edge(name[at + joint.len()..].chars().next()))
        .last()
}

/// The name without the number that counts joints: `joint3` anywhere, else the last number.
fn number_within(name: &str) -> Option<(String, Index)> {
    let lower = name.to_ascii_lowercase();
    let spelled = ["joint_", "joint", "axis_", "axis", "j", "a"].iter().find_map(|word| {
        lower.match_indices(word).find_map(|(at, _)| {
            let from = at + word.len();
            let digits = digits(&lower[from..]);
            let by_itself = lower[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric());
            let ends = lower[from + digits..].chars().next().is_none_or(|c| !c.is_alphanumeric());
            // `joint_1` alone says no quantity, `q_joint_1` does.
            (digits > 0 && by_itself && ends).then_some((at, from, from + digits))
        })
    });
    let (start, from, to) = match spelled {
        Some(found) => found,
        None => {
            let end = lower.trim_end_matches([']', ')', ' ']).len();
            let from = lower[..end].trim_end_matches(|c: char| c.is_ascii_digit()).len();
            (from, from, end)
        }
    };
    let number = lower[from..to].parse().ok()?;
    Some((
        format!("{} {}", &name[..start], &name[to..]).trim().to_string(),
        Index::Number(number),
    ))
}

fn digits(text: &str) -> usize {
    text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len()
}

/// Columns of time by their names: whole seconds and the nanoseconds beside them, or one column.
pub(super) fn known_time(names: &[Named], stream: usize) -> Option<(usize, Option<usize>)> {
    let within = |n: &Named| n.stream == stream;
    let keys: Vec<String> = names
        .iter()
        .map(|n| if within(n) { squeezed(&n.name) } else { String::new() })
        .collect();
    let nanoseconds = |key: &str| {
        ["nanosec", "nanosecs", "nanoseconds", "nsec", "nsecs"]
            .iter()
            .find_map(|end| {
                let start = key.strip_suffix(end)?;
                let whole = |k: &String| ["sec", "secs", "seconds"].iter().any(|s| k.strip_suffix(s) == Some(start));
                keys.iter().position(whole)
            })
    };
    if let Some((at, whole)) = keys.iter().enumerate().find_map(|(at, key)| Some((at, nanoseconds(key)?))) {
        return Some((whole, Some(at)));
    }
    let at = |word: &str| {
        let is = |text: &str| squeezed(text) == word;
        let last = |n: &Named| n.stem.rsplit('/').next().is_some_and(is);
        names
            .iter()
            .position(|n| within(n) && (is(&n.stem) || is(&n.name) || last(n)))
    };
    TIMES.iter().find_map(|word| at(word)).map(|at| (at, None))
}

/// Whether columns of currents stand where torques are looked for.
pub(super) fn has_currents(names: &[Named], joints: &[String]) -> Option<Vec<usize>> {
    known(names, Quantity::Torque, joints, true)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn named(names: &[String]) -> Vec<Named> {
        names.iter().map(|n| Named::new(n, 0)).collect()
    }

    fn per_joint(pattern: &str, from: usize, joints: &[String]) -> Vec<String> {
        (0..joints.len())
            .map(|j| pattern.replace("{n}", &(from + j).to_string()).replace("{joint}", &joints[j]))
            .collect()
    }

    #[test]
    fn names_of_known_programs_are_found_in_the_order_of_the_joints() {
        let joints: Vec<String> = (1..=6).map(|j| format!("panda_joint{j}")).collect();
        for (position, torque, from) in [
            ("actual_q_{n}", "actual_current_as_torque_{n}", 0),
            ("q[{n}]", "tau_J[{n}]", 0),
            ("axisQMsr_LBR_iiwa_14_R820_{n}", "axisTauMsr_LBR_iiwa_14_R820_{n}", 1),
            ("measuredJointPosition{n}", "measuredTorque{n}", 0),
            ("field.position{n}", "field.effort{n}", 0),
            ("/joint_states/{joint}/position", "/joint_states/{joint}/effort", 0),
            ("/joint_states/position/{joint}", "/joint_states/effort/{joint}", 0),
            ("position[{joint}]", "effort[{joint}]", 0),
            ("joint_{n}_pos", "joint_{n}_torque", 1),
            ("q {n} [rad]", "tau {n} [N m]", 1),
            ("log.q{n}", "log.tau{n}", 1),
        ] {
            // What was commanded stands beside, and the columns come in any order.
            let mut names: Vec<String> = per_joint(torque, from, &joints);
            names.extend(per_joint("target_q_{n}", 0, &joints));
            names.extend(per_joint(position, from, &joints).into_iter().rev());
            let names = named(&names);
            let found = known(&names, Quantity::Position, &joints, false);
            let expected: Vec<usize> = (12..18).rev().collect();
            assert_eq!(found, Some(expected), "{position}");
            assert_eq!(
                known(&names, Quantity::Torque, &joints, false),
                Some((0..6).collect()),
                "{torque}"
            );
            assert_eq!(known(&names, Quantity::Velocity, &joints, false), None);
        }
    }

    #[test]
    fn two_recordings_of_one_quantity_are_not_chosen_from() {
        let joints = vec!["a".to_string(), "b".to_string()];
        let names = [
            "/left/a/position",
            "/left/b/position",
            "/right/a/position",
            "/right/b/position",
        ]
        .map(String::from);
        assert_eq!(known(&named(&names), Quantity::Position, &joints, false), None);
        assert_eq!(
            known(&named(&names[..2]), Quantity::Position, &joints, false),
            Some(vec![0, 1])
        );
    }

    #[test]
    fn units_are_taken_from_names_and_indices_are_not() {
        for (name, stem, unit) in [
            ("q1 [rad]", "q1", Some("rad")),
            ("tau1 (N·m)", "tau1", Some("N·m")),
            ("time_ms", "time", Some("ms")),
            ("q_1_deg", "q_1", Some("deg")),
            ("q[3]", "q[3]", None),
            ("position[A1]", "position[A1]", None),
            ("q_A", "q_A", None),
            ("[rad]", "[rad]", None),
        ] {
            let named = Named::new(name, 0);
            assert_eq!((named.stem.as_str(), named.unit.as_deref()), (stem, unit), "{name}");
        }
        assert_eq!(factor("N·m").map(|f| f.1), Some(1.0));
        assert_eq!(factor("ticks"), None);
    }

    #[test]
    fn seconds_and_nanoseconds_of_a_stamp_are_one_time() {
        let names = |list: &[&str]| named(&list.iter().map(|s| s.to_string()).collect::<Vec<_>>());
        assert_eq!(
            known_time(&names(&["q1", "ZeitInSec", "ZeitInNanoSec"]), 0),
            Some((1, Some(2)))
        );
        assert_eq!(
            known_time(&names(&["header.stamp.secs", "header.stamp.nsecs"]), 0),
            Some((0, Some(1)))
        );
        assert_eq!(known_time(&names(&["a", "__time"]), 0), Some((1, None)));
        assert_eq!(known_time(&names(&["%time", "q1"]), 0), Some((0, None)));
        assert_eq!(known_time(&names(&["Time (ms)"]), 0), Some((0, None)));
        assert_eq!(known_time(&names(&["uptime"]), 0), None);
    }
}
