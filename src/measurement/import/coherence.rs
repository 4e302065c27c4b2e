//! Pairs the coherences of a universal file with its FRFs.

use std::collections::BTreeMap;

use super::place::point;
use universal_files::{NodeLocation, Ordinate, RecordHeader, UniversalRecord};

/// Largest relative difference of two abscissa values that count as equal (1).
const ABSCISSA_TOLERANCE: f64 = 1e-6;

/// Returns the coherence of each FRF, where the file has one, with notes on pairs that are not exact and on
/// coherences left out.
///
/// Response, reference (node, direction and name), version and load case must agree. Where a file leaves some
/// of them blank, or names entities differently, a pair counts if neither has another candidate; it is said.
pub(super) fn paired(
    source: &str,
    frfs: &[UniversalRecord],
    coherences: &[UniversalRecord],
    notes: &mut Vec<String>,
) -> Vec<Option<usize>> {
    let mut pairs = vec![None; frfs.len()];
    let mut used = vec![false; coherences.len()];
    exact_pairs(frfs, coherences, &mut pairs, &mut used);
    for (may_belong, what) in [
        (
            stated_fields_agree as fn(&RecordHeader, &RecordHeader) -> bool,
            "fields that one of them leaves blank",
        ),
        (places_agree, "the names of their entities"),
    ] {
        let open: Vec<usize> = (0..frfs.len()).filter(|at| pairs[*at].is_none()).collect();
        let free: Vec<usize> = (0..coherences.len()).filter(|at| !used[*at]).collect();
        let fits = |f: usize, c: usize| {
            may_belong(&frfs[f].header, &coherences[c].header) && same_abscissa(&frfs[f], &coherences[c])
        };
        for &f in &open {
            let mut candidates = free.iter().copied().filter(|c| fits(f, *c));
            if let (Some(c), None) = (candidates.next(), candidates.next())
                && open.iter().filter(|other| fits(**other, c)).count() == 1
            {
                pairs[f] = Some(c);
                used[c] = true;
                notes.push(format!(
                    "{source}: FRF {} and {} are paired in spite of {what}",
                    place(&frfs[f]),
                    coherence_of(&coherences[c])
                ));
            }
        }
    }
    for (c, record) in coherences.iter().enumerate().filter(|(c, _)| !used[*c]) {
        let alike = frfs.iter().filter(|f| places_agree(&f.header, &record.header)).count();
        let why = if alike > 1 {
            format!("{alike} FRFs could be its partner")
        } else {
            "no FRF is its partner".into()
        };
        notes.push(format!(
            "{source}: {} (number {} of the coherences) is left out: {why}",
            coherence_of(record),
            c + 1
        ));
    }
    pairs
}

/// Returns the values of a coherence; `None` where they are complex.
pub(super) fn values(record: &UniversalRecord) -> Option<Vec<f64>> {
    match &record.ordinate {
        Ordinate::Real(values) => Some(values.clone()),
        Ordinate::Complex(values) => {
            values.iter().all(|v| v.im == 0.0 || v.im.is_nan()).then(|| values.iter().map(|v| v.re).collect())
        }
    }
}

fn place(record: &UniversalRecord) -> String {
    format!("{} / {}", point(&record.header.response), point(&record.header.reference))
}

/// Names a coherence.
pub(super) fn coherence_of(record: &UniversalRecord) -> String {
    let version = record.header.version;
    let version = if version == 0 { String::new() } else { format!(", version {version}") };
    format!("the coherence {}{version}", place(record))
}

/// Pairs records whose fields all agree; repeats of one place are paired in their order.
fn exact_pairs(
    frfs: &[UniversalRecord],
    coherences: &[UniversalRecord],
    pairs: &mut [Option<usize>],
    used: &mut [bool],
) {
    type Key<'r> = (&'r str, i64, i64, &'r str, i64, i64, i64, i64);
    fn key(record: &UniversalRecord) -> Key<'_> {
        let h = &record.header;
        let (a, b) = (&h.response, &h.reference);
        (a.entity.trim(), a.node, a.direction, b.entity.trim(), b.node, b.direction, h.version, h.load_case)
    }
    let mut groups: BTreeMap<Key<'_>, (Vec<usize>, Vec<usize>)> = BTreeMap::new();
    frfs.iter().enumerate().for_each(|(at, record)| groups.entry(key(record)).or_default().0.push(at));
    coherences.iter().enumerate().for_each(|(at, record)| groups.entry(key(record)).or_default().1.push(at));
    for (of_key, partners) in groups.into_values().filter(|(f, c)| f.len() == c.len()) {
        for (f, c) in of_key.into_iter().zip(partners) {
            if same_abscissa(&frfs[f], &coherences[c]) {
                pairs[f] = Some(c);
                used[c] = true;
            }
        }
    }
}

fn is_blank(text: &str) -> bool {
    text.trim().is_empty() || text.trim().eq_ignore_ascii_case("none")
}

/// Whether no field differs that both records state.
fn stated_fields_agree(a: &RecordHeader, b: &RecordHeader) -> bool {
    let names = |a: &NodeLocation, b: &NodeLocation| {
        is_blank(&a.entity) || is_blank(&b.entity) || a.entity.trim() == b.entity.trim()
    };
    names(&a.response, &b.response) && names(&a.reference, &b.reference) && places_agree(a, b)
}

/// Whether nodes, directions, version and load case agree as far as both state them.
fn places_agree(a: &RecordHeader, b: &RecordHeader) -> bool {
    let numbers = |a: i64, b: i64| a == b || a == 0 || b == 0;
    numbers(a.response.node, b.response.node)
        && numbers(a.response.direction, b.response.direction)
        && numbers(a.reference.node, b.reference.node)
        && numbers(a.reference.direction, b.reference.direction)
        && numbers(a.version, b.version)
        && numbers(a.load_case, b.load_case)
}

fn same_abscissa(a: &UniversalRecord, b: &UniversalRecord) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= ABSCISSA_TOLERANCE * b.abs().max(ABSCISSA_TOLERANCE);
    let (count, other) = (a.abscissa.len(), b.abscissa.len());
    count == other
        && (0..count).all(|at| a.abscissa.at(at).zip(b.abscissa.at(at)).is_some_and(|(a, b)| near(a, b)))
}
