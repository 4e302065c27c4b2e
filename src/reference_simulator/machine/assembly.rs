//! Assembly of a structure from numbers: kept degrees of freedom, the screw between them, joints, and the
//! motions of all points.

use super::number::{Machine, Screw};
use super::point::{Channel, Point};
use crate::effect::Effect;
use crate::element::Form;
use crate::element::law::Law;
use crate::element::rod::{Rod, Stretch};
use crate::element::structure::{Port, Structure};

/// Relaxation time of the oil film in a guide, s: far above the measured band the film is stiff.
const GUIDE_FILM_S: f64 = 1e-5;
/// Loss factor of the stiffness of a guide: seals and hoses.
const GUIDE_LOSS: f64 = 0.05;

/// A partly assembled machine at one nut position.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Numbers of the machine, including the changes by effects.
    pub machine: Machine,
    /// Parts assembled so far.
    pub structure: Structure,
    /// Nut position from the left bearing, m.
    pub nut_m: f64,
    /// Degree of freedom of the table, axial.
    pub table: usize,
    /// Degree of freedom of the rotor angle.
    pub rotor: usize,
    /// Degrees of freedom of the two screw ends, axial and angle.
    pub ends: [(usize, usize); 2],
    /// Degrees of freedom of the screw at the nut's contacts, axial and angle, and the contact's share of the
    /// joint.
    pub contacts: Vec<(usize, usize, f64)>,
    /// Degrees of freedom of the screw at stations that effects require, axial and angle.
    pub extra: Vec<(usize, usize)>,
    /// Motion of the nut body.
    pub carrier: Form,
    /// Motion of the table at the hammer's point.
    pub hit: Form,
    /// Motion of the table at the sensor.
    pub sensor: Form,
    /// Motions of the two bearing housings; an empty form is ground.
    pub housings: [Form; 2],
    /// Motion that drives the coupling.
    pub driver: Form,
    /// Motion of a contact in addition to the axial and angular motion.
    pub lateral: Form,
}

/// A structure with the motions of its points.
#[derive(Clone, Debug)]
pub struct Assembly {
    /// The structure.
    pub structure: Structure,
    frame_points: Vec<(Point, Form)>,
    hit: Form,
}

impl Assembly {
    /// Assembles a machine with effects for the nut position `nut_m`. `force_level` is the force over the
    /// nominal force.
    pub fn new(machine: &Machine, effects: &[Effect], nut_m: f64, force_level: f64) -> Self {
        let mut machine = machine.clone();
        for effect in effects {
            effect.adjust(&mut machine, nut_m, force_level);
        }
        let mut frame = Frame::screw_only(machine, effects, nut_m);
        for effect in effects {
            effect.attach(&mut frame, force_level);
        }
        frame.assembled()
    }

    /// Returns the response and excitation of a channel.
    pub fn port(&self, channel: Channel) -> Port {
        let excitation =
            if channel.excitation == Point::Table { self.hit.clone() } else { self.form(channel.excitation) };
        Port { response: self.form(channel.response), excitation }
    }

    fn form(&self, point: Point) -> Form {
        self.frame_points
            .iter()
            .find(|(known, _)| *known == point)
            .map(|(_, form)| form.clone())
            .unwrap_or_default()
    }
}

impl Frame {
    fn screw_only(machine: Machine, effects: &[Effect], nut_m: f64) -> Self {
        let mut structure = Structure::default();
        structure.loss_dispersion = machine.loss_dispersion;
        let [table, rotor] = [structure.freedom(), structure.freedom()];
        let mut stations: Vec<(f64, Station)> =
            vec![(0.0, Station::End(0)), (machine.screw.length_m, Station::End(1))];
        for (offset, share) in machine.nut.shares() {
            stations.push((nut_m + offset, Station::Contact(share)));
        }
        for place in effects.iter().filter_map(|effect| effect.station(&machine)) {
            stations.push((place, Station::Extra));
        }
        stations.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ends = [(0, 0); 2];
        let (mut contacts, mut extra) = (Vec::new(), Vec::new());
        let mut previous: Option<(f64, usize, usize)> = None;
        for (place, station) in stations {
            let node = (structure.freedom(), structure.freedom());
            match station {
                Station::End(end) => ends[end] = node,
                Station::Contact(share) => contacts.push((node.0, node.1, share)),
                Station::Extra => extra.push(node),
            }
            if let Some((from, axial, angle)) = previous {
                structure.rod(axial, node.0, rod(&machine.screw, from, place, Family::Axial));
                structure.rod(angle, node.1, rod(&machine.screw, from, place, Family::Torsion));
            }
            previous = Some((place, node.0, node.1));
        }
        structure.rod_loss = machine.screw.loss;
        structure.beam_loss = machine.screw.loss + 0.01;
        let on_table = vec![(table, 1.0)];
        Self {
            structure,
            nut_m,
            table,
            rotor,
            ends,
            contacts,
            extra,
            carrier: on_table.clone(),
            hit: on_table.clone(),
            sensor: on_table,
            housings: [Form::new(), Form::new()],
            driver: vec![(rotor, 1.0)],
            lateral: Form::new(),
            machine,
        }
    }

