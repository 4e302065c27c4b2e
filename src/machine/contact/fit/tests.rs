use super::*;
use crate::contact::published::{LEAD_M, MOTOR_EFFICIENCY, friction_axis_1, friction_axis_2};
use crate::contact::{ContactError, ScrewDrive};

/// Splitmix64 and Box–Muller: sufficient for a test and platform-independent.
struct Normal(u64);

impl Normal {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn draw(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

/// Returns both directions at 24 speeds from 0.05 to 50 mm/s (the paper's range), equally spaced in the
/// logarithm.
fn velocities() -> Vec<f64> {
    let speeds = (0..24).map(|index| 0.05e-3 * 1000.0_f64.powf(f64::from(index) / 23.0));
    speeds.flat_map(|speed| [speed, -speed]).collect()
}

fn data(curve: &StribeckCurve, noise: &mut impl FnMut(f64) -> (f64, Option<f64>)) -> Vec<Observation> {
    let rows = velocities().into_iter().map(|velocity_m_per_s| {
        let force = curve.force_n(velocity_m_per_s);
        let (error, sd_n) = noise(force);
        Observation { velocity_m_per_s, force_n: force + error, sd_n }
    });
    rows.collect()
}

fn values(curve: &StribeckCurve) -> [f64; 4] {
    [curve.coulomb_n, curve.static_n, curve.viscous_n_s_per_m, curve.stribeck_velocity_m_per_s]
}

fn estimates(fit: &StribeckFit) -> [ParameterEstimate; 4] {
    [fit.coulomb_n, fit.static_n, fit.viscous_n_s_per_m, fit.stribeck_velocity_m_per_s]
}

#[test]
fn recover_without_noise() {
    for curve in [friction_axis_1(), friction_axis_2()] {
        let rows = data(&curve, &mut |_| (0.0, Some(1.0)));
        for noise in [StribeckNoise::Uniform, StribeckNoise::Proportional, StribeckNoise::Known] {
            let fit = fit_stribeck(&rows, &StribeckOptions::new(noise)).unwrap();
            for (found, truth) in values(&fit.curve).into_iter().zip(values(&curve)) {
                assert!((found / truth - 1.0).abs() < 1e-7, "{noise:?}: {found} {truth}");
            }
            assert_eq!(fit.degrees_of_freedom, 44);
        }
    }
}

#[test]
fn recover_table_2_from_50_draws_with_2_percent_noise() {
    let mut normal = Normal(7);
    for curve in [friction_axis_1(), friction_axis_2()] {
        let truth = values(&curve);
        let mut mean = [0.0; 4];
        let mut worst = [0.0_f64; 4];
        for _ in 0..50 {
            let rows = data(&curve, &mut |force| (0.02 * force * normal.draw(), None));
            let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Proportional)).unwrap();
            assert!((fit.residual_scatter / 0.02 - 1.0).abs() < 0.5, "{}", fit.residual_scatter);
            for (index, found) in values(&fit.curve).into_iter().enumerate() {
                mean[index] += found / truth[index] / 50.0;
                worst[index] = worst[index].max((found / truth[index] - 1.0).abs());
            }
        }
        for (index, limit) in [0.03, 0.04, 0.12, 0.12].into_iter().enumerate() {
            assert!((mean[index] - 1.0).abs() < 0.01, "{mean:?}");
            assert!(worst[index] < limit, "{worst:?}");
        }
    }
}

/// Returns the share of intervals that contain the true value, for each parameter.
fn coverage(
    curve: &StribeckCurve,
    noise: StribeckNoise,
    seed: u64,
    error: impl Fn(f64, f64) -> (f64, Option<f64>),
) -> [f64; 4] {
    let mut normal = Normal(seed);
    let mut inside = [0.0; 4];
    let draws = 300;
    for _ in 0..draws {
        let rows = data(curve, &mut |force| error(force, normal.draw()));
        let fit = fit_stribeck(&rows, &StribeckOptions::new(noise)).unwrap();
        for ((inside, estimate), truth) in inside.iter_mut().zip(estimates(&fit)).zip(values(curve)) {
            *inside += f64::from(u8::from(estimate.interval_95.unwrap().contains(truth))) / f64::from(draws);
        }
    }
    inside
}

