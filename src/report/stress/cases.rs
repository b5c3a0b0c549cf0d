//! The cases: stiff terrains under usual views, extreme views of a few terrains, extreme edits.

use super::edits;
use super::terrains::Terrain;
use super::views::View;
use crate::camera::NamedView;
use crate::heightfield::Crater;

/// One picture of one terrain.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// What it is called: `terrain/view`, with what else is special about it.
    pub(super) name: String,
    pub(super) terrain: Terrain,
    /// Samples each way of a terrain that has no size of its own.
    pub(super) side: u32,
    pub(super) view: View,
    /// The map's own where absent.
    pub(super) height_scale: Option<f64>,
    pub(super) craters: Vec<Crater>,
    /// Size of the picture where it is not that of the job.
    pub(super) size: Option<[u32; 2]>,
    /// Every so many pixels one is compared.
    pub(super) stride: usize,
    /// The other techniques are measured, too: not on large maps, whose step maps take minutes.
    pub(super) all_techniques: bool,
}

impl Case {
    fn new(terrain: Terrain, view: View, side: u32) -> Self {
        Self {
            name: format!("{}/{}", terrain.name(), view.name()),
            terrain,
            side,
            view,
            height_scale: None,
            craters: Vec::new(),
            size: None,
            stride: 1,
            all_techniques: true,
        }
    }

    fn named(mut self, what: &str) -> Self {
        self.name = format!("{}/{what}", self.name);
        self
    }

    fn scaled(mut self, height_scale: f64) -> Self {
        self.height_scale = Some(height_scale);
        self.named(&format!("height-{height_scale:e}"))
    }

    fn sized(mut self, size: [u32; 2], stride: usize) -> Self {
        (self.size, self.stride) = (Some(size), stride);
        self.all_techniques = stride == 1;
        self.named(&format!("{}x{}", size[0], size[1]))
    }

    fn exact_only(mut self) -> Self {
        self.all_techniques = false;
        self
    }

    /// Pixels of a picture of `size` that the tangency band may excuse: one in a thousand of what is compared, and where
    /// whole rows of rays are degenerate, a few rows and columns.
    pub(super) fn excusable(&self, size: [u32; 2]) -> u64 {
        let [width, height] = size.map(u64::from);
        let few = 2 + width * height / self.stride as u64 / 1000;
        match self.view {
            // The eye itself is within the band.
            View::OnTheSurface | View::AtASample => width * height,
            view if view.is_degenerate() => few + 2 * (width + height),
            _ => few,
        }
    }
}

const STIFF: [Terrain; 13] = [
    Terrain::Needles,
    Terrain::Wall,
    Terrain::Cliff,
    Terrain::Checkerboard,
    Terrain::Terraces,
    Terrain::Staircase,
    Terrain::Saddle,
    Terrain::NearlyPlanar,
    Terrain::FlatLow,
    Terrain::FlatHigh,
    Terrain::OneHigh,
    Terrain::OneLow,
    Terrain::Noise,
];

/// Samples each way of the stiff terrains: odd, so that there is a middle sample.
const SIDES: [u32; 2] = [129, 65];

/// Views of each of them from anywhere, in the full run.
const RANDOM_VIEWS: u32 = 8;

