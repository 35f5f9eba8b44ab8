//! A report in a few lines.

use dynident::diagnosis::{JointFit, ResidualReport};

pub fn show(r: &ResidualReport) {
    let fits = |l: &[JointFit]| {
        let each = |f: &JointFit| format!("{:.2}/{:.0e}", f.statistic, f.p_value);
        l.iter().map(each).collect::<Vec<_>>().join(" ")
    };
    println!(
        "  verdict {:?} floor {:.4?} ({})\n  lack of fit {}\n  afterwards  {}",
        r.verdict,
        r.noise_floor,
        r.noise_source,
        fits(&r.lack_of_fit),
        fits(&r.lack_of_fit_after)
    );
    for f in &r.findings {
        let e = &f.evidence;
        println!(
            "  FOUND {} {:?} gain {:.1} evidence {:.1} p {:.1e} blocks {:?} periods {:?}",
            f.effect, f.joints, e.gain, e.log_evidence_ratio, e.p_value, e.held_out_blocks, e.held_out_periods
        );
        f.parameters
            .iter()
            .for_each(|p| println!("     {} = {:.6} ± {:.6} {}", p.name, p.value, p.std_dev, p.unit));
        f.rivals
            .iter()
            .for_each(|v| println!("     rival {} {:?} {:.1}", v.effect, v.joints, v.evidence));
        f.note.iter().for_each(|n| println!("     note {n}"));
        println!("     held out {:.3?} -> {:.3?}", f.rms_before.held_out, f.rms_after.held_out);
    }
    if let Some(x) = &r.remainder {
        println!("  REMAINDER {x:?}");
    }
    for u in &r.undetected {
        let p = &u.parameter;
        println!(
            "  no {} on {}: {:.4} ± {:.4} {}",
            u.effect, u.joint, p.value, p.std_dev, p.unit
        );
    }
    println!(
        "  identification {:.3?} -> {:.3?}\n  held out {:.3?} -> {:.3?}",
        r.rms_before.identification, r.rms_after.identification, r.rms_before.held_out, r.rms_after.held_out
    );
}
