//! A sketch of the machine, with the location of the verdict marked.

use std::collections::BTreeSet;

use super::text::escape;

/// A machine to sketch: its points, and what connects them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Sketch {
    /// Name of each point, and whether it rotates.
    pub points: Vec<(String, bool)>,
    /// Name of each joint, and the points (index) that it connects; a single one is connected to the ground.
    pub joints: Vec<(String, Vec<usize>)>,
    /// Name of each shaft, and its stations from left to right: the points (index) that move and that rotate
    /// with it.
    pub shafts: Vec<(String, Vec<[Option<usize>; 2]>)>,
}

/// Column and row of a point.
type Cell = (i32, i32);

/// Height of a row, of a point, of a stub to the ground and of a line of text, and width of a character (px).
const ROW: i32 = 78;
const BOX: i32 = 26;
const STUB: i32 = 20;
const LINE: i32 = 13;
const CHARACTER: i32 = 8;

impl Sketch {
    /// Places the points: stations of a shaft in columns, those that move above those that rotate; each other
    /// point near one that a joint connects it with.
    fn cells(&self) -> Vec<Cell> {
        let mut cells: Vec<Option<Cell>> = vec![None; self.points.len()];
        let mut taken: BTreeSet<Cell> = BTreeSet::new();
        let mut put = |cells: &mut Vec<Option<Cell>>, point: usize, cell: Cell| {
            if cells[point].is_none() && taken.insert(cell) {
                cells[point] = Some(cell);
            }
        };
        for (at, (_, stations)) in self.shafts.iter().enumerate() {
            for (column, station) in stations.iter().enumerate() {
                for (below, point) in station.iter().enumerate() {
                    let cell = (2 * column as i32, (4 * at + below) as i32);
                    point.iter().for_each(|point| put(&mut cells, *point, cell));
                }
            }
        }
        // One step places at least one point.
        for _ in &self.points {
            let Some(next) = cells.iter().position(Option::is_none) else { break };
            let neighbour = self.joints.iter().find_map(|(_, on)| {
                let placed = on.iter().find_map(|point| cells[*point])?;
                Some((on.iter().copied().find(|point| cells[*point].is_none())?, placed))
            });
            let lowest = cells.iter().flatten().map(|cell| cell.1).max().map_or(0, |row| row + 2);
            let (point, (column, row)) = neighbour.unwrap_or((next, (0, lowest)));
            let steps: &[Cell] = if self.points[point].1 {
                &[(0, 0), (-2, 0), (2, 0), (0, 1), (-2, 1), (2, 1)]
            } else {
                &[(0, 0), (0, -1), (2, 0), (-2, 0), (0, -2), (2, -1), (-2, -1)]
            };
            let near = steps.iter().map(|(x, y)| (column + x, row + y));
            near.chain((1..).map(|far| (column + 2 * far, row)))
                .take(20)
                .for_each(|c| put(&mut cells, point, c));
        }
        cells.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// Draws the machine as SVG, with the point, joint or shaft of a name marked; empty where it has none.
    pub(super) fn drawn(&self, place: &str) -> String {
        let names = || self.points.iter().map(|(name, _)| name);
        let parts = self.joints.iter().map(|(name, _)| name).chain(self.shafts.iter().map(|(name, _)| name));
        if !names().chain(parts).any(|name| name == place) {
            return String::new();
        }
        let longest = names().map(|name| name.chars().count() as i32).max().unwrap_or_default();
        let width = CHARACTER * longest + 16;
        let cells = self.cells();
        let (left, top) = cells.iter().fold((0, 0), |(x, y), cell| (x.min(cell.0), y.min(cell.1)));
        // Half a column leaves room for the name of a joint.
        let half = (width + 90) / 2;
        let at = |point: usize| {
            ((cells[point].0 - left) * half + 60 + width / 2, (cells[point].1 - top) * ROW + 40)
        };
        let class = |name: &str| if name == place { " class=\"here\"" } else { "" };
        let mut out = String::new();
        for (name, stations) in &self.shafts {
            for kind in 0..2 {
                let along: Vec<usize> = stations.iter().filter_map(|station| station[kind]).collect();
                if let [first, .., last] = along[..] {
                    let ((x1, y), (x2, _)) = (at(first), at(last));
                    out += &format!("<path{} d=\"M{x1} {}H{x2}M{x1} {}H{x2}\"/>", class(name), y - 4, y + 4);
                }
            }
        }
        let mut grounded = vec![0; cells.len()];
        for (name, on) in &self.joints {
            let Some((&first, others)) = on.split_first() else { continue };
            let ((x, y), (column, row)) = (at(first), cells[first]);
            for &other in others {
                let (x2, y2) = at(other);
                out += &format!("<path{} d=\"M{x} {y}L{x2} {y2}\"/>", class(name));
            }
            let (x, y, anchor) = if let Some(other) = others.first() {
                let (x2, y2) = at(*other);
                ((x + x2) / 2, (y + y2) / 2 - 5, "middle")
            } else {
                // The ground is above a point that stands on another.
                let stands = cells.contains(&(column, row + 1)) && !cells.contains(&(column, row - 1));
                let away = if stands { -1 } else { 1 };
                let ground = y + away * (BOX / 2 + STUB);
                out +=
                    &format!("<path{} d=\"M{x} {y}V{ground}M{} {ground}H{}\"/>", class(name), x - 14, x + 14);
                grounded[first] += 1;
                (x + 8, y + away * BOX / 2 + away * LINE * grounded[first] + 4, "start")
            };
            out += &format!(
                "<text{} x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{}</text>",
                class(name),
                escape(name)
            );
        }
        for (point, (name, rotates)) in self.points.iter().enumerate() {
            let ((x, y), round) = (at(point), if *rotates { BOX / 2 } else { 0 });
            out += &format!(
                "<rect{0} x=\"{1}\" y=\"{2}\" width=\"{width}\" height=\"{BOX}\" rx=\"{round}\"/><text{0} x=\"{x}\" y=\"{3}\" text-anchor=\"middle\">{4}</text>",
                class(name),
                x - width / 2,
                y - BOX / 2,
                y + 4,
                escape(name)
            );
        }
        let (right, bottom) = (0..cells.len()).map(at).fold((0, 0), |(x, y), at| (x.max(at.0), y.max(at.1)));
        let (right, bottom, place) = (right + width / 2 + 90, bottom + 60, escape(place));
        format!(
            "<svg class=\"sketch\" viewBox=\"0 0 {right} {bottom}\" width=\"{right}\" role=\"img\" aria-label=\"Sketch of the machine, «{place}» marked\">{out}</svg>\n"
        )
    }
}
