//! Values of options: text in, a checked value or a message out.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::{RangedU64ValueParser, TypedValueParser, ValueParser};
use glam::DVec3;

use crate::heightfield::{Crater, HEIGHT_SCALES};
use crate::scene::light::Clock;
use crate::scene::sun::days_in_month;
use crate::scene::{CompareSettings, CraterSettings, LevelUnit, Technique, Water};
use crate::scene_file::{FARTHEST, FIELDS_OF_VIEW, MOST_HALVINGS, MOST_SAMPLES, SMALLEST, readable};

/// A crater as far as the command line gives it: the brush of the scene fills in the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CraterSpec {
    x: f64,
    z: f64,
    radius: Option<f64>,
    depth: Option<f64>,
    rim: Option<f64>,
}

impl CraterSpec {
    /// The crater, completed by the scene's brush.
    pub(crate) fn complete(self, settings: &CraterSettings) -> Crater {
        let brush = settings.brush_at(self.x, self.z);
        Crater {
            radius: self.radius.unwrap_or(brush.radius),
            depth: self.depth.unwrap_or(brush.depth),
            rim: self.rim.unwrap_or(brush.rim),
            ..brush
        }
    }
}

/// A technique to compare with, and where the line is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CompareSpec {
    technique: Technique,
    share: Option<f64>,
}

impl CompareSpec {
    /// Splits the picture; without a share the line stays where the scene has it.
    pub(crate) fn apply(self, settings: &mut CompareSettings) {
        let share = self.share.unwrap_or(settings.share);
        *settings = CompareSettings { enabled: true, technique: self.technique, share };
    }
}

/// `linear-binary@0.4`, or the technique alone.
pub(crate) fn compare(text: &str) -> Result<CompareSpec, String> {
    let (name, share) = match text.split_once('@') {
        Some((name, share)) => {
            (name, Some(in_range(share, |share: f64| (0.0..=1.0).contains(&share), "a share of the width, 0 to 1")?))
        }
        None => (text, None),
    };
    match Technique::CHOICES.into_iter().find(|technique| technique.name() == name) {
        Some(technique) => Ok(CompareSpec { technique, share }),
        None => Err(format!(
            "there is no technique `{name}`; there are {}",
            Technique::CHOICES.map(Technique::name).join(", ")
        )),
    }
}

/// A file to read. `-` would mean standard input elsewhere; here it is a mistake.
pub(crate) fn input_file() -> ValueParser {
    let parser = clap::builder::PathBufValueParser::new().try_map(|path: PathBuf| {
        if path.as_os_str() == "-" { Err("standard input cannot be read; give the name of a file") } else { Ok(path) }
    });
    ValueParser::new(parser)
}

/// `1280x800`.
pub(crate) fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or("expected WIDTHxHEIGHT, such as 1280x800")?;
    let side = |name: &str, text: &str| match text.parse::<u32>() {
        Ok(0) => Err(format!("the {name} is 0, but a picture has at least 1 pixel")),
        Ok(side) => Ok(side),
        Err(_) => Err(format!("the {name} `{text}` is not a whole number of pixels")),
    };
    Ok([side("width", width)?, side("height", height)?])
}

/// `x,z,width,height` in samples.
pub(crate) fn window(text: &str) -> Result<[u32; 4], String> {
    let number =
        |part: &str| part.trim().parse::<u32>().map_err(|_| format!("`{part}` is not a whole number of samples"));
    let numbers = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    match numbers[..] {
        [x, z, width, height] if width >= 2 && height >= 2 => Ok([x, z, width, height]),
        [_, _, _, _] => Err(String::from("a part has at least 2×2 samples")),
        _ => Err(format!("expected four numbers x,z,width,height, found {}", numbers.len())),
    }
}

/// How many of something.
pub(crate) fn count(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("`{text}` is not a whole number from 0 to {}", u32::MAX))
}

