//! Files that a scene names.

use super::{MotionTable, Scene, Shape, SoftShape};
use crate::text::Located;
use std::collections::BTreeSet;
use thenar_rig::figure::SHIPPED;

/// Hands that are in the program.
const BUILT_IN: [&str; 2] = ["right", "left"];

impl Scene {
    /// Files that bodies and motions come from, as the scene calls them: what is read beside its
    /// text when it is built.
    pub fn files(&self) -> BTreeSet<&str> {
        let mut found: Vec<&Located<String>> = Vec::new();
        let shapes = self.rigid.iter().filter_map(|rigid| rigid.shape.as_ref());
        shapes.for_each(|shape| of_shape(&shape.value, &mut found));
        for soft in &self.soft {
            match &soft.shape.value {
                SoftShape::Mesh(mesh) => found.push(&mesh.file),
                SoftShape::File(tets) => found.push(&tets.file),
                SoftShape::Lattice(_)
                | SoftShape::Ball(_)
                | SoftShape::Bread(_)
                | SoftShape::Explicit(_) => {}
            }
        }
        let figures = self.figure.iter().map(|figure| &figure.model);
        found.extend(figures.filter(|model| !SHIPPED.contains(&model.value.as_str())));
        for hand in &self.hand {
            let model = hand.model.as_ref();
            found.extend(model.filter(|model| !BUILT_IN.contains(&model.value.as_str())));
            match hand.motion.as_ref().map(|motion| &motion.value) {
                Some(MotionTable::Recorded(recorded)) => found.push(&recorded.file),
                Some(MotionTable::File(motion)) => found.push(&motion.file),
                Some(MotionTable::Keyframes(_)) | None => {}
            }
        }
        found.into_iter().map(|file| file.value.as_str()).collect()
    }
}

fn of_shape<'a>(shape: &'a Shape, found: &mut Vec<&'a Located<String>>) {
    match shape {
        Shape::Mesh(mesh) => found.push(&mesh.file),
        Shape::Compound(compound) => {
            compound.parts.iter().for_each(|part| of_shape(&part.value.shape.value, found));
        }
        Shape::Box(_)
        | Shape::Sphere(_)
        | Shape::Capsule(_)
        | Shape::Cylinder(_)
        | Shape::Ellipsoid(_)
        | Shape::Cone(_)
        | Shape::Plane(_)
        | Shape::Car(_) => {}
    }
}
