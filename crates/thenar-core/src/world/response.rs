//! Contact of one step: from the points found to impulses (Sec. 3.4, Eq. 12).

use crate::contact::{
    Contact, Detector, Reach, RigidPlace, SearchReport, Site, SurfacePoint, SurfaceState,
};
use crate::math::Vec3;
use crate::model::{BodyId, Cone};
use crate::solver::{ContactRows, Convergence, is_on_rim};
use crate::world::model::Model;
use crate::world::state::{Scratch, State};
use crate::world::{ContactPoint, StepReport, friction, push_out};

/// Finds the points that touch, or would within the step at the contact-free velocities.
pub fn detect(
    reach: Reach,
    model: &Model,
    state: &State,
    detector: &mut Detector,
    places: &mut [RigidPlace],
    scratch: &mut Scratch,
) -> SearchReport {
    let row0 = 2 * model.rigids.len();
    for (b, place) in places.iter_mut().enumerate() {
        place.pose_WB = state.poses_WB[b];
        place.velocity_W = state.v[2 * b];
        place.angular_velocity_W = state.v[2 * b + 1];
    }
    for (i, vertex) in model.vertices.iter().enumerate() {
        scratch.vertices[i] = vertex.of(&state.x);
        scratch.vertex_velocities[i] = vertex.of(&state.v[row0..]);
    }
    let surfaces =
        SurfaceState { positions: &scratch.vertices, velocities: &scratch.vertex_velocities };
    detector.find(reach, places, surfaces, &state.sides, &mut scratch.sides, &mut scratch.found)
}

/// Builds the rows of the contacts found, `J (v + Δv) ≥ -g₊/Δt`, started from the impulses of the
/// step before; a gap within the slack (`push_out::slack`) closes gently. An overlap asks for no
/// speed: it does not grow, and `push_out` undoes it. So no target is above zero, zero velocity
/// obeys all rows, and contacts cannot contradict each other.
pub fn build_rows(model: &Model, state: &State, h: f64, scratch: &mut Scratch) {
    let rows = &mut scratch.rows;
    rows.clear();
    for contact in &scratch.found {
        let at = state.impulses.binary_search_by_key(&contact.key, |(key, _)| *key);
        let impulse = at.map_or(Vec3::zeros(), |i| state.impulses[i].1);
        add_row(model, contact, &impulse, rows);
    }
    let slack = push_out::slack(h);
    for (i, contact) in scratch.found.iter().enumerate() {
        let row = &rows.rows[i];
        let v = row.frame * rows.relative_velocity(row, &state.v);
        let wanted = push_out::closing(contact.gap, slack, h);
        rows.rows[i].target = Vec3::new(wanted, 0.0, 0.0) - v;
    }
}

/// Adds Δv to the velocities and keeps what contact did for the next step.
pub fn apply(state: &mut State, scratch: &Scratch) {
    for (v, change) in state.v.iter_mut().zip(&state.contact_change) {
        *v += change;
    }
    keep_impulses(state, scratch);
}

/// Keeps the impulses of contacts for the next step, but for what is no number: a state may have
/// begun with impulses that no sum of them can hold.
fn keep_impulses(state: &mut State, scratch: &Scratch) {
    let rows = scratch.found.iter().zip(&scratch.rows.rows);
    let impulses = rows.map(|(contact, row)| (contact.key, row.frame.tr_mul(&row.lambda)));
    state.impulses.clear();
    state.impulses.extend(impulses.filter(|(_, impulse)| impulse.iter().all(|x| x.is_finite())));
    state.impulses.sort_unstable_by_key(|(key, _)| *key);
}

