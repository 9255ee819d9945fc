//! The page of what is served: where it is, and for whom.

use crate::error::CliError;
use std::io::IsTerminal;
use thenar_serve::http::{Options, Port, Reach, RequestLimits, Server, StartError};
use thenar_serve::hub::Hub;
use thenar_serve::page;

/// The port where nothing else is asked for.
const PORT: u16 = 8014;

/// Options of every command that serves a page.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PageOptions {
    /// Listen on this port, or fail; without it on 8014 or the next free one.
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Let headsets and other computers on the network in: HTTPS, with a pairing token.
    #[arg(long)]
    lan: bool,
    /// Open the page in a browser, whether or not this looks like a desktop.
    #[arg(long, overrides_with = "no_open")]
    open: bool,
    /// Do not open a browser.
    #[arg(long, overrides_with = "open")]
    no_open: bool,
}

impl PageOptions {
    /// True when one of them was given.
    pub fn any(&self) -> bool {
        self.port.is_some() || self.lan || self.open || self.no_open
    }

    /// Serves what is behind this hub.
    ///
    /// # Errors
    /// The port cannot be had.
    pub fn serve(&self, hub: Hub) -> Result<Server, CliError> {
        let options = Options {
            reach: if self.lan { Reach::Lan } else { Reach::Loopback },
            address: None,
            port: self.port.map_or(Port::From(PORT), Port::Exactly),
            limits: RequestLimits::default(),
        };
        Ok(Server::start(&options, hub)?)
    }

    /// Says where the page is, and opens it for who wants that.
    pub fn announce(&self, what: &str, server: &Server) {
        let port = server.address().port();
        if self.port.is_none() && port != PORT {
            println!("Port {PORT} is taken, so this is on {port}.");
        }
        println!("{what} at");
        for url in server.urls() {
            println!("  {url}");
        }
        if !page::BUILT {
            println!("Its page was not built; open the address to see why.");
        }
        if let Some(code) = self.lan.then(|| server.qr_code()).flatten() {
            print_code(&code);
        }
        if let Some(fingerprint) = server.fingerprint() {
            println!(
                "Whoever has such an address can watch, and move the hand. The browser will warn, as \
                 nobody\nvouches for a certificate made just now. Its SHA-256 fingerprint:\n  \
                 {fingerprint}"
            );
        }
        println!("Ctrl-C ends it.");
        if self.wants_browser() {
            // Where there is none, the address stands there to be clicked on.
            let _ = server.urls().first().map(open::that_detached);
        }
    }

    /// A browser is opened on a desktop, by a person, for this computer's own address.
    fn wants_browser(&self) -> bool {
        if self.open || self.no_open {
            return self.open;
        }
        let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let windows = cfg!(any(windows, target_os = "macos"));
        let desktop = windows || set("DISPLAY") || set("WAYLAND_DISPLAY");
        let person = std::io::stdout().is_terminal() && !set("CI") && !set("SSH_CONNECTION");
        !self.lan && desktop && person
    }
}

/// Whatever the terminal's colours, the code is light on dark there.
fn print_code(code: &str) {
    let (begin, end) = match std::io::stdout().is_terminal() {
        true => ("\x1b[97;40m", "\x1b[0m"),
        false => ("", ""),
    };
    for line in code.lines() {
        println!("{begin}{line}{end}");
    }
}

impl From<StartError> for CliError {
    fn from(error: StartError) -> Self {
        match error {
            StartError::PortTaken(_) | StartError::Listen { .. } => Self::Input(error.to_string()),
            _ => Self::Other(error.to_string()),
        }
    }
}
