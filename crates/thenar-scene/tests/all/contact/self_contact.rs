//! Goal: a hand touches itself. Method: the shipped pinch and fist are run; whether flesh is inside
//! other flesh is asked of winding numbers, which know nothing of contact.

use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_core::world::ContactPoint;
use thenar_scene::session::Session;

fn load(name: &str, changes: &[&str]) -> Session {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let changes: Vec<String> = changes.iter().map(|s| s.to_string()).collect();
    Session::load(&scenes.join(name).with_extension("toml"), &changes).unwrap()
}

/// How far a pad reaches from its middle \[m\].
const PAD: f64 = 0.008;

/// How often the hand's surface winds around `p` (van Oosterom & Strackee 1983).
fn winding(session: &Session, p: &Vec3) -> f64 {
    let x = session.world().collision_vertices(0);
    let angle = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| x[v as usize] - p);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let low = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * a.dot(&b.cross(&c)).atan2(low)
    };
    let triangles = &session.world().desc().softs[0].flesh.collision.triangles;
    triangles.iter().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
}

/// How many points on the skin of these digits within `reach` of one of the `places` \[m\] are
/// deeper than `depth` \[m\] in other flesh than their own: so far below the skin the surface winds
/// around them once more. Farther off are the creases of bent joints, where skin of one digit meets
/// itself.
fn buried(session: &Session, digits: &[Digit], places: &[Vec3], reach: f64, depth: f64) -> usize {
    let x = session.world().collision_vertices(0);
    let of = &session.hands()[0].model.collision_digits;
    let mut count = 0;
    for t in &session.world().desc().softs[0].flesh.collision.triangles {
        if !t.iter().all(|&v| digits.contains(&of[v as usize])) {
            continue;
        }
        let [a, b, c] = t.map(|v| x[v as usize]);
        let centre = (a + b + c) / 3.0;
        if !places.iter().any(|place| (place - centre).norm() < reach) {
            continue;
        }
        let normal = (b - a).cross(&(c - a)).normalize();
        for w in [[1.0, 1.0, 1.0], [4.0, 1.0, 1.0], [1.0, 4.0, 1.0], [1.0, 1.0, 4.0]] {
            let p = (a * w[0] + b * w[1] + c * w[2]) / (w[0] + w[1] + w[2]);
            count += usize::from(winding(session, &(p - normal * depth)) > 1.5);
        }
    }
    count
}

fn run(session: &mut Session, until: f64) {
    while session.world().time() < until - 1e-9 {
        let report = session.step(&mut ());
        assert!(!report.non_finite && !report.fell_back && report.contacts_dropped == 0);
        assert!(report.penetration_max < 1e-4, "{report:?}");
    }
}

/// Force on a digit \[N\].
fn force(session: &Session, digit: Digit) -> Vec3 {
    let of = &session.hands()[0].model.collision_digits;
    let on = |vertex: Option<u32>| vertex.is_some_and(|v| of[v as usize] == digit);
    let sign = |on: bool| if on { 1.0 } else { 0.0 };
    let contacts = session.world().contacts().iter();
    contacts.map(|c| c.force_W * (sign(on(c.vertices[0])) - sign(on(c.vertices[1])))).sum()
}

/// The weight and the drives of a hand at rest: what else acts on it from outside.
fn outside(session: &Session) -> Vec3 {
    let world = session.world();
    let input = session.input();
    let drives = (0..world.desc().rigids.len() as u32).map(|b| world.drive_wrench(b, input)[0]);
    let flesh: f64 = world.node_masses(0).iter().sum();
    let bones: f64 = world.desc().rigids.iter().map(|rigid| rigid.mass).sum();
    drives.sum::<Vec3>() + world.desc().gravity * (flesh + bones)
}

