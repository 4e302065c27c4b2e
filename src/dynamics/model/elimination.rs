//! Symmetric elimination with a fixed sparse pattern, which is computed once and used for many
//! factorisations.

use std::cell::Cell;
use std::collections::BTreeSet;

use super::scalar::Scalar;
use super::simd::ABREAST;

/// One pivot: its slot, its neighbours that are eliminated later, and the slots updated by their products.
#[derive(Debug, Clone)]
struct Pivot {
    /// The coordinate eliminated.
    row: usize,
    /// Slot of the diagonal entry.
    diagonal: usize,
    /// Range of the neighbours in `neighbours`: first, and one past the last.
    neighbours: (usize, usize),
    /// First of the pivot's targets in `targets`.
    targets: usize,
}

/// The sparsity pattern of A = L·D·Lᵀ for a sparse symmetric matrix.
#[derive(Debug, Clone)]
pub struct Elimination {
    size: usize,
    slots: usize,
    pivots: Vec<Pivot>,
    /// (coordinate, slot of its entry with the pivot).
    neighbours: Vec<(usize, usize)>,
    /// Slots that are updated by the products of pairs of neighbours (a, b ≤ a), pivot by pivot.
    targets: Vec<usize>,
    /// Slot of the entry (i, j); `usize::MAX` where the entry is zero.
    slot_of: Vec<usize>,
}

