//! Trial amplitudes of the parameters that a hypothesis adds.

use machine::{Mechanism, Parameter};
use numeric::halton::halton_point;

/// Loss factor of trials (1), wide enough to miss no resonance between two of them.
const WIDE_LOSS_FACTOR: f64 = 0.1;
/// Largest number of parameters that all vary together.
const FEW: usize = 4;

/// Returns trial coordinates of added parameters: their start, and a grid over the unit cube (Halton's
/// sequence). Loss factors beside many other parameters keep one value.
pub fn amplitudes(described: &[&Parameter]) -> Vec<Vec<f64>> {
    if described.is_empty() {
        return vec![Vec::new()];
    }
    let start: Vec<f64> = described.iter().map(|p| p.to_unit(p.start)).collect();
    if let Some(resonances) = resonances(described) {
        return std::iter::once(start).chain(resonances).collect();
    }
    let is_loss = |p: &Parameter| p.mechanism == Mechanism::LossFactor;
    let losses = described.iter().filter(|p| is_loss(p)).count();
    let holds_losses = described.len() > FEW && losses < described.len();
    let varied = described.len() - if holds_losses { losses } else { 0 };
    let count = match varied {
        1 => 25,
        2 => 20,
        3 | 4 => 40,
        _ => 200,
    };
    let grid = (1..=count).map(|index| {
        let mut along = halton_point(index, varied).into_iter();
        let held =
            |p: &Parameter| (holds_losses && is_loss(p)).then(|| p.to_unit(WIDE_LOSS_FACTOR).clamp(0.0, 1.0));
        described.iter().filter_map(|p| held(p).or_else(|| along.next())).collect()
    });
    std::iter::once(start).chain(grid).collect()
}

/// Lowest and highest frequency (Hz) of trial resonances, and their number.
const RESONANCES_HZ: (f64, f64, u32) = (8.0, 1600.0, 26);
/// Coordinates of a mass in its range for trial resonances.
const SHARES: [f64; 3] = [0.3, 0.6, 0.85];
/// Loss factor of trial resonances (1), twice the damping ratio.
const LOSS: f64 = 0.06;
/// Trial values of pairs of dimensionless parameters: lever arms of reading and of strike, on either side.
const ARMS: [[f64; 2]; 5] = [[0.0, 0.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];

/// Returns coordinates of trial resonances all over the band. Covered is a mass with a spring and a damper or
/// a loss factor, and with two lever arms. Ranges alone would mostly give resonances outside the band. `None`
/// for other sets of parameters.
fn resonances(described: &[&Parameter]) -> Option<Vec<Vec<f64>>> {
    let that = |is: fn(Mechanism) -> bool| {
        (0..described.len()).filter(|at| is(described[*at].mechanism)).collect::<Vec<usize>>()
    };
    let masses = that(|m| m == Mechanism::Inertia);
    let springs = that(|m| m == Mechanism::Stiffness);
    let dampers = that(|m| m == Mechanism::Damping);
    let clamped =
        |at: usize, x: f64| described[at].to_unit(x.clamp(described[at].lower, described[at].upper));
    let (low, high, count) = RESONANCES_HZ;
    let start: Vec<f64> = described.iter().map(|p| p.to_unit(p.start)).collect();
    let frequencies = (0..count).map(|at| low * (high / low).powf(f64::from(at) / f64::from(count - 1)));
    let tried = frequencies.flat_map(|hz| SHARES.map(|share| (hz, share)));
    // Numbers without a unit are loss factors and lever arms.
    let losses = that(|m| m == Mechanism::LossFactor);
    let arms = that(|m| m.is_dimensionless() && m != Mechanism::LossFactor);
    let are_all = masses.len() + springs.len() + dampers.len() + losses.len() + arms.len() == described.len();
    let (&[mass], &[spring], true) =
        (masses.as_slice(), springs.as_slice(), are_all && [0, 2].contains(&arms.len()))
    else {
        return None;
    };
    if dampers.len() + losses.len() != 1 {
        return None;
    }
    let sides = if arms.is_empty() { &ARMS[..1] } else { &ARMS };
    let place = |((hz, share), sides): ((f64, f64), [f64; 2])| {
        let (m, omega) = (described[mass].from_unit(share), std::f64::consts::TAU * hz);
        let mut place = start.clone();
        place[mass] = share;
        place[spring] = clamped(spring, m * omega * omega);
        dampers.iter().for_each(|damper| place[*damper] = clamped(*damper, LOSS * (m * omega)));
        losses.iter().for_each(|loss| place[*loss] = clamped(*loss, LOSS));
        arms.iter().zip(sides).for_each(|(at, arm)| place[*at] = clamped(*at, arm));
        place
    };
    Some(tried.flat_map(|resonance| sides.iter().map(move |some| (resonance, *some))).map(place).collect())
}
