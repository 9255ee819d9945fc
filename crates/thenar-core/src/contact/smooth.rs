//! Normals of a soft surface without jumps from face to face.
//!
//! A surface of flesh is smooth; its triangles are how it is stored. A rigid corner that slides
//! over it feels the normal interpolated between the vertices (Phong 1975), which turns evenly, not
//! that of each face in turn. Edges that are sharp at rest, as those of a block, stay sharp.

use crate::contact::triangle::area_vector;
use crate::math::Vec3;

/// Faces that turn by more than this at rest (cosine of 45°) meet at a sharp edge: nearer to the
/// edge of a block than to a plane.
const SHARP: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// For each corner of each triangle the triangles around it that belong to one smooth piece.
#[derive(Clone, Debug)]
pub(crate) struct SmoothNormals {
    /// The piece of corner k of triangle t: `faces[start[3 t + k]..start[3 t + k + 1]]`.
    start: Vec<u32>,
    faces: Vec<u32>,
    /// Sharp edges of each triangle.
    pub creases: Vec<[bool; 3]>,
}

impl SmoothNormals {
    /// For triangles with their vertices at rest at `x`; `across(t, k)` is the triangle across edge
    /// k.
    pub fn new(
        triangles: &[[u32; 3]],
        x: &[Vec3],
        across: impl Fn(u32, usize) -> Option<u32>,
    ) -> Self {
        let normal = |t: u32| {
            let area = area_vector(&triangles[t as usize].map(|v| x[v as usize]));
            area.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        };
        let is_sharp = |t: u32, u: u32| normal(t).dot(&normal(u)) < SHARP;
        let crease = |t: u32, k: usize| across(t, k).is_some_and(|u| is_sharp(t, u));
        let creases =
            (0..triangles.len() as u32).map(|t| [0, 1, 2].map(|k| crease(t, k))).collect();
        let (mut start, mut faces) = (vec![0], Vec::new());
        for (t, corners) in (0..).zip(triangles) {
            for &v in corners {
                let first = faces.len();
                faces.push(t);
                let mut next = first;
                while next < faces.len() {
                    let u: u32 = faces[next];
                    next += 1;
                    let at = triangles[u as usize].iter().position(|&w| w == v).unwrap_or(0);
                    // The two edges of u that end at v.
                    for k in [at, (at + 2) % 3] {
                        let Some(w) = across(u, k) else { continue };
                        if !faces[first..].contains(&w) && !is_sharp(u, w) {
                            faces.push(w);
                        }
                    }
                }
                faces[first..].sort_unstable();
                start.push(faces.len() as u32);
            }
        }
        Self { start, faces, creases }
    }

    /// Unit outward normal at the point of triangle `t` with these weights; zero where all faces
    /// around it have none.
    pub fn at(&self, t: u32, weights: &[f64; 3], triangles: &[[u32; 3]], x: &[Vec3]) -> Vec3 {
        let corner = |k: usize| {
            let i = 3 * t as usize + k;
            let faces = &self.faces[self.start[i] as usize..self.start[i + 1] as usize];
            let of = |f: &u32| area_vector(&triangles[*f as usize].map(|v| x[v as usize]));
            faces.iter().map(of).sum::<Vec3>().try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        };
        let weighted = (0..3).filter(|&k| weights[k] != 0.0).map(|k| corner(k) * weights[k]);
        weighted.sum::<Vec3>().try_normalize(1e-12).unwrap_or_else(Vec3::zeros)
    }
}