/// `1025` for both sides of a map, or `2049x1025`.
pub(crate) fn grid(text: &str) -> Result<[u32; 2], String> {
    let (columns, rows) = text.split_once(['x', 'X', '×']).unwrap_or((text, text));
    let side = |text: &str| {
        text.parse::<u32>()
            .map_err(|_| format!("`{text}` is not a whole number; expected N or COLUMNSxROWS, such as 1025"))
    };
    Ok([side(columns)?, side(rows)?])
}

/// `128..512`, or one number for both.
pub(crate) fn samples(text: &str) -> Result<[u32; 2], String> {
    let (min, max) = text.split_once("..").unwrap_or((text, text));
    let count = |text: &str| match text.trim().parse::<u32>() {
        Ok(count @ 1..=MOST_SAMPLES) => Ok(count),
        Ok(count) => Err(format!("{count} is not between 1 and {MOST_SAMPLES}")),
        Err(_) => Err(format!("`{text}` is not a whole number; expected MIN..MAX, such as 128..512")),
    };
    match [count(min)?, count(max)?] {
        [min, max] if min > max => Err(format!("MIN ({min}) is above MAX ({max}); write {max}..{min}")),
        range => Ok(range),
    }
}

/// Halvings after the linear search.
pub(crate) fn halvings() -> RangedU64ValueParser<u32> {
    RangedU64ValueParser::new().range(0..=u64::from(MOST_HALVINGS))
}

/// `x,y,z` in world units.
pub(crate) fn point(text: &str) -> Result<DVec3, String> {
    match numbers::<f64>(text)?.as_slice() {
        &[x, y, z] if DVec3::new(x, y, z).abs().max_element() <= FARTHEST => Ok(DVec3::new(x, y, z)),
        &[_, _, _] => Err(format!("farther than {FARTHEST:e} from the origin, where no terrain can be seen")),
        other => Err(format!("expected three numbers x,y,z, found {}", other.len())),
    }
}

/// The sun's azimuth and elevation in degrees.
pub(crate) fn sun(text: &str) -> Result<[f32; 2], String> {
    match numbers::<f32>(text)?.as_slice() {
        &[azimuth, elevation] if azimuth.abs() <= 360.0 && elevation.abs() <= 90.0 => Ok([azimuth, elevation]),
        &[_, _] => Err(String::from("the azimuth is within -360 and 360 degrees, the elevation within -90 and 90")),
        other => Err(format!("expected two numbers azimuth,elevation, found {}", other.len())),
    }
}

/// Where the sea stands: a number and what it counts in, or wherever it usually does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WaterLevel(Option<(f32, LevelUnit)>);

impl WaterLevel {
    /// Makes a sea of it.
    pub(crate) fn set(self, water: &mut Water) {
        water.enabled = true;
        (water.level, water.levels) = match self.0 {
            Some((level, unit)) => (Some(level), unit),
            None => (None, LevelUnit::default()),
        };
    }
}

/// `auto`, a share of the map's height, or metres: `120m`.
pub(crate) fn water(text: &str) -> Result<WaterLevel, String> {
    if text == "auto" {
        return Ok(WaterLevel(None));
    }
    let (number, unit) =
        text.strip_suffix('m').map_or((text, LevelUnit::Share), |metres| (metres.trim_end(), LevelUnit::Metres));
    match number.parse::<f32>() {
        Ok(level) if level.abs() <= 1e6 => Ok(WaterLevel(Some((level, unit)))),
        _ => Err(format!("`{text}` is no level; write a share of the map's height (0.3), metres (120m), or auto")),
    }
}

/// A date and an hour, UTC.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Time {
    date: (i32, u32, u32),
    hour: f64,
}

impl Time {
    /// Sets a clock to it.
    pub(crate) fn set(self, clock: &mut Clock) {
        clock.enabled = true;
        ((clock.year, clock.month, clock.day), clock.hour) = (self.date, self.hour);
    }
}

