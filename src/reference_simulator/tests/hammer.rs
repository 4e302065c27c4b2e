//! Tests of the hammer test: transforms, windows, bias of H1, coherence against the scatter of repeats.

use num_complex::Complex64;

use super::{setting, subject};
use crate::case::{ChannelSet, TestRig, axis};
use crate::draw::Draw;
use crate::hammer::block::Analyser;
use crate::hammer::fft::Fft;
use crate::hammer::pulse::Pulse;
use crate::hammer::series::{StructureResponse, expected_coherence, noise_level, strike};
use crate::hammer::setting::Setting;

#[test]
fn limit_fft_is_the_sum() {
    let mut draw = Draw::new(1);
    let values: Vec<Complex64> = (0..64).map(|_| Complex64::new(draw.normal(), draw.normal())).collect();
    let mut fast = values.clone();
    let fft = Fft::new(64);
    fft.forward(&mut fast);
    for (k, value) in fast.iter().enumerate() {
        let turn = |n: usize| Complex64::from_polar(1.0, -2.0 * std::f64::consts::PI * (k * n) as f64 / 64.0);
        let sum: Complex64 = values.iter().enumerate().map(|(n, value)| value * turn(n)).sum();
        assert!((value - sum).norm() < 1e-12);
    }
    fft.backward(&mut fast);
    assert!(fast.iter().zip(&values).all(|(a, b)| (a / 64.0 - b).norm() < 1e-14));
}

#[test]
fn limit_pulse_is_a_half_sine() {
    let pulse = Pulse { height: 2.0, width_s: 1.3e-3, start_s: 0.01 };
    for s in [
        Complex64::new(1.0, 30.0),
        Complex64::new(2.0, 5000.0),
        Complex64::new(0.0, std::f64::consts::PI / 1.3e-3),
    ] {
        let step = 1.3e-3 / 20000.0;
        let part = |k: usize| {
            let t = (k as f64 + 0.5) * step;
            2.0 * (std::f64::consts::PI * t / 1.3e-3).sin() * (-s * (0.01 + t)).exp() * step
        };
        let sum: Complex64 = (0..20000).map(part).sum();
        assert!((pulse.transform(s) / sum - 1.0).norm() < 1e-7, "at {s}");
    }
}

#[test]
fn limit_block_is_the_decay_of_an_oscillator() {
    // x'' + 2 d x' + w² x = f / m. An ideal impulse gives e^{−dt} sin(w_d t) / (m w_d); the spectrum accounts
    // for the finite pulse width.
    let setting = setting(1000.0);
    let analyser = Analyser::new(setting);
    let (mass, decay, omega) = (3.0, 4.0, 2.0 * std::f64::consts::PI * 60.0);
    let pulse = Pulse::nominal(&setting);
    let samples = analyser.samples(|k| {
        let s = analyser.contour[k];
        let force = pulse.transform(s);
        (force, force / ((s * s + 2.0 * decay * s + omega * omega) * mass))
    });
    let damped = (omega * omega - decay * decay).sqrt();
    // The tail is the impulse response times the transform of pulse and filter at the oscillator's pole.
    let pole = Complex64::new(-decay, damped);
    let weight = pulse.transform(pole) * setting.filter(pole);
    for n in [800usize, 3000, 9000, 16000] {
        let expected = (weight * (pole * (n as f64 / setting.rate_hz)).exp() / (mass * damped)).im;
        let first = weight.norm() / (mass * damped);
        let there = first * (-decay * n as f64 / setting.rate_hz).exp();
        assert!(
            (samples[n].im - expected).abs() < 1e-4 * there + 1e-6 * first,
            "sample {n}: {} against {expected}",
            samples[n].im
        );
    }
}

/// Returns tests of the machines whose response a block contains, with their number and setting.
fn tests(channel_set: ChannelSet, spacing: f64) -> impl Iterator<Item = (u64, Setting, TestRig)> {
    (0..12).filter_map(move |seed| {
        let subject = subject(seed);
        let setting = setting(subject.drawn.band_hz);
        let test = TestRig::new(&subject, &setting, &channel_set.channels(), &[1.0], spacing).ok()?;
        Some((seed, setting, test))
    })
}

