//! Macros that declare a table, a choice of tables, or a set of words once, and derive from it
//! the type, its reader and its schema.

/// A table: `key: type [where RANGE] [= default];` with a doc comment for each key.
macro_rules! table {
    ($(#[doc = $about:literal])+ pub struct $name:ident {
        $($(#[doc = $doc:literal])+ $key:ident : $kind:ty $(where $range:ident)? $(= $default:expr)?;)*
    }) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug)]
        pub struct $name { $($(#[doc = $doc])+ pub $key: $kind,)* }

        impl $crate::text::Read for $name {
            #[allow(unused_variables)] // a table may have no keys
            fn read(
                node: &$crate::text::Node, cx: &$crate::text::Cx<'_>,
            ) -> Result<Self, $crate::text::Fault> {
                let fields = $crate::text::Fields::new(node, cx, &[$(stringify!($key)),*])?;
                Ok(Self { $($key: fields.take::<$kind>(
                    stringify!($key),
                    $crate::text::declare::range!($($range)?),
                    $crate::text::declare::default!($($default)?),
                )?,)* })
            }

            #[allow(unused_variables, unused_mut)] // a table may have no keys
            fn schema(
                defs: &mut $crate::text::Defs, cx: &$crate::text::Cx<'_>,
            ) -> serde_json::Value {
                defs.part(stringify!($name), |defs| {
                    let mut properties = serde_json::Map::new();
                    let mut required: Vec<&str> = Vec::new();
                    $({
                        let range = $crate::text::declare::range!($($range)?);
                        let inner = cx.inside($crate::text::Step::Key(stringify!($key)), range);
                        let mut schema = <$kind as $crate::text::Read>::schema(defs, &inner);
                        schema["description"] = [$($doc),+].concat().trim().into();
                        properties.insert(stringify!($key).into(), schema);
                        let default: Option<$kind> = $crate::text::declare::default!($($default)?);
                        if default.or_else(<$kind as $crate::text::Read>::absent).is_none() {
                            required.push(stringify!($key));
                        }
                    })*
                    serde_json::json!({
                        "type": "object",
                        "description": ([$($about),+].concat().trim()),
                        "properties": properties,
                        "required": required,
                        "additionalProperties": false,
                    })
                })
            }
        }
    };
}

/// A table whose key `$tag` chooses what else it holds.
macro_rules! choice {
    ($(#[doc = $about:literal])+ pub enum $name:ident by $tag:literal {
        $($(#[doc = $doc:literal])+ $word:literal => $variant:ident($inner:ty),)*
    }) => {
        $(#[doc = $about])+
        #[derive(Clone, Debug)]
        pub enum $name { $($(#[doc = $doc])+ $variant($inner),)* }

        impl $crate::text::Read for $name {
            fn read(
                node: &$crate::text::Node, cx: &$crate::text::Cx<'_>,
            ) -> Result<Self, $crate::text::Fault> {
                let words: &[&str] = &[$($word),*];
                let chosen = $crate::text::declare::word_of(node, cx, $tag, words)?;
                let inner = cx.with_tag($tag);
                match chosen {
                    $($word => <$inner as $crate::text::Read>::read(node, &inner).map(Self::$variant),)*
                    _ => Err(cx.fault(&node.place, "unknown kind")),
                }
            }

            fn schema(
                defs: &mut $crate::text::Defs, cx: &$crate::text::Cx<'_>,
            ) -> serde_json::Value {
                defs.part(stringify!($name), |defs| {
                    let variants = vec![$({
                        let part = <$inner as $crate::text::Read>::schema(defs, cx);
                        defs.tagged(&part, $tag, $word, [$($doc),+].concat().trim())
                    }),*];
                    serde_json::json!({
                        "description": ([$($about),+].concat().trim()),
                        "oneOf": variants,
                    })
                })
            }
        }
    };
}

/// A set of words; after `once`, old spellings, which are read and never offered.
macro_rules! words {
    ($(#[doc = $about:literal])+ pub enum $name:ident {
        $($(#[doc = $doc:literal])+ $word:literal => $variant:ident,)*
    } $(once { $($old:ident => $now:literal,)* })?) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name { $($(#[doc = $doc])+ $variant,)* }

        impl $crate::text::Read for $name {
            fn read(
                node: &$crate::text::Node, cx: &$crate::text::Cx<'_>,
            ) -> Result<Self, $crate::text::Fault> {
                let once = &[$($(($old, $now)),*)?];
                match $crate::text::declare::word(node, cx, &[$($word),*], once)? {
                    $($word => Ok(Self::$variant),)*
                    _ => Err(cx.fault(&node.place, "unknown word")),
                }
            }

            fn schema(
                _: &mut $crate::text::Defs, _: &$crate::text::Cx<'_>,
            ) -> serde_json::Value {
                serde_json::json!({ "type": "string", "enum": [$($word),*] })
            }
        }
    };
}

macro_rules! range {
    () => {
        $crate::text::Range::ANY
    };
    ($range:ident) => {
        $crate::text::Range::$range
    };
}

macro_rules! default {
    () => {
        None
    };
    ($default:expr) => {
        Some($default)
    };
}

pub(crate) use {choice, default, range, table, words};

use super::{Cx, Fault, Node, Range, Step, Value, nearest};

/// The word in `node`, one of `known`; `once` has old spellings, each with the present one.
pub(crate) fn word<'a>(
    node: &'a Node,
    cx: &Cx<'_>,
    known: &[&str],
    once: &[(&str, &'static str)],
) -> Result<&'a str, Fault> {
    let list = || format!("one of \"{}\"", known.join("\", \""));
    match &node.value {
        Value::Text(word) if known.contains(&word.as_str()) => Ok(word),
        Value::Text(word) => {
            if let Some((_, now)) = once.iter().find(|(old, _)| old == word) {
                return Ok(now);
            }
            let mut fault = cx.expected(node, list());
            if let Some(near) = nearest(word, known.iter().copied()) {
                fault.problem.push_str(&format!("; did you mean \"{near}\"?"));
            }
            Err(fault)
        }
        _ => Err(cx.expected(node, list())),
    }
}

/// The word under `tag` in a table.
pub(crate) fn word_of<'a>(
    node: &'a Node,
    cx: &Cx<'_>,
    tag: &str,
    known: &[&str],
) -> Result<&'a str, Fault> {
    if !matches!(node.value, Value::Table(_)) {
        return Err(cx.expected(node, "a table"));
    }
    match node.get(tag) {
        Some(chosen) => word(chosen, &cx.inside(Step::Key(tag), Range::ANY), known, &[]),
        None => Err(cx.fault(
            &node.place,
            format!("the key `{tag}` is missing; expected one of \"{}\"", known.join("\", \"")),
        )),
    }
}
