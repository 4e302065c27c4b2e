//! Reading of configurations: files or embedded ones, with overrides.

use std::cmp::Reverse;
use std::path::Path;
use std::sync::OnceLock;

use file_access::{MOST_TEXT_BYTES, ReadFault, read_text};
use serde::de::DeserializeOwned;

use super::embedded::{EFFECTS, embedded_config};
use super::error::{ConfigError, fault};
use super::extent::check_extent;
use super::file::{EffectFile, LibraryFile, MachineFile};
use super::plausibility::{check_numbers, check_parameters, number};
use super::unknown::unknown_effect;
use machine::{Data, Effect, Machine, MachineError};

/// Overrides `key.path=value` of a configuration, applied in order.
pub type Overrides<'a> = &'a [String];

/// A machine as configured.
#[derive(Debug, Clone)]
pub struct MachineConfig {
    /// Its source: a file path, or the project path of an embedded configuration.
    pub path: String,
    /// Its text, for the digest.
    pub text: String,
    /// The machine with the effects it contains. Results embed `text`, so that numbers are to be changed
    /// there or by overrides.
    pub machine: Machine,
    /// Name of the built-in measurement set that belongs to the machine.
    pub measurements: Option<String>,
    /// Warnings for the user.
    pub warnings: Vec<String>,
    /// Those of the warnings that are about implausible numbers.
    pub implausible: Vec<String>,
    /// All available effects: those of the library and of the file.
    pub effects: Vec<Effect>,
    /// SHA-256 of the files of the measurements from which its `[fitted]` estimates are.
    pub fitted_from: Vec<String>,
}

/// Returns the embedded effect library.
///
/// # Errors  never in a released program: a test reads the library.
pub fn effect_library() -> Result<Vec<Effect>, ConfigError> {
    static LIBRARY: OnceLock<Vec<Effect>> = OnceLock::new();
    if let Some(library) = LIBRARY.get() {
        return Ok(library.clone());
    }
    let path = "configs/effects.toml";
    let file: LibraryFile = parse(path, EFFECTS, &[])?;
    let effect = |file: EffectFile| file.effect().map_err(|error| ConfigError::in_file(path, error));
    let library = file.effect.into_iter().map(effect).collect::<Result<Vec<_>, _>>()?;
    Ok(LIBRARY.get_or_init(|| library).clone())
}

/// Reads a machine from a file, or from the embedded configuration of that path where no such file exists.
/// The effects `without` are removed from the description first.
///
/// # Errors  the file cannot be read, is not valid TOML, or does not describe a machine; an override or an
///   effect is unknown.
pub fn read_machine(
    path: &str,
    overrides: Overrides<'_>,
    without: &[String],
) -> Result<MachineConfig, ConfigError> {
    let text = match read_text(Path::new(path), MOST_TEXT_BYTES) {
        Ok(text) => text,
        Err(fault) => match (embedded_config(path).filter(|_| fault.is_missing()), fault) {
            (Some(text), _) => text.to_string(),
            (None, ReadFault::Folder) => {
                return Err(ConfigError::Unreadable {
                    path: path.into(),
                    fault: "is a folder; name a .toml file".into(),
                });
            }
            (None, fault) => {
                return Err(ConfigError::Unreadable { path: path.into(), fault: fault.to_string() });
            }
        },
    };
    read_machine_text(path, &text, overrides, without)
}

