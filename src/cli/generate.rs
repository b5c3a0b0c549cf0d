//! `relief generate`: a height map from a recipe, and the recipe beside it.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::convert::spare_file;
use super::failure::{Exit, Failure};
use super::output::Output;
use super::parse;
use super::progress::Progress;
use crate::heightfield::Sidecar;
use crate::heightfield::generate::recipe_file::{self, RecipeFileError};
use crate::heightfield::generate::{Kind, MakeError, Recipe, RecipeError};
use crate::heightfield::save::save_png16;

/// Shown below the options.
pub(super) const EXAMPLES: &str = "\
Examples:
  relief generate ridged --size 1025 --seed 7 -o ridged.png
  relief generate perlin --size 2049x1025 --tileable --roughness 0.55 --scale 5 -o hills.png
  relief generate ridged --seed 3 --hydraulic 0.5 --thermal 20 -o eroded.png
  relief generate diamond-square --size 513 --schedule 1,0.7,0.3 --roughness 0.45 --smoothing 2 -o soft.png
  relief generate --recipe eroded.toml -o again.png             the same bytes once more
  relief generate --recipe eroded.toml --seed 4 -o other.png

The recipe goes into the TOML file beside the map. The same recipe makes the same bytes on every machine.";

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// The kind of landscape
    #[arg(value_enum, required_unless_present = "recipe")]
    kind: Option<Kind>,
    /// Begin with the [recipe] of this TOML file; options given here beat it
    #[arg(long, value_name = "FILE.toml", value_parser = parse::input_file())]
    recipe: Option<PathBuf>,
    /// Samples along each side, 2 to 32768, or columns × rows [default: 1024]
    #[arg(long, value_name = "N|WxH", value_parser = parse::grid, allow_hyphen_values = true)]
    size: Option<[u32; 2]>,
    /// The same seed makes the same landscape [default: 1]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Make opposite borders equal; diamond-square then needs a side such as 1025, a few cells halved and 1
    #[arg(long)]
    tileable: bool,
    /// The height map, a 16-bit greyscale PNG; relief convert makes other formats of it
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Replace a map that exists, and its recipe
    #[arg(long)]
    force: bool,

    /// Height of an octave, or of a level of halving, over the one before, 0 to 1 [default: 0.5]
    #[arg(long, value_name = "R", allow_negative_numbers = true, help_heading = "Fractal")]
    roughness: Option<f64>,
    /// Octaves of noise, 1 to 32 [default: down to two samples]
    #[arg(long, value_name = "N", value_parser = parse::count, allow_negative_numbers = true, help_heading = "Fractal")]
    octaves: Option<u32>,
    /// Frequency of an octave over the one before, 1.1 to 8 [default: 2]
    #[arg(long, value_name = "L", allow_negative_numbers = true, help_heading = "Fractal")]
    lacunarity: Option<f64>,
    /// Cells of the coarsest octave along the longer side, 0.1 to 1024 [default: 3]
    #[arg(long, value_name = "N", allow_negative_numbers = true, help_heading = "Fractal")]
    scale: Option<f64>,
    /// diamond-square: how far each halving displaces, coarse to fine; then the roughness goes on [default: 1]
    #[arg(
        long,
        value_name = "A,B,…",
        value_delimiter = ',',
        value_parser = parse::number::<f64>,
        allow_negative_numbers = true,
        help_heading = "Fractal"
    )]
    schedule: Option<Vec<f64>>,
    /// diamond-square: passes of smoothing, 0 to 64 [default: 0]
    #[arg(long, value_name = "N", value_parser = parse::count, allow_negative_numbers = true, help_heading = "Fractal")]
    smoothing: Option<u32>,
    /// ridged: what the noise is subtracted from, 0.5 to 2 [default: 1]
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Fractal")]
    ridge_offset: Option<f64>,
    /// ridged: how much detail gathers on crests, 0 to 16 [default: 2]
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Fractal")]
    ridge_gain: Option<f64>,
    /// warped: how far places are displaced, in cells of the coarsest octave, 0 to 8 [default: 0.8]
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Fractal")]
    warp: Option<f64>,

    /// Drops of rain for each sample, 0 to 64; 0.5 digs valleys [default: 0]
    #[arg(long, value_name = "DROPS", allow_negative_numbers = true, help_heading = "Erosion")]
    hydraulic: Option<f64>,
    /// How fast drops take up soil, 0 to 1 [default: 0.3]
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Erosion")]
    hydraulic_strength: Option<f64>,
    /// Samples around a drop that soil is taken from, 1 to 8 [default: 3]
    #[arg(long, value_name = "N", value_parser = parse::count, allow_negative_numbers = true, help_heading = "Erosion")]
    hydraulic_radius: Option<u32>,
    /// Steps of a drop at most, 1 to 1000 [default: 64]
    #[arg(long, value_name = "N", value_parser = parse::count, allow_negative_numbers = true, help_heading = "Erosion")]
    hydraulic_lifetime: Option<u32>,
    /// Steps in which steep slopes slide, 0 to 10000; 20 make screes [default: 0]
    #[arg(long, value_name = "STEPS", value_parser = parse::count, allow_negative_numbers = true, help_heading = "Erosion")]
    thermal: Option<u32>,
    /// Share of what can slide in a step that does, 0 to 1 [default: 1]
    #[arg(long, value_name = "X", allow_negative_numbers = true, help_heading = "Erosion")]
    thermal_strength: Option<f64>,
    /// Rise over run at which material rests, 0 to 100 [default: 0.7]
    #[arg(long, value_name = "SLOPE", allow_negative_numbers = true, help_heading = "Erosion")]
    talus: Option<f64>,
}

