//! Reading, past damage if there is any.

use crate::frame::{
    FRAME_BYTES_MAX, Frame, HEAD_BYTES, MAGIC, PAYLOAD_BYTES_MIN, PROLOGUE_BYTES, checksum,
};
use crate::resync::{NewestTimes, Search};
use crate::{FrameKind, Header, OpenError, VERSION};
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

/// Fault of the first frame that cannot be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The file ends within it.
    CutOff,
    /// The frame's checksum does not agree.
    Checksum,
    /// The frame's length is impossible.
    Length,
    /// The recording does not begin with a header.
    Header,
    /// The frame is older than one before it: it has been moved or repeated.
    Order,
    /// Whoever reads the frames finds that this one cannot stand here: [`Frames::reject`].
    Content,
}

/// A piece of a recording that makes no sense.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Start of the first damaged frame \[bytes\].
    pub offset: u64,
    /// Fault of that frame.
    pub fault: Fault,
    /// From there to the next frame that can be trusted, or to the end of the file \[bytes\].
    pub lost_bytes: u64,
    /// True if a trusted frame follows.
    pub resumed: bool,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.fault {
            Fault::CutOff => "the file ends within a frame",
            Fault::Checksum => "a checksum does not agree",
            Fault::Length => "a frame has an impossible length",
            Fault::Header => "there is no header",
            Fault::Order => "a frame is not in its place",
            Fault::Content => "a frame's number, time or state cannot be",
        };
        let Self { offset, lost_bytes, resumed, .. } = self;
        let which = if *resumed { "bytes from there" } else { "bytes from there on" };
        write!(f, "{what} at byte {offset}; the {lost_bytes} {which} are not used")
    }
}

/// Begin of a frame in a file, to come back to it.
#[derive(Clone, Debug)]
pub struct FramePlace {
    at: u64,
    sum: u32,
    newest: NewestTimes,
}

impl FramePlace {
    /// Offset of the frame's start \[bytes\].
    pub fn offset(&self) -> u64 {
        self.at
    }
}

/// The frames of a recording, one after another. Every one of them was written as it is, after
/// those before it; what is damaged is left out.
#[derive(Debug)]
pub struct Frames<R> {
    input: R,
    /// Bytes of the whole file, and where the next frame begins.
    size: u64,
    at: u64,
    sum: u32,
    /// Place in the file and checksum so far, where the frame that was read last begins.
    last: (u64, u32),
    payload: Vec<u8>,
    damages: Vec<Damage>,
    newest: NewestTimes,
    /// Times of the newest frames before the one that was read last.
    before: NewestTimes,
    /// Bytes that may still be read to find the way after damage.
    budget: u64,
    ended: bool,
}

/// Opens a recording and reads its header.
///
/// # Errors
/// The file cannot be read, is no recording, is of another version, or is damaged before its first
/// frame is over.
pub fn open(file: &Path) -> Result<(Header, Frames<BufReader<File>>), OpenError> {
    let read = |cause| OpenError::Read { file: file.into(), cause };
    let (input, size) = thenar_input::open_plain(file).map_err(|e| read(e.into()))?;
    let size = size.ok_or_else(|| read(ErrorKind::NotSeekable.into()))?;
    Frames::new(BufReader::with_capacity(1 << 16, input), size).map_err(|error| match error {
        Refused::Read(cause) => read(cause),
        Refused::Foreign => OpenError::Foreign { file: file.into() },
        // The first was 1.
        Refused::Version(0) => OpenError::NoVersion { file: file.into() },
        Refused::Version(version) => OpenError::Version { file: file.into(), version },
        Refused::Damaged(damage) => OpenError::Damaged { file: file.into(), damage },
    })
}

/// Why there are no frames.
#[derive(Debug)]
pub(crate) enum Refused {
    Read(io::Error),
    Foreign,
    Version(u32),
    Damaged(Damage),
}

