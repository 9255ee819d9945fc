//! Default classes: attributes that elements have unless they say otherwise.

use super::super::link_tree::hint;
use super::super::xml::Attribute;
use super::{Element, RigError};
use std::collections::BTreeMap;
use thenar_input::quoted;

/// Classes nest no deeper.
const DEPTH_MAX: usize = 50;
/// Most classes of a file.
const CLASSES_MAX: usize = 500;

/// All classes of a file; the first applies to what names none.
pub(super) struct Classes<'a> {
    list: Vec<Class<'a>>,
    names: BTreeMap<&'a str, usize>,
}

/// Attributes by element and name, those of outer classes included.
#[derive(Clone, Default)]
struct Class<'a> {
    attributes: BTreeMap<(&'a str, &'a str), Attribute<'a>>,
    depth: usize,
}

impl<'a> Classes<'a> {
    /// The classes of all `<default>` elements.
    pub fn read(root: Element<'a>) -> Result<Self, RigError> {
        let mut classes = Self { list: vec![Class::default()], names: BTreeMap::new() };
        classes.names.insert("main", 0);
        let mut open = Vec::new();
        for top in root.named("default") {
            if let Some(name) = top.name("class")? {
                classes.names.insert(name, 0);
            }
            classes.fill(0, top);
            open.push((top, 0));
        }
        open.reverse();
        while let Some((element, outer)) = open.pop() {
            for inner in element.named("default") {
                open.push((inner, classes.add(inner, outer)?));
            }
        }
        Ok(classes)
    }

    fn add(&mut self, element: Element<'a>, outer: usize) -> Result<usize, RigError> {
        let name = element.needs_name("class")?;
        let index = self.list.len();
        if self.names.insert(name, index).is_some() {
            return Err(element.error(format!("there is another class {}", quoted(name))));
        }
        // Each class holds what it inherits.
        if index >= CLASSES_MAX {
            return Err(element.error(format!("there are more than {CLASSES_MAX} classes")));
        }
        let mut class = self.list[outer].clone();
        class.depth += 1;
        if class.depth > DEPTH_MAX {
            return Err(element.error(format!("classes nest deeper than {DEPTH_MAX} levels")));
        }
        self.list.push(class);
        self.fill(index, element);
        Ok(index)
    }

    /// Takes what the elements of a `<default>` set.
    fn fill(&mut self, class: usize, element: Element<'a>) {
        let kept = |inner: &Element<'a>| ["joint", "geom", "mesh"].contains(&inner.tag());
        for inner in element.children().filter(kept) {
            let named = inner.attributes().map(|a| ((inner.tag(), a.name), a));
            self.list[class].attributes.extend(named);
        }
    }

    /// The class that an attribute names; without it, `otherwise`.
    pub fn named(
        &self,
        element: Element<'a>,
        attribute: &str,
        otherwise: usize,
    ) -> Result<usize, RigError> {
        let Some(name) = element.name(attribute)? else { return Ok(otherwise) };
        self.names.get(name).copied().ok_or_else(|| {
            let near = hint(name, self.names.keys().copied());
            element.error(format!("there is no class {}{near}", quoted(name)))
        })
    }

    /// An element with what its class gives it, `childclass` being that of the bodies around.
    pub fn styled(
        &self,
        element: Element<'a>,
        childclass: usize,
    ) -> Result<Styled<'_, 'a>, RigError> {
        let class = self.named(element, "class", childclass)?;
        Ok(Styled { element, class: &self.list[class] })
    }
}

/// An element with the attributes of its class.
#[derive(Clone, Copy)]
pub(super) struct Styled<'c, 'a> {
    pub element: Element<'a>,
    class: &'c Class<'a>,
}

impl<'a> Styled<'_, 'a> {
    /// An attribute: the element's own, else that of its class.
    pub fn get(&self, name: &str) -> Option<Attribute<'a>> {
        self.element.get(name).or_else(|| self.of_class(name))
    }

    /// An attribute of the class alone.
    pub fn of_class(&self, name: &str) -> Option<Attribute<'a>> {
        self.class.attributes.get(&(self.element.tag(), name)).copied()
    }

    /// A finite number, else this one.
    pub fn number_or(&self, name: &str, otherwise: f64) -> Result<f64, RigError> {
        self.get(name).map_or(Ok(otherwise), Attribute::number)
    }

    /// A number of at least zero, else zero.
    pub fn amount(&self, name: &str) -> Result<f64, RigError> {
        let Some(attribute) = self.get(name) else { return Ok(0.0) };
        let value = attribute.number()?;
        if value >= 0.0 { Ok(value) } else { Err(attribute.error("at least 0")) }
    }

    /// Finite numbers, else these.
    pub fn numbers_or<const N: usize>(
        &self,
        name: &str,
        otherwise: [f64; N],
    ) -> Result<[f64; N], RigError> {
        self.get(name).map_or(Ok(otherwise), Attribute::numbers)
    }
}
