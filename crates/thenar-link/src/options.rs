//! Addresses of devices on the network: `place?key=value&key=value`.

use crate::LinkError;
use std::net::{IpAddr, SocketAddr};
use std::str::FromStr;

/// An address taken apart.
#[derive(Clone, Debug, PartialEq)]
pub struct Options<'a> {
    driver: &'a str,
    address: &'a str,
    /// Part before `?`.
    pub place: &'a str,
    pairs: Vec<(&'a str, &'a str)>,
}

impl<'a> Options<'a> {
    /// Takes the address of `driver` apart.
    ///
    /// # Errors
    /// An option that is not `known`.
    pub fn parse(driver: &'a str, address: &'a str, known: &[&str]) -> Result<Self, LinkError> {
        let (place, rest) = address.split_once('?').unwrap_or((address, ""));
        let mut options = Self { driver, address, place, pairs: Vec::new() };
        for option in rest.split('&').filter(|option| !option.is_empty()) {
            match option.split_once('=') {
                Some((key, value)) if known.contains(&key) => options.pairs.push((key, value)),
                _ => {
                    let there = known.join("=, ");
                    return Err(options.refuse(format!("`{option}` is not an option of {there}=")));
                }
            }
        }
        Ok(options)
    }

    /// The text of an option.
    pub fn text(&self, key: &str) -> Option<&'a str> {
        self.pairs.iter().rev().find(|(known, _)| *known == key).map(|(_, value)| *value)
    }

    /// The value of an option.
    ///
    /// # Errors
    /// It is not `expected`.
    pub fn value<T: FromStr>(&self, key: &str, expected: &str) -> Result<Option<T>, LinkError> {
        let read = |text: &str| {
            text.parse().map_err(|_| self.refuse(format!("{key} is `{text}`, expected {expected}")))
        };
        self.text(key).map(read).transpose()
    }

    /// Address to listen at: `PORT` or `ADDRESS:PORT`, with defaults for what is missing.
    ///
    /// # Errors
    /// It is neither.
    pub fn listen_at(
        &self,
        place: &str,
        address: IpAddr,
        port: u16,
    ) -> Result<SocketAddr, LinkError> {
        if place.is_empty() {
            return Ok((address, port).into());
        }
        if let Ok(port) = place.parse() {
            return Ok((address, port).into());
        }
        place.parse().map_err(|_| {
            self.refuse(format!("`{place}` is neither a port nor an address with a port"))
        })
    }

    /// The error that an address cannot be used, with its cause.
    pub fn refuse(&self, cause: String) -> LinkError {
        LinkError::Setting { what: self.name(), cause }
    }

    /// The error that a device cannot be opened, with its cause.
    pub fn cannot_open(&self, cause: &dyn std::fmt::Display) -> LinkError {
        let device = format!("{}:{}", self.driver, self.address);
        LinkError::Open { device, cause: cause.to_string() }
    }

    fn name(&self) -> String {
        format!("device `{}:{}`", self.driver, self.address)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_read_strictly() {
        let known = ["from", "speed"];
        let read = |text| Options::parse("d", text, &known);
        let options = read("9000?from=10.0.0.1&speed=0.5").unwrap();
        assert_eq!((options.place, options.text("from")), ("9000", Some("10.0.0.1")));
        assert_eq!(options.value::<f64>("speed", "a number").unwrap(), Some(0.5));
        let told = options.value::<u16>("speed", "a whole number").unwrap_err().to_string();
        let want =
            "device `d:9000?from=10.0.0.1&speed=0.5`: speed is `0.5`, expected a whole number";
        assert_eq!(told, want);
        let told = read("x?speed").unwrap_err().to_string();
        assert_eq!(told, "device `d:x?speed`: `speed` is not an option of from=, speed=");

        let here = IpAddr::from([127, 0, 0, 1]);
        let at = |place| options.listen_at(place, here, 7).map(|a| a.to_string());
        assert_eq!(at("").unwrap(), "127.0.0.1:7");
        assert_eq!(at("90").unwrap(), "127.0.0.1:90");
        assert_eq!(at("0.0.0.0:90").unwrap(), "0.0.0.0:90");
        assert_eq!(at("[::1]:90").unwrap(), "[::1]:90");
        assert!(at("99999").unwrap_err().to_string().contains("`99999` is neither a port"));
    }
}
