//! Text of an identified machine: the description with parameters at identified values, tolerances held, and
//! effects added.

use std::collections::BTreeMap;

use super::error::ConfigError;
use super::read::{MachineConfig, Overrides, read_machine_text, stated_table};
use machine::{Estimate, FitRule, Parameter, Prior, Scale};

/// What an identification or a diagnosis found about a machine.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Found {
    /// Values of the parameters, by id.
    pub values: BTreeMap<String, f64>,
    /// Nut positions (m) of the set, and estimates of the tolerances by name; `None` where tolerances were not
    /// fitted along.
    pub tolerances: Option<(Vec<f64>, BTreeMap<String, Estimate>)>,
    /// SHA-256 of the files of the measurements from which the tolerances are.
    pub measurements_sha256: Vec<String>,
    /// Ids of effects to add.
    pub effects: Vec<String>,
    /// Whether the measurement set that the description names stays named.
    pub keeps_measurements: bool,
}

/// Returns the description of a machine as found, overrides included: text that [`read_machine_text`] reads.
///
/// `heading` becomes a comment. Comments of the description are lost, its descriptions and sources of
/// parameters stay.
///
/// # Errors  an effect is unknown or does not apply; a value is missing.
pub fn machine_as_found(
    config: &MachineConfig,
    overrides: Overrides<'_>,
    found: &Found,
    heading: &str,
) -> Result<String, ConfigError> {
    let content = |fault: String| ConfigError::Content { path: config.path.clone(), fault };
    let mut table = stated_table(&config.text, overrides)?;
    if !found.keeps_measurements {
        table.remove("measurements");
    }
    let effects: Vec<toml::Value> =
        config.machine.effects.iter().chain(&found.effects).cloned().map(toml::Value::String).collect();
    if effects.is_empty() {
        table.remove("effects");
    } else {
        table.insert("effects".into(), effects.into());
    }
    let text = |table: &toml::Table| {
        toml::to_string(table).map_err(|e| content(format!("the machine cannot be written as TOML: {e}")))
    };
    // Ranges of added parameters are those of the description, where it states them, else those of the
    // library.
    let machine = read_machine_text(&config.path, &text(&table)?, &[], &[])?.machine;
    let parameters = table.entry("parameter").or_insert_with(|| toml::Table::new().into());
    let parameters = parameters.as_table_mut().ok_or_else(|| content("parameter is no table".into()))?;
    parameters.retain(|id, _| machine.parameter(id).is_some());
    for parameter in &machine.parameters {
        let value = found
            .values
            .get(&parameter.id)
            .ok_or_else(|| content(format!("the result has no parameter «{}»", parameter.id)))?;
        parameters.insert(parameter.id.clone(), entry(parameter, *value).into());
    }
    if parameters.is_empty() {
        table.remove("parameter");
    }
    if let Some((nuts_m, estimates)) = &found.tolerances {
        put_estimates(&mut table, (nuts_m, &found.measurements_sha256), estimates);
    }
    let heading: String = heading.lines().map(|line| format!("# {line}\n")).collect();
    let text = heading + "\n" + &text(&table)?;
    // What is written is read back: a file that no command reads must not come out.
    read_machine_text(&config.path, &text, &[], &[])?;
    Ok(text)
}

/// Writes estimates of tolerances into the section `[fitted]`. Where a description has it, others of its
/// tolerances stay as they are, and so do the nut positions on which its journals and nuts depend.
fn put_estimates(
    table: &mut toml::Table,
    (nuts_m, data): (&[f64], &[String]),
    estimates: &BTreeMap<String, Estimate>,
) {
    let fitted = table.entry("fitted").or_insert_with(|| {
        let nuts_m: Vec<toml::Value> = nuts_m.iter().map(|x| (*x).into()).collect();
        toml::Table::from_iter([("nuts_m".to_string(), nuts_m.into())]).into()
    });
    let Some(fitted) = fitted.as_table_mut() else { return };
    let known = fitted.entry("measurements_sha256").or_insert_with(|| toml::Value::Array(Vec::new()));
    if let toml::Value::Array(known) = known {
        known.extend(data.iter().cloned().map(toml::Value::String));
    }
    let own = fitted.entry("tolerances").or_insert_with(|| toml::Table::new().into());
    if let Some(own) = own.as_table_mut() {
        own.extend(estimates.iter().map(|(name, Estimate { value, sd })| {
            let known = sd.map(|sd| ("sd".to_string(), sd.into()));
            let entry = known.into_iter().chain([("value".to_string(), (*value).into())]);
            (name.clone(), toml::Value::Table(entry.collect()))
        }));
    }
}

/// Returns the configuration of a parameter in SI units, starting at a value.
fn entry(parameter: &Parameter, value: f64) -> toml::Table {
    let Parameter { unit, lower, upper, scale, fit, prior, source, description, .. } = parameter;
    let mut table = toml::Table::new();
    let mut put = |key: &str, value: toml::Value| {
        table.insert(key.into(), value);
    };
    put("unit", unit.clone().into());
    put("start", value.clamp(*lower, *upper).into());
    put("lower", (*lower).into());
    put("upper", (*upper).into());
    put("scale", if *scale == Scale::Logarithmic { "logarithmic" } else { "linear" }.into());
    match fit {
        FitRule::Always => {}
        FitRule::Frf => put("fit", "frf".into()),
        FitRule::Never => put("fit", "never".into()),
    }
    match prior {
        Some(Prior::Normal(sd)) => put("sd", (*sd).into()),
        Some(Prior::Catalogue(median, sd)) => {
            let catalogue = [("value".to_string(), (*median).into()), ("factor".into(), sd.exp().into())];
            put("prior", toml::Value::Table(catalogue.into_iter().collect()));
        }
        Some(Prior::LogNormal(_)) | None => {}
    }
    for (key, text) in [("source", source), ("description", description)] {
        if !text.is_empty() {
            put(key, text.clone().into());
        }
    }
    table
}
