//! Frames are come back to, in whole files and in damaged ones.

use crate::{Place, starts, write};
use thenar_record::open;

/// All frames from here on.
fn rest(frames: &mut thenar_record::Frames<impl std::io::Read + std::io::Seek>) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    while let Some(frame) = frames.next().unwrap() {
        all.push(frame.body.to_vec());
    }
    all
}

#[test]
fn from_any_frame_the_same_frames_follow() {
    for damaged in [false, true] {
        let file = Place::new(&format!("places-{damaged}"));
        write(&file.0);
        if damaged {
            let mut bytes = std::fs::read(&file.0).unwrap();
            // Within the last step.
            let starts = starts(&bytes);
            let [step, end] = [3, 2].map(|k| starts[starts.len() - k]);
            bytes[usize::midpoint(step, end)] ^= 1;
            std::fs::write(&file.0, bytes).unwrap();
        }
        let (_, mut frames) = open(&file.0).unwrap();
        let mut places = Vec::new();
        let mut all = Vec::new();
        while let Some(frame) = frames.next().unwrap() {
            all.push(frame.body.to_vec());
            places.push(frames.place());
        }
        assert_eq!((frames.damages().len(), frames.ended()), (usize::from(damaged), true));
        assert_eq!(all.len(), 5 - usize::from(damaged), "a scene, three steps, the end");
        assert!(places.is_sorted_by_key(|place| place.offset()));
        // Backwards, so that each is come back to from behind it.
        for (k, place) in places.iter().enumerate().rev() {
            frames.go_to(place).unwrap();
            assert_eq!(rest(&mut frames), all[k..], "{damaged} {k}");
            assert!(frames.ended());
        }
        assert_eq!(frames.damages().len(), usize::from(damaged), "it lies behind the first frame");
        frames.go_to(&places[1]).unwrap();
        let next = frames.place_of_next();
        frames.next().unwrap();
        assert_eq!(frames.place().offset(), next.offset());
    }
}
