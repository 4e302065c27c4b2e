//! Composed stiffnesses: contacts, screw segments and springs in series. Resolves names and checks numbers.

use std::sync::Arc;

use super::error::{MachineError, fault, listing};
use super::source::{ContactNumber, SegmentNumber};
use super::{Base, LoadedPair, Machine, Modifier, NumberSource, Operating, Segment, Value};

impl Machine {
    /// Resolves a value from its source.
    pub(super) fn value(&self, part: &str, source: &NumberSource) -> Result<Value, MachineError> {
        if matches!(source, NumberSource::Contact(_) | NumberSource::Segment(_) | NumberSource::Series(_))
            && !part.ends_with("stiffness")
        {
            return Err(fault(
                part,
                "only a stiffness can be a contact, a segment or a series; write a number or a parameter here",
            ));
        }
        let (base, times) = match source {
            NumberSource::Number(number) if number.is_finite() => (Base::Number(*number), None),
            NumberSource::Number(number) => {
                return Err(fault(part, format!("{number} is not a finite number; write one")));
            }
            NumberSource::Parameter(id) => (Base::Parameter(self.known_parameter(part, id)?), None),
            NumberSource::Contact(ContactNumber { contact: name, times }) => {
                let found = self.contacts.iter().find(|c| c.name == *name).ok_or_else(|| {
                    let known = listing(self.contacts.iter().map(|c| c.name.as_str()));
                    fault(
                        part,
                        format!("no contact is called «{name}»; {known}. Describe it as [contact.{name}]"),
                    )
                })?;
                (Base::Contact(Arc::clone(found)), times.as_ref())
            }
            NumberSource::Segment(SegmentNumber { segment: name, times }) => {
                let found = self.segments.iter().find(|s| s.name == *name).ok_or_else(|| {
                    let known = listing(self.segments.iter().map(|s| s.name.as_str()));
                    fault(
                        part,
                        format!("no segment is called «{name}»; {known}. Describe it as [segment.{name}]"),
                    )
                })?;
                (Base::Segment(Arc::clone(found)), times.as_ref())
            }
            NumberSource::Series(of) if of.series.len() < 2 => {
                return Err(fault(part, "a series needs at least two springs"));
            }
            NumberSource::Series(of) => {
                let mut springs = Vec::new();
                for (at, spring) in of.series.iter().enumerate() {
                    let label = match spring {
                        NumberSource::Number(_) => format!("{}", at + 1),
                        other => other.label(),
                    };
                    springs.push((label, self.value(part, spring)?));
                }
                (Base::Series(Arc::new(springs)), of.times.as_ref())
            }
            NumberSource::Times(spring, id) => {
                let mut value = self.value(part, spring)?;
                value.modifiers.push(Modifier::Times(self.known_parameter(part, id)?));
                return Ok(value);
            }
        };
        let laws = times
            .map(|id| self.known_parameter(part, id).map(Modifier::Times))
            .transpose()?
            .into_iter()
            .collect();
        Ok(Value { base, modifiers: laws })
    }

    fn known_parameter(&self, part: &str, id: &str) -> Result<usize, MachineError> {
        self.parameter(id).ok_or_else(|| {
            let known = listing(self.parameters.iter().map(|p| p.id.as_str()));
            fault(part, format!("no parameter is called «{id}»; {known}. Declare it as [parameter.{id}]"))
        })
    }

    /// Adds a contact after a check at rest.
    pub(super) fn add_contact(&mut self, contact: &LoadedPair) -> Result<(), MachineError> {
        let part = |key: &str| format!("contact.{}.{key}", contact.name);
        if self.contacts.iter().any(|c| c.name == contact.name) {
            return Err(fault(
                format!("contact.{}", contact.name),
                "this name is declared twice; give each contact a name of its own",
            ));
        }
        if !(contact.weight > 0.0 && contact.weight.is_finite()) {
            return Err(fault(part("weight"), format!("is {}; write a number above 0", contact.weight)));
        }
        if !(contact.moved_mass_kg >= 0.0 && contact.moved_mass_kg.is_finite()) {
            return Err(fault(
                part("moved_mass_kg"),
                format!("is {}; write 0 or a mass above it", contact.moved_mass_kg),
            ));
        }
        if !contact.gravity_m_s2.is_finite() {
            return Err(fault(
                part("gravity_m_s2"),
                format!("is {}; write a finite number", contact.gravity_m_s2),
            ));
        }
        if !(0.0..=1.0).contains(&contact.share) {
            return Err(fault(part("share"), format!("is {}; write a number from 0 to 1", contact.share)));
        }
        if !(0.0..=1.0).contains(&contact.outside_share) {
            return Err(fault(
                part("outside_share"),
                format!("is {}; write a number from 0 to 1", contact.outside_share),
            ));
        }
        if let Some(curve) = contact.friction {
            curve.check().map_err(|e| fault(part("friction"), e.to_string()))?;
        }
        contact
            .at(&Operating::default())
            .map_err(|e| fault(format!("contact.{}", contact.name), e.to_string()))?;
        self.contacts.push(Arc::new(contact.clone()));
        Ok(())
    }

    /// Adds a segment after a check.
    pub(super) fn add_segment(&mut self, segment: &Segment) -> Result<(), MachineError> {
        if self.segments.iter().any(|s| s.name == segment.name) {
            return Err(fault(
                format!("segment.{}", segment.name),
                "this name is declared twice; give each segment a name of its own",
            ));
        }
        let mut numbers = vec![
            ("diameter_m", segment.diameter_m),
            ("youngs_modulus_pa", segment.youngs_modulus_pa),
            ("length_m", segment.length_m),
        ];
        numbers.extend(
            segment
                .twist
                .iter()
                .flat_map(|t| [("shear_modulus_pa", t.shear_modulus_pa), ("lead_m", t.lead_m)]),
        );
        for (key, x) in numbers {
            if !(x > 0.0 && x.is_finite()) {
                return Err(fault(
                    format!("segment.{}.{key}", segment.name),
                    format!("is {x}; write a number above 0"),
                ));
            }
        }
        self.segments.push(Arc::new(segment.clone()));
        Ok(())
    }

    /// Checks that velocity, acceleration and force are finite, and that every contact holds under them.
    pub(super) fn check_loads(&self, place: &str, operating: &Operating) -> Result<(), MachineError> {
        let given = [
            ("velocity", operating.velocity_m_s),
            ("acceleration", operating.acceleration_m_s2),
            ("force", operating.force_n),
        ];
        for (key, number) in given {
            if let Some(x) = number.filter(|x| !x.is_finite()) {
                return Err(fault(place, format!("the {key} is {x}; write a finite number")));
            }
        }
        for contact in &self.contacts {
            contact.at(operating).map_err(|e| {
                let force_n = contact.force_n(operating);
                fault(place, format!("contact «{}» under {force_n:.0} N: {e}; lower the load", contact.name))
            })?;
        }
        Ok(())
    }
}
