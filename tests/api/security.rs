//! What pages of other sites, and clients that stop half way, can do to a server: nothing.

use crate::server::{Answer, Server, quick_request};
use dynident::service::Config;
use serde_json::Value;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Method and path of every operation of the interface.
fn operations() -> Vec<(String, String)> {
    let document: Value = serde_json::from_str(&dynident::service::openapi_json()).unwrap();
    let of_path = |(path, item): (&String, &Value)| {
        let methods = item.as_object().unwrap().keys();
        methods
            .map(|m| (m.to_uppercase(), path.replace("{id}", "iiwa14")))
            .collect::<Vec<_>>()
    };
    document["paths"].as_object().unwrap().iter().flat_map(of_path).collect()
}

/// A request by hand: `Host` is what is given, or left out.
fn raw(server: &Server, method: &str, path: &str, headers: &[(&str, &str)]) -> (u16, String) {
    let lines: String = headers.iter().map(|(name, value)| format!("{name}: {value}\r\n")).collect();
    let request = format!("{method} {path} HTTP/1.1\r\n{lines}content-length: 0\r\nconnection: close\r\n\r\n");
    let mut stream = TcpStream::connect(server.address).unwrap();
    stream.write_all(request.as_bytes()).unwrap();
    let mut text = String::new();
    stream.read_to_string(&mut text).unwrap();
    let status = text.split(' ').nth(1).and_then(|s| s.parse().ok()).unwrap_or(0);
    (status, text)
}

#[test]
fn no_address_answers_to_a_foreign_name() {
    let server = Server::start();
    let others = [
        ("GET", "/"),
        ("GET", "/robot"),
        ("GET", "/assets/api.js"),
        ("GET", "/docs/"),
        ("GET", "/openapi.json"),
        ("GET", "/nothing"),
    ];
    let all = others.iter().map(|(m, p)| (m.to_string(), p.to_string())).chain(operations());
    for (method, path) in all {
        let (status, text) = raw(
            &server,
            &method,
            &path,
            &[("host", &format!("evil.example:{}", server.address.port()))],
        );
        assert_eq!(status, 421, "{method} {path}: {text}");
        assert!(text.contains("wrong_host") || method == "HEAD", "{method} {path}: {text}");
        assert!(!text.to_ascii_lowercase().contains("access-control-allow"), "{text}");
    }
    assert_eq!(raw(&server, "GET", "/jobs", &[]).0, 421);
    assert_eq!(raw(&server, "GET", "/jobs", &[("host", "localhost")]).0, 200);
}

#[test]
fn a_name_that_the_operator_allows_is_answered() {
    let server = Server::with(Config {
        allowed_hosts: vec!["lab.example.org".into()],
        ..Config::default()
    });
    assert_eq!(raw(&server, "GET", "/jobs", &[("host", "lab.example.org")]).0, 200);
    assert_eq!(raw(&server, "GET", "/jobs", &[("host", "other.example.org")]).0, 421);
    // A proxy that does not hand on the name that the page was asked for by.
    let rewritten = [("host", "127.0.0.1:8080"), ("origin", "https://lab.example.org")];
    assert_eq!(raw(&server, "GET", "/jobs", &rewritten).0, 200);
    assert_ne!(raw(&server, "DELETE", "/jobs/nothing", &rewritten).0, 403);
    let foreign = [("host", "127.0.0.1:8080"), ("origin", "https://evil.example")];
    assert_eq!(raw(&server, "GET", "/jobs", &foreign).0, 403);
}

/// What browsers say of the requests of a foreign page: with fetch metadata, and older ones without.
const FOREIGN: [&[(&str, &str)]; 5] = [
    &[
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "cors"),
        ("origin", "https://evil.example"),
    ],
    &[
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "no-cors"),
        ("origin", "https://evil.example"),
    ],
    &[
        ("sec-fetch-site", "same-site"),
        ("sec-fetch-mode", "cors"),
        ("origin", "http://127.0.0.1:1"),
    ],
    &[("origin", "https://evil.example")],
    &[("origin", "null")],
];

fn refused(answer: &Answer) -> bool {
    answer.status == 403 && answer.problem()["code"] == "cross_site"
}

#[test]
fn a_foreign_page_reaches_no_address() {
    let server = Server::start();
    for (method, path) in operations() {
        for headers in FOREIGN {
            let answer = server.send(
                &method,
                &path,
                headers,
                if method == "POST" || method == "PUT" { "{}" } else { "" },
            );
            assert!(refused(&answer), "{method} {path} {headers:?}: {}", answer.text);
            assert!(answer.header("access-control-allow-origin").is_none());
        }
    }
    let preflight = [("origin", "https://evil.example"), ("access-control-request-method", "POST")];
    assert!(refused(&server.send("OPTIONS", "/excitation", &preflight, "")));
}

