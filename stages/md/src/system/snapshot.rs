//! The atoms as bytes: all of a system that its next step depends on.
use super::System;
use crate::force::{Kept, Sums};
use crate::lanes::Isa;
use crate::neighbor::List;
use crate::table::Tables;
use serde::{Deserialize, Serialize};

/// A system at rest between two steps. It goes on from there with the same bits: the neighbour list is part of it, because
/// its order is the order of the sums.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Snapshot {
    edges: [f64; 3],
    listed_edges: [f64; 3],
    skin: f64,
    position: Vec<[f64; 4]>,
    velocity: Vec<[f64; 4]>,
    force: Vec<[f64; 4]>,
    site: Vec<[f64; 4]>,
    listed: Vec<[f64; 4]>,
    id: Vec<u32>,
    list: List,
    energy: f64,
    virial: [f64; 3],
    twice_kinetic: [f64; 3],
    middle_kinetic: [f64; 3],
    site_virial: f64,
    step: u64,
    time: f64,
    rebuilds: u64,
}

impl System {
    /// What it is now.
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            edges: self.edges,
            listed_edges: self.listed_edges,
            skin: self.skin,
            position: self.position.clone(),
            velocity: self.velocity.clone(),
            force: self.force.clone(),
            site: self.site.clone(),
            listed: self.listed.clone(),
            id: self.id.clone(),
            list: self.list.clone(),
            energy: self.sums.energy,
            virial: self.sums.virial,
            twice_kinetic: self.twice_kinetic,
            middle_kinetic: self.middle_kinetic,
            site_virial: self.site_virial,
            step: self.step,
            time: self.time,
            rebuilds: self.rebuilds,
        }
    }

    /// The system that a snapshot was taken of; `tables` are those it had.
    pub fn resume(tables: Tables, isa: Isa, from: Snapshot) -> System {
        let atoms = from.velocity.len();
        let mut kept = Kept::default();
        kept.fit(&from.list);
        System {
            mass: System::mass_of(&tables),
            tables,
            isa,
            edges: from.edges,
            listed_edges: from.listed_edges,
            skin: from.skin,
            position: from.position,
            velocity: from.velocity,
            force: from.force,
            site: from.site,
            listed: from.listed,
            id: from.id,
            list: from.list,
            density: vec![0.0; atoms + 1],
            kept,
            sums: Sums { energy: from.energy, virial: from.virial, nearest2: 0.0, too_dense: None },
            twice_kinetic: from.twice_kinetic,
            middle_kinetic: from.middle_kinetic,
            site_virial: from.site_virial,
            step: from.step,
            time: from.time,
            rebuilds: from.rebuilds,
        }
    }
}
