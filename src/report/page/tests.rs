//! Requirements on every page.

use num_complex::Complex64;

use super::*;
use crate::vocabulary::VerdictKind;

const EVIL: &str = "<script>alert('x')</script><img src=http://example.org/a.png>";

fn resonator(f: f64) -> Complex64 {
    1e-8 / Complex64::new(1.0 - (f / 100.0).powi(2), 0.03 * f / 100.0)
}

fn curves(positions: usize, channels: usize, lines: usize) -> Vec<PageCurve> {
    let mut out = Vec::new();
    for p in 0..positions {
        for c in 0..channels {
            let scatter =
                |i: usize, s: f64| 1.0 + s * (((i * 7919 + p * 31 + c * 17) % 101) as f64 / 50.0 - 1.0);
            let measured =
                (1..=lines).map(|i| (0.2 * i as f64, resonator(0.2 * i as f64) * scatter(i, 0.05))).collect();
            let predicted = (1..=lines).map(|i| (0.2 * i as f64, resonator(0.2 * i as f64))).collect();
            out.push(PageCurve {
                position: if p == 0 { EVIL.into() } else { format!("l{p}") },
                channel: format!("table/{c}"),
                held_out: p % 2 == 1,
                unit: "receptance (µm/N)".into(),
                measured,
                predicted,
                before: Vec::new(),
                peaks: Vec::new(),
            });
        }
    }
    out
}

fn diagnosis() -> DiagnosisDocument {
    let effect = |id: &str, closed: f64| {
        serde_json::json!({ "id": id, "status": "tried", "gap_held_out_before": 0.3, "gap_held_out_after": 0.3 * (1.0 - closed),
            "closed": closed, "closed95": [closed - 0.1, closed + 0.1], "p_value": 0.001, "parameters": {}, "selected": closed > 0.5 })
    };
    let document = serde_json::json!({
        "schema": "jointid/diagnosis/1", "tool_version": "0", "seed": 1, "complete": true, "inputs": [], "warnings": [EVIL],
        "domain": "frf", "noise_floor": 0.01,
        "gap": { "fit": 0.2, "held_out": 0.3 },
        "where": [{ "interface": EVIL, "gap_held_out": 0.02, "shape": "stiffness" }],
        "effects": [effect(EVIL, 0.9), effect("table-mass", 0.1)],
        "verdict": { "kind": "ambiguous", "effects": [EVIL, "table-mass"], "reason": EVIL, "next_measurement": EVIL },
        "residual_map": [{ "position": EVIL, "channel": EVIL, "from_hz": 5.0, "to_hz": 50.0, "gap": 0.2 }],
        "delta_z": [{ "interface": EVIL, "frequency_hz": [1.0, 2.0], "real": [1e5, 1e5], "imag": [1.0, 2.0] }],
    });
    serde_json::from_value(document).unwrap()
}

#[test]
fn names_from_files_are_escaped() {
    let page = Page {
        title: EVIL.into(),
        curves: curves(2, 2, 50),
        diagnosis: Some(diagnosis()),
        notes: vec![EVIL.into()],
        files: vec![("diagnosis.json".into(), EVIL.into())],
        ..Page::default()
    };
    let made = html(&page);
    let own = made.replace(chart::LIBRARY, "");
    assert!(!own.contains("<script>alert") && !own.contains("<img"), "a name is not escaped");
    assert!(own.contains("&lt;script&gt;alert(&#39;x&#39;)"));
    // Names in charts are escaped, too.
    assert!(own.contains("\"\\u003c") || own.contains("&lt;img src=http://example.org/a.png&gt;"));
    assert!(own.contains("do not distinguish them") && own.contains("Measure next:"));
}

#[test]
fn uninformative_intervals_are_reported_as_such() {
    let mut found = diagnosis();
    found.effects[1].closed95 = Some([-63.83, 52.36]);
    let made = html(&Page { title: "open".into(), diagnosis: Some(found), ..Page::default() });
    assert!(
        made.contains("not determined")
            && made.contains("80.00 % … 100.00 %")
            && !made.contains("-6383")
            && !made.contains("−6383")
    );
}

#[test]
fn many_lines_stay_below_the_size_limit() {
    let page = Page { title: "many".into(), curves: curves(6, 6, 10_000), ..Page::default() };
    let made = html(&page);
    assert!(made.len() < MOST_BYTES, "{} bytes", made.len());
    assert!(made.contains("\\u003cextra") || made.contains("extra"));
}

#[test]
fn the_library_is_embedded_once_and_nothing_is_fetched() {
    let made = html(&Page { title: "empty".into(), ..Page::default() });
    assert_eq!(made.matches("* plotly.js (").count(), 1);
    assert!(made.contains("default-src 'none'"));
    let own = made.replace(chart::LIBRARY, "");
    assert!(!own.contains("http://") && !own.contains("https://"));
}

