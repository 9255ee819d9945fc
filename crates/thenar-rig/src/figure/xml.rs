//! XML as descriptions of robots use it: elements whose attributes are numbers and names.

use crate::RigError;
use roxmltree::{Document, Node, ParsingOptions};
use thenar_input::quoted;

/// Larger files are refused.
const BYTES_MAX: usize = 16 << 20;
/// Elements deeper than this are refused.
const DEPTH_MAX: usize = 500;
/// Most attributes of one element, and most namespaces of a file: the parser compares each with all
/// others.
const ATTRIBUTES_MAX: usize = 1000;

/// The tree of a text without a document type.
///
/// # Errors
/// Names the line and the cause.
pub(super) fn parse(text: &str) -> Result<Document<'_>, RigError> {
    if text.len() > BYTES_MAX {
        let size = text.len() >> 20;
        return Err(RigError::invalid(format!(
            "the XML text has {size} MiB or more, at most {} MiB can be read",
            BYTES_MAX >> 20
        )));
    }
    check_attributes(text)?;
    let options = ParsingOptions { allow_dtd: false, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| match error {
        roxmltree::Error::DtdDetected => RigError::invalid(
            "the XML text declares a document type (<!DOCTYPE>), which is not read: remove it",
        ),
        roxmltree::Error::UnexpectedEndOfStream => {
            RigError::line(text.lines().count().max(1), "the XML text ends within an element")
        }
        other => RigError::line(other.pos().row as usize, format!("not XML: {other}")),
    })?;
    check_depth(&document)?;
    Ok(document)
}

/// Refuses more attributes or namespaces than can be compared quickly.
fn check_attributes(text: &str) -> Result<(), RigError> {
    let many = |piece: &str| piece.bytes().filter(|&b| b == b'=').count() > ATTRIBUTES_MAX;
    let element = |piece: &&str| !piece.starts_with(['!', '?']);
    if text.split('<').filter(element).any(many) {
        let what = format!("an element of the XML text has more than {ATTRIBUTES_MAX} attributes");
        return Err(RigError::invalid(what));
    }
    if text.matches("xmlns").count() > ATTRIBUTES_MAX {
        let what = format!("the XML text has more than {ATTRIBUTES_MAX} namespaces");
        return Err(RigError::invalid(what));
    }
    Ok(())
}

fn check_depth(document: &Document<'_>) -> Result<(), RigError> {
    let mut open = vec![(Element { node: document.root_element() }, 1)];
    while let Some((element, depth)) = open.pop() {
        if depth > DEPTH_MAX {
            return Err(element.error(format!("elements nest deeper than {DEPTH_MAX} levels")));
        }
        open.extend(element.children().map(|child| (child, depth + 1)));
    }
    Ok(())
}

/// An element of a document.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
}

impl<'a> Element<'a> {
    /// The outermost element.
    pub fn root(document: &'a Document<'a>) -> Self {
        Self { node: document.root_element() }
    }

    /// Name of the element, without a prefix.
    pub fn tag(self) -> &'a str {
        self.node.tag_name().name()
    }

    /// Address of the element's namespace; empty where it has none.
    pub fn namespace(self) -> &'a str {
        self.node.tag_name().namespace().unwrap_or_default()
    }

    /// Elements directly inside, in order.
    pub fn children(self) -> impl DoubleEndedIterator<Item = Element<'a>> {
        self.node.children().filter(|node| node.is_element()).map(|node| Element { node })
    }

    /// Elements of this name directly inside, in order.
    pub fn named(self, tag: &'a str) -> impl DoubleEndedIterator<Item = Element<'a>> {
        self.children().filter(move |child| child.tag() == tag)
    }

    /// The first element of this name directly inside.
    pub fn child(self, tag: &'a str) -> Option<Element<'a>> {
        self.named(tag).next()
    }

    /// The first element of this name directly inside, which must be there.
    pub fn needs(self, tag: &'a str) -> Result<Element<'a>, RigError> {
        self.child(tag).ok_or_else(|| self.error(format!("<{tag}> is missing inside")))
    }

    /// All elements inside, at any depth, itself first.
    pub fn descendants(self) -> impl Iterator<Item = Element<'a>> {
        self.node.descendants().filter(|node| node.is_element()).map(|node| Element { node })
    }

    /// All attributes, without those of namespaces.
    pub fn attributes(self) -> impl Iterator<Item = Attribute<'a>> {
        let plain = self.node.attributes().filter(|a| a.namespace().is_none());
        plain.map(move |a| Attribute { element: self, name: a.name(), value: a.value().trim() })
    }

    /// An attribute, where it is given.
    pub fn get(self, name: &str) -> Option<Attribute<'a>> {
        self.attributes().find(|a| a.name == name)
    }

    /// A name, where it is given; an empty one is an error.
    pub fn name(self, name: &str) -> Result<Option<&'a str>, RigError> {
        self.get(name).map(Attribute::name).transpose()
    }

    /// A name that must be there.
    pub fn needs_name(self, name: &str) -> Result<&'a str, RigError> {
        self.name(name)?.ok_or_else(|| self.missing(name, "a name"))
    }

    /// A finite number, where it is given.
    pub fn number(self, name: &str) -> Result<Option<f64>, RigError> {
        self.get(name).map(Attribute::number).transpose()
    }

    /// A finite number that must be there.
    pub fn needs_number(self, name: &str) -> Result<f64, RigError> {
        self.number(name)?.ok_or_else(|| self.missing(name, "a finite number"))
    }

    /// Finite numbers, where they are given.
    pub fn numbers<const N: usize>(self, name: &str) -> Result<Option<[f64; N]>, RigError> {
        self.get(name).map(Attribute::numbers).transpose()
    }

    /// Returns an error that names the element and its line, and says what is wrong.
    pub fn error(self, what: impl std::fmt::Display) -> RigError {
        let line = self.node.document().text_pos_at(self.node.range().start).row as usize;
        RigError::line(line, format!("<{}>: {what}", self.tag()))
    }

    /// An attribute that is not there, and what it should be.
    pub fn missing(self, name: &str, expected: &str) -> RigError {
        self.error(format!("{name} is missing ({expected} is expected)"))
    }
}

