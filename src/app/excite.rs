//! Design an excitation trajectory.

use super::detectable::Basis;
use super::{Code, Error};
use crate::cancel::CancelFlag;
use crate::documents::{DesignDocument, ExcitationRequest};
use crate::excitation::{
    Backoff, Control, Design, Found, Given, Halt, NoRun, Point, Problem, ProblemSpec, Progress, RunSpec, first_run, run_in,
    run_out, search_from,
};
use crate::formats::significant;
use crate::model::FieldProblem;
use crate::trajectory::FourierSeries;
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// A finished design.
#[derive(Debug, Clone, PartialEq)]
pub struct Excited {
    /// The answer that clients get.
    pub document: DesignDocument,
    /// `None` where the problem is infeasible.
    pub series: Option<FourierSeries>,
    /// Smaller amplitudes, where they were asked for.
    pub first_run: Option<FourierSeries>,
}

/// The ways into a periodic motion and out of it that are asked for.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Runs {
    /// Positions at rest before and after [rad or m]; where the motion begins if left out.
    pub from: Option<Vec<f64>>,
    /// (s); 0 for none. The shortest gentle one within all limits where `None` and a pose is given, else none.
    pub run_in_s: Option<f64>,
    /// As `run_in_s`.
    pub run_out_s: Option<f64>,
}

impl Runs {
    /// Whether neither is asked for.
    pub fn is_none(&self) -> bool {
        let wanted = |s: Option<f64>| s.map_or(self.from.is_some(), |s| s > 0.0);
        !wanted(self.run_in_s) && !wanted(self.run_out_s)
    }
}

/// Run-in and run-out of `series` within all limits of the problem, each the first half of the period of a series and a whole
/// number of samples at `rate_hz`.
///
/// # Errors
/// `invalid_document` for a pose of another robot or beyond its limits; `no_trajectory` where a limit does not hold on the way.
pub fn runs(problem: &Problem, series: &FourierSeries, asked: &Runs, rate_hz: f64) -> Result<[Option<FourierSeries>; 2], Error> {
    use crate::trajectory::Trajectory;
    let start = || (0..series.joints()).map(|j| series.state(j, 0.0)[0]).collect();
    let pose: Vec<f64> = asked.from.clone().unwrap_or_else(start);
    let one = |name: &str, seconds: Option<f64>, out: bool| {
        if !seconds.map_or(asked.from.is_some(), |s| s > 0.0) {
            return Ok(None);
        }
        let spec = RunSpec {
            pose: pose.clone(),
            duration_s: seconds,
            rate_hz,
        };
        let found = if out {
            run_out(problem, series, &spec)
        } else {
            run_in(problem, series, &spec)
        };
        found.map(Some).map_err(|why| no_run(problem, name, &spec, why))
    };
    Ok([
        one("run_in_s", asked.run_in_s, false)?,
        one("run_out_s", asked.run_out_s, true)?,
    ])
}

fn no_run(problem: &Problem, name: &str, spec: &RunSpec, why: NoRun) -> Error {
    let joints = problem.robot().joints();
    let of_pose = |detail: String| Error::invalid("the pose", vec![FieldProblem::new("/from", detail)]);
    match why {
        NoRun::Joints => of_pose(format!(
            "has {} positions, and the robot has {} joints",
            spec.pose.len(),
            joints.len()
        )),
        NoRun::Pose(j) => {
            let [low, high] = joints[j].limits.position.unwrap_or_default().map(|v| significant(v, 6));
            let value = significant(spec.pose[j], 6);
            of_pose(format!(
                "joint {} at {value} is not within its limits, {low} to {high} {}",
                joints[j].name,
                joints[j].position_unit()
            ))
        }
        NoRun::Limits => {
            let tried = spec
                .duration_s
                .map_or("any duration".to_string(), |s| format!("{} s", significant(s, 4)));
            Error::new(
                Code::NoTrajectory,
                format!("a limit does not hold on the way between the pose and the motion in {tried}"),
            )
            .with_hint(format!(
                "take a longer {name}, or a pose from which the straight way of all joints is free"
            ))
        }
    }
}

/// What connects a search with its earlier life and with those beside it; see [`Control::found`] and [`Control::others`].
pub trait Exchange: Sync {
    /// Takes what the search has found so far, after every round.
    fn found(&self, found: &Found);
    /// The best points of the searches beside this one; empty if there are none.
    fn others(&self) -> Vec<Point>;
}

/// Searches until the search itself ends, its time limit is over, or `cancel` is set; the last two are honoured within a second
/// and keep the best trajectory found.
///
/// `observe` is called after every local solve, from many threads.
pub fn excite(request: &ExcitationRequest, cancel: &CancelFlag, observe: &(dyn Fn(&Progress) + Sync)) -> Excited {
    excite_beside(request, None, cancel, observe)
}

/// [`excite`], going on from what `exchange` knows, and telling it what is found.
pub fn excite_beside(
    request: &ExcitationRequest,
    exchange: Option<&dyn Exchange>,
    cancel: &CancelFlag,
    observe: &(dyn Fn(&Progress) + Sync),
) -> Excited {
    let started = Instant::now();
    let course = Course {
        request,
        cancel,
        exchange,
        observe,
        done: AtomicU64::new(0),
    };
    let run = || course.designs();
    // Threads of its own: in a shared pool a search whose time is up would wait for the local solves of another.
    let designs = match rayon::ThreadPoolBuilder::new().build() {
        Ok(pool) => pool.install(run),
        Err(_) => run(),
    };
    let backoff = request.backoff.map(|amplitude| Backoff {
        amplitude,
        slowness: 1.0,
    });
    let (problem, design) = &designs[0];
    let first_run = backoff
        .filter(|_| design.criteria.is_some())
        .and_then(|asked| first_run(problem, &design.series, asked));
    let searched_s = started.elapsed().as_secs_f64();
    let series: Vec<&FourierSeries> = designs
        .iter()
        .filter(|(_, d)| d.criteria.is_some())
        .map(|(_, d)| &d.series)
        .collect();
    let basis = Basis::new(request);
    let assessed = basis.assess(&designs, &series);
    let document = DesignDocument::new(request, &designs, first_run.as_ref(), assessed.as_ref(), searched_s);
    let design = &designs[0].1;
    Excited {
        document,
        series: design.criteria.map(|_| design.series.clone()),
        first_run: first_run.map(|run| run.series),
    }
}

