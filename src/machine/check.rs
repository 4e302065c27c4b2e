//! Checks of a description: plausible numbers, and an equation for every point.

use std::collections::HashSet;

use super::error::{MachineError, fault};
use super::number::{BENDING, CHAIN, JOINT, POINT, Reach, SHAFT, check_ranges, numbers_of};
use super::{Machine, Operating, Parameter, Scale, Shaft, Value};

impl Machine {
    /// Checks every number at the start values and at both ends of every parameter's range.
    pub(super) fn check(&self) -> Result<(), MachineError> {
        let start = self.start();
        self.check_numbers(&start, false)?;
        for (index, parameter) in self.parameters.iter().enumerate() {
            for end in [parameter.lower, parameter.upper] {
                let mut values = start.clone();
                values[index] = end;
                self.check_numbers(&values, true).map_err(|e| {
                    fault(e.part, format!("{} at {} = {end}, an end of its range", e.fault, parameter.id))
                })?;
            }
        }
        self.check_massless()
    }

    /// Checks every number at the given parameter values.
    ///
    /// At the end of a range a point on a shaft may have a negative lumped inertia, down to a quarter of the
    /// shaft's. The description takes a shaft as a uniform rod, but real ends are thinner.
    fn check_numbers(&self, start: &[f64], at_end: bool) -> Result<(), MachineError> {
        let middle = Operating::at(self.stroke_m().map(|s| 0.5 * s));
        let at = |v: &Value| v.at(start, &middle);
        let lightest = |point: usize| match self.shafts.iter().find(|s| at_end && s.carries(point)) {
            Some(shaft) => -0.25 * shaft.inertia(self.points[point].motion, start, &middle),
            None => 0.0,
        };
        for (index, p) in self.points.iter().enumerate() {
            if !(lightest(index)..f64::INFINITY).contains(&at(&p.inertia)) {
                check_ranges(numbers_of(POINT, p), |key| format!("point.{}.{key}", p.name), &at)?;
            }
        }
        for s in &self.shafts {
            check_ranges(numbers_of(SHAFT, s), |key| format!("shaft.{}.{key}", s.name), &at)?;
            self.check_stations(s, start, &middle)?;
            self.check_bending(s, start, &middle)?;
        }
        check_ranges(numbers_of(CHAIN, &self.chain), str::to_string, &at)?;
        for j in &self.joints {
            let of_all = numbers_of(JOINT, j).filter(|(number, _)| number.reach == Reach::All);
            check_ranges(of_all, |key| format!("joint.{}.{key}", j.name), &at)?;
        }
        self.check_motion(at)
    }

    fn check_bending(&self, shaft: &Shaft, start: &[f64], middle: &Operating) -> Result<(), MachineError> {
        let Some(bending) = &shaft.bending else { return Ok(()) };
        let part = format!("bending.{}", shaft.name);
        check_ranges(numbers_of(BENDING, bending), |key| format!("{part}.{key}"), &|value: &Value| {
            value.at(start, middle)
        })?;
        if [&bending.misalignment, &bending.eccentricity].iter().all(|value| value.at(start, middle) == 0.0) {
            return Err(fault(
                part,
                "its misalignment and its eccentricity are both 0; write one of them, or leave the bending out",
            ));
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
            // The nut position is checked with the operating condition.
            if matches!(station.place, super::StationPlace::Nut | super::StationPlace::NearNut(_)) {
                continue;
            }
            if last_m.is_some_and(|last| last >= here_m) {
                return Err(fault(
                    part,
                    format!(
                        "stations must run from left to right; {here_m} m does not follow {} m",
                        last_m.unwrap_or(0.0)
                    ),
                ));
            }
            last_m = Some(here_m);
        }
        for station in &shaft.stations {
            for (point, motion) in [
                (station.axial, super::PointMotion::Translation),
                (station.torsion, super::PointMotion::Rotation),
            ] {
                if let Some(p) = point.map(|p| &self.points[p]).filter(|p| p.motion != motion) {
                    return Err(fault(
                        part,
                        format!("point «{}» is a {}; name a {} here", p.name, p.motion.noun(), motion.noun()),
                    ));
                }
            }
        }
        Ok(())
    }

