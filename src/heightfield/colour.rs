//! A diffuse texture made from the heights: bands of rock on steep ground, soil and woods on flat ground.
//!
//! The bands and their order are those of the Grand Canyon, from the dark schist of the gorge over red sandstone and
//! cream cliffs to the wooded plateau, but they hang on normalised heights, so every landscape gets them: all but maps
//! that reach far below 0 m, whose sea is blue and whose land begins green at the shore.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::generate::hash;
use super::{HeightField, Holes, SampleRect};

/// Samples around a texel that its colour depends on, including the one cell of interpolation.
const REACH: u32 = HOLLOW_RADIUS as u32 + 2;

/// Distance in samples at which the ground around is compared with a place to see whether it lies in a hollow.
const HOLLOW_RADIUS: i32 = 3;

/// Rock by normalised height (sRGB).
const ROCK: [(f32, Vec3); 17] = [
    (0.00, Vec3::new(58.0, 55.0, 53.0)),
    (0.07, Vec3::new(84.0, 74.0, 64.0)),
    (0.11, Vec3::new(108.0, 85.0, 71.0)),
    (0.14, Vec3::new(112.0, 107.0, 84.0)),
    (0.20, Vec3::new(136.0, 120.0, 92.0)),
    (0.22, Vec3::new(142.0, 91.0, 70.0)),
    (0.33, Vec3::new(167.0, 108.0, 82.0)),
    (0.36, Vec3::new(130.0, 76.0, 60.0)),
    (0.44, Vec3::new(167.0, 98.0, 73.0)),
    (0.48, Vec3::new(186.0, 126.0, 94.0)),
    (0.53, Vec3::new(151.0, 83.0, 63.0)),
    (0.59, Vec3::new(138.0, 71.0, 55.0)),
    (0.615, Vec3::new(219.0, 199.0, 167.0)),
    (0.66, Vec3::new(228.0, 212.0, 185.0)),
    (0.68, Vec3::new(185.0, 161.0, 131.0)),
    (0.72, Vec3::new(211.0, 196.0, 169.0)),
    (1.00, Vec3::new(186.0, 174.0, 150.0)),
];

/// What lies on flat ground, by normalised height (sRGB).
const SOIL: [(f32, Vec3); 11] = [
    (0.000, Vec3::new(52.0, 76.0, 68.0)),
    (0.012, Vec3::new(74.0, 88.0, 66.0)),
    (0.05, Vec3::new(108.0, 102.0, 80.0)),
    (0.20, Vec3::new(134.0, 115.0, 92.0)),
    (0.36, Vec3::new(167.0, 119.0, 90.0)),
    (0.46, Vec3::new(180.0, 127.0, 95.0)),
    (0.56, Vec3::new(159.0, 115.0, 87.0)),
    (0.68, Vec3::new(158.0, 142.0, 112.0)),
    (0.75, Vec3::new(136.0, 132.0, 92.0)),
    (0.84, Vec3::new(92.0, 106.0, 70.0)),
    (1.00, Vec3::new(58.0, 80.0, 52.0)),
];

/// Woods and shrubs where they grow on the soil (sRGB), and the height from which they cover it.
const WOODS: Vec3 = Vec3::new(62.0, 78.0, 50.0);
const WOODS_FROM: (f32, f32) = (0.64, 0.86);

/// Share of the map's relief that must lie below 0 m for it to be taken for a map of a sea. Less is land that lies low.
const LEAST_SEA: f32 = 0.1;

/// The bed of a sea, from its deepest place to the shore (sRGB).
const BED: [(f32, Vec3); 5] = [
    (0.00, Vec3::new(14.0, 30.0, 60.0)),
    (0.55, Vec3::new(28.0, 62.0, 104.0)),
    (0.88, Vec3::new(48.0, 100.0, 136.0)),
    (0.98, Vec3::new(92.0, 148.0, 162.0)),
    (1.00, Vec3::new(150.0, 184.0, 172.0)),
];

