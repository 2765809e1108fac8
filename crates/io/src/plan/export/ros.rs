//! How is a plan handed to a robot? As a ROS map: a grey image and a `map.yaml`.

use planwalk_types::{Cell, FloorPlan};

/// The plan as a PGM image (P5): 0 wall, 254 free, 205 unknown, as map savers write them; row 0 is the top.
pub fn ros_map_image(plan: &FloorPlan) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", plan.width(), plan.height()).into_bytes();
    for row in plan.cells().chunks(plan.width()).rev() {
        bytes.extend(row.iter().map(|cell| match cell {
            Cell::Wall | Cell::Window => 0u8,
            Cell::Free | Cell::Door => 254,
            Cell::Unknown => 205,
        }));
    }
    bytes
}

/// The `map.yaml` that goes with [`ros_map_image`] saved as `image` beside it.
///
/// `free_thresh` is 0.196, not the saver's 0.25: with that, 205 would reload as free.
pub fn ros_map_yaml(plan: &FloorPlan, image: &str) -> String {
    let (x, y) = (plan.origin().x, plan.origin().y);
    format!(
        "image: {image}\nresolution: {}\norigin: [{x}, {y}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n",
        plan.cell_m()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{PlanOptions, read};
    use planwalk_types::Pt2;

    #[test]
    fn a_map_reads_back_as_it_was_written() {
        let kinds = [Cell::Wall, Cell::Free, Cell::Unknown, Cell::Free, Cell::Free, Cell::Wall];
        let plan = FloorPlan::new(Pt2::new(-1.5, 2.25), 0.1, 3, 2, kinds.to_vec()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("m.pgm"), ros_map_image(&plan)).unwrap();
        std::fs::write(folder.path().join("m.yaml"), ros_map_yaml(&plan, "m.pgm")).unwrap();
        let read = read(&folder.path().join("m.yaml"), &PlanOptions::default()).unwrap().plan;
        assert_eq!(read.cells(), plan.cells());
        assert!(read.origin().distance(plan.origin()) < 1e-12 && (read.cell_m() - 0.1).abs() < 1e-12);
    }
}