    /// Checks that every free point has an equation: an inertia, a rod or a joint with stiffness.
    fn check_massless(&self) -> Result<(), MachineError> {
        let start = self.start();
        let operating = Operating::at(self.stroke_m().map(|s| 0.5 * s));
        let mut carried = HashSet::new();
        for shaft in &self.shafts {
            carried.extend(shaft.stations.iter().flat_map(|s| [s.axial, s.torsion]).flatten());
            carried.extend(shaft.bending.iter().map(|bending| bending.point));
        }
        for joint in self.joints.iter().filter(|j| j.stiffness.at(&start, &operating) > 0.0) {
            carried.extend(joint.on.iter().map(|(p, _)| *p));
        }
        for (index, point) in self.points.iter().enumerate() {
            if !point.fixed && point.inertia.at(&start, &operating) == 0.0 && !carried.contains(&index) {
                let part = format!("point.{}.{}", point.name, point.motion.inertia_key());
                return Err(fault(
                    part,
                    "is 0, and neither a shaft nor a joint with a stiffness holds the point; give it an inertia, or attach it",
                ));
            }
        }
        Ok(())
    }

    /// Checks that the nut position lies inside its shaft and that every contact holds under its load.
    ///
    /// # Errors  the position is missing where the machine has a nut, or lies outside the shaft; a contact is
    ///   overloaded.
    pub fn check_operating(&self, place: &str, operating: &Operating) -> Result<(), MachineError> {
        match (self.stroke_m(), operating.nut_m) {
            (Some(stroke_m), Some(nut_m)) if !(nut_m > 0.0 && nut_m < stroke_m) => Err(fault(
                place,
                format!(
                    "nut_m = {nut_m} is outside the screw; write a distance from the left bearing between 0 and {stroke_m} m"
                ),
            )),
            (Some(stroke_m), None) => Err(fault(
                place,
                format!(
                    "the machine has a nut, but no nut position is given; write nut_m between 0 and {stroke_m} m"
                ),
            )),
            _ => self.check_station_order(place, operating),
        }?;
        self.check_loads(place, operating)
    }

    fn check_station_order(&self, place: &str, operating: &Operating) -> Result<(), MachineError> {
        let start = self.start();
        for shaft in self.shafts.iter().filter(|_| operating.nut_m.is_some()) {
            let places: Vec<f64> =
                shaft.stations.iter().filter_map(|s| shaft.place_m(s.place, &start, operating)).collect();
            let inside = places.iter().all(|p| (0.0..=shaft.length.at(&start, operating)).contains(p));
            if inside && places.windows(2).any(|w| w[0] >= w[1]) {
                let fixed: Vec<String> =
                    places.iter().filter(|p| Some(**p) != operating.nut_m).map(|p| format!("{p}")).collect();
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

pub(super) fn check_parameter(p: &Parameter) -> Result<(), MachineError> {
    let part = |key: &str| format!("parameter.{}.{key}", p.id);
    if p.id == "gain" {
        let fault_of_name = "is the name of the measuring chain's factor in results; choose another name";
        return Err(fault(format!("parameter.{}", p.id), fault_of_name));
    }
    for (key, number) in [("start", p.start), ("lower", p.lower), ("upper", p.upper)] {
        if !number.is_finite() {
            return Err(fault(part(key), format!("is {number}; write a finite number")));
        }
    }
    if !(p.lower < p.upper) {
        return Err(fault(
            part("lower"),
            format!("{} is not below upper = {}; write a range with lower < upper", p.lower, p.upper),
        ));
    }
    if !(p.lower..=p.upper).contains(&p.start) {
        return Err(fault(
            part("start"),
            format!(
                "{} is outside the range {} … {}; widen the range or move the start",
                p.start, p.lower, p.upper
            ),
        ));
    }
    if let Some(sd) = p.prior.map(super::Prior::sd).filter(|sd| !(*sd > 0.0 && sd.is_finite())) {
        return Err(fault(
            part("sd"),
            format!("is {sd}; write a standard deviation above 0, or leave it out"),
        ));
    }
    if p.scale == Scale::Logarithmic && p.lower <= 0.0 {
        return Err(fault(
            part("lower"),
            format!(
                "{} is not allowed on a logarithmic scale; write a number above 0, or scale = \"linear\"",
                p.lower
            ),
        ));
    }
    Ok(())
}