/// Land beside a sea by its share of the highest: what covers gentle ground, and bare rock (sRGB).
const COUNTRY: [(f32, Vec3); 6] = [
    (0.00, Vec3::new(126.0, 134.0, 88.0)),
    (0.04, Vec3::new(94.0, 116.0, 68.0)),
    (0.20, Vec3::new(126.0, 132.0, 84.0)),
    (0.45, Vec3::new(160.0, 146.0, 106.0)),
    (0.75, Vec3::new(156.0, 146.0, 136.0)),
    (1.00, Vec3::new(240.0, 242.0, 244.0)),
];
const STONE: [(f32, Vec3); 3] = [
    (0.0, Vec3::new(118.0, 108.0, 92.0)),
    (0.5, Vec3::new(130.0, 120.0, 108.0)),
    (1.0, Vec3::new(198.0, 198.0, 200.0)),
];

/// A texture over the whole map: texel (i, j) is centred on u = (i + ½) / width, v = (j + ½) / height.
#[derive(Clone, Debug, PartialEq)]
pub struct Diffuse {
    /// Columns.
    pub width: u32,
    /// Rows, the first in the north.
    pub height: u32,
    /// 8-bit sRGB with an alpha of 255, row by row.
    pub rgba: Vec<u8>,
    painter: Painter,
}

/// Paints the map in a box of the size `box_size` (for the true slopes): as many texels as samples, but at most
/// `max_side` on the longer side.
pub fn diffuse(field: &HeightField, box_size: DVec3, max_side: u32) -> Diffuse {
    let longer = field.width().max(field.height());
    let shrink = f64::from(max_side.clamp(1, longer)) / f64::from(longer);
    let [width, height] =
        [field.width(), field.height()].map(|side| (f64::from(side) * shrink).round().max(1.0) as u32);
    let rgba = vec![0; width as usize * height as usize * 4];
    let mut diffuse = Diffuse { width, height, rgba, painter: Painter::new(field, box_size) };
    diffuse.paint(field, SampleRect { x: 0, y: 0, width, height });
    diffuse
}

impl Diffuse {
    /// Paints anew what the changed samples `dirty` of the map can have changed, and returns it in texels; `None` for
    /// an empty rectangle. The map must have the size it had in [`diffuse`].
    pub fn update(&mut self, field: &HeightField, dirty: SampleRect) -> Option<SampleRect> {
        if dirty.width == 0 || dirty.height == 0 {
            return None;
        }
        let span = |first: u32, count: u32, samples: u32, texels: u32| {
            let texel = |sample: u32| f64::from(sample) / f64::from(samples - 1) * f64::from(texels) - 0.5;
            let start = texel(first.saturating_sub(REACH)).floor().max(0.0) as u32;
            let end = texel((first + count - 1 + REACH).min(samples - 1)).ceil().min(f64::from(texels - 1)) as u32;
            (start.min(end), end - start.min(end) + 1)
        };
        let (x, width) = span(dirty.x, dirty.width, field.width(), self.width);
        let (y, height) = span(dirty.y, dirty.height, field.height(), self.height);
        let texels = SampleRect { x, y, width, height };
        self.paint(field, texels);
        Some(texels)
    }

    fn paint(&mut self, field: &HeightField, texels: SampleRect) {
        let stride = self.width as usize * 4;
        let rows = texels.y as usize * stride..(texels.y + texels.height) as usize * stride;
        let (painter, width, height) = (&self.painter, f64::from(self.width), f64::from(self.height));
        self.rgba[rows].par_chunks_mut(stride).enumerate().for_each(|(offset, row)| {
            let v = (f64::from(texels.y) + offset as f64 + 0.5) / height;
            for x in texels.x..texels.x + texels.width {
                let colour = painter.colour(field, (f64::from(x) + 0.5) / width, v);
                let [r, g, b] = colour.to_array().map(|channel| channel.round().clamp(0.0, 255.0) as u8);
                row[x as usize * 4..][..4].copy_from_slice(&[r, g, b, 255]);
            }
        });
    }
}

/// What colours depend on besides the place itself.
#[derive(Clone, Debug, PartialEq)]
struct Painter {
    /// The map with its holes filled, where it has some: the colours around a hole are those of ground that goes on, and
    /// what a sampler's filter blends in from beyond its edge looks like what is there.
    filled: Option<Arc<HeightField>>,
    /// Slope (rise over run) of a height difference of 1 between neighbouring samples, west–east and north–south.
    slope_scale: [f32; 2],
    /// Mean slope of the whole map: what is steep is judged by it, so gentle maps show rock, too.
    mean_slope: f32,
    /// The map's sides over the longer one, so that noise is not stretched.
    sides: [f32; 2],
    /// Height of the sea, of the map's relief, where it has one.
    sea: Option<f32>,
}