/// Forms need no leave of the server that they are sent to: multipart, urlencoded and plain text go out from any page.
#[test]
fn a_foreign_form_begins_no_job() {
    let server = Server::start();
    let navigation = [
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "navigate"),
        ("sec-fetch-dest", "document"),
        ("origin", "https://evil.example"),
    ];
    let part = format!(
        "--b\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{}\r\n--b--\r\n",
        "{\"robot\": \"iiwa14\"}"
    );
    for (path, kind, body) in [
        ("/identify", "multipart/form-data; boundary=b", part.clone()),
        ("/identify/preview", "multipart/form-data; boundary=b", part.clone()),
        ("/logs/columns", "multipart/form-data; boundary=b", part),
        ("/excitation", "text/plain", quick_request().to_string()),
        ("/excitation", "application/x-www-form-urlencoded", "robot=iiwa14".into()),
        ("/robots", "text/plain", "{\"name\": \"evil\"}".into()),
    ] {
        for foreign in [&navigation[..], &navigation[3..]] {
            let answer = server.send("POST", path, &[&[("content-type", kind)], foreign].concat(), &body);
            assert!(refused(&answer), "{path} {kind}: {}", answer.text);
        }
    }
    assert_eq!(server.get("/jobs").json()["jobs"].as_array().unwrap().len(), 0);
}

#[test]
fn links_and_own_pages_are_answered() {
    let server = Server::start();
    let followed = [
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "navigate"),
        ("sec-fetch-dest", "document"),
    ];
    assert_eq!(server.send("GET", "/identification?id=x", &followed, "").status, 200);
    let framed = [
        ("sec-fetch-site", "cross-site"),
        ("sec-fetch-mode", "navigate"),
        ("sec-fetch-dest", "iframe"),
    ];
    assert!(refused(&server.send("GET", "/", &framed, "")));
    let origin = format!("http://{}", server.address);
    for own in [
        &[("sec-fetch-site", "same-origin")][..],
        &[("origin", &origin)],
        &[("sec-fetch-site", "none")],
        &[],
    ] {
        let headers = [&[("content-type", "application/json"), ("prefer", "wait=60")], own].concat();
        let answer = server.send("POST", "/excitation", &headers, &quick_request().to_string());
        assert_eq!(answer.status, 200, "{own:?}: {}", answer.text);
    }
}

/// A foreign page has no token: where one is needed, names and origins are the operator's business.
#[test]
fn with_tokens_the_token_decides() {
    let server = Server::with(Config {
        tokens_required: true,
        ..Config::default()
    });
    let (status, text) = raw(&server, "GET", "/jobs", &[("host", "lab.example.org")]);
    assert_eq!(status, 401, "{text}");
    assert_eq!(server.send("GET", "/jobs", FOREIGN[0], "").status, 401);
}

#[test]
fn every_answer_is_protected() {
    let server = Server::start();
    let pages = [
        "/",
        "/robot",
        "/design",
        "/identification",
        "/loop",
        "/runs",
        "/help",
        "/docs/",
    ];
    let data = [
        "/jobs",
        "/openapi.json",
        "/metrics",
        "/assets/api.js",
        "/assets/icon.svg",
        "/nothing",
        "/robots/nothing",
        "/health/live",
    ];
    for path in pages.iter().chain(&data) {
        let answer = server.get(path);
        let header = |name: &str| answer.header(name).unwrap_or_else(|| panic!("{name} of {path}")).to_string();
        assert_eq!(header("x-content-type-options"), "nosniff", "{path}");
        assert_eq!(header("x-frame-options"), "DENY", "{path}");
        assert_eq!(header("referrer-policy"), "same-origin", "{path}");
        assert_eq!(header("cross-origin-resource-policy"), "same-origin", "{path}");
        let policy = header("content-security-policy");
        let has = |directive: &str| policy.split(';').any(|d| d.trim() == directive);
        assert!(
            has("default-src 'none'") && has("frame-ancestors 'none'") && has("base-uri 'none'"),
            "{path}: {policy}"
        );
        assert_eq!(has("script-src 'self'"), pages.contains(path), "{path}: {policy}");
        assert_eq!(
            answer.header("cross-origin-opener-policy").is_some(),
            pages.contains(path),
            "{path}"
        );
    }
    // No page has a script that stands in it, which the policy would not run.
    for path in pages {
        let text = server.get(path).text;
        let scripts: Vec<&str> = text.split("<script").skip(1).filter_map(|s| s.split('>').next()).collect();
        assert!(scripts.iter().all(|s| s.contains("src=")), "{path}: {scripts:?}");
        assert!(!text.contains(" onclick=") && !text.contains("javascript:"), "{path}");
    }
}

/// A server with short times.
fn impatient(config: Config) -> Server {
    Server::with(Config {
        header_timeout: Duration::from_millis(400),
        idle_timeout: Duration::from_millis(400),
        ..config
    })
}

