//! Extreme views.

use glam::DVec3;

use super::terrains::hash;
use crate::camera::{Camera, NamedView};
use crate::heightfield::HeightField;

/// An extreme view; places are found on the map that it looks at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum View {
    /// One of the report's.
    Named(NamedView),
    /// Along an axis (degrees clockwise from north), level, above a column or row of samples, at half the box's height or above the ground.
    Axis(f64),
    /// The same, one ulp of the angle off.
    BesideAxis(f64),
    /// Along an axis from outside, in the plane of a side of the box.
    AlongSide(f64),
    /// Straight down, the middle ray onto a sample.
    Down,
    /// Straight up from below the floor.
    Up,
    /// Straight up from above the ground.
    UpFromInside,
    /// Level, exactly as high as the box's lid.
    AtTheTop,
    /// Level, exactly as high as a plateau: the height of the sample in the middle.
    AtAPlateau,
    /// Along a diagonal of the grid, through its points.
    Diagonal,
    /// On the surface, between samples.
    OnTheSurface,
    /// At a sample, on the surface.
    AtASample,
    /// In the ground.
    InTheGround,
    /// On a side of the box.
    OnASide,
    /// On an edge of the box's lid.
    OnAnEdge,
    /// On a corner of the box's lid.
    OnACorner,
    /// So many box lengths away; the box fills the picture.
    Far(f64),
    /// So many box lengths away, with the usual field of view: the box is a few pixels, and most of them are its outline.
    Small(f64),
    /// So far away, looking past the box: it stands at the border of the picture.
    FarBeside(f64),
    /// A ten-thousandth of a cell above the ground.
    Skim,
    /// A field of view of so many degrees, onto the ground.
    Field(f64),
    /// So many box lengths away, with a field of view of so many degrees, onto the ground.
    FarField(f64, f64),
    /// Upside down: a roll of 180°.
    Rolled,
    /// From anywhere in or around the box, with any field of view, towards a place on the ground; the number is the seed.
    Random(u32),
}

impl View {
    /// What the tables call it.
    pub(super) fn name(self) -> String {
        match self {
            Self::Named(view) => view.name().into(),
            Self::Axis(yaw) => format!("axis-{yaw}"),
            Self::BesideAxis(yaw) => format!("axis-{yaw}-one-ulp-off"),
            Self::AlongSide(yaw) => format!("along-side-{yaw}"),
            Self::Down => "straight-down".into(),
            Self::Up => "straight-up".into(),
            Self::UpFromInside => "straight-up-inside".into(),
            Self::AtTheTop => "level-at-the-top".into(),
            Self::AtAPlateau => "level-at-a-plateau".into(),
            Self::Diagonal => "through-grid-points".into(),
            Self::OnTheSurface => "eye-on-surface".into(),
            Self::AtASample => "eye-at-sample".into(),
            Self::InTheGround => "eye-in-ground".into(),
            Self::OnASide => "eye-on-side".into(),
            Self::OnAnEdge => "eye-on-edge".into(),
            Self::OnACorner => "eye-on-corner".into(),
            Self::Far(distance) => format!("far-{distance:e}"),
            Self::Small(distance) => format!("small-{distance}"),
            Self::FarBeside(distance) => format!("far-{distance:e}-beside"),
            Self::Skim => "skim".into(),
            Self::Field(degrees) => format!("fov-{degrees}"),
            Self::FarField(distance, degrees) => format!("far-{distance:e}-fov-{degrees:e}"),
            Self::Rolled => "rolled-180".into(),
            Self::Random(seed) => format!("random-{seed}"),
        }
    }

    /// Whether whole rows or columns of rays lie in a side of the box, along its lid or in a plateau: either answer is
    /// right for them, and as many may be excused.
    pub(super) fn is_degenerate(self) -> bool {
        matches!(
            self,
            Self::AlongSide(_)
                | Self::AtTheTop
                | Self::AtAPlateau
                | Self::OnTheSurface
                | Self::AtASample
                | Self::OnASide
                | Self::OnAnEdge
                | Self::OnACorner
                | Self::Skim
                | Self::FarBeside(_)
        )
    }

