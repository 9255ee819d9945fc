//! Rigid bodies.

use super::{DriveTable, InterpolationWord, Keyframe, Placement, Rotation};
use crate::math::Vec3;
use crate::text::{Located, choice, table, words};

table! {
    /// A box, its centre at the origin.
    pub struct BoxShape {
        /// Edge lengths along x, y, z [m].
        size: Vec3 where SIZE;
    }
}

table! {
    /// A sphere, its centre at the origin.
    pub struct SphereShape {
        /// Radius [m].
        radius: f64 where SIZE;
    }
}

table! {
    /// A rounded segment along y, its centre at the origin.
    pub struct CapsuleShape {
        /// Radius [m].
        radius: f64 where SIZE;
        /// Length of the segment, caps excluded [m].
        length: f64 where SIZE;
    }
}

table! {
    /// A cylinder along y, its centre at the origin.
    pub struct CylinderShape {
        /// Radius [m].
        radius: f64 where SIZE;
        /// Length from end to end [m].
        length: f64 where SIZE;
    }
}

table! {
    /// An ellipsoid, its centre at the origin.
    pub struct EllipsoidShape {
        /// Whole axes along x, y, z [m].
        size: Vec3 where SIZE;
    }
}

table! {
    /// A cone along y, apex up. The origin is its centre of mass: the base lies a quarter of the
    /// height below it.
    pub struct ConeShape {
        /// Radius of the base [m].
        radius: f64 where SIZE;
        /// Height [m].
        height: f64 where SIZE;
    }
}

table! {
    /// Several shapes as one rigid body. Its mass is that of the parts, each weighed for itself:
    /// where they overlap, twice. As with a mesh, `position`, `rotation` and `keyframes` place the
    /// frame that the parts are given in; the body's own frame has its origin at the centre of
    /// mass.
    pub struct CompoundShape {
        /// At least one.
        parts: Vec<Located<CompoundPart>>;
    }
}

table! {
    /// A part of a compound.
    pub struct CompoundPart {
        /// Any shape but a plane, a car and a compound.
        shape: Located<Shape>;
        /// Placement in the compound's frame. Default: the same frame.
        frame: Option<Placement>;
    }
}

table! {
    /// All points with y <= 0; its normal is +y. Not for dynamic bodies.
    pub struct PlaneShape {}
}

table! {
    /// The built-in toy car; it drives along +x, its wheels stand on y = 0. It weighs 0.1 kg
    /// unless the body says otherwise.
    pub struct CarShape {
        /// Length [m]. Default 0.072.
        length: f64 where SIZE = 0.072;
    }
}

table! {
    /// A triangle mesh from a file (GLB, OBJ, STL, PLY, OFF). It may be open or of many parts:
    /// inside is where the generalised winding number is at least ½; a mesh without inside becomes
    /// a shell. Or a model file (`.thenar`) of a rigid body, which has its own mass.
    pub struct MeshShape {
        /// Path, relative to the scene file.
        file: Located<String>;
        /// Factor on all coordinates, 0.001 for a mesh in mm. Default 1.
        scale: f64 where SCALE = 1.0;
        /// Cells of the distance grid along the longest edge. Default 56.
        grid: u32 where GRID = 56;
    }
}

choice! {
    /// A contact shape in the body's frame.
    pub enum Shape by "kind" {
        /// A box.
        "box" => Box(BoxShape),
        /// A sphere.
        "sphere" => Sphere(SphereShape),
        /// A capsule along y.
        "capsule" => Capsule(CapsuleShape),
        /// A cylinder along y.
        "cylinder" => Cylinder(CylinderShape),
        /// An ellipsoid.
        "ellipsoid" => Ellipsoid(EllipsoidShape),
        /// A cone along y.
        "cone" => Cone(ConeShape),
        /// Several shapes as one body.
        "compound" => Compound(CompoundShape),
        /// A half space below y = 0.
        "plane" => Plane(PlaneShape),
        /// The built-in toy car.
        "car" => Car(CarShape),
        /// A triangle mesh from a file.
        "mesh" => Mesh(MeshShape),
    }
}

words! {
    /// Motion of a rigid body.
    pub enum MotionWord {
        /// By forces.
        "dynamic" => Dynamic,
        /// Not at all.
        "fixed" => Fixed,
        /// By its keyframes; without keyframes at its constant velocity.
        "scripted" => Scripted,
    }
}

table! {
    /// A rigid body. Its frame has its origin at the centre of mass. Of a mesh, car or compound,
    /// `position`, `rotation` and `keyframes` place the frame of the file or of the parts instead;
    /// everything else, probes too, uses the centre of mass.
    pub struct Rigid {
        /// Name, unique in the scene.
        name: Located<String>;
        /// Contact shape; without one the body touches nothing.
        shape: Option<Located<Shape>>;
        /// Placement of the shape in the body's frame. Default: the same frame.
        shape_frame: Option<Placement>;
        /// "dynamic" (default), "fixed" or "scripted".
        motion: MotionWord = MotionWord::Dynamic;
        /// Mass [kg]. A dynamic body needs `mass` or `density`.
        mass: Option<f64> where MASS;
        /// Density of its shape [kg/m³].
        density: Option<f64> where DENSITY;
        /// Inertia about the centre of mass in the body's frame [kg m²]: [Ixx, Iyy, Izz] or
        /// [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]. Left out, that of the homogeneous shape.
        inertia: Option<Located<Vec<f64>>> where INERTIA;
        /// Start position, world [m]. Default [0, 0, 0].
        position: Option<Located<Vec3>> where PLACE;
        /// Start rotation. Default none.
        rotation: Option<Located<Rotation>>;
        /// Start velocity of the centre of mass, world [m/s]. Default [0, 0, 0].
        velocity: Vec3 where RATE = Vec3::zeros();
        /// Start angular velocity, world [rad/s]. Default [0, 0, 0].
        angular_velocity: Vec3 where RATE = Vec3::zeros();
        /// Coulomb friction coefficient. Default 0.5.
        friction: f64 where FRICTION = 0.5;
        /// Pose over time: of a scripted body, or of the target of `drive`.
        keyframes: Vec<Located<Keyframe>>;
        /// Between keyframes: "smooth" (default) or "linear".
        interpolation: InterpolationWord = InterpolationWord::Smooth;
        /// Pulls a dynamic body towards its keyframes, or towards its start pose.
        drive: Option<Located<DriveTable>>;
        /// Colour in pictures: red, green, blue from 0 to 1.
        colour: Option<[f64; 3]> where FRACTION;
    }
}
