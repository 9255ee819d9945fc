//! A loaf of bread: a lattice bent to a rounded, bulging shape.

use super::lattice_box::{Cubes, lattice_tets};
use super::soft::{SoftModel, SoftOptions, SoftReport, soft_from_tets};
use crate::RigError;
use crate::error::positive;
use thenar_core::Vec3;
use thenar_core::model::{EmbeddedSurface, Law, Material, SurfaceVertex};

/// A loaf, lying along x, its bottom on y = 0, centred in x and z.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Bread {
    /// Length, height and width (x, y, z) \[m\].
    pub size: Vec3,
    /// Lattice cells along x, y, z; five elements each.
    pub cells: [u32; 3],
    /// Material of the crumb.
    pub crumb: Material,
    /// Young's modulus of the elements at the surface over that of the crumb; 1 is no crust.
    pub crust: f64,
    /// Damping and friction.
    pub options: SoftOptions,
}

impl Bread {
    /// A tin loaf of 180 × 90 × 90 mm.
    pub fn loaf() -> Self {
        Self {
            size: Vec3::new(0.18, 0.09, 0.09),
            cells: [8, 4, 4],
            // Pressed flat, a crumb bears more and more; the corotational law gives way at E and
            // turns inside out.
            crumb: Material { law: Law::NeoHookean, young: 12e3, poisson: 0.25, density: 250.0 },
            crust: 3.0,
            options: SoftOptions { mass_damping: 0.5, stiffness_damping: 5e-3, friction: 0.6 },
        }
    }

    /// A roll that a hand can close around: 130 × 56 × 60 mm.
    pub fn roll() -> Self {
        Self { size: Vec3::new(0.13, 0.056, 0.06), ..Self::loaf() }
    }
}

/// Roundness of the square section: 0 square, 1 round.
const SECTION_ROUND: f64 = 0.55;
/// Inset of the edges of the ends, part of the half length.
const END_DOME: f64 = 0.10;
/// Part by which the top is wider than the bottom.
const TOP_FLARE: f64 = 0.10;
/// Height of the crown above the shoulders, part of the height.
const CROWN: f64 = 0.10;
/// Quads along x, y, z of the collision and render surfaces.
const COLLISION_QUADS: [u32; 3] = [12, 6, 6];
const RENDER_QUADS: [u32; 3] = [36, 18, 18];

/// Builds the loaf.
pub fn bread(bread: &Bread) -> Result<(SoftModel, SoftReport), RigError> {
    for &edge in bread.size.iter() {
        positive("size", edge)?;
    }
    positive("crust", bread.crust)?;
    let cells = bread.cells.map(|n| n as usize);
    if cells.iter().any(|&n| n == 0 || n > 1000) {
        return Err(RigError::invalid("a loaf needs 1 to 1000 cells along each axis"));
    }
    let tets = lattice_tets(cells, Cubes::Five)?;
    let map = LoafMap::new(&bread.size);
    let nodes = lattice_nodes(cells, &map);
    let materials = materials(&tets, cells, bread);

    let (mut model, report) = soft_from_tets("bread", nodes, tets, materials, &bread.options)?;
    let lattice = Embedder { cells, nodes: &model.flesh.nodes, tets: &model.flesh.tets };
    let collision = lattice.surface(COLLISION_QUADS, &map);
    model.render = lattice.surface(RENDER_QUADS, &map);
    model.flesh.collision = collision;
    Ok((model, report))
}

/// Maps the cube [-1, 1]³ to the loaf.
struct LoafMap {
    half: Vec3,
    /// Bounds of the unscaled shape, by which it is brought to size.
    low: Vec3,
    span: Vec3,
}

impl LoafMap {
    fn new(size: &Vec3) -> Self {
        let mut map = Self { half: size * 0.5, low: Vec3::zeros(), span: Vec3::zeros() };
        let n = 24;
        let at = |i: i32| f64::from(i) / f64::from(n);
        let (mut low, mut high) = (Vec3::repeat(f64::MAX), Vec3::repeat(f64::MIN));
        for i in -n..=n {
            for j in -n..=n {
                for k in [-1.0, 1.0] {
                    for q in [
                        Vec3::new(k, at(i), at(j)),
                        Vec3::new(at(i), k, at(j)),
                        Vec3::new(at(i), at(j), k),
                    ] {
                        let p = bulged(&q);
                        (low, high) = (low.inf(&p), high.sup(&p));
                    }
                }
            }
        }
        (map.low, map.span) = (low, high - low);
        map
    }

