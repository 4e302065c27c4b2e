//! The library of effects as a document, and its text on a terminal.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::document::Stamp;
use super::terminal::{columns, figure, table, table_text, unit, width, wrapped};
use super::vocabulary::DataKind;

/// `effect-library.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectLibraryDocument {
    /// Provenance.
    #[serde(flatten)]
    pub stamp: Stamp,
    /// Effects in the order of the library. An effect written for machines described in different words has
    /// an entry for each.
    pub effects: Vec<EffectEntry>,
}

/// An effect of the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectEntry {
    /// Id.
    pub id: String,
    /// One sentence.
    pub description: String,
    /// What it looks like in measurements.
    pub signature: Option<String>,
    /// The measurement that distinguishes it from effects that look alike.
    pub discriminating_test: Option<String>,
    /// Kinds of data it shows in: `frf` (and modes), `motion`.
    pub data: Vec<DataKind>,
    /// Points, joints or shafts (by name) that a machine must have for it to apply; `drive` stands for its
    /// drive.
    pub needs: Vec<String>,
    /// Effect (id) that it describes in more detail; a machine must contain that for it to apply.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refines: Option<String>,
    /// Effects (ids) that force and one encoder do not distinguish from it.
    pub confusable_with: Vec<String>,
    /// Its parameters by id.
    pub parameters: BTreeMap<String, EffectParameter>,
}

/// A parameter of an effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectParameter {
    /// Unit.
    pub unit: String,
    /// Value at which the effect does next to nothing.
    pub start: f64,
    /// Lower end of the plausible range.
    pub lower: f64,
    /// Upper end of the plausible range.
    pub upper: f64,
    /// Origin of the range.
    pub source: String,
}

impl EffectEntry {
    /// The kinds of data in words.
    fn data_text(&self) -> String {
        let words = |kind: &DataKind| match kind {
            DataKind::Frf | DataKind::Modes => "FRFs, modes",
            DataKind::Motion => "motion",
        };
        self.data.iter().map(words).collect::<Vec<_>>().join(", ")
    }
}

/// Width (columns) from which on the list shows signatures and discriminating tests, too.
const WIDE: usize = 150;

/// The library as a table, one effect a row.
pub fn effects_table(document: &EffectLibraryDocument) -> String {
    let is_wide = width() >= WIDE;
    let more = is_wide.then_some(["Signature", "Discriminating test"]).into_iter().flatten();
    let mut out = table(["Effect", "Data", "Description"].into_iter().chain(more));
    out.column_iter_mut().for_each(|column| column.set_cell_alignment(comfy_table::CellAlignment::Left));
    let mut listed: Vec<(&str, String)> = Vec::new();
    for effect in &document.effects {
        let data = effect.data_text();
        if listed.contains(&(effect.id.as_str(), data.clone())) {
            continue;
        }
        let optional = |text: &Option<String>| text.clone().unwrap_or_default();
        let more = is_wide
            .then(|| [optional(&effect.signature), optional(&effect.discriminating_test)])
            .into_iter()
            .flatten();
        out.add_row([effect.id.clone(), data.clone(), effect.description.clone()].into_iter().chain(more));
        listed.push((&effect.id, data));
    }
    table_text(&out)
}

/// One effect whole; an effect written for machines described in different words form by form.
pub fn effect_text(document: &EffectLibraryDocument) -> String {
    let form = |effect: &EffectEntry| {
        let mut text = wrapped(&format!("{}: {}", effect.id, effect.description));
        let lists = [
            ("shows in", effect.data_text()),
            ("applies to machines with", effect.needs.join(", ")),
            ("describes in more detail", effect.refines.clone().unwrap_or_default()),
            ("signature", effect.signature.clone().unwrap_or_default()),
            ("discriminating test", effect.discriminating_test.clone().unwrap_or_default()),
            ("not distinguished by force and one encoder from", effect.confusable_with.join(", ")),
        ];
        for (head, content) in lists.iter().filter(|(_, content)| !content.is_empty()) {
            text += &wrapped(&format!("  {head}: {content}"));
        }
        let rows = effect.parameters.iter().map(|(id, p)| {
            let range = format!("{} … {}", figure(p.lower), figure(p.upper));
            vec![format!("  {id}"), unit(&p.unit), figure(p.start), range, p.source.clone()]
        });
        text + &columns(
            &["  parameter", "unit", "start", "range", "source of the range"].map(String::from),
            rows,
        )
    };
    document.effects.iter().map(form).collect::<Vec<_>>().join("\n")
}
