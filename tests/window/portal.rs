//! The system's dialogue: a stand-in for the session's bus and for the desktop's portal behind it, which chooses a file at
//! once. The messages are those of the D-Bus specification 0.43 and of the portal `org.freedesktop.portal.FileChooser`.

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use image::{ImageBuffer, Luma};

use crate::harness::{Window, text, widget};

/// Codes of header fields.
const PATH: u8 = 1;
const INTERFACE: u8 = 2;
const MEMBER: u8 = 3;
const ERROR: u8 = 4;
const REPLY_TO: u8 = 5;
const SENDER: u8 = 7;
const SIGNATURE: u8 = 8;

/// Types of messages.
const CALL: u8 = 1;
const REPLY: u8 = 2;
const FAILED: u8 = 3;
const SIGNAL: u8 = 4;

/// Little-endian data, each value at a multiple of its own size.
#[derive(Default)]
struct Data(Vec<u8>);

impl Data {
    fn align(&mut self, size: usize) {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
    }

    fn number(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u32);
        self.0.extend(text.bytes().chain([0]));
    }

    fn signature(&mut self, signature: &str) {
        self.0.push(signature.len() as u8);
        self.0.extend(signature.bytes().chain([0]));
    }

    /// An array whose elements are aligned to `size`: the length does not count what aligns the first.
    fn array(&mut self, size: usize, fill: impl FnOnce(&mut Self)) {
        self.number(0);
        let at = self.0.len() - 4;
        self.align(size);
        let start = self.0.len();
        fill(self);
        let length = (self.0.len() - start) as u32;
        self.0[at..at + 4].copy_from_slice(&length.to_le_bytes());
    }
}

/// A message with text fields, and the serial number of what it answers.
fn message(kind: u8, fields: &[(u8, &str)], answers: Option<u32>, body: &[u8]) -> Vec<u8> {
    let mut data = Data(vec![b'l', kind, 1, 1]);
    data.number(body.len() as u32);
    data.number(1);
    data.array(8, |data| {
        for (code, text) in fields {
            data.align(8);
            data.0.push(*code);
            match *code {
                PATH => data.signature("o"),
                SIGNATURE => data.signature("g"),
                _ => data.signature("s"),
            }
            if *code == SIGNATURE { data.signature(text) } else { data.text(text) }
        }
        if let Some(serial) = answers {
            data.align(8);
            data.0.push(REPLY_TO);
            data.signature("u");
            data.number(serial);
        }
    });
    data.align(8);
    data.0.extend(body);
    data.0
}

/// The text or signature that stands at `at`, whose length has `wide` bytes.
fn text_at(data: &[u8], at: usize, wide: usize) -> Option<&str> {
    let mut length = [0; 4];
    length[..wide].copy_from_slice(data.get(at..at + wide)?);
    std::str::from_utf8(data.get(at + wide..at + wide + u32::from_le_bytes(length) as usize)?).ok()
}

/// What is called: its serial number, its member, and its body.
fn next_call(stream: &mut UnixStream) -> Option<(u8, u32, String, Vec<u8>)> {
    let mut head = [0; 16];
    stream.read_exact(&mut head).ok()?;
    let [body, serial, fields] = [4, 8, 12].map(|at| u32::from_le_bytes(head[at..at + 4].try_into().unwrap()) as usize);
    let mut rest = vec![0; fields.next_multiple_of(8) + body];
    stream.read_exact(&mut rest).ok()?;
    let (fields, body) = (&rest[..fields], &rest[fields.next_multiple_of(8)..]);
    let mut at = 0;
    let mut member = String::new();
    while at < fields.len() {
        let kind = text_at(fields, at + 1, 1)?;
        let value = at + 4;
        let length = match kind {
            "s" | "o" => 4 + text_at(fields, value, 4)?.len() + 1,
            "g" => 1 + text_at(fields, value, 1)?.len() + 1,
            _ => 4,
        };
        if fields[at] == MEMBER {
            member = text_at(fields, value, 4)?.to_owned();
        }
        at = (value + length).next_multiple_of(8);
    }
    Some((head[1], serial as u32, member, body.to_vec()))
}

/// A line without its end. No byte more is read: a message may follow.
fn line(stream: &mut UnixStream) -> Option<String> {
    let mut bytes = Vec::new();
    while bytes.last() != Some(&b'\n') {
        let mut byte = [0];
        stream.read_exact(&mut byte).ok()?;
        bytes.extend(byte);
    }
    Some(String::from_utf8_lossy(&bytes).trim_matches(['\0', '\r', '\n']).to_owned())
}