/// All cases, those of one terrain one after the other.
pub(super) fn all(quick: bool) -> Vec<Case> {
    let side = SIDES[usize::from(quick)];
    let mut cases = Vec::new();
    for (index, terrain) in (0..).zip(STIFF) {
        cases.extend(usual_views(quick).iter().map(|&view| Case::new(terrain, view, side)));
        let anywhere = if quick { index..index + 1 } else { 100 * index..100 * index + RANDOM_VIEWS };
        cases.extend(anywhere.map(|seed| Case::new(terrain, View::Random(seed), side)));
        match terrain {
            // The terrain that has plains, peaks and saddles is seen from everywhere.
            Terrain::Terraces => cases.extend(extreme_views(quick).iter().map(|&view| Case::new(terrain, view, side))),
            Terrain::Noise => {
                let few = [
                    View::AlongSide(90.0),
                    View::Far(1e6),
                    View::Field(0.001),
                    View::Field(1e-6),
                    View::FarField(1e6, 1e-9),
                    View::Field(179.0),
                ];
                cases.extend(few.map(|view| Case::new(terrain, view, side)));
                let scales = [0.0, 1e-6, 1.0, 1e3];
                let views = [View::Named(NamedView::Over), View::Axis(0.0)];
                let scaled = |scale: f64| views.map(|view| Case::new(terrain, view, side).scaled(scale));
                cases.extend(scales.into_iter().flat_map(scaled));
            }
            Terrain::Checkerboard => {
                let few =
                    [View::Axis(90.0), View::BesideAxis(90.0), View::Diagonal, View::AtTheTop, View::AlongSide(0.0)];
                cases.extend(few.map(|view| Case::new(terrain, view, side)));
            }
            Terrain::Staircase => {
                // Aligned with the view and across it; from a step's own height.
                let few = [View::Axis(90.0), View::Axis(270.0), View::Axis(0.0), View::AtAPlateau];
                cases.extend(few.map(|view| Case::new(terrain, view, side)));
            }
            Terrain::FlatLow => cases.push(Case::new(terrain, View::Up, side)),
            _ => {}
        }
    }
    for (width, height) in [(2, 2), (3, 2000), (2000, 3), (7, 5), (131, 67)] {
        // Along the longer side.
        let along = View::Axis(if height > width { 0.0 } else { 90.0 });
        let views = [along, View::Field(0.1), View::Skim, View::Named(NamedView::Graze)];
        let views = &views[..if quick { 2 } else { views.len() }];
        cases.extend(views.iter().map(|&view| Case::new(Terrain::Shape(width, height), view, side)));
    }
    cases.extend(pictures(quick));
    for (name, list) in edits::craters(side) {
        let views: &[View] = if quick {
            &[View::Named(NamedView::Graze)]
        } else {
            &[View::Named(NamedView::Graze), View::Named(NamedView::Over), View::Axis(0.0)]
        };
        cases.extend(views.iter().map(|&view| {
            let case = Case::new(Terrain::Fractal(side - 1), view, side).named(name);
            Case { craters: list.clone(), ..case }
        }));
    }
    let mut seen = std::collections::HashSet::new();
    cases.retain(|case| seen.insert(case.name.clone()));
    cases
}

fn usual_views(quick: bool) -> &'static [View] {
    const VIEWS: [View; 5] = [
        View::Named(NamedView::Graze),
        View::Skim,
        View::Named(NamedView::Over),
        View::Named(NamedView::Down),
        View::Axis(0.0),
    ];
    if quick { &VIEWS[..2] } else { &VIEWS }
}

fn extreme_views(quick: bool) -> &'static [View] {
    const VIEWS: [View; 35] = [
        View::Axis(0.0),
        View::BesideAxis(0.0),
        View::AlongSide(0.0),
        View::Down,
        View::Up,
        View::AtTheTop,
        View::AtAPlateau,
        View::Diagonal,
        View::OnTheSurface,
        View::AtASample,
        View::InTheGround,
        View::OnASide,
        View::OnAnEdge,
        View::OnACorner,
        View::Small(8.0),
        View::Far(1e3),
        View::Far(1e6),
        View::Far(1e9),
        View::FarBeside(1e6),
        View::Field(0.001),
        View::Field(1e-6),
        View::FarField(1e6, 1e-9),
        View::Field(179.0),
        View::Rolled,
        View::UpFromInside,
        View::Axis(90.0),
        View::Axis(180.0),
        View::Axis(270.0),
        View::BesideAxis(90.0),
        View::BesideAxis(180.0),
        View::BesideAxis(270.0),
        View::AlongSide(90.0),
        View::AlongSide(180.0),
        View::AlongSide(270.0),
        View::FarBeside(1e3),
    ];
    // One of each kind is at the front.
    if quick { &VIEWS[..25] } else { &VIEWS }
}

/// Pictures of extreme sizes, and large maps.
fn pictures(quick: bool) -> Vec<Case> {
    let graze = |size: u32| Case::new(Terrain::Fractal(size), View::Named(NamedView::Graze), size);
    let mut cases = vec![graze(64).sized([1, 1], 1), graze(64).sized([1, 4096], if quick { 7 } else { 1 })];
    if !quick {
        cases.extend([graze(512).sized([7680, 4320], 199)]);
        let views = [View::Named(NamedView::Graze), View::Skim, View::Far(1e6), View::Field(0.001), View::Axis(90.0)];
        cases.extend(views.map(|view| Case::new(Terrain::Fractal(1024), view, 1024).exact_only()));
        cases.push(Case::new(Terrain::Noise, View::Named(NamedView::Graze), 2048).named("2048").exact_only());
    }
    cases
}
