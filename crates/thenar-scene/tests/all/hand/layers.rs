//! Goal: layers, skin and nails reach the world as a scene asks, and what makes no sense is refused
//! with file, key and reason. Method: hands and soft bodies opened from text, their descriptions
//! and errors looked at.

use std::path::Path;
use thenar_core::model::{Skin, WorldDesc};
use thenar_scene::session::Session;

fn open(body: &str) -> Result<Session, String> {
    let text = format!("version = 1\n{body}");
    Session::from_text(&text, Path::new("layers.toml"), &[]).map_err(|e| e.to_string())
}

fn world(body: &str) -> WorldDesc {
    open(body).unwrap_or_else(|e| panic!("{e}")).world().desc().clone()
}

fn hand(keys: &str) -> String {
    format!("[[hand]]\nname = \"hand\"\npreset = \"touch\"\ndetail = 0.3\n{keys}\n")
}

fn area(skin: &Skin, sheet: u32) -> f64 {
    skin.facets.iter().filter(|facet| facet.sheet == sheet).map(|facet| facet.area).sum()
}

/// Area of the surface that touches.
fn surface(world: &WorldDesc) -> f64 {
    let flesh = &world.softs[0].flesh;
    let mut x = vec![thenar_core::Vec3::zeros(); flesh.collision.vertices.len()];
    flesh.collision.positions(&flesh.tets, &flesh.nodes, &mut x);
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| x[v as usize]);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    flesh.collision.triangles.iter().map(of).sum()
}

#[test]
fn a_layered_hand_has_skin_nails_and_subcutis() {
    let even = world(&hand(""));
    let layered = world(&hand("tissue = \"layered\""));
    assert!(even.skins.is_empty());
    let [skin] = layered.skins.as_slice() else { panic!("one skin") };
    // Skin of 148 N/m, nails of 1 kN/m; together they cover the hand.
    let stiffness = |k: usize| skin.sheets[k].young * skin.sheets[k].thickness;
    assert!((stiffness(0) - 148.0).abs() < 1e-6 && (stiffness(1) - 1e3).abs() < 1e-6);
    let whole = surface(&layered);
    assert!((area(skin, 0) + area(skin, 1) - whole).abs() < 1e-9 * whole);
    assert!(
        (0.005..0.03).contains(&(area(skin, 1) / whole)),
        "{} of it nails",
        area(skin, 1) / whole
    );
    // The same mesh, softer where there is subcutis, nowhere else.
    let young = |world: &WorldDesc| -> Vec<f64> {
        world.softs[0].flesh.materials.iter().map(|m| m.young).collect()
    };
    let (before, after) = (young(&even), young(&layered));
    assert_eq!(even.softs[0].flesh.nodes, layered.softs[0].flesh.nodes);
    let ratios: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a / b).collect();
    assert!(ratios.iter().all(|r| (0.68 - 1e-9..1.0 + 1e-9).contains(r)));
    let softened = ratios.iter().filter(|r| **r < 0.6801).count() as f64 / ratios.len() as f64;
    assert!((0.2..0.8).contains(&softened), "{softened}");
    // Nails hold nodes that nothing held.
    let held = |world: &WorldDesc| {
        let springs = &world.softs[0].coupling.as_ref().unwrap().springs;
        springs.stiffness().filter(|k| *k > 0.0).count()
    };
    assert!(held(&layered) > held(&even));
}

/// Keys beside the preset win; layers lie on the hand's material.
#[test]
fn keys_win_over_the_tissue() {
    let keys = "tissue = \"layered\"\n\
                skin = { thickness = 0.001, young = 1e5, pretension = 4.0 }\n\
                material = { young = 2e4, poisson = 0.46 }\n\
                layer = [{ region = \"pad\", depth = [0, 0.003], tissue = \"dermis\", poisson = 0.4 }]";
    let world = world(&hand(keys));
    let sheet = world.skins[0].sheets[0];
    assert_eq!((sheet.thickness, sheet.young, sheet.pretension), (0.001, 1e5, 4.0));
    let materials = &world.softs[0].flesh.materials;
    let most = materials.iter().map(|m| m.young).fold(0.0, f64::max);
    // Some element lies in dermis alone or nearly so, none is stiffer; all else is as soft as
    // asked.
    assert!((4e4..=8e4 * (1.0 + 1e-9)).contains(&most), "{most} Pa");
    assert!(materials.iter().all(|m| (0.4 - 1e-9..0.46 + 1e-9).contains(&m.poisson)));
    let soft = materials.iter().filter(|m| m.young < 2e4 * (1.0 + 1e-9)).count();
    assert!(soft as f64 > 0.8 * materials.len() as f64);
}

