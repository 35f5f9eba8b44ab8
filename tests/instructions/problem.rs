//! The seven joints of the iiwa 14 on one motion, and a search on the paper's problem: what counts of instructions and the
//! comparison with other libraries run on.

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::Motion;
use dynident::excitation::{
    Control, Criterion, Form, Halt, Knowledge, Problem, ProblemSpec, Progress, SearchOptions, Start, search,
};
use dynident::model::Robot;

pub const SAMPLES: usize = 1000;

pub fn robot() -> Robot {
    Shipped.named("iiwa14").expect("shipped with the program").robot
}

pub fn motion() -> Motion {
    Motion::from_fn(7, SAMPLES, |j, s| {
        let t = 0.01 * s as f64 + j as f64;
        [t.sin(), t.cos(), -t.sin()]
    })
}

struct Unwatched;

impl Control for Unwatched {
    fn halt(&self) -> Option<Halt> {
        None
    }

    fn progress(&self, _: &Progress) {}
}

/// Evaluations of a search on the paper's problem that ends after about `most_evaluations`.
pub fn paper_search(most_evaluations: u64) -> u64 {
    let problem = Problem::new(ProblemSpec {
        robot: robot(),
        order: 5,
        fundamental_hz: 0.1,
        sample_rate_hz: 100.0,
        criterion: Criterion::ConditionNumber,
        form: Form::Paper,
        start: Start::Zero,
        start_position: None,
        torque_noise: None,
        torque: None,
        space: None,
        harmonics: None,
        knowledge: Knowledge::default(),
    });
    let options = SearchOptions {
        max_evaluations: Some(most_evaluations),
        jobs_per_round: 1,
        ..SearchOptions::default()
    };
    search(&problem.expect("a sound problem"), &options, &Unwatched).evaluations
}
