//! `jointid simulate published`: figures that the papers of the lumped models print, beside ours.

mod servo;
mod twin;
mod vertical;

use std::fmt::Write;

use clap::Args;

use crate::arguments::Output;
use crate::delivery::{CommandResult, Outcome, deliver, prepare, told};
use config::{embedded_config, read_machine_text};
use machine::Machine;
use report::document::{Input, Stamp};
use report::simulation::{PublishedDocument, PublishedFigure};
use report::{digest, wrapped};

/// The configurations the figures are computed from.
const CONFIGS: [&str; 3] = ["configs/twin-ball-screw.toml", "configs/servo-axis.toml", "configs/vertical-axis.toml"];

/// `simulate published`.
#[derive(Debug, Args)]
pub struct PublishedArguments {
    /// Print the table as Markdown
    #[arg(long)]
    pub markdown: bool,
    #[command(flatten)]
    pub output: Output,
}

/// Runs the command.
pub fn run(given: &PublishedArguments) -> CommandResult {
    let folder = prepare(&given.output)?;
    let mut figures = twin::figures()?;
    figures.extend(servo::figures()?);
    figures.extend(vertical::figures()?);
    let text = if given.markdown { markdown(&figures) } else { plain(&figures) };
    let input = |path: &&str| embedded_config(path).map(|text| Input { path: (*path).into(), sha256: digest(text.as_bytes()) });
    let document = PublishedDocument {
        stamp: Stamp {
            schema: "jointid/published/1".into(),
            tool_version: env!("CARGO_PKG_VERSION").into(),
            seed: 1,
            complete: true,
            inputs: CONFIGS.iter().filter_map(input).collect(),
            overrides: Vec::new(),
            without: Vec::new(),
            warnings: Vec::new(),
        },
        figures,
    };
    deliver(&given.output, folder.as_ref(), "published.json", &document, &text)?;
    Ok(Outcome::Done)
}

/// A configuration that comes with the program, with overrides.
fn machine(path: &str, overrides: &[&str]) -> Result<Machine, String> {
    let text = embedded_config(path).ok_or_else(|| format!("{path}: does not come with the program"))?;
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_string()).collect();
    Ok(read_machine_text(path, text, &overrides, &[]).map_err(told)?.machine)
}

/// Where a figure is printed.
#[derive(Clone, Copy)]
struct Source {
    paper: &'static str,
    place: &'static str,
}

/// A figure that both sides have.
fn compared(source: Source, quantity: &str, unit: &str, (published, ours): (f64, f64), tolerance: f64, remark: &str) -> PublishedFigure {
    let difference = ours / published - 1.0;
    PublishedFigure {
        paper: source.paper.into(),
        place: source.place.into(),
        quantity: quantity.into(),
        unit: unit.into(),
        published: Some(published),
        ours: Some(ours),
        relative_difference: Some(difference),
        verdict: if difference.abs() <= tolerance { "agrees" } else { "differs" }.into(),
        remark: remark.into(),
    }
}

/// A figure that only we have: the paper prints a curve or a statement.
fn stated(source: Source, quantity: &str, unit: &str, ours: f64, holds: bool, remark: &str) -> PublishedFigure {
    PublishedFigure {
        published: None,
        relative_difference: None,
        verdict: if holds { "agrees" } else { "differs" }.into(),
        ..compared(source, quantity, unit, (1.0, ours), 0.0, remark)
    }
}

/// A figure of ours for which the paper prints neither number nor statement.
fn ours_alone(source: Source, quantity: &str, unit: &str, ours: f64, remark: &str) -> PublishedFigure {
    PublishedFigure { verdict: "not printed".into(), ..stated(source, quantity, unit, ours, true, remark) }
}

/// A figure that only the paper has.
fn unreachable(source: Source, quantity: &str, unit: &str, published: f64, remark: &str) -> PublishedFigure {
    PublishedFigure {
        ours: None,
        relative_difference: None,
        verdict: "not reproducible".into(),
        ..compared(source, quantity, unit, (published, 1.0), 0.0, remark)
    }
}

/// A number to four figures.
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

fn plain(figures: &[PublishedFigure]) -> String {
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
        "# Published figures of the lumped models, beside ours\n\n\
         Printed by `jointid simulate published --markdown`; nothing here is written by hand. «–»: the paper prints a curve or a\n\
         statement and no number, or ours does not exist. «agrees» means within 5 %, for Tab. 2 and for frequencies that were fitted or\n\
         held out within 2 %, for equations written out within 1e-8, for statements that they hold.\n",
    );
    let mut paper = "";
    for f in figures {
        if f.paper != paper {
            paper = &f.paper;
            let _ = writeln!(
                text,
                "\n## {paper}\n\n| where | what | unit | printed | ours | difference | | how, and why not |\n|---|---|---|---|---|---|---|---|"
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