    /// The place of cube point `q` \[m\].
    fn point(&self, q: &Vec3) -> Vec3 {
        let unit = (bulged(q) - self.low).component_div(&self.span);
        let p = (unit * 2.0 - Vec3::repeat(1.0)).component_mul(&self.half);
        Vec3::new(p.x, p.y + self.half.y, p.z)
    }
}

/// The loaf's shape, about as large as the cube.
fn bulged(q: &Vec3) -> Vec3 {
    // The section: between the square and the disc it maps to (q in [-1, 1]²).
    let (u, v) = (q.z, q.y);
    let round = |a: f64, b: f64| a * (1.0 - SECTION_ROUND * (1.0 - (1.0 - b * b / 2.0).sqrt()));
    let (mut z, mut y) = (round(u, v), round(v, u));
    // Wider above, a crown along the middle, ends drawn in towards their rims.
    z *= 1.0 + TOP_FLARE * (v + 1.0) / 2.0;
    y += CROWN * (v + 1.0) * (1.0 - u * u) * (1.0 - 0.5 * q.x * q.x);
    let rim = (u * u + v * v) / 2.0;
    let x = q.x * (1.0 - END_DOME * rim * q.x * q.x);
    let taper = 1.0 - 0.08 * q.x.powi(4);
    Vec3::new(x, y * taper, z * taper)
}

fn lattice_nodes([nx, ny, nz]: [usize; 3], map: &LoafMap) -> Vec<Vec3> {
    let at = |i: usize, n: usize| 2.0 * i as f64 / n as f64 - 1.0;
    let mut nodes = Vec::with_capacity((nx + 1) * (ny + 1) * (nz + 1));
    for k in 0..=nz {
        for j in 0..=ny {
            nodes.extend((0..=nx).map(|i| map.point(&Vec3::new(at(i, nx), at(j, ny), at(k, nz)))));
        }
    }
    nodes
}

/// Crust where an element has a face on the surface.
fn materials(tets: &[[u32; 4]], [nx, ny, nz]: [usize; 3], bread: &Bread) -> Vec<Material> {
    // The planes of the lattice's surface that a node lies on, as bits.
    let planes = |node: u32| {
        let n = node as usize;
        let (i, j, k) = (n % (nx + 1), n / (nx + 1) % (ny + 1), n / ((nx + 1) * (ny + 1)));
        [i == 0, i == nx, j == 0, j == ny, k == 0, k == nz]
    };
    let on_surface =
        |tet: &[u32; 4]| (0..6).any(|plane| tet.iter().filter(|&&n| planes(n)[plane]).count() >= 3);
    let crust = Material { young: bread.crumb.young * bread.crust, ..bread.crumb };
    tets.iter().map(|tet| if on_surface(tet) { crust } else { bread.crumb }).collect()
}

/// Finds the elements that carry points of the cube's surface.
struct Embedder<'a> {
    cells: [usize; 3],
    nodes: &'a [Vec3],
    tets: &'a [[u32; 4]],
}

