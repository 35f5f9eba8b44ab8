//! What happens in a child.

use super::confine::confine;
use super::fault;
use super::message::{
    Advance, Document, FromChild, JobTask, Latest, Named, RobotRead, Series, Spot, Task, ToChild, receive, send,
};
use crate::app::{CancelFlag, Code, Error, Exchange, LogFile, inspect, motion, runs};
use crate::documents::{
    BaseParametersDocument, RobotDocument, catalogue_effect, read_identify_request, read_motion_request, robot_document_of,
};
use crate::excitation::{Backoff, Found, Point, first_run};
use crate::formats::logs::log_overview;
use crate::formats::{Parsed, robot_archive};
use crate::service::blocking::ended;
use crate::service::known::Known;
use crate::service::problem::internal_error;
use crate::service::progress::News;
use crate::service::work::{JobKind, JobOutcome, Measure, Notice, Request};
use crate::service::{rows, spread, submit::stored_error};
use crate::web::{Circumstances, report};
use serde::Serialize;
use std::io::{self, BufReader};
use std::os::fd::AsFd;
use std::os::unix::net::UnixStream;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Searches step back behind everything else on the machine: what is asked for meanwhile gets the processor first.
const NICE: i32 = 10;
/// How often news are handed on.
const NEWS: Duration = Duration::from_millis(100);
/// How long a search waits for what others have found, a little longer than the server may take to find out.
const LISTENING: Duration = Duration::from_millis(1500);

/// The program `dynident child`: does what comes through its standard input, a socket, until that is closed.
///
/// # Errors
/// Standard input is none.
pub fn main(memory: u64) -> Result<(), Error> {
    confine(memory);
    let failed = |e: io::Error| Error::new(Code::Internal, format!("a child needs a socket as its standard input: {e}"));
    let stream = io::stdin()
        .as_fd()
        .try_clone_to_owned()
        .map(UnixStream::from)
        .map_err(failed)?;
    // The common threads start here, where nothing has stepped back yet.
    let _ = rayon::ThreadPoolBuilder::new().build_global();
    serve(stream, true);
    Ok(())
}

/// Does the tasks that come, one after the other. `alone` in its process it ends that at once when nobody is there any more to do
/// it for.
pub fn serve(stream: UnixStream, alone: bool) {
    let Ok(reader) = stream.try_clone() else { return };
    let mut reader = BufReader::new(reader);
    let line = Line(Arc::new(Mutex::new(stream)));
    let mut running: Option<Running> = None;
    while let Ok(message) = receive(&mut reader) {
        match message {
            ToChild::Begin(task) => running = begin(*task, &line),
            ToChild::Cancel => running.iter().for_each(|work| work.cancel.cancel()),
            // Work that is over listens no more.
            ToChild::Others(points) => drop(running.as_ref().map(|work| work.others.send(points))),
        }
    }
    let Some(work) = running.filter(|work| !work.thread.is_finished()) else {
        return;
    };
    work.cancel.cancel();
    if alone {
        // Not by `exit`, which would take things down around threads that work on.
        let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
    }
}

/// A task that is being done.
struct Running {
    cancel: CancelFlag,
    others: Sender<Vec<Spot>>,
    thread: std::thread::JoinHandle<()>,
}

/// Starts a task on a thread of its own.
fn begin(task: Task, line: &Line) -> Option<Running> {
    let cancel = CancelFlag::default();
    let (others, heard) = channel();
    let (own, flag) = (line.clone(), cancel.clone());
    let work = move || {
        let done = catch_unwind(AssertUnwindSafe(|| perform(task, &own, &flag, heard)));
        let failed = |error: &Error| FromChild::Failed(stored_error(error));
        own.say(&match done {
            Ok(Ok(answer)) => answer,
            Ok(Err(error)) => failed(&error),
            Err(_) => failed(&internal_error()),
        });
    };
    match std::thread::Builder::new().spawn(work) {
        Ok(thread) => Some(Running { cancel, others, thread }),
        Err(e) => {
            let error = Error::new(Code::TooManyJobs, format!("no thread can be started for the work: {e}"));
            line.say(&FromChild::Failed(stored_error(&error)));
            None
        }
    }
}

