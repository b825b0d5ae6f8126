//! Running other programs.

use std::fmt;
use std::io::{self, Read};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// What stopped the command, in words for the terminal.
#[derive(Debug)]
pub struct Failure(pub String);

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Failure {}

impl From<String> for Failure {
    fn from(text: String) -> Self {
        Self(text)
    }
}

/// A failure with these words.
pub fn fail<T>(text: impl Into<String>) -> Result<T, Failure> {
    Err(Failure(text.into()))
}

/// What a program left behind.
#[derive(Debug)]
pub struct Finished {
    /// Whether its exit code was 0.
    pub passed: bool,
    /// Its standard output.
    pub out: String,
    /// Its standard error.
    pub err: String,
}

/// Runs a program to its end, or ends it when its time is over.
///
/// # Errors
/// If it cannot be started or does not end in time.
pub fn run(command: &mut Command, limit: Duration) -> Result<Finished, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command
        .spawn()
        .map_err(|error| Failure(format!("{name} cannot be started: {error}")))?;
    let out = drain(child.stdout.take());
    let err = drain(child.stderr.take());
    let passed = wait(&mut child, limit).map_err(|error| Failure(format!("{name}: {error}")))?;
    let text =
        |reader: thread::JoinHandle<Vec<u8>>| String::from_utf8_lossy(&reader.join().unwrap_or_default()).into_owned();
    Ok(Finished {
        passed,
        out: text(out),
        err: text(err),
    })
}

/// Like [`run`], and a failure if the program fails.
///
/// # Errors
/// With the end of what it said.
pub fn run_well(command: &mut Command, limit: Duration) -> Result<String, Failure> {
    let finished = run(command, limit)?;
    if finished.passed {
        return Ok(finished.out);
    }
    let said = format!("{}{}", finished.out, finished.err);
    let lines: Vec<&str> = said.lines().collect();
    let tail = lines[lines.len().saturating_sub(40)..].join("\n");
    fail(format!("{:?} failed:\n{tail}", command))
}

/// Whether a program can be started and answers `--version`.
pub fn answers(program: &str) -> bool {
    let mut command = Command::new(program);
    command.arg("--version");
    run(&mut command, Duration::from_secs(20)).is_ok_and(|f| f.passed)
}

fn drain(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut pipe) = pipe {
            // What a broken pipe has delivered is kept; the verdict comes from the exit code.
            let _ = pipe.read_to_end(&mut bytes);
        }
        bytes
    })
}

fn wait(child: &mut Child, limit: Duration) -> io::Result<bool> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status.success());
        }
        if start.elapsed() > limit {
            child.kill()?;
            child.wait()?;
            return Err(io::Error::other(format!("not finished after {} s", limit.as_secs())));
        }
        thread::sleep(Duration::from_millis(20));
    }
}