/// The searches of one request, one after the other.
struct Course<'a> {
    request: &'a ExcitationRequest,
    cancel: &'a CancelFlag,
    exchange: Option<&'a dyn Exchange>,
    observe: &'a (dyn Fn(&Progress) + Sync),
    /// Evaluations of the searches that are over.
    done: AtomicU64,
}

impl Course<'_> {
    /// As many trajectories as asked for, each given those before it; at least one, and none after one that could not be found.
    fn designs(&self) -> Vec<(Problem, Design)> {
        let count = self.request.trajectories;
        let mut found: Vec<(Problem, Design)> = Vec::new();
        let mut spec = self.request.problem.spec().clone();
        for index in 0..count {
            let (problem, design) = self.best_fundamental(&spec, index, 1.0 / count as f64);
            let periods = spec.knowledge.periods;
            spec = problem.spec().clone();
            spec.knowledge.given.push(Given::Motion {
                series: design.series.clone(),
                periods,
            });
            let over = design.criteria.is_none() || self.cancel.is_cancelled();
            found.push((problem, design));
            if over {
                break;
            }
        }
        found
    }

    /// The best over the fundamentals to choose from: half of the time for all of them alike, the other half for going on from
    /// the best.
    fn best_fundamental(&self, spec: &ProblemSpec, index: usize, share: f64) -> (Problem, Design) {
        let earlier = self.request.earlier.as_ref().filter(|_| index == 0);
        let fundamentals = &self.request.fundamentals[..];
        let [only] = fundamentals else {
            let share_of_each = 0.5 * share / fundamentals.len() as f64;
            let all = fundamentals.iter().map(|&f| self.search(spec, f, earlier, share_of_each));
            let (problem, first) = all
                .reduce(|best, next| {
                    if worth(&next.0, &next.1) < worth(&best.0, &best.1) {
                        next
                    } else {
                        best
                    }
                })
                .expect("a request has a fundamental");
            if first.criteria.is_none() || self.cancel.is_cancelled() {
                return (problem, first);
            }
            let (_, last) = self.search(spec, problem.spec().fundamental_hz, Some(&first.series), 0.5 * share);
            let best = if worth(&problem, &first) < worth(&problem, &last) {
                first
            } else {
                last
            };
            return (problem, best);
        };
        self.search(spec, *only, earlier, share)
    }

    fn search(&self, spec: &ProblemSpec, fundamental_hz: f64, earlier: Option<&FourierSeries>, share: f64) -> (Problem, Design) {
        let spec = ProblemSpec {
            fundamental_hz,
            ..spec.clone()
        };
        // All fundamentals were checked when the request was read.
        let problem = Problem::new(spec).unwrap_or_else(|_| self.request.problem.clone());
        let search = &self.request.search;
        let mut options = search.options;
        options.max_evaluations = options
            .max_evaluations
            .map(|most| ((most as f64 * share).ceil() as u64).max(1));
        // A search among several ends by the clock or when it has converged.
        let clock = Clock {
            deadline: Instant::now() + Duration::from_secs_f64(search.time_limit_s * share),
            cancel: self.cancel,
            // Points of one problem mean nothing in another.
            exchange: self.exchange.filter(|_| self.request.is_single()),
            observe: self.observe,
            before: self.done.load(Ordering::Relaxed),
        };
        let design = search_from(&problem, &options, earlier, &clock);
        self.done.fetch_add(design.evaluations, Ordering::Relaxed);
        (problem, design)
    }
}

/// What is minimised, for recordings of equal length: deviations fall with the root of the time, ratios do not.
fn worth(problem: &Problem, design: &Design) -> f64 {
    let criterion = problem.spec().criterion;
    let value = design.criteria.map_or(f64::INFINITY, |c| c.value(criterion));
    if criterion.is_condition_number() {
        value
    } else {
        value / problem.spec().fundamental_hz.sqrt()
    }
}

/// Brings the clock to a search that knows none.
struct Clock<'a> {
    deadline: Instant,
    cancel: &'a CancelFlag,
    exchange: Option<&'a dyn Exchange>,
    observe: &'a (dyn Fn(&Progress) + Sync),
    /// Evaluations before this search.
    before: u64,
}

impl Control for Clock<'_> {
    fn halt(&self) -> Option<Halt> {
        if self.cancel.is_cancelled() {
            return Some(Halt::Cancelled);
        }
        (Instant::now() >= self.deadline).then_some(Halt::TimeUp)
    }

    fn progress(&self, progress: &Progress) {
        (self.observe)(&Progress {
            evaluations: self.before + progress.evaluations,
            ..progress.clone()
        });
    }

    fn found(&self, found: &Found) {
        if let Some(exchange) = self.exchange {
            exchange.found(found);
        }
    }

    fn others(&self) -> Vec<Point> {
        self.exchange.map_or_else(Vec::new, Exchange::others)
    }
}
