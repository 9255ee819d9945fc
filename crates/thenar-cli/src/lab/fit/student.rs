//! Student's distribution, for intervals from few data.

/// The value that a variable of Student's distribution with `freedoms` degrees of freedom stays
/// under, in size, with a probability of 95 %. Found by bisection of the regularised incomplete
/// beta function: `P(|t| > x) = I_{f/(f+x²)}(f/2, 1/2)`.
pub fn t95(freedoms: usize) -> f64 {
    let f = freedoms.max(1) as f64;
    let beyond = |x: f64| incomplete_beta(f / (f + x * x), 0.5 * f, 0.5);
    let (mut low, mut high) = (0.0, 20.0);
    // Halved until the ends are neighbours: 12.7 is the largest that there is.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if beyond(middle) > 0.05 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The regularised incomplete beta function `I_x(a, b)`, by its continued fraction on the side
/// where that converges fast, `x < (a + 1)/(a + b + 2)`, and by symmetry on the other.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front = ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (-x).ln_1p();
    front.exp() * fraction(x, a, b) / a
}

/// The continued fraction 1/(1 + d₁/(1 + d₂/(1 + …))) of the incomplete beta function, by Lentz's
/// method: `d_{2m} = m (b-m) x / ((a+2m-1)(a+2m))`,
/// `d_{2m+1} = -(a+m)(a+b+m) x / ((a+2m)(a+2m+1))`.
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let apart = |y: f64| if y.abs() < 1e-300 { 1e-300 } else { y };
    let (mut value, mut above, mut below) = (1.0, 1.0, 0.0);
    for k in 1..500 {
        let m = f64::from(k / 2);
        let d = match k % 2 {
            0 => m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m)),
            _ => -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0)),
        };
        below = 1.0 / apart(1.0 + d * below);
        above = apart(1.0 + d / above);
        value *= above * below;
        if (above * below - 1.0).abs() < 1e-15 {
            break;
        }
    }
    1.0 / value
}

/// `ln Γ(x)` for `x > 0`: Stirling's series at `x + 10`, led back by `Γ(x+1) = x Γ(x)`.
fn ln_gamma(x: f64) -> f64 {
    let y = x + 10.0;
    let back: f64 = (0..10).map(|k| (x + f64::from(k)).ln()).sum();
    let r = 1.0 / (y * y);
    let series = (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r / 1680.0))) / y;
    (y - 0.5) * y.ln() - y + 0.5 * (2.0 * std::f64::consts::PI).ln() + series - back
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Closed forms: one freedom tan(0.475 π); two freedoms `0.95 √(2/(1 - 0.95²))`; tables for the
    /// rest.
    #[test]
    fn the_quantiles_of_the_tables_come_out() {
        let one = (0.475 * PI).tan();
        let two = 0.95 * (2.0 / (1.0 - 0.95 * 0.95_f64)).sqrt();
        for (freedoms, want, off) in [
            (1, one, 1e-9),
            (2, two, 1e-9),
            (5, 2.570_582, 1e-6),
            (10, 2.228_139, 1e-6),
            (30, 2.042_272, 1e-6),
            (120, 1.979_930, 1e-6),
            (100_000, 1.959_988, 2e-6),
        ] {
            assert!((t95(freedoms) - want).abs() < off, "{freedoms}: {} not {want}", t95(freedoms));
        }
    }

    #[test]
    fn the_logarithm_of_gamma_is_that_of_factorials() {
        for (x, want) in
            [(0.5, 0.5 * PI.ln()), (1.0, 0.0), (5.0, 24f64.ln()), (11.0, 3_628_800f64.ln())]
        {
            assert!((ln_gamma(x) - want).abs() < 1e-12, "{x}");
        }
    }
}