    /// The camera over `map` in a box of the size `extent`.
    pub(super) fn camera(self, map: &HeightField, extent: DVec3) -> Camera {
        let fov = Camera::DEFAULT_FOV;
        let middle = extent * 0.5;
        let [columns, rows] = map.cells();
        // A sample near the middle, and the places of samples.
        let [i, j] = [columns / 2, rows / 2];
        let place = |i: u32, j: u32| {
            let at = |index: u32, cells: u32, side: f64| f64::from(index) / f64::from(cells) * side;
            let height = f64::from(map.sample(i, j)) * extent.y;
            DVec3::new(at(i, columns, extent.x), height, at(j, rows, extent.z))
        };
        let on_ground = |u: f64, v: f64| DVec3::new(u * extent.x, map.surface_height(u, v) * extent.y, v * extent.z);
        let level = |eye: DVec3, yaw: f64| Camera { eye, yaw, pitch: 0.0, fov };
        let cell = extent.x / f64::from(columns);
        let above = |eye: DVec3| eye.with_y((0.55 * extent.y).max(eye.y + 0.05 * extent.y) + 1e-3);
        match self {
            Self::Named(view) => view.camera(map, extent),
            Self::Axis(yaw) => level(above(place(i, j)), yaw),
            Self::BesideAxis(yaw) => level(above(place(i, j)), yaw.next_up()),
            Self::AlongSide(yaw) => {
                let back = DVec3::new(-f64::sin(yaw.to_radians()).round(), 0.0, f64::cos(yaw.to_radians()).round());
                level(DVec3::new(0.0, 0.6 * extent.y, 0.0) + back * 1.5, yaw)
            }
            Self::Down => Camera { pitch: -90.0, ..level(place(i, j).with_y(extent.y + 0.75), 0.0) },
            Self::Up => Camera { pitch: 90.0, ..level(place(i, j).with_y(-0.75), 0.0) },
            Self::UpFromInside => Camera { pitch: 90.0, ..level(place(i, j) + DVec3::Y * (0.1 * extent.y + 0.1), 0.0) },
            Self::AtTheTop => level(DVec3::new(0.3 * extent.x, extent.y, 1.4 * extent.z), 12.0),
            Self::AtAPlateau => level(place(i, j).with_x(-0.4).with_z(0.4 * extent.z), 90.0),
            Self::Diagonal => Camera { pitch: -20.0, ..level(place(0, rows).with_y(extent.y + 0.1), 45.0) },
            Self::OnTheSurface => level(on_ground(0.4137, 0.5731), 40.0),
            Self::AtASample => level(place(i, j), 130.0),
            Self::InTheGround => level(on_ground(0.5, 0.5) * DVec3::new(1.0, 0.5, 1.0), 200.0),
            Self::OnASide => level(DVec3::new(0.0, 0.7 * extent.y, 0.45 * extent.z), 80.0),
            Self::OnAnEdge => level(DVec3::new(0.0, extent.y, 0.45 * extent.z), 100.0),
            Self::OnACorner => Camera::look_at(extent * DVec3::Y, middle, fov),
            Self::Far(distance) => {
                let eye = middle + DVec3::new(0.3, 0.4, 1.0).normalize() * distance;
                // Half the diagonal of the box, with a little air.
                Camera::look_at(eye, middle, 2.0 * (0.55 * extent.length() / distance).atan().to_degrees())
            }
            Self::Small(distance) => {
                let eye = middle + DVec3::new(0.3, 0.4, 1.0).normalize() * distance;
                Camera::look_at(eye, middle, fov)
            }
            Self::FarBeside(distance) => {
                let eye = middle + DVec3::new(0.3, 0.4, 1.0).normalize() * distance;
                let fov = 2.0 * (1.5 * extent.length() / distance).atan().to_degrees();
                let camera = Camera::look_at(eye, middle, fov);
                Camera { yaw: camera.yaw + 0.4 * fov, pitch: camera.pitch + 0.3 * fov, ..camera }
            }
            Self::Skim => level(on_ground(0.4137, 0.5731) + DVec3::Y * (1e-4 * cell), 40.0),
            Self::Field(degrees) => {
                // A wide picture shows little of what is not close.
                let close = DVec3::new(0.35 * extent.x, extent.y + 0.02, 0.7 * extent.z);
                let eye = if degrees > 90.0 { close } else { DVec3::new(-0.2, extent.y + 0.5, 1.2 * extent.z) };
                Camera::look_at(eye, on_ground(0.4137, 0.5731), degrees)
            }
            Self::FarField(distance, degrees) => {
                let target = on_ground(0.4137, 0.5731);
                let from = DVec3::new(0.3, 0.4, 1.0).normalize() * distance;
                let camera = Camera::look_at(target + from, target, degrees);
                // The angles are coarser than the picture: the eye is where they look at the target from.
                Camera { eye: target - camera.basis().forward * distance, ..camera }
            }
            Self::Random(seed) => {
                let mut draw = 0;
                let mut number = || {
                    draw += 1;
                    hash(seed, draw)
                };
                let target = on_ground(number(), number());
                let towards = DVec3::new(number() - 0.5, 0.5 * number(), number() - 0.5).normalize_or(DVec3::Y);
                // From a thousandth of the box to a hundred of them, and from a hundredth of a degree to 150.
                let eye = target + towards * 10f64.powf(5.0 * number() - 3.0);
                Camera::look_at(eye, target, 150.0 * 10f64.powf(-4.0 * number() * number()))
            }
            Self::Rolled => {
                let camera = NamedView::Over.camera(map, extent);
                Camera { yaw: camera.yaw + 180.0, pitch: -180.0 - camera.pitch, ..camera }
            }
        }
    }
}
