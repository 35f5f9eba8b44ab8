//! The kernels that a design and an identification spend their time in, on the seven joints of the iiwa 14.

use super::problem::{SAMPLES, motion, paper_search, robot};
use dynident::dynamics::{Chain, ColumnSet, Coulomb, MotionGradient, RowBlocks, inverse_dynamics_batch};
use dynident::formats::logs::{Columns, Source, read_log};
use dynident::parameters::{BaseParameters, Layout};
use std::fmt::Write as _;
use std::hint::black_box;

/// One kernel with the count it is held to.
pub struct Kernel {
    pub name: &'static str,
    pub unit: &'static str,
    /// Locked: instructions per unit.
    pub instructions: f64,
    /// Rounds of the two runs whose difference counts.
    pub rounds: [usize; 2],
    /// Runs so many rounds, and says how many units those were.
    pub run: fn(usize) -> u64,
}

pub const KERNELS: &[Kernel] = &[
    Kernel {
        name: "base_regressor",
        unit: "sample",
        instructions: 3420.5,
        rounds: [2, 12],
        run: base_regressor,
    },
    Kernel {
        name: "regressor_adjoint",
        unit: "sample",
        instructions: 6590.6,
        rounds: [2, 12],
        run: regressor_adjoint,
    },
    Kernel {
        name: "inverse_dynamics",
        unit: "sample",
        instructions: 1834.5,
        rounds: [2, 12],
        run: inverse_dynamics,
    },
    Kernel {
        name: "criterion_in_search",
        unit: "evaluation with gradient",
        instructions: 5_367_256.6,
        rounds: [1, 3],
        run: criterion_in_search,
    },
    Kernel {
        name: "log_of_text",
        unit: "row of 15 numbers",
        instructions: 4743.4,
        rounds: [1, 3],
        run: log_of_text,
    },
];

fn base_regressor(rounds: usize) -> u64 {
    let (robot, motion) = (robot(), motion());
    let columns = ColumnSet::new(&robot, &Layout::standard(&robot), &BaseParameters::exact(&robot).kept);
    let (chain, mut rows) = (Chain::new(&robot), RowBlocks::new(&columns, SAMPLES));
    for _ in 0..rounds {
        rows.fill(&chain, &columns, black_box(&motion), Coulomb::Sign);
    }
    black_box(rows.block(0));
    (rounds * SAMPLES) as u64
}

fn regressor_adjoint(rounds: usize) -> u64 {
    let (robot, motion) = (robot(), motion());
    let columns = ColumnSet::new(&robot, &Layout::standard(&robot), &BaseParameters::exact(&robot).kept);
    let (chain, weights) = (Chain::new(&robot), RowBlocks::new(&columns, SAMPLES));
    let mut gradient = MotionGradient::new(7, SAMPLES);
    for _ in 0..rounds {
        gradient.fill(&chain, &columns, black_box(&motion), Coulomb::Smooth(0.1), &weights);
    }
    black_box(&gradient);
    (rounds * SAMPLES) as u64
}

fn inverse_dynamics(rounds: usize) -> u64 {
    let (robot, motion) = (robot(), motion());
    let (chain, layout) = (Chain::new(&robot), Layout::standard(&robot));
    let phi: Vec<f64> = (0..layout.len()).map(|i| (i as f64).sin()).collect();
    for _ in 0..rounds {
        black_box(inverse_dynamics_batch(
            &chain,
            &layout,
            &phi,
            black_box(&motion),
            Coulomb::Sign,
        ));
    }
    (rounds * SAMPLES) as u64
}

/// The paper's problem: local solves, one a round.
fn criterion_in_search(rounds: usize) -> u64 {
    paper_search(60 * rounds as u64)
}

/// Rows of the longest log that is read.
const MOST_ROWS: usize = 6000;

fn log_of_text(rounds: usize) -> u64 {
    let robot = robot();
    let joints: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let names = |stem: &str| (1..=7).map(|k| format!(",{stem}{k}")).collect::<String>();
    let mut text = format!("time{}{}\n", names("q"), names("tau"));
    // The same text in every run, of which a part is read.
    let mut ends = vec![text.len()];
    for s in 0..MOST_ROWS {
        write!(text, "{:.3}", 0.001 * s as f64).expect("memory");
        (0..14).for_each(|c| write!(text, ",{:.9}", (0.001 * s as f64 + c as f64).sin()).expect("memory"));
        text.push('\n');
        ends.push(text.len());
    }
    let rows = 2000 * rounds;
    let source = Source {
        name: "log.csv".to_string(),
        bytes: &text.as_bytes()[..ends[rows]],
    };
    let (log, _) = read_log(source, &Columns::default(), &joints).expect("a good log");
    assert_eq!(log.q[6].len(), rows);
    rows as u64
}
