//! A machine that contains another one fits no worse: with an effect more, the search finds at least what it finds
//! without.

use jointid::Study;
use machine::{Data, Effect};
use measurement::read_set;
use reference_simulator::{ordinary, write_case};
use test_data::draws;

/// Decrease of χ² (1) by which two ends of a search differ: a ratio of likelihoods of e^(1/4).
const IMPROVEMENT: f64 = 0.5;

/// Required: no fit of a drawn machine with an effect of the library ends above that of the machine without it. Each
/// machine tries one effect; the effects take turns.
#[test]
#[ignore = "long"]
fn recover_no_fit_above_that_of_a_simpler_machine() {
    let (mut fits, mut above) = (0, Vec::new());
    for number in 0..draws(4, 200) as usize {
        let simulated = ordinary(71_409, number).unwrap();
        let folder = tempfile::tempdir().unwrap();
        write_case(folder.path(), &simulated.case).unwrap();
        let path = folder.path().join("machine.toml").display().to_string();
        let cost = |effects: &[String]| {
            let config = config::read_machine(&path, &[format!("effects={effects:?}")], &[]).ok()?;
            let set = read_set(&folder.path().display().to_string()).unwrap();
            Some(Study::new(config, set).identify().unwrap().cost)
        };
        let described = config::read_machine(&path, &[], &[]).unwrap();
        let contained = described.machine.effects.clone();
        let more: Vec<&Effect> = Effect::for_data(&described.effects, Data::Frf)
            .filter(|effect| described.machine.with_effect(effect).is_ok())
            .collect();
        let effect = &more[number % more.len()].id;
        let (without, with) =
            (cost(&contained), cost(&[&contained[..], std::slice::from_ref(effect)].concat()));
        let Some((without, with)) = without.zip(with) else { continue };
        fits += 1;
        if with > without + IMPROVEMENT {
            println!("{number} {} {effect}: {with:.2} above {without:.2}", simulated.size);
            above.push((number, effect.clone()));
        }
    }
    println!("{} of {fits} fits end above that of the machine without the effect", above.len());
    assert!(fits > 0 && above.is_empty(), "{above:?}");
}
