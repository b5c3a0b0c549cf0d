//! The maps that are open. Only the one on screen is in memory; of the others it is known where they come from, how they
//! were read, and where the eye was.

use std::path::PathBuf;

use glam::DVec3;

use crate::camera::Camera;
use crate::heightfield::gallery::{CANYON_NAME, Piece};
use crate::heightfield::generate::Recipe;
use crate::heightfield::import::ImportOptions;
use crate::heightfield::{Crater, Sidecar};
use crate::scene::Scene;

/// Where a map comes from.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// The one inside the binary.
    Canyon,
    /// Made from a recipe that ships.
    Piece(Piece),
    /// Made from a recipe of the user's.
    Made(Box<Recipe>),
    /// A file, absolute.
    File(PathBuf),
}

impl Source {
    /// What it is made from, where that is the user's recipe.
    pub(crate) fn recipe(&self) -> Option<&Recipe> {
        match self {
            Self::Made(recipe) => Some(recipe),
            _ => None,
        }
    }

    /// What to call it before it is open.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Canyon => CANYON_NAME.to_owned(),
            Self::Piece(piece) => piece.name().to_owned(),
            Self::Made(recipe) => recipe.title(),
            Self::File(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
        }
    }
}

/// What belongs to one map and not to the viewer: where the eye is, and what was done to the ground.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    camera: Option<Camera>,
    craters: Vec<Crater>,
    occluder: Option<DVec3>,
    height_scale: Option<f64>,
    /// What of the colours goes by the map's heights or its place: the ramp's ends, the contours' interval, pictures.
    heights: [Option<f64>; 3],
    imagery: Option<PathBuf>,
    coverage: Vec<PathBuf>,
    /// The box at the map's own proportion.
    extent: DVec3,
}

impl Place {
    /// That of a map whose box has this size at its own proportion.
    pub(crate) fn of(scene: &Scene, extent: DVec3) -> Self {
        Self {
            camera: scene.camera,
            craters: scene.craters.list.clone(),
            occluder: scene.occluder.position,
            height_scale: scene.terrain.height_scale,
            heights: [scene.land.low, scene.land.high, scene.land.contour_interval],
            imagery: scene.land.imagery.clone(),
            coverage: scene.materials.coverage.clone(),
            extent,
        }
    }

    /// Puts it back. A map that was read in another way meanwhile may have another proportion: the eye stays over the same
    /// ground.
    pub(crate) fn restore(self, scene: &mut Scene, extent: DVec3) {
        let own = if self.height_scale.is_some() { extent.with_y(self.extent.y) } else { extent };
        let scale = |axis: f64, before: f64| if before > 0.0 { axis / before } else { 1.0 };
        let moved = DVec3::new(scale(own.x, self.extent.x), scale(own.y, self.extent.y), scale(own.z, self.extent.z));
        scene.camera = self.camera.map(|camera| Camera { eye: camera.eye * moved, ..camera });
        scene.occluder.position = self.occluder.map(|position| position * moved);
        scene.craters.list = self.craters;
        for crater in &mut scene.craters.list {
            (crater.x, crater.z) = (crater.x * moved.x, crater.z * moved.z);
        }
        scene.terrain.height_scale = self.height_scale;
        [scene.land.low, scene.land.high, scene.land.contour_interval] = self.heights;
        (scene.land.imagery, scene.materials.coverage) = (self.imagery, self.coverage);
    }
}

/// A map of the list.
#[derive(Clone, Debug)]
pub(crate) struct Map {
    /// Where it comes from.
    pub(crate) source: Source,
    /// Its title, once it was open.
    pub(crate) title: Option<String>,
    /// The options it is opened with.
    pub(crate) said: ImportOptions,
    /// What counts instead of its sidecar, where the import card has changed that.
    pub(crate) stated: Option<Sidecar>,
    /// Where the eye was when it was left.
    pub(crate) place: Option<Place>,
}

impl Map {
    /// What to call it.
    pub(crate) fn name(&self) -> String {
        self.title.clone().unwrap_or_else(|| self.source.name())
    }
}

/// All of them, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(crate) struct Maps {
    list: Vec<Map>,
    current: usize,
    /// The one being opened.
    pub(crate) target: Option<usize>,
}

impl Maps {
    /// The index of the map of this source, which is added where it is not in the list yet.
    pub(crate) fn add(&mut self, source: Source, said: ImportOptions) -> usize {
        if let Some(index) = self.find(&source) {
            return index;
        }
        self.list.push(Map { source, title: None, said, stated: None, place: None });
        self.list.len() - 1
    }

