//! `/excitation`: design a trajectory, hand it out.

use super::common::{Begun, WaitHeader, WorkHeaders};
use super::jobs::JobDocument;
use super::query::QueryFields;
use super::results::{answer, begin, document, find};
use crate::app::{Code, Error, ProblemDetails, Runs};
use crate::documents::DesignDocument;
use crate::documents::requests;
use crate::excitation::{Backoff, LONGEST_RUN_IN_S};
use crate::formats::{Parts, TrajectoryFile, TrajectoryFormat};
use crate::service::access::Access;
use crate::service::blocking::read_stored;
use crate::service::child::{REQUEST, Series, Task};
use crate::service::design::Motion;
use crate::service::document::JsonBody;
use crate::service::prefer::PreferWait;
use crate::service::problem::{Failure, internal_error};
use crate::service::state::Service;
use crate::service::store::{JobRow, sha256};
use crate::service::submit::Asked;
use crate::service::work::{Input, JobKind};
use crate::trajectory::{FourierSeries, Trajectory};
use axum::body::Body;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream::{StreamExt, unfold};
use serde::Serialize;

/// The result of a design, under the id of its job.
#[derive(Serialize, utoipa::ToSchema)]
pub struct Excitation {
    /// ID of the job.
    pub id: String,
    /// The design.
    #[serde(flatten)]
    pub result: DesignDocument,
}

