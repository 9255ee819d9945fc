#![no_main]
use thenar_scene::live::{LivePose, checked};
use thenar_serve::protocol::{Command, PoseBody, PoseMessage};

// What a page, or any program in its place, sends: poses as bytes, commands as text.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(message) = PoseMessage::read(bytes) {
        let pose = match message.body {
            PoseBody::Joints { poses, radii } => LivePose::Joints { joints: *poses, radii: *radii },
            PoseBody::Angles { wrist, angles } => LivePose::Angles { wrist, angles: *angles },
            PoseBody::Lost => return,
        };
        // What is read is a pose of a hand nearby.
        assert!(checked(message.clock, &pose).is_ok(), "{pose:?}");
    }
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Err(cause) = Command::read(text)
    {
        assert!(cause.len() < bytes.len() + 2000, "{} characters", cause.len());
    }
});