/// Reads a machine from text, as [`read_machine`].
///
/// # Errors  as [`read_machine`].
pub fn read_machine_text(
    path: &str,
    text: &str,
    overrides: Overrides<'_>,
    without: &[String],
) -> Result<MachineConfig, ConfigError> {
    let content = |fault: String| ConfigError::Content { path: path.into(), fault };
    let in_file = |error: MachineError| ConfigError::in_file(path, error);
    if text.trim().is_empty() {
        return Err(content("is empty; a machine needs at least title, [[point]] and [[joint]]".into()));
    }
    let mut file: MachineFile = parse(path, text, overrides)?;
    let stated = stated_table(text, overrides)?;
    check_extent(&stated).map_err(in_file)?;
    let implausible = check_numbers(&stated).map_err(in_file)?;
    let is_stated = |id: &str| stated.get("parameter").and_then(|parameters| parameters.get(id)).is_some();
    let renamed = if file.effect.is_empty() { None } else { renamed_keys(path, text) };
    let mut effects = effect_library()?;
    let mut own: Vec<Effect> = Vec::new();
    for effect in std::mem::take(&mut file.effect) {
        let effect = effect.effect().map_err(in_file)?;
        if effects.iter().chain(&own).any(|e| e.id == effect.id) {
            return Err(content(format!("effect «{}» is defined already; choose another id", effect.id)));
        }
        own.push(effect);
    }
    effects.extend(own.iter().cloned());
    for id in without {
        if !file.effects.contains(id) {
            let known = if file.effects.is_empty() { "none".into() } else { file.effects.join(", ") };
            let fault = format!("the machine of {path} does not contain this effect; it contains {known}");
            return Err(ConfigError::Setting { key: "without", given: id.clone(), fault });
        }
    }
    let title = file.title.split_whitespace().collect::<Vec<_>>().join(" ");
    let measurements = file.measurements.take();
    let share_s = file.stiffness_proportional_damping_s;
    if !(share_s >= 0.0 && share_s.is_finite()) {
        return Err(in_file(fault(
            "stiffness_proportional_damping_s",
            format!("is {share_s}; write 0 or a time in s"),
        )));
    }
    let tolerance = file.tolerance;
    tolerance.check().map_err(in_file)?;
    let fitted = file.fitted.take();
    let contained = std::mem::take(&mut file.effects);
    if file.point.is_empty() {
        return Err(content("describes no [[point]]; a machine needs at least one".into()));
    }
    let patch = file.patch().map_err(in_file)?;
    let loss_dispersion = machine::Value::number(tolerance.loss_dispersion);
    let empty = Machine {
        title,
        stiffness_proportional_damping_s: share_s,
        loss_dispersion,
        tolerance,
        ..Machine::default()
    };
    let mut machine = empty.with(&patch).map_err(in_file)?;
    let effects = one_of_each(effects, &machine);
    let mut described = machine.clone();
    machine = with_contained(machine, &contained, &effects, without).map_err(in_file)?;
    let is_set = |key: &str| {
        stated.get("tolerance").and_then(|section| number(section.get(key)?)).is_some_and(|x| x != 0.0)
    };
    if let Some(idle) = machine.idle_tolerance(is_set) {
        return Err(in_file(fault(
            format!("tolerance.{idle}"),
            "the machine has no quantity with this tolerance; remove the key",
        )));
    }
    described.drop_unused_parameters();
    check_own_names(&own, &effects, (&described, &contained)).map_err(in_file)?;
    check_own_effects(&own, &effects, &machine, without).map_err(in_file)?;
    let unused = machine.drop_unused_parameters();
    let fitted_from = fitted.as_ref().map(|fitted| fitted.measurements_sha256.clone()).unwrap_or_default();
    if let Some(fitted) = fitted {
        machine = fitted.applied(&machine, !without.is_empty()).map_err(in_file)?;
    }
    let idle = idle_parameters(path, &unused, &effects);
    let implausible =
        implausible.into_iter().chain(check_parameters((&machine, &stated), is_stated).map_err(in_file)?);
    let implausible: Vec<String> = implausible.map(|warning| format!("{path}: {warning}")).collect();
    let warnings = renamed.into_iter().chain(implausible.clone()).chain(idle).collect();
    Ok(MachineConfig {
        warnings,
        implausible,
        path: path.into(),
        text: text.into(),
        machine,
        measurements,
        effects,
        fitted_from,
    })
}

/// Warns of parameters that nothing uses. A description may state the ranges of effects that it does not
/// contain, such as that of a drive that was off.
fn idle_parameters(path: &str, unused: &[String], effects: &[Effect]) -> Vec<String> {
    let of_effects: Vec<&str> =
        effects.iter().flat_map(|e| e.patch.parameters.iter().map(|p| p.id.as_str())).collect();
    let idle = unused.iter().filter(|id| !of_effects.contains(&id.as_str()));
    idle.map(|id| {
        format!("{path}: nothing uses [parameter.{id}]; name it in a joint, point or shaft, or remove it")
    })
    .collect()
}