/// A named tissue as a hand's and a soft body's material.
#[test]
fn tissues_have_names() {
    let one = world(&hand("material = { tissue = \"subcutis\" }"));
    let most = one.softs[0].flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
    assert!((most - 34e3).abs() < 1e-6 * 34e3);
    assert!(one.softs[0].flesh.materials.iter().all(|m| m.poisson == 0.48));
    let block = "[[soft]]\nname = \"block\"\nshape = { kind = \"lattice\", size = [0.02, 0.02, 0.02], cells = [2, 2, 2] }\n";
    let soft = world(&format!("{block}material = {{ tissue = \"tendon\", poisson = 0.4 }}"));
    let material = soft.softs[0].flesh.materials[0];
    assert_eq!(material.law, thenar_core::model::Law::Ogden { alpha: 8.5 });
    assert_eq!((material.young, material.poisson), (2.0 * 1.48 * 35.3e3, 0.4));
    let skinned =
        world(&format!("{block}contact = false\nskin = {{ thickness = 0.001, young = 1e5 }}"));
    let skin = &skinned.skins[0];
    // Skin lies on the body's surface even where it touches nothing.
    assert!((area(skin, 0) - 6.0 * 4e-4).abs() < 1e-12);
    assert!(skinned.softs[0].flesh.collision.triangles.is_empty());
}

#[test]
fn what_makes_no_sense_is_refused_with_file_key_and_reason() {
    let refused = |body: &str, parts: &[&str]| {
        let error = open(body).err().unwrap_or_else(|| panic!("{body} opened"));
        assert!(error.starts_with("layers.toml:"), "{error}");
        parts.iter().for_each(|part| assert!(error.contains(part), "{error}, not {part}"));
    };
    let layers = |layers: &str| hand(&format!("layer = [{layers}]"));
    refused(
        &layers("{ region = \"pad\", depth = [0, 0.08] }"),
        &["`hand[0].layer[0]`", "reaches 80.0 mm under the skin, but the pad is thinner"],
    );
    refused(
        &layers("{ depth = [0, 0.002] }, { region = \"palm\", depth = [0.001, 0.003] }"),
        &["`hand[0].layer[1]`", "it overlaps layer 1"],
    );
    refused(&layers("{ depth = [0.002, 0.002] }"), &["`hand[0].layer[0]`", "no thickness"]);
    refused(&layers("{ depth = [-0.001, 0.002] }"), &["`hand[0].layer[0].depth[0]`", "from 0"]);
    refused(&layers("{ depth = [0, 0.002], young = 0 }"), &["`hand[0].layer[0].young`"]);
    refused(&layers("{ depth = [0, 0.002], poisson = 0.5 }"), &["`hand[0].layer[0].poisson`"]);
    refused(
        &layers("{ depth = [0, 0.002], law = \"ogden\" }"),
        &["`hand[0].layer[0].law`", "needs its exponent"],
    );
    let skin = |keys: &str| hand(&format!("skin = {{ {keys} }}"));
    refused(&skin("thickness = 0, young = 1e5"), &["`hand[0].skin.thickness`"]);
    refused(&skin("thickness = 0.001, young = -1"), &["`hand[0].skin.young`"]);
    refused(&skin("thickness = 0.001, young = 1e5, poisson = 0.5"), &["`hand[0].skin.poisson`"]);
    refused(
        &skin("thickness = 0.001, young = 1e5, pretension = -2"),
        &["`hand[0].skin.pretension`"],
    );
    refused(
        &skin("thickness = 0.001, young = 1e5, pretension = inf"),
        &["`hand[0].skin.pretension`"],
    );
    refused(
        &skin("thickness = 0.03, young = 1e5"),
        &["`hand[0].skin`", "skin of 30.000 mm is thicker than the body"],
    );
    refused(&hand("nail = { thickness = -0.001 }"), &["`hand[0].nail.thickness`"]);
    let block = "[[soft]]\nname = \"block\"\nshape = { kind = \"lattice\", size = [0.02, 0.02, 0.02], cells = [2, 2, 2] }\n";
    refused(
        &format!("{block}skin = {{ thickness = 0.004, young = 1e5 }}"),
        &["`soft[0].skin`", "thicker than the body, which has 3.333 mm"],
    );
}
