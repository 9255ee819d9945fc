//! Devices that name other devices: the wrist of a glove, the choices of `either:`, what `fault:`
//! spoils.
//!
//! Such a device opens those that it names while it is opened itself. Addresses and profiles can be
//! of any length and can lead back to where they began: how deep, and how many, is bounded here.

use crate::LinkError;
use std::cell::RefCell;
use thenar_input::quoted;

/// Most devices one inside another. Each kind that names others makes sense once: a fault before a
/// choice of gloves on wrists of their own is four. Twice that is more than anybody has.
pub const DEPTH_MAX: usize = 8;
/// Most devices for one address: a choice of choices, both full (`either:` takes 8), is 73.
pub const COUNT_MAX: usize = 80;

/// Devices that are being opened on this thread.
#[derive(Default)]
struct OpenChain {
    /// Addresses, from the outermost in.
    chain: Vec<String>,
    /// Devices since the outermost began, itself included.
    count: usize,
}

thread_local! {
    static OPENING: RefCell<OpenChain> = RefCell::default();
}

/// Stands for a device until it is open.
pub struct NestingGuard(());

/// Goes one device deeper.
///
/// # Errors
/// Too many devices are inside each other, or belong to one address.
pub fn enter(address: &str) -> Result<NestingGuard, LinkError> {
    OPENING.with_borrow_mut(|opening| {
        if opening.chain.is_empty() {
            opening.count = 0;
        }
        let cause = if opening.chain.len() >= DEPTH_MAX {
            format!("devices are nested too deep, more than {DEPTH_MAX} of them")
        } else if opening.count >= COUNT_MAX {
            format!("one address names more than {COUNT_MAX} devices")
        } else {
            opening.count += 1;
            opening.chain.push(address.into());
            return Ok(NestingGuard(()));
        };
        Err(LinkError::Setting { what: format!("device {}", quoted(address)), cause })
    })
}

/// True if a device of this address is being opened, so that to open it again would have no end.
pub fn is_opening(address: &str) -> bool {
    OPENING.with_borrow(|opening| opening.chain.iter().any(|known| known == address))
}

impl Drop for NestingGuard {
    fn drop(&mut self) {
        OPENING.with_borrow_mut(|opening| _ = opening.chain.pop());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(address: &str) -> String {
        crate::open(address).map(|_| ()).unwrap_err().to_string()
    }

    #[test]
    fn addresses_are_nested_up_to_a_bound() {
        let faults = |count: usize| format!("{}null:left", "fault:7:".repeat(count));
        assert!(crate::open(&faults(7)).is_ok());
        let too_deep = "devices are nested too deep, more than 8 of them";
        assert_eq!(told(&faults(8)), format!("device \"null:left\": {too_deep}"));
        for count in [9, 3000, 100_000] {
            let told = told(&faults(count));
            assert!(told.starts_with("device \"fault:7:") && told.ends_with(too_deep), "{told}");
            assert!(told.len() < 200, "{told}");
        }
        let wrists = format!("{}null:left", "lucidgloves:no-such-port?wrist=".repeat(1000));
        let told = told(&wrists);
        assert!(told.ends_with(too_deep) && told.len() < 200, "{told}");
        // What was refused leaves nothing behind.
        assert!(crate::open(&faults(7)).is_ok());
    }

    #[test]
    fn one_address_opens_so_many_devices() {
        let all: Vec<NestingGuard> = (0..4).map(|k| enter(&format!("d:{k}")).unwrap()).collect();
        let more = (0..100).take_while(|k| enter(&format!("e:{k}")).is_ok()).count();
        assert_eq!(more, 76);
        assert!(is_opening("d:3") && !is_opening("e:3"));
        drop(all);
        assert!(!is_opening("d:3") && enter("f:").is_ok());
    }
}