    /// Adds masses and joints.
    fn assembled(mut self) -> Assembly {
        let machine = &self.machine;
        let structure = &mut self.structure;
        structure.inertia(self.table, machine.table_mass_kg);
        structure.inertia(self.rotor, machine.rotor_inertia_kg_m2);
        structure.inertia(self.ends[0].1, machine.hub_inertia_kg_m2);
        if machine.guide_damping_ns_per_m > 0.0 {
            let stiffness = machine.guide_damping_ns_per_m / GUIDE_FILM_S;
            structure.branch(vec![(self.table, 1.0)], Law::Maxwell { stiffness, time_s: GUIDE_FILM_S });
        }
        if machine.guide_stiffness_n_per_m > 0.0 {
            structure
                .branch(vec![(self.table, 1.0)], Law::spring(machine.guide_stiffness_n_per_m, GUIDE_LOSS));
        }
        if let Some(hold) = machine.hold {
            let law = Law::Servo {
                stiffness: hold.stiffness,
                damping: hold.damping,
                integral: hold.integral,
                delay_s: hold.lag_s,
            };
            structure.branch(vec![(self.rotor, 1.0)], law);
        }
        structure.branch(
            difference(&self.driver, &[(self.ends[0].1, machine.drive_ratio)]),
            machine.coupling.law(1.0),
        );
        structure
            .branch(difference(&[(self.ends[0].0, 1.0)], &self.housings[0]), machine.bearing_left.law(1.0));
        structure
            .branch(difference(&[(self.ends[1].0, 1.0)], &self.housings[1]), machine.bearing_right.law(1.0));
        let mut at_nut = Form::new();
        for &(axial, angle, share) in &self.contacts {
            structure.inertia(axial, machine.nut.screw_mass_kg * share);
            structure.inertia(angle, machine.nut.screw_inertia_kg_m2 * share);
            let mut screw_side = vec![(axial, 1.0), (angle, machine.ratio_m())];
            screw_side.extend(&self.lateral);
            structure.branch(difference(&self.carrier, &screw_side), machine.nut.joint.law(share));
            at_nut.push((axial, share));
        }
        let frame_points = vec![
            (Point::Table, self.sensor),
            (Point::Rotor, vec![(self.rotor, 1.0)]),
            (Point::Left, vec![(self.ends[0].0, 1.0)]),
            (Point::Screw, at_nut),
            (Point::Right, vec![(self.ends[1].0, 1.0)]),
            (Point::NutBody, self.carrier),
            (Point::HousingLeft, self.housings[0].clone()),
            (Point::HousingRight, self.housings[1].clone()),
        ];
        Assembly { structure: self.structure, frame_points, hit: self.hit }
    }
}

enum Station {
    End(usize),
    Contact(f64),
    Extra,
}

/// Returns a − b as one form.
pub fn difference(a: &[(usize, f64)], b: &[(usize, f64)]) -> Form {
    a.iter().copied().chain(b.iter().map(|&(freedom, weight)| (freedom, -weight))).collect()
}

/// Motion of the screw that a rod describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Along the axis.
    Axial,
    /// About the axis.
    Torsion,
}

/// Models the screw between two positions: ten elements for each journal part, a power of two for the uniform
/// part.
pub fn rod(screw: &Screw, from_m: f64, to_m: f64, family: Family) -> Rod {
    let (modulus, section): (f64, &dyn Fn(f64) -> f64) = match family {
        Family::Axial => (screw.youngs_modulus_pa, &|diameter| screw.area(diameter)),
        Family::Torsion => (screw.shear_modulus_pa, &|diameter| screw.polar(diameter)),
    };
    let uniform_from = from_m.max(screw.left.length_m.min(to_m));
    let uniform_to = to_m.min((screw.length_m - screw.right.length_m).max(uniform_from));
    let largest = screw.length_m / screw.elements as f64;
    let mut stretches = Vec::new();
    let mut put = |start: f64, end: f64, pieces: u32, doublings: u32| {
        if end - start <= 0.0 {
            return;
        }
        let element = (end - start) / (f64::from(pieces) * f64::from(1u32 << doublings));
        for piece in 0..pieces {
            let middle = start + (end - start) * (f64::from(piece) + 0.5) / f64::from(pieces);
            let section = section(screw.diameter_at(middle));
            stretches.push(Stretch {
                stiffness: modulus * section / element,
                inertia: screw.density_kg_m3 * section * element,
                doublings,
            });
        }
    };
    put(from_m, uniform_from, 10, 0);
    let halvings = ((uniform_to - uniform_from) / largest).log2().ceil().max(1.0) as u32;
    put(uniform_from, uniform_to, 1, halvings);
    put(uniform_to, to_m, 10, 0);
    Rod { stretches }
}
