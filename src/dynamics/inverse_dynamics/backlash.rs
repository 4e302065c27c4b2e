//! State of a backlash along a motion: the side in contact, or the position in between.

/// Share of the root mean square of the transmitted force that must act against the side in contact before it
/// separates. Below it the parts stay in contact.
const SEPARATION_SHARE: f64 = 0.1;

/// Computes the position within the backlash along a motion: in contact at ± `half`, or in between, where the
/// load moves freely. Its free acceleration is `stiffness_per_mass` (1/s²) times `deflection`, the deflection
/// of the joint without backlash. Impacts are plastic.
pub(super) fn position_in_backlash(
    deflection: &[f64],
    half: f64,
    stiffness_per_mass: f64,
    step_s: f64,
) -> Vec<f64> {
    let first = contact_sides(deflection).first().copied().unwrap_or(0.0);
    let (mut position, mut speed) = (half * first, 0.0);
    deflection
        .iter()
        .map(|deflection| {
            let here = position;
            let speed_change = step_s * stiffness_per_mass * deflection;
            position += step_s * (speed + 0.5 * speed_change);
            speed += speed_change;
            if position.abs() >= half {
                (position, speed) = (half * position.signum(), 0.0);
            }
            here
        })
        .collect()
}

/// Returns the side (1 or −1) in contact under a force.
pub(super) fn contact_sides(force: &[f64]) -> Vec<f64> {
    let level =
        SEPARATION_SHARE * (force.iter().map(|f| f * f).sum::<f64>() / force.len().max(1) as f64).sqrt();
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

    /// Under a constant force the other side is reached after √(2·gap/(stiffness_per_mass·deflection)); a
    /// force that reverses earlier brings the load back.
    #[test]
    fn limit_free_motion_under_a_constant_force_is_a_parabola() {
        let (half, stiffness_per_mass, deflection, step_s) = (8e-6, 1e6, 2e-6, 1e-4);
        let force: Vec<f64> = (0..200).map(|i| if i < 20 { -deflection } else { deflection }).collect();
        let positions = position_in_backlash(&force, half, stiffness_per_mass, step_s);
        let after_s = (4.0 * half / (stiffness_per_mass * deflection)).sqrt();
        for (i, position) in positions.iter().enumerate() {
            let t = step_s * (i as f64 - 20.0);
            let expected = if t < 0.0 {
                -half
            } else {
                (0.5 * stiffness_per_mass * deflection * t * t - half).min(half)
            };
            assert!((position - expected).abs() < 1e-9 * half, "{i}: {position} for {expected}");
        }
        assert_eq!(positions[21 + (after_s / step_s).ceil() as usize], half);
        let brief: Vec<f64> =
            (0..200).map(|i| if (20..40).contains(&i) { deflection } else { -deflection }).collect();
        assert!(
            position_in_backlash(&brief, half, stiffness_per_mass, step_s)
                .iter()
                .all(|position| *position < half)
        );
    }
}
