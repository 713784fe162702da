//! `trueaxis desk` as called.

use trueaxis_testing::command::Folder;

const TRUEAXIS: &str = env!("CARGO_BIN_EXE_trueaxis");

#[test]
#[cfg(not(feature = "desk"))]
fn without_the_page_it_says_how_to_get_it() {
    for arguments in [&["desk"][..], &["desk", "-o", "desk.html"], &["desk", "--write", "desk.html"]] {
        Folder::new(TRUEAXIS).bad(arguments, &["built without the page", "desk/build.sh", "--features desk"]);
    }
}

#[test]
fn a_port_has_no_meaning_for_a_file() {
    Folder::new(TRUEAXIS).bad(&["desk", "--port", "9000", "--output", "desk.html"], &["cannot be used with"]);
    Folder::new(TRUEAXIS).bad(&["desk", "--port", "70000"], &["70000"]);
}

#[cfg(feature = "desk")]
mod served {
    use super::{Folder, TRUEAXIS};
    use std::fs;
    use std::io::ErrorKind::{BrokenPipe, ConnectionReset};
    use std::io::{BufRead, BufReader, Read, Write};
    use std::net::{Ipv4Addr, TcpListener, TcpStream};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    /// Even on a busy computer, anything slower never arrives.
    const PATIENCE: Duration = Duration::from_secs(120);

    /// The page that the build embeds.
    fn page() -> Vec<u8> {
        fs::read(env!("TRUEAXIS_DESK_PAGE")).unwrap()
    }

    /// A running desk and its port.
    struct Desk {
        child: Child,
        port: u16,
    }

    impl Desk {
        fn open(arguments: &[&str]) -> Desk {
            let folder = Folder::new(TRUEAXIS);
            let mut command = folder.command(&[&["desk"], arguments].concat());
            let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
            let mut line = String::new();
            BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
            let port = line.trim().strip_prefix("http://127.0.0.1:").and_then(|rest| rest.strip_suffix('/'));
            Desk { child, port: port.unwrap_or_else(|| panic!("{line}")).parse().unwrap() }
        }

        fn connect(&self) -> TcpStream {
            let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
            stream.set_write_timeout(Some(PATIENCE)).unwrap();
            stream
        }

        /// Status, headers in lower case, body.
        fn ask(&self, method: &str, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
            let mut stream = self.connect();
            write!(stream, "{method} {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").unwrap();
            let mut answer = Vec::new();
            stream.read_to_end(&mut answer).unwrap();
            let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
            let head = String::from_utf8(answer[..end].to_vec()).unwrap().to_lowercase();
            let status = head.split(' ').nth(1).unwrap().parse().unwrap();
            (status, head, answer[end + 4..].to_vec())
        }

        fn host(&self) -> String {
            format!("Host: 127.0.0.1:{}\r\n", self.port)
        }

        fn interrupt(mut self) -> Option<i32> {
            assert!(Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap().success());
            let end = Instant::now() + PATIENCE;
            while Instant::now() < end {
                if let Some(ended) = self.child.try_wait().unwrap() {
                    return ended.code();
                }
                std::thread::sleep(Duration::from_millis(20));
            }
            panic!("it continues after Ctrl-C");
        }

        /// A figure of `/proc/PID/status`.
        #[cfg(target_os = "linux")]
        fn figure(&self, name: &str) -> u64 {
            let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
            let line = status.lines().find_map(|line| line.strip_prefix(name)).unwrap();
            line.trim_start_matches(':').split_whitespace().next().unwrap().parse().unwrap()
        }
    }

    impl Drop for Desk {
        fn drop(&mut self) {
            let _ = self.child.kill();
        }
    }

    #[test]
    fn the_page_is_served_with_strict_headers_until_it_is_interrupted() {
        let desk = Desk::open(&["--port", "0"]);
        let (status, head, body) = desk.ask("GET", "/", &desk.host());
        assert_eq!((status, body == page()), (200, true), "{head}");
        for line in [
            "content-security-policy: default-src 'none';",
            "x-content-type-options: nosniff",
            "cache-control: no-store",
            "content-type: text/html; charset=utf-8",
        ] {
            assert!(head.contains(line), "{line} in {head}");
        }
        assert!(!head.contains("content-encoding"), "{head}");

        let (status, head, body) = desk.ask("GET", "/", &format!("{}Accept-Encoding: br, gzip\r\n", desk.host()));
        assert_eq!((status, &body[..2]), (200, &[0x1f, 0x8b][..]), "{head}");
        assert!(head.contains("content-encoding: gzip"), "{head}");
        let refused = format!("{}Accept-Encoding: gzip;q=0\r\n", desk.host());
        assert_eq!(desk.ask("GET", "/", &refused).2, page());
        assert!(desk.ask("HEAD", "/", &desk.host()).2.is_empty());
        assert_eq!(desk.interrupt(), Some(0));
    }

