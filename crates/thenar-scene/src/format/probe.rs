//! Probes.

use super::Selector;
use crate::math::Vec3;
use crate::text::{Located, choice, table, words};

table! {
    /// A probe of the whole scene.
    pub struct ProbeName {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
    }
}

table! {
    /// A probe of one body.
    pub struct ProbeBody {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The body; a bone is `hand/bone`, a hand's own name is its flesh.
        body: Located<String>;
    }
}

table! {
    /// A probe of one hand.
    pub struct ProbeHand {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The hand.
        hand: Located<String>;
    }
}

table! {
    /// Momentum of some bodies, or of all that move.
    pub struct ProbeMomentum {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The bodies; a hand's name with `/*` stands for all its bones. Default: all.
        bodies: Option<Located<Vec<String>>>;
        /// Point for the angular momentum, world [m]. Default: the bodies' centre of mass.
        about: Option<Vec3> where PLACE;
    }
}

table! {
    /// A point that moves with a rigid body.
    pub struct PointProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The rigid body; a bone is `hand/bone`.
        body: Located<String>;
        /// The point in the body's frame [m]. Default: the centre of mass.
        point: Vec3 where PLACE = Vec3::zeros();
    }
}

table! {
    /// A joint's angles and rates.
    pub struct JointProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The joint; of a hand, `hand/joint`.
        joint: Located<String>;
    }
}

words! {
    /// Quantity that is averaged over nodes.
    pub enum QuantityWord {
        /// Place, world [m].
        "position" => Position,
        /// Place less the place of the undeformed body at its start pose [m].
        "displacement" => Displacement,
        /// Velocity, world [m/s].
        "velocity" => Velocity,
        /// The place that the bones wish (f of Eq. 6) [m].
        "target" => Target,
    }
}

table! {
    /// A mean over nodes of a soft body.
    pub struct NodesProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The soft body or hand.
        body: Located<String>;
        /// Nodes that are measured. Default: all.
        nodes: Option<Located<Selector>>;
        /// "position" (default), "displacement", "velocity" or "target".
        quantity: QuantityWord = QuantityWord::Position;
    }
}

table! {
    /// The mean distance of nodes from an axis.
    pub struct RadiusProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The soft body or hand.
        body: Located<String>;
        /// Nodes that are measured. Default: all.
        nodes: Option<Located<Selector>>;
        /// A point on the axis, world [m].
        origin: Vec3 where PLACE = Vec3::zeros();
        /// Direction of the axis, world.
        axis: Vec3 where PLACE;
        /// "position" (default) or "target".
        quantity: QuantityWord = QuantityWord::Position;
    }
}

table! {
    /// Contact between two bodies.
    pub struct ContactProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The two bodies; forces are those on the first. The bones of a hand count as the hand.
        bodies: [Located<String>; 2];
    }
}

words! {
    /// A part of a hand.
    pub enum DigitWord {
        /// The palm.
        "palm" => Palm,
        /// The thumb.
        "thumb" => Thumb,
        /// The index finger.
        "index" => Index,
        /// The middle finger.
        "middle" => Middle,
        /// The ring finger.
        "ring" => Ring,
        /// The little finger.
        "little" => Little,
    }
}

table! {
    /// All that one finger feels.
    pub struct FingerProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The hand.
        hand: Located<String>;
        /// "thumb", "index", "middle", "ring", "little" or "palm".
        finger: DigitWord;
    }
}

words! {
    /// Quantity that is given of each vertex.
    pub enum VertexWord {
        /// Normal force over area [Pa].
        "pressure" => Pressure,
        /// Force [N]: three columns for each vertex.
        "force" => Force,
        /// Speed along what it touches [m/s].
        "slip" => Slip,
        /// 0 open, 1 sticks, 2 slips.
        "state" => State,
        /// Area that it stands for, while it bears load [m²].
        "area" => Area,
    }
}

