//! Goal: a recording gives back what went in; of a damaged one all that came before the damage and
//! what can be trusted after it, and nothing else. Method: small files, cut at every byte, with
//! every bit flipped, with every byte missing, and with seeded havoc.

mod places;

use std::path::{Path, PathBuf};
use thenar_record::{
    Build, Channel, ChannelInfo, Damage, Fault, Field, FrameKind, Gap, Header, OpenError, Record,
    RecordError, Recorder, Weight, open,
};
use thenar_testing::Mutator;

/// A file of its own for each test.
struct Place(PathBuf);

impl Place {
    fn new(name: &str) -> Self {
        let file = format!("thenar-record-{name}-{}.rec", std::process::id());
        let path = std::env::temp_dir().join(file);
        let _ = std::fs::remove_file(&path);
        Self(path)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn header() -> Header {
    Header {
        program: "thenar 9.9.9".into(),
        build: Build { bytes: 7, crc32: 8 },
        vectors: "Avx512".into(),
        system: "linux x86_64".into(),
        created_unix_ns: 1_700_000_000_000_000_000,
        simulated_time: false,
    }
}

/// Kind, time and body of all frames after the header, and how the file ends.
type Content = (Vec<Known>, Option<Damage>, bool);

/// Kind, time and body.
type Known = (Option<FrameKind>, u64, Vec<u8>);

/// Of a file with one piece of damage at most.
fn content(file: &Path) -> Result<Content, OpenError> {
    let (found, mut frames) = open(file)?;
    assert_eq!(found, header());
    let mut all = Vec::new();
    while let Some(frame) = frames.next().unwrap() {
        all.push((frame.kind, frame.time_ns, frame.body.to_vec()));
    }
    assert!(frames.damages().len() < 2);
    Ok((all, frames.damages().first().copied(), frames.ended()))
}

/// Writes a scene, a few steps and a channel.
fn write(file: &Path) {
    let recorder = Recorder::create(file, &header()).unwrap();
    let mut writer = recorder.session();
    assert!(writer.big_frame(FrameKind::Scene, 1, |body| body.extend(b"a scene")));
    for k in 0..3_u8 {
        let step = |body: &mut Vec<u8>| body.extend([k; 8]);
        assert!(writer.frame(FrameKind::Step, 10 + u64::from(k), Weight::Usual, step));
    }
    drop(writer);
    recorder.finish().unwrap();
}

#[test]
fn what_goes_in_comes_out_in_order() {
    let place = Place::new("order");
    write(&place.0);
    let (frames, damage, ended) = content(&place.0).unwrap();
    assert_eq!((damage, ended), (None, true));
    let kinds: Vec<_> = frames.iter().map(|f| f.0.unwrap()).collect();
    assert_eq!(
        kinds,
        [FrameKind::Scene, FrameKind::Step, FrameKind::Step, FrameKind::Step, FrameKind::End]
    );
    assert_eq!((frames[0].1, &frames[0].2[..]), (1, &b"a scene"[..]));
    for k in 0..3_u8 {
        let frame = &frames[1 + k as usize];
        assert_eq!((frame.1, &frame.2[..]), (10 + u64::from(k), &[k; 8][..]));
    }
}

#[test]
fn a_file_that_is_there_stays() {
    let place = Place::new("there");
    std::fs::write(&place.0, b"precious").unwrap();
    let error = Recorder::create(&place.0, &header()).unwrap_err();
    assert!(matches!(error, RecordError::Exists(_)), "{error}");
    assert_eq!(std::fs::read(&place.0).unwrap(), b"precious");
}

/// Where frames begin, the end of the file included.
fn starts(bytes: &[u8]) -> Vec<usize> {
    let mut starts = vec![16];
    while *starts.last().unwrap() < bytes.len() {
        let at = *starts.last().unwrap();
        let length = u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        starts.push(at + 8 + length as usize);
    }
    starts
}

#[test]
fn cut_anywhere_it_keeps_all_whole_frames_and_says_where_it_was_cut() {
    let place = Place::new("cut");
    write(&place.0);
    let whole = std::fs::read(&place.0).unwrap();
    let (frames, ..) = content(&place.0).unwrap();
    let starts = starts(&whole);
    for size in 0..whole.len() {
        std::fs::write(&place.0, &whole[..size]).unwrap();
        let found = content(&place.0);
        // Header and prologue are needed.
        if size < starts[1] {
            let error = found.unwrap_err();
            let expected = match error {
                OpenError::Foreign { .. } => size < 8,
                OpenError::Damaged { .. } => size >= 8,
                _ => false,
            };
            assert!(expected, "{size}: {error}");
            continue;
        }
        let (kept, damage, ended) = found.unwrap();
        let last = starts.iter().rposition(|start| *start <= size).unwrap();
        assert_eq!(kept, frames[..last - 1], "{size}");
        assert!(!ended);
        let offset = starts[last] as u64;
        let lost_bytes = size as u64 - offset;
        let expected = (lost_bytes > 0).then_some((offset, Fault::CutOff, lost_bytes));
        assert_eq!(damage.map(|d| (d.offset, d.fault, d.lost_bytes)), expected, "{size}");
    }
}

#[test]
fn a_flipped_bit_costs_nothing_before_it_and_is_never_believed() {
    let place = Place::new("flip");
    write(&place.0);
    let whole = std::fs::read(&place.0).unwrap();
    let (frames, ..) = content(&place.0).unwrap();
    let starts = starts(&whole);
    for bit in 0..8 * whole.len() {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&place.0, &bytes).unwrap();
        let hit = starts.iter().rposition(|start| *start <= bit / 8);
        match (hit, content(&place.0)) {
            (None | Some(0), found) => {
                let error = found.unwrap_err();
                assert!(!matches!(error, OpenError::Version { .. }), "{bit}: {error}");
            }
            (Some(hit), found) => {
                let (kept, damage, ended) = found.unwrap();
                let damage = damage.unwrap();
                assert_eq!(damage.offset, starts[hit] as u64, "{bit}");
                // The frame before the first that is trusted must be whole in its head: with a
                // flip in length or checksum that is the next one, else the damaged one.
                let in_head = bit / 8 - starts[hit] < 8;
                let next = hit + if in_head { 2 } else { 1 };
                // Frame 0 is the header; the last start is the end of the file.
                let after = frames.get(next - 1..).unwrap_or_default();
                assert_eq!(kept, [&frames[..hit - 1], after].concat(), "{bit}");
                assert_eq!((ended, damage.resumed), (!after.is_empty(), !after.is_empty()));
                let resumed = if after.is_empty() { whole.len() } else { starts[next] };
                assert_eq!(damage.lost_bytes as usize, resumed - starts[hit], "{bit}");
            }
        }
    }
}

#[test]
fn frames_that_are_moved_left_out_or_repeated_are_damage() {
    let place = Place::new("moved");
    write(&place.0);
    let whole = std::fs::read(&place.0).unwrap();
    let starts = starts(&whole);
    let piece = |k: usize| &whole[starts[k]..starts[k + 1]];
    let [head, a, b] = [&whole[..starts[2]], piece(2), piece(3)];
    let (frames, ..) = content_of(&place.0);
    let rest = &whole[starts[4]..];
    // Of what follows the damage the first whole frame is only a beginning.
    for (middle, kept) in [
        (vec![b, a, rest], vec![0, 4]),
        (vec![b, rest], vec![0, 3, 4]),
        (vec![a, a, b, rest], vec![0, 1, 2, 3, 4]),
        // A piece from before, of two frames: its times are past.
        (vec![a, b, a, b, rest], vec![0, 1, 2, 3, 4]),
        // A piece from behind, with the mark of the end where no end is.
        (vec![rest, a, b, rest], vec![0, 2, 3, 4]),
    ] {
        std::fs::write(&place.0, [&[head][..], &middle].concat().concat()).unwrap();
        let (found, damages) = content_of(&place.0);
        let expected: Vec<Known> = kept.iter().map(|k: &usize| frames[*k].clone()).collect();
        assert_eq!(found, expected);
        assert_eq!(damages[0].fault, Fault::Checksum);
    }
}

/// Frames and all damage.
fn content_of(file: &Path) -> (Vec<Known>, Vec<Damage>) {
    let (_, mut frames) = open(file).unwrap();
    let mut all = Vec::new();
    while let Some(frame) = frames.next().unwrap() {
        all.push((frame.kind, frame.time_ns, frame.body.to_vec()));
    }
    (all, frames.damages().to_vec())
}

#[test]
fn bytes_that_are_missing_or_added_cost_what_they_touch_only() {
    let place = Place::new("shift");
    write(&place.0);
    let whole = std::fs::read(&place.0).unwrap();
    let (frames, _) = content_of(&place.0);
    let starts = starts(&whole);
    for at in starts[1]..whole.len() {
        for missing in [true, false] {
            let tail = if missing { &whole[at + 1..] } else { &whole[at..] };
            let extra = [0xa5];
            let middle: &[u8] = if missing { &[] } else { &extra };
            std::fs::write(&place.0, [&whole[..at], middle, tail].concat()).unwrap();
            let (found, damages) = content_of(&place.0);
            let hit = starts.iter().rposition(|start| *start <= at).unwrap();
            // All before; the frame that is hit goes, and at most one more.
            assert_eq!(found[..hit - 1], frames[..hit - 1], "{at}");
            let after = &found[hit - 1..];
            assert!(frames.ends_with(after), "{at}");
            assert!(after.len() + hit + 2 > frames.len(), "{at}: {} after {hit}", after.len());
            assert!(!damages.is_empty());
        }
    }
}

#[test]
fn what_follows_a_large_hole_is_found_and_a_trap_takes_no_time() {
    let place = Place::new("hole");
    let recorder = Recorder::create(&place.0, &header()).unwrap();
    let mut writer = recorder.session();
    for k in 0..400_u64 {
        let body = |body: &mut Vec<u8>| body.extend(k.to_le_bytes().repeat(64));
        assert!(writer.frame(FrameKind::Keyframe, k, Weight::Heavy, body));
    }
    drop(writer);
    recorder.finish().unwrap();
    let whole = std::fs::read(&place.0).unwrap();
    let starts = starts(&whole);
    let (frames, _) = content_of(&place.0);
    // 100 kB are overwritten, across several of the search's windows: with nothing, and with heads
    // that each look like a frame which reaches to the end of the file.
    let hole = starts[50] + 3..starts[250] + 5;
    for trap in [false, true] {
        let mut bytes = whole.clone();
        bytes[hole.clone()].fill(0);
        for at in hole.clone().step_by(13).filter(|at| trap && at + 13 < hole.end) {
            let length = (whole.len() - at) as u32 / 2;
            bytes[at..at + 4].copy_from_slice(&length.to_le_bytes());
            bytes[at + 8] = FrameKind::Step as u8;
        }
        std::fs::write(&place.0, &bytes).unwrap();
        let (found, damages) = content_of(&place.0);
        assert_eq!(found[..49], frames[..49]);
        assert_eq!(found[49..], frames[251..]);
        assert_eq!(damages.len(), 1);
        assert!(damages[0].resumed && damages[0].offset == starts[50] as u64);
        assert_eq!(damages[0].offset + damages[0].lost_bytes, starts[252] as u64);
    }
}

#[test]
fn a_later_version_is_refused_by_name_and_other_files_as_what_they_are() {
    let place = Place::new("version");
    write(&place.0);
    let mut bytes = std::fs::read(&place.0).unwrap();
    let mut of_version = |version: u8| {
        bytes[8] = version;
        let sum = crc32(&bytes[..12]);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        std::fs::write(&place.0, &bytes).unwrap();
        open(&place.0).unwrap_err()
    };
    let error = of_version(7);
    assert!(matches!(error, OpenError::Version { version: 7, .. }));
    assert!(error.to_string().contains("format version 7; this program reads version 1"));
    // There was none before the first.
    let error = of_version(0);
    assert!(matches!(error, OpenError::NoVersion { .. }));
    let told = error.to_string();
    assert!(told.contains("is damaged") && !told.contains("later version"), "{told}");
    std::fs::write(&place.0, b"PK\x03\x04 something else entirely").unwrap();
    assert!(matches!(open(&place.0).unwrap_err(), OpenError::Foreign { .. }));
}

/// CRC-32 (IEEE 802.3) bit by bit, apart from the crate in use.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg())
        })
    })
}

