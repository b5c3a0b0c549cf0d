//! Rust's mirrors of the shaders' structs against the WGSL.

use std::collections::BTreeMap;
use std::mem::offset_of;

use super::air::{AirKey, AirUniform};
use super::anchor::AnchorUniform;
use super::clouds::{CloudsUniform, LayerUniform};
use super::flare::{FlareUniform, GhostUniform};
use super::frame::FrameUniform;
use super::light::{LightKey, LightUniform};
use super::materials::MaterialsUniform;
use super::occluder::{CubeUniform, OccluderKey};
use super::pipelines::sources;
use super::terrain::{TerrainKey, TerrainUniform};
use super::water::{WaterBuffer, WaterKey};
use super::*;
use crate::scene::ColourSource;

/// Offsets and size of a WGSL struct, as naga laid it out. naga_oil decorates names, so the struct is found by its stem.
fn wgsl_layout(module: &naga::Module, name: &str) -> (BTreeMap<String, u32>, u32) {
    let (_, ty) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref().is_some_and(|full| full == name || full.starts_with(&format!("{name}X_"))))
        .unwrap_or_else(|| panic!("no struct {name} in the shader"));
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
    (members.iter().map(|member| (member.name.clone().unwrap(), member.offset)).collect(), *span)
}

macro_rules! assert_layout {
    ($module:expr, $wgsl:literal, $rust:ty, [$($field:ident),* $(,)?]) => {
        let (offsets, span) = wgsl_layout($module, $wgsl);
        let expected: BTreeMap<String, u32> =
            [$((stringify!($field).to_owned(), offset_of!($rust, $field) as u32)),*].into();
        assert_eq!(offsets, expected, "offsets of {}", $wgsl);
        assert_eq!(span as usize, size_of::<$rust>(), "size of {}", $wgsl);
    };
}

#[test]
fn rust_and_wgsl_agree_on_every_uniform() {
    let key = TerrainKey::of(&Scene::default(), false);
    let pass = terrain::describe(key);
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Frame",
        FrameUniform,
        [
            clip_from_world,
            ray_origin,
            ray_start,
            ray_origin_right,
            pixel_size,
            ray_origin_down,
            padding,
            ray_direction,
            flattening,
            ray_direction_right,
            centre_x,
            ray_direction_down,
            centre_y,
        ]
    );
    assert_layout!(
        &module,
        "Terrain",
        TerrainUniform,
        [
            box_clip,
            size,
            highest,
            cells,
            cells_per_unit,
            texel_size,
            pyramid_stack,
            repeats_per_cell,
            pyramid_texel,
            layer_cells,
            samples,
            top_size,
            layer_rise,
            farthest,
            texel_density,
            binary_steps,
            step_cap,
            heat_map_max,
            repeats,
            diffuse,
            specular,
            shininess,
            height_unit,
            sun,
            ambient,
        ]
    );
    let lines = land::LandKey { contours: true, ..Default::default() };
    let pass = terrain::describe(TerrainKey { land: lines, ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Land",
        land::LandUniform,
        [
            ramp_low,
            ramp_middle,
            ramp_high,
            height_unit,
            contours_per_share,
            contour_offset,
            contour_width,
            slope_factor,
            slope_max,
            hillshade_strength,
            imagery_opacity,
            imagery_density,
            imagery_u,
            padding,
            imagery_v,
            imagery_texels,
        ]
    );
    let pass = terrain::describe(key.in_a_deep_zoom(true));
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Anchor",
        AnchorUniform,
        [
            origin,
            depth,
            origin_right,
            beam_shift,
            origin_down,
            begin,
            direction,
            height,
            direction_right,
            units,
            direction_down,
            relief,
            low,
            shares_per_unit,
            high,
            end,
            cell,
            fraction,
            grounds,
        ]
    );
    let mut scene = Scene::default();
    scene.diffuse.source = ColourSource::Materials;
    let pass = terrain::describe(TerrainKey::of(&scene, false));
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Materials", MaterialsUniform, [dark, light, levels, slopes, repeats, relief]);
    let pass = terrain::describe(TerrainKey { light: LightKey::all()[2], ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Light", LightUniform, [columns, shares, cube, sky, sun, cells_per_texel]);
    let pass = water::describe(WaterKey::some()[0]);
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Water",
        WaterBuffer,
        [
            cube,
            cube_sun,
            absorption_and_level,
            deep_and_submerged,
            sun_and_flattening,
            background_and_foam,
            foam_light_and_bubbles,
            drift,
            foam_shift,
            waves,
        ]
    );
    let pass = terrain::describe(TerrainKey { air: AirKey::all()[0], ..key });
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(
        &module,
        "Air",
        AirUniform,
        [
            kilometres,
            molecules,
            haze,
            fog,
            fog_light,
            sun,
            sun_light,
            sky_light,
            mean,
            shadow_place,
            shadow_shear,
            shadow_levels,
            horizon
        ]
    );
    let pass = clouds::describe_shadow();
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Clouds", CloudsUniform, [layers, count, shadow, order, sun]);
    assert_layout!(&module, "CloudLayer", LayerUniform, [shape, first, second, offsets]);
    let pass = flare::describe();
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Flare", FlareUniform, [ghosts]);
    assert_layout!(&module, "Ghost", GhostUniform, [place, light]);
    let pass = occluder::describe(OccluderKey::default());
    let module = sources().compose(pass.file, &pass.modules, &pass.defs).unwrap();
    assert_layout!(&module, "Cube", CubeUniform, [clip, sun, ambient]);
}
