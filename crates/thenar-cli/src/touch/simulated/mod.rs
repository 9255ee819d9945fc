//! Simulated devices to feel a scene with, behind real terminals and sockets: no hardware.

#[cfg(unix)]
mod glove;
#[cfg(unix)]
mod grasp;

use crate::error::CliError;

/// Begins the addresses of simulated devices.
const SIMULATED: &str = "simulated";

/// Devices that are simulated as long as this lives.
#[derive(Default)]
pub struct Simulated {
    #[cfg(unix)]
    devices: Vec<Box<dyn Send>>,
}

impl Simulated {
    /// The addresses that stand for this one: its own unless it is of a device to be simulated,
    /// which is started.
    ///
    /// # Errors
    /// There is no such device, or the system gives no place for it.
    pub fn addresses(&mut self, address: &str) -> Result<Vec<String>, CliError> {
        let Some(rest) = address.strip_prefix(SIMULATED) else { return Ok(vec![address.into()]) };
        let (name, options) = match rest.split_once('?') {
            Some((name, _)) => (name, &rest[name.len()..]),
            None => (rest, ""),
        };
        self.start(name.strip_prefix(':').unwrap_or(name), options)
    }

    #[cfg(unix)]
    fn start(&mut self, name: &str, options: &str) -> Result<Vec<String>, CliError> {
        match name {
            "" | "lucidgloves" => {
                let twin = thenar_link::lucidgloves::LucidGlovesTwin::new(false, false);
                let glove = glove::WavingGlove::start(twin, glove::OPEN_TO_CLOSED)?;
                let address = format!("lucidgloves:{}{options}", glove.path().display());
                self.devices.push(Box::new(glove));
                Ok(vec![address])
            }
            "cybergrasp" => {
                let grasp = grasp::WornGrasp::start()?;
                let addresses = grasp.addresses(options);
                self.devices.push(Box::new(grasp));
                Ok(addresses)
            }
            _ => Err(CliError::Input(format!(
                "no device is simulated as `{name}`; there are simulated and simulated:cybergrasp"
            ))),
        }
    }

    #[cfg(not(unix))]
    fn start(&mut self, _: &str, _: &str) -> Result<Vec<String>, CliError> {
        Err(CliError::Input("this system has no pseudo-terminals for a simulated glove".into()))
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn addresses_stand_for_what_is_simulated() {
        let mut simulated = Simulated::default();
        assert_eq!(simulated.addresses("hts:9000").unwrap(), ["hts:9000"]);
        let glove = simulated.addresses("simulated?side=left").unwrap();
        assert!(glove[0].starts_with("lucidgloves:/") && glove[0].ends_with("?side=left"));
        let [tracker, display] = &simulated.addresses("simulated:cybergrasp").unwrap()[..] else {
            panic!("a glove and tendons")
        };
        assert!(tracker.starts_with("cyberglove:/"), "{tracker}");
        assert!(display.starts_with("cybergrasp:127.0.0.1:"), "{display}");
        assert!(thenar_link::open(tracker).is_ok() && thenar_link::open(display).is_ok());
        assert!(simulated.addresses("simulated:arm").unwrap_err().to_string().contains("`arm`"));
        assert_eq!(simulated.devices.len(), 2);
    }
}
