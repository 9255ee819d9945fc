//! Good files, to be damaged.

use thenar_rig::TriMesh;

/// A mesh as OBJ, corners in all three forms.
pub fn obj(mesh: &TriMesh) -> Vec<u8> {
    let mut text = String::from("# a mesh\nmtllib none.mtl\no thing\n");
    for p in &mesh.positions {
        text += &format!("v {} {} {}\n", p.x, p.y, p.z);
    }
    for [a, b, c] in &mesh.triangles {
        text += &format!("f {}/1/1 {}//2 {}\n", a + 1, b + 1, c + 1);
    }
    text.into_bytes()
}

/// A mesh as text STL.
pub fn ascii_stl(mesh: &TriMesh) -> Vec<u8> {
    let mut text = String::from("solid thing\n");
    for t in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for p in mesh.corners(t) {
            text += &format!("vertex {} {} {}\n", p.x, p.y, p.z);
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid thing\n").into_bytes()
}

/// A GLB with one triangle, and one whose triangle is bound to a joint.
pub fn glb(skinned: bool) -> Vec<u8> {
    let mut blob: Vec<u8> = Vec::new();
    for x in [0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        blob.extend(x.to_le_bytes());
    }
    for i in [0u16, 1, 2, 0] {
        blob.extend(i.to_le_bytes());
    }
    blob.extend([0u8; 12]); // joints
    for x in [1f32, 0.0, 0.0, 0.0].repeat(3) {
        blob.extend(x.to_le_bytes());
    }
    for i in 0..16 {
        blob.extend((if i % 5 == 0 { 1f32 } else { 0.0 }).to_le_bytes());
    }
    let skin = if skinned {
        (
            r#","JOINTS_0":2,"WEIGHTS_0":3"#,
            r#","skin":0"#,
            r#","skins":[{"joints":[1],"inverseBindMatrices":4}]"#,
        )
    } else {
        ("", "", "")
    };
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0{}}},{{"name":"wrist"}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0{}}},"indices":1}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},{{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}},{{"bufferView":2,"componentType":5121,"count":3,"type":"VEC4"}},{{"bufferView":3,"componentType":5126,"count":3,"type":"VEC4"}},{{"bufferView":4,"componentType":5126,"count":1,"type":"MAT4"}}],"bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":8}},{{"buffer":0,"byteOffset":44,"byteLength":12}},{{"buffer":0,"byteOffset":56,"byteLength":48}},{{"buffer":0,"byteOffset":104,"byteLength":64}}],"buffers":[{{"byteLength":{}}}]{}}}"#,
        skin.1,
        skin.0,
        blob.len(),
        skin.2
    );
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + blob.len();
    let mut bytes = b"glTF".to_vec();
    for n in [2, total as u32, json.len() as u32] {
        bytes.extend(n.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((blob.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(blob);
    bytes
}
