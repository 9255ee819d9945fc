//! What holds flesh to bone (Sec. 3.3): skinning targets and the springs to them.

mod pivot;
mod skin;
mod springs;

pub use pivot::Pivot;
pub use skin::{BoundNode, SkinTarget, skin_target};
pub(crate) use springs::add_part;
pub use springs::{BoneSystem, CouplingEntries, CouplingModel, EffectiveMass};

#[cfg(test)]
pub(crate) use pivot::tests::derivatives;