/// The option that sets what the recipe calls by another name.
const OPTIONS: [(&str, &str); 12] = [
    ("midpoint.schedule", "schedule"),
    ("midpoint.smoothing", "smoothing"),
    ("ridges.offset", "ridge-offset"),
    ("ridges.gain", "ridge-gain"),
    ("warp.strength", "warp"),
    ("hydraulic.drops", "hydraulic"),
    ("hydraulic.strength", "hydraulic-strength"),
    ("hydraulic.radius", "hydraulic-radius"),
    ("hydraulic.lifetime", "hydraulic-lifetime"),
    ("thermal.iterations", "thermal"),
    ("thermal.strength", "thermal-strength"),
    ("thermal.talus", "talus"),
];

impl GenerateArgs {
    /// The recipe's file, then the options.
    fn compose(&self) -> Result<Recipe, Failure> {
        let mut recipe = self.recipe.as_deref().map(recipe_file::read).transpose()?.unwrap_or_default();
        set(&mut recipe.kind, self.kind);
        set(&mut recipe.size, self.size);
        set(&mut recipe.seed, self.seed);
        recipe.tileable |= self.tileable;
        set(&mut recipe.roughness, self.roughness);
        recipe.octaves = self.octaves.or(recipe.octaves);
        set(&mut recipe.lacunarity, self.lacunarity);
        set(&mut recipe.scale, self.scale);
        set(&mut recipe.midpoint.schedule, self.schedule.clone());
        set(&mut recipe.midpoint.smoothing, self.smoothing);
        set(&mut recipe.ridges.offset, self.ridge_offset);
        set(&mut recipe.ridges.gain, self.ridge_gain);
        set(&mut recipe.warp.strength, self.warp);
        set(&mut recipe.hydraulic.drops, self.hydraulic);
        set(&mut recipe.hydraulic.strength, self.hydraulic_strength);
        set(&mut recipe.hydraulic.radius, self.hydraulic_radius);
        set(&mut recipe.hydraulic.lifetime, self.hydraulic_lifetime);
        set(&mut recipe.thermal.iterations, self.thermal);
        set(&mut recipe.thermal.strength, self.thermal_strength);
        set(&mut recipe.thermal.talus, self.talus);
        recipe.validate().map_err(|error| bad_option(&error))?;
        Ok(recipe)
    }
}

