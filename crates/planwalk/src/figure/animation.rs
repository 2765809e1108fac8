//! What do drawings look like one after the other? A GIF, which every browser and slide shows without a player.

use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbaImage};

use super::png::{PictureError, pixels_within};

/// How long a frame stands, milliseconds, and the last one, on which one wants to look.
const FRAME_MS: u32 = 220;
const LAST_MS: u32 = 2500;
/// How carefully the colours of a frame are chosen, 1..=30, 30 being the fastest: drawings have few colours.
const SPEED: i32 = 20;

/// The GIF of SVG drawings in order, without end. All should have the size of the first.
///
/// # Errors
/// [`PictureError`] when a text is no SVG, or its size is zero or beyond what a GIF holds.
pub fn gif_of(frames: &[String]) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Vec::new();
    let failed = |why: image::ImageError| PictureError::Animation(why.to_string());
    let mut encoder = GifEncoder::new_with_speed(&mut bytes, SPEED);
    encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
    for (i, svg) in frames.iter().enumerate() {
        let pixels = pixels_within(svg, u32::MAX)?;
        let (width, height) = (pixels.width(), pixels.height());
        // Drawings have an opaque ground, so that straight and premultiplied colours agree.
        let image = RgbaImage::from_raw(width, height, pixels.take()).ok_or(PictureError::Size { width, height })?;
        let ms = if i + 1 == frames.len() { LAST_MS } else { FRAME_MS };
        encoder.encode_frame(Frame::from_parts(image, 0, 0, Delay::from_numer_denom_ms(ms, 1))).map_err(failed)?;
    }
    drop(encoder);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::AnimationDecoder;

    #[test]
    fn each_drawing_is_a_frame() {
        let of = |fill: &str| {
            format!(r#"<svg xmlns="http://www.w3.org/2000/svg" width="4" height="3"><rect width="4" height="3" fill="{fill}"/></svg>"#)
        };
        let gif = gif_of(&[of("red"), of("blue")]).unwrap();
        let decoder = image::codecs::gif::GifDecoder::new(std::io::Cursor::new(gif)).unwrap();
        let frames = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), 2);
        assert_eq!(frames[1].buffer().get_pixel(1, 1).0, [0, 0, 255, 255]);
        assert!(gif_of(&["hello".to_owned()]).is_err());
    }
}
