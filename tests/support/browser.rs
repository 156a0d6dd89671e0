//! A headless Chromium that is driven through two pipes: no port is opened, and no name is looked up.
//!
//! The browser reads commands of the DevTools protocol from its file descriptor 3 and answers on 4, each JSON ended by a NUL.

use std::io::{BufRead, BufReader, Write};
use std::process::ChildStdin;
use std::sync::mpsc::{Receiver, channel};

use super::*;

/// Longest wait for an answer; this machine may be busy.
const PATIENCE: Duration = Duration::from_secs(120);

/// Of a whole page, CSS pixels.
const LONGEST_PICTURE: f64 = 12000.0;

/// The shell gives its own standard input and output to the browser as 3 and 4, and becomes the browser.
const BECOME_THE_BROWSER: &str = r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null 2>&1"#;

const FLAGS: [&str; 12] = [
    "--headless",
    "--remote-debugging-pipe",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--hide-scrollbars",
    // Whatever a page asks for, nothing leaves this machine.
    "--host-resolver-rules=MAP * ~NOTFOUND",
];

/// One browser with one page.
pub struct Browser {
    /// Its helpers end with it.
    _child: Running,
    commands: ChildStdin,
    answers: Receiver<Value>,
    sent: u64,
    session: Option<String>,
    /// What the page did since it was opened, oldest first.
    events: Vec<Value>,
    _profile: Place,
}

/// Debian's program, or the one that `CROSSGRAIN_BROWSER` names.
fn program() -> PathBuf {
    std::env::var_os("CROSSGRAIN_BROWSER").map_or("chromium".into(), PathBuf::from)
}

fn missing(method: &str, error: &dyn std::error::Error) -> ! {
    let program = program().display().to_string();
    panic!("{program}: no answer to {method}: {error}; ci/install_browser installs it")
}

impl Browser {
    /// Panics if there is no browser: `ci/install_browser` installs one.
    pub fn start() -> Self {
        let profile = new_folder();
        let mut child = Command::new("bash")
            .args(["-c", BECOME_THE_BROWSER, "bash"])
            .arg(program())
            .args(FLAGS)
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("bash is there");
        let commands = child.stdin.take().expect("a pipe");
        let mut from = BufReader::new(child.stdout.take().expect("a pipe"));
        let (sender, answers) = channel();
        std::thread::spawn(move || {
            let mut message = Vec::new();
            while from.read_until(0, &mut message).is_ok_and(|read| read > 0) {
                message.pop();
                let told = serde_json::from_slice(&message).map(|value| sender.send(value));
                if !matches!(told, Ok(Ok(()))) {
                    return;
                }
                message.clear();
            }
        });
        let mut browser = Browser {
            _child: Running(child),
            commands,
            answers,
            sent: 0,
            session: None,
            events: Vec::new(),
            _profile: profile,
        };
        let page = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": page["targetId"], "flatten": true});
        let session = browser.call("Target.attachToTarget", attach);
        browser.session = session["sessionId"].as_str().map(str::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Sends a command and waits for its answer; what happens meanwhile is kept.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.sent += 1;
        let mut command = json!({"id": self.sent, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            command["sessionId"] = json!(session);
        }
        let sent = write!(self.commands, "{command}\0").and_then(|()| self.commands.flush());
        sent.unwrap_or_else(|error| missing(method, &error));
        loop {
            let answer = self.answer(method);
            if answer["id"] == self.sent {
                let error = &answer["error"];
                assert!(error.is_null(), "{method}: {error}");
                return answer["result"].clone();
            }
            self.events.push(answer);
        }
    }

    fn answer(&self, method: &str) -> Value {
        let answer = self.answers.recv_timeout(PATIENCE);
        answer.unwrap_or_else(|error| missing(method, &error))
    }

    /// Opens a file and waits until it is loaded and drawn.
    pub fn open(&mut self, page: &Path) {
        self.events.clear();
        let page = page.canonicalize().expect("a page");
        let url = json!({"url": format!("file://{}", page.display())});
        let opened = self.call("Page.navigate", url);
        assert!(opened["errorText"].is_null(), "{opened}");
        while self.of("Page.loadEventFired").next().is_none() {
            let event = self.answer("Page.navigate");
            self.events.push(event);
        }
        self.settle();
    }

    /// Waits until what was changed is laid out and drawn; what was logged has arrived then.
    pub fn settle(&mut self) {
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))");
    }