/// A curve with lines that are missing breaks there; its kinds of lines are in the legend, and no column is
/// without a name.
#[test]
fn curves_break_and_have_a_legend() {
    let mut curves = curves(18, 1, 60);
    for line in curves.iter_mut().flat_map(|curve| &mut curve.measured[20..30]) {
        line.1 = Complex64::new(f64::NAN, f64::NAN);
    }
    let made = html(&Page { title: "gaps".into(), curves, diagnosis: Some(diagnosis()), ..Page::default() });
    let own = made.replace(chart::LIBRARY, "");
    assert!(own.contains("null") && own.contains("Measured curves break where lines are missing"));
    for part in ["<i class=\"wide\"></i>measured", "</i>predicted, fitted", "</i>predicted, held out"] {
        assert!(own.contains(part), "{part}");
    }
    let colours: std::collections::BTreeSet<String> = (0..18).map(|at| chart::colour_of(at, 18)).collect();
    assert_eq!(colours.len(), 18);
    assert!(!own.contains("<th scope=\"col\"></th>") && !own.contains("<th scope=\"col\" class=\"n\"></th>"));
    assert!(own.contains("\".2~%\"") && !own.contains("\".0%\""));
}

#[test]
fn a_verdict_states_how_large_its_effect_is_and_none_shows_the_values_first() {
    let mut found = diagnosis();
    found.effects[1].parameters = [("k_s".to_string(), 900.0)].into();
    found.effects[1].parameter_units = [("k_s".to_string(), "N*m/rad".to_string())].into();
    let made = html(&Page { title: "large".into(), diagnosis: Some(found.clone()), ..Page::default() });
    let head = made.split("<nav").next().unwrap();
    assert!(head.contains("How large: table-mass: k_s = 900.0 N·m/rad"), "{head}");
    found.verdict.kind = VerdictKind::None;
    found.verdict.effects.clear();
    let row = serde_json::json!({ "value": 5e8, "unit": "N/m", "lower": 1e7, "upper": 1e10, "interval95": [4e8, 6e8],
        "identifiable": true, "depends_on_discrepancy": false, "fitted": true, "published": null, "description": "axial stiffness" });
    let parameters = [("k_n".to_string(), serde_json::from_value(row).unwrap())].into();
    let identification = Some(IdentificationDocument { parameters, ..IdentificationDocument::default() });
    let page = Page { title: "none".into(), diagnosis: Some(found), identification, ..Page::default() };
    let made = html(&page);
    let at = |id: &str| made.find(&format!("href=\"#{id}\"")).unwrap();
    assert!(at("parameters") < at("diagnosis"), "the values come first");
    let head = made.split("<nav").next().unwrap();
    assert!(
        head.contains("How large: the gap at held-out data is 30.00 %, where noise alone leaves 1.00 %"),
        "{head}"
    );
}

/// The machine is drawn with the location of the verdict marked; no two points share a place.
#[test]
fn a_sketch_marks_where_the_effect_acts() {
    let points =
        ["table", "left", "screw", "right", "left-angle", "screw-angle", "right-angle", "rotor", EVIL];
    let sketch = Sketch {
        points: points.iter().enumerate().map(|(at, name)| (name.to_string(), at > 3)).collect(),
        joints: vec![
            ("bearing-left".into(), vec![1]),
            ("bearing-right".into(), vec![3]),
            ("nut".into(), vec![0, 2, 5]),
            ("coupling".into(), vec![7, 4]),
            ("guide".into(), vec![0]),
        ],
        shafts: vec![("rod".into(), vec![[Some(1), Some(4)], [Some(2), Some(5)], [Some(3), Some(6)]])],
    };
    let drawn = |place: &str| {
        let mut found = diagnosis();
        found.verdict.place = Some(place.into());
        let page = Page { diagnosis: Some(found), sketch: sketch.clone(), ..Page::default() };
        html(&page).split("<nav").next().unwrap().to_string()
    };
    let head = drawn("rotor");
    assert!(head.contains("aria-label=\"Sketch of the machine, «rotor» marked\""), "{head}");
    assert!(!head.contains(EVIL));
    for (place, marked) in [("rotor", 2), ("nut", 3), ("bearing-left", 2), ("rod", 2)] {
        assert_eq!(drawn(place).matches("class=\"here\"").count(), marked, "{place}");
    }
    assert!(!drawn("measurement").contains("<svg"));
    let corner = |rect: &str| rect.split("width").next().unwrap().to_string();
    let corners: std::collections::BTreeSet<String> = head.split("<rect").skip(1).map(corner).collect();
    assert_eq!(corners.len(), points.len());
}
