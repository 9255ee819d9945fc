//! Lengths and mass of a hand.

use super::{HANDS, still};
use crate::lab::validate::case::{Basis, CaseError, Check, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::model::HandModel;
use thenar_core::{Mat3, Vec3};

/// Mean and standard deviation \[mm\] of 66 radiographs (Buryanov and Kotiuk 2010), by bone. The
/// metacarpals of the fingers are one bone with the palm here, and not among them.
const RADIOGRAPHS: [(&str, f64, f64); 9] = [
    ("thumb-metacarpal", 46.2, 3.9),
    ("thumb-proximal", 31.6, 3.1),
    ("thumb-distal", 21.7, 1.6),
    ("index-proximal", 39.8, 4.9),
    ("index-intermediate", 22.4, 2.5),
    ("index-distal", 15.8, 2.3),
    ("middle-proximal", 44.6, 3.8),
    ("middle-intermediate", 26.3, 3.0),
    ("middle-distal", 17.4, 1.9),
];

fn length_mm(hand: &HandModel, bone: &str) -> Result<f64, CaseError> {
    let bone = hand.bones.iter().find(|b| b.name == bone);
    let bone = bone.ok_or_else(|| CaseError::Missing("the hand lacks a bone".into()))?;
    Ok(1e3 * (bone.ends_B[1] - bone.ends_B[0]).norm())
}

/// Each within two standard deviations of one uniform scale, which the lengths themselves give.
pub fn lengths(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in HANDS {
        let mut run = still(solver, hand)?;
        let model = &run.session().hands()[0].model;
        let (mut up, mut down) = (0.0, 0.0);
        for (bone, mean, sd) in RADIOGRAPHS {
            up += length_mm(model, bone)? * mean / (sd * sd);
            down += mean * mean / (sd * sd);
        }
        let scale = up / down;
        figures.push(Figure::new(
            "scale that fits all [1]",
            hand.name,
            f64::NAN,
            scale,
            Check::Report,
        ));
        for (bone, mean, sd) in RADIOGRAPHS {
            let off = (length_mm(model, bone)? - scale * mean) / (scale * sd);
            let what = format!("{bone} off the mean [SD]");
            figures.push(
                Figure::new(what, hand.name, 2.0, off, Check::AtMost)
                    .rests_on(Basis::People)
                    .or_cannot("the mesh's own rig puts the thumb's first joint some 13 mm further out than radiographs do"),
            );
        }
    }
    Ok(figures)
}

/// de Leva 1996: of men, mass 0.0061 of 73 kg, centre at 0.3624 of the length from wrist to
/// fingertip, radii of gyration 0.288, 0.235 and 0.184 of it about axes through the palm, across
/// and along.
pub fn mass(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = Vec::new();
    for hand in HANDS {
        let mut run = still(solver, hand)?;
        let (model, handle) = {
            let built = &run.session().hands()[0];
            (built.model.clone(), built.handle.clone())
        };
        let world = run.world();
        let flesh =
            world.nodes(0).iter().zip(world.node_masses(0)).map(|(x, m)| (*m, *x, Mat3::zeros()));
        let bones = handle.bones.clone().map(|i| {
            let bone = &world.desc().rigids[i as usize];
            let pose = world.rigid_pose(i);
            let R = pose.rotation.to_rotation_matrix().into_inner();
            (bone.mass, pose.position, R * bone.inertia * R.transpose())
        });
        let parts: Vec<(f64, Vec3, Mat3)> = flesh.chain(bones).collect();
        let mass: f64 = parts.iter().map(|(m, ..)| m).sum();
        let centre: Vec3 = parts.iter().map(|(m, x, _)| x * *m).sum::<Vec3>() / mass;
        let inertia: Mat3 = parts
            .iter()
            .map(|(m, x, I)| {
                let r = x - centre;
                I + (Mat3::identity() * r.norm_squared() - r * r.transpose()) * *m
            })
            .sum();
        let length = model.length;
        let setup = format!("{}, {} tets", hand.name, model.flesh.tets.len());
        // A hand of 190 mm is taken for that of a man of 73 kg, and others for his in proportion.
        let like = 0.0061 * 73.0 * (length / 0.19).powi(3);
        let row = |what: &str, want: f64, got: f64, part: f64, why: &str| {
            Figure::within(what, &setup, [want * (1.0 - part), want * (1.0 + part)], got)
                .rests_on(Basis::Recalled)
                .or_cannot(why)
        };
        let stump = "the mesh has a stump of the wrist, 22 mm of 212, and one open hand of one person is compared with means";
        figures.push(row("mass [kg]", like, mass, 0.2, stump));
        // -z to the fingers, +y out of the back.
        figures.push(row("centre of mass over length", 0.3624, -centre.z / length, 0.1, stump));
        for (what, axis, want) in [
            ("radius of gyration through the palm / length", 1, 0.288),
            ("radius of gyration across / length", 0, 0.235),
            ("radius of gyration along / length", 2, 0.184),
        ] {
            let got = (inertia[(axis, axis)] / mass).sqrt() / length;
            figures.push(row(what, want, got, 0.15, "the bands are of hands half closed by no standard; here fingers are straight and spread"));
        }
    }
    Ok(figures)
}
