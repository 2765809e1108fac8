//! Is this picture safe to open, and what is in it? Sizes are checked from the header, before any memory is taken.

use std::io::BufWriter;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageReader, Limits};
use planwalk_types::GrayImage;

/// Why a picture cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RasterError {
    /// The file system refuses.
    #[error("the image cannot be opened: {0}")]
    Io(#[from] std::io::Error),
    /// Not a picture, or a damaged one.
    #[error("the image cannot be decoded ({reason}): is it complete, and really an image? Open it in a viewer and save it as PNG")]
    Unreadable {
        /// What the decoder says.
        reason: String,
    },
    /// More pixels than are sensible.
    #[error(
        "the image has {width}×{height} px, over the limit of {limit_side} px a side and {limit_megapixels} megapixels: \
         scale it down first (e.g. magick IN -resize 25% OUT.png)"
    )]
    TooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Longest side allowed.
        limit_side: u32,
        /// Most pixels allowed, millions.
        limit_megapixels: u64,
    },
    /// No pixels.
    #[error("the image has {width}×{height} px: it is empty")]
    Empty {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
}

/// How large a picture may be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SizeLimit {
    pub side: u32,
    pub megapixels: u64,
}

impl SizeLimit {
    /// Scanned plans: 300 m at 1 cm, or an A0 sheet at 600 dpi. As RGBA that is at most 2 GB for a moment.
    pub const PLAN: Self = Self { side: 32_000, megapixels: 500 };
    /// Video frames: above 12K.
    pub const FRAME: Self = Self { side: 16_384, megapixels: 100 };
}

/// The picture, upright: an EXIF orientation is applied.
pub(crate) fn open(path: &Path, limit: SizeLimit) -> Result<DynamicImage, RasterError> {
    let unreadable = |e: image::ImageError| RasterError::Unreadable { reason: e.to_string() };
    let (width, height) = ImageReader::open(path)?.with_guessed_format()?.into_dimensions().map_err(unreadable)?;
    if width == 0 || height == 0 {
        return Err(RasterError::Empty { width, height });
    }
    if width.max(height) > limit.side || u64::from(width) * u64::from(height) > limit.megapixels * 1_000_000 {
        return Err(RasterError::TooLarge { width, height, limit_side: limit.side, limit_megapixels: limit.megapixels });
    }
    let mut reader = ImageReader::open(path)?.with_guessed_format()?;
    let mut limits = Limits::default();
    // Eight bytes a pixel hold 16-bit RGBA; the rest is for the decoder.
    limits.max_alloc = Some(u64::from(width) * u64::from(height) * 8 + (64 << 20));
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(unreadable)?;
    let orientation = decoder.orientation().map_err(unreadable)?;
    let mut picture = DynamicImage::from_decoder(decoder).map_err(unreadable)?;
    picture.apply_orientation(orientation);
    Ok(picture)
}

/// Writes a grey picture as PNG: quickly rather than as small as can be, because videos have thousands.
pub(crate) fn write_png(path: &Path, picture: &GrayImage) -> Result<(), RasterError> {
    let file = BufWriter::new(std::fs::File::create(path)?);
    let encoder = PngEncoder::new_with_quality(file, CompressionType::Fast, FilterType::Up);
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    encoder.write_image(picture.data(), width, height, ExtendedColorType::L8).map_err(|e| match e {
        image::ImageError::IoError(why) => RasterError::Io(why),
        other => RasterError::Unreadable { reason: other.to_string() },
    })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A PNG that says it is this large, and holds nothing.
    pub(crate) fn png_header(width: u32, height: u32) -> Vec<u8> {
        let mut ihdr = b"IHDR".to_vec();
        ihdr.extend(width.to_be_bytes());
        ihdr.extend(height.to_be_bytes());
        ihdr.extend([8, 0, 0, 0, 0]);
        let crc = ihdr
            .iter()
            .fold(!0u32, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 }));
        let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\x0d".to_vec();
        png.extend(ihdr);
        png.extend((!crc).to_be_bytes());
        // An image data chunk must be announced, or the header is not accepted.
        png.extend(b"\0\0\0\x02IDAT\x78\x9c\0\0\0\0");
        png
    }

    #[test]
    fn a_huge_header_is_refused_before_memory_is_taken() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("huge.png");
        std::fs::write(&path, png_header(60_000, 60_000)).unwrap();
        let error = open(&path, SizeLimit::PLAN).unwrap_err();
        assert!(matches!(error, RasterError::TooLarge { width: 60_000, height: 60_000, .. }), "{error}");
        assert!(error.to_string().contains("60000×60000"), "{error}");
    }

    #[test]
    fn an_image_without_pixels_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("zero.png");
        std::fs::write(&path, png_header(0, 0)).unwrap();
        assert!(open(&path, SizeLimit::PLAN).is_err());
        std::fs::write(&path, "P5\n0 0\n255\n").unwrap();
        assert!(open(&path, SizeLimit::PLAN).is_err());
    }

    #[test]
    fn a_cut_off_image_and_a_text_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("cut.png");
        std::fs::write(&path, png_header(30, 20)).unwrap();
        assert!(matches!(open(&path, SizeLimit::PLAN), Err(RasterError::Unreadable { .. })));
        std::fs::write(&path, "this is no image").unwrap();
        assert!(matches!(open(&path, SizeLimit::PLAN), Err(RasterError::Unreadable { .. })));
        std::fs::write(&path, "").unwrap();
        assert!(matches!(open(&path, SizeLimit::PLAN), Err(RasterError::Unreadable { .. })));
    }
}