/// The pads press on each other with opposite forces, none is 0.3 mm deep in the other, and the
/// hand as a whole feels nothing: its drives carry its weight.
#[test]
fn thumb_and_index_pinch() {
    let pair = [Digit::Thumb, Digit::Index];
    let mut session = load("pinch", &[]);
    run(&mut session, 2.0);
    let [thumb, index] = pair.map(|digit| force(&session, digit));
    // Asked for 1.5 N of normal force; with what shear the pads have.
    assert!((1.35..2.2).contains(&thumb.norm()), "pinched with {thumb}");
    assert!((thumb + index).norm() < 1e-9, "{thumb} and {index} are opposite");
    // Where the pads press, and as far around as a pad reaches from there.
    let digits = &session.hands()[0].model.collision_digits;
    let digit = |vertex: Option<u32>| vertex.map(|v| digits[v as usize]);
    let between = |c: &&ContactPoint| digit(c.vertices[0]) != digit(c.vertices[1]);
    let pressing = session.world().contacts().iter().filter(|c| c.force_W.norm() > 0.0);
    let pressing = pressing.filter(between);
    let places: Vec<Vec3> = pressing.map(|c| c.position_W).collect();
    assert_eq!(buried(&session, &pair, &places, PAD, 3e-4), 0);
    let rest = outside(&session);
    assert!(rest.norm() < 0.02, "{rest} from outside, though it rests");

    // With contact switched off, or that of the pair, they pass through each other.
    let mut ghost = load("pinch", &["hand.0.self_contact=false"]);
    run(&mut ghost, 2.0);
    assert_eq!(force(&ghost, Digit::Thumb), Vec3::zeros());
    assert!(buried(&ghost, &pair, &places, PAD, 3e-4) > 2);
}

/// A fist is held for five seconds: it comes to rest and gains no energy. Crowded skin of the finer
/// hand still trembles with a millionth of what the fist stores.
#[test]
fn a_fist_rests() {
    rests("paper", 1e-9);
    rests("touch", 1e-5);
}

/// Holds a fist, and checks that it moves with less than this \[J\] at the end.
fn rests(preset: &str, kinetic_max: f64) {
    let preset = format!("hand.hand.preset={preset}");
    let mut session = load("fist", &["time_step=0.01", &preset]);
    run(&mut session, 1.2);
    let energy = |session: &Session| session.world().energy(&session.world().input());
    let start = energy(&session).elastic;
    let mut most = 0.0_f64;
    for k in 1..=19 {
        run(&mut session, 1.2 + 0.2 * f64::from(k));
        most = most.max(energy(&session).elastic);
    }
    assert!(most < 1.01 * start, "the fist tightens by itself: {start} to {most} J");
    let kinetic = energy(&session).kinetic;
    assert!(kinetic < kinetic_max, "{preset}: {kinetic} J");
    let pressed: f64 = session.hand_loads(0).iter().map(|load| load.normal).sum();
    assert!(pressed > 5.0, "pressed with {pressed} N");
    let longest = [Digit::Index, Digit::Middle, Digit::Ring, Digit::Little];
    // Creases at the joints overlap by themselves: the skin of one digit in another's is meant.
    let free = load("fist", &["time_step=0.01", &preset, "hand.0.self_contact=false"]);
    let mut free = free;
    run(&mut free, 1.5);
    let everywhere = [session.world().rigid_pose(0).position];
    let [held, through] = [&session, &free].map(|s| buried(s, &longest, &everywhere, 1.0, 3e-4));
    assert!(held < through, "{held} of {through}");
}

/// Each finger presses on the palm, and the thumb on index and middle finger: a fist of any side
/// and size, with forces of a hand at ease.
#[test]
fn a_fist_closes_on_the_palm_and_the_thumb_over_it() {
    for changes in [["model=right", "length=0.19"], ["model=left", "length=0.17"]] {
        let changes = changes.map(|change| format!("hand.hand.{change}"));
        let mut session = load("fist", &["time_step=0.01", &changes[0], &changes[1]]);
        run(&mut session, 2.2);
        let of = &session.hands()[0].model.collision_digits;
        let pressed = |one: Digit, others: &[Digit]| {
            let digit = |vertex: Option<u32>| vertex.map(|v| of[v as usize]);
            let contacts = session.world().contacts().iter().filter(|c| {
                let [a, b] = c.vertices.map(digit);
                let meets = |a: Option<Digit>, b: Option<Digit>| {
                    a == Some(one) && b.is_some_and(|b| others.contains(&b))
                };
                meets(a, b) || meets(b, a)
            });
            contacts.map(|c| c.force_W.dot(&c.normal_W).abs()).sum::<f64>()
        };
        for finger in &Digit::FINGERS[1..] {
            let force = pressed(*finger, &[Digit::Palm]);
            assert!((0.3..4.0).contains(&force), "{changes:?}: {finger:?} with {force} N");
        }
        let force = pressed(Digit::Thumb, &[Digit::Index, Digit::Middle]);
        assert!((1.0..8.0).contains(&force), "{changes:?}: the thumb with {force} N");
    }
}
