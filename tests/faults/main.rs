//! What must survive when processes are killed, disks fill and databases go away.

#[path = "../support/postgres.rs"]
mod postgres;
#[path = "../support/process.rs"]
mod process;

mod catalogue;
mod children;
mod deploy;
mod handles;
mod kill;
mod network;
mod storage;
mod workers;