/// Share of the map's relief that lies below 0 m, where that is enough to be a sea.
fn sea_level(field: &HeightField) -> Option<f32> {
    let [lowest, highest] = field.range();
    let share = (-lowest / (highest - lowest)) as f32;
    (field.has_metres() && share >= LEAST_SEA).then_some(share.min(1.0))
}

impl Painter {
    fn new(field: &HeightField, size: DVec3) -> Self {
        let [columns, rows] = field.cells().map(f64::from);
        let slope_scale = [(size.y * columns / size.x) as f32, (size.y * rows / size.z) as f32];
        let sides = field.box_size(None);
        let filled = field.holes().map(|_| Arc::new(field.clone().with_hole_policy(Holes::Fill)));
        let mut painter = Self {
            filled,
            slope_scale,
            mean_slope: 0.0,
            sides: [sides.x as f32, sides.z as f32],
            sea: sea_level(field),
        };
        // In two stages, so that the sum does not depend on how the work is shared out.
        let row_sums: Vec<f64> = (0..field.height() as i32)
            .into_par_iter()
            .map(|y| (0..field.width() as i32).map(|x| f64::from(painter.slope(field, x, y))).sum())
            .collect();
        let samples = f64::from(field.width()) * f64::from(field.height());
        painter.mean_slope = (row_sums.iter().sum::<f64>() / samples) as f32;
        painter
    }

    /// A height, or the nearest one to a place beside the map.
    fn near(&self, field: &HeightField, x: i32, y: i32) -> f32 {
        let (x, y) = (x.max(0) as u32, y.max(0) as u32);
        match &self.filled {
            Some(filled) if field.is_hole(x, y) => filled.sample(x, y),
            _ => field.sample(x, y),
        }
    }

    /// Height of the surface at a place of the map.
    fn surface_height(&self, field: &HeightField, u: f64, v: f64) -> f32 {
        if self.filled.is_none() {
            return field.surface_height(u, v) as f32;
        }
        let [columns, rows] = field.cells().map(f64::from);
        let (x, y) = (u.clamp(0.0, 1.0) * columns, v.clamp(0.0, 1.0) * rows);
        let (i, j) = (x.floor(), y.floor());
        let (fx, fy) = ((x - i) as f32, (y - j) as f32);
        let row = |j: i32| {
            let (west, east) = (self.near(field, i as i32, j), self.near(field, i as i32 + 1, j));
            west + (east - west) * fx
        };
        let (north, south) = (row(j as i32), row(j as i32 + 1));
        north + (south - north) * fy
    }

    /// Slope at a sample, by central differences.
    fn slope(&self, field: &HeightField, x: i32, y: i32) -> f32 {
        let dx = (self.near(field, x + 1, y) - self.near(field, x - 1, y)) * 0.5 * self.slope_scale[0];
        let dz = (self.near(field, x, y + 1) - self.near(field, x, y - 1)) * 0.5 * self.slope_scale[1];
        (dx * dx + dz * dz).sqrt()
    }

    /// sRGB colour, 0..255, at a place of the map.
    fn colour(&self, field: &HeightField, u: f64, v: f64) -> Vec3 {
        let height = self.surface_height(field, u, v);
        let [columns, rows] = field.cells().map(f64::from);
        let (x, y) = ((u * columns).round() as i32, (v * rows).round() as i32);
        let (nu, nv) = (u as f32 * self.sides[0], v as f32 * self.sides[1]);
        let broad = noise(nu * 14.0, nv * 14.0, 0) + 0.5 * noise(nu * 31.0, nv * 31.0, 1);
        let fine = noise(nu * 150.0, nv * 150.0, 2) + 0.6 * noise(nu * 333.0, nv * 333.0, 3);

        let slope = self.slope(field, x, y);
        let steepness = if slope > 0.0 { slope / (slope + self.mean_slope) } else { 0.0 };
        let bare = smoothstep(0.36, 0.68, steepness + 0.04 * fine);
        let ground = match self.sea {
            None => mix(soil(height, broad, fine), rock(height + 0.007 * broad + 0.002 * fine), bare),
            Some(sea) => beside_sea(height - sea, sea, bare) * (1.0 + 0.04 * broad),
        };

        // Hollows are darker and crests paler, as dust and shade make them.
        let hollow = self.hollow(field, x, y, height) / (self.mean_slope + 1e-6);
        let shade = 1.0 - 0.16 * (hollow / (1.0 + hollow.abs()));
        ground * (shade * (1.0 + 0.035 * fine))
    }

