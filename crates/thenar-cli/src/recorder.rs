//! Pictures and movies of a run, taken as it goes.

use crate::error::CliError;
use std::path::{Path, PathBuf};
use thenar_output::Output;
use thenar_picture::{Camera, EncodeError, Image, Layers, Movie, Quality, camera, draw, write_png};
use thenar_scene::session::Session;

/// Pictures that `thenar run` is to make.
#[derive(Clone, Debug, clap::Args)]
pub struct PictureOptions {
    /// Draw the end of the run (or the time given by --at) as a PNG file
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// Time of the picture [s]; an error beyond the end of the run
    #[arg(long, value_name = "SECONDS", requires = "picture", allow_negative_numbers = true)]
    pub at: Option<f64>,
    /// Draw a PNG file for each frame into this folder
    #[arg(long, value_name = "DIR")]
    pub frames: Option<PathBuf>,
    /// Draw an animated PNG, which any browser plays
    #[arg(long, value_name = "FILE")]
    pub movie: Option<PathBuf>,
    /// Frames in each simulated second
    #[arg(long, default_value_t = 25, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub fps: u16,
    /// Layers to draw: skin, flesh, bones, tracked, targets, contacts, forces, pressure, weights
    #[arg(long, default_value = "skin", value_name = "LIST")]
    pub layers: Layers,
    /// Pixels, width x height
    #[arg(long, default_value = "960x640", value_parser = size, value_name = "WxH")]
    pub size: [u32; 2],
}

impl PictureOptions {
    /// Refuses what makes no sense, whatever the scene.
    ///
    /// # Errors
    /// A time that is none, or a file name that says another format.
    pub fn check(&self) -> Result<(), CliError> {
        if self.at.is_some_and(|at| !(at.is_finite() && at >= 0.0)) {
            return Err(CliError::Input("--at must be 0 or more".into()));
        }
        ends_in_png("--picture", self.picture.as_deref())?;
        ends_in_png("--movie", self.movie.as_deref())
    }
}

/// Refuses a picture's file whose name ends as that of another format does.
///
/// # Errors
/// There is an ending, and not png.
pub fn ends_in_png(option: &str, file: Option<&Path>) -> Result<(), CliError> {
    let ending = file.and_then(Path::extension).map(|ending| ending.to_string_lossy());
    match ending {
        Some(ending) if !["png", "apng"].contains(&&*ending.to_ascii_lowercase()) => Err(
            CliError::Input(format!("{option} writes PNG: its file ends in .png, not .{ending}")),
        ),
        _ => Ok(()),
    }
}

impl Default for PictureOptions {
    /// Nothing is shown.
    fn default() -> Self {
        Self {
            picture: None,
            at: None,
            frames: None,
            movie: None,
            fps: 25,
            layers: Layers::skin(),
            size: [960, 640],
        }
    }
}

/// Reads a size such as `960x640`.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let number = |s: &str| s.trim().parse::<u32>().ok().filter(|n| (1..=8192).contains(n));
    text.split_once('x')
        .and_then(|(w, h)| Some([number(w)?, number(h)?]))
        .ok_or_else(|| format!("expected WIDTHxHEIGHT from 1x1 to 8192x8192, got \"{text}\""))
}

/// Why something could not be recorded.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A picture or movie.
    #[error(transparent)]
    Picture(#[from] EncodeError),
    /// The folder for frames.
    #[error("cannot make folder {folder}: {cause}")]
    Folder {
        /// Folder that cannot be made.
        folder: PathBuf,
        /// Error of the system.
        cause: std::io::Error,
    },
}

/// Takes pictures of a session while it runs.
pub struct Recorder {
    options: PictureOptions,
    camera: Camera,
    movie: Option<Movie>,
    picture: Option<Output>,
    frames: u32,
}