impl Elimination {
    /// Computes the pattern for `size` coordinates coupled in `pairs`; `last` are eliminated at the end, in
    /// that order.
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
        while let Some(row) =
            remaining.iter().copied().min_by_key(|i| adjacent[*i].len()).or_else(|| tail.next())
        {
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
            pattern.pivots.push(Pivot {
                row,
                diagonal,
                neighbours: (first, pattern.neighbours.len()),
                targets,
            });
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

    /// Returns the slot of the entry (i, j) and creates it if necessary.
    fn slot(&mut self, i: usize, j: usize) -> usize {
        let at = i * self.size + j;
        if self.slot_of[at] == usize::MAX {
            self.slot_of[at] = self.slots;
            self.slot_of[j * self.size + i] = self.slots;
            self.slots += 1;
        }
        self.slot_of[at]
    }

    /// Returns the slot of the entry (i, j), which must be in the pattern.
    pub fn entry(&self, i: usize, j: usize) -> usize {
        let slot = self.slot_of[i * self.size + j];
        debug_assert!(slot != usize::MAX, "({i}, {j}) is not in the pattern");
        slot
    }

    /// Clears `real` for the entries that become complex during factorisation; on entry `real` marks, by
    /// slot, the real entries of the matrix.
    pub fn propagate_complex(&self, real: &mut [bool]) {
        for pivot in &self.pivots {
            let near = &self.neighbours[pivot.neighbours.0..pivot.neighbours.1];
            let mut targets = self.targets[pivot.targets..].iter();
            for (at, &(_, a)) in near.iter().enumerate() {
                for (&(_, b), &target) in near[..=at].iter().zip(&mut targets) {
                    real[target] &= real[pivot.diagonal] && real[a] && real[b];
                }
            }
        }
    }

    /// Factors `abreast` matrices in place, at most [`ABREAST`]. Entry s of matrix w is stored at s·abreast +
    /// w. Slots marked `real` stay real throughout ([`Elimination::propagate_complex`]). Diagonal slots hold
    /// 1/d afterwards; `on_pivot` receives w, d and 1/d of each pivot.
    #[inline]
    pub fn factor<T: Scalar>(
        &self,
        abreast: usize,
        entries: &mut [T],
        real: &[bool],
        mut on_pivot: impl FnMut(usize, T, T),
    ) {
        let cells = Cell::from_mut(entries).as_slice_of_cells();
        let of = |slot: usize| &cells[slot * abreast..][..abreast];
        let mut scaled = [T::ZERO; ABREAST];
        for pivot in &self.pivots {
            let (inverse, pivot_real) = (of(pivot.diagonal), real[pivot.diagonal]);
            let near = &self.neighbours[pivot.neighbours.0..pivot.neighbours.1];
            let mut targets = self.targets[pivot.targets..].iter();
            // Most pivots have one neighbour, which one pass updates.
            if let &[(_, slot)] = near {
                let (entry, target) = (of(slot), of(self.targets[pivot.targets]));
                let mut update = |invert: fn(T) -> T, sub_mul: fn(T, T, T) -> T| {
                    for (w, ((d, entry), target)) in inverse.iter().zip(entry).zip(target).enumerate() {
                        let (value, inverse) = (d.get(), invert(d.get()));
                        on_pivot(w, value, inverse);
                        d.set(inverse);
                        target.set(sub_mul(target.get(), inverse, entry.get()));
                    }
                };
                match (pivot_real, real[slot]) {
                    (true, true) => {
                        update(T::inverse_real, |t, inverse, e| t.sub_mul_reals(inverse.mul_real(e), e))
                    }
                    (true, false) => {
                        update(T::inverse_real, |t, inverse, e| t.sub_mul(e.mul_real(inverse), e))
                    }
                    (false, true) => {
                        update(T::inverse, |t, inverse, e| t.sub_mul_real(inverse.mul_real(e), e))
                    }
                    (false, false) => update(T::inverse, |t, inverse, e| t.sub_mul(inverse * e, e)),
                }
                continue;
            }
            for (w, d) in inverse.iter().enumerate() {
                let value = d.get();
                let inverse = if pivot_real { value.inverse_real() } else { value.inverse() };
                on_pivot(w, value, inverse);
                d.set(inverse);
            }
            for (at, &(_, slot)) in near.iter().enumerate() {
                let scale = |scaled: &mut [T], product: fn(T, T) -> T| {
                    scaled
                        .iter_mut()
                        .zip(of(slot))
                        .zip(inverse)
                        .for_each(|((l, entry), inverse)| *l = product(entry.get(), inverse.get()));
                };
                match (real[slot], pivot_real) {
                    (true, _) => scale(&mut scaled, |entry, inverse| inverse.mul_real(entry)),
                    (_, true) => scale(&mut scaled, T::mul_real),
                    _ => scale(&mut scaled, T::mul),
                }
                let l_real = pivot_real && real[slot];
                for (&(_, slot), &target) in near[..=at].iter().zip(&mut targets) {
                    let update = |sub_mul: fn(T, T, T) -> T| {
                        let each = of(target).iter().zip(&scaled).zip(of(slot));
                        each.for_each(|((target, l), entry)| {
                            target.set(sub_mul(target.get(), *l, entry.get()))
                        });
                    };
                    match (l_real, real[slot]) {
                        (true, true) => update(T::sub_mul_reals),
                        (true, false) => update(|target, l, entry| target.sub_mul_real(entry, l)),
                        (false, true) => update(T::sub_mul_real),
                        (false, false) => update(T::sub_mul),
                    }
                }
            }
        }
    }

    /// Solves A·x = b for `abreast` factored matrices. `x` holds b on entry; coordinate i of matrix w is
    /// stored at i·abreast + w.
    #[inline]
    pub fn solve<T: Scalar>(&self, abreast: usize, entries: &[T], x: &mut [T]) {
        let x = Cell::from_mut(x).as_slice_of_cells();
        let of = |row: usize| &x[row * abreast..][..abreast];
        for pivot in &self.pivots {
            let inverse = &entries[pivot.diagonal * abreast..][..abreast];
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                let entries = &entries[slot * abreast..][..abreast];
                for (((a, x), entry), inverse) in of(a).iter().zip(of(pivot.row)).zip(entries).zip(inverse) {
                    a.set(a.get().sub_mul(x.get() * *inverse, *entry));
                }
            }
        }
        self.back_substitute(abreast, entries, x);
    }

    /// Solves A·x = b for a b that is zero except at the coordinate eliminated last; storage as in
    /// [`Elimination::solve`].
    #[inline]
    pub fn solve_last<T: Scalar>(&self, abreast: usize, entries: &[T], x: &mut [T]) {
        self.back_substitute(abreast, entries, Cell::from_mut(x).as_slice_of_cells());
    }