    /// How much higher the ground around is, as a slope.
    fn hollow(&self, field: &HeightField, x: i32, y: i32, height: f32) -> f32 {
        const R: i32 = HOLLOW_RADIUS;
        let around = [(-R, 0), (R, 0), (0, -R), (0, R), (-2, -2), (2, -2), (-2, 2), (2, 2)];
        let mean =
            around.into_iter().map(|(dx, dy)| self.near(field, x + dx, y + dy)).sum::<f32>() / around.len() as f32;
        (mean - height) * self.slope_scale[0] / R as f32
    }
}

/// Ground so far `over` a sea that lies `sea` high, both of the map's relief; `bare`: how much of it is rock.
fn beside_sea(over: f32, sea: f32, bare: f32) -> Vec3 {
    if over < 0.0 {
        return ramp(&BED, 1.0 + over / sea);
    }
    let share = over / (1.0 - sea).max(f32::MIN_POSITIVE);
    mix(ramp(&COUNTRY, share), ramp(&STONE, share), bare)
}

/// Bare rock: the band of this height, with thin beds in it.
fn rock(height: f32) -> Vec3 {
    let bed = |beds: f32, stream: u32| noise(height * beds, 0.5, stream);
    ramp(&ROCK, height) * (1.0 + 0.10 * bed(70.0, 4) + 0.07 * bed(190.0, 5))
}

/// Flat ground: soil with patches, and woods high up.
fn soil(height: f32, broad: f32, fine: f32) -> Vec3 {
    let soil = ramp(&SOIL, height + 0.02 * broad) * (1.0 + 0.05 * broad);
    let cover = smoothstep(WOODS_FROM.0, WOODS_FROM.1, height + 0.07 * broad);
    let shrubs = 0.16 * smoothstep(-0.2, 1.0, fine) + 0.26 * smoothstep(-0.1, 1.1, broad);
    mix(soil, WOODS, (cover * smoothstep(-0.9, 0.8, fine + 0.7 * broad)).max(shrubs).clamp(0.0, 0.85))
}

fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a + (b - a) * t
}