    #[test]
    fn nothing_else_is_served_and_to_no_other_site() {
        let desk = Desk::open(&["--port", "0"]);
        for path in ["/index.html", "/desk.html", "/../Cargo.toml", "//", "/?x"] {
            assert_eq!(desk.ask("GET", path, &desk.host()).0, 404, "{path}");
        }
        assert_eq!(desk.ask("POST", "/", &format!("{}Content-Length: 0\r\n", desk.host())).0, 405);
        let own = desk.host();
        for host in ["Host: example.org\r\n", "Host: 127.0.0.1\r\n", "Host: 127.0.0.1:1\r\n", "", &own.repeat(2)] {
            let (status, head, body) = desk.ask("GET", "/", host);
            assert_eq!(status, 421, "{host}");
            assert!(head.contains("content-security-policy") && body != page(), "{host}");
        }
        assert_eq!(desk.ask("GET", "/", &format!("Host: localhost:{}\r\n", desk.port)).0, 200);
    }

    /// Clients that stop half-way, send no body or read no answer: other clients still get the page, the desk uses few threads
    /// for them, and Ctrl-C ends the desk while they hold on.
    #[test]
    fn clients_that_hold_on_stall_neither_others_nor_the_end() {
        let desk = Desk::open(&["--port", "0"]);
        let get = format!("GET / HTTP/1.1\r\n{}\r\n", desk.host());
        let begun = [
            String::new(),
            "GET / HT".into(),
            format!("POST / HTTP/1.1\r\n{}Content-Length: 1000000\r\n\r\n", desk.host()),
            format!("POST / HTTP/1.1\r\n{}Transfer-Encoding: chunked\r\n\r\n", desk.host()),
            get.repeat(500),
        ];
        let mut held = Vec::new();
        for _ in 0..60 {
            for text in &begun {
                let mut stream = desk.connect();
                // The desk may close the connection before it has received everything.
                let _ = stream.write_all(text.as_bytes());
                held.push(stream);
            }
            assert_eq!(desk.ask("GET", "/", &desk.host()).2, page());
        }
        #[cfg(target_os = "linux")]
        assert!(desk.figure("Threads") < 100, "{} threads", desk.figure("Threads"));
        assert_eq!(desk.interrupt(), Some(0));
    }

    /// A request is limited in length, whichever part is long, and so is the memory for it.
    #[test]
    fn overlong_requests_are_refused() {
        let desk = Desk::open(&["--port", "0"]);
        let padded = |padding: &str| desk.ask("GET", "/", &format!("{}X: {padding}\r\n", desk.host())).0;
        assert_eq!((padded(&"x".repeat(8000)), padded(&"x".repeat(32_000))), (200, 431));
        let short = "X: y\r\n".repeat(5000);
        assert_eq!(desk.ask("GET", "/", &format!("{short}{}", desk.host())).0, 431);
        for (begin, part) in [("GET / HTTP/1.1\r\nX: ", "xxxx"), ("GET / HTTP/1.1\r\n", "X: y\r\n"), ("", "GET ")] {
            let mut stream = desk.connect();
            stream.write_all(begin.as_bytes()).unwrap();
            let part = part.repeat(1 << 15);
            // Far more than the system buffers between the two.
            let refused = (0..1 << 11).find_map(|_| stream.write_all(part.as_bytes()).err());
            let refused = refused.is_some_and(|error| matches!(error.kind(), ConnectionReset | BrokenPipe));
            assert!(refused, "it reads {begin:?} for ever");
        }
        #[cfg(target_os = "linux")]
        assert!(desk.figure("VmHWM") < 60_000, "{} kB", desk.figure("VmHWM"));
    }

    #[test]
    fn a_request_that_does_not_come_is_given_up() {
        let desk = Desk::open(&["--port", "0"]);
        let mut stream = desk.connect();
        stream.write_all(b"GET / HTTP/1.1\r\n").unwrap();
        assert_eq!(stream.read_to_end(&mut Vec::new()).unwrap(), 0);
    }

    #[test]
    fn malformed_requests_are_refused() {
        let desk = Desk::open(&["--port", "0"]);
        let host = desk.host();
        for (method, path, headers) in [
            ("GET", "/ x", host.as_str()),
            ("GET", "", &host),
            ("GET", "/", &format!("{host} folded\r\n")),
            ("GET", "/", &format!("{host}no colon\r\n")),
        ] {
            let status = desk.ask(method, path, headers).0;
            assert!(matches!(status, 400 | 404), "{status} for {path:?} {headers:?}");
        }
    }

    #[test]
    fn a_port_that_is_taken_is_refused_where_it_was_asked_for() {
        let taken = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let port = taken.local_addr().unwrap().port().to_string();
        Folder::new(TRUEAXIS).bad(&["desk", "--port", &port], &["--port: found", "which another program uses"]);
        // Two desks at once: the second finds the usual port taken.
        let [one, other] = [Desk::open(&[]), Desk::open(&[])];
        assert_ne!(one.port, other.port);
    }

    #[test]
    fn the_page_is_written_as_it_is() {
        let folder = Folder::new(TRUEAXIS);
        assert_eq!(folder.good(&["desk", "-o", "desk.html"]), "");
        assert_eq!(fs::read(folder.join("desk.html")).unwrap(), page());
        folder.bad(&["desk", "--write", TRUEAXIS], &["an input is never written"]);
    }
}
