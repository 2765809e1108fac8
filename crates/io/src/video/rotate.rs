//! Which way up is the picture? Phones store the sensor's picture and how to turn it.

/// A clockwise turn by quarters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turn {
    None,
    Right,
    Half,
    Left,
}

impl Turn {
    /// The turn nearest to this clockwise angle.
    pub fn from_clockwise_deg(deg: f64) -> Self {
        match (deg / 90.0).round().rem_euclid(4.0) as i64 {
            1 => Self::Right,
            2 => Self::Half,
            3 => Self::Left,
            _ => Self::None,
        }
    }

    /// The angle, clockwise.
    pub fn degrees(self) -> u32 {
        match self {
            Self::None => 0,
            Self::Right => 90,
            Self::Half => 180,
            Self::Left => 270,
        }
    }

    /// The turned picture: columns, rows, pixels.
    pub fn apply(self, width: usize, height: usize, pixels: Vec<u8>) -> (usize, usize, Vec<u8>) {
        let upright = |columns: usize, rows: usize, at: &dyn Fn(usize, usize) -> usize| {
            let turned = (0..columns * rows).map(|i| pixels[at(i % columns, i / columns)]).collect();
            (columns, rows, turned)
        };
        match self {
            Self::None => (width, height, pixels),
            Self::Right => upright(height, width, &|u, v| (height - 1 - u) * width + v),
            Self::Half => upright(width, height, &|u, v| (height - 1 - v) * width + (width - 1 - u)),
            Self::Left => upright(height, width, &|u, v| u * width + (width - 1 - v)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_clockwise() {
        // 1 2 3      4 1
        // 4 5 6  ─▶  5 2   to the right
        //            6 3
        let picture = || vec![1, 2, 3, 4, 5, 6];
        assert_eq!(Turn::Right.apply(3, 2, picture()), (2, 3, vec![4, 1, 5, 2, 6, 3]));
        assert_eq!(Turn::Half.apply(3, 2, picture()), (3, 2, vec![6, 5, 4, 3, 2, 1]));
        assert_eq!(Turn::Left.apply(3, 2, picture()), (2, 3, vec![3, 6, 2, 5, 1, 4]));
        assert_eq!(Turn::None.apply(3, 2, picture()), (3, 2, picture()));
    }

    #[test]
    fn angles_are_taken_modulo_a_turn() {
        assert_eq!(Turn::from_clockwise_deg(-90.0), Turn::Left);
        assert_eq!(Turn::from_clockwise_deg(450.2), Turn::Right);
        assert_eq!(Turn::from_clockwise_deg(f64::NAN), Turn::None);
    }
}