    #[inline]
    fn back_substitute<T: Scalar>(&self, abreast: usize, entries: &[T], x: &[Cell<T>]) {
        let of = |row: usize| &x[row * abreast..][..abreast];
        for pivot in self.pivots.iter().rev() {
            let here = of(pivot.row);
            for &(a, slot) in &self.neighbours[pivot.neighbours.0..pivot.neighbours.1] {
                for ((x, a), entry) in here.iter().zip(of(a)).zip(&entries[slot * abreast..][..abreast]) {
                    x.set(x.get().sub_mul(a.get(), *entry));
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
    use num_complex::Complex64;

    use super::super::simd::{Complexes, Reals};
    use super::*;

    /// A dense matrix in the sparse pattern: the inverse times the matrix is the identity.
    #[test]
    fn limit_inverse_times_matrix_is_the_identity() {
        let pairs = [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (1, 4)];
        let pattern = Elimination::new(5, pairs, &[2]);
        let value = |i: usize, j: usize| if i == j { 5.0 + i as f64 } else { -1.0 - 0.3 * ((i + j) as f64) };
        let mut entries = vec![Reals::ZERO; pattern.slots()];
        for i in 0..5 {
            entries[pattern.entry(i, i)] = Reals::splat(value(i, i));
        }
        for (i, j) in pairs {
            entries[pattern.entry(i, j)] = Reals::splat(value(i, j));
        }
        let mut count = 0;
        pattern.factor(1, &mut entries, &vec![true; pattern.slots()], |_, _, _| count += 1);
        assert_eq!(count, 5);
        for column in 0..5 {
            let mut x = vec![Reals::ZERO; 5];
            x[column] = Reals::ONE;
            pattern.solve(1, &entries, &mut x);
            let x: Vec<f64> = x.into_iter().map(|x| x.to_array()[0]).collect();
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

    /// All combinations of real and complex entries, in a chain and in a ring with a chord, give the result
    /// of complex arithmetic.
    #[test]
    fn limit_real_shortcuts_equal_complex_arithmetic() {
        let (chain, ring) =
            ([(0, 1), (1, 2), (2, 3), (3, 4)], [(0, 1), (1, 2), (2, 3), (3, 4), (4, 0), (1, 4)]);
        for pairs in [&chain[..], &ring] {
            let pattern = Elimination::new(5, pairs.iter().copied(), &[2]);
            let stored: Vec<usize> = (0..5)
                .map(|i| (i, i))
                .chain(pairs.iter().copied())
                .map(|(i, j)| pattern.entry(i, j))
                .collect();
            for of_real in 0..1_usize << stored.len() {
                let mut real = vec![true; pattern.slots()];
                let mut entries = vec![Complexes::ZERO; 3 * pattern.slots()];
                for (at, &slot) in stored.iter().enumerate() {
                    real[slot] = of_real >> at & 1 == 1;
                    for w in 0..3 {
                        let im = if real[slot] { 0.0 } else { 0.4 + 0.1 * at as f64 };
                        let re = if at < 5 { 5.0 } else { -1.0 } + 0.3 * (at + w) as f64;
                        entries[3 * slot + w] = Complexes::splat(Complex64::new(re, im));
                    }
                }
                let mut as_complex = entries.clone();
                pattern.propagate_complex(&mut real);
                pattern.factor(3, &mut entries, &real, |_, _, _| ());
                pattern.factor(3, &mut as_complex, &vec![false; pattern.slots()], |_, _, _| ());
                for (slot, (a, b)) in entries.iter().zip(&as_complex).enumerate() {
                    let (a, b) = (a.lanes()[0], b.lanes()[0]);
                    assert!(
                        (a - b).norm() <= 1e-14 * b.norm() && (a.im == 0.0 || !real[slot / 3]),
                        "{of_real:b}, slot {slot}: {a} {b}"
                    );
                }
            }
        }
    }
}
