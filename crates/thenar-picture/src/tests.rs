//! Tests of what a picture must show, from geometry alone.

mod png_reader;

use super::scene3d::{Light, Mesh, Scene3d};
use super::shapes::{Solid, cuboid, sphere};
use super::*;
use std::f64::consts::{FRAC_PI_4, PI};
use thenar_core::Vec3;

fn camera(position: Vec3) -> Camera {
    Camera { position, target: Vec3::zeros(), up: Vec3::y(), fov_y: FRAC_PI_4 }
}

fn plain() -> Quality {
    Quality { samples: 8, shadow_map: 512, ambient_directions: 0, threads: 1 }
}

fn unlit_black(solid: Solid) -> Mesh<'static> {
    solid.mesh(Material::unlit([0.0; 3]))
}

fn white() -> Backdrop {
    Backdrop { horizon: [1e6; 3], zenith: [1e6; 3] }
}

/// Part of the picture that is dark.
fn darkness(image: &Image) -> f64 {
    let sum: f64 = image.rgb.iter().map(|&b| 1.0 - from_byte(b)).sum();
    sum / image.rgb.len() as f64
}

/// Linear light of an sRGB byte.
fn from_byte(byte: u8) -> f64 {
    let c = f64::from(byte) / 255.0;
    if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn the_outline_of_a_ball_has_the_area_of_its_cone() {
    // A ball of radius r at distance d on the axis fills a disc of radius f r / sqrt(d² - r²).
    let (r, d, size) = (0.3, 2.0, 400);
    let eye = camera(Vec3::new(0.0, 0.0, d));
    let scene = Scene3d {
        meshes: vec![unlit_black(sphere(Vec3::zeros(), r, 192))],
        backdrop: white(),
        ..Scene3d::default()
    };
    let image = render(&scene, &eye, size, size, &plain());
    let radius = eye.focal(size) * r / (d * d - r * r).sqrt();
    let expected = PI * radius * radius / f64::from(size * size);
    let got = darkness(&image);
    assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
}

#[test]
fn the_nearer_mesh_hides_the_farther_whatever_the_order() {
    let red = || sphere(Vec3::new(0.0, 0.0, 0.5), 0.2, 24).mesh(Material::unlit([0.5, 0.0, 0.0]));
    let green = || sphere(Vec3::zeros(), 0.2, 24).mesh(Material::unlit([0.0, 0.5, 0.0]));
    for meshes in [vec![red(), green()], vec![green(), red()]] {
        let scene = Scene3d { meshes, ..Scene3d::default() };
        let image = render(&scene, &camera(Vec3::new(0.0, 0.0, 2.0)), 64, 64, &plain());
        let [r, g, _] = image.pixel(32, 32);
        assert!(r > 150 && g == 0, "{r} {g}");
    }
    // Drawn over everything, the farther one shows.
    let mut over = green();
    over.material = over.material.over_everything();
    let scene = Scene3d { meshes: vec![red(), over], ..Scene3d::default() };
    let image = render(&scene, &camera(Vec3::new(0.0, 0.0, 2.0)), 64, 64, &plain());
    assert_eq!(image.pixel(32, 32)[0], 0);
}

#[test]
fn a_translucent_mesh_mixes_with_what_lies_behind_in_the_given_part() {
    let wall = cuboid(&thenar_core::Pose::identity(), Vec3::new(0.5, 0.5, 0.01), 1)
        .mesh(Material::unlit([0.4, 0.0, 0.0]));
    let veil = cuboid(&thenar_core::Pose::translation(0.0, 0.0, 0.2), Vec3::new(0.5, 0.5, 0.01), 1)
        .mesh(Material { opacity: 0.25, ..Material::unlit([0.0, 0.4, 0.0]) });
    let scene = Scene3d { meshes: vec![veil, wall], ..Scene3d::default() };
    let image = render(&scene, &camera(Vec3::new(0.0, 0.0, 2.0)), 64, 64, &plain());
    let [r, g, _] = image.pixel(32, 32).map(from_byte);
    assert!((r - 0.3).abs() < 0.01 && (g - 0.1).abs() < 0.01, "{r} {g}");
}

/// A ball above the ground, lit from straight above, seen from the side.
fn ball_above_ground() -> (Scene3d<'static>, Camera) {
    let scene = Scene3d {
        meshes: vec![sphere(Vec3::new(0.0, 0.3, 0.0), 0.1, 64).mesh(Material::matte([0.5; 3]))],
        ground: Some(Ground::horizontal(0.0, Pattern::Plain([0.5; 3]))),
        light: Light { direction: Vec3::y(), radius: 0.05, ..Light::default() },
        ..Scene3d::default()
    };
    (scene, camera(Vec3::new(0.0, 1.0, 2.0)))
}

#[test]
fn a_ball_casts_its_shadow_straight_below_the_light() {
    let (scene, eye) = ball_above_ground();
    let image = render(&scene, &eye, 400, 400, &plain());
    let on_ground = |x: f64, z: f64| {
        let ([px, py], _) = eye.project(&Vec3::new(x, 0.0, z), 400, 400).expect("in front");
        from_byte(image.pixel(px as u32, py as u32)[1])
    };
    // Sky alone lights the middle, key and sky the rest: 0.44 / (0.44 + 0.81) of it, as far as
    // the tone curve leaves alone; the mean of opposite penumbra edges is half-way.
    let (inside, outside) = (on_ground(0.0, 0.0), on_ground(0.5, 0.0));
    assert!(inside < 0.6 * outside, "{inside} {outside}");
    assert!(on_ground(0.07, 0.0) < 0.6 * outside && on_ground(0.14, 0.0) > 0.97 * outside);
    assert!(on_ground(0.0, 0.07) < 0.6 * outside && on_ground(0.0, -0.14) > 0.97 * outside);
}

#[test]
fn the_ground_grows_dark_under_a_ball_that_lies_on_it() {
    // Under a ball of radius r that touches the plane, at distance x from the contact point, the
    // ball's centre is at the angle t from the normal, tan t = x / r, and its half-angle is a,
    // sin a = r / sqrt(x² + r²), so the ball reaches below the horizon for no x (t + a = 90°).
    // A sphere wholly above the horizon hides cos t sin² a of the cosine-weighted sky.
    let r = 0.1;
    let scene = Scene3d {
        meshes: vec![sphere(Vec3::new(0.0, r, 0.0), r, 128).mesh(Material::matte([0.5; 3]))],
        ground: Some(Ground::horizontal(0.0, Pattern::Plain([0.5; 3]))),
        light: Light { key: [0.0; 3], sky: [0.8; 3], ..Light::default() },
        ..Scene3d::default()
    };
    let eye = camera(Vec3::new(0.0, 0.6, 1.5));
    let quality = Quality { ambient_directions: 600, ..plain() };
    let image = render(&scene, &eye, 400, 400, &quality);
    for x in [0.1, 0.15, 0.2_f64] {
        let ([px, py], _) = eye.project(&Vec3::new(x, 0.0, 0.0), 400, 400).expect("in front");
        let got = from_byte(image.pixel(px as u32, py as u32)[1]);
        let distance = (x * x + r * r).sqrt();
        let hidden = r / distance * (r / distance).powi(2);
        // Half the light is reflected; light between ball and ground adds a little back.
        let open = 1.0 - hidden;
        let expected = 0.4 * open / (1.0 - 0.5 * hidden);
        assert!((got / expected - 1.0).abs() < 0.04, "x = {x}: {got} {expected}");
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let (scene, eye) = ball_above_ground();
    let quality = |threads| Quality { threads, ambient_directions: 9, ..plain() };
    let one = render(&scene, &eye, 123, 77, &quality(1));
    assert_eq!(one, render(&scene, &eye, 123, 77, &quality(1)));
    assert_eq!(one, render(&scene, &eye, 123, 77, &quality(3)));
}

#[test]
fn what_cannot_be_drawn_is_left_out() {
    let mut ball = sphere(Vec3::zeros(), 0.2, 12);
    ball.positions[0].x = f64::NAN;
    ball.triangles.push([0, 1, 60_000]);
    ball.triangles.push([1, 1, 2]);
    let scene = Scene3d {
        meshes: vec![ball.mesh(Material::paint([0.5; 3])), Solid::default().mesh(Material::skin())],
        ..Scene3d::default()
    };
    render(&scene, &camera(Vec3::new(0.0, 0.0, 2.0)), 40, 30, &plain());
    // The eye inside a mesh that surrounds it, and a picture without pixels.
    render(&scene, &camera(Vec3::new(0.0, 0.0, 0.05)), 40, 30, &plain());
    render(&scene, &camera(Vec3::zeros()), 0, 0, &plain());
}

#[test]
fn a_floor_that_passes_under_the_eye_is_cut_at_the_near_plane() {
    // Two huge triangles at y = -1, seen level from the origin: all below the horizon is floor.
    let floor = Solid {
        positions: [(-1e3, -1e3), (1e3, -1e3), (1e3, 1e3), (-1e3, 1e3)]
            .map(|(x, z)| Vec3::new(x, -1.0, z))
            .to_vec(),
        triangles: vec![[0, 2, 1], [0, 3, 2]],
    };
    let scene =
        Scene3d { meshes: vec![unlit_black(floor)], backdrop: white(), ..Scene3d::default() };
    let eye = Camera { position: Vec3::zeros(), target: -Vec3::z(), ..camera(Vec3::zeros()) };
    let image = render(&scene, &eye, 100, 100, &plain());
    let dark = darkness(&image);
    // The far edge, 1000 m off, lies focal / 1000 = 0.12 px below the horizon.
    assert!((dark - 0.5).abs() < 0.005, "{dark}");
}

mod files {
    use super::*;
    use std::path::PathBuf;
    use thenar_output::Output;

    fn folder(name: &str) -> PathBuf {
        let dir = std::env::temp_dir().join(format!("thenar-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&dir).expect("a folder for the test");
        dir
    }

    fn frame(step: u32) -> Image {
        let mut image = Image::new(31, 17);
        for (i, byte) in image.rgb.iter_mut().enumerate() {
            *byte = (i as u32 * 7 % 251) as u8;
        }
        for x in 0..5 {
            let i = 3 * (4 * 31 + (x + step) as usize);
            image.rgb[i..i + 3].copy_from_slice(&[255, step as u8, 0]);
        }
        image
    }

    #[test]
    fn a_png_reads_back_as_it_was_written() {
        let dir = folder("png");
        let path = dir.join("a.png");
        write_png(Output::create(&path).expect("begun"), &frame(3)).expect("written");
        assert_eq!(png_reader::first(&path), (frame(3).rgb, [31, 17], 1));
        assert_eq!(std::fs::read_dir(&dir).expect("listed").count(), 1, "no partial file is left");
        std::fs::remove_dir_all(dir).expect("removed");
    }

    #[test]
    fn a_movie_replayed_by_its_rules_gives_back_every_frame() {
        let dir = folder("movie");
        let path = dir.join("m.png");
        let steps = [0, 1, 20, 20, 9];
        let mut movie = Movie::create(&path, [31, 17], 5, 25).expect("created");
        for step in steps {
            movie.push(&frame(step)).expect("pushed");
        }
        movie.finish().expect("finished");

        let mut reader = png_reader::open(&path);
        assert_eq!(reader.info().animation_control.expect("animated").num_frames, 5);
        let mut canvas = vec![0_u8; 31 * 17 * 4];
        for step in steps {
            let mut bytes = vec![0; 31 * 17 * 4];
            reader.next_frame(&mut bytes).expect("a frame");
            let part = *reader.info().frame_control.as_ref().expect("control");
            assert_eq!((part.delay_num, part.delay_den), (1, 25));
            for y in 0..part.height {
                for x in 0..part.width {
                    let from = 4 * (y * part.width + x) as usize;
                    let to = 4 * ((y + part.y_offset) * 31 + x + part.x_offset) as usize;
                    if bytes[from + 3] == 255 {
                        canvas[to..to + 4].copy_from_slice(&bytes[from..from + 4]);
                    }
                }
            }
            let rgb: Vec<u8> = canvas.chunks(4).flat_map(|p| p[..3].to_vec()).collect();
            assert_eq!(rgb, frame(step).rgb);
        }
        std::fs::remove_dir_all(dir).expect("removed");
    }

    #[test]
    fn a_broken_off_movie_leaves_no_file() {
        let dir = folder("broken");
        let path = dir.join("m.png");
        let mut movie = Movie::create(&path, [31, 17], 3, 25).expect("created");
        movie.push(&frame(0)).expect("pushed");
        assert!(matches!(movie.push(&Image::new(3, 3)), Err(EncodeError::FrameSize { .. })));
        assert!(matches!(movie.finish(), Err(EncodeError::FrameCount { .. })));
        assert_eq!(std::fs::read_dir(&dir).expect("listed").count(), 0);
        std::fs::remove_dir_all(dir).expect("removed");
    }

    #[test]
    fn a_folder_that_does_not_exist_is_named_in_the_error() {
        let error = Output::create(std::path::Path::new("no-such-folder/a.png"));
        assert!(error.expect_err("refused").to_string().contains("no-such-folder/a.png"));
    }
}

/// A rigid box is red and a soft one blue; with its flesh the soft one shows lines.
#[test]
fn what_was_built_is_drawn() {
    use thenar_core::model::{Law, Material as Tissue};
    use thenar_rig::embed::{EmbedOptions, embed};
    use thenar_rig::object::{ImportOptions, SoftModel, Weight, rigid_from_mesh};
    use thenar_rig::{Model, mesh::shapes};
    let mesh = shapes::cuboid(&Vec3::new(0.03, 0.02, 0.04));
    let (rigid, _) =
        rigid_from_mesh("box", &mesh, Weight::Mass(0.1), &ImportOptions::default()).expect("a box");
    let tissue = Tissue { law: Law::Corotational, young: 1e4, poisson: 0.3, density: 1000.0 };
    let options = EmbedOptions { tets: 100, ..EmbedOptions::default() };
    let body = embed(&mesh, &options, |_| tissue).expect("a body");
    let soft = SoftModel { name: "box".into(), flesh: body.flesh, render: body.render };
    let draw = |model: &Model, layers: &str| {
        let layers = layers.parse::<Layers>().expect("layers");
        portrait(model, &layers, [120, 80], &plain()).expect("a picture")
    };
    let [rigid, soft] = [Model::Rigid(rigid), Model::Soft(soft)];
    let [red, _, blue] = draw(&rigid, "skin").pixel(60, 40);
    assert!(red > 2 * blue, "{red} {blue}");
    let whole = draw(&soft, "skin");
    let [red, _, blue] = whole.pixel(60, 40);
    assert!(blue > red, "{red} {blue}");
    let lines = draw(&soft, "skin,flesh");
    let dark = |image: &Image| image.rgb.chunks(3).filter(|p| p[0] < 60 && p[2] < 140).count();
    assert!(dark(&lines) > 100 + dark(&whole), "{} {}", dark(&lines), dark(&whole));
}

/// A hand that rests on a table beside a green cube of flesh: its pressure shows, through the hand,
/// and the cube keeps its colour.
#[test]
fn pressure_shows_on_the_hand_alone() {
    use thenar_scene::session::Session;
    const SCENE: &str = r#"
version = 1
time_step = 0.01
[camera]
position = [0.0, 0.45, 0.05]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, -1.0]
fov_deg = 35
[[rigid]]
name = "table"
shape = { kind = "plane" }
motion = "fixed"
[[hand]]
name = "hand"
model = "right"
preset = "paper"
tets = 300
[hand.motion]
kind = "keyframes"
key = [
  { time = 0, pose = "open", wrist = { position = [0, 0.03, 0.06], fingers = [0, -0.25, -1], back = [0, 1, 0] } },
]
[[soft]]
name = "cube"
colour = [0.1, 0.7, 0.1]
position = [0.11, 0.02, 0.0]
shape = { kind = "lattice", size = [0.04, 0.04, 0.04], cells = [1, 1, 1] }
"#;
    let mut session =
        Session::from_text(SCENE, std::path::Path::new("rest.toml"), &[]).expect("a scene");
    for _ in 0..40 {
        session.step(&mut ());
    }
    let eye = crate::camera(&session, 1.5);
    let picture = |layers: &str, most: f64| {
        let layers = layers.parse::<Layers>().expect("layers");
        let scales = Scales { pressure: most, ..Scales::default() };
        let scene = crate::from_session::stage(&session).scene(&layers, &scales, &eye, 160);
        render(&scene, &eye, 240, 160, &plain())
    };
    let usual = Scales::default().pressure;
    // On a scale that ends at 1 TPa nothing is marked.
    let [bare, unmarked, pressed] =
        [("skin", usual), ("skin,pressure", 1e12), ("skin,pressure", usual)]
            .map(|(l, p)| picture(l, p));
    let differs = |(one, other): &(&[u8], &[u8])| {
        one.iter().zip(other.iter()).any(|(a, b)| a.abs_diff(*b) > 20)
    };
    let marked = unmarked.rgb.chunks(3).zip(pressed.rgb.chunks(3)).filter(differs).count();
    assert!(marked > 30, "{marked} pixels");
    let green = |image: &Image| {
        let green = |p: &&[u8]| p[1] > 60 && u32::from(p[1]) > 2 * u32::from(p[0]);
        image.rgb.chunks(3).filter(green).count()
    };
    assert!(green(&bare) > 300, "{}", green(&bare));
    assert!(green(&bare).abs_diff(green(&pressed)) < 20, "{} {}", green(&bare), green(&pressed));
}
