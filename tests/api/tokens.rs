//! Who may do what: a token of one robot, held against every address of the OpenAPI document.

use crate::server::{Answer, Server, quick_request};
use dynident::service::store::{Role, Store};
use dynident::service::{Config, new_token};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::time::Duration;

/// A server that asks for tokens, and its data folder.
struct Guarded {
    server: Server,
    folder: PathBuf,
}

impl Guarded {
    fn start(name: &str) -> Self {
        Self::with(name, Config::default())
    }

    fn with(name: &str, config: Config) -> Self {
        let folder = std::env::temp_dir().join(format!("dynident-tokens-{name}-{}", std::process::id()));
        let config = Config {
            data: Some(folder.clone()),
            tokens_required: true,
            ..config
        };
        let server = Server::with(config);
        // Its folder is there when it answers.
        assert_eq!(server.get("/health/live").status, 200);
        Self { server, folder }
    }

    fn in_store<T>(&self, work: impl AsyncFnOnce(Store) -> T) -> T {
        let runtime = tokio::runtime::Runtime::new().unwrap();
        runtime.block_on(async { work(Store::in_folder(&self.folder).await.unwrap()).await })
    }

    /// Id and secret.
    fn token(&self, role: Role, robots: &[&str]) -> (String, String) {
        self.lasting_token(role, robots, None)
    }

    fn lasting_token(&self, role: Role, robots: &[&str], valid: Option<Duration>) -> (String, String) {
        let (row, secret, hash) = new_token("test", role, robots.iter().map(|r| r.to_string()).collect(), valid);
        self.in_store(async |store| store.add_token(&row, &hash).await).unwrap();
        (row.id, secret)
    }

    fn send(&self, token: &str, method: &str, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let bearer = format!("Bearer {token}");
        let headers = [headers, &[("authorization", bearer.as_str())]].concat();
        self.server.send(method, path, &headers, body)
    }

    fn post(&self, token: &str, path: &str, body: &Value) -> Answer {
        let headers = [("content-type", "application/json"), ("prefer", "wait=60")];
        self.send(token, "POST", path, &headers, &body.to_string())
    }

    fn get(&self, token: &str, path: &str) -> Answer {
        self.send(token, "GET", path, &[], "")
    }

    /// Identifies or validates with a log that cannot be read: the job is there all the same.
    fn failed_job(&self, token: &str, path: &str, request: &Value) -> String {
        let answer = self.send(
            token,
            "POST",
            path,
            &[("content-type", "multipart/form-data; boundary=b")],
            &multipart(request),
        );
        assert_eq!(answer.status, 202, "{}", answer.text);
        answer.json()["id"].as_str().unwrap().to_string()
    }
}

