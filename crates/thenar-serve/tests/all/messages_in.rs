//! Goal: whatever a client sends is either one of the protocol's messages with values within the
//! protocol's bounds, or refused. Method: messages written from `docs/protocol.md`, whole and then
//! cut, stretched, spliced and with bits flipped at random (the seed is printed).

use thenar_core::model::Side;
use thenar_scene::grip::GripKind;
use thenar_scene::hands::Hands;
use thenar_scene::session::Random;
use thenar_scene::tuning::SettingValue;
use thenar_serve::protocol::{Command, Lengths, PoseBody, PoseError, PoseMessage};

fn header(kind: u8, hand: u8, number: u32, clock: f64) -> Vec<u8> {
    let mut bytes = vec![kind, 3, hand, 0];
    bytes.extend(number.to_le_bytes());
    bytes.extend(clock.to_le_bytes());
    bytes
}

fn floats(bytes: &mut Vec<u8>, numbers: &[f32]) {
    numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
}

/// Joint k at (k/100, 1, -k/200), turned about y by k/10, k+1 mm thick.
fn joints() -> Vec<u8> {
    let mut bytes = header(16, 1, 5, 2.5);
    for k in 0..25 {
        let (x, half) = (k as f32 / 100.0, k as f32 / 20.0);
        floats(&mut bytes, &[x, 1.0, -x / 2.0, 0.0, half.sin(), 0.0, half.cos()]);
        floats(&mut bytes, &[(k + 1) as f32 * 1e-3]);
    }
    bytes
}

fn angles() -> Vec<u8> {
    let mut bytes = header(17, 0, 6, -1.0);
    floats(&mut bytes, &[0.1, 0.2, 0.3, 0.6, 0.0, 0.8, 0.0]);
    let angles: Vec<f32> = (0..20).map(|k| k as f32 / 20.0).collect();
    floats(&mut bytes, &angles);
    bytes
}

fn lost() -> Vec<u8> {
    header(18, 1, 7, 0.0)
}

#[test]
fn joints_are_read_as_written() {
    let bytes = joints();
    assert_eq!(bytes.len(), 816);
    let message = PoseMessage::read(&bytes).unwrap();
    assert_eq!((message.side, message.number, message.clock), (Side::Right, 5, 2.5));
    let PoseBody::Joints { poses, radii } = message.body else { panic!("joints") };
    for k in 0..25 {
        let (x, turn) = (k as f64 / 100.0, k as f64 / 10.0);
        assert!((poses[k].position - thenar_core::Vec3::new(x, 1.0, -x / 2.0)).norm() < 1e-6);
        let own = thenar_core::Quat::from_axis_angle(&thenar_core::Vec3::y_axis(), turn);
        assert!(poses[k].rotation.angle_to(&own) < 1e-6);
        assert!((radii[k] - (k + 1) as f64 * 1e-3).abs() < 1e-8);
    }
}

#[test]
fn angles_and_lost_are_read_as_written() {
    let bytes = angles();
    assert_eq!(bytes.len(), 124);
    let message = PoseMessage::read(&bytes).unwrap();
    assert_eq!((message.side, message.number), (Side::Left, 6));
    let PoseBody::Angles { wrist, angles } = message.body else { panic!("angles") };
    assert!((wrist.position - thenar_core::Vec3::new(0.1, 0.2, 0.3)).norm() < 1e-7);
    let q = wrist.rotation.coords;
    assert!((q.x - 0.6).abs() < 1e-7 && (q.z - 0.8).abs() < 1e-7 && q.w.abs() < 1e-7);
    (0..20).for_each(|k| assert!((angles[k] - k as f64 / 20.0).abs() < 1e-7));
    assert_eq!(lost().len(), 16);
    assert_eq!(PoseMessage::read(&lost()).unwrap().body, PoseBody::Lost);
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let changed = |bytes: &[u8], at: usize, with: &[u8]| {
        let mut bytes = bytes.to_vec();
        bytes[at..at + with.len()].copy_from_slice(with);
        PoseMessage::read(&bytes).unwrap_err()
    };
    let (joints, angles) = (joints(), angles());
    let f = f32::to_le_bytes;
    assert_eq!(changed(&joints, 0, &[19]), PoseError::Kind(19));
    assert_eq!(changed(&joints, 1, &[1]), PoseError::Version(1));
    let older = PoseError::Version(1).to_string();
    assert!(older.contains("version 1") && older.contains("reload"), "{older}");
    assert_eq!(changed(&joints, 2, &[2]), PoseError::Hand(2));
    assert_eq!(changed(&joints, 3, &[1]), PoseError::Padding(1));
    assert_eq!(changed(&joints, 4, &[0; 4]), PoseError::Number);
    assert_eq!(changed(&joints, 8, &f64::NAN.to_le_bytes()), PoseError::NotFinite("the clock"));
    assert_eq!(changed(&joints, 16, &f(f32::INFINITY)), PoseError::NotFinite("a position"));
    assert!(matches!(changed(&joints, 20, &f(10.5)), PoseError::Range { what: "a position", .. }));
    // Each number within 10 m, the point beyond.
    let far: Vec<u8> = [f(8.0), f(8.0), f(0.0)].concat();
    assert!(matches!(changed(&joints, 16, &far), PoseError::Range { what: "a position", .. }));
    assert_eq!(changed(&joints, 40, &f(0.5)), PoseError::Quaternion(0.5));
    assert!(matches!(changed(&joints, 44, &f(-0.01)), PoseError::Range { what: "a radius", .. }));
    assert!(matches!(changed(&angles, 44, &f(7.0)), PoseError::Range { what: "an angle", .. }));
    assert_eq!(
        PoseMessage::read(&joints[..815]),
        Err(PoseError::Length { got: 815, expected: 816 })
    );
    assert_eq!(PoseMessage::read(&[]), Err(PoseError::Length { got: 0, expected: 16 }));
}

fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(3) {
        let n = bytes.len().max(1);
        match random.below(7) {
            0 => bytes.truncate(random.below(n)),
            1 => bytes.extend((0..random.below(2000)).map(|_| random.below(256) as u8)),
            2 => {
                let by = random.below(n).min(bytes.len());
                bytes.rotate_left(by);
            }
            3 if !bytes.is_empty() => bytes[random.below(n)] = random.below(256) as u8,
            4 if bytes.len() > 20 => {
                let hostile = [f32::NAN, f32::INFINITY, -1e38, 1e-45, 10.0, -0.0];
                let at = 16 + random.below((n - 16) / 4) * 4;
                if at + 4 <= bytes.len() {
                    bytes[at..at + 4].copy_from_slice(&hostile[random.below(6)].to_le_bytes());
                }
            }
            _ if !bytes.is_empty() => bytes[random.below(n)] ^= 1 << random.below(8),
            _ => {}
        }
    }
    bytes
}

#[test]
fn damaged_poses_are_refused_or_within_bounds() {
    let (mut taken, mut refused) = (0, 0);
    for seed in 0..60_000 {
        let mut random = Random::new(seed);
        let whole = [joints(), angles(), lost()][random.below(3)].clone();
        let bytes = damaged(&whole, &mut random);
        let Ok(message) = PoseMessage::read(&bytes) else {
            refused += 1;
            continue;
        };
        taken += 1;
        assert!(message.number > 0 && message.clock.is_finite(), "seed {seed}");
        let pose_fits = |pose: &thenar_core::Pose| {
            pose.position.norm() <= 10.0
                && pose.is_finite()
                && (pose.rotation.norm() - 1.0).abs() < 1e-12
        };
        match message.body {
            PoseBody::Joints { poses, radii } => {
                assert!(poses.iter().all(pose_fits), "seed {seed}");
                assert!(radii.iter().all(|r| (0.0..=0.5).contains(r)), "seed {seed}");
            }
            PoseBody::Angles { wrist, angles } => {
                assert!(pose_fits(&wrist), "seed {seed}");
                assert!(angles.iter().all(|a| a.abs() <= std::f64::consts::TAU), "seed {seed}");
            }
            PoseBody::Lost => {}
        }
    }
    assert!(
        taken > 1000 && refused > 10_000,
        "the damage is neither nothing nor all: {taken} {refused}"
    );
}

const COMMANDS: [&str; 16] = [
    r#"{"type":"control","take":true}"#,
    r#"{"type":"run","paused":true}"#,
    r#"{"type":"step"}"#,
    r#"{"type":"reset"}"#,
    r#"{"type":"speed","value":0.25}"#,
    r#"{"type":"scene","name":"car-grasp"}"#,
    r#"{"type":"hands","which":"both","lengths":{"left":0.19,"right":0.19}}"#,
    r#"{"type":"hands","which":"scene","lengths":{"left":null,"right":null}}"#,
    r#"{"type":"script"}"#,
    r#"{"type":"grip"}"#,
    r#"{"type":"grip","kind":"tripod","object":"car","force":2.5,"side":"left"}"#,
    r#"{"type":"release"}"#,
    r#"{"type":"release","side":"right"}"#,
    r#"{"type":"set","key":"friction","value":0.8}"#,
    r#"{"type":"set","key":"solver","value":"two-step"}"#,
    r#"{"type":"ping","t":1.25}"#,
];

