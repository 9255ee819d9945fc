//! Goal: a recorded session is made again with the same bits, from its beginning and from any
//! keyframe: poses, losses, hands that are led, settings, restarts and files that its scene names
//! included; and damage to the file costs no more than `docs/recording.md` says. Method: sessions
//! are recorded while all that enters them, replayed, and compared step by step by hash.

mod bits;
mod damage;
mod difference;
mod fuzz;
mod old_words;
mod stage;
mod tampered;
