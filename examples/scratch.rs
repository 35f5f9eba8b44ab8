use dynident::excitation::*;
use dynident::model::*;
use nalgebra::Vector3;
fn main() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, -quarter, -quarter, quarter, quarter, -quarter];
    let r = [0.0, 0.0, 0.42, 0.0, 0.4, 0.0, 0.0];
    let ql = [170.0, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0f64];
    let vl = [85.0, 85.0, 100.0, 75.0, 130.0, 135.0, 135.0f64];
    let joints = (0..7)
        .map(|j| {
            let mdh = Mdh {
                alpha: alphas[j],
                d: 0.0,
                theta: 0.0,
                r: r[j],
            };
            let q = ql[j].to_radians();
            Joint::from_mdh(format!("A{}", j + 1), JointKind::Revolute, mdh).with_limits(Limits {
                position: Some([-q, q]),
                velocity: Some(vl[j].to_radians()),
                ..Limits::unlimited()
            })
        })
        .collect();
    let robot = Robot::new(
        "iiwa 14",
        Vector3::new(0.0, 0.0, -9.81),
        joints,
        Friction {
            viscous: true,
            coulomb: true,
        },
    )
    .unwrap();
    let form = if std::env::var("EXACT").is_ok() {
        Form::Exact
    } else {
        Form::Paper
    };
    let start = if std::env::var("FREE").is_ok() {
        Start::Free
    } else {
        Start::Zero
    };
    let p = Problem::new(ProblemSpec {
        robot,
        order: 5,
        fundamental_hz: 0.1,
        sample_rate_hz: 100.0,
        criterion: Criterion::ConditionNumber,
        form,
        start,
        start_position: None,
        torque_noise: None,
    })
    .unwrap();
    let limit: f64 = std::env::var("LIMIT").ok().and_then(|v| v.parse().ok()).unwrap_or(10.0);
    let target: f64 = std::env::var("TARGET").ok().and_then(|v| v.parse().ok()).unwrap_or(0.0);
    struct C(std::time::Instant, f64, f64, std::sync::Mutex<(f64, f64)>);
    impl Control for C {
        fn halt(&self) -> Option<Halt> {
            (self.0.elapsed().as_secs_f64() > self.1 || self.3.lock().unwrap().0 < self.2).then_some(Halt::TimeUp)
        }
        fn progress(&self, p: &Progress) {
            let mut b = self.3.lock().unwrap();
            if p.best < b.0 {
                *b = (p.best, self.0.elapsed().as_secs_f64());
                if std::env::var("V").is_ok() {
                    println!("{:.1} s {:.3} round {} ev {}", b.1, b.0, p.rounds_finished, p.evaluations);
                }
            }
        }
    }
    let mut all = vec![];
    for seed in 1..=std::env::var("SEEDS").ok().and_then(|v| v.parse().ok()).unwrap_or(5u64) {
        let c = C(std::time::Instant::now(), limit, target, std::sync::Mutex::new((1e9, 0.0)));
        let d = search(
            &p,
            &SearchOptions {
                seed,
                until_halted: true,
                ..Default::default()
            },
            &c,
        );
        let v = d.criteria.unwrap().condition_number;
        println!(
            "seed {seed}: {v:.3} at {:.1} s of {:.1}, {} ev {} rounds {} starts {:?} worst margin {:.2e} bound {:.9}",
            c.3.lock().unwrap().1,
            c.0.elapsed().as_secs_f64(),
            d.evaluations,
            d.rounds,
            d.starts.len(),
            d.status,
            d.margins.iter().map(|m| m.margin).fold(1.0, f64::min),
            d.margins.iter().filter_map(|m| m.bound_used).fold(0.0, f64::max)
        );
        all.push((v * 100.0).round() / 100.0);
    }
    println!(
        "{all:?} mean {:.2} max {:.2}",
        all.iter().sum::<f64>() / all.len() as f64,
        all.iter().cloned().fold(0.0, f64::max)
    );
}
