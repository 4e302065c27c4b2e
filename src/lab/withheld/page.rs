//! The page of scores of one or several blind checks, in Markdown.

use std::fmt::Write as _;

use serde::Deserialize;

use super::breakdown::SingleScore;
use super::document::SealRow;
use super::proportion::Proportion;
use super::score::Scores;
use super::text::confusion_text;

/// What the page needs of `withheld.json`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct PageColumn {
    /// Whether all cases are diagnosed.
    pub complete: bool,
    /// Seal of the cases.
    pub seal: SealRow,
    /// Folders of the seal.
    pub sealed_cases: usize,
    /// Cases of the plan that could not be made, with reasons.
    pub not_made: Vec<String>,
    /// Scores.
    pub scores: Scores,
}

/// A row of the summary: its name and its score.
type Row = (&'static str, fn(&Scores) -> Proportion);

/// The ten rows of the summary.
const SUMMARY: [Row; 10] = [
    ("machines without an effect: an effect is named", |s| s.false_name_ordinary),
    ("single effects from 200: a discrepancy is reported", |s| size(s, "from 200", |row| row.reported)),
    ("single effects from 20: named alone", |s| visible(s, |row| row.exact)),
    ("the same: alone or in a set", |s| visible(s, |row| row.class)),
    ("the same: only other effects named", |s| visible(s, |row| row.misnamed)),
    ("single effects below 20: named alone, or none", |s| size(s, "0-20", |row| row.right)),
    ("verdicts that name one effect and are right", |s| s.selective),
    ("kinds of outside causes that never get a library's name", |s| s.outside.kinds_never_misnamed),
    ("faulty channels or records reported as such", |s| s.bad_channel),
    ("location right, effects of the library", |s| s.location.interface),
];

fn size(scores: &Scores, range: &str, of: fn(&SingleScore) -> Proportion) -> Proportion {
    scores.by_size.get(range).map_or(Proportion::new(0, 0), of)
}

/// Joins the ranges from 20 on.
fn visible(scores: &Scores, of: fn(&SingleScore) -> Proportion) -> Proportion {
    let rows = scores.by_size.iter().filter(|(range, _)| *range != "0-20").map(|(_, row)| of(row));
    let (count, all) = rows.fold((0, 0), |(count, all), row| (count + row.count, all + row.of));
    Proportion::new(count, all)
}

/// Formats a proportion with its exact interval.
fn cell(of: &Proportion) -> String {
    match of.interval95 {
        Some([low, high]) => format!("{} of {} ({:.0}–{:.0} %)", of.count, of.of, 100.0 * low, 100.0 * high),
        None => "–".into(),
    }
}

impl PageColumn {
    fn title(&self) -> String {
        let generator = &self.seal.generator;
        let truth = if generator.truth == "own" { ", truth of the models" } else { "" };
        let layout =
            generator.layout.as_ref().map_or_else(String::new, |layout| format!(", layout {layout}"));
        let stopped = if self.complete { "" } else { ", not all diagnosed" };
        format!(
            "{}, seed {}{layout}{truth}, {} folders{stopped}",
            generator.arm, generator.seed, self.sealed_cases
        )
    }
}

/// Formats a table; its rows are cut into columns by the caller.
fn table(page: &mut String, head: &[String], rows: Vec<Vec<String>>) {
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    *page += &line(head);
    *page += &format!("|{}\n", "---|".repeat(head.len()));
    for row in rows {
        *page += &line(&row);
    }
    page.push('\n');
}

fn head(first: &str, others: &[&str]) -> Vec<String> {
    std::iter::once(first).chain(others.iter().copied()).map(str::to_owned).collect()
}

/// Formats the page: ten rows for all checks, then size, effect, layout, kinds of outside causes, confusion
/// matrix and what could not be made for each.
pub fn scores_page(columns: &[PageColumn]) -> String {
    let mut page = String::from(
        "# Scores of the blind check\n\nIntervals: 95 %, Clopper and Pearson. Sizes: non-centrality at the given positions after a fit of joints and tolerances.\n\n",
    );
    let titles: Vec<String> =
        std::iter::once(String::new()).chain(columns.iter().map(PageColumn::title)).collect();
    let row = |(name, of): &Row| {
        std::iter::once((*name).to_owned())
            .chain(columns.iter().map(|column| cell(&of(&column.scores))))
            .collect()
    };
    table(&mut page, &titles, SUMMARY.iter().map(row).collect());
    for column in columns {
        let scores = &column.scores;
        let _ = writeln!(page, "## {}\n", column.title());
        let names = ["reported", "named alone", "in a set", "only others named", "right"];
        for (first, groups) in [
            ("single effects, size", &scores.by_size),
            ("single effects and look-alikes, from 20", &scores.by_effect),
        ] {
            let rows = groups.iter().map(|(group, row)| {
                let cells = [&row.reported, &row.exact, &row.class, &row.misnamed, &row.right].map(cell);
                std::iter::once(group.clone()).chain(cells).collect()
            });
            table(&mut page, &head(first, &names), rows.collect());
        }
        if !scores.by_layout.is_empty() {
            let rows = scores.by_layout.iter().map(|(layout, row)| {
                let cells = [&row.false_name, &row.exact, &row.class, &row.selective, &row.outside_misnamed]
                    .map(cell);
                [layout.clone(), row.cases.to_string()].into_iter().chain(cells).collect()
            });
            let names = [
                "cases",
                "named without an effect",
                "named alone, from 20",
                "in a set, from 20",
                "one name, right",
                "outside causes named",
            ];
            table(&mut page, &head("layout", &names), rows.collect());
        }
        let rows = scores.outside.by_kind.iter().map(|(kind, row)| {
            let cells = [&row.unknown, &row.misnamed, &row.imitated].map(cell);
            std::iter::once(kind.clone()).chain(cells).collect()
        });
        let names = ["verdict unknown", "named by the library", "imitated by an effect of the library"];
        table(&mut page, &head("outside cause", &names), rows.collect());
        let _ = writeln!(page, "```text\n{}```\n", confusion_text(&scores.confusion));
        if !column.not_made.is_empty() {
            let _ = writeln!(page, "Not made: {} cases of the plan.\n", column.not_made.len());
            for reason in &column.not_made {
                let _ = writeln!(page, "- {reason}");
            }
            page.push('\n');
        }
    }
    page
}
