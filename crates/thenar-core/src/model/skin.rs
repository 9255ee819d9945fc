//! Skin: an elastic sheet over a deformable body, thinner than any element.

use crate::math::Vec3;
use crate::model::EmbeddedSurface;
use crate::model::patches::{NONE, behind_faces};

/// A sheet of skin of one kind. In its plane it is linear in the stretches, as corotational flesh
/// is; where it is pressed together further than `wrinkling`, it wrinkles and resists no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Thickness \[m\].
    pub thickness: f64,
    /// Young's modulus at small strain \[Pa\].
    pub young: f64,
    /// Poisson's ratio, in (-1, 0.5).
    pub poisson: f64,
    /// Tension in the rest shape, along every direction \[N/m\].
    pub pretension: f64,
    /// Strain at which the sheet wrinkles, counted from where it is slack; 0 resists no compression
    /// at all. It wrinkles at a stress of `young × wrinkling`.
    pub wrinkling: f64,
}

impl Sheet {
    /// Strain at which a stiff sheet on a soft half-space wrinkles, `¼ (3 Ē_s/Ē_f)^⅔` with `Ē_s` of
    /// the softer and `Ē_f` of the sheet, both in plane strain (Allen 1969), for skin of 136 kPa on
    /// tissue of 34 kPa (Maeno et al. 1998): 0.21.
    pub const WRINKLING: f64 = 0.21;
}

/// A piece of skin in one tetrahedron, which it stretches and turns with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Tetrahedron of the body.
    pub tet: u32,
    /// Kind of sheet, an index into `Skin::sheets`.
    pub sheet: u32,
    /// Unit normal in the rest shape, model frame.
    pub normal: Vec3,
    /// Area in the rest shape \[m²\].
    pub area: f64,
}

/// The skin of one deformable body (`WorldDesc::skins`).
#[derive(Clone, Debug, PartialEq)]
pub struct Skin {
    /// Index into `WorldDesc::softs`.
    pub soft: u32,
    /// Kinds of skin.
    pub sheets: Vec<Sheet>,
    /// Facets that it covers, as [`facets`] makes them of a surface.
    pub facets: Vec<Facet>,
}

/// Facets of one tetrahedron whose normals are nearer to each other than this become one. The error
/// in the stiffness along the skin is of second order in the angle: `sin² 15°`, 7 %, at the rim of
/// what is merged.
const MERGED_COS: f64 = 0.966;
/// A triangle is cut so fine that its parts are no longer than this, relative to the cube root of
/// the volume of the tetrahedra at its corners (whose edges are about 2.2 times that root).
const PART: f64 = 0.7;
/// Most parts that an edge is cut into.
const PARTS_MAX: usize = 16;
/// Most tetrahedra of a walk through the mesh: one that has not ended by then ends where it is.
const WALK_MAX: usize = 200;

/// Lays a surface into the tetrahedra that it passes through. Skin moves with flesh, so that its
/// stretch at a place is that of the tetrahedron there, in the plane of the skin: pieces of skin
/// depend on four nodes each, which are coupled already, however the triangles of the surface lie.
/// `sheet` gives the kind of skin of each triangle, or none.
///
/// The areas of all facets sum to that of the triangles. Places outside all tetrahedra belong to
/// the one where the way to them leaves the mesh. Depends on nothing but its input.
///
/// # Panics
/// When an index points nowhere.
pub fn facets(
    nodes: &[Vec3],
    tets: &[[u32; 4]],
    surface: &EmbeddedSurface,
    sheet: impl Fn(usize) -> Option<u32>,
) -> Vec<Facet> {
    let mesh = BoundaryWalk { nodes, tets, behind: behind_faces(tets) };
    let mut places = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(tets, nodes, &mut places);
    let mut pieces: Vec<(u32, u32, Vec3, f64)> = Vec::new();
    for (k, corners) in surface.triangles.iter().enumerate() {
        let Some(sheet) = sheet(k) else { continue };
        let x = corners.map(|v| places[v as usize]);
        let of_corner = corners.map(|v| surface.vertices[v as usize].tet);
        let cross = (x[1] - x[0]).cross(&(x[2] - x[0]));
        let Some(normal) = cross.try_normalize(f64::MIN_POSITIVE) else { continue };
        let n = mesh.parts(&x, &of_corner);
        let area = 0.5 * cross.norm() / (n * n) as f64;
        for [a, b] in parts_of_triangle(n) {
            let p = x[0] + (x[1] - x[0]) * a + (x[2] - x[0]) * b;
            let nearest = [1.0 - a - b, a, b];
            let first = (1..3).fold(0, |m, k| if nearest[k] > nearest[m] { k } else { m });
            pieces.push((mesh.at(&p, of_corner[first]), sheet, normal, area));
        }
    }
    // A stable sort: pieces of one tetrahedron stay in the order of the triangles.
    pieces.sort_by_key(|piece| (piece.0, piece.1));
    merged(&pieces)
}

