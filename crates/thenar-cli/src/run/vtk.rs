//! A run as a series of VTK files.

use crate::error::CliError;
use std::path::Path;
use thenar_core::model::EmbeddedSurface;
use thenar_core::readout::{ContactReadout, VertexContact};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3};
use thenar_rig::export::{Field, Series, flesh_cell_fields, lines, surface, tetrahedra};
use thenar_scene::session::Session;

/// Moments of a run, for ParaView.
pub struct VtkSeries {
    series: Series,
    every: u64,
    readout: ContactReadout,
}

type Parts = Vec<(String, &'static str, String)>;

impl VtkSeries {
    /// Starts a series with a moment after every `interval` \[s\].
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn create(folder: &Path, session: &Session, interval: f64) -> Result<Self, CliError> {
        let every = (interval / session.world().time_step()).round().max(1.0) as u64;
        let readout = ContactReadout::new(session.world());
        Ok(Self { series: Series::create(folder, session.name())?, every, readout })
    }

    /// Writes the present state when its time has come.
    ///
    /// # Errors
    /// Writing fails.
    pub fn take(&mut self, session: &Session) -> Result<(), CliError> {
        if !session.steps().is_multiple_of(self.every) {
            return Ok(());
        }
        let mut parts = Parts::new();
        hands(session, &mut parts)?;
        softs(session, &mut parts)?;
        rigids(session, &mut parts)?;
        contacts(session, &mut parts)?;
        self.readout.read(session.world());
        touched(session, &self.readout, &mut parts)?;
        let parts: Vec<_> =
            parts.iter().map(|(name, end, text)| (name.as_str(), *end, text.clone())).collect();
        Ok(self.series.push(session.world().time(), &parts)?)
    }
}

fn flesh(session: &Session, soft: u32, name: &str, parts: &mut Parts) -> Result<(), CliError> {
    let world = session.world();
    let flesh = &world.desc().softs[soft as usize].flesh;
    let velocity = Field::vector("velocity [m/s]", world.node_velocities(soft));
    let text = tetrahedra(world.nodes(soft), &flesh.tets, &[velocity], &flesh_cell_fields(flesh))?;
    parts.push((format!("{name}-flesh"), "vtu", text));
    Ok(())
}

fn skin(
    session: &Session,
    soft: u32,
    render: &EmbeddedSurface,
    name: &str,
    parts: &mut Parts,
) -> Result<(), CliError> {
    let world = session.world();
    let tets = &world.desc().softs[soft as usize].flesh.tets;
    let mut points = vec![Vec3::zeros(); render.vertices.len()];
    render.positions(tets, world.nodes(soft), &mut points);
    parts.push((format!("{name}-skin"), "vtp", surface(&points, &render.triangles, &[], &[])?));
    Ok(())
}

fn hands(session: &Session, parts: &mut Parts) -> Result<(), CliError> {
    for hand in session.hands() {
        if let Some(soft) = hand.flesh() {
            flesh(session, soft, &hand.name, parts)?;
            skin(session, soft, &hand.model.render, &hand.name, parts)?;
        }
        let (mut points, mut segments) = (Vec::new(), Vec::new());
        for (bone, i) in hand.model.bones.iter().zip(hand.handle.bones.clone()) {
            let pose = session.world().rigid_pose(i);
            let first = points.len() as u32;
            points.extend(bone.ends_B.iter().map(|end| pose.point(end)));
            segments.push([first, first + 1]);
        }
        let text = lines(&points, &segments, &[], &[])?;
        parts.push((format!("{}-bones", hand.name), "vtp", text));
    }
    Ok(())
}

fn softs(session: &Session, parts: &mut Parts) -> Result<(), CliError> {
    for soft in session.softs() {
        let name = session.world().desc().softs[soft.soft as usize].name.clone();
        flesh(session, soft.soft, &name, parts)?;
        skin(session, soft.soft, &soft.render, &name, parts)?;
    }
    Ok(())
}

fn rigids(session: &Session, parts: &mut Parts) -> Result<(), CliError> {
    let world = session.world();
    for (i, rigid) in world.desc().rigids.iter().enumerate() {
        let pose_WB = world.rigid_pose(i as u32);
        let mesh = match &session.looks()[i].mesh {
            Some((mesh, _)) => {
                let points = mesh.positions.iter().map(|p| pose_WB.point(p)).collect();
                Some((points, mesh.triangles.clone()))
            }
            None if world.desc().flesh_of_bone(i as u32).is_some() => None,
            None => rigid.shape.as_ref().and_then(|s| outline(s, &(pose_WB * rigid.pose_BS))),
        };
        if let Some((points, triangles)) = mesh {
            parts.push((rigid.name.clone(), "vtp", surface(&points, &triangles, &[], &[])?));
        }
    }
    Ok(())
}

/// The surface of a shape in the world; of a half space, a square of 1 m.
fn outline(shape: &Shape, pose_WS: &Pose) -> Option<(Vec<Vec3>, Vec<[u32; 3]>)> {
    if matches!(shape, Shape::HalfSpace) {
        let corner = |x: f64, z: f64| pose_WS.point(&Vec3::new(x, 0.0, z));
        let corners = [corner(-0.5, -0.5), corner(-0.5, 0.5), corner(0.5, 0.5), corner(0.5, -0.5)];
        return Some((corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]));
    }
    let solid = thenar_picture::of_shape(shape, 24, 1)?.placed(pose_WS);
    Some((solid.positions, solid.triangles))
}

/// The collision surface of each deformable body with what presses on its vertices.
fn touched(session: &Session, readout: &ContactReadout, parts: &mut Parts) -> Result<(), CliError> {
    let world = session.world();
    for (s, soft) in (0..).zip(&world.desc().softs) {
        let vertices = readout.vertices(s);
        let scalar = |name: &str, of: fn(&VertexContact) -> f64| {
            Field::scalar(name, vertices.iter().map(of).collect())
        };
        let forces: Vec<Vec3> = vertices.iter().map(|v| v.force_W).collect();
        let states = vertices.iter().map(|v| i32::from(v.state.number())).collect();
        let fields = [
            scalar("pressure [Pa]", |v| v.pressure),
            Field::vector("force [N]", &forces),
            scalar("slip [m/s]", |v| v.slip_W.norm()),
            Field::whole("state: 0 open, 1 sticks, 2 slips", states),
        ];
        let triangles = &soft.flesh.collision.triangles;
        let text = surface(world.collision_vertices(s), triangles, &fields, &[])?;
        parts.push((format!("{}-contact", soft.name), "vtp", text));
    }
    Ok(())
}

/// Contact forces as short lines that carry the force on the first body.
fn contacts(session: &Session, parts: &mut Parts) -> Result<(), CliError> {
    let active: Vec<_> =
        session.world().contacts().iter().filter(|c| c.force_W.norm() > 0.0).collect();
    let points: Vec<Vec3> =
        active.iter().flat_map(|c| [c.position_W, c.position_W + c.normal_W * 0.005]).collect();
    let segments: Vec<[u32; 2]> = (0..active.len() as u32).map(|i| [2 * i, 2 * i + 1]).collect();
    let forces: Vec<Vec3> = active.iter().map(|c| c.force_W).collect();
    let field = Field::vector("force [N]", &forces);
    parts.push(("contacts".into(), "vtp", lines(&points, &segments, &[], &[field])?));
    Ok(())
}
