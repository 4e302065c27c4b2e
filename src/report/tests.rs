//! Snapshots of documents and terminal text. `INSTA_UPDATE=always cargo test -p jointid-report` writes them
//! again; review them with `git diff`.

use insta::assert_snapshot;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::*;

/// Returns a document of this content, with a stamp.
fn document<T: DeserializeOwned>(content: Value) -> T {
    let stamp = json!({ "schema": "jointid/test/1", "tool_version": "0", "seed": 1, "complete": true, "inputs": [], "warnings": [] });
    let (Value::Object(mut all), Value::Object(content)) = (stamp, content) else { unreachable!() };
    all.extend(content);
    serde_json::from_value(Value::Object(all)).unwrap()
}

/// Lists the keys of an object of a schema, `?` behind those that may be absent.
fn keys(schema: &Map<String, Value>) -> String {
    let required = |key: &String| {
        schema.get("required").and_then(Value::as_array).is_some_and(|list| list.contains(&json!(key)))
    };
    let of = |key: &String| if required(key) { key.clone() } else { format!("{key}?") };
    let properties = schema.get("properties").and_then(Value::as_object);
    properties.map(|all| all.keys().map(of).collect::<Vec<_>>().join(" ")).unwrap_or_default()
}

/// Lists the words of a closed vocabulary.
fn words(schema: &Map<String, Value>) -> String {
    let of = |variant: &Value| variant.get("const").and_then(Value::as_str).map(String::from);
    let variants = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten();
    variants.filter_map(of).collect::<Vec<_>>().join(" | ")
}

#[test]
fn documents_keep_their_keys_and_words() {
    let mut text = String::new();
    for name in SCHEMAS {
        let schema = schema(name).unwrap();
        let root = schema.as_object().unwrap();
        text += &format!("{name}: {}\n", keys(root));
        for (part, own) in root.get("$defs").and_then(Value::as_object).into_iter().flatten() {
            let own = own.as_object().unwrap();
            text += &format!("    {part}: {}{}\n", keys(own), words(own));
        }
    }
    assert_snapshot!(text);
}

#[test]
fn a_diagnosis_as_text() {
    let effect = |id: &str, closed: f64, selected: bool| {
        json!({ "id": id, "status": "tried", "gap_held_out_before": 0.312, "gap_held_out_after": 0.312 * (1.0 - closed), "closed": closed,
            "closed95": [closed - 0.1, closed + 0.05], "p_value": 4e-5, "misfit_reduction": closed, "selected": selected,
            "parameters": { "k_s": 2.07e7 }, "parameter_units": { "k_s": "N*m/rad" }, "description": "The drive holds the rotor." })
    };
    let other = |id: &str, status: &str| {
        json!({ "id": id, "status": status, "gap_held_out_before": null, "gap_held_out_after": null, "closed": null, "p_value": null,
            "selected": false })
    };
    let found = document(json!({
        "domain": "frf", "noise_floor": 0.011, "gap": { "fit": 0.2, "held_out": 0.312 },
        "where": [{ "interface": "rotor", "shape": "other", "misfit_reduction": 0.97, "gap_held_out": 0.021 },
                  { "interface": "nut", "shape": "resonator", "misfit_reduction": 0.4, "gap_held_out": 0.2 }],
        "effects": [effect("rotor-hold", 0.94, true), effect("guide-stiffness", 0.2, false), other("table-rocking", "failed"),
                    other("backlash", "not-applicable")],
        "chosen": { "id": "rotor-hold", "gap_held_out": 0.021, "closed": 0.94, "closed95": [0.84, 0.99], "ceiling": 0.95,
                    "headline_metrics": [{ "figure": "frequency of the highest resonance", "before": 0.05, "after": 0.0004 }] },
        "tolerances": { "mass of table": { "unit": "1", "prior": { "mean": 0.0, "sd": 0.05 }, "value": 0.08, "sd": 0.01 } },
        "verdict": { "kind": "effect", "effects": ["rotor-hold"], "confirmed": true, "reason": "It predicts the held-out positions.",
                     "next_measurement": "strike at the rotor", "band_hz": [20.0, 90.0] },
    }));
    assert_snapshot!(diagnosis_text(&found));
}

