//! Meshes of a scene that may be in another unit than metres.

use super::Session;
use crate::format::{Shape as Table, SoftShape};
use crate::grip::bounds;
use crate::text::Located;
use thenar_core::Vec3;
use thenar_core::model::Motion;
use thenar_core::shape::Shape;
use thenar_rig::object::{Extent, mass_in_words, size_in_words, unit_question};

/// A mesh as a scene names it.
struct NamedMesh<'a> {
    file: &'a Located<String>,
    scale: f64,
    /// Edge lengths of its box \[m\].
    size: Vec3,
}

impl NamedMesh<'_> {
    /// Asks about the unit of a mesh that is too long or too short, or heavier than what hands move
    /// where there are any. `mass` \[kg\] is that of the body that it is; 0 leaves it out. What
    /// stands `still` may be a room.
    fn question(&self, mass: f64, still: bool, hands: bool) -> Option<String> {
        let counted = if hands { mass } else { 0.0 };
        let body = Extent { longest: self.size.max(), mass: counted, still };
        let question = unit_question(&body, self.scale, "scale = ")?;
        let weight = match mass > 0.0 {
            true => format!(" and weighs {}", mass_in_words(mass)),
            false => String::new(),
        };
        let (key, file, size) = (&self.file.key, &self.file.value, size_in_words(&self.size));
        Some(format!("`{key}`: {file} measures {size}{weight}: {question}"))
    }
}

impl Session {
    /// A question for each mesh that is longer or shorter than what hands hold, or heavier than
    /// what they move, with the scale that would make it so.
    pub(super) fn unit_questions(&self) -> Vec<String> {
        self.rigid_questions().chain(self.soft_questions()).collect()
    }

    fn rigid_questions(&self) -> impl Iterator<Item = String> {
        let hands = !self.scene.hand.is_empty();
        let rigids = self.scene.rigid.iter().zip(&self.world.desc().rigids);
        rigids.flat_map(move |(table, rigid)| {
            let still = rigid.motion != Motion::Dynamic;
            let whole = matches!(rigid.shape, Some(Shape::Mesh(_)));
            let mass = if whole && !still { rigid.mass } else { 0.0 };
            let mut meshes = Vec::new();
            if let (Some(table), Some(shape)) = (&table.shape, &rigid.shape) {
                add_meshes(&table.value, shape, &mut meshes);
            }
            meshes.into_iter().filter_map(move |mesh| mesh.question(mass, still, hands))
        })
    }

    fn soft_questions(&self) -> impl Iterator<Item = String> {
        // Figures come before.
        let hands = !self.scene.hand.is_empty();
        let built = self.built.softs.iter().skip(self.built.figures.len());
        self.scene.soft.iter().zip(built).filter_map(move |(table, built)| {
            let (file, scale) = match &table.shape.value {
                SoftShape::Mesh(mesh) if !is_model(&mesh.file) => (&mesh.file, mesh.scale),
                SoftShape::File(tets) => (&tets.file, tets.scale),
                _ => return None,
            };
            let flesh = &self.world.desc().softs[built.soft as usize].flesh;
            let mut places = vec![Vec3::zeros(); built.render.vertices.len()];
            built.render.positions(&flesh.tets, &flesh.nodes, &mut places);
            let first = *places.first()?;
            let [low, high] =
                places.iter().fold([first; 2], |[low, high], p| [low.inf(p), high.sup(p)]);
            let mass = self.world.node_masses(built.soft).iter().sum();
            NamedMesh { file, scale, size: high - low }.question(mass, false, hands)
        })
    }
}

/// The meshes of a shape; of a compound, of its parts.
fn add_meshes<'a>(table: &'a Table, shape: &Shape, found: &mut Vec<NamedMesh<'a>>) {
    match (table, shape) {
        (Table::Mesh(mesh), Shape::Mesh(_)) if !is_model(&mesh.file) => {
            let [_, half] = bounds(shape);
            found.push(NamedMesh { file: &mesh.file, scale: mesh.scale, size: half * 2.0 });
        }
        (Table::Compound(compound), Shape::Compound(parts)) => {
            let tables = compound.parts.iter().map(|part| &part.value.shape.value);
            tables.zip(parts.iter()).for_each(|(table, part)| {
                add_meshes(table, &part.shape, found);
            });
        }
        _ => {}
    }
}

/// True of a built model, which has the size that it was built in.
fn is_model(file: &Located<String>) -> bool {
    file.value.ends_with(".thenar")
}