table! {
    /// Contact at each vertex of a soft body's collision surface: one column for each, numbered as
    /// in the file that `--vtk` writes. Pressure times area, summed, is the normal force.
    pub struct VerticesProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The soft body or hand.
        body: Located<String>;
        /// "pressure" (default), "force", "slip", "state" or "area".
        quantity: VertexWord = VertexWord::Pressure;
    }
}

words! {
    /// Measure of stress.
    pub enum StressWord {
        /// Cauchy stress: force over deformed area, world axes.
        "cauchy" => Cauchy,
        /// First Piola-Kirchhoff stress: force (world axes) over rest area (model axes).
        "nominal" => Nominal,
    }
}

table! {
    /// Stress of elements: mean by volume, and the largest deviation of any element from it.
    pub struct StressProbe {
        /// Name, unique among probes; the start of its column names.
        name: Located<String>;
        /// The soft body or hand.
        body: Located<String>;
        /// Elements that are measured. Default: all.
        elements: Option<Located<Selector>>;
        /// "cauchy" (default) or "nominal".
        stress: StressWord = StressWord::Cauchy;
    }
}

choice! {
    /// Something measured over time.
    pub enum Probe by "measure" {
        /// Position [m] and quaternion of a rigid body, world.
        "pose" => Pose(ProbeBody),
        /// Velocity of the centre of mass [m/s] and angular velocity [rad/s] of a rigid body.
        "velocity" => Velocity(ProbeBody),
        /// Position [m] of a point that moves with a rigid body.
        "point" => Point(PointProbe),
        /// Angles [rad], rates [rad/s] and torques of the limits [N m] of a joint.
        "joint" => Joint(JointProbe),
        /// Energies of the whole scene [J].
        "energy" => Energy(ProbeName),
        /// Kinetic energy and energy of weight of one body [J].
        "body-energy" => BodyEnergy(ProbeBody),
        /// Linear [kg m/s] and angular momentum [kg m²/s].
        "momentum" => Momentum(ProbeMomentum),
        /// Mean of nodes of a soft body.
        "nodes" => Nodes(NodesProbe),
        /// Best-fit rotation vector of nodes against their start [rad].
        "rotation" => Rotation(NodesProbe),
        /// Mean distance of nodes from an axis [m].
        "radius" => Radius(RadiusProbe),
        /// Volume of a soft body [m³].
        "volume" => Volume(ProbeBody),
        /// Stress of elements [Pa].
        "stress" => Stress(StressProbe),
        /// Contact of two bodies: resultant force [N], area [m²], centre of pressure [m],
        /// penetration [m], largest pressure [Pa], mean slip speed [m/s], slip (the part of the
        /// load on sliding points, and the state that most of it is in: 0 open, 1 sticks, 2 slips),
        /// sums of the sizes of normal forces and of friction [N], mean pressure [Pa]. What a
        /// hand's bones bear counts, except in area and pressure, which are those of the skin.
        "contact" => Contact(ContactProbe),
        /// Force [N] and torque about its centre of mass [N m] on a body by all its contacts.
        "contact-force" => ContactForce(ProbeBody),
        /// Pressure, force or slip at each vertex of a surface.
        "vertices" => Vertices(VerticesProbe),
        /// Normal and shear force [N], contact area [m²] and mean pressure [Pa] of each finger of a
        /// hand.
        "fingers" => Fingers(ProbeHand),
        /// All of one finger: force [N], normal and shear force [N], torque about the fingertip
        /// (the centre of mass of its last bone) [N m], centre of pressure [m], area [m²], largest
        /// pressure [Pa], slip as of "contact", what flesh puts on its bones: force [N] and torque
        /// about the fingertip [N m]; the sum of the sizes of friction [N] and the mean pressure
        /// [Pa].
        "finger" => Finger(FingerProbe),
        /// Force [N] and torque [N m] that flesh puts on a rigid body inside it.
        "bone-force" => BoneForce(ProbeBody),
        /// Force [N] and torque [N m] that a drive puts on its body.
        "drive-force" => DriveForce(ProbeBody),
        /// Solver's report of each step.
        "step" => Step(ProbeName),
    }
}
