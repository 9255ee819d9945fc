//! `thenar soak --sweep`: the same thrashing over stiffnesses and time steps, as a table.

use super::{Args, soak};

/// Flesh on bone \[N/m⁴\].
const COUPLINGS: [f64; 4] = [1e7, 1e8, 1e9, 1e10];
/// Young's modulus of the hand's flesh \[Pa\].
const TISSUES: [f64; 4] = [5e3, 5e4, 5e5, 5e6];
/// Time steps \[s\].
const STEPS: [f64; 5] = [2.5e-4, 1e-3, 5e-3, 1.0 / 60.0, 0.02];

/// Runs all and prints a row of each; true when all are sound.
pub fn run(args: &Args) -> Result<bool, String> {
    let seed = args.seeds.first().copied().unwrap_or(1);
    println!("{} s each, seed {seed}", args.seconds);
    println!(
        "{:4} {:>8} {:>7} {:>7} {:>7} {:>6} {:>6} {:>9} {:>8} {:>8} {:>8} {:>8} {:>9}",
        "",
        "N/m^4",
        "Pa",
        "h ms",
        "steps",
        "taken",
        "fell",
        "energy J",
        "pen mm",
        "gap mm",
        "inverted",
        "contacts",
        "contact"
    );
    println!(
        "{:4} {:>8} {:>7} {:>7} {:>7} {:>6} {:>6} {:>9} {:>8} {:>8} {:>8} {:>8} {:>9}",
        "", "", "", "", "", "back", "back", "max", "max", "max", "max", "max", "m/s max"
    );
    let mut passed = true;
    for coupling in COUPLINGS {
        for tissue in TISSUES {
            for h in STEPS {
                let stiffness = [
                    format!("hand.hand.coupling_stiffness={coupling:e}"),
                    format!("hand.hand.material.young={tissue:e}"),
                ];
                let e = soak(args, h, seed, &stiffness)?;
                passed &= e.sound();
                println!(
                    "{:4} {coupling:>8.0e} {tissue:>7.0e} {:>7.2} {:>7} {:>6} {:>6} {:>9.3} {:>8.3} \
                     {:>8.4} {:>8} {:>8} {:>9.1e} {}",
                    e.word(),
                    h * 1e3,
                    e.steps,
                    e.non_finite,
                    e.fell_back,
                    e.energy,
                    e.penetration * 1e3,
                    e.joint_gap * 1e3,
                    e.inverted,
                    e.contacts,
                    e.contact_residual,
                    e.failure.map_or(String::new(), |f| f.to_string()),
                );
            }
        }
    }
    Ok(passed)
}