impl<R: Read + Seek> Frames<R> {
    /// Reads prologue and header of a file of `size` bytes.
    pub(crate) fn new(mut input: R, size: u64) -> Result<(Header, Self), Refused> {
        let mut prologue = [0; PROLOGUE_BYTES];
        let got = read_up_to(&mut input, &mut prologue).map_err(Refused::Read)?;
        if got < MAGIC.len() || &prologue[..8] != MAGIC {
            return Err(Refused::Foreign);
        }
        let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|k| prologue[at + k]));
        let damaged =
            |fault| Refused::Damaged(Damage { offset: 0, fault, lost_bytes: size, resumed: false });
        if got < PROLOGUE_BYTES {
            return Err(damaged(Fault::CutOff));
        }
        // A flipped bit must not look like another version.
        if crc32fast::hash(&prologue[..12]) != word(12) {
            return Err(damaged(Fault::Checksum));
        }
        if word(8) != VERSION {
            return Err(Refused::Version(word(8)));
        }
        let mut frames = Self {
            input,
            size,
            at: PROLOGUE_BYTES as u64,
            sum: word(12),
            last: (PROLOGUE_BYTES as u64, word(12)),
            payload: Vec::new(),
            damages: Vec::new(),
            newest: NewestTimes::default(),
            before: NewestTimes::default(),
            budget: size.saturating_mul(16).saturating_add(1 << 26),
            ended: false,
        };
        let at = frames.at;
        let lost_bytes = size.saturating_sub(at);
        let unusable =
            |fault| Refused::Damaged(Damage { offset: at, fault, lost_bytes, resumed: false });
        if let Err(fault) = frames.read().map_err(Refused::Read)? {
            return Err(unusable(fault));
        }
        frames.at += (HEAD_BYTES + frames.payload.len()) as u64;
        let first =
            Frame::of(&frames.payload).filter(|first| first.kind == Some(FrameKind::Header));
        let header = first.and_then(|frame| serde_json::from_slice(frame.body).ok());
        header.map(|header| (header, frames)).ok_or_else(|| unusable(Fault::Header))
    }

    /// The next frame that can be trusted; `None` when there is none any more. Where some are left
    /// out [`Frames::damages`] has grown.
    ///
    /// # Errors
    /// Reading fails.
    #[allow(clippy::should_implement_trait)] // it lends its buffer
    pub fn next(&mut self) -> io::Result<Option<Frame<'_>>> {
        loop {
            if self.at >= self.size {
                return Ok(None);
            }
            self.last = (self.at, self.sum);
            match self.read()? {
                Ok(()) => break,
                Err(fault) => self.skip(fault)?,
            }
        }
        self.at += (HEAD_BYTES + self.payload.len()) as u64;
        let frame = Frame::of(&self.payload);
        if let Some(frame) = &frame {
            self.before.clone_from(&self.newest);
            self.newest.note(frame);
            self.ended |= frame.kind == Some(FrameKind::End);
        }
        Ok(frame)
    }

    /// Goes on after a damaged frame.
    fn skip(&mut self, fault: Fault) -> io::Result<()> {
        let offset = self.at;
        let Self { input, size, newest, budget, ended, .. } = self;
        let mut search = Search { input, size: *size, newest, ended: *ended, budget };
        let found = search.run(offset)?;
        let (next, sum) = found.unwrap_or((self.size, 0));
        let lost_bytes = next - offset;
        self.damages.push(Damage { offset, fault, lost_bytes, resumed: found.is_some() });
        (self.at, self.sum) = (next, sum);
        self.input.seek(SeekFrom::Start(next))?;
        Ok(())
    }

    /// Reads a frame into the buffer.
    fn read(&mut self) -> io::Result<Result<(), Fault>> {
        let mut head = [0; HEAD_BYTES];
        if read_up_to(&mut self.input, &mut head)? < HEAD_BYTES {
            return Ok(Err(Fault::CutOff));
        }
        let [length, sum] = [0, 4].map(|at| std::array::from_fn(|k| head[at + k]));
        let bytes = u32::from_le_bytes(length);
        if (bytes as usize) < PAYLOAD_BYTES_MIN || bytes > FRAME_BYTES_MAX {
            return Ok(Err(Fault::Length));
        }
        // Never more memory than there is file.
        if u64::from(bytes) > self.size.saturating_sub(self.at + HEAD_BYTES as u64) {
            return Ok(Err(Fault::CutOff));
        }
        self.payload.resize(bytes as usize, 0);
        if read_up_to(&mut self.input, &mut self.payload)? < bytes as usize {
            return Ok(Err(Fault::CutOff));
        }
        let expected = checksum(self.sum, length, &self.payload);
        if u32::from_le_bytes(sum) != expected {
            return Ok(Err(Fault::Checksum));
        }
        self.sum = expected;
        // Pieces that were moved hold together within: only time and the end's place tell.
        let end = self.at + (HEAD_BYTES + self.payload.len()) as u64;
        let is_last = |frame: &Frame| frame.kind != Some(FrameKind::End) || end == self.size;
        let in_order = |frame: Frame| self.newest.is_in_order(&frame) && is_last(&frame);
        if !self.damages.is_empty() && !Frame::of(&self.payload).is_some_and(in_order) {
            return Ok(Err(Fault::Order));
        }
        Ok(Ok(()))
    }

    /// Says that the frame that [`Frames::next`] gave last cannot stand where it does, though its
    /// checksum agrees: it counts as damage, and frames after it are not compared with it.
    pub fn reject(&mut self) {
        let (offset, _) = self.last;
        self.newest.clone_from(&self.before);
        self.damages.push(Damage {
            offset,
            fault: Fault::Content,
            lost_bytes: self.at - offset,
            resumed: self.at < self.size,
        });
    }

    /// Looks at the frames after the one that [`Frames::next`] gave last, up to one for which
    /// `look` gives something or up to damage. [`Frames::next`] goes on as if nothing had been
    /// looked at.
    ///
    /// # Errors
    /// Reading fails.
    pub fn look_ahead<T>(
        &mut self,
        mut look: impl FnMut(&Frame<'_>) -> Option<T>,
    ) -> io::Result<Option<T>> {
        let (at, sum, last, ended) = (self.at, self.sum, self.last, self.ended);
        let (newest, before, met) = (self.newest.clone(), self.before.clone(), self.damages.len());
        // What is looked at is not compared with a frame that is in doubt.
        self.newest.clone_from(&self.before);
        let seen = loop {
            match self.next()? {
                None => break None,
                Some(frame) => {
                    let seen = look(&frame);
                    if seen.is_some() || self.damages.len() > met {
                        break seen;
                    }
                }
            }
        };
        (self.at, self.sum, self.last, self.ended) = (at, sum, last, ended);
        (self.newest, self.before) = (newest, before);
        self.damages.truncate(met);
        self.input.seek(SeekFrom::Start(at))?;
        Ok(seen)
    }

    /// Place of the frame that [`Frames::next`] gave last.
    pub fn place(&self) -> FramePlace {
        let (at, sum) = self.last;
        FramePlace { at, sum, newest: self.newest.clone() }
    }

    /// Place of the next frame.
    pub fn place_of_next(&self) -> FramePlace {
        FramePlace { at: self.at, sum: self.sum, newest: self.newest.clone() }
    }

    /// Goes to a frame, which is the next one then. What is damaged elsewhere is forgotten.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn go_to(&mut self, place: &FramePlace) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(place.at))?;
        (self.at, self.sum, self.ended) = (place.at, place.sum, false);
        self.newest.clone_from(&place.newest);
        self.damages.clear();
        Ok(())
    }

    /// Damaged pieces of the file, as far as it has been read, in the order of their place.
    pub fn damages(&self) -> &[Damage] {
        &self.damages
    }

    /// True once the end frame has been read: the recording was ended as it should be.
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Offset of the next frame's start \[bytes\].
    pub fn offset(&self) -> u64 {
        self.at
    }
}

/// Fills `out` as far as the input goes.
pub(crate) fn read_up_to(input: &mut impl Read, out: &mut [u8]) -> io::Result<usize> {
    let mut got = 0;
    while got < out.len() {
        match input.read(&mut out[got..]) {
            Ok(0) => break,
            Ok(n) => got += n,
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(got)
}
