use num_complex::Complex64;

use crate::modal::{CurveFit, CurveOptions, FrfCurve, LEAST_LINES, ModalError, fit_curve};

fn refused(f: &[f64], h: &[Complex64], sd: Option<&[f64]>, fit: CurveFit) -> ModalError {
    let options = CurveOptions { fit, ..CurveOptions::default() };
    fit_curve(&FrfCurve { frequency_hz: f, receptance: h, component_sd: sd, omega_power: 0 }, &options)
        .unwrap_err()
}

#[test]
fn refused_curves_name_the_line() {
    let f: Vec<f64> = (1..=50).map(f64::from).collect();
    let h = vec![Complex64::new(1.0, -0.1); 50];
    let with = |at: usize, value: Complex64| {
        let mut h = h.clone();
        h[at] = value;
        h
    };
    assert!(matches!(
        refused(&f, &with(7, Complex64::new(0.0, f64::NAN)), None, CurveFit::Full),
        ModalError::Value { line: 7, .. }
    ));
    assert!(matches!(
        refused(&f, &with(8, Complex64::new(f64::INFINITY, 0.0)), None, CurveFit::Full),
        ModalError::Value { line: 8, .. }
    ));
    assert!(matches!(
        refused(&f, &[Complex64::ZERO; 50], None, CurveFit::Full),
        ModalError::AllZero { lines: 50 }
    ));
    assert!(matches!(refused(&f, &h[..49], None, CurveFit::Full), ModalError::Length { found: 49, .. }));
    assert!(matches!(
        refused(&f[..11], &h[..11], None, CurveFit::Full),
        ModalError::TooFewLines { found: 11, needed: LEAST_LINES, .. }
    ));
    assert!(matches!(refused(&[], &[], None, CurveFit::Full), ModalError::TooFewLines { found: 0, .. }));
    assert!(matches!(refused(&f, &h, Some(&[0.0; 50]), CurveFit::Full), ModalError::Value { line: 0, .. }));
    assert!(matches!(
        refused(&f, &h, None, CurveFit::Local { from_hz: 9.0, to_hz: 3.0 }),
        ModalError::Band { .. }
    ));
    assert!(matches!(
        refused(&f, &h, None, CurveFit::Local { from_hz: 3.0, to_hz: 9.0 }),
        ModalError::TooFewLines { found: 7, .. }
    ));
    let mut falling = f.clone();
    falling.swap(3, 4);
    assert!(matches!(refused(&falling, &h, None, CurveFit::Full), ModalError::Order { line: 4, .. }));
    falling[0] = 0.0;
    assert!(matches!(refused(&falling, &h, None, CurveFit::Full), ModalError::Value { line: 0, .. }));
}

#[test]
fn limit_flat_and_pure_noise_curves_have_no_strong_modes() {
    let f: Vec<f64> = (1..=400).map(f64::from).collect();
    let flat = vec![Complex64::new(1e-8, -1e-9); 400];
    let fit = fit_curve(
        &FrfCurve { frequency_hz: &f, receptance: &flat, component_sd: None, omega_power: 0 },
        &CurveOptions::default(),
    )
    .unwrap();
    assert!(fit.modes.is_empty(), "{:?}", fit.modes);
    let mut draw = super::planted::Draw::new(1);
    let noise: Vec<Complex64> = f.iter().map(|_| Complex64::new(draw.normal(), draw.normal())).collect();
    let fit = fit_curve(
        &FrfCurve { frequency_hz: &f, receptance: &noise, component_sd: None, omega_power: 0 },
        &CurveOptions::default(),
    )
    .unwrap();
    println!("pure noise: {} modes", fit.modes.len());
    assert!(fit.modes.iter().all(|m| m.signal_to_noise < 10.0), "{:?}", fit.modes);
}
