//! Coupling of flesh to bone (Sec. 3.3): skinning targets and the springs to them.

mod offsets;
mod pivot;
mod skin;
mod springs;

pub use offsets::{KernelValue, NodeOffset, OffsetModel, PairAtRest, PosedOffsets};
pub use pivot::Pivot;
pub use skin::{BoundNode, SkinTarget, skin_target};
pub(crate) use springs::add_part;
pub use springs::{BoneSystem, CouplingEntries, CouplingModel, EffectiveMass};
