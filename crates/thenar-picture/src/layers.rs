//! Selection of the parts of a simulation that are drawn.

use std::str::FromStr;

/// The parts to draw. Rigid objects and the ground are always drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layers {
    /// The render surface of deformable bodies; translucent when bones or flesh are drawn too.
    pub skin: bool,
    /// The edges of the tetrahedra.
    pub flesh: bool,
    /// Bones and joints (hinges blue, universal joints red, others grey).
    pub bones: bool,
    /// The hand where its tracker has it, without contact, in translucent yellow.
    pub tracked: bool,
    /// The render surface by skinning alone, in place of the skin.
    pub targets: bool,
    /// Contact points and normals.
    pub contacts: bool,
    /// Contact forces.
    pub forces: bool,
    /// Contact pressure as the skin's colour.
    pub pressure: bool,
    /// The bone that carries most, as the skin's colour.
    pub weights: bool,
}

/// Names as a user writes them.
pub const LAYER_NAMES: [&str; 9] =
    ["skin", "flesh", "bones", "tracked", "targets", "contacts", "forces", "pressure", "weights"];

impl Layers {
    /// Skin only.
    pub fn skin() -> Self {
        Self { skin: true, ..Self::default() }
    }

    /// Something is drawn inside the skin.
    pub fn see_through(&self) -> bool {
        self.bones || self.flesh
    }

    fn layer(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "skin" => &mut self.skin,
            "flesh" => &mut self.flesh,
            "bones" => &mut self.bones,
            "tracked" => &mut self.tracked,
            "targets" => &mut self.targets,
            "contacts" => &mut self.contacts,
            "forces" => &mut self.forces,
            "pressure" => &mut self.pressure,
            "weights" => &mut self.weights,
            _ => return None,
        })
    }
}

impl FromStr for Layers {
    type Err = String;

    /// Reads names separated by commas.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut layers = Self::default();
        for name in text.split(',').map(str::trim).filter(|name| !name.is_empty()) {
            match layers.layer(name) {
                Some(layer) => *layer = true,
                None => {
                    let known = LAYER_NAMES.join(", ");
                    return Err(format!("no layer is called \"{name}\"; there are {known}"));
                }
            }
        }
        // Colours need a surface to lie on.
        layers.skin |= layers.pressure || layers.weights;
        Ok(layers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_switches_its_own_layer() {
        for name in LAYER_NAMES {
            let layers: Layers = name.parse().expect(name);
            assert_ne!(layers, Layers::default(), "{name}");
        }
        let two: Layers = "skin, contacts".parse().expect("two");
        assert_eq!(two, Layers { skin: true, contacts: true, ..Layers::default() });
        let fault = "skin,nails".parse::<Layers>().expect_err("no nails");
        assert!(fault.contains("\"nails\"") && fault.contains("pressure"), "{fault}");
    }
}
