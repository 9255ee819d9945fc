//! `thenar devices list`.

use crate::error::CliError;

/// Prints what is there and all drivers.
///
/// # Errors
/// None.
#[allow(clippy::unnecessary_wraps)] // like every command
pub fn run() -> Result<(), CliError> {
    let drivers = thenar_link::drivers();
    println!("Found:");
    let mut none = true;
    for driver in &drivers {
        for found in driver.enumerate() {
            none = false;
            println!("  {:32} {}", format!("{}:{}", driver.name(), found.address), found.what);
        }
    }
    if none {
        println!("  nothing; a device that is not found may still open by its address");
    }
    println!("Drivers:");
    for driver in &drivers {
        println!("  {:16} {}", driver.name(), driver.about());
    }
    Ok(())
}
