//! Soft bodies.

use super::{Rotation, Selector, SkinTable, SkinningWord, TissueWord};
use crate::math::Vec3;
use crate::text::{Cx, Defs, Fault, Located, Node, Read, choice, table, words};
use thenar_core::model::{Coupling, TERMS_MAX};

words! {
    /// Division of a lattice cell into tetrahedra.
    pub enum SplitWord {
        /// Six around the diagonal from the least to the greatest corner.
        "kuhn" => Kuhn,
        /// Five, mirrored from cell to cell.
        "five" => Five,
    }
}

table! {
    /// A box of cells, each cut into tetrahedra: `size` with `cells` (centred on the origin), or
    /// the coordinates of the cell planes.
    pub struct LatticeShape {
        /// Edge lengths [m].
        size: Option<Vec3> where SIZE;
        /// Cells along x, y, z.
        cells: Option<[u32; 3]> where CELLS;
        /// Coordinates of the cell planes along x, y and z [m], each ascending.
        coordinates: Option<[Vec<f64>; 3]> where PLACE;
        /// "kuhn" (default) or "five" tetrahedra per cell.
        split: SplitWord = SplitWord::Kuhn;
        /// Moves inner nodes at random by up to this part of the cell. Default 0.
        jitter: f64 where JITTER = 0.0;
        /// Seed of the jitter. Default 1.
        seed: u32 where INDEX = 1;
    }
}

table! {
    /// A ball of shells of triangles, perhaps with a hollow core to bind or fix.
    pub struct BallShape {
        /// Outer radius [m].
        radius: f64 where SIZE;
        /// Radius of the core left out [m]. Default 0: none.
        core_radius: f64 where CORE = 0.0;
        /// Each face of an icosahedron is split into the square of this many triangles.
        /// Default 6.
        frequency: u32 where FREQUENCY = 6;
        /// Layers of elements. Default 4.
        layers: u32 where CELLS = 4;
        /// Thickness of each layer over that of the one outside it. Default 1.
        growth: f64 where GRADING = 1.0;
        /// Elements at the pole -y are finer by this factor, those at +y as much coarser.
        /// Default 1.
        focus: f64 where GRADING = 1.0;
    }
}

table! {
    /// A closed triangle mesh from a file (GLB, OBJ, STL, PLY, OFF), embedded in tetrahedra; or a
    /// model file (`.thenar`) of a soft body, with its own materials, such as `thenar build --soft`
    /// makes of a mesh with holes.
    pub struct MeshSoftShape {
        /// Path, relative to the scene file.
        file: Located<String>;
        /// Factor on all coordinates, 0.001 for a mesh in mm. Default 1.
        scale: f64 where SCALE = 1.0;
        /// Tetrahedra wanted. Default 1000.
        tets: u32 where TETS = 1000;
    }
}

table! {
    /// The built-in loaf of bread, lying along x, its bottom on y = 0.
    pub struct BreadShape {
        /// Length, height and width (x, y, z) [m]. Default [0.18, 0.09, 0.09].
        size: Option<Vec3> where SIZE;
        /// Lattice cells along x, y, z, five elements each. Default [8, 4, 4].
        cells: Option<[u32; 3]> where CELLS;
        /// Young's modulus of the crust over that of the crumb. Default 3; 1 is no crust.
        crust: Option<f64> where GRADING;
    }
}

table! {
    /// Nodes and tetrahedra written out.
    pub struct ExplicitShape {
        /// Node positions [m].
        nodes: Located<Vec<Vec3>> where PLACE;
        /// Four node indices for each tetrahedron, in either orientation.
        tets: Located<Vec<[u32; 4]>> where INDEX;
    }
}

table! {
    /// Nodes and tetrahedra from a file: TOML with `nodes` and `tets`, as written out.
    pub struct FileShape {
        /// Path, relative to the scene file.
        file: Located<String>;
        /// Factor on all coordinates. Default 1.
        scale: f64 where SCALE = 1.0;
    }
}

