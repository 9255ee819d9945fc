//! The arrays behind the JSON of a model message.

use thenar_core::{Pose, Vec3};

/// Location of an array, as the JSON gives it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Array {
    offset: usize,
    count: usize,
    r#type: &'static str,
    width: usize,
}

/// Arrays one after another, each aligned to 4 bytes, little-endian.
#[derive(Debug, Default)]
pub struct Arrays {
    bytes: Vec<u8>,
}

impl Arrays {
    /// All bytes so far.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn add<const B: usize>(
        &mut self,
        r#type: &'static str,
        width: usize,
        numbers: impl IntoIterator<Item = [u8; B]>,
    ) -> Array {
        let offset = self.bytes.len();
        numbers.into_iter().for_each(|number| self.bytes.extend_from_slice(&number));
        let count = (self.bytes.len() - offset) / (B * width);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        Array { offset, count, r#type, width }
    }

    /// Numbers in 32 bits, `width` to an element.
    pub fn f32(&mut self, width: usize, numbers: impl IntoIterator<Item = f64>) -> Array {
        self.add("f32", width, numbers.into_iter().map(|x| (x as f32).to_le_bytes()))
    }

    /// Array of indices.
    pub fn u32(&mut self, width: usize, numbers: impl IntoIterator<Item = u32>) -> Array {
        self.add("u32", width, numbers.into_iter().map(u32::to_le_bytes))
    }

    /// Short indices.
    pub fn u16(&mut self, width: usize, numbers: impl IntoIterator<Item = u16>) -> Array {
        self.add("u16", width, numbers.into_iter().map(u16::to_le_bytes))
    }

    /// Array of bytes.
    pub fn u8(&mut self, width: usize, numbers: impl IntoIterator<Item = u8>) -> Array {
        self.add("u8", width, numbers.into_iter().map(|x| [x]))
    }

    /// Array of points \[m\].
    pub fn points<'a>(&mut self, points: impl IntoIterator<Item = &'a Vec3>) -> Array {
        self.f32(3, points.into_iter().flat_map(|p| [p.x, p.y, p.z]))
    }

    /// Array of triangles.
    pub fn triangles(&mut self, triangles: &[[u32; 3]]) -> Array {
        self.u32(3, triangles.iter().flatten().copied())
    }
}

/// Position, then quaternion x, y, z, w.
pub fn seven(pose: &Pose) -> [f64; 7] {
    let (p, q) = (pose.position, pose.rotation.coords);
    [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
}
