//! How large is a picture really? What its file says in any place is checked before memory is taken.

use hayro_interpret::hayro_syntax::object::{Dict, Object, Stream};

use super::super::PlanFileError;
use crate::raster::{RasterError, SizeLimit};

/// As of pictures in files.
pub(super) fn check_size(width: u32, height: u32) -> Result<(), PlanFileError> {
    let SizeLimit { side, megapixels } = SizeLimit::PLAN;
    if width.max(height) > side || u64::from(width) * u64::from(height) > megapixels * 1_000_000 {
        return Err(RasterError::TooLarge { width, height, limit_side: side, limit_megapixels: megapixels }.into());
    }
    Ok(())
}

/// Whether what a picture says of its size, wherever it does, may be believed: its memory is taken before its pixels are read.
pub(super) fn check_picture(picture: &Stream) -> Result<(), PlanFileError> {
    let number = |dict: &Dict, name: &[u8], short: &[u8]| {
        let stated = dict.get::<usize>(name).or_else(|| dict.get::<usize>(short)).unwrap_or(0);
        u32::try_from(stated).unwrap_or(u32::MAX)
    };
    let stated = |dict: &Dict| (number(dict, b"Width", b"W"), number(dict, b"Height", b"H"));
    let dict = picture.dict();
    let mut sizes = vec![stated(dict)];
    for mask in [b"SMask".as_slice(), b"Mask"] {
        sizes.extend(dict.get::<Stream>(mask).map(|mask| stated(mask.dict())));
    }
    // Fax.
    let fax = |parameters: &Dict| (number(parameters, b"Columns", b"Columns"), number(parameters, b"Rows", b"Rows").max(stated(dict).1));
    match dict.get::<Object>(b"DecodeParms").or_else(|| dict.get::<Object>(b"DP")) {
        Some(Object::Dict(parameters)) => sizes.push(fax(&parameters)),
        Some(Object::Array(filters)) => sizes.extend(filters.iter::<Object>().filter_map(Object::into_dict).map(|dict| fax(&dict))),
        _ => {}
    }
    sizes.extend(size_in_jpeg(&picture.raw_data()));
    sizes.into_iter().try_for_each(|(width, height)| check_size(width, height))
}

/// Size that a JPEG or JPEG 2000 has in its own header.
fn size_in_jpeg(data: &[u8]) -> Option<(u32, u32)> {
    let number = |at: usize, length: usize| Some(data.get(at..at + length)?.iter().fold(0, |n, byte| (n << 8) | u32::from(*byte)));
    if let Some(at) = data.get(..1024.min(data.len()))?.windows(4).position(|w| w == [0xff, 0x4f, 0xff, 0x51]) {
        return Some((number(at + 8, 4)?, number(at + 12, 4)?));
    }
    let mut at = data.starts_with(&[0xff, 0xd8]).then_some(2)?;
    loop {
        let marker = number(at, 2)?;
        match marker {
            0xffc4 | 0xffc8 | 0xffcc => {}
            0xffc0..=0xffcf => return Some((number(at + 7, 2)?, number(at + 5, 2)?)),
            0xff00..=0xffff => {}
            _ => return None,
        }
        at += 2 + number(at + 2, 2)? as usize;
    }
}
