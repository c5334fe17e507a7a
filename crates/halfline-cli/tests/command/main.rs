//! What people and scripts see of the `halfline` command.

mod arguments;
mod build;
#[cfg(unix)]
mod child;
mod failures;
mod files;
mod info;
mod input;
#[cfg(unix)]
mod interrupt;
mod query;
mod render;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;

/// A folder of its own for each test, in which the command runs.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        Bench { folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    /// The command, not yet run: `line` is split at spaces.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halfline"));
        command.args(line.split_whitespace()).current_dir(self.folder.path());
        command
    }

    fn run(&self, line: &str) -> Outcome {
        let mut command = self.command(line);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Outcome::of(line, end_of(line, command.spawn().unwrap()))
    }

    /// Runs what must succeed and tells its figures.
    fn figures(&self, line: &str) -> Value {
        let outcome = self.run(&format!("{line} --json"));
        outcome.succeeded();
        serde_json::from_str(&outcome.stdout)
            .unwrap_or_else(|error| panic!("`{line}`: {error} in {}", outcome.stdout))
    }

    /// The names of all files in the folder, sorted.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// Waits for the end of a child, for longer than anything takes on a busy machine: a hang ends here.
#[track_caller]
fn end_of(line: &str, child: Child) -> Output {
    const PATIENCE: Duration = Duration::from_secs(600);
    let process = child.id().to_string();
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(child.wait_with_output().unwrap()));
    receiver.recv_timeout(PATIENCE).unwrap_or_else(|_| {
        let _ = Command::new("kill").args(["-KILL", &process]).status();
        panic!("waited {PATIENCE:?} until `{line}` ends");
    })
}

/// What was said on stderr, less how far a stage is, which is told after ten seconds on a busy machine.
fn without_progress(stderr: &str) -> String {
    let is_progress = |line: &str| {
        let stage = line.strip_prefix("halfline: ").and_then(|said| said.split_once(": "));
        stage.is_some_and(|(stage, _)| stage != "error")
    };
    stderr.split_inclusive('\n').filter(|line| !is_progress(line)).collect()
}

/// How the command ended and what it said.
struct Outcome {
    line: String,
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Outcome {
    fn of(line: &str, output: Output) -> Outcome {
        Outcome {
            line: line.into(),
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: without_progress(&String::from_utf8(output.stderr).unwrap()),
        }
    }

    #[track_caller]
    fn succeeded(&self) -> &Outcome {
        assert_eq!(self.code, Some(0), "`{}`: {}", self.line, self.stderr);
        assert_eq!(self.stderr, "", "`{}`", self.line);
        self
    }

    /// Exit code 1, one line on stderr which says `reason` about `file`, and nothing on stdout.
    #[track_caller]
    fn failed(&self, file: &str, reason: &str) -> &Outcome {
        assert_eq!(self.code, Some(1), "`{}`: {}", self.line, self.stderr);
        assert_eq!(self.stdout, "", "`{}`", self.line);
        let said = self.stderr.strip_suffix('\n').unwrap_or_default();
        assert!(!said.contains('\n'), "`{}` says more than a line: {said}", self.line);
        let start = format!("halfline: error: {file}: ");
        assert!(said.starts_with(&start), "`{}` says {said:?}, not {start}", self.line);
        assert!(said.contains(reason), "`{}` says {said:?}, not {reason:?}", self.line);
        self
    }

    /// Exit code 2, `reason` and a hint on stderr, and nothing on stdout.
    #[track_caller]
    fn refused(&self, reason: &str) -> &Outcome {
        assert_eq!(self.code, Some(2), "`{}`: {}", self.line, self.stderr);
        assert_eq!(self.stdout, "", "`{}`", self.line);
        assert!(self.stderr.starts_with("error: "), "`{}` says {}", self.line, self.stderr);
        assert!(self.stderr.contains(reason), "`{}` says {}", self.line, self.stderr);
        assert!(self.stderr.contains("--help"), "`{}` gives no hint: {}", self.line, self.stderr);
        self
    }
}

/// A cube from -1 to 1 of six squares.
const CUBE: &str = "\
ply
format ascii 1.0
element vertex 8
property float x
property float y
property float z
element face 6
property list uchar int vertex_indices
end_header
-1 -1 -1
1 -1 -1
1 1 -1
-1 1 -1
-1 -1 1
1 -1 1
1 1 1
-1 1 1
4 3 2 1 0
4 4 5 6 7
4 0 1 5 4
4 2 3 7 6
4 1 2 6 5
4 0 4 7 3
";
