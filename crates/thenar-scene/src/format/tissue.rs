//! Tissue: named materials, layers, skin and nails.

use super::LawWord;
use crate::text::{Located, table, words};
use thenar_core::model::Sheet;

words! {
    /// Materials of tissue as published; their marks of certainty are in `docs/theory.md`.
    pub enum TissueWord {
        /// 136 kPa, Poisson's ratio 0.48 (Maeno et al. 1998).
        "epidermis" => Epidermis,
        /// 80 kPa, 0.48 (Maeno et al. 1998).
        "dermis" => Dermis,
        /// 34 kPa, 0.48: fat under the skin (Maeno et al. 1998).
        "subcutis" => Subcutis,
        /// 50 kPa, 0.4: a fingertip as one material (touchSim, Saal et al. 2017).
        "pulp" => Pulp,
        /// Ogden's law, 35.3 kPa in shear and exponent 8.5, 0.48: superficial flexor tendons
        /// pressed across.
        "tendon" => Tendon,
    }
}

words! {
    /// Tissue of a hand where its keys do not say.
    pub enum HandTissueWord {
        /// One material.
        "uniform" => Uniform,
        /// Skin of 1.5 mm and 99 kPa over subcutis in pads and palm, and nails.
        "layered" => Layered,
    }
}

words! {
    /// A part of a hand.
    pub enum HandRegionWord {
        /// The palm's side of the last bones.
        "pad" => Pad,
        /// Nails and what lies under them.
        "nail" => Nail,
        /// The palm's side of all else.
        "palm" => Palm,
        /// The back of all else.
        "back" => Back,
        /// All of the hand.
        "all" => All,
    }
}

table! {
    /// Flesh between two depths under the skin; what is left out keeps the value of the hand's
    /// material.
    pub struct HandLayer {
        /// Region of the hand. Default "all".
        region: HandRegionWord = HandRegionWord::All;
        /// From and to [m]: 0 is the skin. An element that holds several layers has their mean by
        /// volume.
        depth: [f64; 2] where DEPTH;
        /// "epidermis", "dermis", "subcutis", "pulp" or "tendon": its law, modulus and Poisson's
        /// ratio.
        tissue: Option<Located<TissueWord>>;
        /// "corotational", "neo-hookean", "stable-neo-hookean" or "ogden". An element has the law
        /// of the larger part of its stiffness.
        law: Option<Located<LawWord>>;
        /// Exponent of Ogden's law, which it needs.
        alpha: Option<Located<f64>> where OGDEN;
        /// Young's modulus [Pa].
        young: Option<f64> where YOUNG;
        /// Poisson's ratio.
        poisson: Option<f64> where POISSON;
    }
}

table! {
    /// Skin: an elastic sheet on the surface that touches, stretched with the flesh under it.
    pub struct SkinTable {
        /// Thickness [m].
        thickness: f64 where THICKNESS;
        /// Young's modulus [Pa].
        young: f64 where YOUNG;
        /// Poisson's ratio. Default 0.48.
        poisson: f64 where POISSON = 0.48;
        /// Tension at rest along every direction [N/m]; flesh under it is pressed together until
        /// the two balance. Default 0.
        pretension: f64 where TENSION = 0.0;
        /// Strain at which compressed skin wrinkles and resists no more. Default 0.21; 0 resists
        /// tension alone.
        wrinkling: f64 where STRAIN = Sheet::WRINKLING;
    }
}

table! {
    /// Nails: plates on the backs of the last bones, tied to them by their beds where flesh hangs
    /// on bone.
    pub struct NailTable {
        /// Thickness [m]. Default 0.0005.
        thickness: f64 where THICKNESS = 5e-4;
        /// Young's modulus [Pa]. Default 2e6: a sheet of 1 kN/m, far stiffer than flesh at any
        /// mesh, while nails as stiff as people's, thousands of times more, shorten steps for
        /// nothing, since their beds hold them.
        young: f64 where YOUNG = 2e6;
        /// Poisson's ratio. Default 0.3.
        poisson: f64 where POISSON = 0.3;
    }
}
