//! Writes a figure as a skinned mesh: `skin_figure FILE THICKNESS TRIANGLES OUT.glb`. The shipped
//! `body.glb` is of `crates/thenar-rig/assets/figures/figure.xml`, 0.03 m and 4000 triangles.

use std::path::Path;
use thenar_rig::export::write_hand_glb;
use thenar_rig::figure::{FigureOptions, build_figure_file};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, thickness, triangles, out] = &arguments[..] else {
        eprintln!("usage: skin_figure FILE THICKNESS TRIANGLES OUT.glb");
        std::process::exit(2);
    };
    if let Err(error) = write(file, thickness, triangles, out) {
        eprintln!("{error}");
        std::process::exit(1);
    }
}

fn write(
    file: &str,
    thickness: &str,
    triangles: &str,
    out: &str,
) -> Result<(), Box<dyn std::error::Error>> {
    let path = Path::new(file);
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    let render_triangles = triangles.parse()?;
    let thickness = Some(thickness.parse()?);
    let options = FigureOptions { name, thickness, render_triangles, ..FigureOptions::default() };
    let (figure, report) = build_figure_file(path, &options)?;
    println!("{report:#?}");
    Ok(write_hand_glb(Path::new(out), &figure)?)
}
