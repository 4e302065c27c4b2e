//! On which side a play lies, or where between.

/// Share of the root mean square of the force through a play that must stand against a side before it is left: while less is transmitted the
/// parts stay where they are.
const LEAVES: f64 = 0.1;

/// Where a play lies along a motion: pressed against one side or the other, ± `half`, or between them, where what lies beyond flies freely, `yields` (1/s²) times
/// as fast as the joint would give way under the force that is missing. Blows are plastic.
pub(super) fn flight(given: &[f64], half: f64, yields: f64, step_s: f64) -> Vec<f64> {
    let first = sides(given).first().copied().unwrap_or(0.0);
    let (mut place, mut speed) = (half * first, 0.0);
    given
        .iter()
        .map(|given| {
            let here = place;
            let gained = step_s * yields * given;
            place += step_s * (speed + 0.5 * gained);
            speed += gained;
            if place.abs() >= half {
                (place, speed) = (half * place.signum(), 0.0);
            }
            here
        })
        .collect()
}

/// The side (1 or −1) on which a play lies under a force.
pub(super) fn sides(force: &[f64]) -> Vec<f64> {
    let level = LEAVES * (force.iter().map(|f| f * f).sum::<f64>() / force.len().max(1) as f64).sqrt();
    let mut side = force.iter().find(|f| f.abs() > level).map_or(0.0, |f| f.signum());
    force
        .iter()
        .map(|f| {
            if f.abs() > level {
                side = f.signum();
            }
            side
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under a steady force the other side is reached after √(2·gap/(k·yields·given)); a force that turns before that brings it back.
    #[test]
    fn limit_a_flight_under_a_steady_force_is_a_parabola() {
        let (half, yields, given, step_s) = (8e-6, 1e6, 2e-6, 1e-4);
        let force: Vec<f64> = (0..200).map(|i| if i < 20 { -given } else { given }).collect();
        let lies = flight(&force, half, yields, step_s);
        let after_s = (4.0 * half / (yields * given)).sqrt();
        for (i, place) in lies.iter().enumerate() {
            let t = step_s * (i as f64 - 20.0);
            let expected = if t < 0.0 { -half } else { (0.5 * yields * given * t * t - half).min(half) };
            assert!((place - expected).abs() < 1e-9 * half, "{i}: {place} for {expected}");
        }
        assert_eq!(lies[21 + (after_s / step_s).ceil() as usize], half);
        let brief: Vec<f64> = (0..200).map(|i| if (20..40).contains(&i) { given } else { -given }).collect();
        assert!(flight(&brief, half, yields, step_s).iter().all(|place| *place < half));
    }
}