#[test]
fn recover_coverage_of_the_95_percent_intervals() {
    for (seed, curve) in [(11, friction_axis_1()), (12, friction_axis_2())] {
        let proportional =
            coverage(&curve, StribeckNoise::Proportional, seed, |force, draw| (0.02 * force * draw, None));
        let uniform = coverage(&curve, StribeckNoise::Uniform, seed, |_, draw| (9.0 * draw, None));
        let known = coverage(&curve, StribeckNoise::Known, seed, |force, draw| {
            let sd = (0.02 * force).hypot(3.0);
            (sd * draw, Some(sd))
        });
        for (name, shares) in [("proportional", proportional), ("uniform", uniform), ("known", known)] {
            println!("{name} {shares:?}");
            assert!(shares.iter().all(|share| (0.90..=0.99).contains(share)), "{name} {shares:?}");
        }
    }
}

#[test]
fn recover_from_torques() {
    let drive = ScrewDrive::new(LEAD_M, MOTOR_EFFICIENCY).unwrap();
    let curve = friction_axis_2();
    let rows: Vec<Observation> = velocities()
        .into_iter()
        .map(|velocity_m_per_s| {
            let torque = drive.torque_nm(curve.force_n(velocity_m_per_s));
            Observation { velocity_m_per_s, force_n: drive.force_n(torque), sd_n: None }
        })
        .collect();
    let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Uniform)).unwrap();
    assert!((fit.curve.static_n / 1225.0 - 1.0).abs() < 1e-7);
}

#[test]
fn limit_curves_without_a_fall_or_a_rise_are_reported_at_a_bound() {
    let line = StribeckCurve {
        coulomb_n: 300.0,
        static_n: 300.0,
        viscous_n_s_per_m: 3000.0,
        stribeck_velocity_m_per_s: 1e-3,
    };
    let rows = data(&line, &mut |_| (0.0, None));
    let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Uniform)).unwrap();
    assert!(
        (fit.curve.coulomb_n / 300.0 - 1.0).abs() < 1e-6
            && (fit.curve.viscous_n_s_per_m / 3000.0 - 1.0).abs() < 1e-6
    );
    // A hidden fall below the slowest measured speed is not identifiable.
    let hidden = StribeckCurve { stribeck_velocity_m_per_s: 1e-6, ..friction_axis_1() };
    let mut normal = Normal(3);
    let rows = data(&hidden, &mut |force| (0.01 * force * normal.draw(), None));
    let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Proportional)).unwrap();
    assert!((fit.curve.coulomb_n / 280.9 - 1.0).abs() < 0.02);
    let velocity = fit.stribeck_velocity_m_per_s;
    let wide = velocity.interval_95.is_none_or(|interval| interval.upper / interval.lower > 3.0);
    assert!(velocity.at_bound || wide, "{velocity:?}");
    let flat = StribeckCurve { viscous_n_s_per_m: 0.0, ..friction_axis_1() };
    let mut normal = Normal(5);
    let mut bounded = 0;
    for _ in 0..20 {
        let rows = data(&flat, &mut |force| (0.02 * force * normal.draw(), None));
        let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Proportional)).unwrap();
        let viscous = fit.viscous_n_s_per_m;
        assert!(viscous.value >= 0.0 && viscous.at_bound == viscous.interval_95.is_none());
        bounded += i32::from(viscous.at_bound);
        assert!(fit.static_n.interval_95.is_some());
    }
    assert!(bounded > 3 && bounded < 17, "{bounded}");
}

#[test]
fn limit_units_of_force_and_order_of_rows_do_not_matter() {
    let mut normal = Normal(9);
    let rows = data(&friction_axis_1(), &mut |force| (0.02 * force * normal.draw(), None));
    let fit = fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Uniform)).unwrap();
    let scaled: Vec<Observation> =
        rows.iter().rev().map(|row| Observation { force_n: 1e3 * row.force_n, ..*row }).collect();
    let other = fit_stribeck(&scaled, &StribeckOptions::new(StribeckNoise::Uniform)).unwrap();
    assert!((other.curve.coulomb_n / fit.curve.coulomb_n / 1e3 - 1.0).abs() < 1e-6);
    assert!((other.curve.stribeck_velocity_m_per_s / fit.curve.stribeck_velocity_m_per_s - 1.0).abs() < 1e-6);
    let (a, b) = (fit.static_n.interval_95.unwrap(), other.static_n.interval_95.unwrap());
    assert!((b.upper / a.upper / 1e3 - 1.0).abs() < 1e-6);
}