#[test]
fn commands_are_read_as_written() {
    let own = 0.19;
    let wanted = [
        Command::Control { take: true },
        Command::Run { paused: true },
        Command::Step {},
        Command::Reset {},
        Command::Speed { value: 0.25 },
        Command::Scene { name: "car-grasp".into() },
        Command::Hands {
            which: Hands::Both,
            lengths: Lengths { left: Some(own), right: Some(own) },
        },
        Command::Hands { which: Hands::Scene, lengths: Lengths::default() },
        Command::Script {},
        Command::Grip { kind: GripKind::Pinch, object: None, force: None, side: None },
        Command::Grip {
            kind: GripKind::Tripod,
            object: Some("car".into()),
            force: Some(2.5),
            side: Some(Side::Left),
        },
        Command::Release { side: None },
        Command::Release { side: Some(Side::Right) },
        Command::Set { key: "friction".into(), value: SettingValue::Number(0.8) },
        Command::Set { key: "solver".into(), value: SettingValue::Choice("two-step".into()) },
        Command::Ping { t: 1.25 },
    ];
    for (text, wanted) in COMMANDS.iter().zip(wanted) {
        assert_eq!(Command::read(text), Ok(wanted), "{text}");
    }
}

#[test]
fn other_texts_are_refused_with_the_reason() {
    let long = format!(r#"{{"type":"scene","name":"{}"}}"#, "x".repeat(5000));
    let deep = format!(r#"{{"type":"set","value":{}"#, "[".repeat(2000));
    let cases = [
        ("", "EOF"),
        ("{}", "type"),
        ("[1,2]", "expected"),
        (r#"{"type":"explode"}"#, "explode"),
        (r#"{"type":"step","twice":true}"#, "twice"),
        (r#"{"type":"run"}"#, "paused"),
        (r#"{"type":"run","paused":1}"#, "boolean"),
        (r#"{"type":"run","paused":true,"paused":false}"#, "duplicate"),
        (r#"{"type":"speed","value":0}"#, "0.02 to 1"),
        (r#"{"type":"speed","value":1.5}"#, "0.02 to 1"),
        (r#"{"type":"speed","value":1e999}"#, "out of range"),
        (r#"{"type":"hands","which":"three"}"#, "three"),
        (r#"{"type":"hands","which":"left","lengths":{"left":9.0}}"#, "9 m long"),
        (r#"{"type":"grip","kind":"grab"}"#, "grab"),
        (r#"{"type":"grip","force":0}"#, "more than 0"),
        (r#"{"type":"grip","force":1e9}"#, "at most 1000 N"),
        (r#"{"type":"grip","side":"middle"}"#, "middle"),
        (r#"{"type":"set","key":"friction","value":[1]}"#, "Value"),
        (r#"{"type":"step"} {"type":"step"}"#, "trailing"),
        (long.as_str(), "4096"),
        (deep.as_str(), "recursion"),
    ];
    for (text, reason) in cases {
        let refused = Command::read(text).unwrap_err();
        let shown: String = text.chars().take(60).collect();
        assert!(refused.contains(reason), "{shown}: {refused}");
        assert!(refused.len() < 400, "{shown}: a reason, not an echo");
    }
}

#[test]
fn damaged_commands_are_refused_or_within_bounds() {
    let mut taken = 0;
    for seed in 0..60_000 {
        let mut random = Random::new(seed);
        let whole = COMMANDS[random.below(COMMANDS.len())];
        let bytes = damaged(whole.as_bytes(), &mut random);
        let text = String::from_utf8_lossy(&bytes);
        match Command::read(&text) {
            Ok(Command::Speed { value }) => assert!((0.02..=1.0).contains(&value), "seed {seed}"),
            Ok(Command::Hands { lengths, .. }) => {
                let all = lengths.left.iter().chain(&lengths.right);
                all.for_each(|l| assert!((0.08..=0.30).contains(l), "seed {seed}"));
            }
            Ok(Command::Ping { t }) => assert!(t.is_finite(), "seed {seed}"),
            Ok(Command::Set { value: SettingValue::Number(x), .. }) => {
                assert!(x.is_finite(), "seed {seed}")
            }
            Ok(_) => taken += 1,
            Err(reason) => assert!(!reason.is_empty(), "seed {seed}"),
        }
    }
    assert!(taken > 100, "some damage leaves a command: {taken}");
}