/// An attribute of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attribute<'a> {
    element: Element<'a>,
    /// Name of the attribute.
    pub name: &'a str,
    /// Text of it, without blanks around.
    pub value: &'a str,
}

impl<'a> Attribute<'a> {
    /// The text as a name; an empty one is an error.
    pub fn name(self) -> Result<&'a str, RigError> {
        if self.value.is_empty() { Err(self.error("a name")) } else { Ok(self.value) }
    }

    /// The text as one finite number.
    pub fn number(self) -> Result<f64, RigError> {
        finite(self.value).ok_or_else(|| self.error("a finite number"))
    }

    /// The text as exactly N finite numbers.
    pub fn numbers<const N: usize>(self) -> Result<[f64; N], RigError> {
        let found = self.list(N).ok().and_then(|list| list.try_into().ok());
        found.ok_or_else(|| self.error(&format!("{N} finite numbers")))
    }

    /// The text as one to `most` finite numbers.
    pub fn list(self, most: usize) -> Result<Vec<f64>, RigError> {
        let words = self.value.split_ascii_whitespace().take(most + 1);
        let found: Option<Vec<f64>> = words.map(finite).collect();
        found.filter(|list| (1..=most).contains(&list.len())).ok_or_else(|| {
            self.error(&match most {
                1 => "a finite number".to_owned(),
                _ => format!("at most {most} finite numbers"),
            })
        })
    }

    /// The position of the text among words.
    pub fn one_of(self, words: &[&str]) -> Result<usize, RigError> {
        let found = words.iter().position(|word| *word == self.value);
        found.ok_or_else(|| self.error(&format!("one of {}", words.join(", "))))
    }

    /// Returns an error that says what the text should be and what it is.
    pub fn error(self, expected: &str) -> RigError {
        let found = quoted(self.value);
        self.element.error(format!("{} must be {expected}, not {found}", self.name))
    }
}

fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|x: &f64| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_names_are_read_and_told_with_their_line_when_wrong() {
        let text =
            "<a>\n <b n=' 1 -2.5e1\t3 ' one='0.5' word='up' none='' bad='1 x' inf='inf'/>\n</a>";
        let document = parse(text).unwrap();
        let b = Element::root(&document).child("b").unwrap();
        assert_eq!(b.numbers::<3>("n").unwrap(), Some([1.0, -25.0, 3.0]));
        assert_eq!(b.number("one").unwrap(), Some(0.5));
        assert_eq!(b.number("nothing").unwrap(), None);
        assert_eq!(b.get("word").unwrap().one_of(&["down", "up"]).unwrap(), 1);
        let message = |error: RigError| error.to_string();
        let two = message(b.numbers::<2>("n").unwrap_err());
        assert_eq!(two, "line 2: <b>: n must be 2 finite numbers, not \"1 -2.5e1 3\"");
        let four = message(b.numbers::<4>("n").unwrap_err());
        assert!(four.contains("must be 4 finite numbers"), "{four}");
        assert!(message(b.number("inf").unwrap_err()).contains("a finite number, not \"inf\""));
        assert!(message(b.numbers::<2>("bad").unwrap_err()).contains("\"1 x\""));
        assert_eq!(
            message(b.name("none").unwrap_err()),
            "line 2: <b>: none must be a name, not \"\""
        );
        let missing = message(b.needs_number("mass").unwrap_err());
        assert_eq!(missing, "line 2: <b>: mass is missing (a finite number is expected)");
        let word = message(b.get("word").unwrap().one_of(&["x", "y"]).unwrap_err());
        assert!(word.contains("one of x, y, not \"up\""), "{word}");
    }

    #[test]
    fn what_is_no_plain_xml_is_refused() {
        let error = |text: &str| parse(text).unwrap_err().to_string();
        assert!(error("").contains("line 1"));
        assert!(error("<a>\n<b>\n</a>").contains("line 3: not XML"), "{}", error("<a>\n<b>\n</a>"));
        let bomb = "<!DOCTYPE a [<!ENTITY x \"y\">]><a>&x;</a>";
        assert!(error(bomb).contains("<!DOCTYPE>"), "{}", error(bomb));
        assert!(error("<a>&x;</a>").contains("line 1"));
        assert!(error(&" ".repeat(17 << 20)).contains("at most 16 MiB"));
        let wide: String = (0..200_000).map(|i| format!(" a{i}=''")).collect();
        assert!(error(&format!("<a{wide}/>")).contains("more than 1000 attributes"));
    }

    #[test]
    fn hostile_depth_is_an_error_and_no_overflow() {
        for depth in [501, 1_000_000] {
            let text = format!("{}{}", "<a>".repeat(depth), "</a>".repeat(depth));
            let error = parse(&text).unwrap_err().to_string();
            assert!(error.contains("deeper than 500 levels"), "{error}");
        }
        assert!(parse(&"<a>".repeat(1_000_000)).is_err());
        assert!(parse(&format!("{}{}", "<a>".repeat(500), "</a>".repeat(500))).is_ok());
    }
}