/// Design an excitation trajectory.
///
/// Answers 202 with the job, whose address is in `Location`; with `Prefer: wait=N` 200 and the result if that comes within N
/// seconds. An infeasible problem is an outcome in the result, not an error. `Idempotency-Key` makes a retry safe: the same key
/// with the same document is the same job.
#[utoipa::path(
    post, path = "/excitation", tag = "excitation", operation_id = "design_excitation",
    request_body(content = requests::ExcitationRequest, content_type = "application/json"),
    params(WorkHeaders),
    responses(
        (status = 200, description = "The result, with `Prefer: wait`", body = Excitation),
        Begun,
        (status = 400, description = "No JSON document", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 413, description = "Document too large", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 415, description = "Not application/json", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 422, description = "Bad fields, all of them", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn post(
    State(service): State<Service>,
    access: Access,
    wait: PreferWait,
    headers: HeaderMap,
    body: JsonBody,
) -> Result<Response, Failure> {
    let asked = Asked {
        kind: JobKind::Excitation,
        body: sha256(&body.bytes),
        parsed: body.parsed,
        logs: Vec::new(),
        validation: Vec::new(),
    };
    begin(&service, &access, &headers, wait, asked).await
}

/// The result of a design.
///
/// While the search goes on, 202 with the job; `Prefer: wait=N` waits for the result as in the POST.
#[utoipa::path(
    get, path = "/excitation/{id}", tag = "excitation", operation_id = "get_excitation",
    params(
        ("id" = String, Path, description = "Id of the job"),
        WaitHeader,
    ),
    responses(
        (status = 200, description = "The result", body = Excitation),
        (status = 202, description = "The job, which goes on", body = JobDocument),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "Cancelled before it began", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn get(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    wait: PreferWait,
) -> Result<Response, Failure> {
    let job = find(&service, &access, &id, JobKind::Excitation).await?;
    answer(&service, job, wait).await
}

/// The trajectory, sampled.
///
/// CSV has the columns `time, q1 … qn, qd1 … qdn, qdd1 … qddn` (s; rad or m and per second), numbers with ten decimals at most;
/// `periods` periods and the sample after them, with which the motion is back where it began.
#[utoipa::path(
    get, path = "/excitation/{id}/trajectory", tag = "excitation", operation_id = "get_trajectory",
    params(
        ("id" = String, Path, description = "Id of the job"),
        ("format" = inline(Option<requests::TrajectoryFormat>), Query, description = "`csv` (default), `json` (the same table), `joint_trajectory` \
            (trajectory_msgs/msg/JointTrajectory as JSON), `yaml` (goal of control_msgs/action/FollowJointTrajectory), `urscript` (servoj, six joints), \
            `mcap` (sensor_msgs/msg/JointState) or `npz` (time, q, qd, qdd)"),
        ("rate_hz" = Option<f64>, Query, description = "Samples per second; that of the request if left out", maximum = 1000000),
        ("periods" = Option<usize>, Query, description = "Periods, 1 if left out", minimum = 1),
        ("index" = Option<usize>, Query, description = "Which of several trajectories that complement each other, from 0"),
        ("backoff" = Option<f64>, Query, description = "For a first run: factor on the amplitudes around where the motion starts, above 0 to 1. Limits that \
            bind several joints are looked at again; where one does not hold, the amplitudes are smaller than asked for", maximum = 1),
        ("from" = Option<String>, Query, description = "Pose at rest before and after the motion: positions of the joints (rad or m), comma-separated; where the motion begins if left out"),
        ("run_in_s" = Option<f64>, Query, description = "Duration of the way from that pose into the motion (s), within all limits of the design; 0 for none. With `from` chosen if left out",
            minimum = 0, maximum = 120),
        ("run_out_s" = Option<f64>, Query, description = "Duration of the way out of the motion to that pose, likewise", minimum = 0, maximum = 120),
        ("slow" = Option<f64>, Query, description = "For a first run: factor on the time that the motion takes, at least 1", minimum = 1, maximum = 100),
    ),
    responses(
        (status = 200, description = "The samples", content((String = "text/csv"), (Object = "application/json"),
            (String = "application/yaml"), (String = "text/plain"), (String = "application/octet-stream"))),
        (status = 400, description = "Bad query", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 404, description = "Unknown id", body = ProblemDetails, content_type = "application/problem+json"),
        (status = 409, description = "No trajectory: not finished, cancelled early, or infeasible; no way into it within the limits", body = ProblemDetails,
            content_type = "application/problem+json"),
        (status = 422, description = "A pose that the robot cannot take", body = ProblemDetails, content_type = "application/problem+json"),
    )
)]
pub async fn trajectory(
    State(service): State<Service>,
    access: Access,
    Path(id): Path<String>,
    mut query: QueryFields,
) -> Result<Response, Failure> {
    let job = find(&service, &access, &id, JobKind::Excitation).await?;
    let (motion, rate_hz) = motion_of(&service, &job).await?;
    let joints = motion.joints.clone();
    let most = motion.count();
    let index = query.take(
        "index",
        0,
        &format!("a whole number below {most}, the trajectories of this design"),
        |t| t.parse().ok().filter(|i: &usize| *i < most.max(1)),
    );
    let backoff = Backoff {
        amplitude: query.take("backoff", 1.0, "a number above 0 and at most 1", |t| {
            t.parse().ok().filter(|f: &f64| *f > 0.0 && *f <= 1.0)
        }),
        slowness: query.take("slow", 1.0, "a number from 1 to 100", |t| {
            t.parse().ok().filter(|f: &f64| (1.0..=100.0).contains(f))
        }),
    };
    let series = motion.series_at(index).ok_or_else(no_trajectory)?;
    let series = first_run_of(&service, &job, series, backoff).await?;
    let format = query.take(
        "format",
        TrajectoryFormat::Csv,
        "csv, json, joint_trajectory, yaml, urscript, mcap or npz",
        |text| TrajectoryFormat::ALL.iter().find(|(name, _)| *name == text).map(|(_, f)| *f),
    );
    // A rate below two samples a period or above a megahertz is a mistake in the unit.
    let rates = 2.0 * series.fundamental_hz..=1e6;
    let rate_hz = query.take("rate_hz", rate_hz, "a number of samples per second", |t| {
        t.parse().ok().filter(|r: &f64| rates.contains(r))
    });
    let duration = |t: &str| {
        t.parse()
            .ok()
            .filter(|s: &f64| (0.0..=LONGEST_RUN_IN_S).contains(s))
            .map(Some)
    };
    let [run_in_s, run_out_s] =
        ["run_in_s", "run_out_s"].map(|name| query.take(name, None, &format!("seconds from 0 to {LONGEST_RUN_IN_S}"), duration));
    let from = query.take("from", None, "positions of the joints, comma-separated", |t| {
        let read: Option<Vec<f64>> = t
            .split(',')
            .map(|v| v.trim().parse().ok().filter(|q: &f64| q.is_finite()))
            .collect();
        read.map(Some)
    });
    let runs = Runs {
        from,
        run_in_s,
        run_out_s,
    };
    let most = format.most_rows(joints.len()) as f64;
    let periods = query.take(
        "periods",
        1,
        &format!("a whole number of periods with at most {most} rows in all"),
        |t| {
            t.parse()
                .ok()
                .filter(|p: &usize| *p >= 1 && *p as f64 * series.duration() * rate_hz <= most)
        },
    );
    query.finish()?;
    let [run_in, run_out] = runs_of(&service, &job, &series, runs, rate_hz).await?;
    let (content_type, ending) = format.kind();
    // Some formats are made as a whole.
    let write = move || {
        let file = TrajectoryFile {
            joints: &joints,
            series: &series,
            rate_hz,
            periods,
            run_in,
            run_out,
        };
        file.parts(format)
    };
    let parts = tokio::task::spawn_blocking(write).await.map_err(|_| internal_error())?;
    let parts = parts.map_err(|why| Failure(Error::new(Code::InvalidQuery, format!("the format {why}"))))?;
    let headers = [
        (header::CONTENT_TYPE, content_type.to_string()),
        (
            header::CONTENT_DISPOSITION,
            format!("attachment; filename=\"excitation-{id}.{ending}\""),
        ),
    ];
    Ok((headers, streamed(parts)).into_response())
}

fn streamed(parts: Parts) -> Body {
    let parts = unfold(Some(parts), |rest| async {
        let mut rest = rest?;
        let next = tokio::task::spawn_blocking(move || (rest.next(), rest)).await;
        match next {
            Ok((part, rest)) => part.map(|part| (Ok(part), Some(rest))),
            // The client sees a body that is cut off, not one that merely ends.
            Err(panic) => Some((Err(std::io::Error::other(panic)), None)),
        }
    });
    // The compressor asks once more after the end, where an unfolded stream that is not fused panics.
    Body::from_stream(parts.fuse())
}

fn no_trajectory() -> Failure {
    Failure(Error::new(
        Code::NoTrajectory,
        "the search ended without a trajectory; its result says why",
    ))
}

/// The trajectory as a first run, within the limits of its request.
async fn first_run_of(
    service: &Service,
    job: &JobRow,
    series: FourierSeries,
    backoff: Backoff,
) -> Result<FourierSeries, Failure> {
    if backoff.amplitude == 1.0 && backoff.slowness == 1.0 {
        return Ok(series);
    }
    let file = job.input.as_ref().ok_or_else(internal_error)?;
    let input: Input = read_stored(service.files().read(file).await?).await?;
    let task = Task::FirstRun {
        input,
        series: series.into(),
        amplitude: backoff.amplitude,
        slowness: backoff.slowness,
    };
    let run: Option<Series> = service.compute_document(task, REQUEST).await?;
    let none = || Error::new(Code::NoTrajectory, "no part of this motion keeps every limit along the path");
    Ok(run.ok_or_else(none)?.into())
}

/// The ways into the motion and out of it, within the limits of its request.
async fn runs_of(
    service: &Service,
    job: &JobRow,
    series: &FourierSeries,
    runs: Runs,
    rate_hz: f64,
) -> Result<[Option<FourierSeries>; 2], Failure> {
    if runs.is_none() {
        return Ok([None, None]);
    }
    let file = job.input.as_ref().ok_or_else(internal_error)?;
    let input: Input = read_stored(service.files().read(file).await?).await?;
    let task = Task::Runs {
        input,
        series: series.clone().into(),
        runs,
        rate_hz,
    };
    let ways: [Option<Series>; 2] = service.compute_document(task, REQUEST).await?;
    Ok(ways.map(|way| way.map(FourierSeries::from)))
}

async fn motion_of(service: &Service, job: &JobRow) -> Result<(Motion, f64), Failure> {
    if !job.state.is_final() {
        let error = Error::new(Code::NoTrajectory, "the search goes on")
            .with_hint("follow /jobs/{id}/events, or DELETE /jobs/{id} to keep the best found");
        return Err(Failure(error));
    }
    let motion: Motion = read_stored(document(service, job).await?).await?;
    let rate_hz = motion.sample_rate_hz;
    if motion.count() == 0 {
        return Err(no_trajectory());
    }
    Ok((motion, rate_hz))
}