choice! {
    /// The rest shape of a soft body.
    pub enum SoftShape by "kind" {
        /// A box of cells.
        "lattice" => Lattice(LatticeShape),
        /// A ball, perhaps with a core.
        "ball" => Ball(BallShape),
        /// A closed triangle mesh, embedded.
        "mesh" => Mesh(MeshSoftShape),
        /// A loaf of bread.
        "bread" => Bread(BreadShape),
        /// Nodes and tetrahedra written out.
        "tets" => Explicit(ExplicitShape),
        /// Nodes and tetrahedra from a file.
        "tet-file" => File(FileShape),
    }
}

words! {
    /// Constitutive law.
    pub enum LawWord {
        /// Linear elasticity in the element's rotated frame.
        "corotational" => Corotational,
        /// μ/2 (I₁ − 3) − μ ln J + λ/2 ln² J.
        "neo-hookean" => NeoHookean,
        /// Neo-Hookean that stays finite when an element inverts.
        "stable-neo-hookean" => StableNeoHookean,
        /// Ogden's of one term, 2μ/α² (Σσ^α − 3) where volume is kept; stays finite when an element
        /// inverts.
        "ogden" => Ogden,
    }
}

table! {
    /// A material; what is left out keeps the value of the body's material, or the default.
    pub struct MaterialTable {
        /// "epidermis", "dermis", "subcutis", "pulp" or "tendon": law, modulus and Poisson's ratio,
        /// on which the keys below act.
        tissue: Option<Located<TissueWord>>;
        /// "corotational" (default), "neo-hookean" (default of bread), "stable-neo-hookean" or
        /// "ogden".
        law: Option<Located<LawWord>>;
        /// Exponent of Ogden's law, which it needs; pulp and skin have 6 to 11.
        alpha: Option<Located<f64>> where OGDEN;
        /// Young's modulus [Pa]. Default 50 000; of bread 12 000.
        young: Option<f64> where YOUNG;
        /// Shear modulus [Pa] in the place of `young`, which is then 2 (1 + `poisson`) times it.
        mu: Option<Located<f64>> where YOUNG;
        /// Poisson's ratio. Default 0.4; of bread 0.25.
        poisson: Option<f64> where POISSON;
        /// Density [kg/m³]. Default 1000; of bread 250.
        density: Option<f64> where DENSITY;
        /// Memory: [part, time in s] of up to 4 exponentials by which the stress of a held strain
        /// fades; parts sum to less than 1. Moduli are those at once. Elements with memory have no
        /// `stiffness_damping`. Default [].
        relaxation: Option<Located<Terms>> where POSITIVE;
    }
}

/// The terms of a relaxation: part and time \[s\].
#[derive(Clone, Debug)]
pub struct Terms(pub Vec<[f64; 2]>);

impl Read for Terms {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        Vec::read(node, cx).map(Self)
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> serde_json::Value {
        let mut schema = Vec::<[f64; 2]>::schema(defs, cx);
        schema["maxItems"] = TERMS_MAX.into();
        schema
    }
}

table! {
    /// A part of the body with its own material; later parts win.
    pub struct Region {
        /// Elements of the region.
        elements: Located<Selector>;
        /// Material of the region.
        material: MaterialTable;
    }
}

table! {
    /// Nodes that are held where they start.
    pub struct FixedSet {
        /// Nodes that are fixed.
        nodes: Located<Selector>;
        /// World axes along which they are held, e.g. "xyz" (default) or "x".
        axes: Option<Located<String>>;
    }
}

table! {
    /// Nodes bound to one or two rigid bodies by springs to their skinned place (Eq. 6-9).
    pub struct Bind {
        /// Nodes that are bound.
        nodes: Located<Selector>;
        /// Names of one or two rigid bodies ("bones").
        bones: Located<Vec<String>>;
        /// Weights of the bodies, of sum 1. Default: equal.
        weights: Located<Vec<f64>> where FRACTION = Located::none();
        /// Spring per volume of flesh [N/m⁴]; without `node_stiffness`. Default 1e9.
        stiffness: Option<f64> where SPRING;
        /// Spring of each node [N/m].
        node_stiffness: Option<f64> where SPRING;
        /// Offsets of these nodes' places by the pose of the joint between two bones: interpolated
        /// between poses, zero at rest. Far from all poses they fade.
        pose_offset: Vec<Located<PoseOffsetTable>>;
    }
}

