//! `jointid lab replay`: stored facts judged again, by the rules as they are and with other numbers.

use std::path::PathBuf;

use crate::blind_check::replay::{
    Replayed, StoredCase, by_evidence, numbers, replay, stored_cases, with_number,
};
use cli::message::shown;
use cli::outcome::{CommandResult, Outcome, print_out};
use study::{Policy, rules};

/// Reads a number and its value.
fn setting(text: &str) -> Result<(String, f64), String> {
    let read = |(name, value): (&str, &str)| Some((name.to_string(), value.parse().ok()?));
    text.split_once('=').and_then(read).ok_or_else(|| "write NAME=VALUE, such as excess=3".into())
}

/// Arguments of `replay`.
#[derive(Debug, clap::Args)]
pub struct ReplayArguments {
    /// Folders of blind checks whose facts were kept
    #[arg(value_name = "FOLDER", required = true)]
    pub folders: Vec<PathBuf>,
    /// Other numbers of the policy, comma-separated
    #[arg(long, value_name = "NAME=VALUE", value_delimiter = ',', value_parser = setting)]
    pub set: Vec<(String, f64)>,
    /// Multiply each number of the policy in turn by this factor
    #[arg(long, value_name = "FACTOR", conflicts_with = "set")]
    pub times: Option<f64>,
    /// Judge by probabilities, too, in place of the rules
    #[arg(long)]
    pub evidence: bool,
    /// Rules to leave out, comma-separated
    #[arg(long, value_name = "RULES", value_delimiter = ',', value_parser = rules().collect::<Vec<_>>())]
    pub without: Vec<String>,
    /// Leave out each rule in turn
    #[arg(long)]
    pub each_rule: bool,
    /// List the cases whose verdict changes
    #[arg(long)]
    pub list: bool,
}

/// Runs the command.
pub fn run(given: &ReplayArguments) -> CommandResult {
    let mut cases: Vec<StoredCase> = Vec::new();
    for folder in &given.folders {
        cases.extend(stored_cases(folder).map_err(shown)?);
    }
    let known = numbers(&cases);
    if let Some((name, _)) = given.set.iter().find(|(name, _)| !known.contains(name)) {
        return Err(format!("--set {name}: no number has this name; there are {}", known.join(", ")));
    }
    let changed = |policy: &Policy| {
        given.set.iter().fold(policy.clone(), |policy, (name, value)| {
            with_number(&policy, name, |_| *value).unwrap_or(policy)
        })
    };
    let mut rows = vec![("as set".to_string(), replay(&cases, &given.without, changed))];
    if given.evidence {
        rows.push(("by evidence".into(), by_evidence(&cases)));
    }
    if given.each_rule {
        rows.extend(rules().map(|rule| {
            let left_out = [&given.without[..], &[rule.to_string()]].concat();
            (format!("without {rule}"), replay(&cases, &left_out, changed))
        }));
    }
    if let Some(factor) = given.times {
        rows.extend(known.into_iter().map(|name| {
            let changed = |policy: &Policy| {
                with_number(policy, &name, |own| own * factor).unwrap_or_else(|| policy.clone())
            };
            let found = replay(&cases, &given.without, changed);
            (name, found)
        }));
    }
    print_out(&table(&rows, given.list))?;
    Ok(Outcome::Done)
}

/// Returns the counts as a table.
fn table(rows: &[(String, Replayed)], list: bool) -> String {
    let mut text = format!(
        "{:<31} {:>5} {:>7} {:>4} {:>5} {:>6} {:>5} {:>9} {:>7} {:>7}\n",
        "", "cases", "changed", "open", "right", "better", "worse", "single", "alarms", "outside"
    );
    let of = |[part, all]: [usize; 2]| format!("{part} of {all}");
    for (name, found) in rows {
        text += &format!(
            "{name:<31} {:>5} {:>7} {:>4} {:>5} {:>6} {:>5} {:>9} {:>7} {:>7}\n",
            found.cases,
            found.changed.len(),
            found.open.len(),
            found.right,
            found.turned[0],
            found.turned[1],
            of(found.single),
            of(found.alarms),
            of(found.outside)
        );
        if list {
            text += &found.changed.iter().map(|line| format!("  {line}\n")).collect::<String>();
            text +=
                &found.open.iter().map(|name| format!("  {name}: facts are missing\n")).collect::<String>();
        }
    }
    text
}
