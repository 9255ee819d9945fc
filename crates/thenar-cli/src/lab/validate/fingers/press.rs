//! Curves of an index pad, and what they say.

use super::curve::{force_and_area, line, open};
use super::{HandVariant, KNUCKLE, OWN, PRESS, SMALL, pressed};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use nalgebra::{DMatrix, DVector};

/// The hands and angles \[degrees\] that are pressed.
const PRESSES: [(HandVariant, u32); 4] = [(OWN, 30), (OWN, 45), (SMALL, 30), (SMALL, 45)];

/// Why areas are too small, as far as is known.
const SMALL_AREA: &str = "an element of 7 mm deforms the skin on it evenly and cannot flatten it: elastic flesh of 50 kPa touches with \
                          24 mm² at 1 N, in cubes of 2.7 mm with 55; with cubes half as large at the pads this hand has 33 to 50 mm² at 1 N and \
                          36 to 80 at 5 N, as bone is met at 3.0 to 3.6 mm, before a finger's area at 5 N";

fn recalled(figure: Figure) -> Figure {
    figure.rests_on(Basis::Recalled)
}

/// Serina, Mote and Rempel 1997.
pub fn depth(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (hand, angle) in PRESSES {
        let c = pressed(solver, hand, angle)?;
        let depth = 1e3 * c.depth[c.at(1.0)?];
        let ratio = c.stiffness(c.at(5.0)?) / c.stiffness(c.at(0.5)?);
        let what = "depth at 1 N [mm]";
        figures.push(recalled(Figure::within(what, &c.setup, [1.0, 2.5], depth)));
        let what = "stiffness at 5 N over that at 0.5 N";
        figures.push(recalled(Figure::new(what, &c.setup, 3.0, ratio, Check::AtLeast)));
        let skin = c.skin[c.at(5.0)?];
        let what = "part of 5 N that flesh bears, not bone";
        figures.push(Figure::new(what, &c.setup, f64::NAN, skin, Check::Report));
    }
    Ok(figures)
}

/// A stair of depths, each held for ten seconds.
pub fn held(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    const HOLD: f64 = 10.0;
    let stairs: Vec<f64> = (2..=11).map(|k| 0.4e-3 * f64::from(k)).collect();
    let mut course = vec![[0.0, -0.25e-3]];
    let (mut t, mut reached) = (0.0, -0.25e-3);
    let mut reads = Vec::new();
    for d in &stairs {
        t += (d - reached) / 5e-3;
        course.push([t, *d]);
        t += HOLD;
        course.push([t, *d]);
        reads.push(t);
        reached = *d;
    }
    let (mut run, plate) = open(solver, OWN, 30.0, &course, &["time_step=0.02".into()])?;
    let (mut depths, mut forces) = (Vec::new(), Vec::new());
    for (d, t) in stairs.iter().zip(reads) {
        let (force, _) = force_and_area(run.to(t)?, &plate)?;
        depths.push(*d);
        forces.push(force);
        if force > 5.5 {
            break;
        }
    }
    let setup = format!("{}, 30°, h = 20 ms", OWN.name);
    // Between stairs as a power of the depth.
    let at = |wanted: f64| {
        let k = forces.windows(2).position(|w| w[0] < wanted && w[1] >= wanted && w[0] > 0.0)?;
        let part = (wanted / forces[k]).ln() / (forces[k + 1] / forces[k]).ln();
        Some(depths[k] * (depths[k + 1] / depths[k]).powf(part))
    };
    let none =
        |f: f64| CaseError::Missing(format!("{f} N is not among the stairs' forces {forces:?}"));
    let depth = at(1.0).ok_or_else(|| none(1.0))?;
    let mut figures = vec![recalled(
        Figure::within("depth at 1 N after 10 s of hold [mm]", &setup, [1.0, 2.5], 1e3 * depth)
            .or_cannot("what is left of the stress after ten seconds, 7 %, bears 1 N deeper than people's moving pads do: the band is for a moving plate"),
    )];
    if let (Some(low), Some(high)) = (at(0.5), at(5.0)) {
        let slope = |f: f64, d: f64| at(1.1 * f).map(|e| 0.1 * f / (e - d));
        if let (Some(a), Some(b)) = (slope(0.5, low), slope(4.5, at(4.5).unwrap_or(high))) {
            let what = "stiffness at 4.5 N over that at 0.5 N, after hold";
            figures.push(recalled(Figure::new(what, &setup, 3.0, b / a, Check::AtLeast)));
        }
    }
    Ok(figures)
}

