//! Patches applied and checked: names resolved, numbers sensible.

use std::collections::HashSet;

use thiserror::Error;

use super::effect::{DerivedPatch, JointPatch, Patch, PointPatch, ShaftPatch, Target};
use super::{Base, Derivation, Derived, Effect, Joint, Law, Machine, Operating, Parameter, Point, Rescale, Scale, Shaft, Station, Value};

/// What is wrong with a description; the text says what to write instead.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{part}: {fault}")]
pub struct MachineError {
    /// Where, for example `joint.nut.stiffness`.
    pub part: String,
    /// What was found and what to write instead.
    pub fault: String,
}

pub(super) fn fault(part: impl Into<String>, fault: impl Into<String>) -> MachineError {
    MachineError { part: part.into(), fault: fault.into() }
}

pub(super) fn listing<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "there are none".into() } else { format!("there are {}", names.join(", ")) }
}

impl Machine {
    /// The machine with a patch applied, checked.
    ///
    /// # Errors  an unknown or repeated name, a range with lower ≥ upper, a number out of its physical range.
    pub fn with(&self, patch: &Patch) -> Result<Machine, MachineError> {
        let mut machine = self.clone();
        for parameter in &patch.parameters {
            check_parameter(parameter)?;
            if machine.parameter(&parameter.id).is_none() {
                machine.parameters.push(parameter.clone());
            }
        }
        patch.contacts.iter().try_for_each(|contact| machine.add_contact(contact))?;
        patch.segments.iter().try_for_each(|segment| machine.add_segment(segment))?;
        for point in &patch.points {
            let point = machine.resolve_point_patch(point)?;
            machine.points.push(point);
        }
        for shaft in &patch.shafts {
            let shaft = machine.resolve_shaft_patch(shaft)?;
            machine.shafts.push(shaft);
        }
        for joint in &patch.joints {
            let joint = machine.resolve_joint_patch(joint)?;
            machine.joints.push(joint);
        }
        for (target, rescale, parameter) in &patch.rescales {
            machine.rescale(target, *rescale, parameter)?;
        }
        for (name, from) in &patch.derived {
            let from = machine.resolve_derived(name, from)?;
            machine.derived.push(Derived { name: name.clone(), from });
        }
        machine.check()?;
        Ok(machine)
    }

    /// The machine with an effect applied and listed among its effects.
    ///
    /// # Errors  as [`Machine::with`]; the machine contains the effect already, or lacks what it needs.
    pub fn with_effect(&self, effect: &Effect) -> Result<Machine, MachineError> {
        if self.effects.contains(&effect.id) {
            return Err(fault(format!("effect {}", effect.id), "the machine contains it already"));
        }
        if let Some(name) = self.lacks(effect) {
            return Err(fault(format!("effect {}", effect.id), format!("it does not apply: the machine has no «{name}»")));
        }
        let mut machine = self.with(&effect.patch)?;
        machine.effects.push(effect.id.clone());
        Ok(machine)
    }

    /// Takes out parameters that nothing depends on, such as those of an effect that was taken out.
    /// Gives their ids.
    pub fn drop_unused_parameters(&mut self) -> Vec<String> {
        let mut used: Vec<bool> = vec![false; self.parameters.len()];
        self.values().for_each(|v| v.depends_on().for_each(|i| used[i] = true));
        let mut next = 0;
        let moved: Vec<usize> = used
            .iter()
            .map(|u| {
                next += usize::from(*u);
                next - usize::from(*u)
            })
            .collect();
        self.values_mut().for_each(|v| v.renumber(&moved));
        self.derived.retain(|d| !matches!(d.from, Derivation::Parameter(index) if !used[index]));
        for derived in &mut self.derived {
            if let Derivation::Parameter(index) = &mut derived.from {
                *index = moved[*index];
            }
        }
        let dropped = self.parameters.iter().zip(&used).filter(|(_, used)| !**used).map(|(p, _)| p.id.clone()).collect();
        let mut keep = used.iter();
        self.parameters.retain(|_| *keep.next().unwrap_or(&true));
        dropped
    }