#[test]
fn bad_data_are_named() {
    let row = |velocity_m_per_s: f64, force_n: f64| Observation { velocity_m_per_s, force_n, sd_n: None };
    let good: Vec<Observation> =
        (1..=6).map(|index| row(f64::from(index) * 1e-3, 300.0 + f64::from(index))).collect();
    let fails = |rows: &[Observation], noise| fit_stribeck(rows, &StribeckOptions::new(noise)).unwrap_err();
    assert_eq!(fails(&good[..4], StribeckNoise::Uniform), ContactError::TooFewData { found: 4, needed: 5 });
    assert_eq!(fails(&[], StribeckNoise::Uniform), ContactError::TooFewData { found: 0, needed: 5 });
    let single = vec![row(2e-3, 300.0); 10];
    assert_eq!(fails(&single, StribeckNoise::Uniform), ContactError::TooFewSpeeds { found: 1, needed: 4 });
    let reversed: Vec<Observation> =
        good.iter().take(3).flat_map(|r| [*r, row(-r.velocity_m_per_s, -r.force_n)]).collect();
    assert_eq!(fails(&reversed, StribeckNoise::Uniform), ContactError::TooFewSpeeds { found: 3, needed: 4 });
    let with = |index: usize, bad: Observation| {
        let mut rows = good.clone();
        rows[index] = bad;
        rows
    };
    assert_eq!(
        fails(&with(2, row(f64::NAN, 1.0)), StribeckNoise::Uniform),
        ContactError::NonFiniteData { row: 2 }
    );
    assert_eq!(
        fails(&with(3, row(1.0, f64::INFINITY)), StribeckNoise::Uniform),
        ContactError::NonFiniteData { row: 3 }
    );
    assert_eq!(fails(&with(4, row(0.0, 1.0)), StribeckNoise::Uniform), ContactError::ZeroVelocity { row: 4 });
    assert_eq!(fails(&good, StribeckNoise::Known), ContactError::MissingStandardDeviation { row: 0 });
    let bad_sd = Observation { sd_n: Some(0.0), ..good[1] };
    assert_eq!(
        fails(&with(1, bad_sd), StribeckNoise::Uniform),
        ContactError::StandardDeviation { row: 1, value: 0.0 }
    );
    let opposing: Vec<Observation> = good.iter().map(|r| row(-r.velocity_m_per_s, r.force_n)).collect();
    assert_eq!(fails(&opposing, StribeckNoise::Uniform), ContactError::OpposingForces);
    let options = StribeckOptions {
        stribeck_range_m_per_s: Some((2e-3, 1e-3)),
        ..StribeckOptions::new(StribeckNoise::Uniform)
    };
    assert_eq!(
        fit_stribeck(&good, &options).unwrap_err(),
        ContactError::EmptyRange { lower: 2e-3, upper: 1e-3 }
    );
}

/// Friction that rises from rest to a level, or falls with speed throughout, is no Stribeck curve.
#[test]
fn runs_that_no_curve_explains_contradict_it() {
    let mut noise = Normal(11);
    let mut contradicted = |force: fn(f64) -> f64, sd: f64| {
        let rows: Vec<Observation> = velocities()
            .into_iter()
            .map(|velocity_m_per_s| Observation {
                velocity_m_per_s,
                force_n: (force(velocity_m_per_s.abs()) + sd * noise.draw()).copysign(velocity_m_per_s),
                sd_n: None,
            })
            .collect();
        fit_stribeck(&rows, &StribeckOptions::new(StribeckNoise::Uniform)).unwrap().contradicted
    };
    let rising = contradicted(|v| 100.0 - 50.0 * (-(v / 0.01).powi(2)).exp(), 1.0).unwrap();
    assert!(rising.static_n < rising.coulomb_n, "{rising:?}");
    let falling = contradicted(|v| 100.0 + 80.0 * (-(v / 0.01).powi(2)).exp() - 600.0 * v, 1.0).unwrap();
    assert!((falling.viscous_n_s_per_m + 600.0).abs() < 100.0, "{falling:?}");
    for law in [|_| 100.0, |v| 100.0 + 50.0 * (-(v / 0.01).powi(2)).exp(), |v| 100.0 + 400.0 * v]
        as [fn(f64) -> f64; 3]
    {
        for sd in [0.0, 1.0] {
            assert_eq!(contradicted(law, sd), None);
        }
    }
}
