//! The least area over which two soft surfaces bear their load: the load over the largest pressure
//! on the patch.
//!
//! Where two meshes meet at a vertex or along an edge, what is nearer than [`TOUCHING`] is a
//! sliver, however hard they press: between its vertices neither gives way to the other. What they
//! resolve is the pressure at a vertex, its share of the load over a third of the triangles around
//! it, as seen along the load. No mean pressure is larger than the largest one, so that a patch
//! which bears N with a peak p touches over N / p at least: a single vertex over the surface that
//! it stands for. The larger of both surfaces' peaks counts, which is mostly that of the finer
//! mesh. Under a round tip the peak is half more than the mean (Hertz), and two thirds of the area
//! are asked for. A rigid shape has no triangles to meet: skin on it has the area that is near.
//!
//! [`TOUCHING`]: crate::contact::area::TOUCHING

use crate::capacity_vec::CapacityVec;
use crate::contact::area::{Skin, WEIGHT_MIN, soft_point};
use crate::contact::triangle::stands_for;
use crate::contact::{Contact, SurfacePoint};
use crate::math::Vec3;

const NONE: u32 = u32::MAX;

/// Work space: per triangle and per vertex of the largest surface, and per contact.
#[derive(Clone, Debug)]
pub(super) struct Patches {
    /// A contact on each triangle and at each vertex, and the triangles and vertices with one.
    on: Vec<u32>,
    at: Vec<u32>,
    triangles: CapacityVec<u32>,
    corners: CapacityVec<u32>,
    /// Normal force at each vertex, its size and its sum \[N\], and the vertices with one.
    pressed: Vec<(f64, Vec3)>,
    vertices: CapacityVec<u32>,
    /// For each contact another of its patch, for one of them itself.
    next: CapacityVec<u32>,
    /// For that one: load \[N\], area \[m²\] and largest pressure \[Pa\] of the patch.
    patches: CapacityVec<[f64; 3]>,
}

impl Patches {
    /// For surfaces and contacts up to these counts.
    pub fn with_size(triangles: usize, vertices: usize, contacts: usize) -> Self {
        Self {
            on: vec![NONE; triangles],
            at: vec![NONE; vertices],
            triangles: CapacityVec::with_capacity(triangles),
            corners: CapacityVec::with_capacity(vertices),
            pressed: vec![(0.0, Vec3::zeros()); vertices],
            vertices: CapacityVec::with_capacity(vertices),
            next: CapacityVec::with_capacity(contacts),
            patches: CapacityVec::with_capacity(contacts),
        }
    }

    /// Gives contacts of patches that have less area than their load asks for their shares of it,
    /// by load. `skins` are the soft surfaces of these contacts, `load` gives the normal force of
    /// each \[N\].
    pub fn stand_for(
        &mut self,
        skins: &[Skin],
        of: &[Contact],
        areas: &mut [f64],
        load: impl Fn(usize) -> f64,
    ) {
        self.next.clear();
        self.next.extend(0..of.len() as u32);
        for skin in skins {
            self.join(skin, of, |i| load(i) > 0.0 || areas[i] > 0.0);
        }
        self.patches.clear();
        self.patches.resize(of.len(), [0.0; 3]);
        for (i, area) in areas.iter().enumerate() {
            let of_patch = patch(&self.next, i as u32);
            let [loads, whole, _] = &mut self.patches[of_patch as usize];
            *loads += load(i).max(0.0);
            *whole += area;
        }
        for skin in skins {
            self.find_peaks(skin, of, &load);
        }
        for (i, area) in areas.iter_mut().enumerate() {
            let [loads, whole, peak] = self.patches[patch(&self.next, i as u32) as usize];
            if peak > 0.0 && peak * whole < loads {
                *area = load(i).max(0.0) / peak;
            }
        }
    }

