//! WGSL modules into one naga module: only what a pipeline's defs select is in it.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use naga_oil::compose::{ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderDefValue};

use crate::camera::NEAR;
use crate::scene_file::{MOST_HALVINGS, MOST_SAMPLES, MOST_STEPS};

macro_rules! embed {
    ($($file:literal),* $(,)?) => {
        &[$(($file, include_str!(concat!("../../shaders/", $file)))),*]
    };
}

/// Every shader file, as compiled in.
const EMBEDDED: &[(&str, &str)] = embed![
    "air.wgsl",
    "anchor.wgsl",
    "beam.wgsl",
    "cloud_layers.wgsl",
    "cloud_shadow.wgsl",
    "clouds.wgsl",
    "cones.wgsl",
    "cube.wgsl",
    "cube_faces.wgsl",
    "flare.wgsl",
    "frame.wgsl",
    "ground.wgsl",
    "heightfield.wgsl",
    "land.wgsl",
    "light.wgsl",
    "light_map.wgsl",
    "march/cone.wgsl",
    "march/fractal.wgsl",
    "march/linear-binary.wgsl",
    "march/linear.wgsl",
    "march/max-mipmap-deep.wgsl",
    "march/max-mipmap.wgsl",
    "march/relaxed-cone.wgsl",
    "march/secant.wgsl",
    "march/smooth.wgsl",
    "materials.wgsl",
    "present.wgsl",
    "pyramid.wgsl",
    "sampling.wgsl",
    "shading.wgsl",
    "shadow.wgsl",
    "skybox.wgsl",
    "srgb.wgsl",
    "terrain.wgsl",
    "varyings.wgsl",
    "water.wgsl",
    "waves.wgsl",
];

/// A shader that does not compose or does not validate, with the place in the source.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{file}: {message}")]
pub struct ShaderError {
    /// The file of the pass.
    pub file: String,
    /// What the composer or the validator said.
    pub message: String,
}

/// The text of every shader file.
#[derive(Clone, Debug)]
pub struct ShaderSources {
    files: BTreeMap<&'static str, Cow<'static, str>>,
    generated: Vec<(&'static str, String)>,
}

impl ShaderSources {
    /// The sources compiled into the program. `generated` are further modules made from Rust values, named by what
    /// follows `relief::`, so that no number is typed in two languages.
    pub fn embedded(generated: Vec<(&'static str, String)>) -> Self {
        Self { files: EMBEDDED.iter().map(|&(name, text)| (name, Cow::Borrowed(text))).collect(), generated }
    }

    /// Where the sources lie that are read again when one is saved: the folder that `RELIEF_SHADERS` names, or else the
    /// one that this program was built from; absent once it has been moved to another machine.
    pub fn folder() -> Option<PathBuf> {
        let built_from = || Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
        let folder = std::env::var_os("RELIEF_SHADERS").map_or_else(built_from, PathBuf::from);
        folder.is_dir().then_some(folder)
    }

    /// Reads every file again from `folder`.
    ///
    /// # Errors
    /// The first file that cannot be read.
    pub fn reload(&self, folder: &Path) -> Result<Self, ShaderError> {
        let read = |&name: &&'static str| {
            std::fs::read_to_string(folder.join(name))
                .map(|text| (name, Cow::Owned(text)))
                .map_err(|error| ShaderError { file: name.to_owned(), message: error.to_string() })
        };
        Ok(Self { files: self.files.keys().map(read).collect::<Result<_, _>>()?, generated: self.generated.clone() })
    }

    /// Composes the pass `file` with the modules it may import, in the order in which they need each other.
    ///
    /// # Errors
    /// [`ShaderError`] with the place in the source.
    pub fn compose(&self, file: &str, modules: &[&str], defs: &[&str]) -> Result<naga::Module, ShaderError> {
        let mut composer = Composer::default();
        let shader_defs: std::collections::HashMap<_, _> =
            defs.iter().map(|&def| (def.to_owned(), ShaderDefValue::Bool(true))).collect();
        let fail = |composer: &Composer, error: &ComposerError| ShaderError {
            file: file.to_owned(),
            message: error.emit_to_string(composer),
        };
        // What generated modules may import.
        let srgb = self.text("srgb.wgsl")?;
        let constants = format!(
            "#define_import_path relief::constants\nconst NEAR: f32 = {NEAR:?};\nconst MOST_SAMPLES: f32 = {MOST_SAMPLES}.0;\n\
             const MOST_HALVINGS: u32 = {MOST_HALVINGS}u;\nconst MOST_STEPS: u32 = {MOST_STEPS}u;\n"
        );
        let generated = [("constants", constants.as_str()), ("srgb.wgsl", srgb)]
            .into_iter()
            .chain(self.generated.iter().map(|(name, text)| (*name, text.as_str())));
        let mut sources: Vec<(&str, &str)> = generated.collect();
        for &module in modules {
            sources.push((module, self.text(module)?));
        }
        for (name, source) in sources {
            let added = composer
                .add_composable_module(ComposableModuleDescriptor { source, file_path: name, ..Default::default() })
                .map(|_| ());
            added.map_err(|error| fail(&composer, &error))?;
        }
        let module = composer.make_naga_module(NagaModuleDescriptor {
            source: self.text(file)?,
            file_path: file,
            shader_defs,
            ..Default::default()
        });
        module.map_err(|error| fail(&composer, &error))
    }

    fn text(&self, file: &str) -> Result<&str, ShaderError> {
        self.files
            .get(file)
            .map(AsRef::as_ref)
            .ok_or_else(|| ShaderError { file: file.to_owned(), message: "no such shader file".to_owned() })
    }
}
