//! Pictures and textures brought back from the device.
//!
//! Owns the row padding that copies ask for; knows no pot.

/// Why a picture or a measurement could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// Not a size a picture can have; choose one within it.
    #[error("a picture of {width} x {height} pixels cannot be drawn here: choose 1 to {max} a side")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
        /// Longest side of the device.
        max: u32,
    },
    /// The device was lost or did not answer; open it again.
    #[error("the graphics device did not finish: {0}")]
    Poll(#[from] wgpu::PollError),
    /// The device refused to hand its memory over; open it again.
    #[error("the graphics device did not hand the picture over: {0}")]
    Map(#[from] wgpu::BufferAsyncError),
    /// The mapped memory could not be read; open the device again.
    #[error("the picture cannot be read: {0}")]
    Range(#[from] wgpu::MapRangeError),
    /// The picture could not be packed.
    #[error("the picture cannot be packed as PNG: {0}")]
    Png(#[from] png::EncodingError),
    /// The pictures could not be packed.
    #[error("the pictures cannot be packed as GIF: {0}")]
    Gif(#[from] gif::EncodingError),
}

/// Draws into a picture aside and brings its pixels back, row by row from the top.
///
/// # Errors
/// [`RenderError::Size`] when a side is zero or longer than the device allows; otherwise when the device was lost.
pub(super) fn pixels(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    format: wgpu::TextureFormat,
    (width, height): (u32, u32),
    draw: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::TextureView),
) -> Result<Vec<u8>, RenderError> {
    let max = device.limits().max_texture_dimension_2d;
    if width == 0 || height == 0 || width > max || height > max {
        return Err(RenderError::Size { width, height, max });
    }
    let target = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
    draw(&mut encoder, &view);
    queue.submit([encoder.finish()]);
    let texel_bytes = format.block_copy_size(None).expect("formats that are drawn into have one size");
    texels(device, queue, &target, texel_bytes)
}

/// The texels of a texture, row after row without padding.
pub(super) fn texels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
    texel_bytes: u32,
) -> Result<Vec<u8>, RenderError> {
    let row_bytes = texture.width() * texel_bytes;
    let padded = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded) * u64::from(texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded), rows_per_image: None },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        sender.send(result).expect("the receiver outlives the wait below");
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    receiver.recv().map_err(|_| wgpu::BufferAsyncError)??;
    let mapped = buffer.get_mapped_range(..)?;
    let mut bytes = Vec::with_capacity(row_bytes as usize * texture.height() as usize);
    for row in mapped.chunks_exact(padded as usize) {
        bytes.extend_from_slice(&row[..row_bytes as usize]);
    }
    Ok(bytes)
}
