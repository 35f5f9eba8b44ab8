//! One child, as the server sees it.

use super::message::{FromChild, Task, ToChild, receive, send};
use super::{Limits, confine, inside};
use crate::app::{Code, Error};
use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, PipeReader};
use std::net::Shutdown;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixStream;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError, mpsc as sync};
use std::thread::JoinHandle;
use std::time::Duration;
use tokio::sync::mpsc;

/// Set before the program starts, where its libraries look: OpenBLAS without threads of its own, which gain nothing from matrices
/// of four by four, and freed memory kept for the next columns, up to 32 MB of it: by default every long column goes back to the
/// system, which clears its pages again.
const ENVIRONMENT: [(&str, &str); 3] = [
    ("OPENBLAS_NUM_THREADS", "1"),
    ("MALLOC_TRIM_THRESHOLD_", "33554432"),
    ("MALLOC_MMAP_THRESHOLD_", "33554432"),
];
/// Lines of a child that are kept for its obituary.
const LAST_LINES: usize = 4;
/// Characters of a line that are handed on.
const LONGEST_LINE: usize = 200;

/// A child; killed when dropped.
pub struct Child {
    stream: UnixStream,
    to_child: sync::Sender<ToChild>,
    events: mpsc::UnboundedReceiver<Event>,
    /// `None` for a thread of this process.
    process: Option<Arc<Mutex<std::process::Child>>>,
}

/// What a child does.
#[derive(Debug)]
pub enum Event {
    Notice(FromChild),
    Died(Death),
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq)]
pub enum Death {
    /// It ended by itself; how, and what it said last.
    Crashed { how: String, said: Option<String> },
    /// It was refused memory beyond its limit (bytes).
    Memory(u64),
    /// It did not end in the time it had.
    TooLong(Duration),
}

impl Death {
    /// As the user of `what` sees it.
    pub fn error(&self, what: &str) -> Error {
        match self {
            Death::Crashed { how, said } => {
                let said = said.as_ref().map(|s| format!(" ({s})")).unwrap_or_default();
                Error::new(Code::JobCrashed, format!("the process that did {what} ended: {how}{said}"))
                    .with_hint("nothing else is affected; please report it with the request and the logs")
            }
            Death::Memory(most) => {
                let detail = format!("{what} needs more than the {} MB of memory that it may take", most >> 20);
                Error::new(Code::MemoryLimit, detail)
                    .with_hint("send shorter logs, or at a lower rate; an operator of the server sets job_memory")
            }
            Death::TooLong(most) => {
                let detail = format!("{what} did not end within {} s", most.as_secs_f64());
                Error::new(Code::TimeLimit, detail)
                    .with_hint("ask for less at a time; for jobs an operator of the server sets job_time_s")
            }
        }
    }

    /// For metrics.
    pub fn reason(&self) -> &'static str {
        match self {
            Death::Crashed { .. } => "crash",
            Death::Memory(_) => "memory",
            Death::TooLong(_) => "time",
        }
    }
}

impl Child {
    /// # Errors
    /// No handles or no memory for another process, or no such program.
    pub fn start(limits: &Limits) -> io::Result<Self> {
        let (ours, theirs) = UnixStream::pair()?;
        let (log, said) = io::pipe()?;
        let reader = ours.try_clone()?;
        let writer = ours.try_clone()?;
        let process = match &limits.program {
            Some(program) => {
                let mut command = Command::new(program);
                command
                    .arg0("dynident")
                    .args(["child", "--memory", &limits.memory.to_string()])
                    .envs(ENVIRONMENT)
                    // It knows no more of the world than its task.
                    .env_remove("DATABASE_URL")
                    .stdin(Stdio::from(OwnedFd::from(theirs)))
                    .stdout(Stdio::from(said.try_clone()?))
                    .stderr(Stdio::from(said))
                    // Ctrl-C at a terminal is for the server.
                    .process_group(0);
                Some(Arc::new(Mutex::new(command.spawn()?)))
            }
            None => {
                start_thread(move || inside::serve(theirs, false))?;
                None
            }
        };
        let (to_child, messages) = sync::channel();
        let (tell, events) = mpsc::unbounded_channel();
        let child = Self {
            stream: ours,
            to_child,
            events,
            process: process.clone(),
        };
        let last_words = start_thread(move || listen(log))?;
        start_thread(move || write(writer, &messages))?;
        let memory = limits.memory;
        start_thread(move || read(reader, process, last_words, memory, &tell))?;
        Ok(child)
    }

    pub fn begin(&mut self, task: Task) {
        self.tell(ToChild::Begin(Box::new(task)));
    }

    /// A child that is gone hears nothing, and its end is the next event.
    pub fn tell(&self, message: ToChild) {
        let _ = self.to_child.send(message);
    }

    /// The next that it does; for ever its death once it is dead.
    pub async fn event(&mut self) -> Event {
        let gone = || Event::Died(crashed("it is gone".into(), None));
        self.events.recv().await.unwrap_or_else(gone)
    }

