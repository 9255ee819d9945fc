//! The certificate of `--lan`: made at start for this machine's names, vouched for by nobody.

use rcgen::{CertificateParams, DnType, ExtendedKeyUsagePurpose, KeyPair};
use ring::digest::{SHA256, digest};
use std::fmt::Write as _;
use std::sync::Arc;
use std::time::{Duration, SystemTime};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::PrivateKeyDer;

/// A day before now, as clocks differ, to a month after.
const VALID: [Duration; 2] = [Duration::from_secs(86_400), Duration::from_secs(30 * 86_400)];

/// TLS certificate ready to serve, and the fingerprint to recognise it by.
pub struct Certificate {
    /// Shakes hands.
    pub acceptor: TlsAcceptor,
    /// SHA-256 of the certificate, as browsers show it: `AB:CD:…`.
    pub fingerprint: String,
}

impl std::fmt::Debug for Certificate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Certificate({})", self.fingerprint)
    }
}

/// Makes a key and a certificate for these names and addresses.
///
/// # Errors
/// A name does not fit into a certificate.
pub fn make(names: Vec<String>) -> Result<Certificate, Box<dyn std::error::Error + Send + Sync>> {
    let key = KeyPair::generate()?;
    let mut params = CertificateParams::new(names)?;
    let now = SystemTime::now();
    params.not_before = (now - VALID[0]).into();
    params.not_after = (now + VALID[1]).into();
    params.distinguished_name.push(DnType::CommonName, "Thenar on this machine");
    params.extended_key_usages = vec![ExtendedKeyUsagePurpose::ServerAuth];
    let certificate = params.self_signed(&key)?;
    let fingerprint = fingerprint(certificate.der());
    let key = PrivateKeyDer::try_from(key.serialize_der())?;
    let mut config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()?
        .with_no_client_auth()
        .with_single_cert(vec![certificate.der().clone()], key)?;
    config.alpn_protocols = vec![b"http/1.1".to_vec()];
    Ok(Certificate { acceptor: TlsAcceptor::from(Arc::new(config)), fingerprint })
}

/// SHA-256 in pairs of hexadecimal digits.
fn fingerprint(der: &[u8]) -> String {
    let mut text = String::new();
    for (i, byte) in digest(&SHA256, der).as_ref().iter().enumerate() {
        let _ = write!(text, "{}{byte:02X}", if i > 0 { ":" } else { "" });
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The digest of the empty text, from FIPS 180-4's examples.
    #[test]
    fn fingerprints_are_sha_256() {
        let text = fingerprint(b"");
        assert!(text.starts_with("E3:B0:C4:42:98:FC:1C:14"), "{text}");
        assert_eq!(text.len(), 32 * 3 - 1);
    }

    #[test]
    fn every_start_makes_another_certificate() {
        let make = || make(vec!["localhost".into(), "127.0.0.1".into()]).unwrap().fingerprint;
        assert_ne!(make(), make());
    }
}
