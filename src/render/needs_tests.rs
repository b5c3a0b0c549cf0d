//! Every pipeline that a test builds is held against what is asked of an adapter (`gpu/needs.rs`).

use std::sync::atomic::{AtomicU32, Ordering};

use super::pipelines::PassDescription;
use crate::gpu::needs::limits;

/// What a pipeline uses of the limits that are counted.
const NAMES: [&str; 5] = ["sampled textures", "samplers", "storage buffers", "uniform buffers", "varyings"];

/// The most of each that any pipeline has used.
static MOST: [AtomicU32; 5] = [const { AtomicU32::new(0) }; 5];

fn allowed() -> [u32; 5] {
    let limits = limits();
    [
        limits.max_sampled_textures_per_shader_stage,
        limits.max_samplers_per_shader_stage,
        limits.max_storage_buffers_per_shader_stage,
        limits.max_uniform_buffers_per_shader_stage,
        limits.max_inter_stage_shader_variables,
    ]
}

/// Counts what the stages of a pipeline use.
pub(super) fn examine_or_panic(pass: &PassDescription, module: &naga::Module) {
    let varyings = varyings(module);
    for stage in [wgpu::ShaderStages::VERTEX, wgpu::ShaderStages::FRAGMENT] {
        let count = |wanted: fn(&wgpu::BindingType) -> bool| {
            pass.bindings.iter().filter(|entry| entry.visibility.contains(stage) && wanted(&entry.ty)).count() as u32
        };
        let frame = u32::from(pass.frame);
        let used = [
            count(|ty| matches!(ty, wgpu::BindingType::Texture { .. })),
            count(|ty| matches!(ty, wgpu::BindingType::Sampler(_))),
            count(|ty| matches!(ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { .. }, .. })),
            frame + count(|ty| matches!(ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, .. })),
            varyings,
        ];
        for ((used, allowed), (name, most)) in used.into_iter().zip(allowed()).zip(NAMES.iter().zip(&MOST)) {
            assert!(used <= allowed, "{used} {name} in {}, but {allowed} are asked of an adapter", pass.name);
            most.fetch_max(used, Ordering::Relaxed);
        }
    }
}

/// Locations that the vertices hand to the fragments.
fn varyings(module: &naga::Module) -> u32 {
    let fragment = module.entry_points.iter().filter(|entry| entry.stage == naga::ShaderStage::Fragment);
    let located = |binding: &Option<naga::Binding>| matches!(binding, Some(naga::Binding::Location { .. }));
    let of_argument = |argument: &naga::FunctionArgument| match &module.types[argument.ty].inner {
        naga::TypeInner::Struct { members, .. } => members.iter().filter(|member| located(&member.binding)).count(),
        _ => usize::from(located(&argument.binding)),
    };
    fragment.flat_map(|entry| &entry.function.arguments).map(of_argument).sum::<usize>() as u32
}

/// No more storage buffers are asked of an adapter than some pipeline uses; of all else, no more than every adapter has.
pub(super) fn assert_all_is_needed() {
    let most = MOST.each_ref().map(|most| most.load(Ordering::Relaxed));
    println!("at most: {}", NAMES.iter().zip(most).map(|(name, most)| format!("{most} {name}, ")).collect::<String>());
    assert_eq!(most[2], allowed()[2]);
}
