//! A small static file server for this machine: the page while one works on it, and for the browser tests.
//!
//! It behaves like the plainest static host (no special headers that a real one would lack), except that nothing is
//! cached.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};

/// A folder to serve.
pub struct Site {
    root: PathBuf,
    /// The files and folders of `root` that the world may see; all of them if empty.
    visible: &'static [&'static str],
}

impl Site {
    pub fn new(root: PathBuf, visible: &'static [&'static str]) -> Self {
        Self { root, visible }
    }
}

/// Longer requests than this are no browser's.
const LONGEST_HEAD: u64 = 16 * 1024;

/// Serves from threads of its own until the program ends. A busy port gives way to the next one; port 0 asks for any.
pub fn start(site: Site, port: u16) -> Result<SocketAddr> {
    let (listener, address) = bind(port)?;
    let site = Arc::new(site);
    thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let site = Arc::clone(&site);
            // A browser that hangs up in the middle is no event.
            thread::spawn(move || answer(&site, stream).ok());
        }
    });
    Ok(address)
}

fn bind(port: u16) -> Result<(TcpListener, SocketAddr)> {
    let tries = if port == 0 { 1 } else { 100 };
    for port in (port..=u16::MAX).take(tries) {
        match TcpListener::bind((Ipv4Addr::LOCALHOST, port)) {
            Ok(listener) => {
                let address = listener.local_addr()?;
                return Ok((listener, address));
            }
            Err(error) if error.kind() == io::ErrorKind::AddrInUse => {}
            Err(error) => {
                return Err(error).with_context(|| format!("could not listen on port {port}"));
            }
        }
    }
    bail!("all ports from {port} on are busy; choose another with --port")
}

fn answer(site: &Site, mut stream: TcpStream) -> io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    stream.set_write_timeout(Some(Duration::from_secs(60)))?;
    let mut reader = BufReader::new(stream.try_clone()?).take(LONGEST_HEAD);
    let mut request = String::new();
    reader.read_line(&mut request)?;
    // The headers say nothing that would change the answer, but a socket that closes on unread bytes is reset.
    let mut line = String::new();
    while reader.read_line(&mut line)? > 2 {
        line.clear();
    }
    respond(site, &request, &mut stream)
}

/// Answers one request line.
fn respond(site: &Site, request: &str, out: &mut impl Write) -> io::Result<()> {
    let mut words = request.split_whitespace();
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    if !matches!(method, "GET" | "HEAD") {
        return refuse(out, "405 Method Not Allowed", "Allow: GET, HEAD\r\n");
    }
    let path = target.split(['?', '#']).next().unwrap_or_default();
    let Some(relative) = relative(path) else {
        return refuse(out, "400 Bad Request", "");
    };
    let first = relative.iter().next();
    let is_visible = site.visible.is_empty()
        || first.is_none_or(|first| site.visible.iter().any(|name| first == *name));
    if !is_visible {
        return refuse(out, "404 Not Found", "");
    }
    let mut file = site.root.join(&relative);
    if file.is_dir() {
        if !path.ends_with('/') {
            return refuse(out, "301 Moved Permanently", &format!("Location: {path}/\r\n"));
        }
        file.push("index.html");
    }
    let Ok(mut body) = File::open(&file) else {
        return refuse(out, "404 Not Found", "");
    };
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
        media_type(&file),
        body.metadata()?.len()
    );
    out.write_all(head.as_bytes())?;
    if method == "GET" {
        io::copy(&mut body, out)?;
    }
    out.flush()
}

fn refuse(out: &mut impl Write, status: &str, header: &str) -> io::Result<()> {
    write!(
        out,
        "HTTP/1.1 {status}\r\n{header}Content-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n\
         {status}",
        status.len()
    )?;
    out.flush()
}

