//! The whole command line: all commands, each with its arguments.

use clap::{CommandFactory, Parser, Subcommand};

use crate::compare::CompareArguments;
use crate::diagnose::DiagnoseArguments;
use crate::effects::EffectsArguments;
use crate::friction::FrictionArguments;
use crate::identify::IdentifyArguments;
use crate::import::{ExportArguments, ImportArguments};
use crate::init::InitArguments;
use crate::manual::{CompletionsArguments, ManArguments};
use crate::peaks::PeaksArguments;
use crate::plan::PlanArguments;
use crate::predict::PredictArguments;
use crate::report::ReportArguments;
use crate::schema::SchemaArguments;
use crate::simulate::SimulateArguments;
use crate::validate::ValidateArguments;

/// Identifies joint stiffness and damping of ball-screw feed drives, and diagnoses what their models lack
#[derive(Debug, Parser)]
#[command(
    name = "jointid",
    version,
    propagate_version = true,
    disable_help_subcommand = true,
    after_help = "Example, with the published bench that is built in:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results\n\nLists are comma-separated: --positions l1,l3,l5. «jointid COMMAND --help» explains a command."
)]
pub struct Arguments {
    /// Command to run
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Identify joint parameters, and predict held-out positions
    #[command(after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results")]
    Identify(IdentifyArguments),
    /// Check an identification at held-out positions or on another set
    #[command(
        after_help = "Example:\n  jointid validate --result results/identification.json --positions l2,l4,l6 --fail-above 0.03"
    )]
    Validate(ValidateArguments),
    /// Predict an identified machine at any position, with intervals
    #[command(
        after_help = "Example:\n  jointid predict --result results/identification.json --nut-m 0.4,0.8,1.2,1.6,2.0\n  jointid predict --result results/identification.json --positions l2,l4 --frf --out results"
    )]
    Predict(PredictArguments),
    /// Compare multi- with single-position fits, or two results
    #[command(
        after_help = "Example:\n  jointid compare --positions l1,l3,l5 --single l3,l5\n  jointid compare --results before/identification.json after/identification.json"
    )]
    Compare(CompareArguments),
    /// Find the effect that the model lacks, and what it closes
    #[command(
        after_help = "Example:\n  jointid diagnose --without rotor-hold --positions l1,l3,l5\n  jointid diagnose --config axis.toml --measurements axis --out results"
    )]
    Diagnose(DiagnoseArguments),
    /// Rank positions and responses by the intervals they would leave
    #[command(
        after_help = "Example:\n  jointid plan --choose 3 --data frf --noise 0.02\n  jointid plan --measured l1,l3 --channels table/table,rotor/table"
    )]
    Plan(PlanArguments),
    /// Extract natural frequencies from FRFs, and track them
    #[command(after_help = "Example:\n  jointid peaks --measurements bench --out bench-peaks")]
    Peaks(PeaksArguments),
    /// Make a measurement set from universal files or tables
    #[command(
        after_help = "Example:\n  jointid import tap.uff --list\n  jointid import tap.uff --out bench --pattern 'pos {}' --nut-m l1=0.6"
    )]
    Import(ImportArguments),
    /// Write the FRFs of a measurement set as a universal file
    #[command(after_help = "Example:\n  jointid export --measurements bench --out bench.uff")]
    Export(ExportArguments),
    /// Fit a Stribeck curve to friction at constant velocities
    #[command(after_help = "Example:\n  jointid friction --data axis-1.csv --lead-m 0.005 --efficiency 0.9")]
    Friction(FrictionArguments),
    /// Compute modes, FRFs, stiffness and motion of a machine
    #[command(
        after_help = "Example:\n  jointid simulate modes --config configs/tian-as-published.toml --position l1"
    )]
    Simulate(SimulateArguments),
    /// List the library of effects, or show one of them
    #[command(after_help = "Example:\n  jointid effects\n  jointid effects rotor-hold")]
    Effects(EffectsArguments),
    /// Make one self-contained HTML page from the results in a folder
    #[command(
        after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results"
    )]
    Report(ReportArguments),
    /// Write a commented machine and an empty set to fill in
    #[command(after_help = "Example:\n  jointid init my-axis")]
    Init(InitArguments),
    /// Print the JSON Schema of a file or result document
    #[command(
        after_help = "Example:\n  jointid schema machine > machine.schema.json\n  jointid schema --list"
    )]
    Schema(SchemaArguments),
    /// Print shell completions
    #[command(
        after_help = "Example:\n  jointid completions bash > ~/.local/share/bash-completion/completions/jointid\n  jointid completions zsh > ~/.zfunc/_jointid"
    )]
    Completions(CompletionsArguments),
    /// Write man pages
    #[command(after_help = "Example:\n  jointid man --out ~/.local/share/man/man1")]
    Man(ManArguments),
    /// Examine the method, and repeat the papers: «jointid lab --help»
    #[command(disable_help_flag = true)]
    Lab(LabArguments),
}

