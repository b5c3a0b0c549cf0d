//! Textures back to the CPU.

use super::Gpu;

/// How long a finished mapping may take to be told.
pub(super) const CALL_BACK: std::time::Duration = std::time::Duration::from_secs(10);

/// Why nothing could be read back.
#[derive(Debug, thiserror::Error)]
pub enum ReadbackError {
    /// The device was lost or the wait failed.
    #[error(
        "the picture could not be read back from the GPU\n  {0}\n  try a smaller size, or another adapter (RELIEF_ADAPTER=NAME)"
    )]
    Wait(String),
    /// Fewer bytes came back than the size asks for.
    #[error(
        "the GPU returned less data than the picture holds\n  the driver is at fault\n  try another adapter (RELIEF_ADAPTER=NAME)"
    )]
    Short,
}

/// Reads mip 0 of a 2D `texture`: tightly packed rows, row 0 first. Waits for the GPU.
///
/// # Errors
/// [`ReadbackError`] where the buffer cannot be mapped.
pub fn read_texture(gpu: &Gpu, texture: &wgpu::Texture) -> Result<Vec<u8>, ReadbackError> {
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let row = texture.width() * texel;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        texture.size(),
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = map_and_wait(gpu, &buffer)?;
    Ok(bytes.chunks_exact(padded as usize).flat_map(|line| &line[..row as usize]).copied().collect())
}

/// Maps `buffer`, waits, and copies its bytes out.
pub(crate) fn map_and_wait(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, ReadbackError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // The receiver is gone only when the wait below failed, which is reported there.
        let _ = sender.send(result);
    });
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| ReadbackError::Wait(error.to_string()))?;
    // Another thread's poll may be the one that calls back, a moment after ours has returned.
    match receiver.recv_timeout(CALL_BACK) {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(ReadbackError::Wait(error.to_string())),
        Err(_) => return Err(ReadbackError::Wait(gpu.lost().unwrap_or_else(|| "the buffer was never mapped".into()))),
    }
    let bytes = buffer.slice(..).get_mapped_range().map_err(|error| ReadbackError::Wait(error.to_string()))?.to_vec();
    buffer.unmap();
    Ok(bytes)
}