/// Centroids of the n² parts into which a triangle is cut, as shares of its second and third
/// corner.
fn parts_of_triangle(n: usize) -> impl Iterator<Item = [f64; 2]> {
    let at = move |i: usize, j: usize, third: f64| {
        [(i as f64 + third) / n as f64, (j as f64 + third) / n as f64]
    };
    (0..n).flat_map(move |i| {
        let upright = (0..n - i).map(move |j| at(i, j, 1.0 / 3.0));
        let inverted = (0..(n - i).saturating_sub(1)).map(move |j| at(i, j, 2.0 / 3.0));
        upright.chain(inverted)
    })
}

/// One facet for all pieces of a tetrahedron and sheet that lie about in one plane.
fn merged(pieces: &[(u32, u32, Vec3, f64)]) -> Vec<Facet> {
    let mut facets: Vec<Facet> = Vec::new();
    for group in pieces.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let mut planes: Vec<(Vec3, f64)> = Vec::new();
        for &(_, _, normal, area) in group {
            let near =
                planes.iter_mut().find(|(sum, _)| sum.dot(&normal) > MERGED_COS * sum.norm());
            match near {
                Some((sum, all)) => {
                    *sum += normal * area;
                    *all += area;
                }
                None => planes.push((normal * area, area)),
            }
        }
        let facet = |(sum, area): &(Vec3, f64)| Facet {
            tet: group[0].0,
            sheet: group[0].1,
            normal: sum.normalize(),
            area: *area,
        };
        facets.extend(planes.iter().map(facet));
    }
    facets
}

struct BoundaryWalk<'a> {
    nodes: &'a [Vec3],
    tets: &'a [[u32; 4]],
    behind: Vec<[u32; 4]>,
}

impl BoundaryWalk<'_> {
    fn corners(&self, t: u32) -> [Vec3; 4] {
        self.tets[t as usize].map(|n| self.nodes[n as usize])
    }

    /// Into how many parts each edge of a triangle is cut.
    fn parts(&self, x: &[Vec3; 3], tets: &[u32; 3]) -> usize {
        let longest = (0..3).map(|k| (x[k] - x[(k + 1) % 3]).norm()).fold(0.0, f64::max);
        let size = |&t: &u32| {
            let [a, b, c, d] = self.corners(t);
            ((b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0).cbrt()
        };
        let least = tets.iter().map(size).fold(f64::INFINITY, f64::min);
        ((longest / (PART * least)).ceil() as usize).clamp(1, PARTS_MAX)
    }

    /// The tetrahedron at a place, on the way there from tetrahedron `t`; the last one on it where
    /// it leaves the mesh.
    fn at(&self, p: &Vec3, mut t: u32) -> u32 {
        for _ in 0..WALK_MAX {
            let weights = barycentric(&self.corners(t), p);
            // Through the face that the place lies farthest behind, among those with something
            // behind them.
            let next = (0..4)
                .filter(|&k| weights[k] < 0.0 && self.behind[t as usize][k] != NONE)
                .min_by(|&a, &b| weights[a].total_cmp(&weights[b]));
            let Some(next) = next else { break };
            let beyond = self.behind[t as usize][next];
            // Outside the mesh the way could go on for ever along its boundary: on only as long as
            // it leads nearer.
            let least = |w: [f64; 4]| w.into_iter().fold(f64::INFINITY, f64::min);
            let outside = (0..4).any(|k| weights[k] < 0.0 && self.behind[t as usize][k] == NONE);
            if outside && least(barycentric(&self.corners(beyond), p)) <= least(weights) {
                break;
            }
            t = beyond;
        }
        t
    }
}

