//! ESRI rasters without a header of their own: `.bil`, `.bip`, `.bsq` and `.flt`, each with a `.hdr` beside it.

use super::gather::{Gatherer, Order, Plan, nodata_values};
use super::source::{Fault, Source};
use super::{Elevation, Format, Georeference, ImportOptions, PixelIs, Rows, Sample, VerticalUnit};

pub(super) fn decode(source: &mut Source, options: &ImportOptions) -> Result<Elevation, Fault> {
    let Some(text) = source.companion("hdr") else {
        return Err(Fault::Unclear(
            "its header is missing: a text file of the same name, ending in .hdr".into(),
            "put it beside the file, or say --raw-size and --raw-type after renaming it to .raw".into(),
        ));
    };
    if text.trim_start().starts_with("ENVI") {
        return Err(Fault::Unsupported(
            "an ENVI header".into(),
            "convert it to GeoTIFF, with gdal_translate for instance",
        ));
    }
    let header = Header::parse(&text);
    let float = source.path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("flt"));
    let bits = header.number("nbits").unwrap_or(if float { 32.0 } else { 8.0 });
    let kind = header.word("pixeltype").unwrap_or(if float { "FLOAT" } else { "UNSIGNEDINT" }).to_ascii_uppercase();
    match (kind.as_str(), bits as u32) {
        ("FLOAT", 32) => read::<f32>(source, options, &header),
        ("FLOAT", 64) => read::<f64>(source, options, &header),
        ("SIGNEDINT", 8) => read::<i8>(source, options, &header),
        ("SIGNEDINT", 16) => read::<i16>(source, options, &header),
        ("SIGNEDINT", 32) => read::<i32>(source, options, &header),
        ("UNSIGNEDINT", 8) => read::<u8>(source, options, &header),
        // Older files say nothing of signs; elevations have them.
        ("UNSIGNEDINT", 16) if header.word("pixeltype").is_none() => read::<i16>(source, options, &header),
        ("UNSIGNEDINT", 16) => read::<u16>(source, options, &header),
        ("UNSIGNEDINT", 32) => read::<u32>(source, options, &header),
        (kind, bits) => Err(Fault::Unsupported(
            format!("samples of {bits} bits ({})", super::source::one_line(kind)),
            "convert it to GeoTIFF, with gdal_translate for instance",
        )),
    }
}

fn read<T: Sample>(source: &mut Source, options: &ImportOptions, header: &Header) -> Result<Elevation, Fault> {
    let prj = source.companion("prj");
    let (columns, rows) = (header.whole("ncols")?, header.whole("nrows")?);
    let bands = header.number("nbands").unwrap_or(1.0);
    if !(1.0..=65535.0).contains(&bands) {
        return Err(Fault::Damaged(format!("its header has {bands} bands")));
    }
    let bands = bands as u64;
    let band = u64::from(options.band.unwrap_or(1));
    if band == 0 || band > bands {
        return Err(Fault::Unclear(format!("it has no band {band}"), format!("choose --band 1 to {bands}")));
    }
    let samples = columns.saturating_mul(rows).saturating_mul(bands);
    if samples.saturating_mul(T::BYTES as u64) > source.bytes {
        return Err(Fault::Promises([columns, rows]));
    }
    let plan = Plan::new(columns, rows, options)?;
    let bytes = T::BYTES as u64;
    let layout = header.word("layout").unwrap_or("BIL").to_ascii_uppercase();
    let packed = columns * bytes;
    let (first, step, stride) = match layout.as_str() {
        "BIP" => ((band - 1) * bytes, bytes * bands, packed * bands),
        "BSQ" => ((band - 1) * packed * rows, bytes, packed),
        _ => {
            let in_band = header.at_least("bandrowbytes", packed, source.bytes)?;
            let in_all = header.at_least("totalrowbytes", in_band * bands, source.bytes)?;
            ((band - 1) * in_band, bytes, in_all)
        }
    };
    let lead = header.at_least("skipbytes", 0, source.bytes)? + first;
    let big = header.word("byteorder").is_some_and(|order| order.starts_with(['M', 'm']));

    // Floats without a word on holes still have Esri's.
    let usual: &[f64] = if T::NAME == "f32" { &[-9999.0, f32::MIN as f64] } else { &[] };
    let of_file = header.number("nodata").or(header.number("nodata_value"));
    let of_file = of_file.map_or_else(|| usual.to_vec(), |value| vec![value]);
    let order = Order { south_first: options.flip == Some(true), east_first: false };
    let mut gatherer = Gatherer::<T>::new(plan, order, &nodata_values(options, &of_file));
    source.seek(lead)?;
    let layout = Rows { width: columns as usize, step: step as usize, stride: stride as usize, skip: 0, big };
    layout.gather(source, &mut gatherer)?;

    let mut elevation = gatherer.finish(Format::Raster)?;
    if bands > 1 && options.band.is_none() {
        elevation.warnings.push(format!("it has {bands} bands: the first is taken; choose another with --band"));
    }
    let size = [columns as u32, rows as u32];
    elevation.georeference =
        header.place(rows).map(|place| place.with_projection_file(prj.as_deref(), size, &mut elevation.warnings));
    elevation.vertical_unit = Some(VerticalUnit::Metre);
    Ok(elevation)
}

/// A `.hdr`: one key and one word a line.
struct Header(Vec<(String, String)>);

impl Header {
    fn parse(text: &str) -> Self {
        let line = |line: &str| {
            let mut words = line.split_whitespace();
            Some((words.next()?.to_ascii_lowercase(), words.next()?.to_owned()))
        };
        Self(text.lines().filter_map(line).collect())
    }

    fn word(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| known == key).map(|(_, word)| word.as_str())
    }

    fn number(&self, key: &str) -> Option<f64> {
        self.word(key)?.parse().ok()
    }

    fn whole(&self, key: &str) -> Result<u64, Fault> {
        match self.word(key).map(str::parse::<u64>) {
            Some(Ok(value)) => Ok(value),
            _ => Err(Fault::Damaged(format!("its .hdr has no {key}"))),
        }
    }

    /// A number of bytes that cannot be below `least`, nor above the file's.
    fn at_least(&self, key: &str, least: u64, most: u64) -> Result<u64, Fault> {
        let value = self.word(key).map_or(Ok(least), str::parse::<u64>);
        match value {
            Ok(value) if value >= least && value <= most.max(least) => Ok(value),
            _ => Err(Fault::Damaged(format!("the {key} of its .hdr is wrong"))),
        }
    }

    /// The place of the first, north-western sample.
    fn place(&self, rows: u64) -> Option<Georeference> {
        let cell = self.number("cellsize");
        let [dx, dy] = [self.number("xdim").or(cell)?, self.number("ydim").or(cell)?];
        if let (Some(x), Some(y)) = (self.number("ulxmap"), self.number("ulymap")) {
            return Some(Georeference::new([x, y], [dx, -dy]));
        }
        let half = |corner: &str, centre: &str, step: f64| {
            self.number(centre)
                .map(|at| (at, PixelIs::Point))
                .or(self.number(corner).map(|at| (at + step * 0.5, PixelIs::Area)))
        };
        let (west, pixel) = half("xllcorner", "xllcenter", dx)?;
        let (south, _) = half("yllcorner", "yllcenter", dy)?;
        let north = south + dy * (rows.max(1) - 1) as f64;
        Some(Georeference { pixel, ..Georeference::new([west, north], [dx, -dy]) })
    }
}
