//! One row in a process of its own: the parent's side.
//!
//! The child gets its [`Job`] as an argument and answers with one line of JSON on its standard output; its standard
//! error goes to the scene's log. Its standard input is a pipe that only closes when the parent ends, whatever ends
//! it: the child watches it, so that no child outlives its parent.

use super::job::{Job, JobResult};
use super::output::OutputError;
use crate::record::Exit;
use crate::report::WriteError;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How a child ended.
pub(crate) enum Ended {
    /// With this result.
    With(Box<JobResult>),
    /// The run was interrupted and the child stopped.
    Interrupted,
}

/// The program to start and the signal to stop.
pub(crate) struct Spawner<'a> {
    /// The `validation` program.
    pub(crate) program: PathBuf,
    /// Set when the run is to stop.
    pub(crate) interrupted: &'a AtomicBool,
}

impl Spawner<'_> {
    /// Runs a job in a child process for at most `limit`; a crash or a time-out is a row, not an error.
    ///
    /// # Errors
    /// When the log cannot be written or the program cannot be started.
    pub(crate) fn run(&self, job: &Job, limit: Duration, log: &Path) -> Result<Ended, OutputError> {
        let log_fails = |source| WriteError { path: log.to_owned(), source };
        let mut log_file = File::options().append(true).create(true).open(log).map_err(log_fails)?;
        writeln!(
            log_file,
            "== {} at {} with {} threads, seed {}",
            job.method, job.ladder, job.threads, job.seed
        )
        .map_err(log_fails)?;
        let mut child = self.start(job, &log_file)?;
        let answer = child.stdout.take().map(|mut pipe| {
            std::thread::spawn(move || {
                let mut text = String::new();
                // A child that writes something else than UTF-8 has no answer; its exit status tells the rest.
                let _ = pipe.read_to_string(&mut text);
                text
            })
        });
        let status = self.wait(&mut child, limit).map_err(log_fails)?;
        let text = answer.and_then(|reader| reader.join().ok()).unwrap_or_default();
        let exit = match status {
            Waited::Interrupted => return Ok(Ended::Interrupted),
            Waited::TimedOut => Exit::TimedOut { limit_seconds: limit.as_secs_f64().ceil() as u64 },
            Waited::Exited(status) => match text.lines().last().map(serde_json::from_str::<JobResult>) {
                Some(Ok(result)) => {
                    log_row(&mut log_file, &result.row.exit).map_err(log_fails)?;
                    return Ok(Ended::With(Box::new(result)));
                }
                _ => Exit::Crashed { message: status_message(status) },
            },
        };
        log_row(&mut log_file, &exit).map_err(log_fails)?;
        Ok(Ended::With(Box::new(JobResult { row: job.empty_row(exit), pictures: Vec::new() })))
    }

    fn start(&self, job: &Job, log: &File) -> Result<Child, OutputError> {
        let fails = |source| OutputError::Read { path: self.program.clone(), source };
        let argument = serde_json::to_string(job).map_err(std::io::Error::from).map_err(fails)?;
        let mut command = Command::new(&self.program);
        command.arg("child").arg(argument).env("RAYON_NUM_THREADS", job.threads.to_string());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(log.try_clone().map_err(fails)?);
        // Ctrl-C at a terminal reaches every process of the group; the parent stops the child itself, so that a
        // row that was interrupted cannot be taken for one that crashed.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command.spawn().map_err(fails)
    }

    fn wait(&self, child: &mut Child, limit: Duration) -> std::io::Result<Waited> {
        let start = Instant::now();
        let mut pause = Duration::from_micros(200);
        loop {
            if let Some(status) = child.try_wait()? {
                return Ok(Waited::Exited(status));
            }
            let stopped = if self.interrupted.load(Ordering::Relaxed) {
                Some(Waited::Interrupted)
            } else {
                (start.elapsed() >= limit).then_some(Waited::TimedOut)
            };
            if let Some(stopped) = stopped {
                child.kill()?;
                child.wait()?;
                return Ok(stopped);
            }
            std::thread::sleep(pause);
            // Short rows are not kept waiting, long ones are not disturbed.
            pause = (pause * 2).min(Duration::from_millis(20));
        }
    }
}

enum Waited {
    Exited(ExitStatus),
    TimedOut,
    Interrupted,
}

fn log_row(log: &mut File, exit: &Exit) -> std::io::Result<()> {
    let words = crate::checks::stop_reason(exit).unwrap_or_else(|| "completed".to_owned());
    writeln!(log, "{words}")
}

fn status_message(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        let name = match signal {
            4 => " (illegal instruction)",
            6 => " (abort)",
            9 => " (killed, perhaps for lack of memory)",
            11 => " (segmentation fault)",
            _ => "",
        };
        return format!("the process was ended by signal {signal}{name}");
    }
    format!("the process ended with {status} and without a result")
}

/// Ends this process when its standard input closes: the parent is gone.
pub fn end_with_parent() {
    std::thread::spawn(|| {
        let mut sink = [0_u8; 64];
        loop {
            match std::io::stdin().read(&mut sink) {
                Ok(0) | Err(_) => std::process::exit(1),
                Ok(_) => {}
            }
        }
    });
}