    fn values(&self) -> impl Iterator<Item = &Value> {
        let points = self.points.iter().map(|p| &p.inertia);
        let shafts =
            self.shafts.iter().flat_map(|s| [&s.length, &s.diameter, &s.youngs_modulus, &s.shear_modulus, &s.density, &s.loss_factor]);
        let joints =
            self.joints.iter().flat_map(|j| [&j.stiffness, &j.damping, &j.loss_factor].into_iter().chain(j.relaxation_stiffness.as_ref()));
        points.chain(shafts).chain(joints).chain([&self.chain.gain, &self.chain.delay, &self.chain.power])
    }

    fn values_mut(&mut self) -> impl Iterator<Item = &mut Value> {
        let points = self.points.iter_mut().map(|p| &mut p.inertia);
        let shafts = self.shafts.iter_mut().flat_map(|s| {
            [&mut s.length, &mut s.diameter, &mut s.youngs_modulus, &mut s.shear_modulus, &mut s.density, &mut s.loss_factor]
        });
        let joints = self
            .joints
            .iter_mut()
            .flat_map(|j| [&mut j.stiffness, &mut j.damping, &mut j.loss_factor].into_iter().chain(j.relaxation_stiffness.as_mut()));
        points.chain(shafts).chain(joints).chain([&mut self.chain.gain, &mut self.chain.delay, &mut self.chain.power])
    }

