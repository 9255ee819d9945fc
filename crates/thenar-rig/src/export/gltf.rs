//! Binary glTF 2.0 (GLB): surfaces, and a skeleton as nodes.

use crate::RigError;
use serde_json::{Value, json};
use thenar_core::{Pose, Vec3};

/// The bones that carry a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VertexSkin {
    /// Bone indices.
    pub bones: [u16; 4],
    /// Weights of the bones, of sum 1.
    pub weights: [f32; 4],
}

/// A surface.
pub struct GlbMesh<'a> {
    /// Name of the node.
    pub name: &'a str,
    /// Vertices \[m\].
    pub positions: &'a [Vec3],
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Linear red, green, blue in [0, 1].
    pub colour: [f32; 3],
    /// One per vertex, when the surface follows the skeleton.
    pub skin: Option<&'a [VertexSkin]>,
}

/// Bones in the frame of the meshes.
pub struct Skeleton<'a> {
    /// Names of the targets.
    pub names: Vec<&'a str>,
    /// Parents, before their children.
    pub parents: Vec<Option<u32>>,
    /// Poses in the frame of the meshes, in which the meshes are as they are given.
    pub poses: Vec<Pose>,
}

/// glTF's numbers for component types and buffer targets.
const FLOAT: u32 = 5126;
const U16: u32 = 5123;
const U32: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// A GLB file of meshes, and of a skeleton whose motion moves those meshes that have a skin.
///
/// # Errors
/// When an index does not fit, a number is not finite, or a skin has no skeleton.
pub fn glb(meshes: &[GlbMesh], skeleton: Option<&Skeleton>) -> Result<Vec<u8>, RigError> {
    let mut file = Builder::default();
    if let Some(skeleton) = skeleton {
        file.add_skeleton(skeleton)?;
    }
    for mesh in meshes {
        let bones = skeleton.map_or(0, |s| s.poses.len());
        check(mesh, bones)?;
        file.add_mesh(mesh);
    }
    Ok(file.finish())
}

fn check(mesh: &GlbMesh, bones: usize) -> Result<(), RigError> {
    let fail = |what: String| Err(RigError::invalid(format!("mesh \"{}\": {what}", mesh.name)));
    let count = mesh.positions.len();
    if mesh.triangles.is_empty() {
        return fail("no triangles".into());
    }
    if let Some(i) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= count) {
        return fail(format!("a triangle names vertex {i} of {count}"));
    }
    if let Some(i) = mesh.positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return fail(format!("vertex {i} is not finite"));
    }
    match mesh.skin {
        Some(skin) if skin.len() != count => {
            fail(format!("{} skin weights for {count} vertices", skin.len()))
        }
        Some(skin) if skin.iter().flat_map(|s| s.bones).any(|b| usize::from(b) >= bones) => {
            fail(format!("its skin names a bone beyond the {bones} of the skeleton"))
        }
        _ => Ok(()),
    }
}

#[derive(Default)]
struct Builder {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    nodes: Vec<Value>,
    roots: Vec<usize>,
    skins: Vec<Value>,
}