table! {
    /// An offset of skinning targets at one pose of a joint.
    pub struct PoseOffsetTable {
        /// Rotation of the joint's child from rest against its parent, in the parent's axes.
        rotation: Located<Rotation>;
        /// Offset at rest [m], in the axes of the body's model frame; the bones carry it along.
        offset: Vec3 where PLACE;
    }
}

table! {
    /// A start deformation of the rest shape, in the model frame: x = matrix · X + offset.
    pub struct Deform {
        /// Rows of the matrix. Default: the unit matrix.
        matrix: [Vec3; 3] where PLACE = [Vec3::x(), Vec3::y(), Vec3::z()];
        /// Offset [m]. Default [0, 0, 0].
        offset: Vec3 where PLACE = Vec3::zeros();
        /// Nodes that are displaced. Default: all.
        nodes: Option<Located<Selector>>;
    }
}

words! {
    /// Evaluation of the elements of soft bodies.
    pub enum ElementsWord {
        /// Each by itself, as in the paper: stiffer than flesh where the mesh is coarse or hardly
        /// compressible.
        "tetrahedra" => Tetrahedra,
        /// All around one long edge together.
        "patches" => Patches,
    }
}

table! {
    /// A soft body of linear tetrahedra.
    pub struct Soft {
        /// Name, unique in the scene.
        name: Located<String>;
        /// Rest shape.
        shape: Located<SoftShape>;
        /// Material of the body.
        material: Option<MaterialTable>;
        /// Parts with other materials.
        region: Vec<Region>;
        /// Skin on the surface.
        skin: Option<Located<SkinTable>>;
        /// "tetrahedra": each by itself; "patches": those around one long edge share one evaluation
        /// of their law, which a coarse or hardly compressible mesh needs to bend as it should.
        /// Default "tetrahedra".
        elements: ElementsWord = ElementsWord::Tetrahedra;
        /// Rayleigh damping: part of the mass matrix [1/s]. Default 0; of bread 0.5.
        mass_damping: Option<f64> where SPRING;
        /// Rayleigh damping: part of the stiffness matrix [s]. Default 0; of bread 0.005.
        stiffness_damping: Option<f64> where SPRING;
        /// Start position of the model frame, world [m]. Default [0, 0, 0].
        position: Vec3 where PLACE = Vec3::zeros();
        /// Start rotation. Default none.
        rotation: Option<Located<Rotation>>;
        /// Start velocity of all nodes, world [m/s]. Default [0, 0, 0].
        velocity: Vec3 where RATE = Vec3::zeros();
        /// Start deformations, in turn.
        deform: Vec<Located<Deform>>;
        /// Held nodes.
        fixed: Vec<FixedSet>;
        /// Nodes bound to rigid bodies.
        bind: Vec<Bind>;
        /// Damping time of these bonds: damper = time × spring [s]. Default 0.001.
        bind_damping_time: f64 where SPRING = Coupling::DAMPING_TIME;
        /// Placement of a node that two bones carry: "lbs", linear blend skinning; "joint",
        /// rotations blended about the joint between them, which they must have. Default "lbs".
        skinning: SkinningWord = SkinningWord::Lbs;
        /// False makes the body touch nothing. Default true.
        contact: bool = true;
        /// True: its surface touches itself, for bodies that fold. Skin on skin has its `friction`,
        /// or that of a pair of the body with itself. Default false.
        self_contact: bool = false;
        /// Coulomb friction coefficient. Default 0.5.
        friction: f64 where FRICTION = 0.5;
        /// Colour in pictures: red, green, blue from 0 to 1.
        colour: Option<[f64; 3]> where FRACTION;
    }
}