    /// The first thing an effect needs that the machine lacks.
    pub fn lacks<'e>(&self, effect: &'e Effect) -> Option<&'e str> {
        effect
            .needs
            .iter()
            .find(|name| {
                self.point(name).is_none() && !self.joints.iter().any(|j| j.name == **name) && !self.shafts.iter().any(|s| s.name == **name)
            })
            .map(String::as_str)
    }

    fn named_point(&self, part: &str, name: &str) -> Result<usize, MachineError> {
        self.point(name).ok_or_else(|| {
            let known = listing(self.points.iter().map(|p| p.name.as_str()));
            fault(part, format!("no point is called «{name}»; {known} (and ground)"))
        })
    }

    fn resolve_point_patch(&self, patch: &PointPatch) -> Result<Point, MachineError> {
        let part = format!("point.{}", patch.name);
        if patch.name == "ground" {
            return Err(fault(part, "«ground» is there already and cannot be declared; choose another name"));
        }
        if self.point(&patch.name).is_some() {
            return Err(fault(part, "this name is declared twice; give each point a name of its own"));
        }
        let inertia = self.value(&format!("{part}.{}", patch.motion.inertia_key()), &patch.inertia)?;
        Ok(Point { name: patch.name.clone(), motion: patch.motion, inertia, fixed: patch.fixed })
    }

    fn resolve_shaft_patch(&self, patch: &ShaftPatch) -> Result<Shaft, MachineError> {
        let part = format!("shaft.{}", patch.name);
        if self.shafts.iter().any(|s| s.name == patch.name) {
            return Err(fault(part, "this name is declared twice; give each shaft a name of its own"));
        }
        let value = |key: &str, source| self.value(&format!("{part}.{key}"), source);
        let mut stations = Vec::new();
        for (place, axial, torsion) in &patch.stations {
            let point = |name: &Option<String>| name.as_ref().map(|n| self.named_point(&format!("{part}.station"), n)).transpose();
            stations.push(Station { place: *place, axial: point(axial)?, torsion: point(torsion)? });
        }
        Ok(Shaft {
            name: patch.name.clone(),
            length: value("length_m", &patch.length)?,
            diameter: value("diameter_m", &patch.diameter)?,
            youngs_modulus: value("youngs_modulus_pa", &patch.youngs_modulus)?,
            shear_modulus: value("shear_modulus_pa", &patch.shear_modulus)?,
            density: value("density_kg_m3", &patch.density)?,
            loss_factor: value("loss_factor", &patch.loss_factor)?,
            stations,
        })
    }

    fn resolve_joint_patch(&self, patch: &JointPatch) -> Result<Joint, MachineError> {
        let part = format!("joint.{}", patch.name);
        if self.joints.iter().any(|j| j.name == patch.name) {
            return Err(fault(part, "this name is declared twice; give each joint a name of its own"));
        }
        let mut on: Vec<(usize, f64)> = Vec::new();
        for (name, coefficient) in &patch.on {
            let point = self.named_point(&part, name)?;
            if on.iter().any(|(p, _)| *p == point) {
                return Err(fault(part, format!("it acts on «{name}» twice; name two different points")));
            }
            if !coefficient.is_finite() || *coefficient == 0.0 {
                return Err(fault(part, format!("its coefficient on «{name}» is {coefficient}; write a number other than 0")));
            }
            on.push((point, *coefficient));
        }
        if on.is_empty() {
            return Err(fault(part, "it acts on nothing; name at least one point"));
        }
        let value = |key: &str, source| self.value(&format!("{part}.{key}"), source);
        Ok(Joint {
            name: patch.name.clone(),
            on,
            stiffness: value("stiffness", &patch.stiffness)?,
            damping: value("damping", &patch.damping)?,
            loss_factor: value("loss_factor", &patch.loss_factor)?,
            relaxation_stiffness: patch.relaxation_stiffness.as_ref().map(|s| value("relaxation_stiffness", s)).transpose()?,
        })
    }

    fn rescale(&mut self, target: &Target, rescale: Rescale, parameter: &str) -> Result<(), MachineError> {
        let part = format!("rescale {target:?}");
        let index = self.parameter(parameter).ok_or_else(|| fault(&part, format!("no parameter is called «{parameter}»")))?;
        let stroke_m = self.stroke_m();
        let joint = |name: &String| self.joints.iter().position(|j| j.name == *name);
        let shaft = |name: &String| self.shafts.iter().position(|s| s.name == *name);
        let missing = |name: &String| fault(&part, format!("the machine has no «{name}»"));
        let mut values: Vec<&mut Value> = match target {
            Target::PointInertia(name) => {
                let at = self.point(name).ok_or_else(|| missing(name))?;
                vec![&mut self.points[at].inertia]
            }
            Target::JointStiffness(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].stiffness]
            }
            Target::JointDamping(name) => {
                let at = joint(name).ok_or_else(|| missing(name))?;
                vec![&mut self.joints[at].damping]
            }
            Target::ShaftDiameter(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].diameter]
            }
            Target::ShaftLossFactor(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                vec![&mut self.shafts[at].loss_factor]
            }
            Target::ShaftModulus(name) => {
                let at = shaft(name).ok_or_else(|| missing(name))?;
                let shaft = &mut self.shafts[at];
                vec![&mut shaft.youngs_modulus, &mut shaft.shear_modulus]
            }
            Target::ChainGain => vec![&mut self.chain.gain],
            Target::ChainDelay => vec![&mut self.chain.delay],
            Target::ChainPower => vec![&mut self.chain.power],
        };
        for value in &mut values {
            match rescale {
                Rescale::Relative => value.laws.push(Law::Relative(index)),
                Rescale::InSeries => value.laws.push(Law::InSeries(index)),
                Rescale::AlongStroke => {
                    let stroke_m = stroke_m.ok_or_else(|| fault(&part, "the machine has no shaft with a nut"))?;
                    value.laws.push(Law::AlongStroke(index, stroke_m));
                }
                Rescale::Replace => value.base = Base::Parameter(index),
            }
        }
        Ok(())
    }

    fn resolve_derived(&self, name: &str, from: &DerivedPatch) -> Result<Derivation, MachineError> {
        let part = format!("derived.{name}");
        let order = |order: usize| if order > 0 { Ok(order) } else { Err(fault(&part, "order is 0; count from 1")) };
        if self.derived.iter().any(|d| d.name == name) {
            return Err(fault(part, "this name is declared twice; give each quantity a name of its own"));
        }
        Ok(match from {
            DerivedPatch::NaturalFrequency(n) => Derivation::NaturalFrequency(order(*n)?),
            DerivedPatch::Antiresonance(n, point) => Derivation::Antiresonance(order(*n)?, self.named_point(&part, point)?),
            DerivedPatch::InertiaRatio(a, b) => Derivation::InertiaRatio(self.named_point(&part, a)?, self.named_point(&part, b)?),
            DerivedPatch::Parameter(id) => {
                let known = || listing(self.parameters.iter().map(|p| p.id.as_str()));
                Derivation::Parameter(
                    self.parameter(id).ok_or_else(|| fault(&part, format!("no parameter is called «{id}»; {}", known())))?,
                )
            }
        })
    }

    /// Checks every number at the start values and at both ends of every parameter's range.
    fn check(&self) -> Result<(), MachineError> {
        let start = self.start();
        self.check_numbers(&start)?;
        for (index, parameter) in self.parameters.iter().enumerate() {
            for end in [parameter.lower, parameter.upper] {
                let mut values = start.clone();
                values[index] = end;
                self.check_numbers(&values)
                    .map_err(|e| fault(e.part, format!("{} at {} = {end}, an end of its range", e.fault, parameter.id)))?;
            }
        }
        self.check_massless()
    }

    fn check_numbers(&self, start: &[f64]) -> Result<(), MachineError> {
        let middle = Operating::at(self.stroke_m().map(|s| 0.5 * s));
        let at = |v: &Value| v.at(start, &middle);
        let positive = |part: String, v: &Value| match at(v) {
            x if x > 0.0 && x.is_finite() => Ok(()),
            x => Err(fault(part, format!("is {x:?}; write a number above 0"))),
        };
        let not_negative = |part: String, v: &Value| match at(v) {
            x if x >= 0.0 && x.is_finite() => Ok(()),
            x => Err(fault(part, format!("is {x:?}; write 0 or a number above it"))),
        };
        for p in &self.points {
            not_negative(format!("point.{}.{}", p.name, p.motion.inertia_key()), &p.inertia)?;
        }
        for s in &self.shafts {
            let part = |key: &str| format!("shaft.{}.{key}", s.name);
            positive(part("length_m"), &s.length)?;
            positive(part("diameter_m"), &s.diameter)?;
            positive(part("youngs_modulus_pa"), &s.youngs_modulus)?;
            positive(part("shear_modulus_pa"), &s.shear_modulus)?;
            positive(part("density_kg_m3"), &s.density)?;
            not_negative(part("loss_factor"), &s.loss_factor)?;
            self.check_stations(s, start, &middle)?;
        }
        positive("chain-gain".into(), &self.chain.gain)?;
        for j in &self.joints {
            not_negative(format!("joint.{}.stiffness", j.name), &j.stiffness)?;
            not_negative(format!("joint.{}.damping", j.name), &j.damping)?;
            not_negative(format!("joint.{}.loss_factor", j.name), &j.loss_factor)?;
            if let Some(relaxation) = &j.relaxation_stiffness {
                positive(format!("joint.{}.relaxation_stiffness", j.name), relaxation)?;
            }
        }
        Ok(())
    }

    fn check_stations(&self, shaft: &Shaft, start: &[f64], middle: &Operating) -> Result<(), MachineError> {
        let part = format!("shaft.{}.station", shaft.name);
        let length_m = shaft.length.at(start, middle);
        if shaft.stations.len() < 2 {
            return Err(fault(part, "a shaft needs at least two stations: its two ends"));
        }
        let mut last_m: Option<f64> = None;
        for station in &shaft.stations {
            let here_m = shaft.place_m(station.place, start, middle).unwrap_or(0.5 * length_m);
            if !(0.0..=length_m).contains(&here_m) {
                return Err(fault(part, format!("at_m = {here_m} is outside the shaft of {length_m} m")));
            }
            // Where the nut stands is checked with the operating condition.
            if station.place == super::Place::Nut {
                continue;
            }
            if last_m.is_some_and(|last| last >= here_m) {
                return Err(fault(
                    part,
                    format!("stations must run from left to right; {here_m} m does not follow {} m", last_m.unwrap_or(0.0)),
                ));
            }
            last_m = Some(here_m);
        }
        for station in &shaft.stations {
            for (point, motion) in [(station.axial, super::Motion::Translation), (station.torsion, super::Motion::Rotation)] {
                if let Some(p) = point.map(|p| &self.points[p]).filter(|p| p.motion != motion) {
                    return Err(fault(part, format!("point «{}» is a {}, a {} is needed here", p.name, p.motion.noun(), motion.noun())));
                }
            }
        }
        Ok(())
    }

    /// A free point without inertia, rod or joint has no equation.
    fn check_massless(&self) -> Result<(), MachineError> {
        let start = self.start();
        let operating = Operating::at(self.stroke_m().map(|s| 0.5 * s));
        let mut carried = HashSet::new();
        for shaft in &self.shafts {
            carried.extend(shaft.stations.iter().flat_map(|s| [s.axial, s.torsion]).flatten());
        }
        for joint in self.joints.iter().filter(|j| j.stiffness.at(&start, &operating) > 0.0) {
            carried.extend(joint.on.iter().map(|(p, _)| *p));
        }
        for (index, point) in self.points.iter().enumerate() {
            if !point.fixed && point.inertia.at(&start, &operating) == 0.0 && !carried.contains(&index) {
                let part = format!("point.{}.{}", point.name, point.motion.inertia_key());
                return Err(fault(
                    part,
                    "is 0, and no shaft and no joint with a stiffness holds the point; give it an inertia, or attach it",
                ));
            }
        }
        Ok(())
    }

    /// Checks that a nut position lies inside its shaft and that every contact holds under its load.
    ///
    /// # Errors  the position is missing where the machine has a nut, or lies outside the shaft; a contact is overloaded.
    pub fn check_operating(&self, place: &str, operating: &Operating) -> Result<(), MachineError> {
        match (self.stroke_m(), operating.nut_m) {
            (Some(stroke_m), Some(nut_m)) if !(nut_m > 0.0 && nut_m < stroke_m) => Err(fault(
                place,
                format!("nut_m = {nut_m} is outside the screw; write a distance from the left bearing between 0 and {stroke_m} m"),
            )),
            (Some(stroke_m), None) => {
                Err(fault(place, format!("the machine has a nut, but no nut position is given; write nut_m between 0 and {stroke_m} m")))
            }
            _ => self.check_station_order(place, operating),
        }?;
        self.check_loads(place, operating)
    }

    fn check_station_order(&self, place: &str, operating: &Operating) -> Result<(), MachineError> {
        let start = self.start();
        for shaft in self.shafts.iter().filter(|_| operating.nut_m.is_some()) {
            let places: Vec<f64> = shaft.stations.iter().filter_map(|s| shaft.place_m(s.place, &start, operating)).collect();
            let inside = places.iter().all(|p| (0.0..=shaft.length.at(&start, operating)).contains(p));
            if inside && places.windows(2).any(|w| w[0] >= w[1]) {
                let fixed: Vec<String> = places.iter().filter(|p| Some(**p) != operating.nut_m).map(|p| format!("{p}")).collect();
                return Err(fault(
                    place,
                    format!(
                        "nut_m = {} does not keep the order of the stations of shaft {} (at {} m)",
                        operating.nut_m.unwrap_or(0.0),
                        shaft.name,
                        fixed.join(", ")
                    ),
                ));
            }
        }
        Ok(())
    }
}

fn check_parameter(p: &Parameter) -> Result<(), MachineError> {
    let part = |key: &str| format!("parameter.{}.{key}", p.id);
    for (key, number) in [("start", p.start), ("lower", p.lower), ("upper", p.upper)] {
        if !number.is_finite() {
            return Err(fault(part(key), format!("is {number}; write a finite number")));
        }
    }
    if !(p.lower < p.upper) {
        return Err(fault(part("lower"), format!("{} is not below upper = {}; write a range with lower < upper", p.lower, p.upper)));
    }
    if !(p.lower..=p.upper).contains(&p.start) {
        return Err(fault(
            part("start"),
            format!("{} is outside the range {} … {}; widen the range or move the start", p.start, p.lower, p.upper),
        ));
    }
    if let Some(sd) = p.sd.filter(|sd| !(*sd > 0.0 && sd.is_finite())) {
        return Err(fault(part("sd"), format!("is {sd}; write a standard deviation above 0, or leave it out")));
    }
    if p.scale == Scale::Logarithmic && p.lower <= 0.0 {
        return Err(fault(
            part("lower"),
            format!("{} cannot stand on a logarithmic scale; write a number above 0, or scale = \"linear\"", p.lower),
        ));
    }
    Ok(())
}
