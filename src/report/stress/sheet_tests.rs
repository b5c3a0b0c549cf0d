use image::RgbImage;

use super::super::judge::Judgement;
use super::super::tables;
use super::super::terrains::Terrain;
use super::super::views::View;
use super::*;
use crate::camera::NamedView;

/// Cases of the same view: with so many pixels in the band, and with what broke the promise.
fn report(cases: &[(u64, &[&str])]) -> StressReport {
    let field = Terrain::Noise.map(33).unwrap();
    let extent = field.box_size(None);
    let view = View::Named(NamedView::Graze);
    let (camera, size, cell) = (view.camera(&field, extent), [48, 30], extent.x / 32.0);
    let stage = Stage { field: &field, extent, camera, size, cell };
    let reference = stage.reference(1);
    let picture: Vec<f32> = reference.iter().map(|&distance| distance as f32).collect();
    let mut report = StressReport {
        machine: String::new(),
        adapter: String::new(),
        driver: String::new(),
        size,
        quick: true,
        stopped: None,
        cases: Vec::new(),
        checks: Vec::new(),
        bound: Vec::new(),
        left_out: Vec::new(),
        strips: Vec::new(),
    };
    for (number, &(tangent, broken)) in cases.iter().enumerate() {
        let name = format!("noise/{number}");
        let mut strip = Strip::new(&name, &stage, &reference);
        for technique in Technique::ALL {
            strip.add(technique, &stage, &reference, &picture);
        }
        report.strips.push(strip);
        report.cases.push(CaseReport {
            name,
            view: view.name(),
            map_samples: [33, 33],
            map_box: extent.to_array(),
            camera,
            size,
            cell,
            stride: 1,
            rows: Vec::new(),
            judgement: Judgement { tangent, ..Judgement::default() },
            excusable: 9,
            broken: broken.iter().map(|&why| why.to_owned()).collect(),
        });
    }
    report
}

fn sheet(report: &StressReport) -> RgbImage {
    image::load_from_memory(&png(report).unwrap()).unwrap().into_rgb8()
}

/// Pixels of a colour, the frame's or the letters', in a part of the sheet.
fn coloured(sheet: &RgbImage, colour: &str, [x, y, width, height]: [u32; 4]) -> usize {
    let digits: Vec<u8> = colour[1..].chars().map(|digit| digit.to_digit(16).unwrap() as u8).collect();
    let wanted: Vec<u8> = match digits[..] {
        [r, g, b] => vec![r * 17, g * 17, b * 17],
        _ => digits.chunks(2).map(|pair| pair[0] * 16 + pair[1]).collect(),
    };
    image::imageops::crop_imm(sheet, x, y, width, height)
        .to_image()
        .pixels()
        .filter(|pixel| pixel.0[..] == wanted)
        .count()
}

/// Someone who finds red pixels in the exact technique's column has to see at once whether they count.
#[test]
fn wrong_pixels_inside_the_band_are_told_from_broken_promises() {
    let report = report(&[(0, &[]), (3, &[]), (2, &["7 pixels missed"]), (0, &[])]);
    let sheet = sheet(&report);
    let layout = Layout::of(4);
    let around = 2 * (THUMB[0] + THUMB[1]) as usize * FRAME as usize;
    for (index, marks) in [[0, 0], [1, 0], [0, 1], [0, 0]].into_iter().enumerate() {
        let [x, y] = layout.strip(index).map(|at| at as u32);
        let cell =
            [x + NAMES + DIFFERENCE * Layout::STEP[0] - FRAME, y - FRAME, THUMB[0] + 2 * FRAME, THUMB[1] + 2 * FRAME];
        let rest = [x + NAMES, y, DIFFERENCE * Layout::STEP[0] - FRAME, THUMB[1]];
        for (colour, marked) in [BAND, BROKEN].into_iter().zip(marks) {
            let found = coloured(&sheet, colour, cell);
            assert!(found >= marked * around && (marked == 1 || found == 0), "{found} of {colour} in row {index}");
            assert_eq!(coloured(&sheet, colour, rest), 0, "only the difference is framed");
        }
    }
    // The legend says what the frames mean, inside the sheet and above the pictures.
    assert!([BAND, BROKEN].iter().all(|colour| coloured(&sheet, colour, [0, 0, sheet.width(), HEAD - FRAME]) > 80));
    let empty = [sheet.width() - 40, 0, 40, HEAD - 24];
    assert_eq!(coloured(&sheet, "#fff", empty), (40 * (HEAD - 24)) as usize, "the legend is cut off");
    let words = tables::markdown(&report);
    assert!(words.contains("an amber frame") && words.contains("a red one"), "{words}");
}