/// `YYYY-MM-DDTHH:MM`.
pub(crate) fn time(text: &str) -> Result<Time, String> {
    let wrong = || String::from("expected a date and a time of day, UTC, like 2026-06-21T19:30");
    let (date, time) = text.trim_end_matches('Z').split_once('T').ok_or_else(wrong)?;
    let numbers =
        |text: &str, mark: char| -> Option<Vec<u32>> { text.split(mark).map(|part| part.parse().ok()).collect() };
    let (date, time) = numbers(date, '-').zip(numbers(time, ':')).ok_or_else(wrong)?;
    match (date.as_slice(), time.as_slice()) {
        (&[year @ 1900..=2100, month @ 1..=12, day @ 1..=31], &[hour @ 0..=24, minute @ 0..=59])
            if hour < 24 || minute == 0 =>
        {
            let (year, days) = (year as i32, days_in_month(year as i32, month));
            if day > days {
                return Err(format!("that month has {days} days"));
            }
            Ok(Time { date: (year, month, day), hour: f64::from(hour) + f64::from(minute) / 60.0 })
        }
        ([_, _, _], [_, _]) => Err(String::from(
            "the year is within 1900 and 2100, and there are 12 months of at most 31 days of 24 hours",
        )),
        _ => Err(wrong()),
    }
}

/// `x,z[,radius[,depth[,rim]]]`.
pub(crate) fn crater(text: &str) -> Result<CraterSpec, String> {
    let numbers = numbers::<f64>(text)?;
    let (&[x, z], rest) = numbers.split_at_checked(2).ok_or("expected at least two numbers x,z")? else {
        return Err(String::from("expected at least two numbers x,z"));
    };
    if x.abs().max(z.abs()) > FARTHEST {
        return Err(format!("farther than {FARTHEST:e} from the origin, where there is no ground"));
    }
    if rest.len() > 3 {
        return Err(format!("expected at most x,z,radius,depth,rim, found {} numbers", numbers.len()));
    }
    let spec =
        CraterSpec { x, z, radius: rest.first().copied(), depth: rest.get(1).copied(), rim: rest.get(2).copied() };
    if spec.radius.is_some_and(|radius| !(SMALLEST..=10.0).contains(&radius)) {
        return Err(String::from("the radius is more than 0 and at most 10 world units"));
    }
    if rest.iter().skip(1).any(|share| !(0.0..=10.0).contains(share)) {
        return Err(String::from("depth and rim are shares of the terrain's height, 0 to 10"));
    }
    Ok(spec)
}

/// Height of the box in world units.
pub(crate) fn height_scale(text: &str) -> Result<f64, String> {
    let (least, most) = (HEIGHT_SCALES.start(), HEIGHT_SCALES.end());
    in_range(text, |scale| HEIGHT_SCALES.contains(&scale), &format!("at least {least} and at most {most}"))
}

/// Vertical field of view in degrees.
pub(crate) fn fov(text: &str) -> Result<f64, String> {
    let (least, most) = (readable(*FIELDS_OF_VIEW.start()), readable(*FIELDS_OF_VIEW.end()));
    in_range(text, |fov| FIELDS_OF_VIEW.contains(&fov), &format!("at least {least} and at most {most} degrees"))
}

/// Repeats of the diffuse texture.
pub(crate) fn repeats(text: &str) -> Result<f32, String> {
    in_range(text, |repeats: f32| (SMALLEST..=4096.0).contains(&f64::from(repeats)), "more than 0 and at most 4096")
}

fn in_range<T: Number>(text: &str, valid: impl Fn(T) -> bool, range: &str) -> Result<T, String> {
    let value = number::<T>(text)?;
    if valid(value) { Ok(value) } else { Err(format!("must be {range}")) }
}

/// What this module reads: `f32` and `f64`.
pub(crate) trait Number: FromStr + Copy {
    fn finite(self) -> bool;
}

