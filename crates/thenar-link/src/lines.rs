//! Lines out of bytes that arrive in pieces, bounded.

/// Puts pieces of lines together. A line that is too long is left out whole.
#[derive(Debug)]
pub struct Lines {
    /// The beginning of a line whose end has not come.
    begun: Vec<u8>,
    longest: usize,
    /// The present line is too long: its rest is skipped.
    skipping: bool,
}

/// A line was longer than allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a line longer than {0} bytes")]
pub struct TooLong(pub usize);

/// A line without its end.
pub type LineResult<'a> = Result<&'a [u8], TooLong>;

impl Lines {
    /// Lines up to this length \[bytes\].
    pub fn new(longest: usize) -> Self {
        Self { begun: Vec::new(), longest, skipping: false }
    }

    /// Forgets what has begun: another peer speaks.
    pub fn clear(&mut self) {
        self.begun.clear();
        self.skipping = false;
    }

    /// Takes bytes of a stream; shows each line that ends, without its end, unless it is blank.
    pub fn push(&mut self, bytes: &[u8], show: &mut dyn FnMut(LineResult)) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            let ended = piece.last() == Some(&b'\n');
            if !self.skipping && self.begun.len() + piece.len() > self.longest + 1 {
                self.skipping = true;
                self.begun.clear();
                show(Err(TooLong(self.longest)));
            }
            if !self.skipping {
                // Most lines come in one piece and are shown where they lie.
                match (ended, self.begun.is_empty()) {
                    (true, true) => line(piece, show),
                    (true, false) => {
                        self.begun.extend_from_slice(piece);
                        line(&self.begun, show);
                        self.begun.clear();
                    }
                    (false, _) => self.begun.extend_from_slice(piece),
                }
            }
            self.skipping &= !ended;
        }
    }

    /// Takes a whole message, or bytes of a stream.
    pub fn take(&mut self, whole: bool, bytes: &[u8], show: &mut dyn FnMut(LineResult)) {
        match whole {
            true => self.datagram(bytes, show),
            false => self.push(bytes, show),
        }
    }

    /// Takes a whole datagram: its end also ends its last line.
    pub fn datagram(&mut self, bytes: &[u8], show: &mut dyn FnMut(LineResult)) {
        self.clear();
        self.push(bytes, show);
        if !self.begun.is_empty() {
            line(&self.begun, show);
        }
        self.clear();
    }
}

fn line(bytes: &[u8], show: &mut dyn FnMut(LineResult)) {
    let bytes = bytes.trim_ascii();
    if !bytes.is_empty() {
        show(Ok(bytes));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn collect(pieces: &[&[u8]], datagrams: bool) -> Vec<String> {
        let mut lines = Lines::new(8);
        let mut seen = Vec::new();
        let mut show = |line: LineResult| {
            seen.push(match line {
                Ok(line) => String::from_utf8_lossy(line).into_owned(),
                Err(_) => "too long".into(),
            });
        };
        for piece in pieces {
            if datagrams {
                lines.datagram(piece, &mut show);
            } else {
                lines.push(piece, &mut show);
            }
            assert!(lines.begun.capacity() <= 64);
        }
        seen
    }

    #[test]
    fn lines_are_the_same_wherever_the_stream_is_cut() {
        let text = b"one\n\r\ntwo \r\n12345678\n123456789\nthis is far too long\nlast\nrest";
        let want = ["one", "two", "12345678", "too long", "too long", "last"];
        assert_eq!(collect(&[text], false), want);
        for a in 0..text.len() {
            for b in a..text.len() {
                assert_eq!(collect(&[&text[..a], &text[a..b], &text[b..]], false), want);
            }
        }
        let bytes: Vec<_> = text.chunks(1).collect();
        assert_eq!(collect(&bytes, false), want);
    }

    #[test]
    fn a_datagram_is_whole() {
        assert_eq!(collect(&[b"a\nb", b"c"], true), ["a", "b", "c"]);
        assert_eq!(collect(&[b"0123456789", b"d\n"], true), ["too long", "d"]);
        assert_eq!(collect(&[b"", b"\n\n"], true), [""; 0]);
    }
}
