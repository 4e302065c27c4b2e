//! `jointid schema`.

use crate::outcome::{CommandResult, Outcome, print_out};
use config::{effects_schema, machine_schema};
use measurement::manifest_schema;
use report::{self, to_json};
use study::blind_check::WithheldDocument;

/// `schema`.
#[derive(Debug, clap::Args)]
pub struct SchemaArguments {
    /// Name of a file or document: machine, effects, manifest, identification, diagnosis, …
    #[arg(value_name = "NAME", required_unless_present = "list")]
    pub name: Option<String>,
    /// List the names
    #[arg(long, conflicts_with = "name")]
    pub list: bool,
}

/// Runs the command.
pub fn run(given: &SchemaArguments) -> CommandResult {
    let mut names = vec!["machine", "effects", "manifest"];
    names.extend(report::SCHEMAS);
    names.push("withheld");
    let Some(name) = &given.name else {
        print_out(&names.iter().map(|n| format!("{n}\n")).collect::<String>())?;
        return Ok(Outcome::Done);
    };
    let schema = match name.as_str() {
        "machine" => Some(machine_schema()),
        "effects" => Some(effects_schema()),
        "manifest" => Some(manifest_schema()),
        "withheld" => Some(schemars::schema_for!(WithheldDocument)),
        other => report::schema(other),
    };
    let schema = schema.ok_or_else(|| format!("schema {name}: no schema has this name; there are {}", names.join(", ")))?;
    print_out(&to_json(&schema)?)?;
    Ok(Outcome::Done)
}
