//! A QR code made of characters.

use qrcode::render::unicode::Dense1x2;
use qrcode::{EcLevel, QrCode};

/// The code of a text, light on dark as terminals are, two rows of it per line; nothing where the
/// text is too long.
pub fn code(text: &str) -> Option<String> {
    let code = QrCode::with_error_correction_level(text, EcLevel::L).ok()?;
    let mut picture = code.render::<Dense1x2>();
    picture.dark_color(Dense1x2::Light).light_color(Dense1x2::Dark).quiet_zone(true);
    Some(picture.build())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 70 characters fit into version 4 at the lowest correction: 33 modules and two quiet zones
    /// of 4, two rows to the line.
    #[test]
    fn an_address_with_a_token_fits_a_terminal() {
        let text = format!("https://192.168.100.100:8014/?token={}", "a".repeat(32));
        let picture = code(&text).unwrap();
        assert!(picture.lines().all(|line| line.chars().count() == 41), "{picture}");
        assert_eq!(picture.lines().count(), 21);
    }
}
