use dynident::excitation::*;
use dynident::model::*;
use nalgebra::Vector3;
fn main() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, -quarter, -quarter, quarter, quarter, -quarter];
    let r = [0.0, 0.0, 0.42, 0.0, 0.4, 0.0, 0.0];
    let ql = [170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0f64];
    let vl = [85.0, 85.0, 100.0, 75.0, 130.0, 135.0, 135.0f64];
    let joints = (0..7).map(|j| {
        let mdh = Mdh { alpha: alphas[j], d: 0.0, theta: 0.0, r: r[j] };
        let q = ql[j].to_radians();
        Joint::from_mdh(format!("A{}", j + 1), JointKind::Revolute, mdh).with_limits(Limits { position: Some([-q, q]), velocity: Some(vl[j].to_radians()), ..Limits::unlimited() })
    }).collect();
    let robot = Robot::new("iiwa 14", Vector3::new(0.0, 0.0, -9.81), joints, Friction { viscous: true, coulomb: true }).unwrap();
    let form = if std::env::var("EXACT").is_ok() { Form::Exact } else { Form::Paper };
    let start = if std::env::var("FREE").is_ok() { Start::Free } else { Start::Zero };
    let p = Problem::new(ProblemSpec { robot, order: 5, fundamental_hz: 0.1, sample_rate_hz: 100.0, criterion: Criterion::ConditionNumber, form, start, start_position: None, torque_noise: None }).unwrap();
    use dynident::excitation::search::*;
    let limit: f64 = std::env::var("LIMIT").ok().and_then(|v| v.parse().ok()).unwrap_or(10.0);
    struct C(std::time::Instant, f64);
    impl Control for C { fn halt(&self) -> Option<Halt> { (self.0.elapsed().as_secs_f64() > self.1).then_some(Halt::TimeUp) } fn progress(&self, _: &Progress) {} }
    if std::env::var("OLD").is_ok() { dynident::excitation::experiment::run(&p); return; }
    let mut all = vec![];
    for seed in 1..=std::env::var("SEEDS").ok().and_then(|v| v.parse().ok()).unwrap_or(5u64) {
        let v = experiment_search(&p, &SearchOptions { seed, starts: 64, max_evaluations: None }, &C(std::time::Instant::now(), limit));
        all.push((v * 100.0).round() / 100.0);
    }
    println!("{all:?} mean {:.2} max {:.2}", all.iter().sum::<f64>() / all.len() as f64, all.iter().cloned().fold(0.0, f64::max));
}