impl Embedder<'_> {
    /// The loaf's surface with this many quads along the axes, two triangles each.
    fn surface(&self, quads: [u32; 3], map: &LoafMap) -> EmbeddedSurface {
        let mut surface = EmbeddedSurface::default();
        let mut index = std::collections::BTreeMap::new();
        for axis in 0..3 {
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            for side in [0, quads[axis]] {
                for i in 0..quads[b] {
                    for j in 0..quads[c] {
                        let mut corner = |di: u32, dj: u32| {
                            let mut at = [0; 3];
                            (at[axis], at[b], at[c]) = (side, i + di, j + dj);
                            *index.entry(at).or_insert_with(|| {
                                let q = Vec3::from_fn(|k, _| {
                                    2.0 * f64::from(at[k]) / f64::from(quads[k]) - 1.0
                                });
                                surface.vertices.push(self.vertex(&q, map));
                                surface.vertices.len() as u32 - 1
                            })
                        };
                        let [p, q, r, s] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if side == 0 {
                            surface.triangles.extend([[p, r, q], [p, s, r]]);
                        } else {
                            surface.triangles.extend([[p, q, r], [p, r, s]]);
                        }
                    }
                }
            }
        }
        surface
    }

    /// The element of the point's lattice cell that holds it best.
    fn vertex(&self, q: &Vec3, map: &LoafMap) -> SurfaceVertex {
        let cell = [0, 1, 2].map(|k| {
            let n = self.cells[k];
            (((q[k] + 1.0) / 2.0 * n as f64) as usize).min(n - 1)
        });
        let [nx, ny, _] = self.cells;
        let first = 5 * (cell[0] + nx * (cell[1] + ny * cell[2]));
        let p = map.point(q);
        let best = (first..first + 5)
            .map(|t| (t, barycentric(&p, &self.tets[t].map(|n| self.nodes[n as usize]))))
            .max_by(|a, b| smallest(&a.1).total_cmp(&smallest(&b.1)));
        let (tet, weights) = best.unwrap_or((first, [0.25; 4]));
        SurfaceVertex { tet: tet as u32, weights }
    }
}

fn smallest(weights: &[f64; 4]) -> f64 {
    weights.iter().copied().fold(f64::INFINITY, f64::min)
}

fn barycentric(p: &Vec3, x: &[Vec3; 4]) -> [f64; 4] {
    let volume = super::soft::volume;
    let whole = volume(x);
    std::array::from_fn(|k| {
        let mut part = *x;
        part[k] = *p;
        volume(&part) / whole
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TriMesh;
    use crate::mesh::Topology;

    fn mesh_of(surface: &EmbeddedSurface, model: &SoftModel) -> TriMesh {
        let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
        surface.positions(&model.flesh.tets, &model.flesh.nodes, &mut positions);
        TriMesh::new(positions, surface.triangles.clone()).unwrap()
    }

    #[test]
    fn a_loaf_is_sound_and_of_the_stated_size() {
        let loaf = Bread::loaf();
        let (model, report) = bread(&loaf).unwrap();
        assert_eq!((report.tets, report.nodes), (640, 9 * 25));
        assert!(report.dihedral_min.to_degrees() > 15.0, "{}", report.dihedral_min.to_degrees());
        for (surface, triangles) in [(&model.flesh.collision, 720), (&model.render, 6480)] {
            let mesh = mesh_of(surface, &model);
            let t = Topology::of(&mesh);
            assert!(t.closed() && t.manifold() && t.oriented(), "{t:?}");
            assert_eq!((t.genus(), t.triangles), (Some(0), triangles));
            let [min, max] = mesh.bounds();
            assert!((max - min - loaf.size).amax() < 0.002, "{}", max - min);
            assert!(min.y.abs() < 1e-3);
            // The drawn and the touched body are the one that is computed.
            assert!((mesh.volume() / report.volume - 1.0).abs() < 0.05);
        }
        // Embedded vertices stay close to their element.
        let worst = model.render.vertices.iter().map(|v| smallest(&v.weights)).fold(1.0, f64::min);
        assert!(worst > -0.35, "{worst}");
        assert!((report.mass / (250.0 * report.volume) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn crust_is_stiffer_and_outside() {
        let (model, _) = bread(&Bread { cells: [8, 6, 6], ..Bread::loaf() }).unwrap();
        let crust = |m: &Material| m.young > 20e3;
        assert!(model.flesh.materials.iter().any(crust));
        let (middle, _) = model
            .flesh
            .tets
            .iter()
            .zip(&model.flesh.materials)
            .map(|(t, m)| {
                let c = t.iter().map(|&n| model.flesh.nodes[n as usize]).sum::<Vec3>() / 4.0;
                (m, (c - Vec3::new(0.0, 0.045, 0.0)).norm())
            })
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap();
        assert_eq!(middle.young, 12e3);
        let (plain, _) = bread(&Bread { crust: 1.0, ..Bread::roll() }).unwrap();
        assert!(plain.flesh.materials.iter().all(|m| m.young == 12e3));
    }
}
