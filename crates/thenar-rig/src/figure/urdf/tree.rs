//! Tree of the links of a URDF file.

use super::super::link_tree::{Follows, hint, listed};
use super::joint::{Joint, Kind};
use super::{Element, RigError};
use std::collections::BTreeMap;
use thenar_input::quoted;

/// Links and the joints between them.
pub(super) struct Tree<'a> {
    pub links: Vec<Element<'a>>,
    pub joints: Vec<Joint<'a>>,
    names: Vec<&'a str>,
    /// Joint of each link to its parent.
    above: Vec<Option<usize>>,
    /// Joints of each link to its children.
    below: Vec<Vec<usize>>,
}

impl<'a> Tree<'a> {
    /// The links and joints of a robot, each link with at most one parent.
    pub fn read(robot: Element<'a>) -> Result<Self, RigError> {
        let links: Vec<Element<'a>> = robot.named("link").collect();
        if links.is_empty() {
            return Err(robot.error("there is no <link>"));
        }
        let mut index = BTreeMap::new();
        let mut names = Vec::new();
        for (i, link) in links.iter().enumerate() {
            let name = link.needs_name("name")?;
            if index.insert(name, i).is_some() {
                return Err(link.error(format!("there is another link {}", quoted(name))));
            }
            names.push(name);
        }
        let mut tree = Self {
            above: vec![None; links.len()],
            below: vec![Vec::new(); links.len()],
            joints: Vec::new(),
            links,
            names,
        };
        tree.read_joints(robot, &index)?;
        Ok(tree)
    }

    fn read_joints(
        &mut self,
        robot: Element<'a>,
        index: &BTreeMap<&str, usize>,
    ) -> Result<(), RigError> {
        let mut taken = BTreeMap::new();
        for (j, element) in robot.named("joint").enumerate() {
            let name = element.needs_name("name")?;
            if taken.insert(name, j).is_some() {
                return Err(element.error(format!("there is another joint {}", quoted(name))));
            }
            let end = |tag: &'a str| -> Result<usize, RigError> {
                let end = element.needs(tag)?;
                let link = end.needs_name("link")?;
                index.get(link).copied().ok_or_else(|| {
                    let near = hint(link, index.keys().copied());
                    let joint = quoted(name);
                    end.error(format!("joint {joint} names an unknown link {}{near}", quoted(link)))
                })
            };
            let (parent, child) = (end("parent")?, end("child")?);
            if let Some(other) = self.above[child] {
                let names = listed([self.joints[other].name, name]);
                let link = quoted(self.names[child]);
                return Err(
                    element.error(format!("link {link} is the child of two joints, {names}"))
                );
            }
            self.above[child] = Some(j);
            self.below[parent].push(j);
            self.joints.push(Joint { element, name, kind: Kind::read(element, name)?, parent });
            self.joints[j].check_child(child, &self.names)?;
        }
        Ok(())
    }

    /// The joint of a link to its parent.
    pub fn joint_of(&self, link: usize) -> Option<&Joint<'a>> {
        self.above[link].and_then(|j| self.joints.get(j))
    }

    /// Links from the root on, parents before children.
    pub fn order(&self) -> Result<Vec<usize>, RigError> {
        let root = self.root()?;
        let mut child_of = vec![0; self.joints.len()];
        for (link, joint) in self.above.iter().enumerate() {
            joint.iter().for_each(|&j| child_of[j] = link);
        }
        let first = match self.floating_child(root, &child_of) {
            Some(child) => child,
            None => root,
        };
        self.check_floating(first)?;
        let (mut order, mut open, mut seen) =
            (Vec::new(), vec![first], vec![false; self.links.len()]);
        seen[root] = true;
        while let Some(link) = open.pop() {
            seen[link] = true;
            order.push(link);
            open.extend(self.below[link].iter().rev().map(|&j| child_of[j]));
        }
        match seen.iter().position(|&seen| !seen) {
            None => Ok(order),
            Some(link) => Err(self.cycle_error(link)),
        }
    }

    /// The only link without a parent.
    fn root(&self) -> Result<usize, RigError> {
        let roots: Vec<usize> =
            (0..self.links.len()).filter(|&link| self.above[link].is_none()).collect();
        match roots[..] {
            [root] => Ok(root),
            [] => Err(self.cycle_error(0)),
            _ => Err(RigError::invalid(format!(
                "the robot has {} links without a parent, which must be one: {}",
                roots.len(),
                listed(roots.iter().map(|&link| self.names[link]))
            ))),
        }
    }

    /// The link that floats on a root that is only a place.
    fn floating_child(&self, root: usize, child_of: &[usize]) -> Option<usize> {
        let [joint] = self.below[root][..] else { return None };
        let empty = ["inertial", "collision", "visual"].map(|tag| self.links[root].child(tag));
        let only_place = empty.iter().all(Option::is_none);
        (self.joints[joint].kind == Kind::Floating && only_place).then_some(child_of[joint])
    }

    /// Errs when a link floats that is not the first.
    fn check_floating(&self, first: usize) -> Result<(), RigError> {
        let floats = |joint: &&Joint<'_>| joint.kind == Kind::Floating;
        let joint_above = self.joint_of(first).map(|joint| joint.name);
        match self.joints.iter().filter(floats).find(|joint| Some(joint.name) != joint_above) {
            Some(joint) => Err(joint.slides("floats")),
            None => Ok(()),
        }
    }

    /// Joints that follow others, by `<mimic>`.
    pub fn mimics(&self) -> Result<Vec<Follows>, RigError> {
        let known = || self.joints.iter().map(|joint| joint.name);
        let mut follows = Vec::new();
        for joint in &self.joints {
            let Some(mimic) = joint.element.child("mimic") else { continue };
            let leader = mimic.needs_name("joint")?;
            if !known().any(|name| name == leader) {
                let [name, near] = [quoted(joint.name), hint(leader, known())];
                let what = format!("joint {name} mimics an unknown joint {}{near}", quoted(leader));
                return Err(mimic.error(what));
            }
            let [offset, multiplier] = ["offset", "multiplier"].map(|name| mimic.number(name));
            let law = [offset?.unwrap_or(0.0), multiplier?.unwrap_or(1.0), 0.0, 0.0, 0.0];
            let [follower, leader] = [joint.name, leader].map(str::to_owned);
            follows.push(Follows { follower, leader, law });
        }
        Ok(follows)
    }

    /// Note on a root that is left out.
    pub fn dropped_root(&self) -> Result<Option<String>, RigError> {
        let dropped = self.joints.iter().find(|joint| joint.is_dropped());
        Ok(dropped.map(|joint| {
            let [root, name] = [self.names[joint.parent], joint.name].map(quoted);
            format!("the link {root} and its floating joint {name} are left out: a figure's root is free")
        }))
    }

    /// A cycle through which this link is reached: followed upwards as often as there are links, it
    /// is on it.
    fn cycle_error(&self, mut link: usize) -> RigError {
        for _ in 0..self.links.len() {
            link = self.joint_of(link).map_or(link, |joint| joint.parent);
        }
        let name = quoted(self.names[link]);
        RigError::invalid(format!("link {name} is its own ancestor: the joints form a cycle"))
    }
}
