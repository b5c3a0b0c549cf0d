//! What the renderer needs of an adapter at least, in one place: without any of it there is no device. All else is optional
//! and told by [`super::Capabilities`].

use super::GpuError;

/// Storage buffers hold the constants of sea, air, clouds, flare and invented detail; those of the flare are read by its
/// vertices. Textures with mipmaps have any size. A picture is shown by its bytes, and clouds read the depth that they are
/// tested against.
const FLAGS: wgpu::DownlevelFlags = wgpu::DownlevelFlags::FRAGMENT_STORAGE
    .union(wgpu::DownlevelFlags::VERTEX_STORAGE)
    .union(wgpu::DownlevelFlags::NON_POWER_OF_TWO_MIPMAPPED_TEXTURES)
    .union(wgpu::DownlevelFlags::VIEW_FORMATS)
    .union(wgpu::DownlevelFlags::READ_ONLY_DEPTH_STENCIL);

/// The least limits. The renderer's tests hold every pipeline against them; what is not named is a baseline below which wgpu
/// supports no adapter.
pub(crate) const fn limits() -> wgpu::Limits {
    wgpu::Limits {
        max_bind_groups: 2,
        max_bindings_per_bind_group: 256,
        max_sampled_textures_per_shader_stage: 16,
        max_samplers_per_shader_stage: 16,
        max_storage_buffers_per_shader_stage: 3,
        max_uniform_buffers_per_shader_stage: 11,
        max_inter_stage_shader_variables: 15,
        max_uniform_buffer_binding_size: 16 << 10,
        max_storage_buffer_binding_size: 16 << 10,
        // A single landscape of 2048 samples a side, with its picture.
        max_texture_dimension_2d: 2048,
        max_immediate_size: 0,
        ..wgpu::Limits::downlevel_webgl2_defaults()
    }
}

/// Whether an adapter of this name can draw everything.
///
/// # Errors
/// [`GpuError::TooWeak`] with all that it lacks.
pub(super) fn check(name: &str, limits: &wgpu::Limits, flags: wgpu::DownlevelFlags) -> Result<(), GpuError> {
    let mut lacks: Vec<_> =
        (FLAGS - flags).iter_names().map(|(flag, _)| flag.to_lowercase().replace('_', " ")).collect();
    self::limits().check_limits_with_fail_fn(limits, false, |limit, needed, has| {
        lacks.push(format!("{} {needed}: it has {has}", limit.replace('_', " ")));
    });
    if lacks.is_empty() {
        return Ok(());
    }
    Err(GpuError::TooWeak { adapter: name.to_owned(), lacks: lacks.join(", ") })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An OpenGL ES 3.0 adapter, as wgpu describes it, has no storage buffers at all.
    #[test]
    fn an_adapter_without_storage_buffers_is_refused_in_words() {
        let all = wgpu::DownlevelFlags::all();
        assert!(check("good", &wgpu::Limits::default(), all).is_ok());
        assert!(check("just", &limits(), FLAGS).is_ok());
        let webgl = wgpu::Limits::downlevel_webgl2_defaults();
        let error = check("old", &webgl, all - wgpu::DownlevelFlags::FRAGMENT_STORAGE).unwrap_err().to_string();
        let said = [
            "old",
            "fragment storage",
            "max storage buffers per shader stage 3: it has 0",
            super::super::ADAPTER_VARIABLE,
        ];
        assert!(said.iter().all(|part| error.contains(part)), "{error}");
        assert!(!error.contains("vertex storage") && !error.contains("bind groups"), "{error}");
    }

    /// Each is looked at: an adapter that lacks it, and nothing else, is refused.
    #[test]
    fn every_need_is_checked() {
        for flag in FLAGS.iter() {
            assert!(check("", &wgpu::Limits::default(), wgpu::DownlevelFlags::all() - flag).is_err(), "{flag:?}");
        }
        let less: [fn(&mut wgpu::Limits); 9] = [
            |limits| limits.max_bind_groups -= 1,
            |limits| limits.max_bindings_per_bind_group -= 1,
            |limits| limits.max_sampled_textures_per_shader_stage -= 1,
            |limits| limits.max_samplers_per_shader_stage -= 1,
            |limits| limits.max_storage_buffers_per_shader_stage -= 1,
            |limits| limits.max_uniform_buffers_per_shader_stage -= 1,
            |limits| limits.max_inter_stage_shader_variables -= 1,
            |limits| limits.max_storage_buffer_binding_size -= 1,
            |limits| limits.max_texture_dimension_2d -= 1,
        ];
        for change in less {
            let mut limits = limits();
            change(&mut limits);
            assert!(check("", &limits, FLAGS).is_err(), "{limits:?}");
        }
    }
}
