//! Pictures of a world, by the program's own renderer.

use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use std::path::PathBuf;
use thenar_core::Vec3;
use thenar_output::Output;
use thenar_picture::{Camera, EncodeError, Image, Layers, Quality, camera, draw, write_png};
use thenar_scene::session::Session;

/// Largest width and height \[px\], as of the program.
const SIZE_MAX: u32 = 8192;

/// For eyes of learners, who look at small pictures very often: no ambient occlusion, a coarse
/// shadow, and no threads, as many such worlds run side by side.
const QUICK: Quality = Quality { samples: 4, shadow_map: 256, ambient_directions: 0, threads: 1 };

/// Content of a picture, and the eye that sees it.
pub struct PictureSpec {
    size: [u32; 2],
    layers: Layers,
    camera: Option<Camera>,
    quality: Quality,
}

impl PictureSpec {
    /// Checks what is wanted. `camera`: place of the eye, place looked at \[m\] and field of view
    /// \[deg\].
    ///
    /// # Errors
    /// The size is none, there is no such layer, or the camera sees nothing.
    pub fn new(
        size: [u32; 2],
        layers: &str,
        camera: Option<[f64; 7]>,
        quality: &str,
    ) -> PyResult<Self> {
        if size.iter().any(|edge| !(1..=SIZE_MAX).contains(edge)) {
            let [width, height] = size;
            return Err(PyValueError::new_err(format!(
                "expected a picture of 1 x 1 to {SIZE_MAX} x {SIZE_MAX} pixels, got {width} x {height}"
            )));
        }
        let layers = layers.parse::<Layers>().map_err(PyValueError::new_err)?;
        let quality = match quality {
            "quick" => QUICK,
            "movie" => Quality::movie(),
            "still" => Quality::still(),
            _ => {
                let what = format!("quality: expected quick, movie or still, got `{quality}`");
                return Err(PyValueError::new_err(what));
            }
        };
        Ok(Self { size, layers, camera: camera.map(eye).transpose()?, quality })
    }

    /// Draws it.
    pub fn draw(&self, session: &Session) -> Image {
        let [width, height] = self.size.map(f64::from);
        let eye = self.camera.unwrap_or_else(|| camera(session, width / height));
        draw(session, &self.layers, &eye, self.size, &self.quality)
    }
}

fn eye(numbers: [f64; 7]) -> PyResult<Camera> {
    let [x, y, z, a, b, c, fov_deg] = numbers;
    let (position, target) = (Vec3::new(x, y, z), Vec3::new(a, b, c));
    if !numbers.iter().all(|number| number.is_finite()) || (position - target).norm() < 1e-6 {
        let what = "camera: expected a place and another to look at, of finite numbers";
        return Err(PyValueError::new_err(what));
    }
    if !(1.0..=150.0).contains(&fov_deg) {
        let what = format!("camera: expected a field of view of 1 to 150 degrees, got {fov_deg}");
        return Err(PyValueError::new_err(what));
    }
    Ok(Camera { position, target, up: Vec3::y(), fov_y: fov_deg.to_radians() })
}

/// Writes a picture as a PNG file; a file that is there is replaced once the new one is whole.
///
/// # Errors
/// The file cannot be written.
pub fn write(image: &Image, file: PathBuf) -> PyResult<()> {
    let output = Output::create(&file).map_err(|e| error(&e.into()))?;
    write_png(output, image).map_err(|e| error(&e))
}

fn error(error: &EncodeError) -> PyErr {
    PyOSError::new_err(error.to_string())
}