    fn find(&self, source: &Source) -> Option<usize> {
        self.list.iter().position(|map| map.source == *source)
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// All of them.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Map> {
        self.list.iter()
    }

    /// The map with this index.
    pub(crate) fn get(&self, index: usize) -> Option<&Map> {
        self.list.get(index)
    }

    /// The index of the one on screen.
    pub(crate) fn index(&self) -> usize {
        self.current
    }

    /// The one on screen.
    pub(crate) fn current(&self) -> Option<&Map> {
        self.list.get(self.current)
    }

    /// The one on screen.
    pub(crate) fn current_mut(&mut self) -> Option<&mut Map> {
        self.list.get_mut(self.current)
    }

    /// The index so many further, around the ends; from the one that is being opened, where one is. `None` where there is
    /// only one.
    pub(crate) fn step(&self, by: isize) -> Option<usize> {
        let count = isize::try_from(self.list.len()).ok().filter(|count| *count > 1)?;
        let from = isize::try_from(self.target.unwrap_or(self.current)).ok()?;
        usize::try_from((from + by).rem_euclid(count)).ok()
    }

    /// Remembers where the eye was in the map on screen.
    pub(crate) fn leave(&mut self, place: Place) {
        if let Some(map) = self.current_mut() {
            map.place = Some(place);
        }
    }

    /// The map with this index is on screen now.
    pub(crate) fn arrive(&mut self, index: usize, title: &str) {
        self.target = None;
        if let Some(map) = self.list.get_mut(index) {
            map.title = Some(title.to_owned());
            self.current = index;
        }
    }

    /// A map did not open: one that never has leaves the list.
    pub(crate) fn failed(&mut self, source: &Source) {
        self.target = None;
        let Some(index) = self.find(source) else { return };
        if self.list[index].title.is_none() && index != self.current {
            self.list.remove(index);
            self.current -= usize::from(index < self.current);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn maps(names: &[&str]) -> Maps {
        let mut maps = Maps::default();
        for name in names {
            maps.add(Source::File(name.into()), ImportOptions::default());
        }
        maps.arrive(0, "first");
        maps
    }

    #[test]
    fn tab_goes_around_and_on_from_where_it_is_going() {
        let mut maps = maps(&["a", "b", "c"]);
        assert_eq!((maps.step(1), maps.step(-1)), (Some(1), Some(2)));
        maps.target = Some(1);
        assert_eq!(maps.step(1), Some(2), "pressed twice before the first has opened");
        maps.arrive(2, "third");
        assert_eq!((maps.index(), maps.step(1)), (2, Some(0)));
        assert_eq!(Maps::default().step(1), None);
        assert_eq!(maps.add(Source::File("b".into()), ImportOptions::default()), 1, "no map is listed twice");
    }

    #[test]
    fn what_does_not_open_leaves_the_list_unless_it_was_open_before() {
        let mut maps = maps(&["a", "b", "c"]);
        maps.arrive(2, "third");
        maps.failed(&Source::File("b".into()));
        assert_eq!((maps.len(), maps.index(), maps.current().map(Map::name)), (2, 1, Some("third".into())));
        maps.failed(&Source::File("a".into()));
        maps.failed(&Source::File("c".into()));
        assert_eq!(maps.len(), 2, "both were open");
    }

    #[test]
    fn the_eye_stays_over_the_same_ground_when_the_proportion_changes() {
        let camera = Camera { eye: DVec3::new(0.5, 0.2, 0.25), yaw: 1.0, pitch: 2.0, fov: 60.0 };
        let mut scene = Scene { camera: Some(camera), ..Scene::default() };
        scene.craters.list = vec![Crater { x: 0.5, z: 0.25, radius: 0.1, depth: 0.2, rim: 0.1 }];
        let place = Place::of(&scene, DVec3::new(1.0, 0.1, 0.5));
        let mut same = Scene::default();
        place.clone().restore(&mut same, DVec3::new(1.0, 0.1, 0.5));
        assert_eq!((same.camera, &same.craters.list), (scene.camera, &scene.craters.list));
        place.restore(&mut scene, DVec3::new(0.5, 0.2, 1.0));
        assert_eq!(scene.camera.map(|camera| camera.eye), Some(DVec3::new(0.25, 0.4, 0.5)));
        assert_eq!((scene.craters.list[0].x, scene.craters.list[0].z), (0.25, 0.5));
    }
}