    /// Whether it can be given another task.
    pub fn is_alive(&mut self) -> bool {
        // Without a task it says nothing: all that can have come is its death.
        matches!(self.events.try_recv(), Err(mpsc::error::TryRecvError::Empty))
    }

    /// Memory that it holds (bytes).
    pub fn memory(&self) -> Option<u64> {
        let id = self.process.as_ref().map(|p| lock(p).id())?;
        confine::held_by(id)
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        // The end for one in a thread; a process might be past listening.
        let _ = self.stream.shutdown(Shutdown::Both);
        if let Some(process) = &self.process {
            let _ = lock(process).kill();
        }
    }
}

fn start_thread<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> io::Result<JoinHandle<T>> {
    std::thread::Builder::new().spawn(work)
}

fn lock(process: &Mutex<std::process::Child>) -> std::sync::MutexGuard<'_, std::process::Child> {
    process.lock().unwrap_or_else(PoisonError::into_inner)
}

fn write(mut stream: UnixStream, messages: &sync::Receiver<ToChild>) {
    while let Ok(message) = messages.recv() {
        if send(&mut stream, &message).is_err() {
            return;
        }
    }
}

/// Hands on what it says until the end, and then how it ended.
fn read(
    stream: UnixStream,
    process: Option<Arc<Mutex<std::process::Child>>>,
    last_words: JoinHandle<VecDeque<String>>,
    memory: u64,
    tell: &mpsc::UnboundedSender<Event>,
) {
    let mut stream = BufReader::new(stream);
    while let Ok(message) = receive(&mut stream) {
        if tell.send(Event::Notice(message)).is_err() {
            break;
        }
    }
    // Its end of the socket is closed when it has ended, or it says what is no message: the signal changes nothing for one that
    // is dead.
    let status = process.map(|process| {
        let mut process = lock(&process);
        let _ = process.kill();
        process.wait()
    });
    let last_words = last_words.join().unwrap_or_default();
    // Nobody waits for a child that was dropped.
    let _ = tell.send(Event::Died(death(status, &last_words, memory)));
}

/// Hands what a child says to the log; its last lines at its end.
fn listen(log: PipeReader) -> VecDeque<String> {
    let mut last = VecDeque::new();
    for line in BufReader::new(log)
        .lines()
        .map_while(Result::ok)
        .filter(|l| !l.trim().is_empty())
    {
        tracing::warn!(line, "a child says");
        if says_why(&line) {
            last.push_back(line.chars().take(LONGEST_LINE).collect());
        }
        if last.len() > LAST_LINES {
            last.pop_front();
        }
    }
    last
}

/// Whether a line stands for itself: those of a backtrace would push out what led to it.
fn says_why(line: &str) -> bool {
    !line.starts_with([' ', '\t']) && !line.starts_with("note:") && line != "stack backtrace:"
}

fn death(status: Option<io::Result<ExitStatus>>, said: &VecDeque<String>, memory: u64) -> Death {
    // What the allocators of Rust and C++ say before they give up.
    let refused = |line: &String| line.contains("memory allocation of") || line.contains("bad_alloc");
    if said.iter().any(refused) {
        return Death::Memory(memory);
    }
    let how = match status {
        Some(Ok(status)) => match (status.signal(), status.code()) {
            (Some(9), _) => "it was killed, which is what the system does when memory runs out".to_string(),
            (Some(signal), _) => format!("signal {signal}"),
            (None, code) => format!("exit status {}", code.unwrap_or_default()),
        },
        _ => "it is gone".to_string(),
    };
    // The C library or Rust's runtime have explained an abort just before it.
    crashed(how, said.back().cloned())
}

fn crashed(how: String, said: Option<String>) -> Death {
    Death::Crashed { how, said }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(text: &str) -> Death {
        let (reader, mut writer) = io::pipe().unwrap();
        io::Write::write_all(&mut writer, text.as_bytes()).unwrap();
        drop(writer);
        death(None, &listen(reader), 1 << 30)
    }

    #[test]
    fn what_a_child_said_last_tells_why_it_died_whatever_backtrace_follows() {
        let frames: String = (0..20).map(|i| format!("  {i:2}: dynident::formats::logs\n")).collect();
        let note = "note: Some details are omitted, run with `RUST_BACKTRACE=full` for a verbose backtrace.";
        let backtrace = format!("stack backtrace:\n{frames}{note}\n");
        let refused = heard(&format!("memory allocation of 100000000000001 bytes failed\n{backtrace}"));
        assert_eq!(refused, Death::Memory(1 << 30));
        assert_eq!(refused.error("the job").code, Code::MemoryLimit);
        let overflow = "thread '<unnamed>' (1) has overflowed its stack\nfatal runtime error: stack overflow, aborting";
        let Death::Crashed { said, .. } = heard(&format!("{overflow}\n{backtrace}")) else {
            panic!("a stack is not the memory limit");
        };
        assert_eq!(said.as_deref(), Some("fatal runtime error: stack overflow, aborting"));
    }
}
