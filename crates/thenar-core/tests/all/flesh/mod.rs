//! Flesh alone: constitutive laws, elements, memory, layers and skin.

mod elastic_solids;
mod element_patches;
mod layered_slab;
mod memory;
mod memory_passive;
mod ogden;
mod skin;
