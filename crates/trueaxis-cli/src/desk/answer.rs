//! Answers to requests.

use super::page;

/// The page may run its embedded script, module and workers; it may not load or send anything.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; \
    style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Headers of every answer.
const HEADERS: [(&str, &str); 8] = [
    ("Content-Security-Policy", POLICY),
    ("X-Content-Type-Options", "nosniff"),
    ("X-Frame-Options", "DENY"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Opener-Policy", "same-origin"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cache-Control", "no-store"),
    ("Connection", "close"),
];

/// A complete response, head and body.
pub(super) type Answer = Vec<u8>;

/// Answers the head of a request, without the empty line at its end.
pub(super) fn to(head: &[u8], port: u16, plain: &[u8]) -> Answer {
    let Some(Request { method, target, headers }) = std::str::from_utf8(head).ok().and_then(Request::read) else {
        return refusal("400 Bad Request", "needed a request of HTTP/1.1\n");
    };
    // Prevents DNS rebinding: a foreign host name that resolves to this address could otherwise read the page as same-origin.
    let own = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    let hosts: Vec<&str> = values(&headers, "Host").collect();
    if !matches!(hosts[..], [host] if own.iter().any(|own| own == host)) {
        return refusal(
            "421 Misdirected Request",
            &format!("found the Host {:?}, needed {}\n", hosts.join(", "), own[0]),
        );
    }
    if target != "/" {
        return refusal("404 Not Found", "found another path, needed /\n");
    }
    if !matches!(method, "GET" | "HEAD") {
        return answer("405 Method Not Allowed", &[TEXT, ("Allow", "GET, HEAD")], b"needed GET or HEAD\n");
    }
    let gzip = values(&headers, "Accept-Encoding").any(takes_gzip);
    let encoding: &[_] = if gzip { &[("Content-Encoding", "gzip")] } else { &[] };
    let of_page = [("Content-Type", "text/html; charset=utf-8"), ("Vary", "Accept-Encoding")];
    let body = if gzip { page::COMPRESSED } else { plain };
    let mut page = answer("200 OK", &[&of_page, encoding].concat(), body);
    if method == "HEAD" {
        page.truncate(page.len() - body.len());
    }
    page
}

/// Response to a request longer than the desk reads.
pub(super) fn too_long(most: usize) -> Answer {
    refusal("431 Request Header Fields Too Large", &format!("needed a request of at most {most} bytes\n"))
}

struct Request<'h> {
    method: &'h str,
    target: &'h str,
    headers: Vec<(&'h str, &'h str)>,
}

impl Request<'_> {
    fn read(head: &str) -> Option<Request<'_>> {
        let mut lines = head.split("\r\n");
        let mut words = lines.next()?.split(' ');
        let (method, target, version) = (words.next()?, words.next()?, words.next()?);
        if words.next().is_some() || !matches!(version, "HTTP/1.0" | "HTTP/1.1") {
            return None;
        }
        // A folded line continues the previous header: it has no name and is refused.
        let named = |(name, _): &(&str, &str)| !name.starts_with([' ', '\t']);
        let headers = lines.map(|line| line.split_once(':').filter(named)).collect::<Option<_>>()?;
        Some(Request { method, target, headers })
    }
}

/// All values of a header, one per occurrence.
fn values<'r>(headers: &'r [(&str, &'r str)], name: &'static str) -> impl Iterator<Item = &'r str> {
    headers.iter().filter(move |(field, _)| field.eq_ignore_ascii_case(name)).map(|(_, value)| value.trim())
}

/// Whether an `Accept-Encoding` header names gzip with a quality above 0.
fn takes_gzip(value: &str) -> bool {
    value.split(',').any(|coding| {
        let (name, quality) = coding.split_once(';').unwrap_or((coding, ""));
        let quality = quality.trim().strip_prefix("q=").map_or(Ok(1.0), str::parse::<f64>);
        name.trim().eq_ignore_ascii_case("gzip") && quality.is_ok_and(|quality| quality > 0.0)
    })
}

const TEXT: (&str, &str) = ("Content-Type", "text/plain; charset=utf-8");

fn refusal(status: &str, why: &str) -> Answer {
    answer(status, &[TEXT], why.as_bytes())
}

fn answer(status: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
    let mut head = format!("HTTP/1.1 {status}\r\nContent-Length: {}\r\n", body.len());
    for (name, value) in HEADERS.iter().chain(headers) {
        head += &format!("{name}: {value}\r\n");
    }
    [head.as_bytes(), b"\r\n", body].concat()
}