    /// What kinds of things happened since the page was opened, their parameters.
    pub fn of(&self, method: &str) -> impl Iterator<Item = &Value> {
        let events = self
            .events
            .iter()
            .filter(move |event| event["method"] == method);
        events.map(|event| &event["params"])
    }

    /// The value of an expression, of a promise too, in the page. Panics if it throws.
    pub fn evaluate(&mut self, expression: &str) -> Value {
        let wanted = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let result = self.call("Runtime.evaluate", wanted);
        let thrown = &result["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {thrown}");
        result["result"]["value"].clone()
    }

    /// A window of this size, CSS pixels.
    pub fn resize(&mut self, width: u32, height: u32) {
        let size =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        self.call("Emulation.setDeviceMetricsOverride", size);
        self.settle();
    }

    /// A medium, `screen` or `print`, and a colour scheme, `light` or `dark`.
    pub fn emulate(&mut self, medium: &str, scheme: &str) {
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        let media = json!({"media": medium, "features": features});
        self.call("Emulation.setEmulatedMedia", media);
        self.settle();
    }

    /// A click of the left button in the middle of the first element that this selector finds.
    pub fn click(&mut self, selector: &str) {
        let place = self.evaluate(&format!(
            "(() => {{ const found = document.querySelector({selector:?}); found.scrollIntoView({{block: 'center'}}); \
             const box = found.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
        ));
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({"type": kind, "x": place[0], "y": place[1], "button": "left", "clickCount": 1});
            self.call("Input.dispatchMouseEvent", event);
        }
        self.settle();
    }

    /// The key Enter while the first element that this selector finds has the focus.
    pub fn press_enter(&mut self, selector: &str) {
        self.evaluate(&format!("document.querySelector({selector:?})?.focus()"));
        for kind in ["keyDown", "keyUp"] {
            let key = json!({"type": kind, "key": "Enter", "code": "Enter", "windowsVirtualKeyCode": 13, "text": "\r"});
            self.call("Input.dispatchKeyEvent", key);
        }
        self.settle();
    }

    /// Types on the keyboard, one key after the other.
    pub fn type_text(&mut self, text: &str) {
        for letter in text.chars() {
            let key = json!({"type": "char", "text": letter.to_string()});
            self.call("Input.dispatchKeyEvent", key);
        }
        self.settle();
    }

    /// What the window shows, or the whole page up to a length that a picture can have; a PNG file.
    pub fn screenshot(&mut self, path: &Path, whole: bool) {
        let mut wanted = json!({"format": "png", "captureBeyondViewport": whole});
        if whole {
            let size = self.evaluate("[innerWidth, document.scrollingElement.scrollHeight]");
            let height = size[1].as_f64().map(|height| height.min(LONGEST_PICTURE));
            wanted["clip"] =
                json!({"x": 0, "y": 0, "width": size[0], "height": height, "scale": 1});
        }
        let picture = self.call("Page.captureScreenshot", wanted);
        let bytes = base64(picture["data"].as_str().expect("a picture"));
        fs::write(path, bytes).expect("a writable folder");
    }

    /// The page printed, a PDF file.
    pub fn pdf(&mut self) -> Vec<u8> {
        let wanted = json!({"printBackground": true, "preferCSSPageSize": true});
        let printed = self.call("Page.printToPDF", wanted);
        base64(printed["data"].as_str().expect("a document"))
    }
}

/// Bytes from their base64 text.
fn base64(text: &str) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let value = |letter: u8| LETTERS.iter().position(|other| *other == letter);
    let bits: Vec<usize> = text.bytes().filter_map(value).collect();
    let group = |four: &[usize]| {
        let all = four.iter().fold(0, |sum, bits| sum << 6 | bits) << (6 * (4 - four.len()));
        [all >> 16, all >> 8, all].map(|byte| (byte & 0xff) as u8)[..four.len() - 1].to_vec()
    };
    bits.chunks(4).flat_map(group).collect()
}