/// What a client hears until the server closes the connection.
fn heard(stream: &mut TcpStream) -> (String, Duration) {
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let (begun, mut text) = (Instant::now(), Vec::new());
    stream.read_to_end(&mut text).expect("the server closes the connection");
    (String::from_utf8_lossy(&text).into_owned(), begun.elapsed())
}

#[test]
fn a_client_that_stops_half_way_is_not_waited_for() {
    let server = impatient(Config::default());
    let host = format!("host: {}", server.address);
    let begin = |text: &str| {
        let mut stream = TcpStream::connect(server.address).unwrap();
        stream.write_all(text.as_bytes()).unwrap();
        stream
    };
    // Nothing at all, half a line, a header without its end.
    for head in ["", "GET /jo", &format!("GET /jobs HTTP/1.1\r\n{host}\r\nx-a: b\r\n")] {
        let (text, time) = heard(&mut begin(head));
        assert!(text.is_empty() && time < Duration::from_secs(10), "{head:?}: {text}");
    }
    // Half a body, of a document and of a log.
    for kind in ["application/json", "multipart/form-data; boundary=b"] {
        let path = if kind.starts_with("multipart") {
            "/identify"
        } else {
            "/excitation"
        };
        let half = "--b\r\nContent-Disposition: form-data; name=\"log\"; filename=\"a.csv\"\r\n\r\ntime,q1";
        let (text, time) = heard(&mut begin(&format!(
            "POST {path} HTTP/1.1\r\n{host}\r\ncontent-type: {kind}\r\ncontent-length: 1000\r\n\r\n{half}"
        )));
        assert!(
            text.starts_with("HTTP/1.1 408 ") && text.contains("request_timeout"),
            "{kind}: {text}"
        );
        assert!(time < Duration::from_secs(10), "{kind}: {time:?}");
    }
    // A connection that is kept open and has no next request.
    let (text, _) = heard(&mut begin(&format!("GET /health/live HTTP/1.1\r\n{host}\r\n\r\n")));
    assert!(text.starts_with("HTTP/1.1 200 "), "{text}");
}

/// A drop at a time is slow, not stopped: logs come over bad lines too.
#[test]
fn a_slow_body_is_read_to_its_end() {
    let server = impatient(Config::default());
    let body = r#"{"robot": "planar_two_link"}"#;
    let head = format!(
        "POST /motion HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\nconnection: close\r\ncontent-length: {}\r\n\r\n",
        server.address,
        body.len()
    );
    let mut stream = TcpStream::connect(server.address).unwrap();
    stream.write_all(head.as_bytes()).unwrap();
    for byte in body.as_bytes().chunks(4) {
        std::thread::sleep(Duration::from_millis(100));
        stream.write_all(byte).unwrap();
    }
    let (text, _) = heard(&mut stream);
    assert!(text.starts_with("HTTP/1.1 200 "), "{text}");
}

/// Whoever holds all places holds them for a while only: without a request, or with an answer that is not taken.
#[test]
fn places_of_connections_come_free_again() {
    let server = impatient(Config {
        most_connections: 2,
        ..Config::default()
    });
    let design = server.excite(&quick_request()).json();
    let path = format!(
        "/excitation/{}/trajectory?rate_hz=1000000&periods=4",
        design["id"].as_str().unwrap()
    );
    let mut greedy: Vec<TcpStream> = (0..2).map(|_| TcpStream::connect(server.address).unwrap()).collect();
    greedy[0]
        .write_all(format!("GET {path} HTTP/1.1\r\nhost: {}\r\n\r\n", server.address).as_bytes())
        .unwrap();
    std::thread::sleep(Duration::from_millis(100));
    let begun = Instant::now();
    assert_eq!(server.get("/health/live").status, 200);
    assert!(
        begun.elapsed() > Duration::from_millis(100),
        "the third connection did not wait"
    );
    // The answer that was not taken was cut off.
    std::thread::sleep(Duration::from_millis(1500));
    let mut taken = 0;
    let mut buffer = vec![0; 1 << 20];
    while let Ok(read @ 1..) = greedy[0].read(&mut buffer) {
        taken += read;
    }
    assert!(taken < 100 << 20, "{taken}");
}

/// The end of the server is not held up by clients that do not go.
#[test]
fn open_connections_do_not_hold_up_the_end() {
    let mut server = Server::start();
    let mut stream = TcpStream::connect(server.address).unwrap();
    let head = format!(
        "POST /excitation HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\ncontent-length: 10\r\n\r\n{{",
        server.address
    );
    stream.write_all(head.as_bytes()).unwrap();
    let _idle = TcpStream::connect(server.address).unwrap();
    std::thread::sleep(Duration::from_millis(200));
    let begun = Instant::now();
    server.stop();
    assert!(begun.elapsed() < Duration::from_secs(15), "{:?}", begun.elapsed());
}
