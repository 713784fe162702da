//! The page on 127.0.0.1, until Ctrl-C.

use super::page;
use crate::output::{print, tell};
use anyhow::{Context, Result, anyhow};
use std::io::ErrorKind;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use tiny_http::{Header, Method, Request, Response, Server};

/// Where the desk is looked for: a bookmark stays good.
const USUAL_PORT: u16 = 8471;

/// The page may run its own script, module and workers; it may load and send nothing.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; \
    style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Headers of every answer.
const HEADERS: [(&str, &str); 7] = [
    ("Content-Security-Policy", POLICY),
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cache-Control", "no-store"),
];

/// Serves the page at `port`, or at the usual one, or at any free one.
pub(super) fn serve(port: Option<u16>) -> Result<()> {
    let listener = listener(port)?;
    let port = listener.local_addr().context("127.0.0.1")?.port();
    let plain = page::plain()?;
    let server = Server::from_listener(listener, None).map_err(|error| anyhow!("127.0.0.1:{port}: {error}"))?;
    let server = Arc::new(server);
    let interrupted = Arc::clone(&server);
    ctrlc::set_handler(move || interrupted.unblock()).context("Ctrl-C")?;
    print(&format!("http://127.0.0.1:{port}/\n"))?;
    tell("note: open this address in a browser; Ctrl-C ends the desk");
    // Ends when it is unblocked.
    for request in server.incoming_requests() {
        let response = answer(&request, port, &plain);
        // A browser that has gone away needs no answer.
        let _ = request.respond(response);
    }
    Ok(())
}

fn listener(port: Option<u16>) -> Result<TcpListener> {
    let at = |port: u16| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    match (at(port.unwrap_or(USUAL_PORT)), port) {
        (Ok(listener), _) => Ok(listener),
        (Err(_), None) => at(0).context("127.0.0.1: no port is free"),
        (Err(error), Some(port)) if error.kind() == ErrorKind::AddrInUse => {
            Err(anyhow!("--port: found {port}, which another program serves at, needed a free one (0: any)"))
        }
        (Err(error), Some(port)) => Err(error).context(format!("--port: cannot serve at {port}")),
    }
}

type Answer = Response<std::io::Cursor<Vec<u8>>>;

fn answer(request: &Request, port: u16, plain: &[u8]) -> Answer {
    // A name of another site that points here would otherwise read the page as its own.
    let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let hosts: Vec<&str> = values(request, "Host").collect();
    if !matches!(hosts[..], [host] if own.iter().any(|own| own == host)) {
        return refusal(421, &format!("found the Host {:?}, needed {}\n", hosts.join(", "), own[0]));
    }
    if request.url() != "/" {
        return refusal(404, "there is / and nothing else\n");
    }
    if !matches!(request.method(), Method::Get | Method::Head) {
        return header(refusal(405, "needed GET or HEAD\n"), "Allow", "GET, HEAD");
    }
    let gzip = values(request, "Accept-Encoding").any(takes_gzip);
    let body = if gzip { page::COMPRESSED } else { plain };
    let page = header(text(200, body), "Content-Type", "text/html; charset=utf-8");
    let page = header(page, "Vary", "Accept-Encoding");
    if gzip { header(page, "Content-Encoding", "gzip") } else { page }
}

/// The values of a header, as often as it was sent.
fn values<'r>(request: &'r Request, name: &'static str) -> impl Iterator<Item = &'r str> {
    request.headers().iter().filter(move |header| header.field.equiv(name)).map(|header| header.value.as_str())
}

/// Whether an `Accept-Encoding` header names gzip with a quality above 0.
fn takes_gzip(value: &str) -> bool {
    value.split(',').any(|coding| {
        let (name, quality) = coding.split_once(';').unwrap_or((coding, ""));
        let quality = quality.trim().strip_prefix("q=").map_or(Ok(1.0), str::parse::<f64>);
        name.trim().eq_ignore_ascii_case("gzip") && quality.is_ok_and(|quality| quality > 0.0)
    })
}

fn refusal(status: u16, why: &str) -> Answer {
    header(text(status, why.as_bytes()), "Content-Type", "text/plain; charset=utf-8")
}

fn text(status: u16, body: &[u8]) -> Answer {
    // In one piece: its length is known.
    let answer = Response::from_data(body).with_status_code(status).with_chunked_threshold(usize::MAX);
    HEADERS.into_iter().fold(answer, |answer, (name, value)| header(answer, name, value))
}

fn header(answer: Answer, name: &str, value: &str) -> Answer {
    match Header::from_bytes(name, value) {
        Ok(header) => answer.with_header(header),
        Err(()) => answer,
    }
}