/// Scales impulses as their velocities were scaled, island by island.
pub fn scale_impulses(model: &Model, h: f64, state: &mut State, scratch: &mut Scratch) {
    let Scratch { rows, islands, found, .. } = scratch;
    for i in 0..rows.rows.len() {
        let share = islands.share_of_contact(&rows.rows[i], rows);
        rows.rows[i].lambda *= share;
    }
    for (row, change) in state.contact_change.iter_mut().enumerate() {
        *change *= islands.share(row);
    }
    for (impulses, joint) in state.limit_impulses.iter_mut().zip(&model.joints) {
        let share = islands.share(2 * joint.child as usize);
        impulses.iter_mut().for_each(|impulse| *impulse *= share);
    }
    friction::keep_loads(model, found, rows, h, &mut state.patch_loads);
    keep_impulses(state, scratch);
}

/// Lists the contacts with their forces; penetration is that at the end of the step, to first
/// order.
pub fn report(
    state: &State,
    h: f64,
    cone: Cone,
    convergence: Convergence,
    scratch: &mut Scratch,
    report: &mut StepReport,
) {
    report.contact_sweeps = convergence.iterations;
    report.contact_residual = convergence.residual;
    report.contacts = scratch.found.len() as u32;
    scratch.contacts.clear();
    for (contact, row) in scratch.found.iter().zip(&scratch.rows.rows) {
        let v = scratch.rows.relative_velocity(row, &state.v);
        let along = v.dot(&contact.normal_W);
        let pushed =
            scratch.push().map_or(Vec3::zeros(), |p| scratch.rows.relative_velocity(row, p));
        let gap = contact.gap + h * (along + pushed.dot(&contact.normal_W));
        report.penetration_max = report.penetration_max.max(-gap);
        report.contacts_active += u32::from(row.lambda.x > 0.0);
        let sides = [&contact.a, &contact.b];
        scratch.contacts.push(ContactPoint {
            bodies: sides.map(body_of),
            vertices: sides.map(nearest_vertex),
            position_W: contact.position_W,
            normal_W: contact.normal_W,
            gap: contact.gap,
            force_W: row.frame.tr_mul(&row.lambda) / h,
            slip_W: v - contact.normal_W * along,
            area: 0.0,
            friction: row.friction,
            slips: is_on_rim(cone, row.friction, &row.lambda),
        });
    }
}

fn add_row(model: &Model, contact: &Contact, impulse: &Vec3, rows: &mut ContactRows) {
    rows.begin(&contact.normal_W, contact.friction, impulse);
    for (site, sign) in [(&contact.a, 1.0), (&contact.b, -1.0)] {
        match site {
            Site::Rigid { body, offset_W } => rows.hold_rigid(*body, *offset_W, sign),
            Site::Soft(point) => hold_surface(model, point, sign, rows),
        }
    }
}

/// A surface point holds the nodes of the tetrahedra around its vertices.
fn hold_surface(model: &Model, point: &SurfacePoint, sign: f64, rows: &mut ContactRows) {
    let first = model.soft_vertices[point.soft as usize].start;
    for (vertex, share) in point.vertices.iter().zip(point.weights) {
        if share == 0.0 {
            continue;
        }
        let embedded = &model.vertices[first + *vertex as usize];
        for (node, weight) in embedded.nodes.iter().zip(embedded.weights) {
            if weight != 0.0 {
                rows.hold_node(*node, sign * share * weight);
            }
        }
    }
}

/// The body a contact touches.
pub fn body_of(site: &Site) -> BodyId {
    match site {
        Site::Rigid { body, .. } => BodyId::Rigid(*body),
        Site::Soft(point) => BodyId::Soft(point.soft),
    }
}

