//! What does an SVG of ours look like as pixels? Drawn without fonts, files or network, so the same everywhere.

use resvg::{tiny_skia, usvg};

/// Why a drawing could not be turned into pixels.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The text is no SVG.
    #[error("the drawing is not valid SVG: {0}")]
    NotSvg(#[from] usvg::Error),
    /// No memory, or a size of zero.
    #[error("a picture of {width}×{height} px cannot be made: use a smaller drawing")]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The pixels could not be packed.
    #[error("the picture could not be written as PNG: {0}")]
    Encoding(String),
    /// The frames could not be packed.
    #[error("the animation could not be written as GIF: {0}")]
    Animation(String),
}

/// The PNG file of an SVG drawing at its own size.
///
/// # Errors
/// [`PictureError`] when the text is no SVG, or its size is zero or beyond memory.
pub fn png_of(svg: &str) -> Result<Vec<u8>, PictureError> {
    png_within(svg, u32::MAX)
}

/// The same, made smaller where it would be wider or higher than this.
///
/// # Errors
/// As [`png_of`].
pub fn png_within(svg: &str, most_px: u32) -> Result<Vec<u8>, PictureError> {
    pixels_within(svg, most_px)?.encode_png().map_err(|e| PictureError::Encoding(e.to_string()))
}

/// The pixels of an SVG drawing, made smaller where it would be wider or higher than this.
pub(super) fn pixels_within(svg: &str, most_px: u32) -> Result<tiny_skia::Pixmap, PictureError> {
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default())?;
    let (width, height) = (tree.size().width(), tree.size().height());
    let scale = (most_px as f32 / width.max(height)).min(1.0);
    let [columns, rows] = [width, height].map(|side| (scale * side).ceil().max(1.0) as u32);
    let mut pixels = tiny_skia::Pixmap::new(columns, rows).ok_or(PictureError::Size { width: columns, height: rows })?;
    resvg::render(&tree, tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_those_of_the_drawing() {
        let svg = r##"<svg xmlns="http://www.w3.org/2000/svg" width="2" height="1"><rect width="1" height="1" fill="#ff0000"/></svg>"##;
        let png = png_of(svg).unwrap();
        assert_eq!(&png[1..4], b"PNG");
        let pixels = tiny_skia::Pixmap::decode_png(&png).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (2, 1));
        assert_eq!(&pixels.data()[..8], &[255, 0, 0, 255, 0, 0, 0, 0]);
    }

    #[test]
    fn large_drawings_are_made_smaller_and_small_ones_stay() {
        let svg = r##"<svg xmlns="http://www.w3.org/2000/svg" width="30" height="12"><rect width="30" height="12" fill="#ff0000"/></svg>"##;
        let size = |most_px: u32| {
            let pixels = pixels_within(svg, most_px).unwrap();
            (pixels.width(), pixels.height(), pixels.data()[..4].to_vec())
        };
        let red = vec![255, 0, 0, 255];
        assert_eq!(size(10), (10, 4, red.clone()));
        assert_eq!(size(300), (30, 12, red));
    }

    #[test]
    fn what_is_no_drawing_is_said() {
        assert!(matches!(png_of("hello"), Err(PictureError::NotSvg(_))));
    }
}