fn set<T>(field: &mut T, given: Option<T>) {
    if let Some(given) = given {
        *field = given;
    }
}

/// The message for a setting that came from an option.
fn bad_option(error: &RecipeError) -> Failure {
    let option = OPTIONS.iter().find(|(field, _)| *field == error.field).map_or(error.field, |(_, option)| option);
    Failure::usage(format!("--{option} {} is not possible", error.value))
        .line(&error.why)
        .line(format!("give {}", error.instead))
}

impl From<RecipeFileError> for Failure {
    fn from(error: RecipeFileError) -> Self {
        let exit = if matches!(error, RecipeFileError::InTheWay { .. }) { Exit::Failed } else { Exit::BadInput };
        Self::new(exit, error.to_string())
    }
}

impl From<MakeError> for Failure {
    fn from(error: MakeError) -> Self {
        Self::new(Exit::Failed, error.to_string())
    }
}

impl GenerateArgs {
    /// Options that say something, and change nothing: each with the reason.
    fn without_effect(&self, recipe: &Recipe) -> Vec<String> {
        let kind = |kind: Kind| recipe.kind == kind;
        let noise = !kind(Kind::DiamondSquare);
        let rain = recipe.hydraulic.drops > 0.0;
        let slides = recipe.thermal.iterations > 0;
        let of = |name: &str| format!("it belongs to {name}, and this is {}", recipe.kind.name());
        [
            ("octaves", self.octaves.is_some(), noise, "diamond-square halves down to the samples".to_owned()),
            ("lacunarity", self.lacunarity.is_some(), noise, "diamond-square always halves".to_owned()),
            ("scale", self.scale.is_some(), noise, "diamond-square begins with the whole map".to_owned()),
            ("schedule", self.schedule.is_some(), kind(Kind::DiamondSquare), of("diamond-square")),
            ("smoothing", self.smoothing.is_some(), kind(Kind::DiamondSquare), of("diamond-square")),
            ("ridge-offset", self.ridge_offset.is_some(), kind(Kind::Ridged), of("ridged")),
            ("ridge-gain", self.ridge_gain.is_some(), kind(Kind::Ridged), of("ridged")),
            ("warp", self.warp.is_some(), kind(Kind::Warped), of("warped")),
            (
                "hydraulic-strength",
                self.hydraulic_strength.is_some(),
                rain,
                "it does not rain: say --hydraulic".to_owned(),
            ),
            ("hydraulic-radius", self.hydraulic_radius.is_some(), rain, "it does not rain: say --hydraulic".to_owned()),
            (
                "hydraulic-lifetime",
                self.hydraulic_lifetime.is_some(),
                rain,
                "it does not rain: say --hydraulic".to_owned(),
            ),
            ("thermal-strength", self.thermal_strength.is_some(), slides, "nothing slides: say --thermal".to_owned()),
            ("talus", self.talus.is_some(), slides, "nothing slides: say --thermal".to_owned()),
        ]
        .into_iter()
        .filter(|(_, given, used, _)| *given && !used)
        .map(|(option, _, _, why)| format!("--{option} changes nothing: {why}"))
        .collect()
    }

    /// The file, which has to be one that a PNG may go to.
    fn check_ending(&self) -> Result<(), Failure> {
        let ending = self.output.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("png") => Ok(()),
            other => Err(Failure::usage(format!("{} does not end in .png", self.output.display()))
                .line(match other {
                    Some("toml") => "The recipe goes into the file of the same name that ends in .toml.",
                    _ => "A generated map is a 16-bit PNG, whatever its name.",
                })
                .line("Name it with .png; relief convert map.png -o map.tif makes other formats of it.")),
        }
    }
}