/// Pawluk and Howe 1999: a press at once is exponential in depth; a held one relaxes by three
/// exponentials and a constant.
pub fn relaxation(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    const H: f64 = 1e-3;
    // 2 mm at 100 mm/s, then still.
    let depth = 2e-3;
    let ramp = (depth + 0.25e-3) / 0.1;
    let course = [[0.0, -0.25e-3], [ramp, depth], [ramp + 4.0, depth]];
    let step = [format!("time_step={H}")];
    let (mut run, plate) = open(solver, OWN, 30.0, &course, &step)?;
    let (mut d, mut f, mut t, mut held) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    while run.time() < ramp + 3.9 {
        run.step()?;
        let force = force_and_area(&mut run, &plate)?.0;
        if run.time() <= ramp {
            d.push(0.1 * run.time() - 0.25e-3);
            f.push(force);
        } else {
            t.push(run.time() - ramp);
            held.push(force);
        }
    }
    let setup = format!("{}, 30°, 100 mm/s, h = 1 ms", OWN.name);
    let peak = f.last().copied().unwrap_or(f64::NAN);
    let off = exponential(&d, &f) / peak;
    let basis = DMatrix::from_fn(t.len(), 4, |i, k| match k {
        0 => 1.0,
        k => (-t[i] / [4e-3, 0.07, 1.4][k - 1]).exp(),
    });
    let data = DVector::from_column_slice(&held);
    let parts = basis
        .clone()
        .svd(true, true)
        .solve(&data, 1e-12)
        .map_err(|e| CaseError::Missing(e.into()))?;
    let left = (&basis * &parts - &data).norm() / (t.len() as f64).sqrt() / peak;
    let end = held.last().copied().unwrap_or(f64::NAN) / peak;
    let least = parts.iter().skip(1).copied().fold(f64::INFINITY, f64::min);
    Ok(vec![
        recalled(
            Figure::new("force off A (exp(b d) - 1) / peak, rms", &setup, 0.05, off, Check::AtMost)
                .or_cannot("the law is linear: what stiffens is the patch, and bone"),
        ),
        Figure::new("hold off three exponentials / peak, rms", &setup, 0.02, left, Check::AtMost)
            .rests_on(Basis::People),
        Figure::new("least of the three parts [N]", &setup, 0.0, least, Check::AtLeast)
            .rests_on(Basis::People),
        Figure::new("force after 3.9 s over peak", &setup, f64::NAN, end, Check::Report),
    ])
}

/// Root mean square by which a force misses `A (exp(b d) - 1)`; b is sought by golden section.
fn exponential(d: &[f64], f: &[f64]) -> f64 {
    let miss = |b: f64| {
        let shape: Vec<f64> = d.iter().map(|d| (b * d.max(0.0)).exp_m1()).collect();
        let A = shape.iter().zip(f).map(|(s, f)| s * f).sum::<f64>()
            / shape.iter().map(|s| s * s).sum::<f64>();
        let squares = shape.iter().zip(f).map(|(s, f)| (A * s - f).powi(2)).sum::<f64>();
        (squares / f.len() as f64).sqrt()
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (1.0, 5e3);
    for _ in 0..60 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if miss(a) < miss(b) { high = b } else { low = a }
    }
    miss(0.5 * (low + high))
}

/// Westling and Johansson 1987; Xydas and Kao 1999.
pub fn area(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (hand, angle) in PRESSES {
        let c = pressed(solver, hand, angle)?;
        // Lengths scale with the hand: areas are told for one of 190 mm.
        let scale = if hand == SMALL { (0.19_f64 / 0.17).powi(2) } else { 1.0 };
        let area = |force: f64| Ok::<f64, CaseError>(1e6 * c.area[c.at(force)?] * scale);
        for (force, band) in [(1.0, [50.0, 130.0]), (5.0, [120.0, 260.0])] {
            let what = format!("area at {force} N, for 190 mm [mm²]");
            figures.push(recalled(
                Figure::within(what, &c.setup, band, area(force)?).or_cannot(SMALL_AREA),
            ));
        }
        let exponent = (area(5.0)? / area(0.5)?).log10();
        figures.push(recalled(Figure::within(
            "exponent of area over 0.5 to 5 N",
            &c.setup,
            [0.35, 0.55],
            exponent,
        )));
    }
    Ok(figures)
}

