//! What an evaluation of the criterion with its gradient costs, and how far the search gets with it, on the paper's problem.
//!
//! `cargo bench --bench search -- [seconds per search] [seeds] [paper|exact] [zero|free] [stop below] [first seed]`

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::excitation::*;
use std::sync::Mutex;
use std::time::Instant;

/// Ends a search when its time is up or the goal is reached, and remembers when the best was found.
struct Clock {
    begun: Instant,
    seconds: f64,
    goal: f64,
    best: Mutex<(f64, f64)>,
}

impl Control for Clock {
    fn halt(&self) -> Option<Halt> {
        let reached = self.best.lock().expect("not poisoned").0 < self.goal;
        (reached || self.begun.elapsed().as_secs_f64() > self.seconds).then_some(Halt::TimeUp)
    }

    fn progress(&self, progress: &Progress) {
        let mut best = self.best.lock().expect("not poisoned");
        if progress.best < best.0 {
            *best = (progress.best, self.begun.elapsed().as_secs_f64());
        }
    }
}

fn main() {
    // `cargo bench` adds a flag of its own.
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let number = |at: usize, default: f64| arguments.get(at).and_then(|a| a.parse().ok()).unwrap_or(default);
    let is = |at: usize, word: &str| arguments.get(at).is_some_and(|a| a == word);
    let spec = ProblemSpec {
        robot: Shipped.named("iiwa14").expect("shipped with the program").robot,
        order: 5,
        fundamental_hz: 0.1,
        sample_rate_hz: 100.0,
        criterion: Criterion::ConditionNumber,
        form: if is(2, "exact") { Form::Exact } else { Form::Paper },
        start: if is(3, "free") { Start::Free } else { Start::Zero },
        start_position: None,
        torque_noise: None,
        torque: None,
        space: None,
        harmonics: None,
        knowledge: Knowledge::default(),
    };
    let problem = Problem::new(spec).expect("a sound problem");
    println!("seed  condition number  found after [s]  stopped after [s]  evaluations  per second");
    let first = number(5, 1.0) as u64;
    for seed in first..first + number(1, 5.0) as u64 {
        let clock = Clock {
            begun: Instant::now(),
            seconds: number(0, 10.0),
            goal: number(4, 0.0),
            best: Mutex::new((f64::INFINITY, 0.0)),
        };
        let design = search(
            &problem,
            &SearchOptions {
                seed,
                until_halted: true,
                ..SearchOptions::default()
            },
            &clock,
        );
        let elapsed = clock.begun.elapsed().as_secs_f64();
        let found = clock.best.lock().expect("not poisoned").1;
        let condition = design.criteria.map_or(f64::INFINITY, |c| c.condition_number);
        let rate = design.evaluations as f64 / elapsed;
        println!(
            "{seed:4}  {condition:16.3}  {found:15.1}  {elapsed:17.1}  {:11}  {rate:10.0}",
            design.evaluations
        );
    }
}
