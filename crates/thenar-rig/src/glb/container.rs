//! The outer shell of a GLB file: header, JSON chunk, binary chunk.

use crate::RigError;

/// A parsed file whose JSON has passed the `gltf` crate's validation.
pub(super) struct Container {
    pub document: gltf::Document,
    pub blob: Vec<u8>,
}

const HEADER_BYTES: usize = 12;

impl Container {
    pub fn new(bytes: &[u8]) -> Result<Self, RigError> {
        check_header(bytes)?;
        let invalid = |e| RigError::invalid(format!("not a valid GLB file: {e}"));
        // The validation itself indexes accessors by the attributes, so these come first.
        let mut parsed = gltf::Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
        let mut json = parsed.document.into_json();
        check_extensions(&json.extensions_required)?;
        check_attributes(&json)?;
        forget_looks(&mut json);
        parsed.document = gltf::Document::from_json(json).map_err(invalid)?;
        let file = Self { document: parsed.document, blob: parsed.blob.unwrap_or_default() };
        file.check_buffers()?;
        Ok(file)
    }

    /// Refuses what would be read wrongly, also where nothing uses it.
    fn check_buffers(&self) -> Result<(), RigError> {
        if let Some(accessor) = self.document.accessors().find(|a| a.sparse().is_some()) {
            return Err(RigError::invalid(format!(
                "accessor {} is sparse, which is not supported",
                accessor.index()
            )));
        }
        for buffer in self.document.buffers() {
            let there = self.blob.len();
            if matches!(buffer.source(), gltf::buffer::Source::Bin) && buffer.length() > there {
                return Err(RigError::invalid(format!(
                    "buffer {} says {} bytes, its binary chunk has {there}",
                    buffer.index(),
                    buffer.length()
                )));
            }
        }
        Ok(())
    }
}

/// Extensions that pack vertices, which `gltf-transform dequantize` unpacks.
const PACKING: [&str; 4] = [
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "KHR_draco_mesh_compression",
];

/// True of extensions about looks alone, which are not read.
fn is_of_looks(extension: &str) -> bool {
    ["_texture_", "_materials_", "_lights_"].iter().any(|part| extension.contains(part))
}

/// Errs in one line on extensions that change what a mesh is.
fn check_extensions(required: &[String]) -> Result<(), RigError> {
    let needed = required.iter().map(String::as_str).filter(|name| !is_of_looks(name));
    let (packing, others): (Vec<&str>, Vec<&str>) = needed.partition(|name| PACKING.contains(name));
    let help = if others.is_empty() {
        "which packs its vertices and is not read; write it without, such as by `gltf-transform dequantize \
         in.glb out.glb`, or by Blender's export without compression"
    } else {
        "which is not read; export it without"
    };
    let all = [packing, others].concat();
    if all.is_empty() {
        return Ok(());
    }
    Err(RigError::invalid(format!(
        "the file requires the glTF extension {}, {help}",
        all.join(", ")
    )))
}

/// Takes out materials and textures, so that nothing about looks stands in the way of a mesh.
fn forget_looks(json: &mut gltf::json::Root) {
    json.extensions_required.clear();
    json.materials.clear();
    json.textures.clear();
    json.images.clear();
    json.samplers.clear();
    json.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives).for_each(|p| p.material = None);
}

/// Checks that the attributes of meshes name accessors that exist.
fn check_attributes(json: &gltf::json::Root) -> Result<(), RigError> {
    let count = json.accessors.len();
    for (m, mesh) in json.meshes.iter().enumerate() {
        for accessor in mesh.primitives.iter().flat_map(|p| p.attributes.values()) {
            if accessor.value() >= count {
                return Err(RigError::invalid(format!(
                    "mesh {m} names accessor {}, but there are only {count}",
                    accessor.value()
                )));
            }
        }
    }
    Ok(())
}

/// Checks magic, version and length, which the parser trusts.
fn check_header(bytes: &[u8]) -> Result<(), RigError> {
    let word = |at: usize| {
        let four: Option<[u8; 4]> = bytes.get(at..at + 4).and_then(|b| b.try_into().ok());
        four.map(u32::from_le_bytes)
    };
    let (Some(magic), Some(version), Some(length)) = (word(0), word(4), word(8)) else {
        return Err(RigError::byte(bytes.len(), "the file ends inside the GLB header"));
    };
    if magic != u32::from_le_bytes(*b"glTF") {
        return Err(RigError::byte(0, "not a GLB file: it does not start with `glTF`"));
    }
    if version != 2 {
        return Err(RigError::byte(4, format!("glTF version {version}, expected 2")));
    }
    if (length as usize) < HEADER_BYTES || length as usize > bytes.len() {
        return Err(RigError::byte(
            8,
            format!("the header says {length} bytes, the file has {}", bytes.len()),
        ));
    }
    Ok(())
}
