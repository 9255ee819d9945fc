//! Bodies of the figure.

use super::super::link_tree::{Body, Link, LinkMass, is_inertia};
use super::geom::{self, Role};
use super::joint::{self, Kind};
use super::place::pose_of;
use super::settings::FromGeoms;
use super::world::{Place, check_known, inside};
use super::{Context, RigError};
use std::collections::BTreeSet;
use thenar_core::{Mat3, Pose, Vec3};
use thenar_input::quoted;

/// A body with what belongs to it, as elements.
struct BodyElements<'a> {
    name: String,
    parent: Option<usize>,
    pose_PL: Pose,
    joints: Vec<Place<'a>>,
    geoms: Vec<Place<'a>>,
    inertial: Option<Place<'a>>,
}

/// The links of a body and of those inside, parents before children.
pub(super) fn read<'a>(
    figure: &Place<'a>,
    context: &mut Context<'a>,
) -> Result<Vec<Link>, RigError> {
    let raw = collect(figure, context)?;
    let mut names = joint_names(&raw)?;
    raw.into_iter().map(|body| link(body, &mut names, context)).collect()
}

/// Bodies in the order of the file.
fn collect<'a>(
    figure: &Place<'a>,
    context: &Context<'a>,
) -> Result<Vec<BodyElements<'a>>, RigError> {
    let (classes, settings) = (&context.classes, &context.settings);
    let mut bodies: Vec<BodyElements<'a>> = Vec::new();
    let mut taken = BTreeSet::new();
    let mut open = vec![(*figure, None)];
    while let Some((place, owner)) = open.pop() {
        let owned = owner.and_then(|k: usize| bodies.get_mut(k));
        match (place.element.tag(), owned) {
            ("body", _) => {
                let given = place.element.name("name")?.map(str::to_owned);
                let name = given.unwrap_or_else(|| unused("body", bodies.len(), &taken));
                if !taken.insert(name.clone()) {
                    let what = format!("there is another body {}", quoted(&name));
                    return Err(place.element.error(what));
                }
                let pose_PL = place.pose * pose_of(place.element, settings)?;
                let contents = Place { pose: Pose::identity(), ..place };
                let index = bodies.len();
                bodies.push(BodyElements {
                    name,
                    parent: owner,
                    pose_PL,
                    joints: Vec::new(),
                    geoms: Vec::new(),
                    inertial: None,
                });
                let contents = inside(contents, classes, settings)?;
                open.extend(contents.into_iter().map(|inner| (inner, Some(index))));
            }
            ("frame", _) => {
                let contents = inside(place, classes, settings)?;
                open.extend(contents.into_iter().map(|inner| (inner, owner)));
            }
            ("joint" | "freejoint", Some(body)) => body.joints.push(place),
            ("geom", Some(body)) => body.geoms.push(place),
            ("inertial", Some(body)) => body.inertial = Some(place),
            _ => check_known(place.element)?,
        }
    }
    Ok(bodies)
}

/// `word` with a number at which no other has this name.
fn unused(word: &str, from: usize, taken: &BTreeSet<String>) -> String {
    let mut names = (from..).map(|k| format!("{word} {k}"));
    names.find(|name| !taken.contains(name)).unwrap_or_default()
}

/// Most joints of a body: three turn it every way, and three slide it.
const JOINTS_MAX: usize = 6;

/// The names that joints have in the file.
fn joint_names(bodies: &[BodyElements<'_>]) -> Result<BTreeSet<String>, RigError> {
    let mut names = BTreeSet::new();
    for place in bodies.iter().flat_map(|body| &body.joints) {
        let Some(name) = place.element.name("name")? else { continue };
        if !names.insert(name.to_owned()) {
            return Err(place.element.error(format!("there is another joint {}", quoted(name))));
        }
    }
    Ok(names)
}

fn link<'a>(
    body: BodyElements<'a>,
    names: &mut BTreeSet<String>,
    context: &mut Context<'a>,
) -> Result<Link, RigError> {
    let mut joints = Vec::new();
    if let Some(place) = body.joints.get(JOINTS_MAX) {
        let name = quoted(&body.name);
        let problem = format!("body {name} has more than {JOINTS_MAX} joints");
        return Err(place.element.error(problem));
    }
    for place in &body.joints {
        let name = match place.element.name("name")? {
            Some(name) => name.to_owned(),
            None if names.contains(&body.name) => unused(&body.name, 1, names),
            None => body.name.clone(),
        };
        names.insert(name.clone());
        if body.parent.is_some() {
            joints.push(joint::read(place, name, &body.name, context)?);
        } else if joint::kind(&context.classes.styled(place.element, place.class)?)? != Kind::Free {
            context.notes.to_world.push(name);
        }
    }
    let mut link = Link {
        name: body.name,
        parent: body.parent,
        pose_PL: body.pose_PL,
        joints,
        mass: LinkMass::default(),
        solids: Vec::new(),
    };
    let from_geoms = context.settings.from_geoms;
    let inertial = body.inertial.filter(|_| from_geoms != FromGeoms::Always);
    let inertial = inertial.map(|place| mass_of(&place, &link.name, context)).transpose()?;
    let counted = inertial.is_none() && from_geoms != FromGeoms::Never;
    read_geoms(&mut link, &body.geoms, counted, context)?;
    if let Some(body) = inertial {
        link.mass = LinkMass { body, stated: true };
    }
    Ok(link)
}

/// Gives a link its geoms: those that others touch, or all where there are none such. Their mass is
/// taken where it is `counted`.
fn read_geoms<'a>(
    link: &mut Link,
    geoms: &[Place<'a>],
    counted: bool,
    context: &mut Context<'a>,
) -> Result<(), RigError> {
    let roles: Vec<Role> =
        geoms.iter().map(|place| geom::role(place, context)).collect::<Result<_, _>>()?;
    let any_touches = roles.iter().any(|role| role.touches);
    let always = context.settings.from_geoms == FromGeoms::Always;
    let stated = counted && (always && !geoms.is_empty() || roles.iter().any(|role| role.stated));
    let mut total = LinkMass { body: None, stated };
    for (place, role) in geoms.iter().zip(roles) {
        let shown = role.touches || !any_touches;
        let weighed = stated && role.heavy;
        if !(shown || weighed) {
            continue;
        }
        let (solid, body) = geom::read(place, role, &link.name, context)?;
        if shown {
            link.solids.push(solid);
        }
        if counted {
            total = total.plus(LinkMass { body, stated });
        }
    }
    link.mass = total;
    Ok(())
}

/// The mass of an `<inertial>`; none where it is zero.
fn mass_of(place: &Place<'_>, body: &str, context: &Context<'_>) -> Result<Option<Body>, RigError> {
    let element = place.element;
    let mass = element.needs_number("mass")?;
    if mass < 0.0 {
        return Err(element.error(format!("body {}: mass must be at least 0", quoted(body))));
    }
    if mass == 0.0 {
        return Ok(None);
    }
    let inertia = match (element.numbers::<3>("diaginertia")?, element.numbers::<6>("fullinertia")?)
    {
        (_, Some([xx, yy, zz, xy, xz, yz])) => Some(Mat3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)),
        (Some(diagonal), None) => Some(Mat3::from_diagonal(&Vec3::from(diagonal))),
        (None, None) => None,
    };
    if inertia.is_some_and(|inertia| !is_inertia(&inertia)) {
        let what = format!("body {}: the inertia is not positive definite", quoted(body));
        return Err(element.error(what));
    }
    let pose = place.pose * pose_of(element, &context.settings)?;
    Ok(Some(Body { mass, centre: Vec3::zeros(), inertia }.moved(&pose)))
}
