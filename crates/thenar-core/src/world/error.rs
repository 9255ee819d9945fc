//! Why a description cannot be simulated.

/// One fault of a `WorldDesc`, with the thing and the cause.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A number is out of range or not finite.
    #[error("{thing}: {what} must be {expected}, got {got}")]
    Value {
        /// Body, joint or setting.
        thing: String,
        /// Quantity that is not finite.
        what: &'static str,
        /// Values that are allowed.
        expected: &'static str,
        /// Value that was given.
        got: f64,
    },
    /// An index points nowhere.
    #[error("{thing}: {what} {index} does not exist (there are {count})")]
    Index {
        /// Body or joint.
        thing: String,
        /// Kind of index.
        what: &'static str,
        /// Index given.
        index: u64,
        /// Number of things.
        count: usize,
    },
    /// Two lists that belong together differ in length.
    #[error("{thing}: {what} has {got} entries, expected {expected}")]
    Count {
        /// Name of the body.
        thing: String,
        /// List of the wrong length.
        what: &'static str,
        /// Length that is needed.
        expected: usize,
        /// Length that was given.
        got: usize,
    },
    /// An element has no volume or is inside out at rest.
    #[error("{thing}: tetrahedron {tet} has a rest volume that is not positive")]
    Tet {
        /// Name of the body.
        thing: String,
        /// Number of the element.
        tet: usize,
    },
    /// A node belongs to no element.
    #[error("{thing}: node {node} belongs to no tetrahedron, so it has no mass")]
    LooseNode {
        /// Name of the body.
        thing: String,
        /// Number of the node.
        node: usize,
    },
    /// A node is bound to two bones that no joint connects.
    #[error("{thing}: node {node} is bound to bones {bones:?}, which no joint connects")]
    NotAdjacent {
        /// Name of the body.
        thing: String,
        /// Number of the node.
        node: usize,
        /// Rigid-body indices.
        bones: [u32; 2],
    },
    /// The pose of a joint is to shift a node that the joint's two bodies do not both carry.
    #[error(
        "{thing}: node {node} is not held by springs to both bodies of joint {joint}, whose pose shifts only what lies between them"
    )]
    NotPosed {
        /// Name of the body.
        thing: String,
        /// Number of the node.
        node: usize,
        /// Name of the joint.
        joint: String,
    },
    /// Offsets are given twice for one pose.
    #[error(
        "{thing}: offsets at joint {joint} have poses that are the same, or too near to each other or to rest"
    )]
    SamePoses {
        /// Name of the body.
        thing: String,
        /// Name of the joint.
        joint: String,
    },
    /// Weights are negative or do not sum to 1.
    #[error("{thing}: weights of node {node} must be non-negative and sum to 1, got {weights:?}")]
    Weights {
        /// Name of the body.
        thing: String,
        /// Number of the node.
        node: usize,
        /// Weights given.
        weights: [f64; 2],
    },
    /// A half-space cannot move by forces.
    #[error("{thing}: a plane must be fixed, it has no finite mass")]
    MovingPlane {
        /// Name of the body.
        thing: String,
    },
    /// Joints hold more together than the monolithic solver can take.
    #[error(
        "{thing} and what joints hold to it have up to {freedoms} freedoms, more than {most}: the monolithic solver takes the \
         cube of them in time; the two-step solver takes any number (solver.kind = \"two-step\")"
    )]
    ManyFreedoms {
        /// First of the bodies.
        thing: String,
        /// Freedoms of all of them.
        freedoms: usize,
        /// Most that are taken.
        most: usize,
    },
    /// A joint connects a body with itself.
    #[error("{thing}: a joint needs two different bodies")]
    SelfJoint {
        /// Name of the joint.
        thing: String,
    },
    /// A running world is given a description of another one.
    #[error("{thing}: {what} cannot change while the world runs")]
    Changed {
        /// Body, joint or world.
        thing: String,
        /// Property that differs.
        what: &'static str,
    },
}