#[test]
fn channels_keep_every_number_and_may_be_empty() {
    let place = Place::new("channel");
    let mut recorder = Recorder::create(&place.0, &header()).unwrap();
    let fields = [Field::new("force", "N"), Field::new("period", "s")];
    let mut haptic: Channel = recorder.channel("haptic", &fields, 100);
    let mut marks = recorder.channel("marks", &[], 100);
    let values = |k: u64| [f64::from_bits(0x7ff8_0000_0000_0001), 1e-3 * k as f64];
    for k in 0..50 {
        assert!(haptic.record(k, &values(k)));
        assert!(!k.is_multiple_of(10) || marks.record(k, &[]));
    }
    recorder.finish().unwrap();
    let (frames, ..) = content(&place.0).unwrap();
    let infos: Vec<ChannelInfo> = frames
        .iter()
        .filter(|f| f.0 == Some(FrameKind::Channel))
        .map(|f| serde_json::from_slice(&f.2).unwrap())
        .collect();
    assert_eq!((infos[0].id, &infos[0].fields[..], infos[1].fields.len()), (1, &fields[..], 0));
    let of = |id: u32| {
        frames.iter().filter(move |f| {
            f.0 == Some(FrameKind::Record) && Record::read(&f.2).unwrap().channel == id
        })
    };
    assert_eq!((of(1).count(), of(2).count()), (50, 5));
    for (k, frame) in of(1).enumerate() {
        let got: Vec<u64> = Record::read(&frame.2).unwrap().values().map(f64::to_bits).collect();
        assert_eq!((frame.1, got), (k as u64, values(k as u64).map(f64::to_bits).to_vec()));
    }
}

