//! Programs for the controllers of Universal Robots: one `servoj` for every sample.

use super::table::{self, decimal, states};
use crate::trajectory::{FourierSeries, Trajectory};
use std::fmt::Write;

/// Joints of the arms that run URScript.
const JOINTS: usize = 6;
/// Of `servoj`: the least look-ahead (s), which follows most closely, and the gain that the manual has as its default.
const LOOKAHEAD_S: f64 = 0.03;
const GAIN: u32 = 300;

fn moves(series: FourierSeries, rate_hz: f64, periods: usize) -> impl Iterator<Item = String> + Send + 'static {
    let step = decimal(1.0 / rate_hz);
    let write = move |text: &mut String, _, row| {
        let q = joints(&states(row).of[0]);
        writeln!(text, "  servoj({q}, 0, 0, {step}, {LOOKAHEAD_S}, {GAIN})").expect("writing to a string cannot fail");
    };
    table::parts(series, rate_hz, periods, write)
}

fn joints(q: &[f64]) -> String {
    format!("[{}]", q.iter().map(|&v| decimal(v)).collect::<Vec<_>>().join(", "))
}

/// # Errors
/// The robot has other joints than those of Universal Robots.
pub(super) fn parts(
    series: FourierSeries,
    rate_hz: f64,
    periods: usize,
) -> Result<impl Iterator<Item = String> + Send + 'static, String> {
    if series.joints() != JOINTS {
        return Err(format!(
            "is for {JOINTS} joints, and this robot has {}; take another format",
            series.joints()
        ));
    }
    let start: Vec<f64> = (0..JOINTS).map(|j| series.state(j, 0.0)[0]).collect();
    let head = format!(
        "# {periods} periods of {} s at {} Hz. It goes slowly to where the motion begins, and stops where that ends.\n\
         def excitation():\n  movej({}, a=0.5, v=0.2)\n  sleep(1.0)\n",
        decimal(series.duration()),
        decimal(rate_hz),
        joints(&start)
    );
    let moves = moves(series, rate_hz, periods);
    let tail = "  stopj(2.0)\nend\nexcitation()\n".to_string();
    Ok(std::iter::once(head).chain(moves).chain(std::iter::once(tail)))
}