impl Builder {
    /// Adds an array and returns its accessor.
    fn array(
        &mut self,
        bytes: &[u8],
        count: usize,
        component: u32,
        kind: &str,
        target: Option<u32>,
    ) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view =
            json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": component,
            "count": count,
            "type": kind,
        }));
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[Vec3]) -> usize {
        let bytes = floats(vectors.iter().flat_map(|v| [v.x as f32, v.y as f32, v.z as f32]));
        self.array(&bytes, vectors.len(), FLOAT, "VEC3", Some(VERTICES))
    }

    fn add_mesh(&mut self, mesh: &GlbMesh) {
        let positions = self.vectors(mesh.positions);
        let single = |f: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
            (0..3).map(|k| mesh.positions.iter().map(|p| p[k] as f32).fold(start, f)).collect()
        };
        self.accessors[positions]["min"] = json!(single(f32::min, f32::INFINITY));
        self.accessors[positions]["max"] = json!(single(f32::max, f32::NEG_INFINITY));
        let normals = self.vectors(&vertex_normals(mesh.positions, mesh.triangles));
        let corners: Vec<u8> =
            mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let count = 3 * mesh.triangles.len();
        let indices = self.array(&corners, count, U32, "SCALAR", Some(INDICES));

        let mut attributes = json!({"POSITION": positions, "NORMAL": normals});
        if let Some(skin) = mesh.skin {
            let bones: Vec<u8> =
                skin.iter().flat_map(|s| s.bones).flat_map(u16::to_le_bytes).collect();
            let weights = floats(skin.iter().flat_map(|s| s.weights));
            attributes["JOINTS_0"] =
                self.array(&bones, skin.len(), U16, "VEC4", Some(VERTICES)).into();
            attributes["WEIGHTS_0"] =
                self.array(&weights, skin.len(), FLOAT, "VEC4", Some(VERTICES)).into();
        }
        let [r, g, b] = mesh.colour;
        self.materials.push(json!({
            "name": mesh.name,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.6,
            },
        }));
        self.meshes.push(json!({
            "name": mesh.name,
            "primitives": [{
                "attributes": attributes,
                "indices": indices,
                "material": self.materials.len() - 1,
            }],
        }));
        let mut node = json!({"name": mesh.name, "mesh": self.meshes.len() - 1});
        if mesh.skin.is_some() {
            node["skin"] = 0.into();
        }
        self.roots.push(self.nodes.len());
        self.nodes.push(node);
    }

    /// Bones become the first nodes, in order; poses relative to the parent.
    fn add_skeleton(&mut self, skeleton: &Skeleton) -> Result<(), RigError> {
        let count = skeleton.poses.len();
        if skeleton.names.len() != count || skeleton.parents.len() != count || count == 0 {
            return Err(RigError::invalid(
                "a skeleton needs a name, parent and pose for each bone",
            ));
        }
        for (i, pose) in skeleton.poses.iter().enumerate() {
            let parent = skeleton.parents[i];
            if parent.is_some_and(|p| p as usize >= i) || !pose.is_finite() {
                let what = format!(
                    "bone \"{}\" comes before its parent, or its pose is not finite",
                    skeleton.names[i]
                );
                return Err(RigError::invalid(what));
            }
            let local = parent.map_or(*pose, |p| skeleton.poses[p as usize].inverse() * *pose);
            let (t, r) = (local.position, local.rotation.coords);
            let mut node = json!({
                "name": skeleton.names[i],
                "translation": [t.x, t.y, t.z],
                "rotation": [r.x, r.y, r.z, r.w],
            });
            let children: Vec<usize> =
                (i..count).filter(|&c| skeleton.parents[c] == Some(i as u32)).collect();
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            self.nodes.push(node);
            if parent.is_none() {
                self.roots.push(i);
            }
        }
        let inverse = floats(skeleton.poses.iter().flat_map(|pose| column_matrix(&pose.inverse())));
        let matrices = self.array(&inverse, count, FLOAT, "MAT4", None);
        let joints: Vec<usize> = (0..count).collect();
        self.skins.push(json!({"inverseBindMatrices": matrices, "joints": joints}));
        Ok(())
    }

    fn finish(mut self) -> Vec<u8> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut document = json!({
            "asset": {"version": "2.0", "generator": "thenar"},
            "scene": 0,
            "scenes": [{"nodes": self.roots}],
        });
        let length = self.bytes.len();
        if length > 0 {
            document["buffers"] = json!([{"byteLength": length}]);
        }
        let parts = [
            ("nodes", self.nodes),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("skins", self.skins),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
        ];
        // glTF does not allow empty arrays.
        for (key, list) in parts.into_iter().filter(|(_, list)| !list.is_empty()) {
            document[key] = list.into();
        }
        container(document.to_string().into_bytes(), &self.bytes)
    }
}

/// The GLB container: a header and two chunks, each padded to four bytes.
fn container(mut text: Vec<u8>, binary: &[u8]) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut out = Vec::with_capacity(total);
    let word = |out: &mut Vec<u8>, n: usize| out.extend((n as u32).to_le_bytes());
    out.extend(b"glTF");
    word(&mut out, 2);
    word(&mut out, total);
    word(&mut out, text.len());
    out.extend(b"JSON");
    out.extend(&text);
    word(&mut out, binary.len());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

fn floats(numbers: impl Iterator<Item = f32>) -> Vec<u8> {
    numbers.flat_map(f32::to_le_bytes).collect()
}

/// A pose as a 4×4 matrix, column by column.
fn column_matrix(pose: &Pose) -> [f32; 16] {
    let m = pose.rotation.to_rotation_matrix().into_inner();
    let t = pose.position;
    std::array::from_fn(|i| {
        let (row, column) = (i % 4, i / 4);
        let value = match (row, column) {
            (3, 3) => 1.0,
            (3, _) => 0.0,
            (_, 3) => t[row],
            _ => m[(row, column)],
        };
        value as f32
    })
}

/// Area-weighted unit normals.
fn vertex_normals(positions: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::zeros(); positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|i| positions[i as usize]);
        let n = (b - a).cross(&(c - a));
        for &i in t {
            normals[i as usize] += n;
        }
    }
    normals.iter().map(|n| n.try_normalize(1e-30).unwrap_or_else(Vec3::y)).collect()
}
