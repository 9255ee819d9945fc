//! Commands that a glove needs before it streams, in its pace, and again when it falls silent.

/// Listens this long to a glove that may stream already \[ns\].
const LISTEN_NS: u64 = 100_000_000;

/// Between two words, since a glove has a small buffer \[ns\].
const PACE_NS: u64 = 20_000_000;
/// A stream that pauses for so long has ended \[ns\].
const SILENCE_NS: u64 = 1_000_000_000;

/// The conversation up to the stream.
#[derive(Clone, Debug)]
pub struct Handshake {
    words: &'static [&'static [u8]],
    /// The next word and when it is due; `None` while the glove streams or has been told all.
    next: Option<(usize, u64)>,
    /// Time of the last word, the glove's or ours.
    heard_ns: u64,
    streams: bool,
}

impl Handshake {
    /// A dialogue of `words`, with a pause between them, repeated after a silence.
    pub fn new(words: &'static [&'static [u8]]) -> Self {
        Self { words, next: None, heard_ns: 0, streams: false }
    }

    /// Says them from the first, at once.
    pub fn begin(&mut self, now_ns: u64) {
        (self.next, self.heard_ns, self.streams) = (Some((0, now_ns)), now_ns, false);
    }

    /// Says them unless the glove is heard before.
    pub fn listen(&mut self, now_ns: u64) {
        self.begin(now_ns);
        self.next = Some((0, now_ns + LISTEN_NS));
    }

    /// The glove said something that made sense.
    pub fn heard(&mut self, now_ns: u64) {
        (self.next, self.heard_ns, self.streams) = (None, now_ns, true);
    }

    /// True once it was heard.
    pub fn streams(&self) -> bool {
        self.streams
    }

    /// Says what is due.
    pub fn tick(&mut self, now_ns: u64, send: &mut dyn FnMut(&[u8])) {
        match self.next {
            Some((word, due_ns)) if now_ns >= due_ns => {
                send(self.words[word]);
                self.heard_ns = now_ns;
                let following = Some((word + 1, now_ns + PACE_NS));
                self.next = following.filter(|(word, _)| *word < self.words.len());
            }
            None if now_ns.saturating_sub(self.heard_ns) > SILENCE_NS => self.begin(now_ns),
            _ => {}
        }
    }
}
