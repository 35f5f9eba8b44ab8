//! What a sample costs: batched against one by one, adjoint against regressor, as ratios in one run.
//!
//! `cargo bench --bench dynamics`

use dynident::dynamics::*;
use dynident::model::{Friction, Joint, JointKind, Mdh, Robot};
use dynident::parameters::{BaseParameters, Layout};
use nalgebra::Vector3;
use std::hint::black_box;
use std::time::Instant;

const SAMPLES: usize = 1000;

/// Seven joints in the manner of the iiwa.
fn robot() -> Robot {
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, -quarter, -quarter, quarter, quarter, -quarter];
    let joints = alphas.iter().enumerate().map(|(j, &alpha)| {
        let r = if j == 2 || j == 4 { 0.4 } else { 0.0 };
        Joint::from_mdh(
            format!("A{}", j + 1),
            JointKind::Revolute,
            Mdh {
                alpha,
                d: 0.0,
                theta: 0.0,
                r,
            },
        )
    });
    let friction = Friction {
        viscous: true,
        coulomb: true,
    };
    Robot::new("bench", Vector3::new(0.0, 0.0, -9.81), joints.collect(), friction).expect("a robot")
}

/// Best of several repetitions [s]: the one least disturbed.
fn best(mut work: impl FnMut()) -> f64 {
    let once = |work: &mut dyn FnMut()| {
        let begun = Instant::now();
        work();
        begun.elapsed().as_secs_f64()
    };
    (0..30).map(|_| once(&mut work)).fold(f64::INFINITY, f64::min)
}

fn main() {
    let robot = robot();
    let layout = Layout::standard(&robot);
    let chain = Chain::new(&robot);
    let base = BaseParameters::exact(&robot);
    let columns = ColumnSet::new(&robot, &layout, &base.kept);
    let motion = Motion::from_fn(7, SAMPLES, |j, s| {
        let t = 0.01 * s as f64 + j as f64;
        [t.sin(), t.cos(), -t.sin()]
    });
    let phi: Vec<f64> = (0..layout.len()).map(|i| (i as f64).sin()).collect();
    let (mut rows, weights) = (RowBlocks::new(&columns, SAMPLES), RowBlocks::new(&columns, SAMPLES));
    let mut gradient = MotionGradient::new(7, SAMPLES);
    let part = |s: usize, i: usize| (0..7).map(|j| motion.get(j, s)[i]).collect::<Vec<_>>();

    let fill = best(|| rows.fill(&chain, &columns, &motion, Coulomb::Sign));
    let adjoint = best(|| gradient.fill(&chain, &columns, &motion, Coulomb::Smooth(0.1), &weights));
    let single = best(|| {
        for s in 0..SAMPLES {
            black_box(regressor(&robot, &layout, &part(s, 0), &part(s, 1), &part(s, 2)));
        }
    });
    let batched_torques = best(|| {
        black_box(inverse_dynamics_batch(&chain, &layout, &phi, &motion, Coulomb::Sign));
    });
    let single_torques = best(|| {
        for s in 0..SAMPLES {
            black_box(inverse_dynamics(&robot, &layout, &phi, &part(s, 0), &part(s, 1), &part(s, 2)));
        }
    });
    let microseconds = 1e6 / SAMPLES as f64;
    println!("base regressor, batched        {:8.3} us per sample   1", fill * microseconds);
    println!(
        "its adjoint, batched           {:8.3} us per sample   {:.1}",
        adjoint * microseconds,
        adjoint / fill
    );
    println!(
        "regressor one by one           {:8.3} us per sample   {:.1}",
        single * microseconds,
        single / fill
    );
    println!(
        "inverse dynamics, batched      {:8.3} us per sample   1",
        batched_torques * microseconds
    );
    let ratio = single_torques / batched_torques;
    println!(
        "inverse dynamics one by one    {:8.3} us per sample   {ratio:.1}",
        single_torques * microseconds
    );
}
