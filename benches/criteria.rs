//! What each criterion is worth in the others, and in the torque it predicts, on the iiwa 14.
//!
//! `cargo bench --bench criteria -- [seconds per search]`. Noise is that of the published experiment, one standard deviation per
//! joint; the torque error is i_optimality itself: expected over random states within the limits, from one period.

use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::excitation::*;
use std::time::Instant;

/// RMS errors of the published base parameters (Table 4) on the identification motion [N m].
const NOISE: [f64; 7] = [0.29, 0.36, 0.13, 0.15, 0.08, 0.18, 0.06];

struct Until(Instant, f64);

impl Control for Until {
    fn halt(&self) -> Option<Halt> {
        (self.0.elapsed().as_secs_f64() > self.1).then_some(Halt::TimeUp)
    }

    fn progress(&self, _: &Progress) {}
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| a != "--bench").collect();
    let seconds = arguments.first().and_then(|a| a.parse().ok()).unwrap_or(20.0);
    let designs = [
        ("paper, zero", Criterion::ConditionNumber, Form::Paper, Start::Zero),
        ("paper, zero", Criterion::DOptimality, Form::Paper, Start::Zero),
        ("paper, zero", Criterion::IOptimality, Form::Paper, Start::Zero),
        ("exact, zero", Criterion::ConditionNumber, Form::Exact, Start::Zero),
        ("exact, free", Criterion::ConditionNumber, Form::Exact, Start::Free),
        ("exact, free", Criterion::ScaledConditionNumber, Form::Exact, Start::Free),
        ("exact, free", Criterion::DOptimality, Form::Exact, Start::Free),
        ("exact, free", Criterion::AOptimality, Form::Exact, Start::Free),
        ("exact, free", Criterion::IOptimality, Form::Exact, Start::Free),
    ];
    println!(
        "| constraints | minimised | condition number | scaled | geometric mean deviation | torque error, N m | of the first |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut first = None;
    for (name, criterion, form, start) in designs {
        let problem = Problem::new(ProblemSpec {
            robot: Shipped.named("iiwa14").expect("shipped with the program").robot,
            order: 5,
            harmonics: None,
            fundamental_hz: 0.1,
            sample_rate_hz: 100.0,
            criterion,
            form,
            start,
            start_position: None,
            torque_noise: Some(NOISE.to_vec()),
            torque: None,
            space: None,
            knowledge: Knowledge::default(),
        })
        .expect("a sound problem");
        let options = SearchOptions {
            until_halted: true,
            ..SearchOptions::default()
        };
        let design = search(&problem, &options, &Until(Instant::now(), seconds));
        let (c, p) = (design.criteria.expect("found"), design.predicted.expect("found"));
        let mean = (p.std_dev.map(f64::ln).sum() / p.std_dev.len() as f64).exp();
        let reference = *first.get_or_insert(c.i_optimality);
        println!(
            "| {name} | {criterion:?} | {:.1} | {:.1} | {mean:.2e} | {:.4} | {:.3} |",
            c.condition_number,
            c.scaled_condition_number,
            c.i_optimality,
            c.i_optimality / reference
        );
    }
}