/// A map that exists is replaced by the one that its recipe makes again, or by those who say --force.
fn spare(file: &Path, beside: &Path, args: &GenerateArgs, recipe: &Recipe) -> Result<(), Failure> {
    let same = recipe_file::read(beside).is_ok_and(|made| made == *recipe);
    spare_file(file, &args.output, args.force || same)?;
    // A recipe without its map would be lost, too.
    if !args.force && !same && recipe_file::read(beside).is_ok() {
        return Err(Failure::new(Exit::Failed, format!("cannot write {}", args.output.display()))
            .line(format!("{} holds another recipe, which would be replaced.", beside.display()))
            .line("Nothing was written. Say --force to replace it, or give another name."));
    }
    Ok(())
}

pub(crate) fn run(args: &GenerateArgs) -> Result<(), Failure> {
    args.check_ending()?;
    let recipe = args.compose()?;
    let output = Output::prepare(&args.output)?;
    let file = output.regular_file()?;
    let beside = Sidecar::path_of(&args.output);
    for remark in args.without_effect(&recipe) {
        super::warn(&remark);
    }
    spare(file, &beside, args, &recipe)?;
    let sidecar = Output::prepare(&beside)?;
    let text = recipe_file::sidecar_text(&beside, existing(&beside)?.as_deref(), &recipe)?;
    let field = {
        let progress = Progress::start("generating");
        recipe.make(recipe.size, &|share| progress.set(share), &AtomicBool::new(false))?
    };
    let _progress = Progress::start("writing the height map");
    save_png16(&field, file).map_err(|error| Failure::new(Exit::Failed, error.to_string()))?;
    sidecar.write(text.as_bytes())
}

/// What the sidecar holds now, if there is one.
fn existing(path: &Path) -> Result<Option<String>, Failure> {
    match std::fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(_) => Err(RecipeFileError::InTheWay { path: path.to_path_buf() }.into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::*;
    use crate::cli::args::{Cli, Command};

    fn compose(line: &str) -> Result<Recipe, Failure> {
        match Cli::try_parse_from(line.split_whitespace()).unwrap().command {
            Some(Command::Generate(args)) => args.compose(),
            other => panic!("not generate: {other:?}"),
        }
    }

    #[test]
    fn every_option_reaches_the_recipe() {
        let recipe = compose(
            "relief generate warped --force --size 33x17 --seed 5 --tileable --roughness 0.4 --octaves 6 --lacunarity 2.5 --scale 4 \
             --schedule 1,0.5 --smoothing 2 --ridge-offset 1.1 --ridge-gain 3 --warp 0.7 --hydraulic 0.25 \
             --hydraulic-strength 0.2 --hydraulic-radius 2 --hydraulic-lifetime 50 --thermal 9 --thermal-strength 0.5 \
             --talus 0.6 -o a.png",
        );
        let mut expected = Recipe { size: [33, 17], tileable: true, ..Recipe::new(Kind::Warped, 5) };
        (expected.roughness, expected.octaves, expected.lacunarity, expected.scale) = (0.4, Some(6), 2.5, 4.0);
        (expected.midpoint.schedule, expected.midpoint.smoothing) = (vec![1.0, 0.5], 2);
        (expected.ridges.offset, expected.ridges.gain, expected.warp.strength) = (1.1, 3.0, 0.7);
        let rain = &mut expected.hydraulic;
        (rain.drops, rain.strength, rain.radius, rain.lifetime) = (0.25, 0.2, 2, 50);
        (expected.thermal.iterations, expected.thermal.strength, expected.thermal.talus) = (9, 0.5, 0.6);
        assert_eq!(recipe.unwrap(), expected);
        assert_eq!(compose("relief generate perlin -o a.png").unwrap(), Recipe::new(Kind::Perlin, 1));
    }

    #[test]
    fn options_have_the_names_that_messages_use() {
        let command = Cli::command();
        let generate = command.get_subcommands().find(|command| command.get_name() == "generate").unwrap();
        for (_, option) in OPTIONS {
            assert!(generate.get_arguments().any(|argument| argument.get_long() == Some(option)), "{option}");
        }
    }
}