#[test]
fn h1_has_no_bias_at_resonances() {
    for (seed, _, test) in tests(ChannelSet::Rotor, 1.0 / 150.0).take(2) {
        assert!(test.bias < 0.003, "noise-free bias {}", test.bias);
        // With noise: the mean of repeated estimates at the highest peak of two table records.
        for station in [0, 5] {
            let exact = &test.exact[station][0];
            let peak = (0..exact.len()).max_by(|a, b| exact[*a].norm().total_cmp(&exact[*b].norm())).unwrap();
            let repeat = |repeat| {
                test.record(station, 0, None, &Draw::new(seed).branch(repeat))[peak].response / exact[peak]
            };
            let mean: Complex64 = (0..12).map(repeat).sum::<Complex64>() / 12.0;
            assert!(
                (mean - 1.0).norm() < 0.01,
                "machine {seed}, station {station}: bias {}",
                (mean - 1.0).norm()
            );
        }
    }
}

#[test]
fn coherence_predicts_the_scatter_of_repeats() {
    let subject = subject(0);
    let setting = setting(subject.drawn.band_hz);
    let test = TestRig::new(&subject, &setting, &ChannelSet::Table.channels(), &[1.0], 1.0 / 60.0).unwrap();
    let repeats: Vec<_> =
        (0..60).map(|repeat| test.record(3, 0, None, &Draw::new(9).branch(repeat))).collect();
    let exact = &test.exact[3][0];
    let n = setting.averages as f64;
    let mut ratios = Vec::new();
    for (line, exact) in exact.iter().enumerate() {
        let coherence: f64 =
            repeats.iter().map(|lines| lines[line].coherence).sum::<f64>() / repeats.len() as f64;
        if !(0.8..0.99999).contains(&coherence) {
            continue;
        }
        let scatter: f64 =
            repeats.iter().map(|lines| (lines[line].response / exact).ln().norm_sqr() / 2.0).sum::<f64>()
                / repeats.len() as f64;
        // n averages leave n − 1 degrees of freedom: the estimated 1 − γ² is too small by (n − 1)/n.
        let expected: f64 = repeats
            .iter()
            .map(|lines| (1.0 - lines[line].coherence) / (2.0 * n * lines[line].coherence))
            .sum::<f64>()
            / repeats.len() as f64;
        ratios.push(scatter / expected * (n - 1.0) / n);
    }
    assert!(ratios.len() > 100, "{} lines", ratios.len());
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((0.93..1.07).contains(&mean), "scatter over the value from coherence: {mean}");
    let outside = ratios.iter().filter(|ratio| !(0.6..1.6).contains(*ratio)).count();
    assert!(outside * 50 < ratios.len(), "{outside} of {} lines have another scatter", ratios.len());
}

#[test]
fn noise_has_the_expected_variance() {
    let Some((_, setting, test)) = tests(ChannelSet::Table, 1.0 / 100.0).nth(1) else {
        panic!("no machine has a response that a block contains")
    };
    let setting = setting.with_samples((test.block_s() * setting.rate_hz).round() as usize);
    let noise = noise_level(&setting, &test.lines_hz, &test.exact[2][0]);
    let expected: Vec<Vec<f64>> =
        test.exact.iter().map(|of| expected_coherence(&setting, &test.lines_hz, &of[0], noise)).collect();
    let (mut squares, mut count) = (0.0, 0.0);
    for repeat in 0..6 {
        for (station, expected) in expected.iter().enumerate() {
            let lines = test.record(station, 0, None, &Draw::new(repeat));
            for (index, line) in
                lines.iter().enumerate().filter(|(index, _)| (0.95..0.9999).contains(&expected[*index]))
            {
                let coherence = expected[index];
                let variance = (1.0 - coherence) / (2.0 * setting.averages as f64 * coherence);
                squares += (line.response / test.exact[station][0][index]).ln().norm_sqr() / 2.0 / variance;
                count += 1.0;
            }
        }
    }
    assert!((squares / count - 1.0).abs() < 0.1, "variance over the expected one: {}", squares / count);
}

#[test]
fn a_blow_without_noise_gives_the_response_of_a_mass() {
    let setting = setting(1000.0);
    let analyser = Analyser::new(setting);
    let response = StructureResponse {
        accelerance: vec![Complex64::new(0.2, 0.0); analyser.contour.len()],
        slope: None,
    };
    let lines = strike(&analyser, &response, &setting.kept_lines(0.05), None, None, &mut Draw::new(1));
    let worst = lines.iter().map(|line| (line.response / 0.2 - 1.0).norm()).fold(0.0, f64::max);
    assert!(worst < 1e-4, "{worst}");
    assert!(lines.iter().all(|line| line.coherence > 1.0 - 1e-9));
    assert_eq!(axis(&[1.0])[0].re, 0.0);
}
