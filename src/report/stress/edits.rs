//! Extreme edits: craters to be drawn, and what must hold of the edited map itself.

use std::sync::Arc;

use serde::Serialize;

use super::terrains::Terrain;
use crate::heightfield::{Crater, EditedTerrain, HeightField, HeightFieldError, MaxPyramid};

/// Something that holds or not, without a picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Check {
    /// What must hold.
    pub name: String,
    /// Why it does not; absent where it does.
    pub failure: Option<String>,
}

impl Check {
    /// A check that held, or says why not.
    pub(super) fn new(name: impl Into<String>, result: Result<(), String>) -> Self {
        Self { name: name.into(), failure: result.err() }
    }
}

/// Lists of craters for a square map with `side` samples each way.
pub(super) fn craters(side: u32) -> [(&'static str, Vec<Crater>); 6] {
    let crater = |x, z, radius, depth, rim| Crater { x, z, radius, depth, rim };
    let cell = 1.0 / f64::from(side - 1);
    [
        ("craters-overlapping", (0..9).map(|i| crater(0.4 + 0.03 * f64::from(i), 0.5, 0.1, 0.2, 0.1)).collect()),
        (
            "craters-over-the-border",
            vec![crater(0.0, 0.4, 0.15, 0.6, 0.1), crater(1.0, 1.0, 0.2, 0.4, 0.3), crater(0.5, -0.1, 0.2, 0.5, 0.2)],
        ),
        ("crater-larger-than-the-map", vec![crater(0.5, 0.5, 3.0, 0.4, 0.2)]),
        (
            "craters-smaller-than-a-cell",
            vec![crater(0.25, 0.5, 0.7 * cell, 1.0, 0.5), crater(0.5 + 0.4 * cell, 0.5, 0.1 * cell, 1.0, 0.5)],
        ),
        ("crater-deeper-than-the-terrain", vec![crater(0.5, 0.5, 0.2, 10.0, 0.0), crater(0.7, 0.3, 0.1, 10.0, 10.0)]),
        ("craters-a-thousand", thousand()),
    ]
}

fn thousand() -> Vec<Crater> {
    let part = |i: u32, factor: f64| (f64::from(i) * factor).fract();
    (0..1000)
        .map(|i| Crater {
            x: 1.2 * part(i, 0.618_033_988_75) - 0.1,
            z: 1.2 * part(i, 0.754_877_666_25) - 0.1,
            radius: 0.003 + 0.03 * part(i, 0.569_840_290_99),
            depth: 0.3 * part(i, 0.445_041_867_91),
            rim: 0.1 * part(i, 0.246_979_603_72),
        })
        .collect()
}

/// What must hold of edited maps.
///
/// # Errors
/// None that the maps of this list can cause.
pub(super) fn checks(quick: bool) -> Result<Vec<Check>, HeightFieldError> {
    let side = if quick { 129 } else { 513 };
    let map = Terrain::Fractal(side).map(side)?;
    let mut checks = Vec::new();
    for (name, list) in craters(side) {
        checks.push(Check::new(format!("{name}: the pyramid is that of a fresh build"), same_pyramid(&map, &list)));
        checks.push(Check::new(format!("{name}: undoing all gives the same bytes"), undone(&map, &list)));
    }
    checks.push(Check::new("an edit at a border of every level: the pyramid is that of a fresh build", borders(&map)));
    Ok(checks)
}

fn pyramid_of(terrain: &EditedTerrain) -> Result<(), String> {
    let fresh = MaxPyramid::build(terrain.field());
    let levels = terrain.pyramid().levels().iter().zip(fresh.levels());
    for (level, (edited, built)) in levels.enumerate() {
        let nodes = (0..built.height).flat_map(|row| (0..built.width).map(move |column| (column, row)));
        for (column, row) in nodes {
            if edited.node(column, row).to_bits() != built.node(column, row).to_bits() {
                return Err(format!("level {}, node {column}, {row} differs", level + 1));
            }
        }
    }
    Ok(())
}

fn same_pyramid(map: &Arc<HeightField>, list: &[Crater]) -> Result<(), String> {
    let mut edited = EditedTerrain::new(Arc::clone(map));
    // One after the other for a few, then the rest at once, then without the last.
    for count in (0..list.len().min(5)).chain([list.len(), list.len() - 1]) {
        edited.set_craters(&list[..count]);
        pyramid_of(&edited).map_err(|why| format!("{count} craters: {why}"))?;
    }
    Ok(())
}

fn undone(map: &Arc<HeightField>, list: &[Crater]) -> Result<(), String> {
    let mut edited = EditedTerrain::new(Arc::clone(map));
    edited.set_craters(list);
    for count in (0..list.len()).rev().take(3).chain([list.len() / 2, 0]) {
        edited.set_craters(&list[..count]);
    }
    let differs = edited.field().samples().iter().zip(map.samples()).position(|(a, b)| a.to_bits() != b.to_bits());
    match differs {
        Some(index) => Err(format!("sample {index} differs")),
        None => pyramid_of(&edited),
    }
}

/// A small crater on each side of a border between nodes of every level, in the middle and at the map's borders.
fn borders(map: &Arc<HeightField>) -> Result<(), String> {
    let cells = map.cells()[0];
    let mut edited = EditedTerrain::new(Arc::clone(map));
    let mut list = Vec::new();
    let mut size = 2;
    while size / 2 < cells {
        let near = (cells / 2 / size).max(1) * size;
        for at in [0, near - 1, near, near + 1, cells].map(|at| at.min(cells)) {
            let x = f64::from(at) / f64::from(cells);
            list.push(Crater { x, z: x, radius: 1.2 / f64::from(cells), depth: 0.2, rim: 0.3 });
            edited.set_craters(&list);
            pyramid_of(&edited).map_err(|why| format!("sample {at}, nodes of {size} cells: {why}"))?;
        }
        size *= 2;
    }
    Ok(())
}
