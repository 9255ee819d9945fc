//! Driver that reaches the streamer.

use super::{HandTrackingStreamer, Points, TCP_PORT, UDP_PORT};
use crate::options::Options;
use crate::profile::camera_timing;
use crate::transport::{StreamTransport, TcpServer, host_and_port, listening, tcp};
use crate::worker::{Connect, Device};
use crate::{Driver, FoundDevice, LinkError, Opened};
use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;

/// Shipped profile.
const SHIPPED: &str = include_str!("../../profiles/hts.toml");

/// `hts:udp`, `hts:tcp` and `hts:call:HOST`.
pub struct HandTrackingStreamerDriver;

impl Driver for HandTrackingStreamerDriver {
    fn name(&self) -> &'static str {
        "hts"
    }

    fn about(&self) -> &'static str {
        "Hand Tracking Streamer on a Quest: hts:9000 (UDP), hts:tcp:8000 (it calls us) or \
         hts:call:HOST:8000; ?from=IP hears one headset only, ?points=local or world, ?profile=FILE"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let options = Options::parse(self.name(), address, &["from", "points", "profile"])?;
        let from = options.value::<IpAddr>("from", "an IP address")?;
        let profile = options.text("profile").map(PathBuf::from);
        let timing = camera_timing(self.name(), SHIPPED, profile)?;
        let points = match options.text("points") {
            None | Some("auto") => Points::Auto,
            Some("local") => Points::Local,
            Some("world") => Points::World,
            Some(other) => {
                let cause = format!("points is `{other}`, expected auto, local or world");
                return Err(options.refuse(cause));
            }
        };
        let any = Ipv4Addr::UNSPECIFIED.into();
        let (kind, rest) = options.place.split_once(':').unwrap_or((options.place, ""));
        let (connect, datagrams): (Connect, bool) = match kind {
            "tcp" => {
                let server = TcpServer::listen(options.listen_at(rest, any, TCP_PORT)?, from)
                    .map_err(|e| options.cannot_open(&e))?;
                (Box::new(move || Ok(Box::new(server.accept()?))), false)
            }
            "call" if !rest.is_empty() => {
                let peer =
                    host_and_port(rest, Some(TCP_PORT)).map_err(|cause| options.refuse(cause))?;
                let call = move || -> std::io::Result<Box<dyn crate::Transport>> {
                    Ok(Box::new(StreamTransport::new(tcp::call(&peer)?)?))
                };
                (Box::new(call), false)
            }
            _ => {
                let place = if kind == "udp" { rest } else { options.place };
                let at = options.listen_at(place, any, UDP_PORT)?;
                (listening(at, from).map_err(|e| options.cannot_open(&e))?, true)
            }
        };
        let protocol = HandTrackingStreamer::new(datagrams, points);
        Device::tracker(format!("hts:{}", options.place), connect, Box::new(protocol))
            .timed(timing)
            .open()
    }
}
