//! Logs as laboratories have them: other headers, several files, periods known by name, motions that say too little.

use crate::identify::{log, log_at, post};
use crate::server::Server;
use dynident::documents::{NamedRobots, shipped::Shipped};
use dynident::dynamics::{Chain, Coulomb, inverse_dynamics_batch};
use dynident::parameters::{BaseParameters, Layout};
use dynident::trajectory::{FourierSeries, Trajectory};
use nalgebra::DMatrix;
use serde_json::{Value, json};

const ARM: &str = "planar_two_link";

fn identified(server: &Server, request: Value, logs: &[(&str, &str)]) -> Value {
    let request = request.to_string();
    let mut parts = vec![("request", "", request.as_str())];
    parts.extend(logs.iter().map(|(name, text)| ("log", *name, *text)));
    let answer = post(server, "/identify", true, &parts);
    assert_eq!(answer.status, 200, "{}", answer.text);
    answer.json()
}

fn values(found: &Value, key: &str) -> Vec<f64> {
    let parameters = found["base_parameters"].as_array().unwrap();
    parameters.iter().map(|p| p[key].as_f64().unwrap_or(f64::INFINITY)).collect()
}

fn choice<'a>(found: &'a Value, log: usize, what: &str) -> &'a Value {
    let choices = found["log_report"][log]["choices"].as_array().unwrap();
    choices
        .iter()
        .find(|c| c["what"] == what)
        .unwrap_or_else(|| panic!("{what} in {choices:?}"))
}

/// Rows of a log, header first, as fields.
fn fields(text: &str) -> Vec<Vec<String>> {
    text.lines()
        .map(|line| line.split(',').map(str::to_string).collect())
        .collect()
}

fn text(rows: &[Vec<String>]) -> String {
    rows.iter().map(|row| row.join(",") + "\n").collect()
}

/// The excitation's id alone tells the period: a log of one period and a half holds none that repeats, so that nothing else
/// could.
#[test]
fn the_period_comes_from_the_excitations_id() {
    let server = Server::start();
    let fourier = json!({"order": 3, "fundamental_hz": 0.2});
    let request = json!({"robot": ARM, "fourier": fourier, "sample_rate_hz": 100, "search": {"max_evaluations": 40}});
    let design = server.send(
        "POST",
        "/excitation",
        &[("prefer", "wait=60"), ("content-type", "application/json")],
        &request.to_string(),
    );
    assert_eq!(design.status, 200, "{}", design.text);
    let id = design.json()["id"].as_str().unwrap().to_string();
    let rows = fields(&log(0.3));
    let short = text(&rows[..751]);
    let without = identified(&server, json!({"robot": ARM, "trace": false}), &[("run.csv", &short)]);
    assert_eq!(choice(&without, 0, "period")["value"], "none");
    let found = identified(
        &server,
        json!({"robot": ARM, "trace": false, "excitation": id}),
        &[("run.csv", &short)],
    );
    assert_eq!(choice(&found, 0, "period")["value"], "5.000000 s");
    assert!(
        choice(&found, 0, "averaging")["value"]
            .as_str()
            .unwrap()
            .starts_with("1 periods of 500 samples")
    );
    let unknown = json!({"robot": ARM, "excitation": "nothing"}).to_string();
    let answer = post(
        &server,
        "/identify",
        true,
        &[("request", "", &unknown), ("log", "run.csv", &short)],
    );
    assert!(answer.errors()[0].starts_with("/excitation"), "{}", answer.text);
}