/// The collision vertex nearest to a contact, of a deformable body.
pub fn nearest_vertex(site: &Site) -> Option<u32> {
    match site {
        Site::Rigid { .. } => None,
        Site::Soft(point) => {
            let heaviest = (0..3).max_by(|&i, &j| point.weights[i].total_cmp(&point.weights[j]));
            heaviest.map(|i| point.vertices[i])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::Shape;
    use crate::math::{Mat3, Pose};
    use crate::model::{Motion, RigidDesc, SolverKind, WorldDesc};
    use crate::world::World;

    /// A cube of 0.1 kg that rests on a floor.
    fn resting(kind: SolverKind) -> World {
        let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
        desc.solver.kind = kind;
        let mut floor = RigidDesc {
            name: "floor".into(),
            motion: Motion::Prescribed,
            mass: 0.1,
            inertia: Mat3::from_diagonal_element(1e-5),
            pose_WB: Pose::identity(),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(Shape::HalfSpace),
            pose_BS: Pose::identity(),
            friction: 0.5,
        };
        desc.add_rigid(floor.clone());
        floor.name = "cube".into();
        floor.motion = Motion::Dynamic;
        floor.shape = Some(Shape::Cuboid { half: Vec3::repeat(0.01) });
        floor.pose_WB = Pose::translation(0.0, 0.01, 0.0);
        desc.add_rigid(floor);
        let mut world = World::new(desc).unwrap();
        let input = world.input();
        (0..3).for_each(|_| {
            world.step(&input, &mut ());
        });
        world
    }

    /// Lifted by half of what the tolerance makes of a gap, a cube does not fall:
    /// `½ · 4 · 10 µm/s · 1 ms` at once would take 0.2 % of its weight. It comes down by so little
    /// in a step that a quarter of what the tolerance makes of its weight is not exceeded, and lies
    /// where it lay in the end.
    #[test]
    fn what_hovers_by_the_tolerance_keeps_its_weight() {
        let mut world = resting(SolverKind::Monolithic);
        let input = world.input();
        let h = world.time_step();
        let settings = world.desc().solver;
        let lift = 0.5 * push_out::slack(h);
        let low = world.state.poses_WB[1].position.y;
        world.state.poses_WB[1].position.y += lift;
        let weight = 0.1 * world.desc().gravity.norm();
        let allowed = 0.25 * settings.velocity_tolerance / (world.desc().gravity.norm() * h);
        for _ in 0..200 {
            world.step(&input, &mut ());
            let force = world.contacts().iter().map(|c| c.force_W.y).sum::<f64>().abs();
            assert!((force / weight - 1.0).abs() <= allowed, "{force} N of {weight} N");
        }
        let off = world.state.poses_WB[1].position.y - low;
        assert!(off.abs() < 1e-3 * lift, "{off} m");
    }

    /// An overlap that is undone moves a body by no more than the tolerance does in a step; a deep
    /// one goes at once.
    #[test]
    fn small_overlaps_are_undone_in_small_parts() {
        for (depth, part) in [(1.05, 0.3), (100.0, 100.0)] {
            let mut world = resting(SolverKind::Monolithic);
            let input = world.input();
            let slack = push_out::slack(world.time_step());
            world.state.poses_WB[1].position.y = 0.01 - depth * slack;
            let from = world.state.poses_WB[1].position.y;
            world.step(&input, &mut ());
            let moved = world.state.poses_WB[1].position.y - from;
            assert!(moved <= part * slack && moved >= 0.1 * part * slack, "{moved} m");
            (0..20).for_each(|_| {
                world.step(&input, &mut ());
            });
            let left = 0.01 - world.state.poses_WB[1].position.y;
            assert!(left > 0.0 && left <= slack, "{left} m");
        }
    }

    #[test]
    fn impulses_that_no_sum_can_hold_are_forgotten() {
        for kind in [SolverKind::Monolithic, SolverKind::TwoStep] {
            for size in [1e300, f64::MAX] {
                let mut world = resting(kind);
                let input = world.input();
                assert!(!world.state.impulses.is_empty());
                world.state.impulses.iter_mut().for_each(|(_, impulse)| impulse.fill(size));
                (0..50).for_each(|_| {
                    world.step(&input, &mut ());
                    assert!(world.state.is_finite(), "{kind:?} {size}: {:?}", world.state);
                });
                // What happened once is over: the cube lies as it did.
                let weight: f64 = world.contacts().iter().map(|c| c.force_W.y).sum();
                assert!((weight.abs() - 0.981).abs() < 1e-3, "{kind:?} {size}: {weight} N");
            }
        }
    }
}