/// The way back to the server. Clones share.
#[derive(Clone)]
struct Line(Arc<Mutex<UnixStream>>);

impl Line {
    fn say(&self, message: &FromChild) {
        let mut stream = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        // A server that is gone hears nothing; the reader of the other direction ends this process.
        let _ = send(&mut *stream, message);
    }
}

fn perform(task: Task, line: &Line, cancel: &CancelFlag, heard: Receiver<Vec<Spot>>) -> Result<FromChild, Error> {
    match task {
        Task::Job(task) => job(*task, line, cancel, heard).map(FromChild::Done),
        Task::Check { kind, document, known } => {
            let (parsed, known) = (Parsed::from(document), Known::from(known));
            answer(&Measure::for_request(&Request::read(kind, &parsed, &known)?))
        }
        Task::Motion { document, known } => {
            let (parsed, known) = (Parsed::from(document), Known::from(known));
            let request = read_motion_request(&parsed, &known).map_err(|e| Error::invalid("the motion request", e))?;
            answer(&motion(&request, cancel).ok_or_else(ended)?)
        }
        Task::Preview {
            document,
            known,
            logs,
            validation,
            most_rows,
        } => preview(document, known, (files(logs), files(validation)), most_rows, cancel),
        Task::Columns { log } => {
            let log = LogFile::from(log);
            let overview = log_overview(&log.path, &log.name).map_err(|e| Error::new(Code::InvalidLog, e.to_string()))?;
            answer(&overview)
        }
        Task::Robot { document, known } => answer(&RobotRead::from(robot(document, known)?)),
        Task::Effect { document } => {
            let read = catalogue_effect(&document.into()).map_err(|e| Error::invalid("the effect", e))?;
            answer(&read)
        }
        Task::RobotArchive { bytes } => answer(&robot_archive(&bytes)?),
        Task::BaseParameters { document, known } => answer(&BaseParametersDocument::for_robot(&robot(document, known)?.robot)),
        Task::Report {
            result,
            id,
            ended,
            design,
        } => {
            let result = serde_json::from_slice(&result).map_err(|_| internal_error())?;
            let id = Some(id);
            let page = report(&result, &Circumstances { id, ended, design });
            Ok(FromChild::Answer(page.into_bytes()))
        }
        Task::Runs {
            input,
            series,
            runs: asked,
            rate_hz,
        } => {
            let ways = match Request::from_input(JobKind::Excitation, &input)? {
                Request::Excite(request) => runs(&request.problem, &series.into(), &asked, rate_hz)?,
                Request::Identify(_) | Request::Validate(_) => [None, None],
            };
            answer(&ways.map(|way| way.map(Series::from)))
        }
        Task::FirstRun {
            input,
            series,
            amplitude,
            slowness,
        } => {
            let run = match Request::from_input(JobKind::Excitation, &input)? {
                Request::Excite(request) => first_run(&request.problem, &series.into(), Backoff { amplitude, slowness }),
                Request::Identify(_) | Request::Validate(_) => None,
            };
            answer(&run.map(|run| Series::from(run.series)))
        }
    }
}

fn answer(document: &impl Serialize) -> Result<FromChild, Error> {
    Ok(FromChild::Answer(
        serde_json::to_vec(document).expect("documents are plain data"),
    ))
}

fn robot(document: Document, known: Named) -> Result<RobotDocument, Error> {
    robot_document_of(&document.into(), &Known::from(known)).map_err(|errors| Error::invalid("the robot", errors))
}

fn files(logs: Vec<super::message::Log>) -> Vec<LogFile> {
    logs.into_iter().map(LogFile::from).collect()
}

fn preview(
    document: Document,
    known: Named,
    (logs, held_out): (Vec<LogFile>, Vec<LogFile>),
    most_rows: usize,
    cancel: &CancelFlag,
) -> Result<FromChild, Error> {
    let (parsed, known) = (Parsed::from(document), Known::from(known));
    let request = read_identify_request(&parsed, &known, &known);
    let request = request.map_err(|e| Error::invalid("the identification request", e))?;
    logs.iter()
        .chain(&held_out)
        .try_for_each(|log| rows::check(log, most_rows, cancel))?;
    answer(&inspect(&request, &logs, &held_out, cancel)?.ok_or_else(ended)?)
}

