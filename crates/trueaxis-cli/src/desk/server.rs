//! Serves the page on 127.0.0.1 until Ctrl-C.
//!
//! Each connection has its own thread and one request, with limits on size and time, so it can delay neither the other
//! connections nor Ctrl-C.

use super::{answer, page};
use crate::output::{print, report_line};
use anyhow::{Context, Result, anyhow};
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Weak, mpsc};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Default port, fixed so that a bookmark stays valid.
const USUAL_PORT: u16 = 8471;

/// Most connections at once. One more closes the oldest, so idle clients cannot block others.
const CONNECTIONS: usize = 64;
/// Longest head of a request, bytes.
const HEAD: usize = 16 << 10;
/// Bytes read and discarded after the head: closing a connection with unread bytes can discard the answer too.
const BEHIND: u64 = 64 << 10;
/// Time limit for receiving a request.
const RECEIVE_TIMEOUT: Duration = Duration::from_secs(10);
/// Time limit for sending the answer.
const SEND_TIMEOUT: Duration = Duration::from_secs(60);

/// Serves the page at `port`; without one, at the usual port or, if another program uses that, at any free one.
pub(super) fn serve(port: Option<u16>) -> Result<()> {
    let listener = listener(port)?;
    let port = listener.local_addr().context("127.0.0.1")?.port();
    let plain: Arc<[u8]> = page::plain()?.into();
    let (interrupt, interrupted) = mpsc::channel();
    ctrlc::set_handler(move || {
        let _ = interrupt.send(());
    })
    .context("Ctrl-C")?;
    print(&format!("http://127.0.0.1:{port}/\n"))?;
    report_line("note: open this address in a browser; Ctrl-C ends the desk");
    thread::Builder::new().spawn(move || accept(&listener, port, &plain)).context("127.0.0.1")?;
    // When this returns, the process ends and closes every connection.
    interrupted.recv().context("Ctrl-C")
}

fn listener(port: Option<u16>) -> Result<TcpListener> {
    let at = |port: u16| TcpListener::bind(SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    match (at(port.unwrap_or(USUAL_PORT)), port) {
        (Ok(listener), _) => Ok(listener),
        (Err(_), None) => at(0).context("127.0.0.1: no port is free"),
        (Err(error), Some(port)) if error.kind() == ErrorKind::AddrInUse => {
            Err(anyhow!("--port: found {port}, which another program uses, needed a free one (0: any)"))
        }
        (Err(error), Some(port)) => Err(error).context(format!("--port: cannot serve at {port}")),
    }
}

fn accept(listener: &TcpListener, port: u16, plain: &Arc<[u8]>) {
    // Each thread owns its connection, which closes when the thread ends.
    let mut open: VecDeque<(Weak<TcpStream>, JoinHandle<()>)> = VecDeque::new();
    for stream in listener.incoming() {
        open.retain(|(_, thread)| !thread.is_finished());
        if open.len() >= CONNECTIONS
            && let Some((oldest, thread)) = open.pop_front()
        {
            if let Some(oldest) = oldest.upgrade() {
                let _ = oldest.shutdown(Shutdown::Both);
            }
            let _ = thread.join();
        }
        // Accepting fails if the client has disconnected or the process has no free file descriptor.
        let Ok(stream) = stream.map(Arc::new) else { continue };
        let (held, plain) = (Arc::downgrade(&stream), Arc::clone(plain));
        if let Ok(thread) = thread::Builder::new().spawn(move || one(&stream, port, &plain)) {
            open.push_back((held, thread));
        }
    }
}

/// Handles one request. A client that disconnects or is too slow gets no answer.
fn one(stream: &TcpStream, port: u16, plain: &[u8]) {
    let mut of_client = Until { stream, end: Instant::now() + RECEIVE_TIMEOUT };
    if let Ok(head) = head(&mut of_client) {
        let answer = head.map_or_else(|| answer::too_long(HEAD), |head| answer::to(&head, port, plain));
        of_client.end = Instant::now() + SEND_TIMEOUT;
        if of_client.write_all(&answer).is_ok() && stream.shutdown(Shutdown::Write).is_ok() {
            of_client.end = Instant::now() + RECEIVE_TIMEOUT;
            let _ = io::copy(&mut of_client.take(BEHIND), &mut io::sink());
        }
    }
}

/// The head of a request, without the empty line that ends it; `None` if it is too long.
fn head(of_client: &mut Until) -> io::Result<Option<Vec<u8>>> {
    const END: &[u8] = b"\r\n\r\n";
    let (mut head, mut part) = (Vec::new(), [0; 4096]);
    while head.len() <= HEAD {
        let searched = head.len().saturating_sub(END.len() - 1);
        match of_client.read(&mut part)? {
            0 => return Err(ErrorKind::UnexpectedEof.into()),
            read => head.extend_from_slice(&part[..read]),
        }
        if let Some(at) = head[searched..].windows(END.len()).position(|four| four == END) {
            head.truncate(searched + at);
            return Ok(Some(head));
        }
    }
    Ok(None)
}

/// A connection with a deadline, however slowly the bytes arrive.
struct Until<'s> {
    stream: &'s TcpStream,
    end: Instant,
}

impl Until<'_> {
    /// Time left. Never zero, which would mean waiting without a limit.
    fn left(&self) -> io::Result<Option<Duration>> {
        let left = self.end.saturating_duration_since(Instant::now());
        if left.is_zero() { Err(ErrorKind::TimedOut.into()) } else { Ok(Some(left)) }
    }
}

impl Read for Until<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.left()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Until<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.left()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