#[test]
fn what_no_longer_fits_is_counted_and_the_file_says_so() {
    let place = Place::new("full");
    let mut recorder = Recorder::create(&place.0, &header()).unwrap();
    let mut channel = recorder.channel("fast", &[Field::new("x", "1")], 1);
    // The ring holds 4 KiB and is emptied every 10 ms: most of these find it full.
    let taken = (0..100_000_u64).filter(|k| channel.record(*k, &[*k as f64])).count() as u64;
    let dropped = channel.dropped();
    assert!(dropped > 0 && taken + dropped == 100_000, "{taken} {dropped}");
    drop(channel);
    recorder.finish().unwrap();
    let (frames, damage, ended) = content(&place.0).unwrap();
    assert!(damage.is_none() && ended);
    let count = |kind| frames.iter().filter(move |f| f.0 == Some(kind));
    assert_eq!(count(FrameKind::Record).count() as u64, taken);
    let told: u64 = count(FrameKind::Gap).map(|f| Gap::read(&f.2).unwrap().frames).sum();
    assert_eq!(told, dropped);
}

#[test]
fn havoc_never_makes_it_panic_or_invent_a_frame() {
    let place = Place::new("havoc");
    write(&place.0);
    let whole = std::fs::read(&place.0).unwrap();
    let (frames, ..) = content(&place.0).unwrap();
    let mut mutator = Mutator::new(0x5eed);
    let mut random = |n: usize| mutator.below(n);
    for round in 0..2000 {
        let mut bytes = whole.clone();
        for _ in 0..=random(4) {
            let (a, b) = (random(bytes.len()), random(bytes.len()));
            let (low, high) = (a.min(b), a.max(b));
            match random(5) {
                0 => bytes.truncate(high.max(1)),
                1 => bytes[a] = random(256) as u8,
                2 => bytes[low..high].fill(0),
                3 => drop(bytes.drain(low..high.min(bytes.len() - 1))),
                _ => {
                    let piece = bytes[low..high].to_vec();
                    bytes.splice(a..a, piece);
                }
            }
        }
        std::fs::write(&place.0, &bytes).unwrap();
        let Ok((_, mut read)) = open(&place.0) else { continue };
        // What is read is what was written, in its order.
        let mut known = frames.iter();
        while let Some(frame) = read.next().unwrap() {
            let same = |f: &&Known| (f.0, f.1, &f.2[..]) == (frame.kind, frame.time_ns, frame.body);
            assert!(known.any(|f| same(&f)), "round {round}");
        }
        let lost: u64 = read.damages().iter().map(|damage| damage.lost_bytes).sum();
        assert!(lost <= bytes.len() as u64);
    }
}
