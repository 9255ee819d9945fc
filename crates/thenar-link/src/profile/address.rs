//! Part of an address after the driver's name: `place?key=value&key=value`.

use crate::LinkError;
use std::net::IpAddr;
use std::path::PathBuf;
use thenar_core::model::Side;

/// A parsed address.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Address {
    /// A port, or host and port.
    pub place: String,
    /// Side of the hand that wears the device; overrules the profile.
    pub side: Option<Side>,
    /// A profile to use instead of the user's own.
    pub profile: Option<PathBuf>,
    /// The only peer that is heard, for gloves that call us.
    pub from: Option<IpAddr>,
    /// Address of a tracker for the wrist, over what the profile says.
    pub wrist: Option<String>,
}

impl Address {
    /// Reads the address of `driver`.
    ///
    /// # Errors
    /// An option that is unknown or has no such value.
    pub fn parse(driver: &str, address: &str) -> Result<Self, LinkError> {
        let refuse = |cause: String| LinkError::Setting {
            what: format!("device `{driver}:{address}`"),
            cause,
        };
        let (place, options) = address.split_once('?').unwrap_or((address, ""));
        let mut parsed = Self { place: place.into(), ..Self::default() };
        // The address of a wrist's tracker may have options of its own: it comes last.
        let (options, wrist) = match options.split_once("wrist=") {
            Some((before, wrist)) if before.is_empty() || before.ends_with('&') => {
                (before, Some(wrist))
            }
            _ => (options, None),
        };
        parsed.wrist = wrist.map(str::to_string);
        for option in options.split('&').filter(|option| !option.is_empty()) {
            match option.split_once('=') {
                Some(("side", "left")) => parsed.side = Some(Side::Left),
                Some(("side", "right")) => parsed.side = Some(Side::Right),
                Some(("profile", file)) if !file.is_empty() => parsed.profile = Some(file.into()),
                Some(("from", ip)) if place.starts_with("wifi") => {
                    let bad = |_| refuse(format!("from is `{ip}`, expected an IP address"));
                    parsed.from = Some(ip.parse().map_err(bad)?);
                }
                _ => {
                    let from = if place.starts_with("wifi") { "from=ADDRESS, " } else { "" };
                    let cause = format!(
                        "`{option}` is not an option; there are side=left, side=right, {from}\
                         profile=FILE and, last, wrist=DEVICE"
                    );
                    return Err(refuse(cause));
                }
            }
        }
        Ok(parsed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_follow_the_place() {
        let read = |text: &str| Address::parse("d", text).map_err(|e| e.to_string());
        assert_eq!(read("COM3").unwrap().place, "COM3");
        let full = read("/dev/x?side=left&profile=a b.toml&wrist=hts:9000?side=left").unwrap();
        assert_eq!((full.place.as_str(), full.side), ("/dev/x", Some(Side::Left)));
        assert_eq!(full.profile, Some("a b.toml".into()));
        assert_eq!(full.wrist.as_deref(), Some("hts:9000?side=left"));
        let wifi = read("wifi:70?from=10.0.0.7").unwrap();
        assert_eq!(wifi.from, Some(IpAddr::from([10, 0, 0, 7])));
        let told = read("wifi?from=glove").unwrap_err();
        assert!(told.ends_with("from is `glove`, expected an IP address"), "{told}");
        assert!(read("/dev/x?from=10.0.0.7").unwrap_err().contains("not an option"));
        let told = read("/dev/x?side=up").unwrap_err();
        assert!(
            told.starts_with("device `d:/dev/x?side=up`: `side=up` is not an option;"),
            "{told}"
        );
    }
}
