//! Symmetric elimination with a fixed sparse pattern: the shape is worked out once, the numbers many times.

use std::collections::BTreeSet;
use std::ops::{AddAssign, Mul, SubAssign};

/// A number that can be eliminated: real without damping, complex with.
pub trait Scalar: Copy + AddAssign + SubAssign + Mul<Output = Self> {
    /// 1/x.
    fn inverse(self) -> Self;
}

impl Scalar for f64 {
    fn inverse(self) -> Self {
        1.0 / self
    }
}

/// One pivot: its own slot, its later neighbours, and which products are taken from which slots.
#[derive(Debug, Clone)]
struct Pivot {
    /// The coordinate eliminated.
    row: usize,
    /// Slot of its diagonal entry.
    diagonal: usize,
    /// First and one past the last of its neighbours in `neighbours`.
    neighbours: (usize, usize),
    /// First of its targets in `targets`.
    targets: usize,
}

/// The pattern of A = L·D·Lᵀ for a sparse symmetric matrix.
#[derive(Debug, Clone)]
pub struct Elimination {
    size: usize,
    slots: usize,
    pivots: Vec<Pivot>,
    /// (coordinate, slot of its entry with the pivot).
    neighbours: Vec<(usize, usize)>,
    /// Slots that receive the products of pairs of neighbours (a, b ≤ a), pivot by pivot.
    targets: Vec<usize>,
    /// Slot of the entry (i, j); `usize::MAX` where the entry is zero.
    slot_of: Vec<usize>,
}

impl Elimination {
    /// Works out the pattern for `size` coordinates that meet in `pairs`; `last` are eliminated at the end, in that order.
    pub fn new(size: usize, pairs: impl IntoIterator<Item = (usize, usize)>, last: &[usize]) -> Self {
        let mut adjacent = vec![BTreeSet::new(); size];
        for (i, j) in pairs.into_iter().filter(|(i, j)| i != j) {
            adjacent[i].insert(j);
            adjacent[j].insert(i);
        }
        let mut pattern = Elimination {
            size,
            slots: 0,
            pivots: Vec::with_capacity(size),
            neighbours: Vec::new(),
            targets: Vec::new(),
            slot_of: vec![usize::MAX; size * size],
        };
        for i in 0..size {
            pattern.slot(i, i);
        }
        let mut remaining: BTreeSet<usize> = (0..size).filter(|i| !last.contains(i)).collect();
        let mut tail = last.iter().copied();
        while let Some(row) = remaining.iter().copied().min_by_key(|i| adjacent[*i].len()).or_else(|| tail.next()) {
            remaining.remove(&row);
            let near: Vec<usize> = std::mem::take(&mut adjacent[row]).into_iter().collect();
            let first = pattern.neighbours.len();
            for &a in &near {
                let slot = pattern.slot(row, a);
                pattern.neighbours.push((a, slot));
            }
            let targets = pattern.targets.len();
            for (at, &a) in near.iter().enumerate() {
                for &b in &near[..=at] {
                    let slot = pattern.slot(a, b);
                    pattern.targets.push(slot);
                    if a != b {
                        adjacent[a].insert(b);
                        adjacent[b].insert(a);
                    }
                }
                adjacent[a].remove(&row);
            }
            let diagonal = pattern.slot(row, row);
            pattern.pivots.push(Pivot { row, diagonal, neighbours: (first, pattern.neighbours.len()), targets });
        }
        pattern
    }

    /// Number of coordinates.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of stored entries.
    pub fn slots(&self) -> usize {
        self.slots
    }

    /// Slot of the entry (i, j), made if it is not there.
    fn slot(&mut self, i: usize, j: usize) -> usize {
        let at = i * self.size + j;
        if self.slot_of[at] == usize::MAX {
            self.slot_of[at] = self.slots;
            self.slot_of[j * self.size + i] = self.slots;
            self.slots += 1;
        }
        self.slot_of[at]
    }

    /// Slot of the entry (i, j), which must be one of the pairs of [`Elimination::new`].
    pub fn entry(&self, i: usize, j: usize) -> usize {
        let slot = self.slot_of[i * self.size + j];
        debug_assert!(slot != usize::MAX, "({i}, {j}) is not in the pattern");
        slot
    }

    /// Factors in place. Diagonal slots then hold 1/d; `on_pivot` sees each d before.
    #[inline]
    pub fn factor<T: Scalar>(&self, entries: &mut [T], mut on_pivot: impl FnMut(T)) {
        for pivot in &self.pivots {
            let d = entries[pivot.diagonal];
            on_pivot(d);
            let inverse = d.inverse();
            entries[pivot.diagonal] = inverse;
            let near = &self.neighbours[pivot.neighbours.0..pivot.neighbours.1];
            let mut target = pivot.targets;
            for (at, &(_, slot_a)) in near.iter().enumerate() {
                let l = entries[slot_a] * inverse;
                for &(_, slot_b) in &near[..=at] {
                    let product = l * entries[slot_b];
                    entries[self.targets[target]] -= product;
                    target += 1;
                }
            }
        }
    }

    /// Solves A·x = b for factored entries; `x` holds b on entry.
    #[inline]
    pub fn solve<T: Scalar>(&self, entries: &[T], x: &mut [T]) {
        for pivot in &self.pivots {
            let scaled = x[pivot.row] * entries[pivot.diagonal];
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                let product = entries[slot] * scaled;
                x[a] -= product;
            }
        }
        self.solve_back(entries, x);
    }

    /// Solves A·x = b where b is zero but at the coordinate eliminated last; `x` holds b on entry.
    #[inline]
    pub fn solve_last<T: Scalar>(&self, entries: &[T], x: &mut [T]) {
        self.solve_back(entries, x);
    }

    #[inline]
    fn solve_back<T: Scalar>(&self, entries: &[T], x: &mut [T]) {
        for pivot in self.pivots.iter().rev() {
            let mut sum = x[pivot.row];
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                let product = entries[slot] * x[a];
                sum -= product;
            }
            x[pivot.row] = sum * entries[pivot.diagonal];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A dense matrix through the sparse path: every entry of the inverse times the matrix is the identity.
    #[test]
    fn limit_inverse_times_matrix_is_the_identity() {
        let pairs = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (1, 4)];
        let pattern = Elimination::new(5, pairs, &[2]);
        let value = |i: usize, j: usize| if i == j { 5.0 + i as f64 } else { -1.0 - 0.3 * ((i + j) as f64) };
        let mut entries = vec![0.0; pattern.slots()];
        for i in 0..5 {
            entries[pattern.entry(i, i)] = value(i, i);
        }
        for (i, j) in pairs {
            entries[pattern.entry(i, j)] = value(i, j);
        }
        let mut count = 0;
        pattern.factor(&mut entries, |_| count += 1);
        assert_eq!(count, 5);
        for column in 0..5 {
            let mut x = vec![0.0; 5];
            x[column] = 1.0;
            pattern.solve(&entries, &mut x);
            for i in 0..5 {
                let mut sum = value(i, i) * x[i];
                for (a, b) in pairs {
                    if a == i {
                        sum += value(a, b) * x[b];
                    }
                    if b == i {
                        sum += value(a, b) * x[a];
                    }
                }
                let identity = if i == column { 1.0 } else { 0.0 };
                assert!((sum - identity).abs() < 1e-12);
            }
        }
    }
}
