//! Exit codes only; the commands are in [`relief::cli`].

fn main() -> std::process::ExitCode {
    relief::cli::run()
}