impl Recorder {
    /// A recorder for a run of `seconds`, starting with the session as it is; `None` when
    /// nothing is to be shown.
    pub fn start(
        options: &PictureOptions,
        session: &Session,
        seconds: f64,
    ) -> Result<Option<Self>, RecordError> {
        let o = options;
        let wanted = o.picture.is_some() || o.frames.is_some() || o.movie.is_some();
        if !wanted {
            return Ok(None);
        }
        if let Some(folder) = &o.frames {
            std::fs::create_dir_all(folder)
                .map_err(|cause| RecordError::Folder { folder: folder.clone(), cause })?;
        }
        let count = (seconds.max(0.0) * f64::from(o.fps) + 1e-6).floor() as u32 + 1;
        let movie = |path: &PathBuf| Movie::create(path, o.size, count, o.fps);
        let picture = o.picture.as_deref().map(Output::create).transpose();
        let mut recorder = Self {
            camera: camera(session, f64::from(o.size[0]) / f64::from(o.size[1])),
            movie: o.movie.as_ref().map(movie).transpose()?,
            picture: picture.map_err(EncodeError::from)?,
            options: o.clone(),
            frames: 0,
        };
        recorder.observe(session)?;
        Ok(Some(recorder))
    }

    /// To be called after each step.
    pub fn observe(&mut self, session: &Session) -> Result<(), RecordError> {
        let time = session.world().time() + 1e-9;
        if time >= f64::from(self.frames) / f64::from(self.options.fps) {
            self.frame(session)?;
            self.frames += 1;
        }
        if self.options.at.is_some_and(|at| time >= at) {
            self.take_picture(session)?;
        }
        Ok(())
    }

    /// Completes all files. A movie that is short of frames stands still at its end.
    pub fn finish(mut self, session: &Session) -> Result<(), RecordError> {
        self.take_picture(session)?;
        if let Some(mut movie) = self.movie {
            movie.stand_still()?;
            movie.finish()?;
        }
        Ok(())
    }

    fn frame(&mut self, session: &Session) -> Result<(), RecordError> {
        if self.movie.is_some() || self.options.frames.is_some() {
            let image = self.draw(session, &Quality::movie());
            if let Some(folder) = &self.options.frames {
                let file = folder.join(format!("frame-{:06}.png", self.frames));
                let output = Output::create(&file).map_err(EncodeError::from)?;
                write_png(output, &image)?;
            }
            if let Some(movie) = self.movie.as_mut().filter(|m| m.frames_left() > 0) {
                movie.push(&image)?;
            }
        }
        Ok(())
    }

    /// Draws the picture, if it is still to be drawn.
    fn take_picture(&mut self, session: &Session) -> Result<(), RecordError> {
        let Some(output) = self.picture.take() else { return Ok(()) };
        Ok(write_png(output, &self.draw(session, &Quality::still()))?)
    }

    fn draw(&self, session: &Session, quality: &Quality) -> Image {
        draw(session, &self.options.layers, &self.camera, self.options.size, quality)
    }
}

#[cfg(test)]
#[path = "../../thenar-picture/src/tests/png_reader.rs"]
mod png_reader;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_or_refused_with_what_was_expected() {
        assert_eq!(size("960x640"), Ok([960, 640]));
        for wrong in ["960", "0x640", "960x99999", "x", "-1x5"] {
            assert!(size(wrong).expect_err(wrong).contains("WIDTHxHEIGHT"));
        }
    }

    #[test]
    fn a_time_that_is_none_and_a_name_of_another_format_are_refused() {
        let asked = |at, picture: &str| {
            let picture = Some(PathBuf::from(picture));
            PictureOptions { picture, at, ..PictureOptions::default() }.check()
        };
        for at in [f64::NAN, f64::INFINITY, -0.1] {
            assert!(asked(Some(at), "a.png").is_err(), "{at}");
        }
        for name in ["a.png", "A.PNG", "a", "/dev/stdout"] {
            assert!(asked(Some(0.0), name).is_ok(), "{name}");
        }
        let told = asked(None, "a.jpg").expect_err("another format").to_string();
        assert!(told.contains("--picture") && told.contains(".png"), "{told}");
    }

    /// A red ball that falls on a table, drawn small.
    const SCENE: &str = r#"
