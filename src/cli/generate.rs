//! `relief generate`: a height map from a seed.

use super::args::GenerateArgs;
use super::failure::{Exit, Failure};
use super::output::Output;
use super::progress::Progress;
use crate::heightfield::generate::generate_with_progress;
use crate::heightfield::save::save_png16;

pub(crate) fn run(args: &GenerateArgs) -> Result<(), Failure> {
    let output = Output::prepare(&args.output)?;
    let file = output.regular_file()?;
    let field = {
        let progress = Progress::start("generating");
        generate_with_progress(args.kind, args.size, args.seed, &|share| progress.set(share))
    };
    let _progress = Progress::start("writing the height map");
    save_png16(&field, file).map_err(|error| Failure::new(Exit::Failed, error.to_string()))
}
