//! Joints of URDF files.

use super::super::link_tree::{Link, LinkJoint, unit};
use super::{Element, RigError, origin};
use thenar_core::Vec3;
use thenar_core::model::{AngleLimit, Axis, JointKind};
use thenar_input::quoted;

/// Kind of a joint's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Revolute,
    Continuous,
    Fixed,
    Ball,
    Floating,
}

const KINDS: &str = "revolute, continuous, fixed, spherical or ball, and floating at the root";

impl Kind {
    /// The kind of a joint.
    ///
    /// # Errors
    /// Names a joint that slides, or whose type is unknown.
    pub fn read(element: Element<'_>, name: &str) -> Result<Self, RigError> {
        let word = element.needs_name("type")?;
        match word {
            "revolute" => Ok(Self::Revolute),
            "continuous" => Ok(Self::Continuous),
            "fixed" => Ok(Self::Fixed),
            "spherical" | "ball" => Ok(Self::Ball),
            "floating" => Ok(Self::Floating),
            "prismatic" | "planar" => Err(slides(element, name, &format!("is {word}"))),
            _ => Err(element.error(format!(
                "joint {} is of an unknown type {} ({KINDS} are known)",
                quoted(name),
                quoted(word)
            ))),
        }
    }
}

fn slides(element: Element<'_>, name: &str, how: &str) -> RigError {
    let name = quoted(name);
    element.error(format!(
        "joint {name} {how}, and sliding joints are not simulated: make it fixed or a hinge"
    ))
}

/// A joint between two links.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint<'a> {
    pub element: Element<'a>,
    pub name: &'a str,
    pub kind: Kind,
    /// Index of the parent among the links.
    pub parent: usize,
}

impl Joint<'_> {
    /// True for the floating joint of a root that is left out.
    pub fn is_dropped(&self) -> bool {
        self.kind == Kind::Floating
    }

    /// Errs that the joint slides.
    pub fn slides(&self, how: &str) -> RigError {
        slides(self.element, self.name, how)
    }

    /// Errs when a joint leads from a link to itself.
    pub fn check_child(&self, child: usize, names: &[&str]) -> Result<(), RigError> {
        if self.parent != child {
            return Ok(());
        }
        let name = quoted(names[child]);
        Err(self.element.error(format!("link {name} is its own parent")))
    }

    /// Places a link and gives it this joint.
    pub fn attach(&self, link: &mut Link) -> Result<(), RigError> {
        if self.is_dropped() {
            return Ok(());
        }
        link.pose_PL = origin(self.element)?;
        let (kind, limit) = match self.kind {
            Kind::Fixed | Kind::Floating => return Ok(()),
            Kind::Revolute => (JointKind::Hinge, Some(self.range()?)),
            Kind::Continuous => (JointKind::Hinge, None),
            Kind::Ball => (JointKind::Ball, None),
        };
        link.joints.push(LinkJoint {
            name: self.name.to_owned(),
            kind,
            point_L: Vec3::zeros(),
            axis_L: self.axis()?,
            axis: Axis { limit, damping: self.damping()?, ..Axis::default() },
        });
        Ok(())
    }

    fn range(&self) -> Result<AngleLimit, RigError> {
        let Some(limit) = self.element.child("limit") else {
            let what = "<limit> is missing inside (a joint without a range is continuous)";
            return Err(self.element.error(format!("joint {}: {what}", quoted(self.name))));
        };
        let [min, max] = ["lower", "upper"].map(|name| limit.number(name));
        let (min, max) = (min?.unwrap_or(0.0), max?.unwrap_or(0.0));
        if min <= max {
            return Ok(AngleLimit { min, max });
        }
        let name = quoted(self.name);
        Err(limit.error(format!("joint {name}: lower must be at most upper, not {min} and {max}")))
    }

    fn axis(&self) -> Result<Vec3, RigError> {
        let Some(axis) = self.element.child("axis") else { return Ok(Vec3::x()) };
        let xyz = axis.numbers::<3>("xyz")?.map_or(Vec3::x(), Vec3::from);
        unit(&xyz).ok_or_else(|| {
            axis.error(format!("joint {}: xyz must be of some length", quoted(self.name)))
        })
    }

    fn damping(&self) -> Result<f64, RigError> {
        let Some(dynamics) = self.element.child("dynamics") else { return Ok(0.0) };
        let damping = dynamics.number("damping")?.unwrap_or(0.0);
        if damping >= 0.0 {
            return Ok(damping);
        }
        let name = quoted(self.name);
        Err(dynamics.error(format!("joint {name}: damping must be at least 0, not {damping}")))
    }
}
