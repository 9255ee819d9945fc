//! Typed reading of accessors, every range checked against the binary chunk.

use super::container::Container;
use crate::RigError;
use gltf::accessor::{DataType, Dimensions};

/// The elements of one accessor.
pub(super) struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: DataType,
    normalized: bool,
    pub count: usize,
    what: String,
}

/// Opens an accessor that must have these dimensions. `what` names it in errors.
pub(super) fn open<'a>(
    file: &'a Container,
    accessor: &gltf::Accessor<'_>,
    dimensions: Dimensions,
    what: &str,
) -> Result<Elements<'a>, RigError> {
    let what = format!("{what} (accessor {})", accessor.index());
    let fail = |cause: String| RigError::invalid(format!("{what}: {cause}"));
    if accessor.dimensions() != dimensions {
        return Err(fail(format!("is {:?}, expected {dimensions:?}", accessor.dimensions())));
    }
    let view = accessor.view().ok_or_else(|| fail("has no buffer view".into()))?;
    let bytes = view_bytes(file, &view).map_err(fail)?;

    let size = accessor.size();
    let stride = view.stride().unwrap_or(size);
    let count = accessor.count();
    let end = count
        .checked_sub(1)
        .ok_or_else(|| fail("is empty".into()))?
        .checked_mul(stride)
        .and_then(|n| n.checked_add(size))
        .and_then(|n| n.checked_add(accessor.offset()))
        .filter(|&end| end <= bytes.len() && stride >= size)
        .ok_or_else(|| {
            fail(format!("{count} elements do not fit in its {} byte view", bytes.len()))
        })?;
    Ok(Elements {
        bytes: &bytes[accessor.offset()..end],
        stride,
        kind: accessor.data_type(),
        normalized: accessor.normalized(),
        count,
        what,
    })
}

/// The bytes of a view, which must lie in the file's own binary chunk.
fn view_bytes<'a>(file: &'a Container, view: &gltf::buffer::View<'_>) -> Result<&'a [u8], String> {
    if let gltf::buffer::Source::Uri(_) = view.buffer().source() {
        return Err("its data lie outside the file, which is not supported".into());
    }
    let end = view.offset().checked_add(view.length());
    end.and_then(|end| file.blob.get(view.offset()..end)).ok_or_else(|| {
        format!(
            "its view reaches byte {} of a binary chunk of {}",
            view.offset() as u128 + view.length() as u128,
            file.blob.len()
        )
    })
}

impl Elements<'_> {
    /// The numbers of element `i` as they stand (normalised integers scaled to 0..1).
    pub fn floats<const N: usize>(&self, i: usize) -> Result<[f64; N], RigError> {
        let mut out = [0.0; N];
        for (k, value) in out.iter_mut().enumerate() {
            *value = self.number(i, k, N)?;
            if !value.is_finite() {
                return Err(self.fail(format!("element {i} is not finite")));
            }
        }
        Ok(out)
    }

    /// The unsigned integers of element `i`.
    pub fn integers<const N: usize>(&self, i: usize) -> Result<[u32; N], RigError> {
        if !matches!(self.kind, DataType::U8 | DataType::U16 | DataType::U32) {
            return Err(self.fail(format!("holds {:?}, expected unsigned integers", self.kind)));
        }
        let mut out = [0; N];
        for (k, value) in out.iter_mut().enumerate() {
            *value = self.raw(i, k, N)? as u32;
        }
        Ok(out)
    }

    fn number(&self, i: usize, k: usize, n: usize) -> Result<f64, RigError> {
        let raw = self.raw(i, k, n)?;
        Ok(match (self.kind, self.normalized) {
            (DataType::F32, _) => raw,
            (DataType::U8, true) => raw / f64::from(u8::MAX),
            (DataType::U16, true) => raw / f64::from(u16::MAX),
            _ => return Err(self.fail(format!("holds {:?}, expected floats", self.kind))),
        })
    }

    /// Component `k` of `n` of element `i`.
    fn raw(&self, i: usize, k: usize, n: usize) -> Result<f64, RigError> {
        let size = match self.kind {
            DataType::U8 | DataType::I8 => 1,
            DataType::U16 | DataType::I16 => 2,
            DataType::U32 | DataType::F32 => 4,
        };
        let at = i * self.stride + k * size;
        let bytes = (i < self.count && k < n)
            .then(|| self.bytes.get(at..at + size))
            .flatten()
            .ok_or_else(|| self.fail(format!("element {i} lies outside")))?;
        Ok(match (self.kind, bytes) {
            (DataType::U8, &[a]) => f64::from(a),
            (DataType::U16, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
            (DataType::U32, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            (DataType::F32, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            _ => return Err(self.fail(format!("holds {:?}, which is not supported", self.kind))),
        })
    }

    fn fail(&self, cause: String) -> RigError {
        RigError::invalid(format!("{}: {cause}", self.what))
    }
}