fn smoothstep(from: f32, to: f32, value: f32) -> f32 {
    let t = ((value - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Linear between the entries; the first and last colour beyond them.
fn ramp(entries: &[(f32, Vec3)], at: f32) -> Vec3 {
    let next = entries.partition_point(|entry| entry.0 <= at);
    if next == 0 {
        return entries[0].1;
    }
    let (from, low) = entries[next - 1];
    match entries.get(next) {
        Some(&(to, high)) => mix(low, high, (at - from) / (to - from)),
        None => low,
    }
}

/// Value noise, −1 to 1.
fn noise(x: f32, y: f32, stream: u32) -> f32 {
    let (cell_x, cell_y) = (x.floor(), y.floor());
    let value = |i: i32, j: i32| {
        let bits = hash(0, stream, (cell_x as i32 + i) as u32, (cell_y as i32 + j) as u32) >> 40;
        bits as f32 / (1 << 23) as f32 - 1.0
    };
    let (u, v) = (smoothstep(0.0, 1.0, x - cell_x), smoothstep(0.0, 1.0, y - cell_y));
    let row = |j: i32| value(0, j) + (value(1, j) - value(0, j)) * u;
    let (top, bottom) = (row(0), row(1));
    top + (bottom - top) * v
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::generate::{Kind, generate};
    use super::super::{Crater, EditedTerrain};
    use super::*;

    fn luminance(rgba: &[u8]) -> f64 {
        0.2126 * f64::from(rgba[0]) + 0.7152 * f64::from(rgba[1]) + 0.0722 * f64::from(rgba[2])
    }

    #[test]
    fn it_has_the_maps_size_up_to_the_limit() {
        let field = HeightField::from_raw(40, 20, &(0..800).map(f64::from).collect::<Vec<_>>()).unwrap();
        let whole = diffuse(&field, field.box_size(None), 2048);
        assert_eq!((whole.width, whole.height, whole.rgba.len()), (40, 20, 3200));
        let small = diffuse(&field, field.box_size(None), 10);
        assert_eq!((small.width, small.height, small.rgba.len()), (10, 5, 200));
        assert!(small.rgba.chunks(4).all(|texel| texel[3] == 255));
        let flat = HeightField::from_raw(2, 2, &[1.0; 4]).unwrap();
        assert_eq!(diffuse(&flat, flat.box_size(Some(0.0)), 1).rgba.len(), 4);
    }

    /// Deep ground is dark, and a landscape shows many colours.
    #[test]
    fn heights_can_be_told_apart() {
        let field = generate(Kind::DiamondSquare, 129, 5);
        let texture = diffuse(&field, field.box_size(None), 2048);
        let mean = |from: f32, to: f32| {
            let inside = texture.rgba.chunks(4).zip(field.samples()).filter(|(_, h)| (from..to).contains(*h));
            let (sum, count) =
                inside.fold((0.0, 0.0), |(sum, count), (texel, _)| (sum + luminance(texel), count + 1.0));
            sum / count
        };
        assert!(mean(0.0, 0.15) + 15.0 < mean(0.3, 0.6));
        let colours: std::collections::HashSet<_> = texture.rgba.chunks(4).map(<[u8]>::to_vec).collect();
        assert!(colours.len() > 2000, "{}", colours.len());
    }

    /// The whole Earth is not a canyon: what lies below 0 m is blue, the shore green, the summits white.
    #[test]
    fn a_sea_is_blue_where_metres_are_known() {
        let metres: Vec<f64> = (0..64 * 64).map(|i| f64::from(i % 64) / 63.0 * 8000.0 - 4000.0).collect();
        let field = HeightField::from_raw(64, 64, &metres).unwrap();
        let texel = |field: &HeightField, column: usize| {
            let texture = diffuse(field, field.box_size(None), 64);
            let rgba = &texture.rgba[(32 * 64 + column) * 4..][..3];
            [rgba[0], rgba[1], rgba[2]].map(i32::from)
        };
        let metric = field.clone().with_metres(true);
        let [deep, shore, summit] = [6, 33, 63].map(|column| texel(&metric, column));
        assert!(deep[2] > deep[0] + 40 && deep[2] > deep[1], "{deep:?}");
        assert!(shore[1] > shore[0] && shore[1] > shore[2] + 20, "{shore:?}");
        assert!(summit.iter().all(|&channel| channel > 150), "{summit:?}");
        // Without metres 0 means nothing, and a little land below the sea is land.
        assert_ne!(texel(&field, 6), deep);
        let polder: Vec<f64> = metres.iter().map(|height| height + 3900.0).collect();
        let polder = HeightField::from_raw(64, 64, &polder).unwrap();
        assert_eq!(texel(&polder.clone().with_metres(true), 0), texel(&polder, 0));
    }

    #[test]
    fn a_crater_is_painted_and_taken_back_without_a_trace() {
        let base = Arc::new(generate(Kind::Perlin, 150, 5));
        let size = base.box_size(None);
        for limit in [60, 150] {
            let mut terrain = EditedTerrain::new(base.clone());
            let original = diffuse(&base, size, limit);
            let mut texture = original.clone();
            let crater = Crater { x: 0.4, z: 0.9, radius: 0.08, depth: 0.3, rim: 0.1 };
            let edit = terrain.set_craters(&[crater]).unwrap();
            let texels = texture.update(terrain.field(), edit.samples).unwrap();
            assert!(texels.width < limit / 2, "only around it: {texels:?}");
            let mut whole = texture.clone();
            whole.paint(terrain.field(), SampleRect { x: 0, y: 0, width: limit, height: limit });
            assert!(whole == texture, "the update leaves nothing out");
            assert!(texture != original);
            let edit = terrain.set_craters(&[]).unwrap();
            texture.update(terrain.field(), edit.samples);
            assert!(texture == original);
        }
    }
}
