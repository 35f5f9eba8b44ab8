//! scratch
use super::criterion::SmoothCriterion;
use super::evaluator::Evaluator;
use super::problem::*;
use super::solver::*;
use super::variables::Variables;
use crate::dynamics::Coulomb;
use crate::trajectory::Trajectory;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::time::Instant;

pub fn cond_at(problem: &Problem, vars: &Variables, x: &[f64]) -> f64 {
    let mut e = Evaluator::new(problem, vars, problem.samples());
    let g = e.gram_at(Coulomb::Sign, x);
    let ev = g.symmetric_eigenvalues();
    (ev.max() / ev.min()).sqrt()
}

pub fn run(problem: &Problem) {
    let vars = Variables::new(problem);
    println!("vars {} samples {}", vars.len(), problem.samples());
    let args: Vec<f64> = std::env::args().skip(1).map(|a| a.parse().unwrap()).collect();
    let n1 = args[0] as usize;
    let method = if args[1] == 0.0 { Method::Slsqp } else { Method::Lbfgs };
    let starts = args[2] as usize;
    // timing
    for n in [n1, 1000] {
        let mut e = Evaluator::new(problem, &vars, n);
        let x: Vec<f64> = (0..vars.len()).map(|i| ((i * 37 % 11) as f64 - 5.0) / 5.0).collect();
        let mut g = vec![0.0; vars.len()];
        let t = Instant::now();
        for _ in 0..50 { e.evaluate(&SmoothCriterion::ConditionNumber { power: 3.0 }, Coulomb::Smooth(0.1), &x, &mut g); }
        println!("{n} samples: {:.3} ms", t.elapsed().as_secs_f64() * 20.0);
        let t = Instant::now();
        for _ in 0..50 { e.gram_at(Coulomb::Smooth(0.1), &x); }
        println!("   gram only: {:.3} ms", t.elapsed().as_secs_f64() * 20.0);
        let gr = e.gram_at(Coulomb::Smooth(0.1), &x);
        let t = Instant::now();
        for _ in 0..50 { SmoothCriterion::ConditionNumber { power: 3.0 }.evaluate(gr.clone()); }
        println!("   eigen: {:.3} ms", t.elapsed().as_secs_f64() * 20.0);
    }
    let mut finals = vec![];
    let t0 = Instant::now();
    for s in 0..starts {
        let mut rng = ChaCha8Rng::seed_from_u64(s as u64);
        let mut x: Vec<f64> = (0..vars.len()).map(|_| rng.random_range(-1.0..1.0)).collect();
        let mut line = format!("{:.1}", cond_at(problem, &vars, &x));
        let mut total = 0;
        for (p, eps, n, cap) in [(1.0, 0.1, n1, args[3] as u32), (5.0, 0.05, n1, args[4] as u32), (25.0, 0.03, n1, args[5] as u32), (100.0, 0.02, 1000, args[6] as u32)] {
            if cap == 0 { continue; }
            let mut e = Evaluator::new(problem, &vars, n);
            let t = Instant::now();
            let m = minimize(method, &x, StopRule { max_evaluations: cap, least_improvement: 1e-6 }, &mut |x, g| Some(e.evaluate(&SmoothCriterion::ConditionNumber { power: p }, Coulomb::Smooth(eps), x, g)));
            x = m.x;
            total += m.evaluations;
            line += &format!(" -> {:.2} ({} ev {:.0} ms)", cond_at(problem, &vars, &x), m.evaluations, t.elapsed().as_secs_f64() * 1e3);
        }
        let c = cond_at(problem, &vars, &x);
        finals.push(c);
        println!("{s}: {line} total {total}");
    }
    finals.sort_by(f64::total_cmp);
    println!("{:.1} s; min {:.2} quart {:.2} median {:.2}", t0.elapsed().as_secs_f64(), finals[0], finals[finals.len() / 4], finals[finals.len() / 2]);
    let _ = problem.spec().robot.joint_count();
    let _ = vars.series(&vec![0.1; vars.len()]).duration();
}