#[test]
fn an_identification_as_text() {
    let order = |order: u32, measured: f64, predicted: f64| {
        json!({ "order": order, "measured_hz": measured, "predicted_hz": predicted, "relative_error": predicted / measured - 1.0,
            "measured_amplitude": null, "predicted_amplitude": null, "published_hz": 1.01 * measured })
    };
    let position = |role: &str| {
        json!({ "role": role, "overall_error": 0.0123, "overall_error_rounded": 0.012, "overall_error_published": 0.02,
            "orders": [order(1, 66.0, 66.4), order(2, 244.0, 241.0)], "lone_peaks": [] })
    };
    let parameter = |value: f64, identifiable: Value, depends: bool| {
        json!({ "value": value, "unit": "N/m", "lower": 1e7, "upper": 1e10, "interval95": [0.9 * value, 1.1 * value],
            "identifiable": identifiable, "depends_on_discrepancy": depends, "fitted": true, "published": 5.59e8,
            "description": "axial stiffness" })
    };
    let found = document(json!({
        "settings": { "config": "configs/tian.toml", "measurements": "measurements/tian", "model": "receptance", "lumps": null,
            "objective": "least-squares", "frequency_model_error": 0.01, "amplitude_sd": 0.13, "repeats": 5, "freeze": [] },
        "parameters": { "k_n": parameter(5.6e8, json!(true), false), "k_al": parameter(3.2e8, Value::Null, true) },
        "derived": { "largest_frequency_error_held_out": 0.0123, "ln_amplitude_rms_fit": 0.2, "stiffness": 1.23e8 },
        "derived_interval95": { "stiffness": [1.2e8, 1.26e8] },
        "bootstrap": [{ "drawn": "lines", "samples": 200, "interval95": { "k_n": [5.4e8, 5.8e8] } }],
        "cost": 12.3456789, "evaluations": 4321, "search": { "starts": 8, "found": 5, "required": 5 }, "searches_agree": true, "searches": [],
        "fitted_parameters": [], "correlation": [], "fit_positions": ["l1"], "held_out_positions": ["l2"],
        "positions": { "l1": position("fit"), "l2": position("held_out") },
    }));
    assert_snapshot!(identification_text("bench", &found, &["stiffness".into()]));
}

#[test]
fn a_prediction_as_text_and_table() {
    let found = document(json!({
        "quantity": "receptance", "response": "table", "excitation": "table", "band_hz": [5.0, 900.0], "draws": 199, "minima": 2, "nut_sd_m": 0.001,
        "positions": {
            "0.4": { "nut_m": 0.4, "modes": [{ "order": 1, "frequency_hz": 66.123, "natural_hz": 66.138, "natural95": [65.9, 66.4], "damping_ratio": 0.0213, "amplitude": 1.234e-7,
                "frequency95": [65.9, 66.4], "damping95": [0.02, 0.023], "amplitude95": null }],
                "static_stiffness": 8.1e7, "static_stiffness95": [7.9e7, 8.3e7],
                "frf": { "frequency_hz": [10.0], "value": [[1e-8, -1e-9]], "magnitude95": [[0.9e-8, 1.1e-8]] } },
            "l1": { "nut_m": 0.6, "role": "held_out", "modes": [{ "order": 1, "natural_hz": 67.0, "natural95": [66.8, 67.2], "damping_ratio": null, "amplitude": null,
                "damping95": null, "amplitude95": null }], "static_stiffness": null, "static_stiffness95": null },
        },
    }));
    let tables = format!("{}\n{}", prediction_csv(&found), predicted_frfs_csv(&found).unwrap());
    assert_snapshot!(format!("{}\n{tables}", prediction_text("bench", &found)));
}

#[test]
fn a_plan_and_a_change_as_text() {
    let choice = |name: &str, score: f64| json!({ "measure": [name], "score": score, "determined": ["k_n"], "half_width95": { "k_n": 1.3e7, "k_al": 9e8 } });
    let plan = document(json!({ "data": "frf", "measured": ["l1"], "parameters": ["k_n", "k_al"],
        "rankings": [{ "count": 1, "split_rank": 2, "choices": [choice("l3", 0.3), choice("l5", 0.4)] }] }));
    let change = document(json!({ "level": 0.05, "compared": 1, "common": ["mass of table"], "parameters": {
        "k_n": { "first": 5.6e8, "second": 4.9e8, "unit": "N/m", "change": -0.125, "change95": [-0.15, -0.1], "relative": true,
                 "p_value": 1e-6, "p_adjusted": 1e-6, "changed": true },
        "offset": { "first": 1.0, "second": 1.2, "unit": "N", "change": 0.2, "change95": [-0.2, 0.6], "relative": false,
                    "p_value": null, "p_adjusted": null, "changed": false } } }));
    assert_snapshot!(format!("{}\n{}", plan_table(&plan, &|_| 5.6e8, 5), change_text("bench", &change)));
}

#[test]
fn a_change_says_what_was_not_compared_and_what_is_common() {
    let row = |second: f64, p: Value| {
        json!({ "first": 5326.0, "second": second, "unit": "N/m", "change": -0.07, "change95": [-0.11, -0.03],
            "relative": true, "p_value": p, "p_adjusted": p, "changed": !p.is_null() })
    };
    let text = |compared: usize, row: Value| {
        let change = document(
            json!({ "level": 0.05, "compared": compared, "common": [], "parameters": { "k_n": row } }),
        );
        change_text("bench", &change).split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let none = text(0, row(4953.0, Value::Null));
    assert!(none.contains("no parameter could be compared") && !none.contains("no significant"), "{none}");
    let common = text(1, row(4419.0, json!(1e-4)));
    assert!(common.contains("separate fits") && common.contains("differ for k_n"), "{common}");
    let alike = text(1, row(4953.2, json!(1e-4)));
    assert!(!alike.contains("separate fits"), "{alike}");
}
