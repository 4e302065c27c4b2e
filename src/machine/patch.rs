//! Application of patches: resolves names and inserts numbers.

use std::collections::BTreeMap;

use super::added_part::LeverFile;
use super::check::check_parameter;
use super::effect::{AttachFile, ReattachFile};
use super::error::{MachineError, fault, listing};
use super::number::{BENDING, JOINT, LEVER, Reach, SHAFT};
use super::{
    Bending, BendingFile, Derivation, Derived, DerivedPatch, Effect, FrictionTable, GROUND, Joint,
    JointPatch, Lever, Machine, ParameterValues, Patch, Point, PointMotion, PointPatch, Shaft, ShaftFile,
    Station, StationPlace, Value,
};

impl Machine {
    /// Applies a patch and checks the result.
    ///
    /// # Errors  an unknown or repeated name, a range with lower ≥ upper, a number outside its physical
    ///   range.
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
        if let Some(drive) = &patch.drive {
            machine.drive = Some(machine.resolve_drive_patch(drive)?);
        }
        patch.reattached.iter().try_for_each(|reattach| machine.reattach(reattach))?;
        patch.attached.iter().try_for_each(|attach| machine.attach(attach))?;
        patch.bending.iter().try_for_each(|bending| machine.add_bending(bending))?;
        patch.levers.iter().try_for_each(|lever| machine.add_lever(lever))?;
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

