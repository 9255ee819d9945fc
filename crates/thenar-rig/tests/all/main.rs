//! Builders and parsers, in one binary: `cargo test -p thenar-rig --test all hand::` runs a part.

#[path = "../../../../fuzz/src/bodies.rs"]
mod bodies;
mod cost;
mod crushed_fingertip;
#[path = "../damage/mod.rs"]
mod damage;
mod embed;
mod export;
mod export_json;
mod figures;
mod fuzz_builders;
mod fuzz_parsers;
mod graded_hand;
mod hand;
mod heard;
mod in_bone;
mod joint_stiffness;
mod mesh_limits;
mod mesh_shape;
mod objects;
mod pieces;
#[path = "../press/mod.rs"]
mod press;
mod regions;
mod rigs;
mod scans;
mod sculpted;
mod skinned_meshes;
mod support;
