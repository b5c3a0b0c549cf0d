//! `relief man`: the manual pages, made from the grammar of the command line.

use std::path::Path;

use clap::CommandFactory;
use clap_mangen::Man;

use super::args::Cli;
use super::failure::{Exit, Failure};
use super::output::{Output, make_folder};
use super::print;

/// Prints the page of `relief`, or writes it and one for each command into `folder`.
pub(crate) fn run(folder: Option<&Path>) -> Result<(), Failure> {
    let mut command = Cli::command();
    command.build();
    let Some(folder) = folder else { return print(&page(command)?) };
    make_folder(folder)?;
    let commands = command.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help");
    let pages: Vec<_> = commands.cloned().chain([command.clone()]).collect();
    for command in pages {
        let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
        Output::prepare(&folder.join(format!("{name}.1")))?.write(page(command)?.as_bytes())?;
    }
    Ok(())
}

fn page(command: clap::Command) -> Result<String, Failure> {
    let mut text = Vec::new();
    let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
    let written = Man::new(command).title(name.to_uppercase()).render(&mut text);
    written.map_err(|error| Failure::new(Exit::Failed, format!("cannot write the manual page of {name}: {error}")))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