    /// Returns the machine with the effects that a diagnosis chose, given by their ids.
    ///
    /// An id may also name a released parameter, which the machine contains already. `None` where an id is
    /// neither that nor an applicable effect.
    pub fn with_chosen<'i>(
        &self,
        chosen: impl IntoIterator<Item = &'i str>,
        effects: &[Effect],
    ) -> Option<Machine> {
        chosen.into_iter().try_fold(self.clone(), |machine, id| {
            match effects.iter().find(|effect| effect.id == id) {
                Some(effect) => machine.with_effect(effect).ok(),
                // A released parameter is already a parameter of the machine.
                None => machine.parameter(id).map(|_| machine),
            }
        })
    }

    /// Returns the values of its parameters in order, looked up by id; `None` where one is missing.
    pub fn values_of(&self, values: &BTreeMap<String, f64>) -> Option<ParameterValues> {
        self.parameters
            .iter()
            .map(|p| values.get(&p.id).copied())
            .collect::<Option<Vec<f64>>>()
            .map(ParameterValues)
    }

    /// Applies an effect and lists it among the machine's effects.
    ///
    /// # Errors  as [`Machine::with`]; the machine contains the effect already, or lacks a part that it
    ///   needs.
    pub fn with_effect(&self, effect: &Effect) -> Result<Machine, MachineError> {
        if self.effects.contains(&effect.id) {
            return Err(fault(format!("effect {}", effect.id), "the machine contains it already"));
        }
        if let Some(name) = self.missing_part(effect) {
            return Err(fault(
                format!("effect {}", effect.id),
                format!("it does not apply: the machine has no «{name}»"),
            ));
        }
        let mut machine = self.with(&effect.patch)?;
        machine.effects.push(effect.id.clone());
        Ok(machine)
    }

    /// Removes parameters on which nothing depends, such as those of a removed effect, and returns their ids.
    pub fn drop_unused_parameters(&mut self) -> Vec<String> {
        let used = self.depended_on(self.numbers().map(|(.., value)| value));
        let mut next = 0;
        let moved: Vec<usize> = used
            .iter()
            .map(|u| {
                next += usize::from(*u);
                next - usize::from(*u)
            })
            .collect();
        self.change_numbers(&mut |_, _, value| value.renumber(&moved));
        self.derived.retain(|d| !matches!(d.from, Derivation::Parameter(index) if !used[index]));
        for derived in &mut self.derived {
            if let Derivation::Parameter(index) = &mut derived.from {
                *index = moved[*index];
            }
        }
        let dropped = self
            .parameters
            .iter()
            .zip(&used)
            .filter(|(_, used)| !**used)
            .map(|(p, _)| p.id.clone())
            .collect();
        let mut keep = used.iter();
        self.parameters.retain(|_| *keep.next().unwrap_or(&true));
        dropped
    }

    /// Whether frequency responses and modes depend on each parameter; the others affect only motion. Of the
    /// numbers of motion they depend on the expansion of a lead.
    pub fn linear_parameters(&self) -> Vec<bool> {
        let own = self.numbers().filter(|(number, ..)| number.reach == Reach::All).map(|(.., value)| value);
        let with_lead = |joint: &&Joint| joint.on.iter().any(|(point, _)| self.has_lead(joint, *point));
        self.depended_on(
            own.chain(self.joints.iter().filter(with_lead).map(|joint| &joint.lead_error.growth)),
        )
    }

    /// Whether one of the numbers depends on each parameter.
    pub(super) fn depended_on<'v>(&self, numbers: impl Iterator<Item = &'v Value>) -> Vec<bool> {
        let mut depends = vec![false; self.parameters.len()];
        numbers.for_each(|value| value.depends_on().for_each(|index| depends[index] = true));
        depends
    }

    /// Returns the first part that an effect needs, or names as its location, and the machine lacks; or the
    /// effect that it describes in more detail, where the machine does not contain that.
    pub fn missing_part<'e>(&self, effect: &'e Effect) -> Option<&'e str> {
        effect
            .needs
            .iter()
            .chain(effect.at.as_ref().filter(|at| *at != "measurement"))
            .find(|name| {
                let driven = **name == "drive" && self.drive.is_some();
                let named = self.joints.iter().any(|j| j.name == **name)
                    || self.shafts.iter().any(|s| s.name == **name);
                !driven && !named && self.point(name).is_none()
            })
            .or(effect.refines.as_ref().filter(|refined| !self.effects.contains(refined)))
            .map(String::as_str)
    }

    pub(super) fn named_point(&self, part: &str, name: &str) -> Result<usize, MachineError> {
        self.point(name).ok_or_else(|| {
            let known = listing(self.points.iter().map(|p| p.name.as_str()));
            fault(part, format!("no point is called «{name}»; {known} (and ground)"))
        })
    }

    fn resolve_point_patch(&self, patch: &PointPatch) -> Result<Point, MachineError> {
        let part = format!("point.{}", patch.name);
        if patch.name == GROUND {
            return Err(fault(part, "«ground» is predefined and cannot be declared; choose another name"));
        }
        if self.point(&patch.name).is_some() {
            return Err(fault(part, "this name is declared twice; give each point a name of its own"));
        }
        let inertia = self.value(&format!("{part}.{}", patch.motion.inertia_key()), &patch.inertia)?;
        Ok(Point {
            name: patch.name.clone(),
            motion: patch.motion,
            inertia,
            fixed: patch.fixed,
            role: patch.role,
        })
    }

    fn resolve_shaft_patch(&self, patch: &ShaftFile) -> Result<Shaft, MachineError> {
        let part = format!("shaft.{}", patch.name);
        if self.shafts.iter().any(|s| s.name == patch.name) {
            return Err(fault(part, "this name is declared twice; give each shaft a name of its own"));
        }
        let point = |name: &Option<String>| {
            name.as_ref().map(|n| self.named_point(&format!("{part}.station"), n)).transpose()
        };
        let mut stations = Vec::new();
        for (place, station) in patch.locations()?.into_iter().zip(&patch.station) {
            stations.push(Station {
                place,
                axial: point(&station.axial)?,
                torsion: point(&station.torsion)?,
            });
        }
        let mut shaft = Shaft {
            name: patch.name.clone(),
            length: Value::default(),
            diameter: Value::default(),
            bore_ratio: Value::default(),
            youngs_modulus: Value::default(),
            shear_modulus: Value::default(),
            density: Value::default(),
            loss_factor: Value::default(),
            nut_position: Value::nut_position(),
            nut_support_factor: Value::number(1.0),
            nut_support_offset: Value::default(),
            stations,
            journal_of: None,
            bending: None,
        };
        self.set_numbers(SHAFT, &part, patch, &mut shaft)?;
        Ok(shaft)
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
                return Err(fault(
                    part,
                    format!("its coefficient on «{name}» is {coefficient}; write a number other than 0"),
                ));
            }
            on.push((point, *coefficient));
        }
        if on.is_empty() {
            return Err(fault(part, "it acts on nothing; name at least one point"));
        }
        let motion = |name: &String| self.point(name).map(|p| self.points[p].motion);
        if let [a, b] = &patch.alike[..]
            && let (Some(first), Some(second)) = (motion(a), motion(b))
            && first != second
        {
            let (first, second) = (first.noun(), second.noun());
            return Err(fault(
                part,
                format!(
                    "«{a}» is a {first} and «{b}» a {second}; a joint between two points needs two of the same kind"
                ),
            ));
        }
        if let Some(name) = patch.angles.iter().find(|n| motion(n) == Some(super::PointMotion::Translation)) {
            return Err(fault(
                part,
                format!("screw.angle: «{name}» is a translation; name a point that rotates"),
            ));
        }
        let mut joint = Joint::new(patch.name.clone(), on);
        joint.relaxation_stiffness = patch.relaxation_stiffness.as_ref().map(|_| Value::default());
        self.set_numbers(JOINT, &part, patch, &mut joint)?;
        if let Some(name) = &patch.friction.load_of {
            joint.friction.load_of = Some(self.joint_named(&format!("{part}.friction.load_of"), name)?);
        }
        if let Some(rows) = &patch.friction.table {
            joint.friction.table = FrictionTable::new(&format!("{part}.friction.table"), rows)?;
        }
        Ok(joint)
    }

    /// Adds a lever: sensor and hammer at a point also respond to another motion.
    fn add_lever(&mut self, lever: &LeverFile) -> Result<(), MachineError> {
        let part = format!("lever {}", lever.at);
        let [at, other] = [self.named_point(&part, &lever.at)?, self.named_point(&part, &lever.with)?];
        if at == other {
            return Err(fault(part, format!("«{}» cannot be its own lever; name another point", lever.at)));
        }
        if self.points[at].fixed || self.points[other].fixed {
            return Err(fault(part, "a fixed point does not move; name points that do"));
        }
        let mut arms =
            Lever { point: at, on: other, sensor_arm: Value::default(), hammer_arm: Value::default() };
        self.set_numbers(LEVER, &part, lever, &mut arms)?;
        self.chain.levers.push(arms);
        Ok(())
    }

    pub(super) fn joint_named(&self, part: &str, name: &str) -> Result<usize, MachineError> {
        self.joints.iter().position(|j| j.name == name).ok_or_else(|| {
            fault(
                part,
                format!(
                    "no joint is called «{name}»; {}",
                    listing(self.joints.iter().map(|j| j.name.as_str()))
                ),
            )
        })
    }

    /// Returns all joints of a name, which share one described joint.
    fn joints_named(&self, part: &str, name: &str) -> Result<Vec<usize>, MachineError> {
        self.joint_named(part, name)?;
        Ok((0..self.joints.len()).filter(|j| self.joints[*j].name == name).collect())
    }

    /// Lets a shaft bend.
    fn add_bending(&mut self, file: &BendingFile) -> Result<(), MachineError> {
        let part = format!("bending.{}", file.shaft);
        let at = self.shafts.iter().position(|shaft| shaft.name == file.shaft);
        let at = at.ok_or_else(|| {
            fault(&part, format!("no shaft is called «{}»; name one of the machine", file.shaft))
        })?;
        if self.shafts[at].bending.is_some() {
            return Err(fault(part, "this shaft bends already; describe its bending once"));
        }
        if !self.shafts[at]
            .stations
            .iter()
            .any(|station| matches!(station.place, StationPlace::Nut | StationPlace::NearNut(_)))
        {
            return Err(fault(part, "the shaft carries no nut; name one with a station at the nut"));
        }
        let own = |shaft: &&Shaft| shaft.name == file.shaft || shaft.journal_of.as_ref() == Some(&file.shaft);
        let has = |place: StationPlace| {
            self.shafts.iter().filter(own).flat_map(|shaft| &shaft.stations).any(|s| s.place == place)
        };
        if !has(StationPlace::At(0.0)) || !has(StationPlace::End) {
            return Err(fault(
                part,
                "the shaft has no stations at both ends, where its bearings hold it; describe them",
            ));
        }
        let point = self.named_point(&part, &file.point)?;
        if self.points[point].fixed {
            return Err(fault(part, format!("«{}» is fixed; name a point that moves", file.point)));
        }
        if self.points[point].motion == PointMotion::Rotation {
            return Err(fault(
                part,
                format!("«{}» is a rotation; name a point that is a translation", file.point),
            ));
        }
        let mut bending = Bending {
            point,
            misalignment: Value::default(),
            eccentricity: Value::default(),
            lateral_stiffness: Value::default(),
            clamping: Default::default(),
            loss_factor: Value::default(),
        };
        self.set_numbers(BENDING, &part, file, &mut bending)?;
        self.shafts[at].bending = Some(bending);
        Ok(())
    }

    /// Moves a joint from `from` to `to`.
    fn reattach(&mut self, ReattachFile { joint, from, to }: &ReattachFile) -> Result<(), MachineError> {
        let part = format!("reattach {joint}");
        let to = self.named_point(&part, to)?;
        for at in self.joints_named(&part, joint)? {
            if self.joints[at].on.iter().any(|(p, _)| *p == to) {
                return Err(fault(part, format!("the joint acts on «{}» already", self.points[to].name)));
            }
            if from == GROUND {
                // A joint relative to the ground becomes a joint relative to the point.
                let on = &mut self.joints[at].on;
                let [(_, coefficient)] = on[..] else {
                    return Err(fault(part, "the joint does not act between one point and the ground"));
                };
                on.push((to, -coefficient));
                continue;
            }
            let from_index = self.named_point(&part, from)?;
            let end = self.joints[at].on.iter_mut().find(|(p, _)| *p == from_index);
            end.ok_or_else(|| fault(&part, format!("the joint does not act on «{from}»")))?.0 = to;
        }
        Ok(())
    }

    /// Lets a joint act on an additional point.
    fn attach(
        &mut self,
        AttachFile { joint, to, times: coefficient }: &AttachFile,
    ) -> Result<(), MachineError> {
        let part = format!("attach {joint}");
        let point = self.named_point(&part, to)?;
        if !coefficient.is_finite() || *coefficient == 0.0 {
            return Err(fault(part, format!("times is {coefficient}; write a number other than 0")));
        }
        for at in self.joints_named(&part, joint)? {
            let own = &mut self.joints[at];
            if own.on.iter().any(|(p, _)| *p == point) {
                return Err(fault(part, format!("the joint acts on «{}» already", self.points[point].name)));
            }
            own.on.push((point, own.share.sqrt() * coefficient));
        }
        Ok(())
    }

    fn resolve_derived(&self, name: &str, from: &DerivedPatch) -> Result<Derivation, MachineError> {
        let part = format!("derived.{name}");
        let order =
            |order: usize| if order > 0 { Ok(order) } else { Err(fault(&part, "order is 0; count from 1")) };
        if self.derived.iter().any(|d| d.name == name) {
            return Err(fault(part, "this name is declared twice; give each quantity a name of its own"));
        }
        Ok(match from {
            DerivedPatch::NaturalFrequency { natural_frequency } => {
                Derivation::NaturalFrequency(order(*natural_frequency)?)
            }
            DerivedPatch::Antiresonance { antiresonance, at } => {
                Derivation::Antiresonance(order(*antiresonance)?, self.named_point(&part, at)?)
            }
            DerivedPatch::InertiaRatio { inertia: [a, b] } => {
                Derivation::InertiaRatio(self.named_point(&part, a)?, self.named_point(&part, b)?)
            }
            DerivedPatch::Parameter { parameter: id } => {
                let known = || listing(self.parameters.iter().map(|p| p.id.as_str()));
                Derivation::Parameter(
                    self.parameter(id)
                        .ok_or_else(|| fault(&part, format!("no parameter is called «{id}»; {}", known())))?,
                )
            }
        })
    }
}