impl Drop for Guarded {
    fn drop(&mut self) {
        self.server.stop();
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn multipart(request: &Value) -> String {
    multipart_of(request, "x")
}

fn multipart_of(request: &Value, log: &str) -> String {
    format!(
        "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{request}\r\n\
         --b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\n{log}\r\n--b--\r\n"
    )
}

fn arm(name: &str) -> Value {
    json!({"name": name, "joints": [{"name": "J1", "kind": "revolute", "mdh": {"alpha": 0, "d": 0, "theta": 0, "r": 0},
        "limits": {"position": [-2, 2], "velocity": 1, "acceleration": 5},
        "prior": {"mass": 1, "center_of_mass": [0.1, 0, 0], "inertia": {"xx": 0.1, "xy": 0, "xz": 0, "yy": 0.1, "yz": 0, "zz": 0.1}}}]})
}

/// Method and path of every operation, but those that ask nobody who they are.
fn operations() -> Vec<(String, String)> {
    let document: Value = serde_json::from_str(&dynident::service::openapi_json()).unwrap();
    let paths = document["paths"].as_object().unwrap();
    let of_path = |(path, item): (&String, &Value)| {
        let methods = item.as_object().unwrap().keys();
        methods.map(|m| (m.to_uppercase(), path.clone())).collect::<Vec<_>>()
    };
    let all = paths.iter().flat_map(of_path);
    all.filter(|(_, path)| !path.starts_with("/health/")).collect()
}

/// Whether the OpenAPI document says that the operation may answer so.
fn is_documented(method: &str, path: &str, status: u16) -> bool {
    let document: Value = serde_json::from_str(&dynident::service::openapi_json()).unwrap();
    document["paths"][path][method.to_lowercase()]["responses"][status.to_string()].is_object()
}

/// A body that the operation would take.
fn body(path: &str, robot: &str) -> (&'static str, String) {
    let mut excitation = quick_request();
    excitation["robot"] = json!(robot);
    match path {
        "/identify" | "/identify/preview" => ("multipart/form-data; boundary=b", multipart(&json!({"robot": robot}))),
        // Of no robot: what is said depends on the file alone, which is empty.
        "/logs/columns" => {
            let part = "--b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\n\r\n--b--\r\n";
            ("multipart/form-data; boundary=b", part.to_string())
        }
        "/robot-archive" => ("application/zip", "PK".to_string()),
        "/validate" => ("multipart/form-data; boundary=b", multipart(&json!({"model": robot}))),
        "/excitation" => ("application/json", excitation.to_string()),
        "/robots" | "/robots/{id}" => ("application/json", arm(robot).to_string()),
        _ => ("application/json", json!({"robot": robot}).to_string()),
    }
}

#[test]
fn an_expired_token_is_refused_at_every_address_with_a_code_of_its_own() {
    let guarded = Guarded::start("expired");
    let (id, expired) = guarded.lasting_token(Role::Admin, &["*"], Some(Duration::from_millis(1)));
    let (_, lasting) = guarded.lasting_token(Role::Admin, &["*"], Some(Duration::from_secs(3600)));
    std::thread::sleep(Duration::from_millis(20));
    for (method, path) in operations() {
        let answer = guarded.send(
            &expired,
            &method,
            &path.replace("{id}", "nothing").replace("{name}", "nothing"),
            &[],
            "",
        );
        assert_eq!(answer.status, 401, "{method} {path}: {}", answer.text);
        assert_eq!(answer.problem()["code"], "token_expired", "{method} {path}");
        assert!(answer.header("www-authenticate").is_some());
    }
    let message = guarded.get(&expired, "/jobs").problem()["detail"]
        .as_str()
        .unwrap()
        .to_string();
    assert!(message.contains(&id) && message.contains("until 20"), "{message}");
    assert_eq!(guarded.get(&lasting, "/jobs").status, 200);
}

#[test]
fn nothing_of_another_robot_is_seen_at_any_address() {
    let guarded = Guarded::start("addresses");
    let (_, everywhere) = guarded.token(Role::Admin, &["*"]);
    for name in ["arm-a", "arm-b"] {
        assert_eq!(guarded.post(&everywhere, "/robots", &arm(name)).status, 201);
    }
    let (_, mine) = guarded.token(Role::Admin, &["arm-a"]);
    let (_, theirs) = guarded.token(Role::Run, &["arm-b"]);
    let mut request = quick_request();
    request["robot"] = json!("arm-b");
    let design = guarded.post(&theirs, "/excitation", &request);
    assert_eq!(design.status, 200, "{}", design.text);
    let excitation = design.json()["id"].as_str().unwrap().to_string();
    let identification = guarded.failed_job(&theirs, "/identify", &json!({"robot": "arm-b"}));
    let validation = guarded.failed_job(&theirs, "/validate", &json!({"model": "arm-b"}));
    let ids = [
        ("/excitation/", excitation.as_str()),
        ("/identify/", &identification),
        ("/validate/", &validation),
        ("/jobs/", &excitation),
        ("/robots/", "arm-b"),
    ];
    let mut checked = 0;
    for (method, path) in operations() {
        let (kind, content) = body(&path, "arm-b");
        let content = if ["POST", "PUT", "PATCH"].contains(&method.as_str()) {
            content
        } else {
            String::new()
        };
        let send =
            |token: &str, path: &str, content: &str| guarded.send(token, &method, path, &[("content-type", kind)], content);
        if path.contains("{id}") {
            let id = ids
                .iter()
                .find(|(start, _)| path.starts_with(start))
                .unwrap_or_else(|| panic!("{path}"))
                .1;
            let answer = send(&mine, &path.replace("{id}", id), &content);
            assert_eq!(answer.status, 404, "{method} {path}: {}", answer.text);
            assert!(is_documented(&method, &path, 404), "{method} {path}");
            // Word for word what is said of a thing that is not there.
            let nothing = send(&mine, &path.replace("{id}", "nothing"), &content.replace("arm-b", "nothing"));
            assert_eq!(answer.text.replace(id, "nothing"), nothing.text, "{method} {path}");
            checked += 1;
        } else if path.contains("{name}") {
            // The catalogue is of no robot: whoever has a token reads it, and those for all robots change it.
            let answer = send(&mine, &path.replace("{name}", "nothing"), &content);
            let expected = if method == "GET" { 404 } else { 403 };
            assert_eq!(answer.status, expected, "{method} {path}: {}", answer.text);
        } else if method == "POST" {
            let answer = send(&mine, &path, &content);
            let nothing = send(&mine, &path, &content.replace("arm-b", "arm-z"));
            // An archive is of no robot before it is unpacked.
            let expected: &[u16] = if path == "/robot-archive" { &[400] } else { &[404, 422] };
            assert!(expected.contains(&answer.status), "{method} {path}: {}", answer.text);
            assert!(
                is_documented(&method, &path, answer.status),
                "{method} {path}: {}",
                answer.status
            );
            assert_eq!(
                (answer.status, answer.text.replace("arm-b", "arm-z")),
                (nothing.status, nothing.text),
                "{method} {path}"
            );
        } else {
            let answer = send(&mine, &path, "");
            let seen =
                [200, 403].contains(&answer.status) && !answer.text.contains("arm-b") && !answer.text.contains(&excitation);
            assert!(seen, "{method} {path}: {}", answer.text);
        }
    }
    assert!(checked >= 12, "{checked} addresses with an id");
    // Their owner sees them still.
    for (start, id) in ids {
        assert_ne!(guarded.get(&theirs, &format!("{start}{id}")).status, 404, "{start}");
    }
}

/// The catalogue is that of all robots: everybody reads and uses it, and the admin of some robots does not change it for the
/// others.
#[test]
fn the_catalogue_of_effects_is_changed_by_those_who_administrate_all_robots() {
    let guarded = Guarded::start("catalogue");
    let (admin_id, admin) = guarded.token(Role::Admin, &["*"]);
    let (_, runs) = guarded.token(Role::Run, &["*"]);
    let (_, of_one) = guarded.token(Role::Admin, &["arm-a"]);
    let (_, reads) = guarded.token(Role::Read, &["arm-a"]);
    let hose = crate::effects::hose().to_string();
    let kind = [("content-type", "application/json")];
    let put = |token: &str| guarded.send(token, "PUT", "/effects/hose", &kind, &hose);
    for token in [&runs, &of_one, &reads] {
        for refused in [put(token), guarded.send(token, "DELETE", "/effects/hose", &[], "")] {
            assert_eq!((refused.status, refused.problem()["code"].as_str()), (403, Some("forbidden")));
        }
    }
    assert_eq!(put(&admin).status, 201);
    for token in [&admin, &runs, &of_one, &reads] {
        assert_eq!(guarded.get(token, "/effects/hose").status, 200);
        assert_eq!(guarded.get(token, "/effects").json()["effects"].as_array().unwrap().len(), 1);
    }
    let preview = |token: &str| guarded.send(token, "POST", "/effect-preview", &kind, &hose).status;
    assert_eq!([&admin, &runs, &of_one, &reads].map(|t| preview(t)), [200, 200, 200, 403]);
    assert_eq!(guarded.send(&admin, "DELETE", "/effects/hose", &[], "").status, 204);
    let entries = guarded.in_store(async |store| store.audit(10).await).unwrap();
    let deeds: Vec<_> = entries
        .iter()
        .map(|e| (e.token.as_str(), e.action.as_str(), e.target.as_str()))
        .collect();
    let id = admin_id.as_str();
    assert_eq!(deeds, [(id, "put_effect", "hose"), (id, "delete_effect", "hose")]);
}

/// A request that calls something else by its id: where it goes, what it says, and the place of the id in it.
struct Reference {
    path: &'static str,
    request: Value,
    pointer: &'static str,
}

/// All that bodies may refer to by the id of a job, with these ids. Warm starts hold numbers and no ids.
fn references(identification: &str, excitation: &str) -> Vec<Reference> {
    let design = |name: &str, value: Value| {
        let mut request = quick_request();
        request[name] = value;
        request
    };
    let mut of_model = design("model", json!({"identification": identification}));
    of_model.as_object_mut().unwrap().remove("robot");
    let list = [
        ("/excitation", of_model, "/model/identification"),
        (
            "/excitation",
            design("given", json!([{"identification": identification}])),
            "/given/0/identification",
        ),
        (
            "/excitation",
            design("given", json!([{"excitation": excitation, "periods": 2}])),
            "/given/0/excitation",
        ),
        ("/identify", json!({"robot": ARM, "excitation": excitation}), "/excitation"),
        (
            "/identify/preview",
            json!({"robot": ARM, "excitation": excitation}),
            "/excitation",
        ),
        ("/validate", json!({"model": ARM, "excitation": excitation}), "/excitation"),
    ];
    let of = |(path, request, pointer)| Reference { path, request, pointer };
    list.into_iter().map(of).collect()
}

/// Comes with the program: anybody may use it, and what is made with it belongs to the robot of the token.
const ARM: &str = "planar_two_link";

impl Guarded {
    fn refer(&self, token: &str, reference: &Reference) -> Answer {
        let (kind, body) = match reference.path {
            "/excitation" => ("application/json", reference.request.to_string()),
            _ => (
                "multipart/form-data; boundary=b",
                multipart_of(&reference.request, &crate::identify::log(0.3)),
            ),
        };
        self.send(token, "POST", reference.path, &[("content-type", kind)], &body)
    }

    /// Ids of a finished identification, which has a model, and of a finished design.
    fn finished(&self, token: &str) -> [String; 2] {
        let log = multipart_of(&json!({"robot": ARM}), &crate::identify::log(0.3));
        let headers = [("content-type", "multipart/form-data; boundary=b"), ("prefer", "wait=60")];
        let identification = self.send(token, "POST", "/identify", &headers, &log);
        let design = self.post(token, "/excitation", &quick_request());
        [identification, design].map(|answer| {
            assert_eq!(answer.status, 200, "{}", answer.text);
            answer.json()["id"].as_str().unwrap().to_string()
        })
    }
}

/// Bodies reach no farther than addresses: an id of another robot's job is one that nobody has.
#[test]
fn nothing_of_another_robot_is_reached_through_a_body() {
    let guarded = Guarded::start("bodies");
    let (_, mine) = guarded.token(Role::Run, &["arm-a"]);
    let (_, theirs) = guarded.token(Role::Run, &["arm-b"]);
    let [identification, excitation] = guarded.finished(&theirs);
    let nothing = references("nothing", "nothing");
    for (reference, nothing) in references(&identification, &excitation).iter().zip(&nothing) {
        let Reference { path, pointer, .. } = reference;
        // For their owner the ids stand for something: what is refused below is refused for no other reason.
        let own = guarded.refer(&theirs, reference);
        assert!([200, 202].contains(&own.status), "{path} {pointer}: {}", own.text);
        let refused = guarded.refer(&mine, reference);
        assert_eq!(refused.status, 422, "{path} {pointer}: {}", refused.text);
        let errors = refused.errors();
        assert!(
            errors.len() == 1 && errors[0].starts_with(&format!("{pointer}: ")),
            "{path}: {errors:?}"
        );
        // Word for word what is said of an id that nobody has.
        let said = refused
            .text
            .replace(&identification, "nothing")
            .replace(&excitation, "nothing");
        assert_eq!(said, guarded.refer(&mine, nothing).text, "{path} {pointer}");
    }
    // A warm start has no place for an id, not even for one's own.
    let mut warm = quick_request();
    warm["warm_start"] = json!({"excitation": excitation});
    let errors = guarded.post(&theirs, "/excitation", &warm).errors();
    let no_field = "/warm_start/excitation: is not a field";
    assert!(errors.iter().any(|e| e.starts_with(no_field)), "{errors:?}");
    // Nor does anything of theirs come along with what is refused.
    assert_eq!(guarded.get(&mine, "/jobs").json()["jobs"], json!([]));
}

/// A key is a word of whoever sends it: the same word of another begins work of their own.
#[test]
fn a_key_of_another_token_finds_nothing() {
    let guarded = Guarded::start("keys");
    let (_, mine) = guarded.token(Role::Run, &["arm-a"]);
    let (_, theirs) = guarded.token(Role::Run, &["arm-b"]);
    let begin = |token: &str| {
        let headers = [("content-type", "application/json"), ("idempotency-key", "monday")];
        let answer = guarded.send(token, "POST", "/excitation", &headers, &quick_request().to_string());
        assert!([200, 202].contains(&answer.status), "{}", answer.text);
        answer.json()["id"].as_str().unwrap().to_string()
    };
    let first = begin(&theirs);
    assert_eq!(begin(&theirs), first);
    assert_ne!(begin(&mine), first);
}

#[test]
fn without_a_valid_token_nothing_is_answered() {
    let guarded = Guarded::start("none");
    let (id, secret) = guarded.token(Role::Admin, &["*"]);
    assert_eq!(guarded.get(&secret, "/jobs").status, 200);
    guarded.in_store(async |store| store.revoke_token(&id).await).unwrap();
    for (method, path) in operations() {
        let path = path.replace("{id}", "iiwa14");
        for token in [secret.as_str(), "wrong", ""] {
            let answer = guarded.send(token, &method, &path, &[], "");
            assert_eq!(
                (answer.status, answer.problem()["code"].as_str()),
                (401, Some("unauthorized")),
                "{method} {path}"
            );
            assert!(answer.header("www-authenticate").is_some());
        }
    }
    assert_eq!(guarded.server.get("/health/live").status, 200);
    // The secret is nowhere on the disk.
    let database = std::fs::read(guarded.folder.join("dynident.sqlite")).unwrap();
    let log = std::fs::read(guarded.folder.join("dynident.sqlite-wal")).unwrap_or_default();
    let kept = [database, log].concat();
    assert!(!kept.windows(secret.len()).any(|w| w == secret.as_bytes()));
}

#[test]
fn a_role_does_what_it_says_and_no_more() {
    let guarded = Guarded::start("roles");
    let (_, read) = guarded.token(Role::Read, &["*"]);
    let (_, run) = guarded.token(Role::Run, &["*"]);
    let (_, admin) = guarded.token(Role::Admin, &["*"]);
    let design = guarded.post(&run, "/excitation", &quick_request());
    assert_eq!(design.status, 200);
    let id = design.json()["id"].as_str().unwrap().to_string();
    assert_eq!(guarded.get(&read, &format!("/excitation/{id}")).status, 200);
    let forbidden = |answer: Answer| assert_eq!((answer.status, answer.problem()["code"].as_str()), (403, Some("forbidden")));
    forbidden(guarded.post(&read, "/excitation", &quick_request()));
    forbidden(guarded.send(&read, "DELETE", &format!("/jobs/{id}"), &[], ""));
    forbidden(guarded.post(&run, "/robots", &arm("x")));
    assert_eq!(guarded.post(&admin, "/robots", &arm("x")).status, 201);
    forbidden(guarded.send(&run, "DELETE", "/robots/x", &[], ""));
    assert_eq!(guarded.get(&read, "/metrics").status, 200);
    let (_, one) = guarded.token(Role::Admin, &["x"]);
    forbidden(guarded.get(&one, "/metrics"));
    // All of it stands in the audit log, with who did it.
    let entries = guarded.in_store(async |store| store.audit(100).await).unwrap();
    let actions: Vec<&str> = entries.iter().map(|e| e.action.as_str()).collect();
    assert_eq!(actions, ["run_excitation", "put_robot"]);
    assert!(
        entries
            .iter()
            .all(|e| e.who == "test" && !e.request.is_empty() && !e.token.is_empty())
    );
}

/// Documents and the robots of the program are anybody's: with them, a token for one robot works for that robot.
#[test]
fn jobs_on_documents_belong_to_the_robot_of_the_token() {
    let guarded = Guarded::start("owner");
    let (_, mine) = guarded.token(Role::Run, &["arm-a"]);
    let (_, theirs) = guarded.token(Role::Run, &["arm-b"]);
    let job = guarded.post(&mine, "/excitation", &quick_request());
    assert_eq!(job.status, 200);
    let path = format!("/jobs/{}", job.json()["id"].as_str().unwrap());
    assert_eq!(guarded.get(&mine, &path).json()["robot"], "arm-a");
    assert_eq!(guarded.get(&theirs, &path).status, 404);
    // The same design asked for by another is not theirs to see either.
    let other = guarded.post(&theirs, "/excitation", &quick_request());
    assert_ne!(other.json()["id"], job.json()["id"]);
}

#[test]
fn one_token_cannot_fill_the_queue() {
    let guarded = Guarded::with(
        "queue",
        Config {
            waiting_per_token: 2,
            concurrent_jobs: 0,
            ..Config::default()
        },
    );
    let (_, one) = guarded.token(Role::Run, &["*"]);
    let (_, other) = guarded.token(Role::Run, &["*"]);
    let post = |token: &str, seed: u64| {
        let mut request = crate::server::long_request();
        request["search"]["seed"] = json!(seed);
        let headers = [("content-type", "application/json")];
        guarded.send(token, "POST", "/excitation", &headers, &request.to_string())
    };
    assert_eq!((post(&one, 1).status, post(&one, 2).status), (202, 202));
    let refused = post(&one, 3);
    assert_eq!(
        (refused.status, refused.problem()["code"].as_str()),
        (429, Some("limit_reached"))
    );
    assert!(refused.header("retry-after").is_some());
    assert_eq!(post(&other, 3).status, 202);
}

#[test]
fn a_server_for_its_own_machine_does_not_serve_a_proxy() {
    let server = Server::start();
    let answer = server.send("GET", "/jobs", &[("x-forwarded-for", "10.0.0.1")], "");
    assert_eq!((answer.status, answer.problem()["code"].as_str()), (403, Some("forbidden")));
}

#[test]
fn too_many_requests_are_told_when_to_come_back() {
    let server = Server::with(Config {
        requests_per_second: Some(1),
        request_burst: 3,
        ..Config::default()
    });
    let answers: Vec<Answer> = (0..5).map(|_| server.get("/jobs")).collect();
    assert_eq!(answers.iter().filter(|a| a.status == 200).count(), 3);
    let refused = answers.last().unwrap();
    assert_eq!(
        (refused.status, refused.problem()["code"].as_str()),
        (429, Some("rate_limited"))
    );
    assert!(refused.header("retry-after").unwrap().parse::<u64>().unwrap() >= 1);
}

/// A word that nobody has verified makes no other client of the same one: neither where tokens are not asked for, nor where they
/// are.
#[test]
fn regress_invented_tokens_have_no_budget_of_their_own() {
    let config = Config {
        requests_per_second: Some(1),
        request_burst: 3,
        ..Config::default()
    };
    let open = Server::with(config.clone());
    let guarded = Guarded::with("budget", config);
    let (_, known) = guarded.token(Role::Run, &["*"]);
    for server in [&open, &guarded.server] {
        let ask = |i: usize| server.send("GET", "/jobs", &[("authorization", &format!("Bearer invented{i}"))], "");
        let answers: Vec<Answer> = (0..6).map(ask).collect();
        // The bucket gains one a second: six requests within a few seconds find three to six places, and six of them only if
        // nothing is limited.
        let limited = answers.iter().filter(|a| a.status == 429).count();
        assert!(limited >= 1, "{:?}", answers.iter().map(|a| a.status).collect::<Vec<_>>());
        assert!(answers[..3].iter().all(|a| a.status != 429));
    }
    // Whoever has a token that is known is not meant, from the same address.
    assert_eq!(guarded.get(&known, "/jobs").status, 200);
}
