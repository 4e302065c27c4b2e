//! Symmetric elimination with a fixed sparse pattern: the shape is worked out once, the numbers many times.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::ops::Mul;

use super::lanes::ABREAST;

/// A number that can be eliminated: real without damping, complex with.
pub trait Scalar: Copy + Mul<Output = Self> {
    /// Nought.
    const ZERO: Self;

    /// 1/x.
    fn inverse(self) -> Self;

    /// x − a·b.
    fn less(self, a: Self, b: Self) -> Self;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;

    fn inverse(self) -> Self {
        1.0 / self
    }

    fn less(self, a: Self, b: Self) -> Self {
        self - a * b
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

    /// Factors `abreast` matrices in place, at most [`ABREAST`]; entry s of matrix w stands at s·abreast + w. Diagonal slots then hold 1/d; `on_pivot` sees
    /// w, d and 1/d of each.
    #[inline]
    pub fn factor<T: Scalar>(&self, abreast: usize, entries: &mut [T], mut on_pivot: impl FnMut(usize, T, T)) {
        let cells = Cell::from_mut(entries).as_slice_of_cells();
        let of = |slot: usize| &cells[slot * abreast..][..abreast];
        let mut scaled = [T::ZERO; ABREAST];
        for pivot in &self.pivots {
            let inverse = of(pivot.diagonal);
            for (w, d) in inverse.iter().enumerate() {
                let (value, inverse) = (d.get(), d.get().inverse());
                on_pivot(w, value, inverse);
                d.set(inverse);
            }
            let near = &self.neighbours[pivot.neighbours.0..pivot.neighbours.1];
            let mut targets = self.targets[pivot.targets..].iter();
            for (at, &(_, slot)) in near.iter().enumerate() {
                for ((l, entry), inverse) in scaled.iter_mut().zip(of(slot)).zip(inverse) {
                    *l = entry.get() * inverse.get();
                }
                for (&(_, slot), &target) in near[..=at].iter().zip(&mut targets) {
                    for ((target, l), entry) in of(target).iter().zip(&scaled).zip(of(slot)) {
                        target.set(target.get().less(*l, entry.get()));
                    }
                }
            }
        }
    }

    /// Solves A·x = b for `abreast` factored matrices; `x` holds b on entry, coordinate i of matrix w at i·abreast + w.
    #[inline]
    pub fn solve<T: Scalar>(&self, abreast: usize, entries: &[T], x: &mut [T]) {
        let x = Cell::from_mut(x).as_slice_of_cells();
        let of = |row: usize| &x[row * abreast..][..abreast];
        for pivot in &self.pivots {
            let inverse = &entries[pivot.diagonal * abreast..][..abreast];
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                let entries = &entries[slot * abreast..][..abreast];
                for (((a, x), entry), inverse) in of(a).iter().zip(of(pivot.row)).zip(entries).zip(inverse) {
                    a.set(a.get().less(x.get() * *inverse, *entry));
                }
            }
        }
        self.back(abreast, entries, x);
    }

    /// Solves A·x = b where b is zero but at the coordinate eliminated last; as [`Elimination::solve`].
    #[inline]
    pub fn solve_last<T: Scalar>(&self, abreast: usize, entries: &[T], x: &mut [T]) {
        self.back(abreast, entries, Cell::from_mut(x).as_slice_of_cells());
    }

    #[inline]
    fn back<T: Scalar>(&self, abreast: usize, entries: &[T], x: &[Cell<T>]) {
        let of = |row: usize| &x[row * abreast..][..abreast];
        for pivot in self.pivots.iter().rev() {
            let here = of(pivot.row);
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                for ((x, a), entry) in here.iter().zip(of(a)).zip(&entries[slot * abreast..][..abreast]) {
                    x.set(x.get().less(a.get(), *entry));
                }
            }
            for (x, inverse) in here.iter().zip(&entries[pivot.diagonal * abreast..]) {
                x.set(x.get() * *inverse);
            }
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
        pattern.factor(1, &mut entries, |_, _, _| count += 1);
        assert_eq!(count, 5);
        for column in 0..5 {
            let mut x = vec![0.0; 5];
            x[column] = 1.0;
            pattern.solve(1, &entries, &mut x);
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
