//! Is this picture safe to open, and what is in it? Sizes are checked from the header, before any memory is taken.

use std::io::BufWriter;
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::metadata::Orientation;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, ImageFormat, ImageReader, Limits};
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

/// Most pixels that a byte of JPEG holds: a block of 8 × 8 takes a bit at least, and colours may have a quarter of the blocks.
/// Decoders fill up what is missing, a kilobyte to gigabytes.
const JPEG_GAIN: u64 = 2048;

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

/// Columns and rows of a picture as it is seen upright, from its header alone.
///
/// # Errors
/// [`RasterError`].
pub fn size(path: &Path) -> Result<[u32; 2], RasterError> {
    let unreadable = |e: image::ImageError| RasterError::Unreadable { reason: e.to_string() };
    let mut decoder = ImageReader::open(path)?.with_guessed_format()?.into_decoder().map_err(unreadable)?;
    let (width, height) = decoder.dimensions();
    let turned = matches!(
        decoder.orientation().map_err(unreadable)?,
        Orientation::Rotate90 | Orientation::Rotate270 | Orientation::Rotate90FlipH | Orientation::Rotate270FlipH
    );
    Ok(if turned { [height, width] } else { [width, height] })
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
    let bytes = std::fs::metadata(path)?.len();
    if reader.format() == Some(ImageFormat::Jpeg) && u64::from(width) * u64::from(height) > bytes.saturating_mul(JPEG_GAIN) {
        let reason = format!("it says {width}×{height} px, of which {bytes} bytes can hold but the beginning");
        return Err(RasterError::Unreadable { reason });
    }
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
    fn a_jpeg_of_few_bytes_and_many_pixels_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("cut.jpg");
        image::GrayImage::new(64, 48).save(&path).unwrap();
        assert!(open(&path, SizeLimit::PLAN).is_ok());
        let mut bytes = std::fs::read(&path).unwrap();
        // The frame: marker, length, bits, height, width.
        let frame = bytes.windows(2).position(|marker| marker == [0xff, 0xc0]).unwrap();
        bytes[frame + 5..frame + 9].copy_from_slice(&[0x4e, 0x20, 0x4e, 0x20]);
        std::fs::write(&path, &bytes).unwrap();
        let error = open(&path, SizeLimit::PLAN).unwrap_err().to_string();
        assert!(error.contains("20000×20000 px"), "{error}");
        assert_eq!(size(&path).unwrap(), [20_000, 20_000]);
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
