//! The kept picture onto the window. Its shader is `present.wgsl`.

use crate::gpu::{Gpu, Target};

use super::frame::texture_entry;
use super::pipelines::{Built, PassDescription};

pub(super) fn describe(format: wgpu::TextureFormat) -> PassDescription {
    PassDescription {
        modules: Vec::new(),
        bindings: vec![texture_entry(0, false, false)],
        frame: false,
        depth: None,
        format,
        ..PassDescription::scene("present", "present.wgsl", false)
    }
}

/// Draws `target`'s picture over all of `pass`, whose attachment has `format`.
pub(super) fn draw(
    gpu: &Gpu,
    built: &Built,
    pass: &mut wgpu::RenderPass<'_>,
    format: wgpu::TextureFormat,
    target: &Target,
) {
    // A window without automatic conversion gets the bytes as they are; one with it must be given linear light.
    let view = if format.is_srgb() { &target.color_view } else { &target.bytes_view };
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("present"),
        layout: &built.layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(view) }],
    });
    pass.set_pipeline(&built.pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.draw(0..3, 0..1);
}
