use super::*;
use crate::random::Random;

/// Iterates one point to its fixed point and checks the law there.
#[test]
fn the_fixed_point_obeys_coulomb() {
    let mut random = Random::new(3);
    for _ in 0..200 {
        let a = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
        let W = a * a.transpose() + Mat3::identity() * 0.5;
        let free = random.vector(1.0);
        let mu = random.range(0.1, 1.2);
        let mut lambda = Vec3::zeros();
        for _ in 0..20_000 {
            lambda = project(Cone::Circular, mu, &W, &(free + W * lambda), &lambda);
        }
        let d = free + W * lambda;
        assert!(lambda.x >= 0.0 && d.x > -1e-9 && (lambda.x * d.x).abs() < 1e-9);
        let (t, slide) = (lambda.yz(), d.yz());
        if t.norm() < mu * lambda.x - 1e-9 {
            assert!(slide.norm() < 1e-8, "sticking yet sliding: {slide}");
        } else if lambda.x > 1e-9 {
            let along = t.dot(&slide) + t.norm() * slide.norm();
            assert!(along < 1e-7, "friction must oppose sliding: {along}");
        }
    }
}

/// Sliding in any direction, the pyramid of four sides gives between cos 45° and all of
/// Coulomb's friction.
#[test]
fn the_linearised_cone_lies_within_the_circular_one() {
    for k in 0..64 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
        let slide = Vec3::new(-1.0, -10.0 * cos, -10.0 * sin);
        let lambda = project(Cone::Linearised, 0.7, &Mat3::identity(), &slide, &Vec3::zeros());
        let ratio = lambda.yz().norm() / (0.7 * lambda.x);
        let least = std::f64::consts::FRAC_1_SQRT_2;
        assert!((least - 1e-12..=1.0 + 1e-12).contains(&ratio), "direction {k}: {ratio}");
    }
}

fn responses(random: &mut Random) -> (Mat3, Vec3, f64) {
    let a = Mat3::from_fn(|_, _| random.range(-1.0, 1.0));
    (a * a.transpose() + Mat3::identity() * 0.3, random.vector(1.0), random.range(0.05, 1.0))
}

#[test]
fn visits_end_at_coulombs_law() {
    let mut random = Random::new(17);
    let (mut stuck, mut slid) = (0, 0);
    for _ in 0..500 {
        let (W, b, mu) = responses(&mut random);
        let mut lambda = Vec3::zeros();
        let response = Response::new(&W);
        for _ in 0..200 {
            lambda = response.impulse(Cone::Circular, mu, &b, &lambda);
        }
        let d = b + W * lambda;
        assert!(lambda.x >= 0.0 && d.x > -1e-9 && (lambda.x * d.x).abs() < 1e-9);
        let (t, slide) = (lambda.yz(), d.yz());
        assert!(t.norm() <= mu * lambda.x + 1e-12);
        if lambda.x > 0.0 && t.norm() < mu * lambda.x - 1e-9 {
            assert!(slide.norm() < 1e-9, "sticks yet slides at {slide}");
            stuck += 1;
        } else if lambda.x > 0.0 {
            let along = t.dot(&slide) + t.norm() * slide.norm();
            assert!(along.abs() < 1e-9, "friction must oppose sliding: {along}");
            slid += 1;
        }
    }
    assert!(stuck > 10 && slid > 50, "{stuck} stuck, {slid} slid");
}

/// No other point of the disc has less energy.
#[test]
fn the_disc_minimum_is_least() {
    let mut random = Random::new(18);
    for _ in 0..200 {
        let (W, c, radius) = responses(&mut random);
        let energy = |t: [f64; 2]| {
            0.5 * (W.m22 * t[0] * t[0] + 2.0 * W.m23 * t[0] * t[1] + W.m33 * t[1] * t[1])
                + c.y * t[0]
                + c.z * t[1]
        };
        let found = Response::new(&W).in_disc([c.y, c.z], radius);
        assert!(found[0].hypot(found[1]) <= radius * (1.0 + 1e-9));
        for k in 0..360 {
            let (sin, cos) = f64::from(k).to_radians().sin_cos();
            for r in [0.3, 0.7, 1.0] {
                let other = [radius * r * cos, radius * r * sin];
                assert!(energy(found) <= energy(other) + 1e-12);
            }
        }
    }
}

