//! The report while a study runs: a page on this machine's own address that renews itself, behind a secret in its path.
//!
//! One thread answers one request after another. Nothing listens elsewhere than on 127.0.0.1, and a request must name that
//! address as its host, so that no page of the web can ask in its place.
use crate::events::{Event, Listener, What};
use crate::plan::{NodeId, Plan};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How long a browser may take to say what it wants.
const PATIENCE: Duration = Duration::from_secs(2);
/// How often the thread looks whether someone asks, or the run has ended.
const NAP: Duration = Duration::from_millis(40);
/// How long the last page stays for a browser that asks every two seconds.
const FAREWELL: Duration = Duration::from_secs(3);
/// Longest request that is read [B].
const LONGEST: usize = 8192;

/// A run that is watched.
pub struct Watch<'a> {
    listener: TcpListener,
    secret: String,
    /// Who else listens.
    next: &'a dyn Listener,
    now: Mutex<Now>,
}

#[derive(Default)]
struct Now {
    settled: usize,
    failed: usize,
    running: BTreeMap<NodeId, (f64, String)>,
    /// When the run ended.
    ended: Option<Instant>,
    /// A browser has asked.
    asked: bool,
}

impl<'a> Watch<'a> {
    /// Opens a free port of this machine's own address; events go on to `next`.
    ///
    /// # Errors
    /// Where no port can be had, or no random bytes.
    pub fn open(next: &'a dyn Listener) -> io::Result<Watch<'a>> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        listener.set_nonblocking(true)?;
        let mut bytes = [0; 16];
        std::fs::File::open("/dev/urandom")?.read_exact(&mut bytes)?;
        let secret = bytes.iter().map(|b| format!("{b:02x}")).collect();
        Ok(Watch { listener, secret, next, now: Mutex::default() })
    }

    /// Where the page is.
    pub fn url(&self) -> String {
        let port = self.listener.local_addr().map_or(0, |a| a.port());
        format!("http://127.0.0.1:{port}/{}/", self.secret)
    }

    /// The run has ended: the thread that serves may end as well.
    pub fn end(&self) {
        self.now().ended = Some(Instant::now());
    }

    /// Answers until the run has ended, and as long again as a browser that has asked needs to see that; `page` makes the page.
    pub fn serve(&self, plan: &Plan, page: &dyn Fn() -> String) {
        loop {
            match self.listener.accept() {
                // A browser that goes away is no fault of the study.
                Ok((stream, _)) => drop(self.answer(stream, plan, page)),
                Err(_) => std::thread::sleep(NAP),
            }
            let now = self.now();
            if now.ended.is_some_and(|at| !now.asked || at.elapsed() > FAREWELL) {
                return;
            }
        }
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn answer(&self, mut stream: TcpStream, plan: &Plan, page: &dyn Fn() -> String) -> io::Result<()> {
        stream.set_nonblocking(false)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let request = read(&mut stream)?;
        let (kind, body) = match self.wanted(&request) {
            Some("") => ("text/html; charset=utf-8", page()),
            Some("state") => ("application/json", self.state(plan)),
            _ => return respond(&mut stream, "404 Not Found", "text/plain", "not here\n"),
        };
        respond(&mut stream, "200 OK", kind, &body)
    }

    /// What a request asks for behind the secret, if it may.
    fn wanted<'r>(&self, request: &'r str) -> Option<&'r str> {
        let mut lines = request.split("\r\n");
        let path = lines.next()?.strip_prefix("GET /")?.strip_suffix(" HTTP/1.1")?;
        let host =
            lines.find_map(|l| l.split_once(':').filter(|(name, _)| name.eq_ignore_ascii_case("host")))?.1.trim();
        let port = self.listener.local_addr().ok()?.port();
        let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let (secret, rest) = path.split_once('/')?;
        // All bytes are compared, whatever the first that differs.
        let differs = secret.len() != self.secret.len()
            || secret.bytes().zip(self.secret.bytes()).fold(0, |all, (a, b)| all | (a ^ b)) != 0;
        (own.iter().any(|o| o == host) && !differs).then_some(rest)
    }

    fn state(&self, plan: &Plan) -> String {
        let mut now = self.now();
        now.asked = true;
        let running = now.running.iter().map(|(id, (share, doing))| {
            let percent = (100.0 * share).round();
            json!({ "node": plan.label(*id), "percent": percent, "doing": doing })
        });
        json!({
            "settled": now.settled,
            "failed": now.failed,
            "of": plan.nodes.len(),
            "running": running.collect::<Vec<_>>(),
            "ended": now.ended.is_some(),
        })
        .to_string()
    }
}

impl Listener for Watch<'_> {
    fn on(&self, plan: &Plan, event: &Event) {
        {
            let mut now = self.now();
            match &event.what {
                What::Started { .. } => _ = now.running.insert(event.node, (0.0, String::new())),
                What::Progress { share, doing } => _ = now.running.insert(event.node, (*share, doing.clone())),
                What::Hit | What::Ran { .. } | What::Failed { .. } | What::Skipped { .. } | What::Cancelled => {
                    now.running.remove(&event.node);
                    now.settled += 1;
                    now.failed += usize::from(matches!(event.what, What::Failed { .. }));
                }
                What::Damaged
                | What::Waiting
                | What::Resumed
                | What::Retrying { .. }
                | What::Queued { .. }
                | What::Delayed { .. } => {}
            }
        }
        self.next.on(plan, event);
    }

    fn outlook(&self, plan: &Plan, seconds: &[f64]) {
        self.next.outlook(plan, seconds);
    }
}

/// A request up to its empty line.
fn read(stream: &mut TcpStream) -> io::Result<String> {
    let (mut all, mut buffer) = (Vec::new(), [0; 1024]);
    while all.len() < LONGEST && !all.windows(4).any(|w| w == b"\r\n\r\n") {
        match stream.read(&mut buffer)? {
            0 => break,
            n => all.extend(&buffer[..n]),
        }
    }
    Ok(String::from_utf8_lossy(&all).into_owned())
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> io::Result<()> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nConnection: close\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())
}
