//! PNG and animated PNG files, written whole or not at all.

use super::image::Image;
use std::cell::RefCell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use thenar_output::{Output, OutputError};

/// Why a picture could not be written.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The file cannot be made.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Writing failed; the cause names the file.
    #[error("cannot write picture {0}")]
    Write(std::io::Error),
    /// The encoder refused.
    #[error("cannot encode picture {path}: {cause}")]
    Encoder {
        /// File that was written.
        path: PathBuf,
        /// Error of the encoder.
        cause: png::EncodingError,
    },
    /// A frame of another size than the movie's.
    #[error("movie {path} is {expected:?} pixels, but a frame is {got:?}")]
    FrameSize {
        /// File that was written.
        path: PathBuf,
        /// Width and height of the movie.
        expected: [u32; 2],
        /// Width and height of the frame.
        got: [u32; 2],
    },
    /// Fewer or more frames than announced.
    #[error("movie {path} was announced with {expected} frames, but has {got}")]
    FrameCount {
        /// File that was written.
        path: PathBuf,
        /// Frames that were announced.
        expected: u32,
        /// Frames that were pushed.
        got: u32,
    },
}

fn fault(path: &Path, cause: png::EncodingError) -> EncodeError {
    match cause {
        png::EncodingError::IoError(cause) => EncodeError::Write(cause),
        cause => EncodeError::Encoder { path: path.to_owned(), cause },
    }
}

/// Writes a PNG file.
pub fn write_png(mut output: Output, image: &Image) -> Result<(), EncodeError> {
    let path = output.target().to_owned();
    let fault = |cause| fault(&path, cause);
    let mut encoder = png::Encoder::new(&mut output, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header().map_err(fault)?;
    writer.write_image_data(&image.rgb).map_err(fault)?;
    writer.finish().map_err(fault)?;
    Ok(output.finish()?)
}

/// An animated PNG in the making. Pixels that do not change from frame to frame cost nothing.
pub struct Movie {
    path: PathBuf,
    writer: png::Writer<Shared>,
    output: Shared,
    size: [u32; 2],
    announced: u32,
    pushed: u32,
    last: Option<Image>,
}

impl Movie {
    /// Starts a movie of `frames` frames, `fps` in each second, that repeats for ever.
    pub fn create(path: &Path, size: [u32; 2], frames: u32, fps: u16) -> Result<Self, EncodeError> {
        let output = Shared(Rc::new(RefCell::new(Output::create(path)?)));
        let fault = |cause| fault(path, cause);
        let mut encoder = png::Encoder::new(output.clone(), size[0], size[1]);
        encoder.set_color(png::ColorType::Rgba);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_animated(frames, 0).map_err(fault)?;
        encoder.set_frame_delay(1, fps.max(1)).map_err(fault)?;
        let writer = encoder.write_header().map_err(fault)?;
        let path = path.to_owned();
        Ok(Self { path, writer, output, size, announced: frames, pushed: 0, last: None })
    }

    /// Frames still to be pushed.
    pub fn frames_left(&self) -> u32 {
        self.announced - self.pushed
    }

    /// Adds a frame.
    pub fn push(&mut self, image: &Image) -> Result<(), EncodeError> {
        let got = [image.width, image.height];
        if got != self.size {
            let (path, expected) = (self.path.clone(), self.size);
            return Err(EncodeError::FrameSize { path, expected, got });
        }
        if self.pushed >= self.announced {
            return Err(self.miscounted(self.pushed + 1));
        }
        let changed = Changed::between(self.last.as_ref(), image);
        let rgba = changed.rgba(self.last.as_ref(), image);
        self.write(&changed, &rgba).map_err(|cause| fault(&self.path, cause))?;
        self.pushed += 1;
        self.last = Some(image.clone());
        Ok(())
    }

    fn write(&mut self, changed: &Changed, rgba: &[u8]) -> Result<(), png::EncodingError> {
        if self.pushed > 0 {
            // The encoder checks each against the other: back to the corner in between.
            self.writer.set_frame_position(0, 0)?;
            self.writer.set_frame_dimension(changed.width, changed.height)?;
            self.writer.set_frame_position(changed.x, changed.y)?;
            self.writer.set_blend_op(png::BlendOp::Over)?;
        }
        self.writer.write_image_data(rgba)
    }

    fn miscounted(&self, got: u32) -> EncodeError {
        EncodeError::FrameCount { path: self.path.clone(), expected: self.announced, got }
    }

    /// Fills up with frames in which nothing moves, up to the number announced.
    pub fn stand_still(&mut self) -> Result<(), EncodeError> {
        // A pixel of the corner, as it is already.
        let nothing = Changed { x: 0, y: 0, width: 1, height: 1 };
        while self.pushed > 0 && self.frames_left() > 0 {
            self.write(&nothing, &[0; 4]).map_err(|cause| fault(&self.path, cause))?;
            self.pushed += 1;
        }
        Ok(())
    }

    /// Completes the file and puts it in its place.
    pub fn finish(self) -> Result<(), EncodeError> {
        if self.pushed != self.announced {
            return Err(self.miscounted(self.pushed));
        }
        self.writer.finish().map_err(|cause| fault(&self.path, cause))?;
        // The writer has gone, and with it the only other owner.
        match Rc::into_inner(self.output.0) {
            Some(output) => Ok(output.into_inner().finish()?),
            None => Ok(()),
        }
    }
}

/// The rectangle in which a frame differs from the one before.
struct Changed {
    x: u32,
    y: u32,
    width: u32,
    height: u32,
}

impl Changed {
    fn between(last: Option<&Image>, image: &Image) -> Self {
        let whole = Self { x: 0, y: 0, width: image.width, height: image.height };
        let Some(last) = last else { return whole };
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for y in 0..image.height {
            for x in 0..image.width {
                if last.pixel(x, y) != image.pixel(x, y) {
                    low = [low[0].min(x), low[1].min(y)];
                    high = [high[0].max(x), high[1].max(y)];
                }
            }
        }
        if low[0] > high[0] {
            return Self { width: 1, height: 1, ..whole };
        }
        Self { x: low[0], y: low[1], width: high[0] - low[0] + 1, height: high[1] - low[1] + 1 }
    }

    /// Pixels of the changed rectangle, fully transparent where nothing changed.
    fn rgba(&self, last: Option<&Image>, image: &Image) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(4 * self.width as usize * self.height as usize);
        for y in self.y..self.y + self.height {
            for x in self.x..self.x + self.width {
                let [r, g, b] = image.pixel(x, y);
                match last {
                    Some(last) if last.pixel(x, y) == [r, g, b] => bytes.extend([0; 4]),
                    _ => bytes.extend([r, g, b, 255]),
                }
            }
        }
        bytes
    }
}

/// The output of an encoder that keeps what it is given for itself.
#[derive(Clone)]
struct Shared(Rc<RefCell<Output>>);

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.0.borrow_mut().flush()
    }
}
