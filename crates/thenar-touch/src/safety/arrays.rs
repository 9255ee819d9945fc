//! Arrays of any length, for serde: its own are of fixed ones.

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserializer, Serializer};
use std::fmt::{self, Formatter};

/// Writes its numbers, one after the other.
pub fn serialize<S: Serializer, const N: usize>(
    array: &[f64; N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(N)?;
    array.iter().try_for_each(|number| tuple.serialize_element(number))?;
    tuple.end()
}

/// Reads as many numbers.
pub fn deserialize<'de, D: Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<[f64; N], D::Error> {
    struct Numbers<const N: usize>;
    impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
        type Value = [f64; N];

        fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
            write!(f, "{N} numbers")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut numbers: A) -> Result<[f64; N], A::Error> {
            let mut array = [0.0; N];
            for (i, place) in array.iter_mut().enumerate() {
                *place = numbers.next_element()?.ok_or_else(|| Error::invalid_length(i, &self))?;
            }
            Ok(array)
        }
    }
    deserializer.deserialize_tuple(N, Numbers)
}