/// Serves one program's connection: the bus, and the portal that chooses `file`. Tells what dialogues are asked for.
fn serve(mut stream: UnixStream, file: &Path, opened: &Sender<Vec<u8>>) -> Option<()> {
    // Identification, a line at a time, until the program says BEGIN.
    loop {
        let line = line(&mut stream)?;
        let answer: &[u8] = match line.split(' ').next()? {
            "AUTH" if line.contains("EXTERNAL") => b"OK 0123456789abcdef0123456789abcdef\r\n",
            "AUTH" => b"REJECTED EXTERNAL\r\n",
            "BEGIN" => break,
            _ => b"ERROR\r\n",
        };
        stream.write_all(answer).ok()?;
    }
    while let Some((kind, serial, member, body)) = next_call(&mut stream) {
        if kind != CALL {
            continue;
        }
        let bus = (SENDER, "org.freedesktop.DBus");
        let mut answer = Data::default();
        let reply = match member.as_str() {
            "Hello" => {
                answer.text(":1.7");
                message(REPLY, &[bus, (SIGNATURE, "s")], Some(serial), &answer.0)
            }
            "AddMatch" => message(REPLY, &[bus], Some(serial), &[]),
            "OpenFile" => {
                // Every dialogue names itself, so that its program can listen before it opens.
                let name = body.windows(4).position(|name| name == b"rfd_")?;
                let name: String =
                    body[name..].iter().take_while(|byte| **byte != 0).map(|byte| *byte as char).collect();
                let handle = format!("/org/freedesktop/portal/desktop/request/1_7/{name}");
                answer.text(&handle);
                let portal = (SENDER, "org.freedesktop.portal.Desktop");
                let mut both = message(REPLY, &[portal, (SIGNATURE, "o")], Some(serial), &answer.0);
                let mut chosen = Data::default();
                chosen.number(0);
                chosen.array(8, |chosen| {
                    chosen.text("uris");
                    chosen.signature("as");
                    chosen.array(4, |chosen| chosen.text(&format!("file://{}", file.display())));
                });
                let request = [
                    (PATH, handle.as_str()),
                    (INTERFACE, "org.freedesktop.portal.Request"),
                    (MEMBER, "Response"),
                    portal,
                    (SIGNATURE, "ua{sv}"),
                ];
                both.extend(message(SIGNAL, &request, None, &chosen.0));
                opened.send(body).ok()?;
                both
            }
            _ => message(FAILED, &[bus, (ERROR, "org.freedesktop.DBus.Error.ServiceUnknown")], Some(serial), &[]),
        };
        stream.write_all(&reply).ok()?;
    }
    None
}

#[test]
fn the_systems_dialogue_opens_what_is_chosen_there() {
    let libraries = Command::new("/sbin/ldconfig").arg("-p").output();
    if !libraries.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).contains("libdbus-1.so.3")) {
        eprintln!("skipped: the viewer asks portals by libdbus-1.so.3, which this machine lacks (package libdbus-1-3)");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let map: PathBuf = folder.path().join("chosen.png");
    ImageBuffer::from_fn(40, 30, |x, y| Luma([((x * 7 + y * 3) * 200) as u16])).save(&map).unwrap();
    let socket = folder.path().join("bus");
    let listener = UnixListener::bind(&socket).unwrap();
    let (opened, dialogues) = channel();
    let chosen = map.clone();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let (chosen, opened) = (chosen.clone(), opened.clone());
            std::thread::spawn(move || serve(stream, &chosen, &opened));
        }
    });
    let address = format!("unix:path={}", socket.display());
    let environment = [("DBUS_SESSION_BUS_ADDRESS", address.as_str()), ("RELIEF_DIALOGUE", "system")];
    let mut window = Window::open_with("--size 700x500", &environment);
    window.key("ctrl+o");
    let loaded =
        window.settled("the chosen map", |status| text(&status["scene"]["terrain"]["file"]).ends_with("chosen.png"));
    assert!(widget(&loaded, "Do not open").is_none(), "our own dialogue stays closed");
    let asked = dialogues.recv_timeout(Duration::from_secs(5)).unwrap();
    let asked = String::from_utf8_lossy(&asked).into_owned();
    for said in ["Open maps", "multiple", "Elevation files", "*.tif", "All files", "current_folder", "x11:"] {
        assert!(asked.contains(said), "{said:?} is not in the question: {asked:?}");
    }
    window.close();
}
