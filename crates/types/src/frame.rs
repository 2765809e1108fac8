//! One picture of the video.

use crate::time::Stamp;

/// An 8-bit grey image, row-major, without padding; row 0 is the top.
#[derive(Clone, PartialEq, Eq)]
pub struct GrayImage {
    width: usize,
    height: usize,
    data: Vec<u8>,
}

impl GrayImage {
    /// The image of these bytes, or `None` unless there are exactly `width · height` of them and at least one.
    pub fn new(width: usize, height: usize, data: Vec<u8>) -> Option<Self> {
        (width > 0 && height > 0 && width.checked_mul(height) == Some(data.len())).then_some(Self { width, height, data })
    }

    /// The image whose pixel (u, v) is `value(u, v)`; sizes of zero become one.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> u8) -> Self {
        let (width, height) = (width.max(1), height.max(1));
        let mut data = Vec::with_capacity(width * height);
        for v in 0..height {
            data.extend((0..width).map(|u| value(u, v)));
        }
        Self { width, height, data }
    }

    /// Columns.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> usize {
        self.height
    }

    /// All pixels, row by row.
    pub fn data(&self) -> &[u8] {
        &self.data
    }

    /// One row.
    ///
    /// # Panics
    /// When `v` is not a row of the image.
    pub fn row(&self, v: usize) -> &[u8] {
        &self.data[v * self.width..(v + 1) * self.width]
    }

    /// The pixel in column `u` of row `v`.
    ///
    /// # Panics
    /// When it is not in the image.
    pub fn at(&self, u: usize, v: usize) -> u8 {
        self.row(v)[u]
    }
}

impl std::fmt::Debug for GrayImage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "GrayImage {}×{}", self.width, self.height)
    }
}

/// A grey image with the moment at which it was taken.
#[derive(Debug, Clone)]
pub struct VideoFrame {
    /// The container's own stamp.
    pub stamp: Stamp,
    /// What was seen, upright: rotation metadata is already applied.
    pub image: GrayImage,
}