    /// Makes one patch of contacts that lie on a common triangle, or between vertices of which one
    /// is common.
    fn join(&mut self, skin: &Skin, of: &[Contact], touches: impl Fn(usize) -> bool) {
        let Self { on, at, triangles, corners: listed, next, .. } = self;
        for (i, contact) in of.iter().enumerate().filter(|(i, _)| touches(*i)) {
            let mut meet = |first: &mut u32, list: &mut CapacityVec<u32>, place: u32| {
                if *first == NONE {
                    *first = i as u32;
                    list.push(place);
                } else {
                    let [one, other] = [*first, i as u32].map(|k| patch(next, k));
                    next[one.max(other) as usize] = one.min(other);
                }
            };
            for (_, point) in points_on(contact, skin) {
                corners(point).for_each(|(v, _)| meet(&mut at[v as usize], listed, v));
                skin.triangles_of(point, |t| meet(&mut on[t as usize], triangles, t));
            }
        }
        triangles.drain(..).for_each(|t| on[t as usize] = NONE);
        listed.drain(..).for_each(|v| at[v as usize] = NONE);
    }

    /// Raises the largest pressure of each patch to that on this surface.
    fn find_peaks(&mut self, skin: &Skin, of: &[Contact], load: impl Fn(usize) -> f64) {
        let bearing = || of.iter().enumerate().filter(|(i, _)| load(*i) > 0.0);
        for (i, contact) in bearing() {
            for (push_W, point) in points_on(contact, skin) {
                for (v, weight) in corners(point) {
                    let (size, sum) = &mut self.pressed[v as usize];
                    if *size == 0.0 {
                        self.vertices.push(v);
                    }
                    *size += load(i) * weight;
                    *sum += push_W * (load(i) * weight);
                }
            }
        }
        for (i, contact) in bearing() {
            let of_patch = patch(&self.next, i as u32) as usize;
            for (_, point) in points_on(contact, skin) {
                for (v, _) in corners(point) {
                    let (size, sum) = self.pressed[v as usize];
                    let around = skin.surface.around(v).iter().map(|&t| skin.corners(t));
                    let area = stands_for(around, &sum.try_normalize(0.0).unwrap_or_default());
                    if area > 0.0 {
                        let peak = &mut self.patches[of_patch][2];
                        *peak = peak.max(size / area);
                    }
                }
            }
        }
        for v in self.vertices.drain(..) {
            self.pressed[v as usize] = (0.0, Vec3::zeros());
        }
    }
}

/// The contact that stands for the patch of this one.
fn patch(next: &[u32], mut contact: u32) -> u32 {
    while next[contact as usize] != contact {
        contact = next[contact as usize];
    }
    contact
}

/// Points of a contact on this surface, each with the direction in which it is pushed.
fn points_on<'a>(
    contact: &'a Contact,
    skin: &Skin,
) -> impl Iterator<Item = (Vec3, &'a SurfacePoint)> {
    let soft = skin.surface.soft;
    let sites = [(contact.normal_W, &contact.a), (-contact.normal_W, &contact.b)].into_iter();
    let points = sites.filter_map(|(push_W, site)| Some((push_W, soft_point(site)?)));
    points.filter(move |(_, point)| point.soft == soft)
}

fn corners(point: &SurfacePoint) -> impl Iterator<Item = (u32, f64)> {
    point.vertices.into_iter().zip(point.weights).filter(|(_, weight)| *weight > WEIGHT_MIN)
}

#[cfg(test)]
mod tests {
    use crate::contact::tests::{Scene, cube, moved};
    use crate::contact::{Contact, Shape, Site};
    use crate::math::{Pose, Vec3};
    use crate::model::Motion;

