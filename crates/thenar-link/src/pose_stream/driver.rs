//! Driver of pose streams.

use super::{PoseStream, UDP_PORT};
use crate::options::Options;
use crate::transport::{PipeTransport, WebSocketTransport, listening, websocket};
use crate::worker::{Connect, Device};
use crate::{Driver, FoundDevice, LinkError, Opened, replay};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};

/// `poses:udp`, `poses:ws://HOST:PORT/PATH` and `poses:FILE`.
pub struct PoseStreamDriver;

impl Driver for PoseStreamDriver {
    fn name(&self) -> &'static str {
        "poses"
    }

    fn about(&self) -> &'static str {
        "hands as JSON lines: poses:9010 (UDP from this computer), poses:0.0.0.0:9010?from=IP, \
         poses:ws://HOST:PORT/PATH, poses:PIPE, or a recording, poses:FILE.jsonl"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        if address.starts_with("ws:") {
            // Its options are the server's.
            let options = Options::parse(self.name(), "", &[])?;
            websocket::authority(address)
                .map_err(|e| options.refuse(format!("`{address}`: {e}")))?;
            let url = address.to_owned();
            let connect = move || -> std::io::Result<Box<dyn crate::Transport>> {
                Ok(Box::new(WebSocketTransport::call(&url)?))
            };
            return device(address, Box::new(connect), true);
        }
        let path = Path::new(address);
        if path.is_file() {
            return replay::open(path, &replay::Settings::default());
        }
        if is_pipe(path) {
            let path: PathBuf = path.into();
            let connect = move || -> std::io::Result<Box<dyn crate::Transport>> {
                Ok(Box::new(PipeTransport::open(&path)?))
            };
            return device(address, Box::new(connect), false);
        }
        let options = Options::parse(self.name(), address, &["from"])?;
        let from = options.value::<IpAddr>("from", "an IP address")?;
        let place = options.place.strip_prefix("udp").unwrap_or(options.place);
        let place = place.strip_prefix(':').unwrap_or(place);
        let at = options.listen_at(place, Ipv4Addr::LOCALHOST.into(), UDP_PORT).map_err(|_| {
            let place = options.place;
            options.refuse(format!("`{place}` is not a port, an address or an existing file"))
        })?;
        let connect = listening(at, from).map_err(|e| options.cannot_open(&e))?;
        device(options.place, connect, true)
    }
}

fn device(place: &str, connect: Connect, messages: bool) -> Result<Opened, LinkError> {
    let protocol = PoseStream::new(messages);
    Device::tracker(format!("poses:{place}"), connect, Box::new(protocol)).open()
}

fn is_pipe(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        path.metadata().is_ok_and(|data| data.file_type().is_fifo())
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}
