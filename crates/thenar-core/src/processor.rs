//! Features of the processor that decide the bits of a result.

/// The vector instructions that steps use here, e.g. `Avx512`. The same input gives the same bits
/// on processors where this is the same.
pub fn vector_instructions() -> String {
    let level = format!("{:?}", fearless_simd::Level::new());
    level.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or_default().into()
}

#[cfg(test)]
mod tests {
    #[test]
    fn they_have_a_short_name() {
        let name = super::vector_instructions();
        assert!(!name.is_empty() && name.len() < 16 && name.is_ascii(), "{name}");
    }
}
