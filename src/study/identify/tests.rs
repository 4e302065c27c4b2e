//! Priors of joints, such as catalogue values, in identifications.

use crate::{Settings, Study, StudyResult};
use config::read_machine_text;
use measurement::{MeasurementSet, ModeObservation, ModeTable, Position};
use report::document::IdentificationDocument;
use report::vocabulary::PriorKind;

/// Identifies two springs side by side, of 2 and 3 N/µm, by the one frequency of their mass. The first may have
/// a prior.
fn identified(prior: &str, settings: Settings) -> StudyResult<IdentificationDocument> {
    let mut text = String::from(
        "title = \"two springs\"\neffects = []\n[[point]]\nname = \"m\"\nmotion = \"translation\"\nmass_kg = 10.0\n",
    );
    for (name, prior) in [("k1", prior), ("k2", "")] {
        text += &format!(
            "[[joint]]\nname = \"joint of {name}\"\nbetween = [\"m\", \"ground\"]\nstiffness = \"{name}\"\n\
             [parameter.{name}]\nunit = \"N/m\"\nstart = 4e6\nlower = 1e6\nupper = 1e7\n{prior}\n"
        );
    }
    let machine = read_machine_text("springs.toml", &text, &[], &[]).unwrap();
    let mode = ModeObservation {
        order: 1,
        frequency_hz: Some((5e6_f64 / 10.0).sqrt() / std::f64::consts::TAU),
        frequency_sd_hz: None,
        amplitude: None,
    };
    let set = MeasurementSet {
        response: Some("m".into()),
        excitation: Some("m".into()),
        positions: vec![Position { name: "p".into(), nut_m: None }],
        modes: Some(ModeTable { positions: vec![vec![mode]], resolution_hz: None, least_prominence: None }),
        ..MeasurementSet::none()
    };
    Study::new(machine, set).with_settings(settings).identify()
}

/// With what is known of one spring the frequency determines the other. The first remains a joint: it is
/// fitted, and no more identified than the catalogue knows it.
#[test]
fn recover_a_spring_by_the_catalogue_value_of_the_other() {
    let found = identified("prior = { value = 2e6, factor = 1.05 }", Settings::default()).unwrap();
    let (first, second) = (&found.parameters["k1"], &found.parameters["k2"]);
    assert!((first.value / 2e6 - 1.0).abs() < 0.01 && (second.value / 3e6 - 1.0).abs() < 0.01, "{found:#?}");
    assert!(
        first.fitted && first.identifiable == Some(false) && second.identifiable == Some(true),
        "{found:#?}"
    );
    let [low, high] = first.interval95.unwrap();
    assert!((1.05_f64.powf(2.0 * 1.96) / (high / low) - 1.0).abs() < 0.02, "{low} … {high}");
    let prior = first.prior.as_ref().unwrap();
    assert!(prior.kind == PriorKind::LogNormal && (prior.mean - 2e6).abs() < 1.0, "{prior:?}");
    assert!(second.prior.is_none() && found.tolerances.keys().all(|name| name != "k1"), "{found:#?}");

    let without = identified("", Settings::default()).unwrap();
    let open = &without.parameters["k1"];
    let [low, high] = open.interval95.unwrap();
    assert!(open.identifiable == Some(false) && open.prior.is_none() && high > 2.0 * low, "{without:#?}");
}

#[test]
fn refuse_a_prior_of_a_frozen_parameter() {
    let settings = Settings { freeze: vec!["k1".into()], ..Settings::default() };
    let fault = identified("prior = { value = 2e6, factor = 1.05 }", settings).unwrap_err().to_string();
    assert!(fault.contains("freeze") && fault.contains("parameter.k1.prior"), "{fault}");
}

/// The other spring as described leaves 1 N/µm for this one, whose catalogue says 2 N/µm within 5 %.
#[test]
fn a_prior_that_the_data_contradict_is_a_doubt() {
    let settings = Settings { freeze: vec!["k2".into()], ..Settings::default() };
    let found = identified("prior = { value = 2e6, factor = 1.05 }", settings.clone()).unwrap();
    let row = &found.parameters["k1"];
    let says = |texts: &[String]| {
        texts.iter().any(|text| text.contains("prior of k1, which the data contradict by -"))
    };
    assert!(row.identifiable != Some(true) && says(&found.stamp.warnings), "{found:#?}");
    assert!(!row.depends_on_discrepancy || says(&row.depends_on), "{row:?}");
    let agreed = identified("prior = { value = 1e6, factor = 1.05 }", settings).unwrap();
    assert!(!says(&agreed.stamp.warnings), "{agreed:#?}");
}

#[test]
fn a_prior_of_a_parameter_that_is_not_fitted_is_reported() {
    let found =
        identified("fit = \"frf\"\nprior = { value = 2e6, factor = 1.05 }", Settings::default()).unwrap();
    let says = |text: &String| text.starts_with("parameter.k1.prior has no effect: these data do not fit it");
    assert!(found.stamp.warnings.iter().any(says), "{:?}", found.stamp.warnings);
}
