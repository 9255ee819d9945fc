//! Figures.

use super::hand::write_boned;
use super::{Args, Outputs, name};
use crate::error::CliError;
use crate::words::{counted, short};
use thenar_core::model::JointKind;
use thenar_rig::Model;
use thenar_rig::figure::{
    FigureOptions, FigureReport, Mimic, build_figure_file, usual_coupling_stiffness,
};
use thenar_scene::build::figure_joints;

/// Builds a figure and prints what it is like.
pub fn build(args: &Args, outputs: &mut Outputs) -> Result<(Model, Vec<Mimic>), CliError> {
    let usual = FigureOptions::default();
    let mut material = usual.material;
    material.young = args.young.unwrap_or(material.young);
    material.poisson = args.poisson.unwrap_or(material.poisson);
    material.density = args.density.unwrap_or(material.density);
    let joints = args.joints.as_deref().map_or(Ok(Vec::new()), figure_joints);
    let options = FigureOptions {
        name: name(args),
        scale: args.scale.unwrap_or(1.0),
        thickness: args.flesh,
        tets: args.tets.unwrap_or(usual.tets),
        material,
        joints: joints.map_err(|e| CliError::Input(e.to_string()))?,
        meshes: args.mesh.clone(),
        ..usual
    };
    let (figure, report) = build_figure_file(&args.input, &options)?;
    print(&report);
    let stiffness = usual_coupling_stiffness(&figure);
    println!(
        "coupling: {stiffness:.2e} N/m⁴ where a scene does not say, {} N/mm for each cubic centimetre of bone",
        short(1e-9 * stiffness)
    );
    write_boned(args, outputs, &figure)?;
    Ok((Model::Hand(figure), report.mimics))
}

fn print(r: &FigureReport) {
    r.notes.iter().for_each(|note| println!("note: {note}"));
    if r.holes > 0 {
        println!("closed: {} of the skin", counted(r.holes, "hole"));
    }
    if r.left_out > 0 {
        let pieces = counted(r.left_out, "separate piece");
        println!("left out: {pieces} of the skin, of which the body is the largest");
    }
    let size = (r.bounds[1] - r.bounds[0]) * 1e3;
    println!("size: {:.1} x {:.1} x {:.1} mm, +y up", size.x, size.y, size.z);
    println!("mass: {:.4} kg flesh, {:.4} kg bones", r.masses[1], r.masses[0]);
    println!("flesh: {} tetrahedra, {} nodes", r.elements[1], r.elements[0]);
    if r.lost_weight > 0.0 {
        println!(
            "weights: {:.1} % of the file's are on bones other than the two that a node can follow",
            100.0 * r.lost_weight
        );
    }
    println!("bones: {}", r.bones);
    for (joint, kind, parent) in &r.joints {
        println!("  {joint:24} {:9} on {parent}", word(*kind));
    }
    for mimic in &r.mimics {
        let [leader, follower] = mimic.ends().map(|(joint, _)| &r.joints[joint as usize].0);
        println!("mimic: {follower} follows {leader} by {}", law(mimic));
    }
}

/// The law of a mimic, as `0.1 rad - 0.5 x` for the leader's angle x.
fn law(mimic: &Mimic) -> String {
    let mut words = String::new();
    for (power, c) in mimic.law.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        let sign = if *c < 0.0 { "-" } else { "+" };
        let term = match power {
            0 => format!("{} rad", short(c.abs())),
            1 if c.abs() == 1.0 => "x".to_owned(),
            1 => format!("{} x", short(c.abs())),
            _ => format!("{} x^{power}", short(c.abs())),
        };
        let first = words.is_empty();
        words += &match (first, sign) {
            (true, "+") => term,
            (true, _) => format!("-{term}"),
            (false, _) => format!(" {sign} {term}"),
        };
    }
    if words.is_empty() { "0 rad".to_owned() } else { words }
}

fn word(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Fixed => "fixed",
        JointKind::Hinge => "hinge",
        JointKind::Universal => "universal",
        JointKind::Ball => "ball",
        JointKind::Free => "free",
    }
}
