//! The whole command line: all commands, each with its arguments.

use clap::{Parser, Subcommand};

use crate::compare::CompareArguments;
use crate::convergence::ConvergenceArguments;
use crate::diagnose::arguments::DiagnoseArguments;
use crate::friction::FrictionArguments;
use crate::hybrid::HybridArguments;
use crate::identify::arguments::IdentifyArguments;
use crate::import::{ExportArguments, ImportArguments};
use crate::init::InitArguments;
use crate::manual::{CompletionsArguments, ManArguments};
use crate::peaks::PeaksArguments;
use crate::plan::PlanArguments;
use crate::report::ReportArguments;
use crate::schema::SchemaArguments;
use crate::simulate::SimulateArguments;
use crate::validate::arguments::ValidateArguments;
use crate::withheld::arguments::WithheldArguments;

/// Joint stiffness and damping of ball-screw feed drives from hammer tests.
#[derive(Debug, Parser)]
#[command(
    name = "jointid",
    version,
    max_term_width = 80,
    propagate_version = true,
    after_help = "Example, with the published bench that comes with the program:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results"
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Identify joint parameters from some positions and predict the others
    #[command(after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results")]
    Identify(IdentifyArguments),
    /// Check an identification at held-out positions, or on another set
    #[command(after_help = "Example:\n  jointid validate --result results/identification.json --positions l2,l4,l6 --fail-above 0.03")]
    Validate(ValidateArguments),
    /// Set multi-position against single-position identification
    #[command(after_help = "Example:\n  jointid compare --positions l1,l3,l5 --single l3,l5")]
    Compare(CompareArguments),
    /// Say where model and machine disagree, which effect is missing, and how far the gap closes
    #[command(
        after_help = "Example:\n  jointid diagnose --without rotor-hold --positions l1,l3,l5\n  jointid diagnose --config axis.toml --measurements axis --out results"
    )]
    Diagnose(DiagnoseArguments),
    /// Make a measurement set of universal files or tables
    #[command(
        after_help = "Example:\n  jointid import tap.uff --list\n  jointid import tap.uff --out bench --pattern 'pos {}' --nut-m l1=0.6"
    )]
    Import(ImportArguments),
    /// Write the FRFs of a measurement set as a universal file
    #[command(after_help = "Example:\n  jointid export --measurements bench --out bench.uff")]
    Export(ExportArguments),
    /// Take natural frequencies from FRFs and track them across positions
    #[command(after_help = "Example:\n  jointid peaks --measurements bench --out bench-peaks")]
    Peaks(PeaksArguments),
    /// Rank positions and responses by what measuring them would tell
    #[command(
        after_help = "Example:\n  jointid plan --choose 3 --data frf --noise 0.02\n  jointid plan --measured l1,l3 --channels table/table,rotor/table"
    )]
    Plan(PlanArguments),
    /// Set the lumped model against the exact one, for several numbers of lumps
    #[command(after_help = "Example:\n  jointid convergence --positions l1,l3,l5 --counts 5,10,20,40")]
    Convergence(ConvergenceArguments),
    /// Fit a Stribeck curve to friction measured at constant velocities
    #[command(after_help = "Example:\n  jointid friction --data axis-1.csv --lead-m 0.005 --efficiency 0.9")]
    Friction(FrictionArguments),
    /// Make one page that can be read anywhere of the results in a folder
    #[command(after_help = "Example:\n  jointid identify --positions l1,l3,l5 --out results\n  jointid report results")]
    Report(ReportArguments),
    /// Begin with a machine of your own: a commented configuration and an empty measurement set
    #[command(after_help = "Example:\n  jointid init my-axis")]
    Init(InitArguments),
    /// Print the JSON Schema of a file or result document
    #[command(after_help = "Example:\n  jointid schema machine > machine.schema.json\n  jointid schema --list")]
    Schema(SchemaArguments),
    /// Print the completions of a shell
    #[command(
        after_help = "Example:\n  jointid completions bash > ~/.local/share/bash-completion/completions/jointid\n  jointid completions zsh > ~/.zfunc/_jointid"
    )]
    Completions(CompletionsArguments),
    /// Write the manual pages
    #[command(after_help = "Example:\n  jointid man --out ~/.local/share/man/man1")]
    Man(ManArguments),
    /// Compute modes, FRFs, stiffness and sensitivity of a machine
    #[command(after_help = "Example:\n  jointid simulate modes --config configs/tian-as-published.toml --position l1")]
    Simulate(SimulateArguments),
    /// Foretell a record's motion by the model, by a network on what it leaves, and by what was named
    #[command(
        after_help = "Example:\n  jointid simulate machine --out machine\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/sines\n  jointid hybrid --config configs/hybrid-axis.toml --measurements machine/circles/x --second-axis machine/circles/y"
    )]
    Hybrid(HybridArguments),
    /// Check the diagnosis blindly on cases whose causes are sealed
    #[command(
        after_help = "Example:\n  jointid withheld --out blind --cases quick\n  jointid withheld --out moved --arm motion\n  jointid withheld --out blind --ablation '--exclude table-mass'"
    )]
    Withheld(WithheldArguments),
}
