//! How does one get from storey to storey? By stairs and lifts that the source says to join them, or that lie above each other.

use planwalk_types::{Building, Element, ElementKind, Plan, Pt2};

use super::super::bounds::Bounds;

/// Storeys whose stairs overlap by this much of the smaller one are joined there.
const OVERLAP: f64 = 0.3;
/// A lift that is drawn as a point or a line is this wide, metres.
const POINT_M: f64 = 2.0;

/// Most stairs and lifts that are looked at: an airport has some hundreds.
const MOST: usize = 5000;

/// A staircase or a lift.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// [`ElementKind::Stairs`] or [`ElementKind::Lift`].
    pub kind: ElementKind,
    /// What a storey calls it, the lowest that does.
    pub name: Option<String>,
    /// Storeys that it joins, indices into [`Building::levels`], rising; one only where nothing lies above or below.
    pub storeys: Vec<usize>,
    /// Its middle on the lowest of them.
    pub at: Pt2<Plan>,
}

/// The box around a shape, points and lines widened.
fn box_of(element: &Element) -> Option<Bounds> {
    let points: Vec<[f64; 2]> = element.form.points().map(|p| [p.x, p.y]).collect();
    let bounds = Bounds::of(&points)?;
    if bounds.area() > 0.0 {
        return Some(bounds);
    }
    let wider = bounds.size().map(|side| 0.5 * (POINT_M - side).max(0.0));
    Some(Bounds { low: [0, 1].map(|k| bounds.low[k] - wider[k]), high: [0, 1].map(|k| bounds.high[k] + wider[k]) })
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    let common = [0, 1].map(|k| (a.high[k].min(b.high[k]) - a.low[k].max(b.low[k])).max(0.0));
    common[0] * common[1] >= OVERLAP * a.area().min(b.area())
}

/// Storeys that the source itself says it joins.
fn said(element: &Element, building: &Building) -> Vec<usize> {
    element.joins.iter().filter_map(|ordinal| building.levels.iter().position(|level| level.ordinal == *ordinal)).collect()
}

/// All stairs and lifts of a building, from the lowest storey up.
pub fn connections(building: &Building) -> Vec<Connection> {
    // What goes up from the storey below, with its box there.
    let mut all: Vec<(Connection, Bounds)> = Vec::new();
    for (storey, level) in building.levels.iter().enumerate() {
        for element in level.elements.iter().filter(|e| matches!(e.kind, ElementKind::Stairs | ElementKind::Lift)) {
            let Some(bounds) = box_of(element).filter(|_| all.len() < MOST) else { continue };
            let said = said(element, building);
            let goes_on = |(connection, below): &&mut (Connection, Bounds)| {
                let last = connection.storeys.last().copied().unwrap_or(storey);
                // On one storey, flights of one staircase overlap or touch.
                connection.kind == element.kind && (last + 1 >= storey || connection.storeys.contains(&storey)) && overlap(below, &bounds)
            };
            match all.iter_mut().find(goes_on) {
                Some((connection, below)) => {
                    connection.storeys.extend(std::iter::once(storey).chain(said));
                    connection.storeys.sort_unstable();
                    connection.storeys.dedup();
                    *below = bounds;
                    connection.name = connection.name.take().or_else(|| element.name.clone());
                }
                None => {
                    let (kind, name) = (element.kind, element.name.clone());
                    let [x, y] = [0, 1].map(|k| 0.5 * (bounds.low[k] + bounds.high[k]));
                    let mut storeys: Vec<usize> = std::iter::once(storey).chain(said).collect();
                    storeys.sort_unstable();
                    storeys.dedup();
                    all.push((Connection { kind, name, storeys, at: Pt2::new(x, y) }, bounds));
                }
            }
        }
    }
    all.into_iter().map(|(connection, _)| connection).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use planwalk_types::{Form, Level};

    fn at(kind: ElementKind, x: f64) -> Element {
        let corners = [(x, 0.0), (x + 3.0, 0.0), (x + 3.0, 5.0), (x, 5.0)].map(|(x, y)| Pt2::new(x, y));
        Element::new(kind, Form::Area(vec![corners.to_vec()]))
    }

    fn building(storeys: Vec<Vec<Element>>) -> Building {
        let level = |(n, elements): (usize, Vec<Element>)| Level { ordinal: n as i32, name: n.to_string(), elements };
        Building { levels: storeys.into_iter().enumerate().map(level).collect(), georeference: None }
    }

    #[test]
    fn stairs_join_the_storeys_on_which_they_lie_above_each_other() {
        use ElementKind::{Lift, Stairs};
        let lift = Element { name: Some("L1".to_owned()), ..Element::new(Lift, Form::Spot(Pt2::new(20.0, 1.0))) };
        let found = connections(&building(vec![
            vec![at(Stairs, 0.0), Element::new(Lift, Form::Spot(Pt2::new(20.5, 1.0)))],
            vec![at(Stairs, 0.5), at(Stairs, 40.0), lift],
            vec![at(Stairs, 1.0), at(Lift, 40.0)],
        ]));
        let said: Vec<_> = found.iter().map(|c| (c.kind, c.name.as_deref(), c.storeys.clone())).collect();
        assert_eq!(
            said,
            [
                (Stairs, None, vec![0, 1, 2]),
                (Lift, Some("L1"), vec![0, 1]),
                (Stairs, None, vec![1]),
                // A lift is no stairs, though it is above some.
                (Lift, None, vec![2]),
            ]
        );
    }

    #[test]
    fn what_the_source_says_is_joined_is_joined() {
        let lift = |joins: Vec<i32>| Element { joins, ..at(ElementKind::Lift, 0.0) };
        let found = connections(&building(vec![vec![lift(vec![0, 2])], vec![], vec![lift(vec![0, 2]), at(ElementKind::Lift, 40.0)]]));
        assert_eq!(found.iter().map(|c| c.storeys.clone()).collect::<Vec<_>>(), [vec![0, 2], vec![2]]);
    }

    #[test]
    fn a_storey_without_them_ends_the_way_up() {
        let stairs = || vec![at(ElementKind::Stairs, 0.0)];
        let found = connections(&building(vec![stairs(), vec![], stairs()]));
        assert_eq!(found.iter().map(|c| c.storeys.clone()).collect::<Vec<_>>(), [vec![0], vec![2]]);
    }
}