impl Number for f32 {
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Number for f64 {
    fn finite(self) -> bool {
        self.is_finite()
    }
}

pub(crate) fn number<T: Number>(text: &str) -> Result<T, String> {
    match text.trim().parse::<T>() {
        Ok(value) if value.finite() => Ok(value),
        Ok(_) => Err(format!("`{text}` is not finite")),
        Err(_) => Err(format!("`{text}` is not a number")),
    }
}

fn numbers<T: Number>(text: &str) -> Result<Vec<T>, String> {
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_their_month() {
        for there in ["2026-02-28T12:00", "2024-02-29T00:00", "2000-02-29T12:00", "2026-12-31T24:00Z"] {
            assert!(time(there).is_ok(), "{there}");
        }
        let many = ["2026-02-30T12:00", "2026-04-31T12:00", "2026-02-29T12:00", "1900-02-29T12:00"];
        for not in many.into_iter().chain(["2026-06-01T24:59", "2026-06-01T12:60", "2026-13-01T12:00", "2026-06-01"]) {
            assert!(time(not).is_err(), "{not}");
        }
        assert_eq!(time("2026-02-30T12:00"), Err("that month has 28 days".into()));
    }

    #[test]
    fn sizes() {
        assert_eq!(size("1280x800"), Ok([1280, 800]));
        for wrong in ["0x5", "5x0", "5", "x", "5x", "-5x5", "5.5x5", "99999999999x1"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn windows() {
        assert_eq!(window("0, 5,100,2"), Ok([0, 5, 100, 2]));
        for wrong in ["1,2,3", "1,2,3,4,5", "0,0,1,9", "-1,0,5,5", "a,b,c,d", ""] {
            assert!(window(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sides_of_maps() {
        assert_eq!((grid("1025"), grid("2049x3")), (Ok([1025; 2]), Ok([2049, 3])));
        for wrong in ["", "x", "5x", "-5", "5.5", "1e9", "99999999999"] {
            assert!(grid(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn sample_ranges() {
        assert_eq!(samples("128..512"), Ok([128, 512]));
        assert_eq!(samples("300"), Ok([300, 300]));
        for wrong in ["0..5", "5..4", "..", "5..", "-1..4", "1..99999999", "a..b"] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn points_are_three_finite_numbers() {
        assert_eq!(point("-0.35, 0.2,1"), Ok(DVec3::new(-0.35, 0.2, 1.0)));
        for wrong in ["1,2", "1,2,3,4", "1,2,nan", "inf,0,0", "1e400,0,0", "1e11,0,0", "a,b,c", ""] {
            assert!(point(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_crater_takes_what_is_left_out_from_the_brush() {
        let settings = CraterSettings::default();
        assert_eq!(crater("0.5,0.25").unwrap().complete(&settings), settings.brush_at(0.5, 0.25));
        let full = crater("0.5,0.25,0.1,0.2,0.3").unwrap().complete(&settings);
        assert_eq!((full.radius, full.depth, full.rim), (0.1, 0.2, 0.3));
        for wrong in ["0.5", "0.5,0.5,0", "0.5,0.5,0.1,-1", "0.5,0.5,0.1,0.1,0.1,0.1", "0.5,nan"] {
            assert!(crater(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_comparison_is_a_technique_and_perhaps_a_share() {
        let mut settings = CompareSettings { share: 0.3, ..CompareSettings::default() };
        compare("linear").unwrap().apply(&mut settings);
        assert_eq!(settings, CompareSettings { enabled: true, technique: Technique::Linear, share: 0.3 });
        compare("max-mipmap@0.75").unwrap().apply(&mut settings);
        assert_eq!(settings, CompareSettings { enabled: true, technique: Technique::MaxMipmap, share: 0.75 });
        for wrong in ["", "@0.5", "lineer", "linear@", "linear@1.1", "linear@-0.1", "linear@nan", "linear@a"] {
            assert!(compare(wrong).is_err(), "{wrong}");
        }
        assert!(compare("lineer").unwrap_err().contains("linear-binary"));
    }

    #[test]
    fn scales_and_angles_have_ends() {
        assert!(height_scale("-0.1").is_err() && height_scale("0").is_ok() && height_scale("1001").is_err());
        assert!(
            fov("0").is_err()
                && fov("180").is_err()
                && fov("NaN").is_err()
                && fov("1e-310").is_err()
                && fov("60").is_ok()
        );
        assert!(sun("10").is_err() && sun("10,91").is_err() && sun("300,32").is_ok());
    }
}