/// The path of a URL as a path below a root: no way up, nothing hidden, nothing that only some systems understand.
fn relative(path: &str) -> Option<PathBuf> {
    let decoded = percent_decoded(path.strip_prefix('/')?)?;
    if decoded.contains(['\\', ':', '\0']) {
        return None;
    }
    let relative = PathBuf::from(decoded);
    let is_plain = |part: Component| matches!(part, Component::Normal(name) if !name.to_string_lossy().starts_with('.'));
    relative.components().all(is_plain).then_some(relative)
}

fn percent_decoded(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        rest = tail;
        if byte == b'%' {
            let (digits, tail) = rest.split_at_checked(2)?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
            rest = tail;
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

fn media_type(file: &Path) -> &'static str {
    let extension = file.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match extension.as_str() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "json" => "application/json",
        "wasm" => "application/wasm",
        "webmanifest" => "application/manifest+json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "webp" => "image/webp",
        "ico" => "image/x-icon",
        "txt" | "md" | "obj" => "text/plain; charset=utf-8",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with a page, something hidden and something private.
    fn site(name: &str) -> Site {
        let root =
            std::env::temp_dir().join(format!("cutflow-server-{name}-{}", std::process::id()));
        for (file, text) in [
            ("index.html", "page"),
            ("www/pkg/a b.wasm", "wasm"),
            ("www/.key", "no"),
            ("src/lib.rs", "no"),
        ] {
            let file = root.join(file);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, text).unwrap();
        }
        Site::new(root, &["index.html", "www"])
    }

    fn reply(site: &Site, request: &str) -> String {
        let mut out = Vec::new();
        respond(site, request, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_root_is_the_page_and_wasm_has_its_media_type() {
        let site = site("good");
        let page = reply(&site, "GET /?renderer=webgl HTTP/1.1");
        assert!(page.starts_with("HTTP/1.1 200") && page.ends_with("\r\n\r\npage"), "{page}");
        let wasm = reply(&site, "GET /www/pkg/a%20b.wasm HTTP/1.1");
        assert!(wasm.contains("Content-Type: application/wasm\r\n"), "{wasm}");
        let head = reply(&site, "HEAD / HTTP/1.1");
        assert!(head.contains("Content-Length: 4\r\n") && head.ends_with("\r\n\r\n"), "{head}");
        std::fs::remove_dir_all(&site.root).unwrap();
    }

    #[test]
    fn nothing_outside_is_served() {
        let site = site("bad");
        for path in [
            "/../secret",
            "/www/../../secret",
            "/www/%2e%2e/%2e%2e/secret",
            "/www/..%2fsecret",
            "//etc/passwd",
            "/www/.key",
            "/src/lib.rs",
            "/www/..\\secret",
            "/%zz",
            "/%",
            "etc/passwd",
            "",
        ] {
            let reply = reply(&site, &format!("GET {path} HTTP/1.1"));
            assert!(reply.starts_with("HTTP/1.1 40"), "{path}: {reply}");
        }
        assert!(reply(&site, "POST / HTTP/1.1").starts_with("HTTP/1.1 405"));
        std::fs::remove_dir_all(&site.root).unwrap();
    }

    #[test]
    fn a_folder_without_its_slash_is_redirected() {
        let site = Site::new(site("slash").root, &[]);
        assert!(reply(&site, "GET /www HTTP/1.1").contains("Location: /www/\r\n"));
        std::fs::remove_dir_all(&site.root).unwrap();
    }

    #[test]
    fn a_busy_port_gives_way_to_the_next() {
        let (held, first) = bind(0).unwrap();
        let (_, second) = bind(first.port()).unwrap();
        assert!(second.port() > first.port());
        drop(held);
    }

    #[test]
    fn it_answers_over_a_socket() {
        let site = site("socket");
        let root = site.root.clone();
        let address = start(site, 0).unwrap();
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        assert!(text.starts_with("HTTP/1.1 200 OK\r\n") && text.ends_with("page"), "{text}");
        std::fs::remove_dir_all(root).unwrap();
    }
}
