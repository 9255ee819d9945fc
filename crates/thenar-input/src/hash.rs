/// Hash of no bytes, to begin with.
pub const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// The 64-bit FNV-1a hash (Fowler, Noll, Vo), carried on from `hash` over more bytes. It guards
/// against damage and mistakes, not against malice.
pub fn fnv1a(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &b| (hash ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv1a_gives_its_authors_values_in_one_piece_or_two() {
        let hash = |text: &[u8]| fnv1a(FNV_START, text);
        assert_eq!(hash(b""), 0xcbf29ce484222325);
        assert_eq!(hash(b"a"), 0xaf63dc4c8601ec8c);
        assert_eq!(hash(b"foobar"), 0x85944171f73967e8);
        assert_eq!(fnv1a(hash(b"foo"), b"bar"), hash(b"foobar"));
    }
}
