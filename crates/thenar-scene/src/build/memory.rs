//! Memory that a scene's bodies take, told and bounded before they are built.

use crate::text::Fault;
use thenar_core::model::Relaxation;
use thenar_core::shape::Shape;

/// Memory of a tetrahedron while it is simulated, with its share of nodes, matrices and surface
/// \[bytes\]: balls of 20 000 to 450 000 tetrahedra take 1200 to 1510 with the monolithic solver.
pub const TET_BYTES: u64 = 1600;
/// Memory of a triangle of a rigid body's mesh, its tree and its picture included \[bytes\].
const TRIANGLE_BYTES: u64 = 600;
/// Memory of any rigid body besides \[bytes\]: 30 000 spheres take 15 400 each.
pub(super) const RIGID_BYTES: u64 = 16_000;
/// Memory that all bodies of a scene may take \[bytes\].
pub const BODIES_BYTES_MAX: u64 = 850_000_000;

/// Memory taken so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Memory {
    bytes: u64,
}

impl Memory {
    /// Takes the memory of a number of tetrahedra; called before they are made.
    ///
    /// # Errors
    /// The sum exceeds the memory there is, in which case `at` makes the fault.
    pub fn take_tets(&mut self, tets: u64, at: impl Fn(String) -> Fault) -> Result<(), Fault> {
        self.take(tets.saturating_mul(TET_BYTES), &format!("{tets} tetrahedra"), at)
    }

    /// Takes what tetrahedra need besides to remember: their relaxation in the description, in that
    /// which settings start from and in the model, and what has faded by each term in the state, in
    /// a copy of it and in a keyframe.
    ///
    /// # Errors
    /// As [`Memory::take_tets`].
    pub fn take_relaxation(
        &mut self,
        of: &[Relaxation],
        at: impl Fn(String) -> Fault,
    ) -> Result<(), Fault> {
        let terms: usize = of.iter().map(|r| r.terms().len()).sum();
        let bytes = 3 * size_of_val(of) + 3 * terms * size_of::<[f64; 6]>();
        self.take(bytes as u64, "memory of tissue", at)
    }

    /// Takes what a rigid body of this shape needs.
    ///
    /// # Errors
    /// As [`Memory::take_tets`].
    pub fn take_shape(
        &mut self,
        shape: Option<&Shape>,
        at: impl Fn(String) -> Fault,
    ) -> Result<(), Fault> {
        self.take(RIGID_BYTES + shape.map_or(0, shape_bytes), "this body", at)
    }

    fn take(&mut self, more: u64, what: &str, at: impl Fn(String) -> Fault) -> Result<(), Fault> {
        let bytes = self.bytes.saturating_add(more);
        if bytes > BODIES_BYTES_MAX {
            return Err(at(format!(
                "{what} would bring the memory of all bodies to about {}, more than {}",
                size(bytes),
                size(BODIES_BYTES_MAX)
            )));
        }
        self.bytes = bytes;
        Ok(())
    }
}

fn shape_bytes(shape: &Shape) -> u64 {
    match shape {
        Shape::Mesh(mesh) => {
            4 * mesh.grid.values.len() as u64 + TRIANGLE_BYTES * mesh.triangles.len() as u64
        }
        Shape::Compound(parts) => {
            parts.iter().map(|part| 500 + shape_bytes(&part.shape)).sum::<u64>()
        }
        _ => 0,
    }
}

/// Bytes for a person.
fn size(bytes: u64) -> String {
    match bytes {
        0..1_000_000_000 => format!("{} MB", bytes.div_ceil(1_000_000)),
        _ => format!("{:.1} GB", bytes as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::text::SourcePlace;

    #[test]
    fn what_is_too_much_is_refused_with_both_numbers() {
        let mut memory = Memory::default();
        let at = |problem: String| Fault::new(&SourcePlace::Text(0..0), "soft[1].shape", problem);
        memory.take_tets(500_000, at).unwrap();
        let fault = memory.take_tets(1_500_000, at).unwrap_err();
        assert_eq!(
            fault.problem,
            "1500000 tetrahedra would bring the memory of all bodies to about 3.2 GB, more than 850 MB"
        );
        // What was refused is not counted.
        memory.take_tets(31_250, at).unwrap();
        assert!(memory.take_shape(None, at).is_err());
        assert!(memory.take_tets(u64::MAX, at).is_err());
    }
}
