//! Dependence of FRFs on the level of the exciting force.

use num_complex::Complex64;

use super::Frf;
use numeric::statistics::median;

/// Least difference of two records (1), root mean square of ln H, that is more than the scatter of a repeat.
const LEAST_DIFFERENCE: f64 = 0.02;
/// The same where the lines differ, so that one record is interpolated at sharp peaks.
const LEAST_INTERPOLATED: f64 = 0.1;
/// Ratio of the difference to the noise of both above which noise does not explain it (1).
const BEYOND_NOISE: f64 = 3.0;
/// Least number of lines that are compared.
const LEAST_LINES: usize = 10;

/// Warns of FRFs of one channel at one position that change with the stated level of the force.
pub fn level_warning(frfs: &[Frf]) -> Option<String> {
    let found = frfs.iter().filter_map(|low| {
        let level_n = low.condition.force_level_n?;
        let other = |high: &&Frf| {
            is_channel(low, high) && high.condition.force_level_n.is_some_and(|level| level > level_n)
        };
        let level_of = |frf: &Frf| frf.condition.force_level_n.unwrap_or(0.0);
        let high = frfs.iter().filter(other).max_by(|a, b| level_of(a).total_cmp(&level_of(b)))?;
        Some((low, high, difference(low, high)?))
    });
    let (low, high, difference) = found.max_by(|a, b| a.2.total_cmp(&b.2))?;
    let [from_n, to_n] = [low, high].map(|frf| frf.condition.force_level_n.unwrap_or(0.0));
    Some(format!(
        "{} and {} differ by {:.0} % rms, more than by noise: the machine depends on the level of the force, {from_n} and {to_n} N; \
         fit records of one level, or describe what depends on it (effect contact-level)",
        low.source,
        high.source,
        100.0 * difference
    ))
}

/// Whether two FRFs differ in the level of the force alone.
fn is_channel(a: &Frf, b: &Frf) -> bool {
    let other = |frf: &Frf| (frf.position, frf.condition.velocity_m_s, frf.condition.window_per_s);
    other(a) == other(b) && (&a.response, &a.excitation) == (&b.response, &b.excitation)
}

/// Returns the difference of two FRFs, root mean square of ln H without its mean (a gain), where neither
/// noise nor interpolation explains it.
fn difference(a: &Frf, b: &Frf) -> Option<f64> {
    let (logs, sds) = (b.logarithms(), b.component_sds());
    let mut same = 0;
    let mut differences: Vec<Complex64> = Vec::new();
    let mut noises: Vec<f64> = Vec::new();
    for ((line, log), own) in a.lines.iter().zip(a.logarithms()).zip(a.component_sds()) {
        let after = b.lines.partition_point(|other| other.frequency_hz < line.frequency_hz * (1.0 - 1e-9));
        let Some(next) = b.lines.get(after) else { continue };
        let is_same = next.frequency_hz <= line.frequency_hz * (1.0 + 1e-9);
        if !is_same && after == 0 {
            continue;
        }
        let other = if is_same {
            logs[after]
        } else {
            let before = &b.lines[after - 1];
            let share = (line.frequency_hz - before.frequency_hz) / (next.frequency_hz - before.frequency_hz);
            logs[after - 1] * (1.0 - share) + logs[after] * share
        };
        same += usize::from(is_same);
        let mut by = log - other;
        by.im = by.im.sin().atan2(by.im.cos());
        differences.push(by);
        noises.extend(own.zip(sds[after]).map(|(own, other)| own.hypot(other)));
    }
    let count = differences.len();
    if count < LEAST_LINES {
        return None;
    }
    let mean = differences.iter().sum::<Complex64>() / count as f64;
    let rms = (differences.iter().map(|by| (by - mean).norm_sqr()).sum::<f64>() / (2 * count) as f64).sqrt();
    let least = if 2 * same > count { LEAST_DIFFERENCE } else { LEAST_INTERPOLATED };
    (rms > least.max(BEYOND_NOISE * median(noises)?)).then_some(rms)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Condition, FrfLine, FrfNoise, Quantity};

    /// A mode at a frequency (Hz) as a record at a level, with 1 % of deterministic noise.
    fn record(mode_hz: f64, (level_n, gain): (f64, f64)) -> Frf {
        let line = |at: u32| {
            let frequency_hz = f64::from(at);
            let h =
                gain / Complex64::new(1.0 - (frequency_hz / mode_hz).powi(2), 0.04 * frequency_hz / mode_hz);
            let noise = 1.0 + 0.01 * (f64::from(at * at) * level_n).sin();
            FrfLine { frequency_hz, value: h * noise, noise: Some(FrfNoise::RelativeSd(0.01)) }
        };
        Frf {
            position: None,
            record: None,
            response: "table".into(),
            excitation: "table".into(),
            quantity: Quantity::Receptance,
            condition: Condition { force_level_n: Some(level_n), ..Condition::default() },
            averages: None,
            source: format!("at {level_n} N"),
            lines: (50..150).map(line).collect(),
            rejected: Vec::new(),
        }
    }

    #[test]
    fn levels_are_reported_where_the_machine_depends_on_them() {
        let one = [record(100.0, (1.0, 1.0)), record(100.0, (10.0, 1.0)), record(100.0, (3.0, 1.1))];
        assert_eq!(level_warning(&one), None);
        let several = [record(100.0, (1.0, 1.0)), record(98.0, (3.0, 1.0)), record(95.0, (10.0, 1.0))];
        let text = level_warning(&several).unwrap();
        assert!(
            text.contains("at 1 N and at 10 N differ by") && text.contains("level of the force"),
            "{text}"
        );
        let mut other = several;
        other.iter_mut().for_each(|frf| frf.condition.force_level_n = None);
        assert_eq!(level_warning(&other), None);
    }
}