/// Maeno 1998, Bensmaïa's laboratory, Geerligs 2011: what the scene's hand is made of.
pub fn moduli(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    let mut told = Vec::new();
    for scene in [&PRESS, &KNUCKLE] {
        let run = solver.open(scene, &[])?;
        let flesh = &run.world().desc().softs[0].flesh;
        let young = flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
        let terms = flesh.relaxation.first().map_or(Vec::new(), |r| r.terms().to_vec());
        told.push((young, terms));
    }
    let (young, terms) = &told[0];
    let after = |t: f64| {
        1e-3 * young
            * (1.0 - terms.iter().map(|g| g.weight * (1.0 - (-t / g.time).exp())).sum::<f64>())
    };
    let what = "scenes of hands with other constants than the first";
    let others = told.iter().filter(|other| **other != told[0]).count();
    figures.push(
        Figure::new(what, "", 0.0, others as f64, Check::AtMost).rests_on(Basis::Construction),
    );
    let pulp = "modulus of the pulp, 20 ms after a strain [kPa]";
    figures.push(recalled(Figure::within(pulp, "flesh", [30.0, 100.0], after(0.02)).or_cannot(
        "memory spreads the modulus over a factor of ten in time; no one number is it",
    )));
    figures.push(Figure::new(
        "modulus at once [kPa]",
        "flesh",
        f64::NAN,
        after(0.0),
        Check::Report,
    ));
    figures.push(Figure::new(
        "modulus after 10 s [kPa]",
        "flesh",
        f64::NAN,
        after(10.0),
        Check::Report,
    ));
    Ok(figures)
}

/// d ∝ F^(2/3) at the touch of a fabric, F rising faster from 1 to 5 N.
pub fn first_touch(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (hand, angle) in PRESSES {
        let c = pressed(solver, hand, angle)?;
        let (from, to) = (c.at(0.1)?, c.at(0.5)?);
        let log = |v: &[f64]| v[from..=to].iter().map(|x| x.ln()).collect::<Vec<_>>();
        let exponent = line(&log(&c.depth), &log(&c.force)).1;
        let what = "exponent of force on depth, 0.1 to 0.5 N";
        figures.push(
            Figure::within(what, &c.setup, [1.25, 1.75], exponent)
                .rests_on(Basis::People)
                .or_cannot(
                    "a skin of facets meets a plate with a vertex first, not with a sphere's cap",
                ),
        );
        let (at_one, at_five) = (c.at(1.0)?, c.at(5.0)?);
        let hertz = (c.depth[at_five] / c.depth[at_one]).powf(1.5);
        let rise = c.force[at_five] / c.force[at_one] / hertz;
        figures.push(recalled(Figure::new(
            "rise from 1 to 5 N over d^1.5",
            &c.setup,
            1.0,
            rise,
            Check::AtLeast,
        )));
    }
    Ok(figures)
}

/// T7: one set of constants for all of the press.
pub fn plate(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for (hand, angle) in PRESSES {
        let c = pressed(solver, hand, angle)?;
        let (from, to) = (c.at(0.5)?, c.at(5.0)?);
        let secant: Vec<f64> = (from..=to).map(|i| c.force[i] / c.depth[i]).collect();
        let r2 = line(&c.force[from..=to], &secant).2;
        let what = "secant modulus linear in force, r², 0.5 to 5 N";
        figures.push(Figure::new(what, &c.setup, 0.95, r2, Check::AtLeast).rests_on(Basis::People));
        let loss = 1.0 - c.volume[c.at(1.0)?];
        let what = "loss of the pad's volume at 1 N";
        figures.push(Figure::new(what, &c.setup, 0.05, loss, Check::AtMost).rests_on(Basis::People).or_cannot(
            "flesh of Poisson's ratio 0.4 gives way in volume where people's moves water aside",
        ));
        let exponent = (c.area[to] / c.area[from]).log10();
        figures.push(recalled(Figure::new(
            "exponent of area, under Hertz's",
            &c.setup,
            2.0 / 3.0,
            exponent,
            Check::AtMost,
        )));
    }
    Ok(figures)
}

/// 50 N on a fingertip: what is crushed is not turned inside out.
pub fn crushed(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in [OWN, SMALL] {
        let (deepest, rate) = (8e-3, 5e-3);
        let end = (deepest + 0.25e-3) / rate;
        let (mut run, plate) = open(solver, hand, 30.0, &[[0.0, -0.25e-3], [end, deepest]], &[])?;
        let (mut force, mut inverted, mut broken) = (0.0_f64, 0.0_f64, 0.0);
        while run.time() < end && force < 50.0 {
            run.step()?;
            force = force_and_area(&mut run, &plate)?.0;
            let [now, bad] = run.values(["step.inverted_tets", "step.non_finite"])?;
            inverted = inverted.max(now);
            broken += bad;
        }
        let setup = format!("{}, 30°, h = 5 ms", hand.name);
        figures.push(Figure::new("force reached [N]", &setup, 50.0, force, Check::AtLeast));
        figures.push(Figure::new(
            "most tetrahedra inside out",
            &setup,
            0.0,
            inverted,
            Check::AtMost,
        ));
        figures.push(Figure::new("steps that were not finite", &setup, 0.0, broken, Check::AtMost));
    }
    Ok(figures)
}
