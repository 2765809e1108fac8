//! Where does a text begin? At the left end of its base line, whatever its alignment is.

use dxf::entities::{Attribute, MText, Text};
use dxf::enums::{AttachmentPoint, HorizontalTextJustification as Across, VerticalTextJustification as Upwards};

use super::curves::{Affine, Point, rad};
use super::objects::Shape;
use super::shapes::plane;
use super::words;

/// Width of a letter as a share of its height, where a text's left end must be guessed from its middle or its right end.
const LETTER_WIDTH: f64 = 0.75;

/// From base line to base line, in heights of a capital letter.
const LINE_SPACING: f64 = 5.0 / 3.0;

/// Where a line of text begins, from what its alignment says.
struct Alignment {
    first: Point,
    second: Point,
    across: Across,
    upwards: Upwards,
}

impl Alignment {
    /// CAD programmes write the left end of the base line whatever the alignment is. Others write the point of alignment twice or zeros;
    /// then the left end is guessed from the number of letters.
    fn base(&self, text: &str, height: f64, stretch: f64, turn_rad: f64) -> Point {
        let plain = self.across == Across::Left && self.upwards == Upwards::Baseline;
        let known = self.first != self.second && self.first != [0.0, 0.0];
        if plain || known || matches!(self.across, Across::Aligned | Across::Fit) {
            return self.first;
        }
        let width = text.chars().count() as f64 * height * LETTER_WIDTH * stretch;
        let left = match self.across {
            Across::Center | Across::Middle => 0.5 * width,
            Across::Right => width,
            _ => 0.0,
        };
        let down = match (self.across, self.upwards) {
            (Across::Middle, _) | (_, Upwards::Middle) => 0.5 * height,
            (_, Upwards::Top) => height,
            _ => 0.0,
        };
        Affine::shift(self.second).after(&Affine::turn(turn_rad)).point([-left, -down])
    }
}

/// What a text and an attribute have in common, which the crate gives no name.
macro_rules! line_of {
    ($text:expr, $said:expr) => {{
        let (text, said): (_, String) = ($text, $said);
        let alignment = Alignment {
            first: [text.location.x, text.location.y],
            second: [text.second_alignment_point.x, text.second_alignment_point.y],
            across: text.horizontal_text_justification,
            upwards: text.vertical_text_justification,
        };
        let at = alignment.base(&said, text.text_height, text.relative_x_scale_factor, rad(text.rotation));
        written(plane(&text.normal, text.location.z), at, text.text_height, said)
    }};
}

pub(super) fn single_line(text: &Text) -> Option<(Affine, Shape)> {
    line_of!(text, words::of_text(&text.value))
}

/// `None` if it is not shown.
pub(super) fn label(attribute: &Attribute) -> Option<(Affine, Shape)> {
    if attribute.is_invisible() {
        return None;
    }
    line_of!(attribute, words::of_mtext(&attribute.value))
}

/// Paragraphs are lines here: where longer ones are broken, only the fonts would tell.
pub(super) fn paragraphs(text: &MText) -> Option<(Affine, Shape)> {
    use AttachmentPoint::{BottomCenter, BottomLeft, BottomRight, MiddleCenter, MiddleLeft, MiddleRight, TopCenter, TopRight};
    let said = words::of_mtext(&(text.extended_text.concat() + &text.text));
    let height = text.initial_text_height;
    let letters = said.lines().map(|l| l.chars().count()).max().unwrap_or(0);
    let width = letters as f64 * height * LETTER_WIDTH;
    let deep = height * (1.0 + said.lines().count().saturating_sub(1) as f64 * LINE_SPACING * text.line_spacing_factor);
    let left = match text.attachment_point {
        TopCenter | MiddleCenter | BottomCenter => 0.5 * width,
        TopRight | MiddleRight | BottomRight => width,
        _ => 0.0,
    };
    let down = match text.attachment_point {
        BottomLeft | BottomCenter | BottomRight => height - deep,
        MiddleLeft | MiddleCenter | MiddleRight => height - 0.5 * deep,
        _ => height,
    };
    let axis = &text.x_axis_direction;
    // Either may be given; the direction is 1, 0, 0 where it is not.
    let turn_rad = if axis.y == 0.0 && axis.x >= 0.0 { rad(text.rotation_angle) } else { axis.y.atan2(axis.x) };
    let at = [text.insertion_point.x, text.insertion_point.y];
    let base = Affine::shift(at).after(&Affine::turn(turn_rad)).point([-left, -down]);
    written(Affine::IDENTITY, base, height, said)
}

/// `None` if nothing is written.
fn written(plane: Affine, at: Point, height: f64, text: String) -> Option<(Affine, Shape)> {
    (!text.is_empty()).then_some((plane, Shape::Text { at, height, text }))
}