/// Barycentric coordinates of a place in a tetrahedron.
fn barycentric([a, b, c, d]: &[Vec3; 4], p: &Vec3) -> [f64; 4] {
    let volume = |a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3| (b - a).cross(&(c - a)).dot(&(d - a));
    let whole = volume(a, b, c, d);
    let parts = [volume(p, b, c, d), volume(a, p, c, d), volume(a, b, p, d), volume(a, b, c, p)];
    parts.map(|part| part / whole)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::SurfaceVertex;
    use crate::random::Random;

    /// A slab of cubes, each of six tetrahedra around a diagonal.
    fn slab(n: usize, edge: f64) -> (Vec<Vec3>, Vec<[u32; 4]>) {
        let m = n + 1;
        let index = |p: [usize; 3]| (p[0] + m * (p[1] + m * p[2])) as u32;
        let cells = |m: usize| (0..m * m * m).map(move |i| [i % m, i / m % m, i / m / m]);
        let nodes = cells(m).map(|p| Vec3::from(p.map(|c| c as f64 * edge))).collect();
        let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let tets = cells(n).flat_map(|cell| {
            paths.map(|path| {
                let mut at = cell;
                let mut tet = [index(at); 4];
                for (k, axis) in path.into_iter().enumerate() {
                    at[axis] += 1;
                    tet[k + 1] = index(at);
                }
                tet
            })
        });
        (nodes, tets.collect())
    }

    /// One triangle whose corners are embedded where they lie.
    fn triangle(nodes: &[Vec3], tets: &[[u32; 4]], x: [Vec3; 3]) -> EmbeddedSurface {
        let vertex = |p: Vec3| {
            let of = |t: u32| barycentric(&tets[t as usize].map(|n| nodes[n as usize]), &p);
            let best = (0..tets.len() as u32)
                .max_by(|&a, &b| {
                    let least = |t| of(t).into_iter().fold(f64::INFINITY, f64::min);
                    least(a).total_cmp(&least(b))
                })
                .unwrap();
            SurfaceVertex { tet: best, weights: of(best) }
        };
        EmbeddedSurface { vertices: x.map(vertex).to_vec(), triangles: vec![[0, 1, 2]] }
    }

    #[test]
    fn parts_of_a_triangle_lie_in_it_and_are_centred() {
        for n in 1..6 {
            let parts: Vec<[f64; 2]> = parts_of_triangle(n).collect();
            assert_eq!(parts.len(), n * n);
            assert!(parts.iter().all(|[a, b]| *a > 0.0 && *b > 0.0 && a + b < 1.0));
            for k in 0..2 {
                let mean = parts.iter().map(|p| p[k]).sum::<f64>() / (n * n) as f64;
                assert!((mean - 1.0 / 3.0).abs() < 1e-14);
            }
        }
    }

    /// Random triangles inside a mesh: their area is kept, and each piece lies where a search
    /// through all tetrahedra finds it.
    #[test]
    fn the_area_is_kept_and_pieces_lie_in_their_tetrahedra() {
        let (nodes, tets) = slab(4, 0.01);
        let mut random = Random::new(3);
        for _ in 0..50 {
            let x: [Vec3; 3] = std::array::from_fn(|_| Vec3::repeat(0.02) + random.vector(0.0199));
            let surface = triangle(&nodes, &tets, x);
            let facets = facets(&nodes, &tets, &surface, |_| Some(7));
            let area = 0.5 * (x[1] - x[0]).cross(&(x[2] - x[0])).norm();
            let sum: f64 = facets.iter().map(|facet| facet.area).sum();
            assert!((sum - area).abs() < 1e-12 * area);
            let normal = (x[1] - x[0]).cross(&(x[2] - x[0])).normalize();
            assert!(facets.iter().all(|f| f.sheet == 7 && (f.normal - normal).norm() < 1e-9));
            let mesh = BoundaryWalk { nodes: &nodes, tets: &tets, behind: behind_faces(&tets) };
            for _ in 0..20 {
                let p = Vec3::repeat(0.02) + random.vector(0.0199);
                let t = mesh.at(&p, surface.vertices[0].tet);
                let least = barycentric(&mesh.corners(t), &p).into_iter().fold(1.0, f64::min);
                assert!(least > -1e-12, "{least}");
            }
        }
    }

    /// Two planes in one tetrahedron stay two facets, those that nearly agree become one.
    #[test]
    fn planes_stay_apart_and_close_normals_merge() {
        let tilted =
            |degrees: f64| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let piece = |degrees: f64| (3, 0, tilted(degrees), 1e-6);
        let apart = merged(&[piece(0.0), piece(60.0), piece(0.0)]);
        assert_eq!(apart.iter().map(|f| f.area).collect::<Vec<_>>(), [2e-6, 1e-6]);
        let one = merged(&[piece(-6.0), piece(6.0)]);
        assert_eq!(one.len(), 1);
        assert!((one[0].normal - Vec3::z()).norm() < 1e-12 && one[0].area == 2e-6);
    }

    /// A surface that sticks out of the mesh belongs to its boundary.
    #[test]
    fn what_lies_outside_belongs_to_the_boundary() {
        let (nodes, tets) = slab(2, 0.01);
        let mut surface = triangle(
            &nodes,
            &tets,
            [
                Vec3::new(0.002, 0.002, 0.019),
                Vec3::new(0.018, 0.002, 0.019),
                Vec3::new(0.002, 0.018, 0.019),
            ],
        );
        // The same corners, 3 mm outside.
        for vertex in &mut surface.vertices {
            let corners = tets[vertex.tet as usize].map(|n| nodes[n as usize]);
            let p: Vec3 = (0..4).map(|k| corners[k] * vertex.weights[k]).sum();
            vertex.weights = barycentric(&corners, &(p + Vec3::z() * 0.004));
        }
        let facets = facets(&nodes, &tets, &surface, |_| Some(0));
        let top = |t: u32| tets[t as usize].iter().any(|&n| nodes[n as usize].z > 0.015);
        assert!(facets.iter().all(|facet| top(facet.tet)));
        assert!((facets.iter().map(|f| f.area).sum::<f64>() - 128e-6).abs() < 1e-15);
        assert!(facets.len() > 3);
    }
}
