//! Scenes that come with the program.

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct Builtin {
    /// Name of the scene.
    pub name: &'static str,
    /// Text of its file.
    pub text: &'static str,
}

macro_rules! scenes {
    ($($name:literal),* $(,)?) => {
        &[$(Builtin {
            name: $name,
            text: include_str!(concat!("../../scenes/", $name, ".toml")),
        }),*]
    };
}

const SCENES: &[Builtin] = scenes![
    "ball-grip",
    "body",
    "bread-grasp",
    "bread-squeeze",
    "car-grasp",
    "card",
    "egg",
    "falling-box",
    "finger-pendulum",
    "fist",
    "forearm",
    "free-motion",
    "glove-versus-hand",
    "gripper",
    "pen",
    "pinch",
    "skinning-comparison",
    "soft-cube",
    "table-press",
    "two-hands",
];

/// All of them.
pub fn builtins() -> &'static [Builtin] {
    SCENES
}

/// The one with this name.
pub fn builtin(name: &str) -> Option<&'static Builtin> {
    SCENES.iter().find(|scene| scene.name == name)
}