/// Returns the machine with the effects that its file lists, without the removed ones and those that refine
/// them.
fn with_contained(
    mut machine: Machine,
    contained: &[String],
    effects: &[Effect],
    without: &[String],
) -> Result<Machine, MachineError> {
    let refines_removed =
        |effect: &Effect| effect.refines.as_ref().is_some_and(|refined| without.contains(refined));
    for id in contained.iter().filter(|id| !without.contains(id)) {
        let known = effects.iter().find(|e| e.id == *id);
        let effect = known.ok_or_else(|| fault("effects", unknown_effect(id, effects)))?;
        if !refines_removed(effect) {
            machine = machine.with_effect(effect)?;
        }
    }
    Ok(machine)
}

/// Checks that the effects of a file declare no parameter that the machine has without them: it would keep its
/// own unit and range.
fn check_own_names(
    own: &[Effect],
    all: &[Effect],
    (described, contained): (&Machine, &[String]),
) -> Result<(), MachineError> {
    for effect in own {
        let is_other = |e: &&Effect| e.id != effect.id && effect.refines.as_ref() != Some(&e.id);
        let others = all.iter().filter(|e| contained.contains(&e.id)).filter(is_other);
        let taken: Vec<&str> = others
            .flat_map(|e| &e.patch.parameters)
            .chain(&described.parameters)
            .map(|p| p.id.as_str())
            .collect();
        if let Some(parameter) = effect.patch.parameters.iter().find(|p| taken.contains(&p.id.as_str())) {
            return Err(fault(
                format!("effect «{}», parameter.{}", effect.id, parameter.id),
                "the machine has a parameter of this name; choose another name, or leave this section out to use that of the machine",
            ));
        }
    }
    Ok(())
}

/// Checks that the effects of a file refine known ones and suit the machine.
fn check_own_effects(
    own: &[Effect],
    all: &[Effect],
    machine: &Machine,
    without: &[String],
) -> Result<(), MachineError> {
    for effect in own {
        let others = || all.iter().map(|e| e.id.as_str()).filter(|id| *id != effect.id);
        if let Some(id) = effect.refines.as_deref().filter(|id| others().all(|other| other != *id)) {
            let known = others().collect::<Vec<_>>().join(", ");
            let remedy = format!("no other effect is called «{id}»; there are {known}");
            return Err(fault(format!("effect «{}», refines", effect.id), remedy));
        }
    }
    // A removed effect may have contained a part that another effect needs.
    for effect in own.iter().filter(|effect| without.is_empty() && !machine.effects.contains(&effect.id)) {
        let elsewhere = machine.missing_part(&Effect { at: None, ..effect.clone() }).is_some();
        if let Some(error) = machine.with_effect(effect).err().filter(|_| !elsewhere) {
            let remedy = format!("{error}; or list in its needs the parts that only other machines have");
            return Err(fault(format!("effect «{}»", effect.id), remedy));
        }
    }
    Ok(())
}

/// Former names of keys of an `[[effect]]` and of its `rescale` entries, which are still accepted, with their
/// present names.
const RENAMED: [(&str, &str); 6] = [
    ("says", "description"),
    ("separates", "discriminating_test"),
    ("like", "confusable_with"),
    ("like_slow", "confusable_with_slow"),
    ("ordinary", "common"),
    ("law", "modifier"),
];

/// Returns one warning with every key of the file that uses a former name; `None` where all keys are up to
/// date.
fn renamed_keys(path: &str, text: &str) -> Option<String> {
    let table: toml::Table = toml::from_str(text).ok()?;
    let entries = |value: &toml::Value, key: &str| {
        value.get(key).and_then(toml::Value::as_array).cloned().unwrap_or_default()
    };
    let effects = entries(&toml::Value::Table(table), "effect");
    let tables = effects
        .iter()
        .flat_map(|effect| entries(effect, "rescale"))
        .chain(effects.iter().cloned())
        .collect::<Vec<_>>();
    let found = RENAMED.iter().filter(|(old, _)| tables.iter().any(|table| table.get(old).is_some()));
    let found: Vec<String> = found.map(|(old, new)| format!("«{old}» is now «{new}»")).collect();
    (!found.is_empty()).then(|| {
        format!(
            "{path}: [[effect]] has keys under former names, which are still read: {}; rename them",
            found.join(", ")
        )
    })
}