/// The same rows under other headers, in other units, with another sign, an offset, and joints that are driven through each
/// other.
#[test]
fn columns_turn_a_laboratorys_file_into_the_robots_own_quantities() {
    let server = Server::start();
    let plain = identified(
        &server,
        json!({"robot": ARM, "trace": false, "period_s": 5}),
        &[("run.csv", &log(0.3))],
    );
    let mut rows = fields(&log(0.3));
    rows[0] = ["stamp", "motor 2", "motor 1", "i1", "i2"].map(str::to_string).to_vec();
    for row in &mut rows[1..] {
        let number: Vec<f64> = row.iter().map(|v| v.parse().unwrap()).collect();
        let [time, q1, q2, tau1, tau2] = number[..] else {
            panic!("five fields")
        };
        // Motor 2 turns by q1 + q2, so its torque acts on both joints: tau1 = m1 + m2, tau2 = m2.
        let (motor1, motor2) = (q1, q1 + q2);
        let (drive1, drive2) = (tau1 - tau2, tau2);
        *row = [
            (1000.0 * time).to_string(),
            motor2.to_degrees().to_string(),
            (motor1.to_degrees() + 30.0).to_string(),
            (-drive1 / 2.5).to_string(),
            (drive2 / 0.5).to_string(),
        ]
        .to_vec();
    }
    let columns = json!({
        "time": "stamp", "time_unit": "ms",
        "position": {"headers": ["motor 1", "motor 2"], "unit": "deg", "offset": [-30f64.to_radians(), 30f64.to_radians()],
            "matrix": [[1, 0], [-1, 1]]},
        "torque": {"headers": ["i1", "i2"], "unit": "A", "scale": [2.5, 0.5], "sign": [-1, 1], "matrix": [[1, 1], [0, 1]]},
    });
    let mapped = identified(
        &server,
        json!({"robot": ARM, "trace": false, "period_s": 5, "columns": columns}),
        &[("run.csv", &text(&rows))],
    );
    // The text holds all digits of a double, but the way there and back rounds; the condition of the data multiplies that.
    for (a, b) in values(&plain, "value").iter().zip(values(&mapped, "value")) {
        assert!((a - b).abs() < 1e-9 * a.abs().max(1.0), "{a} {b}");
    }
    for (a, b) in values(&plain, "std_dev").iter().zip(values(&mapped, "std_dev")) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
}

/// Two logs together know more than either: information adds up.
#[test]
fn two_logs_make_one_identification() {
    let server = Server::start();
    let request = json!({"robot": ARM, "trace": false, "period_s": 5, "estimator": "wls"});
    let (one, other) = (log(0.3), log(2.0));
    let alone: Vec<Value> = [("a.csv", one.as_str()), ("b.csv", other.as_str())]
        .iter()
        .map(|log| identified(&server, request.clone(), &[*log]))
        .collect();
    let both = identified(&server, request, &[("a.csv", &one), ("b.csv", &other)]);
    assert_eq!(both["log_report"].as_array().unwrap().len(), 2);
    assert_eq!(both["rms"]["identification"].as_array().unwrap().len(), 2);
    let robot = Shipped.named(ARM).unwrap().robot;
    let base = BaseParameters::exact(&robot);
    let (value, deviation) = (values(&both, "value"), values(&both, "std_dev"));
    let apart: Vec<Vec<f64>> = alone.iter().map(|found| values(found, "std_dev")).collect();
    for c in 0..base.len() {
        // More information never makes a parameter less certain; the noise is estimated anew from twice the rows, which scatters
        // by 3 %.
        let least = apart.iter().map(|d| d[c]).fold(f64::INFINITY, f64::min);
        assert!(deviation[c] < 1.1 * least, "{} {} {least}", base.names[c], deviation[c]);
        assert!(deviation[c] > 0.0 && value[c].is_finite());
    }
}

/// Three periods of a small slow swing of the arm, with the noise of the other logs.
fn poor(second_joint: f64) -> String {
    let robot = Shipped.named(ARM).unwrap().robot;
    let layout = Layout::standard(&robot);
    let series = FourierSeries {
        fundamental_hz: 0.2,
        a: DMatrix::from_fn(2, 2, |j, l| [0.03, second_joint][j] / (l + 1) as f64),
        b: DMatrix::from_fn(2, 2, |j, l| [0.015, -second_joint][j] / (l + 1) as f64),
        offset: vec![0.1, 0.3],
    };
    let motion = series.sample(100.0);
    let truth = crate::identify::truth(&layout);
    let tau = inverse_dynamics_batch(&Chain::new(&robot), &layout, &truth, &motion, Coulomb::Sign);
    let mut rows = vec![["time", "q1", "q2", "tau1", "tau2"].map(str::to_string).to_vec()];
    rows.extend((0..1500).map(|s| {
        // White: of a single tone, which is what the sine of a multiple of the time is, whitening leaves nothing.
        let hash = |j: usize| {
            ((s * 2 + j) as u64)
                .wrapping_mul(0x9e37_79b9_7f4a_7c15)
                .rotate_left(29)
                .wrapping_mul(0xbf58_476d_1ce4_e5b9)
        };
        let noise = |j: usize| 0.01 * ((hash(j) >> 32) as f64 / f64::from(u32::MAX) * 2.0 - 1.0);
        let (q, t) = (
            |j: usize| motion.positions(j)[s % 500],
            |j: usize| tau[j * motion.stride() + s % 500] + noise(j),
        );
        [s as f64 / 100.0, q(0), q(1), t(0), t(1)].map(|v| v.to_string()).to_vec()
    }));
    text(&rows)
}

