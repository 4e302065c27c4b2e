//! `jointid simulate published`: published figures of the lumped models, compared with ours.

mod figure;
mod servo;
mod twin;
mod vertical;

use std::fmt::Write;

use self::figure::CONFIGS;
use crate::arguments::OutputArguments;
use crate::outcome::{CommandResult, deliver, prepare};
use crate::sources::stamp_files;
use config::embedded_config;
use report::document::{Input, Stamp};
use report::simulation::{PublishedDocument, PublishedFigure};
use report::{digest, wrapped};

/// Arguments of `simulate published`.
#[derive(Debug, clap::Args)]
pub struct PublishedArguments {
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// Runs the command.
pub fn run(given: &PublishedArguments) -> CommandResult {
    let folder = prepare(&given.output)?;
    let mut figures = twin::figures()?;
    figures.extend(servo::figures()?);
    figures.extend(vertical::figures()?);
    let text = if given.markdown { markdown(&figures) } else { plain_text(&figures) };
    let input = |path: &&str| embedded_config(path).map(|text| Input { path: (*path).into(), sha256: digest(text.as_bytes()) });
    let document = PublishedDocument {
        stamp: Stamp { seed: 1, ..stamp_files("published", CONFIGS.iter().filter_map(input).collect(), Vec::new()) },
        figures,
    };
    deliver(&given.output, folder.as_ref(), "published.json", &document, &text)
}

/// Formats a number to four significant digits.
fn number(x: Option<f64>) -> String {
    match x {
        None => "–".into(),
        Some(x) if x != 0.0 && !(1e-3..1e5).contains(&x.abs()) => format!("{x:.3e}"),
        Some(x) => {
            let digits = (3.0 - x.abs().max(1e-9).log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{x:.digits$}")
        }
    }
}

fn difference(figure: &PublishedFigure) -> String {
    figure.relative_difference.map_or_else(|| "–".into(), |d| format!("{:+.1} %", 100.0 * d))
}

fn plain_text(figures: &[PublishedFigure]) -> String {
    let mut text = String::new();
    let mut paper = "";
    for f in figures {
        if f.paper != paper {
            let _ = writeln!(text, "{}{}", if paper.is_empty() { "" } else { "\n" }, f.paper);
            paper = &f.paper;
        }
        text += &wrapped(&format!("  {}: {} ({})", f.place, f.quantity, f.unit));
        let _ = writeln!(text, "    printed {}, ours {}, {}: {}", number(f.published), number(f.ours), difference(f), f.verdict);
        text += &wrapped(&format!("    {}", f.remark));
    }
    text
}

fn markdown(figures: &[PublishedFigure]) -> String {
    let mut text = String::from(
        "# Published figures of the lumped models, compared with ours\n\n\
         Printed by `jointid simulate published --markdown`; nothing here is written by hand. «–»: the paper prints a curve or a\n\
         statement and no number, or ours does not exist. «agrees» means within 5 %; within 2 % for Tab. 2 and for fitted or held-out\n\
         frequencies; within 1e-8 for equations written out; for statements, that they hold.\n",
    );
    let mut paper = "";
    for f in figures {
        if f.paper != paper {
            paper = &f.paper;
            let _ = writeln!(
                text,
                "\n## {paper}\n\n| source | quantity | unit | printed | ours | difference | | method, and reason for a difference |\n|---|---|---|---|---|---|---|---|"
            );
        }
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} |",
            f.place,
            f.quantity,
            f.unit,
            number(f.published),
            number(f.ours),
            difference(f),
            f.verdict,
            f.remark
        );
    }
    text
}
