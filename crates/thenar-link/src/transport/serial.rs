//! Serial ports: cables, USB adapters, Bluetooth serial, pseudo-terminals.

use super::SEND_PATIENCE;
use crate::{FoundDevice, Transport};
use serialport::{ClearBuffer, SerialPort, SerialPortType};
use std::io::{self, ErrorKind, Read, Write};
use std::time::{Duration, Instant};

#[cfg(unix)]
type Port = serialport::TTYPort;
#[cfg(not(unix))]
type Port = Box<dyn SerialPort>;

/// An open port, 8 bits, no parity, 1 stop bit, no flow control.
pub struct SerialTransport {
    port: Port,
    #[cfg(unix)]
    path: String,
    timeout: Duration,
}

impl SerialTransport {
    /// Opens a port for this program alone and drops what waited in it.
    ///
    /// # Errors
    /// It is not there, in use, or not ours to open.
    pub fn open(path: &str, baud: u32) -> io::Result<Self> {
        let timeout = Duration::from_millis(1);
        let port = open_port(serialport::new(path, baud).timeout(timeout))?;
        // Pseudo-terminals of some systems cannot, and need not.
        let _ = port.clear(ClearBuffer::Input);
        Ok(Self {
            port,
            #[cfg(unix)]
            path: path.to_owned(),
            timeout,
        })
    }
}

/// Never blocks in a write, whatever the device does: the port's own time limits only guard the
/// first byte.
#[cfg(unix)]
fn open_port(builder: serialport::SerialPortBuilder) -> io::Result<Port> {
    let port = builder.open_native()?;
    never_block(&port)?;
    Ok(port)
}

#[cfg(unix)]
pub(crate) fn never_block(port: &serialport::TTYPort) -> io::Result<()> {
    use nix::fcntl::{FcntlArg, OFlag, fcntl};
    use std::os::fd::AsRawFd;
    fcntl(port.as_raw_fd(), FcntlArg::F_SETFL(OFlag::O_NONBLOCK))?;
    Ok(())
}

#[cfg(not(unix))]
fn open_port(builder: serialport::SerialPortBuilder) -> io::Result<Port> {
    Ok(builder.open()?)
}

impl Transport for SerialTransport {
    fn receive(&mut self, buffer: &mut [u8], timeout: Duration) -> io::Result<usize> {
        if timeout != self.timeout {
            self.port.set_timeout(timeout)?;
            self.timeout = timeout;
        }
        match self.port.read(buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Err(error) if passing(&error) => Ok(0),
            result => result,
        }
    }

    fn send(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let start = Instant::now();
        while !bytes.is_empty() {
            match self.port.write(bytes) {
                Ok(sent) => bytes = &bytes[sent..],
                // Asleep: this thread is above the loop.
                Err(error) if passing(&error) && start.elapsed() < SEND_PATIENCE => {
                    std::thread::sleep(Duration::from_micros(200));
                }
                Err(error) if passing(&error) => {
                    return Err(io::Error::new(ErrorKind::TimedOut, "it takes no more bytes"));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Opened anew: the library gives its own handle to nobody. The port is for this program alone
    /// but for that moment.
    #[cfg(unix)]
    fn handle(&mut self) -> io::Result<Option<std::os::fd::OwnedFd>> {
        use nix::fcntl::OFlag;
        use std::os::unix::fs::OpenOptionsExt;
        self.port.set_exclusive(false)?;
        let flags = (OFlag::O_NOCTTY | OFlag::O_NONBLOCK).bits();
        let opened =
            std::fs::OpenOptions::new().read(true).write(true).custom_flags(flags).open(&self.path);
        self.port.set_exclusive(true)?;
        Ok(Some(opened?.into()))
    }
}

fn passing(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

/// The ports of this computer that `like` accepts, by USB vendor, product and product name; ports
/// that are no USB devices are offered as 0, 0 and their kind.
pub fn ports(like: impl Fn(u16, u16, &str) -> Option<String>) -> Vec<FoundDevice> {
    let found = serialport::available_ports().unwrap_or_default();
    let offer = |port: serialport::SerialPortInfo| {
        let what = match &port.port_type {
            SerialPortType::UsbPort(usb) => {
                like(usb.vid, usb.pid, usb.product.as_deref().unwrap_or(""))
            }
            SerialPortType::BluetoothPort => like(0, 0, "Bluetooth"),
            SerialPortType::PciPort => like(0, 0, "PCI"),
            SerialPortType::Unknown => like(0, 0, ""),
        };
        what.map(|what| FoundDevice { address: port.port_name, what })
    };
    found.into_iter().filter_map(offer).collect()
}
