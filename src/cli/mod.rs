//! The commands. Data goes to stdout or the named file, everything else to stderr; see [`run`] for the exit codes.

mod args;
mod convert;
mod failure;
mod film;
mod generate;
mod info;
mod land_args;
mod man;
mod output;
mod parse;
mod progress;
mod render;
mod report;
mod rounded;
mod stress;
mod terrain;
mod view;
mod watch;

use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

use self::args::{Cli, Command};
use self::failure::{Exit, Failure};

/// Runs the command that the arguments name.
///
/// Exit codes: 0 done, 1 failed, 2 usage, 3 bad input, 4 no usable GPU adapter.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return explain_usage(&error),
    };
    // Drivers and wgpu log what they also return; what matters of it becomes a message of ours.
    let level = if cli.verbose { "relief=debug,wgpu=warn" } else { "relief=warn" };
    let terminal = env_logger::Builder::from_env(env_logger::Env::new().default_filter_or(level)).build();
    let level = terminal.filter();
    crate::logbook::install(Box::new(terminal), level);
    match execute(&cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("relief: error: {failure}");
            ExitCode::from(failure.exit as u8)
        }
    }
}

fn execute(cli: &Cli) -> Result<(), Failure> {
    match &cli.command {
        None => view::run(&cli.view),
        Some(Command::View(args)) => view::run(args),
        Some(Command::Render(args)) => render::run(args),
        Some(Command::Report(args)) => report::run(args),
        Some(Command::Stress(args)) => stress::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Convert(args)) => convert::run(args),
        Some(Command::Generate(args)) => generate::run(args),
        Some(Command::Completions { shell }) => {
            let mut script = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "relief", &mut script);
            print(&String::from_utf8_lossy(&script))
        }
        Some(Command::Man { folder }) => man::run(folder.as_deref()),
    }
}

/// Prints help to stdout, or what is wrong with the arguments to stderr.
fn explain_usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // A closed pipe is the reader's choice.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let message = error.render();
    if std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty()) {
        eprint!("relief: {}", message.ansi());
    } else {
        eprint!("relief: {message}");
    }
    // The first word may be a mistyped command, whose options then make no sense.
    let word = std::env::args().nth(1).filter(|word| !std::path::Path::new(word).exists());
    if let Some(hint) = word.and_then(|word| terrain::meant_command(&word)) {
        eprintln!("\n{hint}");
    }
    ExitCode::from(Exit::Usage as u8)
}

/// Writes data to stdout. A reader that has seen enough and closed the pipe is no failure.
fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(Exit::Failed, "cannot write to standard output")
                .line(format!("The system says: {error}.")))
        }
        _ => Ok(()),
    }
}

/// Says how a long run ended.
fn tell(message: &str) {
    eprintln!("relief: {message}");
}

/// Tells of something that does not end the work.
fn warn(message: &str) {
    eprintln!("relief: warning: {message}");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grammar_is_consistent() {
        Cli::command().debug_assert();
    }
}
