//! The band that contains most of an effect.

/// Finds the shortest band on the logarithmic frequency axis that contains a share of all squares.
pub fn shortest_band(lines_hz: &[f64], squares: &[f64], share: f64) -> Option<[f64; 2]> {
    let total: f64 = squares.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return None;
    }
    let mut best: Option<[f64; 2]> = None;
    let mut inside = 0.0;
    let mut first = 0;
    for last in 0..squares.len() {
        inside += squares[last];
        while inside - squares[first] >= share * total && first < last {
            inside -= squares[first];
            first += 1;
        }
        let found = [lines_hz[first], lines_hz[last]];
        if inside >= share * total && best.is_none_or(|[from, to]| found[1] / found[0] < to / from) {
            best = Some(found);
        }
    }
    best
}