    /// An octahedron of 20 mm with its tip down.
    fn tip() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let points = axes.iter().flat_map(|axis| [axis * 0.01, axis * -0.01]).collect();
        let faces = (0..8_u32).map(|k| {
            let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1)];
            if k.count_ones().is_multiple_of(2) { [x, y, z] } else { [x, z, y] }
        });
        (points, faces.collect())
    }

    /// A third of the four triangles at a tip, which seen from below are a square with edges of 10
    /// mm √2.
    const OF_TIP: f64 = 2e-4 / 3.0;

    fn on_a_plane(body: (Vec<Vec3>, Vec<[u32; 3]>), height: f64) -> (Scene, Vec<Contact>) {
        let mut scene = Scene::new();
        scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
        scene.soft(body);
        moved(&mut scene.surfaces[0].0, Vec3::new(0.1, height - 1e-5, 0.2));
        let contacts = scene.find(1e-3);
        (scene, contacts)
    }

    fn lies_at(contact: &Contact, vertex: u32) -> bool {
        matches!(&contact.a, Site::Soft(p) if p.vertices[0] == vertex && p.weights[0] == 1.0)
    }

    /// A tip that bears load has the area that its vertex stands for, however large the load;
    /// without any, what is near.
    #[test]
    fn a_tip_stands_for_its_surface() {
        let (scene, contacts) = on_a_plane(tip(), 0.01);
        let pressed = |i: usize, newton: f64| if lies_at(&contacts[i], 3) { newton } else { 0.0 };
        for newton in [1e-3, 0.2, 30.0] {
            let area: f64 = scene.areas_under(&contacts, |i| pressed(i, newton)).iter().sum();
            assert!((area - OF_TIP).abs() < 1e-12, "{area} m² under {newton} N");
        }
        let area: f64 = scene.areas(&contacts).iter().sum();
        assert!(area > 0.0 && area < 0.01 * OF_TIP, "{area} m² without load");
    }

    /// Two tips of one body are two patches: what one bears gives the other no area.
    #[test]
    fn tips_apart_are_patches_apart() {
        let ((mut points, mut faces), (more, others)) = (tip(), tip());
        points.extend(more.iter().map(|p| p + Vec3::x() * 0.03));
        faces.extend(others.iter().map(|t| t.map(|v| v + 6)));
        let (scene, contacts) = on_a_plane((points, faces), 0.01);
        let near = scene.areas(&contacts);
        let areas =
            scene.areas_under(&contacts, |i| if lies_at(&contacts[i], 3) { 5.0 } else { 0.0 });
        let of = |areas: &[f64], vertex: u32| -> f64 {
            let at = contacts.iter().zip(areas).filter(|(c, _)| lies_at(c, vertex));
            at.map(|(_, area)| area).sum()
        };
        assert!((of(&areas, 3) - OF_TIP).abs() < 1e-12);
        assert_eq!(of(&areas, 9), of(&near, 9));
        // Loads that differ by much each have an area of their own.
        let load = |i: usize| if lies_at(&contacts[i], 3) { 5.0 } else { 0.01 };
        let bears = |i: usize| lies_at(&contacts[i], 3) || lies_at(&contacts[i], 9);
        let areas = scene.areas_under(&contacts, |i| if bears(i) { load(i) } else { 0.0 });
        assert!((of(&areas, 3) - OF_TIP).abs() < 1e-12 && (of(&areas, 9) - OF_TIP).abs() < 1e-12);
    }

    /// A flat face that bears the same pressure all over, or more in the middle, keeps the area
    /// that is found.
    #[test]
    fn a_patch_that_is_resolved_keeps_its_area() {
        let (scene, contacts) = on_a_plane(cube(0.04, 4), 0.02);
        let found = scene.areas(&contacts);
        let edges = |c: &Contact| {
            let from_middle = c.position_W - Vec3::new(0.1, 0.0, 0.2);
            [from_middle.x, from_middle.z].iter().filter(|x| x.abs() > 0.019).count() as i32
        };
        for round in [0.0, 1.0] {
            let load = |i: usize| {
                let from_middle = contacts[i].position_W - Vec3::new(0.1, 0.0, 0.2);
                0.5_f64.powi(edges(&contacts[i])) * (1.0 - round * from_middle.norm() / 0.03)
            };
            assert_eq!(scene.areas_under(&contacts, load), found);
        }
    }
}