/// A command of the laboratory and its arguments, which the laboratory's program reads.
#[derive(Debug, clap::Args)]
pub struct LabArguments {
    /// Command of the laboratory and its arguments
    #[arg(value_name = "COMMAND", trailing_var_arg = true, allow_hyphen_values = true)]
    pub words: Vec<std::ffi::OsString>,
}

/// Column at which the description of a command begins.
const ABOUT_COLUMN: usize = 15;
/// Greatest width (columns) of help texts.
const HELP_WIDTH: usize = 100;

/// A heading of the help, and the commands below it.
pub type Group = (&'static str, &'static [&'static str]);

/// The commands by heading, those that a user needs first in front.
const COMMANDS: [Group; 5] = [
    ("Identify and diagnose", &["identify", "validate", "predict", "compare", "diagnose", "plan"]),
    ("Measurements", &["peaks", "import", "export", "friction"]),
    ("Models", &["simulate", "effects"]),
    ("Files and pages", &["init", "report", "schema", "completions", "man"]),
    ("Laboratory", &["lab"]),
];

/// The commands below `simulate` by heading.
const SIMULATIONS: [Group; 2] =
    [("Structure", &["modes", "frf", "stiffness"]), ("Driven axis", &["motion", "bode", "hold"])];

/// The command line, with commands listed by heading.
pub fn command() -> clap::Command {
    grouped(Arguments::command(), &COMMANDS)
        .mut_subcommand("simulate", |command| grouped(command.disable_help_subcommand(true), &SIMULATIONS))
}

/// Lists the commands below a command by heading in its help.
pub fn grouped(command: clap::Command, groups: &[Group]) -> clap::Command {
    let width = report::width().min(HELP_WIDTH);
    let command = command.term_width(width);
    let header = *command.get_styles().get_header();
    let name = command.get_styles().get_literal();
    let line = |id: &&str| {
        let about = command
            .find_subcommand(id)
            .and_then(clap::Command::get_about)
            .map(ToString::to_string)
            .unwrap_or_default();
        format!("  {name}{id:<12}{name:#} {}\n", indented(&about, (ABOUT_COLUMN, width)))
    };
    let list = |(heading, ids): &Group| {
        format!("{header}{heading}:{header:#}\n{}\n", ids.iter().map(line).collect::<String>())
    };
    let lists: String = groups.iter().map(list).collect();
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{lists}{header}Options:{header:#}\n{{options}}{{after-help}}"
    ))
}

/// Wraps a text that begins at a column between words, so that no line is wider than a width.
fn indented(text: &str, (column, width): (usize, usize)) -> String {
    let (mut out, mut at) = (String::new(), column);
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if !out.is_empty() && at + 1 + length > width {
            out += &format!("\n{:column$}{word}", "");
            at = column + length;
        } else {
            let blank = if out.is_empty() { "" } else { " " };
            out += &format!("{blank}{word}");
            at += blank.len() + length;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_are_wrapped_between_words() {
        let about = "Identify joint parameters, and predict held-out positions";
        for width in [40, 60, 80] {
            let text = format!("  identify     {}", indented(about, (ABOUT_COLUMN, width)));
            assert!(text.lines().all(|line| line.chars().count() <= width), "{text}");
            assert_eq!(text.split_whitespace().skip(1).collect::<Vec<_>>().join(" "), about);
        }
    }

    fn listed(groups: &[Group]) -> Vec<&'static str> {
        let mut ids: Vec<&str> = groups.iter().flat_map(|(_, ids)| ids.iter().copied()).collect();
        ids.sort_unstable();
        ids
    }

    #[test]
    fn every_command_stands_under_a_heading_and_in_one_line() {
        let root = command();
        for (of, groups) in
            [(&root, &COMMANDS[..]), (root.find_subcommand("simulate").unwrap(), &SIMULATIONS[..])]
        {
            let mut known: Vec<&str> = of.get_subcommands().map(clap::Command::get_name).collect();
            known.sort_unstable();
            assert_eq!(listed(groups), known);
            for sub in of.get_subcommands() {
                let about = sub.get_about().unwrap().to_string();
                assert!(about.chars().count() <= 65, "{}: {about}", sub.get_name());
            }
        }
    }
}
