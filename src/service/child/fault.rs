//! Faults on demand, for tests of what a fault costs.
//!
//! Only where the environment of the server has `DYNIDENT_TEST_FAULTS`: then a job with a log or a robot that is called `fault-…`
//! fails in that way. It harms nothing but its own child, which is what is tested.

use super::message::JobTask;
use crate::service::known::robot_inside;
use std::hint::black_box;

/// The name of the fault that a job asks for.
pub fn asked(task: &JobTask) -> Option<String> {
    std::env::var_os("DYNIDENT_TEST_FAULTS")?;
    let logs = task.logs.iter().map(|log| log.name.as_str());
    let mut names = logs.chain(robot_inside(&task.input.request));
    let fault = names.find_map(|name| name.strip_prefix("fault-"))?;
    Some(fault.trim_end_matches(".csv").to_string())
}

/// Does what is asked for before the work begins.
pub fn before_work(fault: &str) {
    match fault {
        "abort" => std::process::abort(),
        "overflow" => {
            black_box(deep(1));
        }
        "memory" => hoard(),
        "endless" => loop {
            std::thread::sleep(std::time::Duration::from_millis(10));
        },
        "spin" => loop {
            std::hint::spin_loop();
        },
        "killed" => {
            let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
        }
        _ => {}
    }
}

/// Does what is asked for when the result is complete, before anything is drawn.
pub fn before_drawing(fault: &str) {
    match fault {
        "drawing-abort" => std::process::abort(),
        "drawing-endless" => before_work("endless"),
        _ => {}
    }
}

#[expect(unconditional_recursion, reason = "the overflow is what is asked for")]
fn deep(n: u64) -> u64 {
    let page = black_box([n; 512]);
    deep(n + 1) + page[(n % 512) as usize]
}

fn hoard() {
    let mut all = Vec::new();
    loop {
        all.push(black_box(vec![1u8; 16 << 20]));
    }
}