/// A hinged body answers a pull along one direction only. Whatever little slides across it, from
/// nothing to round-off to much, friction stays in its disc, and no other point of the disc has
/// less energy, but for what round-off of the response makes.
#[test]
fn what_moves_along_one_line_keeps_friction_in_the_disc() {
    let mut random = Random::new(37);
    let (mut stick, mut slide) = (0, 0);
    for case in 0..20_000 {
        let (sin, cos) = random.range(0.0, std::f64::consts::PI).sin_cos();
        let other = if case % 2 == 0 { 0.0 } else { 10f64.powf(random.range(-20.0, -2.0)) };
        let mut W = Mat3::identity();
        W.m22 = cos * cos + other * sin * sin;
        W.m33 = sin * sin + other * cos * cos;
        W.m23 = (1.0 - other) * sin * cos;
        W.m32 = W.m23;
        let W = W.map(|w| f64::from(w as f32));
        let along = random.range(-2.0, 2.0);
        let across = if case % 5 == 0 { 0.0 } else { 10f64.powf(random.range(-20.0, 1.0)) };
        let c = [along * cos - across * sin, along * sin + across * cos];
        let pull =
            |t: [f64; 2]| [W.m22 * t[0] + W.m23 * t[1] + c[0], W.m32 * t[0] + W.m33 * t[1] + c[1]];
        let t = Response::new(&W).in_disc(c, 1.0);
        let length = t[0].hypot(t[1]);
        let told = format!("case {case}: ({along}, {across}), {other}: {t:?}");
        assert!(length <= 1.0 + 1e-12, "{told}");
        // The energy is convex: no point of the disc lies downhill.
        let g = pull(t);
        let downhill = g[0].hypot(g[1]) + g[0] * t[0] + g[1] * t[1];
        assert!(downhill <= 4.0 * PIVOT_LEAST, "{downhill} {told}");
        *(if length < 1.0 - 1e-9 { &mut stick } else { &mut slide }) += 1;
    }
    assert!(stick > 2000 && slide > 5000, "{stick} {slide}");
}

/// The response of a point of a free rigid body of 1 kg, far out: half the radii of gyration are
/// short.
fn lever(random: &mut Random) -> Mat3 {
    let turn = *random.rotation(3.1).to_rotation_matrix().matrix();
    let gyration = Vec3::new(random.range(0.05, 1.0), random.range(0.05, 1.0), 1.0);
    let inertia = gyration.map(|k| 1.0 / (k * k));
    let arm = random.vector(1.5).cross_matrix();
    Mat3::identity()
        + arm.transpose() * turn * Mat3::from_diagonal(&inertia) * turn.transpose() * arm
}

/// One visit gives what the law asks for on a body of any shape: the quartic in the direction of
/// sliding has a root that does (an impulse exists for every response that is positive definite).
#[test]
fn one_visit_obeys_the_law_on_any_lever() {
    let mut random = Random::new(23);
    let (mut stuck, mut slid) = (0, 0);
    for k in 0..20_000 {
        let (mut W, mu) = (lever(&mut random), random.range(0.05, 1.5));
        let (mut b, start) = (random.vector(1.0), random.vector(1.0));
        b.x = -b.x.abs();
        // Every third in a plane: friction points along the second tangent exactly.
        if k % 3 == 0 {
            for (i, j) in [(0, 1), (1, 0), (1, 2), (2, 1)] {
                W[(i, j)] = 0.0;
            }
            b.y = 0.0;
        }
        let lambda = Response::new(&W).impulse(Cone::Circular, mu, &b, &start);
        let d = b + W * lambda;
        let (t, slide) = (lambda.yz(), d.yz());
        let case = format!("W {W} b {b} μ {mu} λ {lambda} d {d} start {start}");
        assert!(lambda.x > 0.0 && d.x.abs() < 1e-9, "{case}");
        assert!(t.norm() <= mu * lambda.x * (1.0 + 1e-9), "{case}");
        if slide.norm() < 1e-9 {
            stuck += 1;
        } else {
            assert!((t.norm() - mu * lambda.x).abs() < 1e-9 * lambda.x, "{case}");
            let along = t.dot(&slide) + t.norm() * slide.norm();
            assert!(along < 1e-9 * t.norm(), "{along}: {case}");
            slid += 1;
        }
    }
    assert!(stuck > 1000 && slid > 5000, "{stuck} stuck, {slid} slid");
}

/// A hinged body answers in one direction or two; rounded to single precision its response has an
/// inverse, which says nothing. Its impulse stays what the old one and the frictionless one are:
/// nothing runs away.
#[test]
fn round_off_makes_no_response_definite() {
    let mut random = Random::new(29);
    let mut definite = 0;
    for _ in 0..5000 {
        let [a, c] = [random.vector(1.0), random.vector(1.0)];
        let rounded = |W: Mat3| W.map(|w| f64::from(w as f32));
        let one = rounded(a * a.transpose());
        let two = rounded(a * a.transpose() + c * c.transpose());
        assert!(!is_definite(&one) && !is_definite(&two), "{one} {two}");
        definite += u32::from(is_definite(&rounded(lever(&mut random))));
    }
    assert!(definite > 4900, "{definite} of 5000 levers");
    for wrong in [f64::NAN, 0.0, -1.0] {
        assert!(!is_definite(&(Mat3::identity() * wrong)));
    }
}

