//! Messages of plain numbers, to be plotted: a schema of one double for each.
//!
//! They are given in Protobuf because both Foxglove and Rerun take any such message apart by the
//! schema that the file holds.

use prost::Message;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::collections::{BTreeMap, BTreeSet};

/// Wire type of eight bytes.
const FIXED64: u64 = 1;

/// The numbers of a topic, in order.
#[derive(Clone, Debug)]
pub struct Numbers {
    /// Name of the message, without its package.
    message: String,
    /// Names that a schema may hold, each once, and units.
    fields: Vec<(String, String)>,
}

/// Turns a name into one that a schema may hold: letters, digits, underscores, no digit first.
fn identifier(name: &str) -> String {
    let mut out: String =
        name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if !out.starts_with(|c: char| c.is_ascii_alphabetic()) {
        out.insert(0, 'n');
    }
    out
}

impl Numbers {
    /// With these names and units. Names that become equal are numbered.
    pub fn new<N: AsRef<str>, U: Into<String>>(
        message: &str,
        fields: impl IntoIterator<Item = (N, U)>,
    ) -> Self {
        let mut taken = BTreeSet::new();
        let mut unique = |name: &str| {
            let plain = identifier(name);
            let mut name = plain.clone();
            let mut count = 1;
            while !taken.insert(name.clone()) {
                count += 1;
                name = format!("{plain}_{count}");
            }
            name
        };
        let fields = fields.into_iter().map(|(name, unit)| (unique(name.as_ref()), unit.into()));
        Self { message: identifier(message), fields: fields.collect() }
    }

    /// Full name of the schema.
    pub fn schema_name(&self) -> String {
        format!("thenar.{}", self.message)
    }

    /// The schema, as MCAP wants it for Protobuf: a serialised `FileDescriptorSet`.
    pub fn schema(&self) -> Vec<u8> {
        let field = |(k, (name, _)): (usize, &(String, String))| FieldDescriptorProto {
            name: Some(name.clone()),
            number: Some(number(k) as i32),
            label: Some(Label::Optional as i32),
            r#type: Some(Type::Double as i32),
            ..FieldDescriptorProto::default()
        };
        let message = DescriptorProto {
            name: Some(self.message.clone()),
            field: self.fields.iter().enumerate().map(field).collect(),
            ..DescriptorProto::default()
        };
        let file = FileDescriptorProto {
            name: Some(format!("thenar/{}.proto", self.message)),
            package: Some("thenar".into()),
            message_type: vec![message],
            syntax: Some("proto3".into()),
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }

    /// Units by name, for the channel's metadata: a schema has no place for them.
    pub fn units(&self) -> BTreeMap<String, String> {
        self.fields.iter().map(|(name, unit)| (format!("unit.{name}"), unit.clone())).collect()
    }

    /// Encodes a message. Zeros are written too, so that a plot need not know what is left out;
    /// what is not known is NaN.
    pub fn encode(&self, values: impl IntoIterator<Item = f64>) -> Vec<u8> {
        let mut out = Vec::with_capacity(11 * self.fields.len());
        let values = values.into_iter().chain(std::iter::repeat(f64::NAN));
        for (k, value) in values.take(self.fields.len()).enumerate() {
            prost::encoding::encode_varint(number(k) << 3 | FIXED64, &mut out);
            out.extend_from_slice(&value.to_le_bytes());
        }
        out
    }
}

/// Number of a field; 19000 to 19999 are Protobuf's own.
fn number(k: usize) -> u64 {
    let number = k as u64 + 1;
    if number < 19_000 { number } else { number + 1000 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost_reflect::{DescriptorPool, DynamicMessage};

    #[test]
    fn a_message_is_read_back_by_the_schema_alone() {
        let names = ["index.force", "index_force", "2nd", "späte"];
        let numbers = Numbers::new("channel.haptic", names.map(|name| (name, "N")));
        let pool = DescriptorPool::decode(&numbers.schema()[..]).unwrap();
        let message = pool.get_message_by_name(&numbers.schema_name()).unwrap();
        let names: Vec<String> = message.fields().map(|field| field.name().into()).collect();
        assert_eq!(names, ["index_force", "index_force_2", "n2nd", "sp_te"]);
        assert_eq!(numbers.units()["unit.n2nd"], "N");
        // One value is missing.
        let bytes = numbers.encode([0.0, -1.5e-300, f64::INFINITY]);
        assert_eq!(bytes.len(), 4 * 9, "zeros are there");
        let read = DynamicMessage::decode(message, &bytes[..]).unwrap();
        let value = |name: &str| read.get_field_by_name(name).unwrap().as_f64().unwrap();
        assert_eq!((value("index_force"), value("index_force_2")), (0.0, -1.5e-300));
        assert!(value("n2nd").is_infinite() && value("sp_te").is_nan());
    }

    #[test]
    fn no_field_has_a_number_that_protobuf_keeps() {
        let numbers = Numbers::new("many", (0..19_100).map(|k| (format!("f{k}"), "1")));
        let pool = DescriptorPool::decode(&numbers.schema()[..]).unwrap();
        let message = pool.get_message_by_name("thenar.many").unwrap();
        let values = numbers.encode((0..19_100).map(f64::from));
        let read = DynamicMessage::decode(message, &values[..]).unwrap();
        assert_eq!(read.get_field_by_name("f19099").unwrap().as_f64(), Some(19_099.0));
    }
}
