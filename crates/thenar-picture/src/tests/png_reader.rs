//! PNG files as tests read them back.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// A file whose header was read.
pub fn open(path: &Path) -> png::Reader<BufReader<File>> {
    let file = BufReader::new(File::open(path).expect("there"));
    png::Decoder::new(file).read_info().expect("a PNG")
}

/// Samples of the first frame, its width and height, and how many frames there are.
pub fn first(path: &Path) -> (Vec<u8>, [u32; 2], u32) {
    let mut reader = open(path);
    let mut samples = vec![0; reader.output_buffer_size().expect("a size")];
    let frames = reader.info().animation_control.map_or(1, |control| control.num_frames);
    let frame = reader.next_frame(&mut samples).expect("a frame");
    samples.truncate(frame.buffer_size());
    (samples, [frame.width, frame.height], frames)
}
