//! `jointid schema` and `jointid lab schema`.

use crate::message::to_message;
use crate::outcome::{CommandResult, Outcome, print_out};
use report::to_json;
use serde::Serialize;

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub struct SchemaArguments {
    /// Name of a file or document: machine, effects, manifest, identification, diagnosis, …
    #[arg(value_name = "NAME", required_unless_present = "list")]
    pub name: Option<String>,
    /// List the names
    #[arg(long, conflicts_with = "name")]
    pub list: bool,
}

/// Runs the command on the documents with these names.
pub fn run<S: Serialize>(
    given: &SchemaArguments,
    names: &[&str],
    schema: fn(&str) -> Option<S>,
) -> CommandResult {
    let Some(name) = &given.name else {
        print_out(&names.iter().map(|n| format!("{n}\n")).collect::<String>())?;
        return Ok(Outcome::Done);
    };
    let schema = schema(name)
        .ok_or_else(|| format!("schema {name}: no schema has this name; there are {}", names.join(", ")))?;
    print_out(&to_json(&schema).map_err(to_message)?)?;
    Ok(Outcome::Done)
}