/// Selects one variant of each effect and kind of data.
///
/// Variants of an effect share one id and serve machines described with different names. The variant with the
/// most needed parts in this machine is kept; where several remain, it comes first.
fn one_of_each(effects: Vec<Effect>, machine: &Machine) -> Vec<Effect> {
    let fits = |e: &Effect| if machine.missing_part(e).is_none() { 1 + e.needs.len() } else { 0 };
    let first = |id: &str| effects.iter().position(|e| e.id == id);
    let mut ordered: Vec<&Effect> = effects.iter().collect();
    ordered.sort_by_key(|e| (first(&e.id), Reverse(fits(e))));
    let mut kept: Vec<Effect> = Vec::with_capacity(ordered.len());
    for effect in ordered {
        let served = |data: &Data| kept.iter().any(|e| e.id == effect.id && e.data.contains(data));
        let data: Vec<Data> = effect.data.iter().copied().filter(|data| !served(data)).collect();
        if !data.is_empty() {
            kept.push(Effect { data, ..effect.clone() });
        }
    }
    kept
}

/// Parses TOML; errors carry file and line. Overrides change the keys before deserialization.
fn parse<T: DeserializeOwned>(path: &str, text: &str, overrides: Overrides<'_>) -> Result<T, ConfigError> {
    let syntax = |error: toml::de::Error| {
        let line = error.span().map_or(1, |span| text[..span.start.min(text.len())].lines().count().max(1));
        let line = if error.span().is_some_and(|s| text[..s.start.min(text.len())].ends_with('\n')) {
            line + 1
        } else {
            line
        };
        let written = text.lines().nth(line - 1).unwrap_or_default();
        // A decimal comma: 272,0 for 272.0.
        let value = written.split_once('=').map_or("", |(_, v)| v.split('#').next().unwrap_or(v)).trim();
        let comma =
            value.split_once(',').is_some_and(|(a, b)| [a, b].iter().all(|x| x.parse::<f64>().is_ok()));
        let hint = if comma { " (decimal comma? write a point)" } else { "" };
        ConfigError::Syntax { path: path.into(), line, fault: error.message().replace('\n', "; ") + hint }
    };
    if overrides.is_empty() {
        return toml::from_str(text).map_err(syntax);
    }
    let mut table: toml::Table = toml::from_str(text).map_err(syntax)?;
    for given in overrides {
        set(&mut table, given)?;
    }
    // Read again as text: a second deserializer, of tables, would be compiled for every section.
    let read = |table: &toml::Table| toml::from_str(&table.to_string());
    read(&table).map_err(|error| {
        // The faulty override is the first that fails alone.
        let alone = |given: &&String| {
            let mut table: toml::Table = toml::from_str(text).unwrap_or_default();
            set(&mut table, given).is_err() || read(&table).is_err()
        };
        let given = overrides.iter().find(alone).cloned().unwrap_or_else(|| overrides.join(" "));
        refused(&given, error.message().replace('\n', "; "))
    })
}

/// Returns the keys of a file as it states them, with overrides.
pub(super) fn stated_table(text: &str, overrides: Overrides<'_>) -> Result<toml::Table, ConfigError> {
    let mut table: toml::Table = toml::from_str(text).unwrap_or_default();
    overrides.iter().try_for_each(|given| set(&mut table, given))?;
    Ok(table)
}

/// Creates the error of an override that cannot be applied.
fn refused(given: &str, fault: impl Into<String>) -> ConfigError {
    ConfigError::Setting { key: "set", given: given.into(), fault: fault.into() }
}