version = 1
time_step = 0.005
duration = 0.1
[[rigid]]
name = "table"
motion = "fixed"
shape = { kind = "plane" }
[[rigid]]
name = "ball"
mass = 0.1
colour = [0.8, 0.0, 0.0]
position = [0.0, 0.1, 0.0]
shape = { kind = "sphere", radius = 0.03 }
[[soft]]
name = "cube"
position = [0.08, 0.0, 0.0]
shape = { kind = "lattice", size = [0.03, 0.03, 0.03], cells = [2, 2, 2] }
"#;

    fn options(dir: &Path) -> PictureOptions {
        PictureOptions {
            picture: Some(dir.join("end.png")),
            at: None,
            frames: Some(dir.join("frames")),
            movie: Some(dir.join("movie.png")),
            fps: 50,
            layers: "skin,flesh,contacts,forces".parse().expect("layers"),
            size: [96, 64],
        }
    }

    /// Runs the scene for a number of steps, announced as 0.1 s.
    fn run(options: &PictureOptions, steps: u32) {
        let mut session = Session::from_text(SCENE, Path::new("ball.toml"), &[]).expect("a scene");
        let mut recorder =
            Recorder::start(options, &session, 0.1).expect("started").expect("something wanted");
        for _ in 0..steps {
            session.step(&mut ());
            recorder.observe(&session).expect("observed");
        }
        recorder.finish(&session).expect("finished");
    }

    /// Mean row of the red pixels.
    fn red_row(path: &Path) -> f64 {
        let (bytes, ..) = png_reader::first(path);
        let red = |p: &[u8]| p[0] > 100 && p[1] < 70 && p[2] < 70;
        let rows: Vec<f64> = bytes
            .chunks(3)
            .enumerate()
            .filter(|(_, p)| red(p))
            .map(|(i, _)| (i / 96) as f64)
            .collect();
        assert!(rows.len() > 50, "the ball is {} pixels", rows.len());
        rows.iter().sum::<f64>() / rows.len() as f64
    }

    #[test]
    fn a_run_leaves_its_frames_movie_and_picture() {
        let dir = std::env::temp_dir().join(format!("thenar-record-{}", std::process::id()));
        std::fs::create_dir_all(&dir).expect("a folder for the test");
        // 0.1 s at 50 frames a second is 6 frames, both ends included.
        run(&options(&dir), 20);
        let frame = |k: u32| dir.join(format!("frames/frame-{k:06}.png"));
        assert_eq!(std::fs::read_dir(dir.join("frames")).expect("listed").count(), 6);
        assert_eq!(png_reader::first(&dir.join("movie.png")).2, 6);
        // It falls 49 mm, more than its radius: visible in the picture as it must be.
        assert!(red_row(&frame(5)) > red_row(&frame(0)) + 3.0);
        assert!((red_row(&dir.join("end.png")) - red_row(&frame(5))).abs() < 1.0);
        std::fs::remove_dir_all(&dir).expect("removed");
    }

    #[test]
    fn a_run_that_ends_early_still_leaves_a_whole_movie() {
        let dir = std::env::temp_dir().join(format!("thenar-early-{}", std::process::id()));
        std::fs::create_dir_all(&dir).expect("a folder for the test");
        let only_movie = PictureOptions { picture: None, frames: None, ..options(&dir) };
        run(&only_movie, 7);
        assert_eq!(png_reader::first(&dir.join("movie.png")).2, 6);
        assert_eq!(std::fs::read_dir(&dir).expect("listed").count(), 1);
        let nothing = PictureOptions { movie: None, ..only_movie };
        let session = Session::from_text(SCENE, Path::new("ball.toml"), &[]).expect("a scene");
        assert!(Recorder::start(&nothing, &session, 1.0).expect("started").is_none());
        std::fs::remove_dir_all(&dir).expect("removed");
    }
}
