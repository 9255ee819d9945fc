//! Hands of scenes: bones, joints, layers, meshes, and how they behave.

mod bone_coupling;
mod bones;
mod crushed_tip;
mod elements;
mod finger_area;
mod hand_mesh;
mod hands;
mod joints;
mod layers;
mod skinning;
mod tips;
mod touch_hand;
