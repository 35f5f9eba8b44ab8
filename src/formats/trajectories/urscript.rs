//! Programs for the controllers of Universal Robots: one `servoj` for every sample.

use super::table::{self, Course, decimal, states};
use crate::trajectory::Trajectory;
use std::fmt::Write;

/// Joints of the arms that run URScript.
const JOINTS: usize = 6;
/// Of `servoj`: the least look-ahead (s), which follows most closely, and the gain that the manual has as its default.
const LOOKAHEAD_S: f64 = 0.03;
const GAIN: u32 = 300;

fn moves(course: Course) -> impl Iterator<Item = String> + Send + 'static {
    let step = decimal(1.0 / course.rate_hz);
    let write = move |text: &mut String, _, row| {
        let q = joints(&states(row).of[0]);
        writeln!(text, "  servoj({q}, 0, 0, {step}, {LOOKAHEAD_S}, {GAIN})").expect("writing to a string cannot fail");
    };
    table::parts(course, write)
}

fn joints(q: &[f64]) -> String {
    format!("[{}]", q.iter().map(|&v| decimal(v)).collect::<Vec<_>>().join(", "))
}

/// # Errors
/// The robot has other joints than those of Universal Robots.
pub(super) fn parts(course: Course) -> Result<impl Iterator<Item = String> + Send + 'static, String> {
    let own = course.series.joints();
    if own != JOINTS {
        return Err(format!(
            "is for {JOINTS} joints, and this robot has {own}; take another format"
        ));
    }
    let start = states(course.row(0)).of[0].clone();
    let head = format!(
        "# {} periods of {} s at {} Hz. It goes slowly to where the motion begins, and stops where that ends.\n\
         def excitation():\n  movej({}, a=0.5, v=0.2)\n  sleep(1.0)\n",
        course.periods,
        decimal(course.series.duration()),
        decimal(course.rate_hz),
        joints(&start)
    );
    let moves = moves(course);
    let tail = "  stopj(2.0)\nend\nexcitation()\n".to_string();
    Ok(std::iter::once(head).chain(moves).chain(std::iter::once(tail)))
}
