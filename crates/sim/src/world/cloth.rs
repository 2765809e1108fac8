//! How bright is this piece of a person? Shirts, trousers, hair and faces, averaged over what one pixel sees of them.

use super::figure::{Cover, Met};
use crate::texture::{Spot, band, cell, hash, lines, mosaic, noise};

impl Met {
    /// Brightness of the cloth in full light, averaged over a pixel that is `footprint` metres wide there; lit from above.
    pub fn brightness(&self, footprint: f32) -> f32 {
        // The trunk is made of several capsules, but a shirt hangs over all of them alike.
        let relief = if self.cover == Cover::Trunk { 0.05 } else { 0.20 };
        let shade = 0.76 + relief * self.own[2] as f32 + 0.05 * self.normal[0] as f32 + 0.03 * self.normal[1] as f32;
        self.cloth(footprint) * shade
    }

    fn cloth(&self, f: f32) -> f32 {
        let (u, v, seed) = (self.u as f32, self.v as f32, self.seed);
        let spot = Spot { u, v, fu: f, fv: f };
        let tone = |key: i32| cell(key, 0, seed);
        let skin = 0.42 + 0.32 * tone(1);
        // Cloth folds: soft, along the limb.
        let folds = 0.07 * noise(u * 9.0, v * 4.0, 9.0 * f, seed ^ 5) + 0.04 * noise(u * 30.0, v * 14.0, 30.0 * f, seed ^ 6);
        match self.cover {
            Cover::Skin => skin + 0.02 * noise(u * 40.0, v * 40.0, 40.0 * f, seed),
            Cover::Head => self.head(skin, f),
            Cover::Trunk | Cover::Sleeve => self.shirt(spot, tone(2), tone(3)) * (1.0 + 1.6 * folds),
            Cover::Trousers => {
                (0.10 + 0.38 * tone(4) * tone(4)) * (1.0 + 2.2 * folds) + 0.02 * noise(u * 90.0, v * 90.0, 90.0 * f, seed ^ 7)
            }
            Cover::Shoe => 0.08 + 0.6 * tone(5) * tone(5) * tone(5),
            Cover::Bag => {
                let seam = lines(v / 0.16, 0.08, f / 0.16);
                let bag = 0.12 + 0.5 * tone(6) + folds;
                bag + seam * (0.08 - bag)
            }
        }
    }

    /// Plain, striped, checked or printed.
    fn shirt(&self, spot: Spot, tone: f32, other: f32) -> f32 {
        let base = 0.10 + 0.75 * tone;
        let ink = if base > 0.5 { 0.06 + 0.3 * other } else { 0.55 + 0.4 * other };
        match hash(11, 3, self.seed) % 5 {
            0 => base + lines(spot.v / 0.06, 0.45, spot.fv / 0.06) * (ink - base),
            1 => {
                let check = 0.5 * (lines(spot.v / 0.07, 0.5, spot.fv / 0.07) + lines(spot.u / 0.07, 0.5, spot.fu / 0.07));
                base + check * (ink - base)
            }
            2 => {
                // A print on the chest and one on the back.
                let print = mosaic(spot.scaled(0.0, 0.0, 0.022, 0.03), self.seed ^ 9);
                let on_trunk = if self.cover == Cover::Trunk { 1.0 } else { 0.0 };
                let share = on_trunk * band(spot.v, 1.10, 1.32, spot.fv) * band(spot.u, -0.12, 0.12, spot.fu);
                base + share * (print - 0.3).clamp(0.0, 0.7) / 0.7 * (ink - base)
            }
            _ => base,
        }
    }

    /// Hair above and behind, a face in front.
    fn head(&self, skin: f32, f: f32) -> f32 {
        let [x, y, z] = self.own.map(|v| v as f32);
        let (hair, soft) = (0.05 + 0.5 * cell(10, 0, self.seed) * cell(10, 0, self.seed), (f / 0.08).max(0.12));
        // Higher in front than behind.
        let line = z - 0.75 * x + 0.1;
        let share = (line / soft + 0.5).clamp(0.0, 1.0);
        let height = self.v as f32 + 0.08 * z;
        let eyes = band(y.abs(), 0.22, 0.5, soft) * band(height, 0.035, 0.055, f)
            + band(y.abs(), -1.0, 0.3, soft) * band(height, -0.045, -0.033, f);
        let face = skin * (1.0 - 0.55 * eyes * (2.0 * x - 1.0).clamp(0.0, 1.0));
        let strands = hair * (1.0 + 0.5 * noise(y * 9.0, z * 3.0 + 5.0, 9.0 * f / 0.08, self.seed ^ 3));
        face + share * (strands - face)
    }
}
