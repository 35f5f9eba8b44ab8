//! Traces what the declared model leaves over on logs of an iiwa 14: `trace_log DIRECTORY…`, each with identify and validate logs.

use dynident::identification::{PreprocessOptions, prepare};
use dynident::io::log::{Columns, read_log_file};
use dynident::model::*;
use dynident::residual::*;
use nalgebra::Vector3;
use std::time::Instant;

fn iiwa14() -> Robot {
    let quarter = std::f64::consts::FRAC_PI_2;
    let alphas = [0.0, quarter, -quarter, -quarter, quarter, quarter, -quarter];
    let r = [0.0, 0.0, 0.42, 0.0, 0.4, 0.0, 0.0];
    let mdh = |j: usize| Mdh {
        alpha: alphas[j],
        d: 0.0,
        theta: 0.0,
        r: r[j],
    };
    let joints = (0..7)
        .map(|j| Joint::from_mdh(format!("A{}", j + 1), JointKind::Revolute, mdh(j)))
        .collect();
    Robot::new(
        "iiwa 14",
        Vector3::new(0.0, 0.0, -9.81),
        joints,
        Friction {
            viscous: true,
            coulomb: true,
        },
    )
    .unwrap()
}

fn load(robot: &Robot, path: &str) -> Stretch {
    let names: Vec<String> = robot.joints().iter().map(|j| j.name.clone()).collect();
    let (log, _) = read_log_file(path.as_ref(), &Columns::default(), &names).unwrap();
    let prepared = prepare(&log, robot.joint_count(), &PreprocessOptions::default()).unwrap();
    Stretch::new(&prepared, &log)
}

fn main() {
    let robot = iiwa14();
    for dir in std::env::args().skip(1) {
        let (a, b) = (
            load(&robot, &format!("{dir}/identify.csv.gz")),
            load(&robot, &format!("{dir}/validate.csv.gz")),
        );
        println!("== {dir}: {a:?} {b:?}");
        let t = Instant::now();
        let out = trace(
            &robot,
            std::slice::from_ref(&a),
            std::slice::from_ref(&b),
            &TraceOptions::default(),
        );
        println!("  identification traced in {:?}", t.elapsed());
        show(&out.report);
        let t = Instant::now();
        let options = TraceOptions {
            existing: Some(out.existing()),
            ..TraceOptions::default()
        };
        let again = trace(&robot, &[b], &[], &options);
        println!("  validation traced in {:?}", t.elapsed());
        show(&again.report);
    }
}

fn show(r: &ResidualReport) {
    let fits = |l: &[JointFit]| {
        l.iter()
            .map(|f| format!("{:.2}/{:.0e}", f.statistic, f.p_value))
            .collect::<Vec<_>>()
            .join(" ")
    };
    println!(
        "  verdict {:?} floor {:.4?}\n  lack of fit {}\n  afterwards  {}",
        r.verdict,
        r.noise_floor,
        fits(&r.lack_of_fit),
        fits(&r.lack_of_fit_after)
    );
    for f in &r.findings {
        let e = &f.evidence;
        println!(
            "  FOUND {} {:?} gain {:.1} evidence {:.1} p {:.1e} blocks {:.1} periods {:?}",
            f.effect, f.joints, e.gain, e.log_evidence_ratio, e.p_value, e.held_out_blocks, e.held_out_periods
        );
        f.parameters
            .iter()
            .for_each(|p| println!("     {} = {:.6} ± {:.6} {}", p.name, p.value, p.std_dev, p.unit));
        f.rivals
            .iter()
            .for_each(|v| println!("     rival {} {:?} {:.1}", v.effect, v.joints, v.evidence));
        println!("     rms {:.4?} -> {:.4?}", f.rms_before.held_out, f.rms_after.held_out);
    }
    if let Some(x) = &r.remainder {
        println!("  REMAINDER {x:?}");
    }
    println!("  rms before {:.4?}\n  rms after  {:.4?}", r.rms_before, r.rms_after);
}