/// Sets one key: `parameter.k_s.start=1e5`. Entries of lists are named by `name`, `id` or number:
/// `point.table.mass_kg=300`.
fn set(table: &mut toml::Table, given: &str) -> Result<(), ConfigError> {
    let refused = |fault: String| refused(given, fault);
    let (path, text) = given.split_once('=').ok_or_else(|| refused("write key.path=value".into()))?;
    let value: toml::Value = toml::from_str::<toml::Table>(&format!("v = {text}"))
        .ok()
        .and_then(|mut t| t.remove("v"))
        .unwrap_or_else(|| toml::Value::String(text.to_string()));
    let keys: Vec<&str> = path.trim().split('.').collect();
    let (last, parents) = keys.split_last().ok_or_else(|| refused("write key.path=value".into()))?;
    if let [section, id] = parents
        && *section == "parameter"
    {
        import_parameter(table, id, given)?;
    }
    if parents == ["tolerance"] {
        // The table is optional.
        table.entry("tolerance").or_insert_with(|| toml::Table::new().into());
    }
    let mut here = table;
    let mut index = 0;
    while index < parents.len() {
        let key = parents[index];
        let known: Vec<String> = here.keys().cloned().collect();
        let child = here.get_mut(key).ok_or_else(|| {
            refused(format!("there is no key «{key}» here; there are {}", known.join(", ")))
        })?;
        here = match child {
            toml::Value::Table(table) => table,
            toml::Value::Array(list) => {
                index += 1;
                let wanted = parents.get(index).ok_or_else(|| {
                    refused(format!("«{key}» is a list; name the entry, as in {key}.NAME.{last}=…"))
                })?;
                let names: Vec<String> = list.iter().map(entry_name).collect();
                let at = names
                    .iter()
                    .position(|n| n == wanted)
                    .or_else(|| wanted.parse::<usize>().ok().filter(|n| *n < list.len()))
                    .ok_or_else(|| {
                        refused(format!(
                            "no entry of «{key}» is called «{wanted}»; there are {}",
                            names.join(", ")
                        ))
                    })?;
                list[at].as_table_mut().ok_or_else(|| refused(format!("«{key}.{wanted}» has no keys")))?
            }
            _ => return Err(refused(format!("«{key}» is a value, not a table; name a key of a table"))),
        };
        index += 1;
    }
    here.insert((*last).to_string(), value);
    Ok(())
}

/// Copies a parameter into the table, so that one of its keys can be set.
///
/// It applies to parameters of library effects that the machine contains and that the table does not define.
///
/// Variants of an effect may use different units for the parameter; then the user has to declare it.
fn import_parameter(table: &mut toml::Table, id: &str, given: &str) -> Result<(), ConfigError> {
    if table.get("parameter").is_some_and(|parameters| parameters.get(id).is_some()) {
        return Ok(());
    }
    let Ok(library) = toml::from_str::<toml::Table>(EFFECTS) else { return Ok(()) };
    let effects = library.get("effect").and_then(toml::Value::as_array).into_iter().flatten();
    let all: Vec<(&toml::Value, &toml::Value)> =
        effects.filter_map(|e| Some((e.get("id")?, e.get("parameter")?.get(id)?))).collect();
    let contained = table.get("effects").and_then(toml::Value::as_array);
    let mut declared =
        all.iter().filter(|(effect, _)| contained.is_some_and(|c| c.contains(effect))).map(|(_, p)| *p);
    let Some(first) = declared.next() else {
        let Some((effect, _)) = all.first() else { return Ok(()) };
        let fault = format!(
            "«{id}» is a parameter of the effect {effect}, which the machine does not contain; add the effect's id to effects first"
        );
        return Err(refused(given, fault));
    };
    if declared.any(|other| other != first) {
        let fault = format!(
            "«{id}» has different units for different kinds of machines; declare it: parameter.{id}={{unit=…,start=…,lower=…,upper=…,source=…}}"
        );
        return Err(refused(given, fault));
    }
    let parameters = table.entry("parameter").or_insert_with(|| toml::Table::new().into());
    if let Some(parameters) = parameters.as_table_mut() {
        parameters.insert(id.to_string(), first.clone());
    }
    Ok(())
}

fn entry_name(entry: &toml::Value) -> String {
    ["name", "id"].iter().find_map(|k| entry.get(*k).and_then(toml::Value::as_str)).unwrap_or("?").to_string()
}