/// A visit leaves the impulse that is there, of several that obey the law, and so does what
/// follows: visits that always took the one that sticks went from it to sliding and back where
/// something else, a limit, gave way.
#[test]
fn what_obeys_the_law_is_left_as_it_is() {
    let mut random = Random::new(29);
    let mut slides_or_sticks = 0;
    for case in 0..20_000 {
        let (W, mu) = (lever(&mut random), random.range(0.05, 1.5));
        let response = Response::new(&W);
        let mut b = random.vector(1.0);
        b.x = -b.x.abs();
        let start = random.vector(1.0);
        let (Some(sticks), Some(slides)) =
            (response.sticking(mu, &b), response.sliding(mu, &b, &start))
        else {
            continue;
        };
        slides_or_sticks += 1;
        for there in [sticks, slides] {
            let next = response.impulse(Cone::Circular, mu, &b, &there);
            let off = (W * (next - there)).norm();
            assert!(off < 1e-7, "case {case}: {off} m/s, W {W}, b {b}, friction {mu}");
        }
    }
    assert!(slides_or_sticks > 5, "{slides_or_sticks}");
}

/// Below the threshold visits from anywhere find the same impulse, but for one response in
/// thousands.
#[test]
fn only_long_levers_have_several_impulses() {
    let mut random = Random::new(31);
    let (mut single, mut several, mut missed) = (0, 0, 0);
    for _ in 0..20_000 {
        let (W, mu) = (lever(&mut random), random.range(0.05, 1.5));
        let response = Response::new(&W);
        let mut b = random.vector(1.0);
        b.x = -b.x.abs();
        let mut from = || {
            let mut start = random.vector(10.0);
            start.x = start.x.abs();
            response.impulse(Cone::Circular, mu, &b, &start)
        };
        let found: Vec<Vec3> = (0..8).map(|_| from()).collect();
        let apart = found.iter().map(|l| (W * (l - found[0])).norm()).fold(0.0, f64::max);
        if response.is_ambiguous(mu) {
            several += usize::from(apart > 1e-3);
        } else {
            single += 1;
            missed += usize::from(apart > 1e-6);
        }
    }
    assert!(single > 1000 && several > 5, "{single} single, {several} several");
    assert!(5000 * missed <= single, "{missed} of {single} missed");
}

/// An impulse that obeys the law does not stray, and a velocity off by e makes it stray by no more
/// than the parts of e; where it strays little, a visit changes little.
#[test]
fn what_obeys_the_law_does_not_stray() {
    let mut random = Random::new(9);
    let (mut pressing, mut sliding) = (0, 0);
    for _ in 0..500 {
        let (W, b, friction) = responses(&mut random);
        let response = Response::new(&W);
        let mut rows = crate::solver::ContactRows::with_capacity(0, 1);
        rows.begin(&Vec3::x(), friction, &Vec3::zeros());
        let mut row = rows.rows.remove(0);
        for _ in 0..300 {
            row.lambda = response.impulse(Cone::Circular, friction, &b, &row.lambda);
        }
        let d = b + W * row.lambda;
        assert!(row.strays(&d) < 1e-8, "{row:?} strays at {d}");
        pressing += usize::from(row.lambda.x > 0.0);
        sliding += usize::from(row.lambda.x > 0.0 && d.yz().norm() > 1e-3);
        let e = random.vector(1e-3);
        let off = row.strays(&(d + e));
        assert!(off <= 2.0 * e.norm(), "{off} for {e}");
        let visited = row.resolved(Cone::Circular, &response, &(d + e));
        let change = (W * (visited - row.lambda)).norm();
        assert!(change <= 30.0 * off + 1e-9, "a visit changes {change}, the row strays by {off}");
    }
    assert!(pressing > 100 && sliding > 30, "{pressing} press, {sliding} slide");
}

/// A contact without friction bears no tangential impulse, a limit and a contact push only, and
/// what is not a number is not lawful.
#[test]
fn impulses_that_no_velocity_goes_with_stray() {
    let mut rows = crate::solver::ContactRows::with_capacity(0, 1);
    rows.begin(&Vec3::x(), 0.0, &Vec3::zeros());
    let mut row = rows.rows.remove(0);
    let still = Vec3::zeros();
    for (friction, lambda, lawful) in [
        (0.0, Vec3::new(1.0, 0.0, 0.0), true),
        (0.0, Vec3::new(1.0, 0.1, 0.0), false),
        (0.5, Vec3::new(1.0, 0.3, -0.4), true),
        (0.5, Vec3::new(1.0, 0.3, -0.41), false),
        (0.5, Vec3::new(-1.0, 0.0, 0.0), false),
    ] {
        (row.friction, row.lambda) = (friction, lambda);
        assert_eq!(row.strays(&still) == 0.0, lawful, "{friction} {lambda}");
    }
    row.lambda = Vec3::zeros();
    assert!(row.strays(&Vec3::repeat(f64::NAN)).is_nan());
    assert_eq!(row.strays(&Vec3::new(-0.2, 5.0, 0.0)), 0.2);
}