fn job(task: JobTask, line: &Line, cancel: &CancelFlag, heard: Receiver<Vec<Spot>>) -> Result<JobOutcome, Error> {
    if task.nice {
        // Of this thread and those it starts; where it is not possible the work merely competes.
        let _ = rustix::process::setpriority_process(None, NICE);
    }
    let fault = fault::asked(&task);
    fault.iter().for_each(|fault| fault::before_work(fault));
    let mut request = Request::from_input(task.kind, &task.input)?;
    let shareable = spread::may_be_shared(&request, task.long);
    line.say(&FromChild::Begun {
        search_s: request.search_s(),
        shareable,
    });
    let mut before = Advance::default();
    if let Request::Excite(search) = &mut request
        && shareable
    {
        match task.share {
            Some(share) => spread::set_apart(search, share),
            None if task.advance.seconds > 0.0 || task.advance.evaluations > 0 => {
                before = task.advance;
                spread::go_on(search, before);
            }
            None => {}
        }
    }
    let (logs, validation) = (files(task.logs), files(task.validation));
    logs.iter()
        .chain(&validation)
        .try_for_each(|log| rows::check(log, task.most_rows, cancel))?;
    let desk = Desk {
        line,
        news: News::after(before),
        found: Mutex::default(),
        heard: Mutex::new(heard),
        begun: Instant::now(),
        fault,
    };
    desk.beside(|| {
        let exchange = shareable.then_some(&desk as &dyn Exchange);
        request.run(&logs, &validation, exchange, cancel, &|notice| desk.tell(notice))
    })
}

/// Where the threads of a job leave their news, and from where those are handed on.
struct Desk<'a> {
    line: &'a Line,
    news: News,
    /// What the search has found, and whether that has been handed on.
    found: Mutex<Option<(Latest, bool)>>,
    heard: Mutex<Receiver<Vec<Spot>>>,
    begun: Instant,
    fault: Option<String>,
}

impl Desk<'_> {
    /// Does `work`, and hands on its news meanwhile.
    fn beside<T>(&self, work: impl FnOnce() -> T) -> T {
        std::thread::scope(|scope| {
            let (working, over) = channel::<()>();
            scope.spawn(move || {
                while over.recv_timeout(NEWS) == Err(RecvTimeoutError::Timeout) {
                    self.hand_on();
                }
            });
            let done = work();
            drop(working);
            self.hand_on();
            done
        })
    }

    fn tell(&self, notice: Notice) {
        match notice {
            Notice::Result(outcome) => {
                self.line.say(&FromChild::Result(outcome));
                self.fault.iter().for_each(|fault| fault::before_drawing(fault));
            }
            notice => self.news.tell(notice, self.begun.elapsed()),
        }
    }

    fn hand_on(&self) {
        if let Some((found, handed_on)) = &mut *self.found.lock().unwrap_or_else(PoisonError::into_inner)
            && !*handed_on
        {
            self.line.say(&FromChild::Found(found.clone()));
            *handed_on = true;
        }
        let (progress, step) = self.news.take();
        if progress.is_some() || step.is_some() {
            self.line.say(&FromChild::News { progress, step });
        }
    }
}

impl Exchange for Desk<'_> {
    fn found(&self, found: &Found) {
        let (epochs, best) = (found.epochs, found.best());
        let mut latest = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        match &mut *latest {
            Some((known, handed_on)) if known.epochs == epochs && known.best == best => {
                known.evaluations = found.evaluations;
                *handed_on = false;
            }
            _ => {
                let points = found.points().into_iter().map(Spot::from).collect();
                let evaluations = found.evaluations;
                *latest = Some((
                    Latest {
                        epochs,
                        best,
                        points,
                        evaluations,
                    },
                    false,
                ));
            }
        }
    }

    fn others(&self) -> Vec<Point> {
        // What has just been found is known when others are asked: the server reads in order.
        self.hand_on();
        let heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        // An answer that came too late was to another question.
        heard.try_iter().for_each(drop);
        self.line.say(&FromChild::AskOthers);
        let answer = heard.recv_timeout(LISTENING).unwrap_or_default();
        answer.into_iter().map(Point::from).collect()
    }
}