#[test]
fn a_log_that_says_too_little_is_flagged_before_anybody_uses_it() {
    let server = Server::start();
    let request = json!({"robot": ARM, "period_s": 5});
    // Both joints move, but by two degrees: the parameters fit this path and no other.
    let small = identified(&server, request.clone(), &[("small.csv", &poor(0.03))]);
    assert_eq!(small["quality"]["verdict"], "poor_excitation", "{}", small["quality"]);
    assert!(
        small["quality"]["reason"]
            .as_str()
            .unwrap()
            .contains("record a richer excitation")
    );
    // The second joint stands still: its own friction is not there to be seen.
    let still = identified(&server, request, &[("still.csv", &poor(0.0))]);
    assert_eq!(still["quality"]["verdict"], "unidentifiable", "{}", still["quality"]);
    let friction = |name: &str| {
        let found = still["base_parameters"].as_array().unwrap();
        found.iter().find(|p| p["name"] == name).unwrap()["std_dev"].clone()
    };
    for name in ["FV2", "FS2"] {
        assert!(
            friction(name).as_f64().is_none_or(f64::is_infinite),
            "{name}: {}",
            friction(name)
        );
        assert!(still["quality"]["reason"].as_str().unwrap().contains(name));
    }
}

/// Every decision is in the answer with its reason, those of the default and those of the request.
#[test]
fn every_choice_is_explained() {
    let server = Server::start();
    let what = [
        "period",
        "averaging",
        "derivatives",
        "row_filter",
        "edges",
        "decimation",
        "dead_zone",
    ];
    let found = identified(&server, json!({"robot": ARM, "trace": false}), &[("run.csv", &log(0.3))]);
    for what in what {
        assert!(choice(&found, 0, what)["why"].as_str().unwrap().len() > 10, "{what}");
    }
    let asked = json!({"robot": ARM, "trace": false, "period_s": 5, "preprocess": {
        "method": "paper", "position_filter": {"order": 4, "cutoff_hz": 3}, "torque_filter": {"order": 6, "cutoff_hz": 2},
        "discard_edges_s": 0.5, "decimation": 3, "dead_zone": 0.01}});
    let found = identified(&server, asked, &[("run.csv", &log(0.3))]);
    for (what, value) in [
        ("period", "5.000000 s"),
        ("derivatives", "order 4"),
        ("row_filter", "order 6"),
        ("edges", "0.500 s"),
        ("decimation", "3"),
        ("dead_zone", "1.00e-2"),
    ] {
        let said = choice(&found, 0, what);
        assert!(said["value"].as_str().unwrap().contains(value), "{what}: {said}");
        assert_eq!(said["why"], "given", "{what}");
    }
}

/// Rates of controllers, with periods and without, drawn over HTTP: series of the length that was asked for, and a report.
#[test]
fn logs_of_every_rate_have_series_to_draw_and_a_report() {
    let server = Server::start();
    for (rate, periods) in [100, 200, 500, 1000].into_iter().flat_map(|rate| [(rate, 3.0), (rate, 1.4)]) {
        let text = log_at(0.3, f64::from(rate), periods);
        let found = identified(
            &server,
            json!({"robot": ARM, "prediction_points": 1500}),
            &[("run.csv", &text)],
        );
        let series = found["predictions"].as_array().unwrap();
        assert_eq!(
            series.len(),
            2,
            "{rate} Hz, {periods} periods: {}",
            found["predictions_error"]
        );
        for one in series {
            let points = one["time"].as_array().unwrap().len();
            assert!(points > 100, "{rate} Hz, {periods} periods: {points}");
            for model in ["measured", "base", "physical", "declared"] {
                assert_eq!(one[model].as_array().map(Vec::len), Some(points), "{model}");
            }
        }
        let report = server.get(&format!("/identify/{}/report", found["id"].as_str().unwrap()));
        assert_eq!(report.status, 200, "{rate} Hz, {periods} periods");
        assert!(report.text.contains("Measured and predicted torque"));
    }
}
