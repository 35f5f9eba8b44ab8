//! Workers on machines of their own, as far as the network can tell: one is cut off in the middle of its work.

use crate::process::{Place, Process, wait_until};
use crate::workers::{LEASE, Lab, begun, result};
use std::process::Command;
use std::time::Duration;

/// A network namespace with a cable to this machine.
struct Machine {
    name: String,
    cable: String,
    number: u8,
}

fn ip(arguments: &str) -> bool {
    let done = Command::new("ip").args(arguments.split_whitespace()).output();
    done.is_ok_and(|o| o.status.success())
}

impl Machine {
    /// `None` where this may not be made.
    fn new(number: u8) -> Option<Self> {
        let process = std::process::id();
        let machine = Self {
            name: format!("dynident-{process}-{number}"),
            cable: format!("dy{process}n{number}"),
            number,
        };
        let Self { name, cable, .. } = &machine;
        let steps = [
            format!("netns add {name}"),
            format!("link add {cable} type veth peer name eth0 netns {name}"),
            format!("addr add 198.18.{number}.1/24 dev {cable}"),
            format!("link set {cable} up"),
            format!("-n {name} addr add 198.18.{number}.2/24 dev eth0"),
            format!("-n {name} link set lo up"),
            format!("-n {name} link set eth0 up"),
        ];
        steps.iter().all(|step| ip(step)).then_some(machine)
    }

    fn place(&self, lab: &Lab) -> Place {
        let place = lab.machine(&self.name);
        let gateway = format!("198.18.{}.1", self.number);
        Place {
            database: place.database.map(|url| url.replace("127.0.0.1", &gateway)),
            network: Some(self.name.clone()),
            ..place
        }
    }

    fn cut_off(&self) {
        assert!(ip(&format!("link set {} down", self.cable)));
    }

    fn connect_again(&self) {
        assert!(ip(&format!("link set {} up", self.cable)));
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        ip(&format!("link del {}", self.cable));
        ip(&format!("netns del {}", self.name));
    }
}

#[test]
fn a_machine_that_is_cut_off_loses_its_work_to_another() {
    let (Some(first), Some(second)) = (Machine::new(1), Machine::new(2)) else {
        println!("SKIPPED a_machine_that_is_cut_off_loses_its_work_to_another: network namespaces cannot be made here");
        return;
    };
    let lab = Lab::new("network");
    let server = lab.server();
    let one = Process::worker(&first.place(&lab), LEASE);
    let id = begun(&server, 6.0);
    let other = Process::worker(&second.place(&lab), LEASE);
    let job = format!("/jobs/{id}");
    wait_until("there is progress", || {
        server.get(&job).1["progress"]["evaluations"].as_u64() > Some(0)
    });
    first.cut_off();
    let found = result(&server, &id);
    let ended = server.get(&job).1;
    assert_eq!(ended["state"], "finished");
    first.connect_again();
    // Time enough for the first machine to hand in what it has: it has lost the job.
    std::thread::sleep(Duration::from_secs(4));
    assert_eq!(server.get(&job).1, ended);
    assert_eq!(server.get(&format!("/excitation/{id}")).1, found);
    drop((one, other));
}
