//! The published figures as text and as a Markdown page.

use std::fmt::Write;

use super::published::{FigureCount, PublishedDocument, PublishedFigure};
use report::wrapped;

/// Returns published figures and ours as text, by paper, with the count of figures below.
pub fn published_text(document: &PublishedDocument) -> String {
    let mut text = String::new();
    let mut paper = "";
    for f in &document.figures {
        if f.paper != paper {
            let _ = writeln!(text, "{}{}", if paper.is_empty() { "" } else { "\n" }, f.paper);
            paper = &f.paper;
        }
        text += &wrapped(&format!("  {}: {} ({})", f.place, f.quantity, f.unit));
        let values = format!(
            "printed {}, as printed {}, mended {}",
            number(f.published),
            number(f.as_printed),
            number(f.mended)
        );
        let _ = writeln!(text, "    {values}, {}: {}", difference(f), f.verdict.word());
        text += &wrapped(&format!("    {}", f.remark));
    }
    text + "\n" + &counts(document, "")
}

/// Returns published figures and ours as a Markdown page, with a table for each paper.
pub fn published_markdown(document: &PublishedDocument) -> String {
    let mut text = String::from(
        "# Published figures, compared with ours\n\n\
         Printed by `jointid lab published --markdown`; nothing here is written by hand. «As printed»: our code with the equations\n\
         and numbers that the paper prints. «Mended»: our code once the cause of the difference is mended; «–» where nothing is to be\n\
         mended, or no cause is known. The difference is that of «mended», else that of «as printed», from the printed number. «Within\n\
         rounding»: off by more than 2 %, but by no more than half a unit of the last printed digit, or than the rounding of the printed\n\
         numbers that it is computed from.\n\n",
    );
    text += &counts(document, "- ");
    let mut paper = "";
    for f in &document.figures {
        if f.paper != paper {
            paper = &f.paper;
            let _ = writeln!(
                text,
                "\n## {paper}\n\n| source | quantity | unit | printed | as printed | mended | difference | | method, and cause of a difference |\n|---|---|---|---|---|---|---|---|---|"
            );
        }
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            f.place,
            f.quantity,
            f.unit,
            number(f.published),
            number(f.as_printed),
            number(f.mended),
            difference(f),
            f.verdict.word(),
            f.remark
        );
    }
    text
}

/// Returns a line for each paper, in the order of the figures, and one for all.
fn counts(document: &PublishedDocument, bullet: &str) -> String {
    let mut papers: Vec<&str> = document.figures.iter().map(|f| f.paper.as_str()).collect();
    papers.dedup();
    let line = |name: &str| {
        let FigureCount { printed, as_printed, mended, within_rounding } =
            document.count.get(name).copied().unwrap_or_default();
        let share = if printed > 0 { 100.0 * mended as f64 / printed as f64 } else { 0.0 };
        let both = if printed > 0 { 100.0 * (mended + within_rounding) as f64 / printed as f64 } else { 0.0 };
        let head = if name == "all" { "all papers" } else { name };
        let text = format!(
            "{bullet}{head}: {printed} figures with a printed number; within 2 % as printed {as_printed}, mended {mended} ({share:.0} %), {within_rounding} \
             more within rounding ({both:.0} % together)\n"
        );
        if bullet.is_empty() { wrapped(text.trim_end()) } else { text }
    };
    papers.into_iter().chain(["all"]).map(line).collect()
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
