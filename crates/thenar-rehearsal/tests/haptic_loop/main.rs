//! Goal: whatever trackers, devices and the simulation do, the loop ticks on, forces are continuous
//! and bounded, and go to zero when there is no ground for them. Method: devices in memory; the
//! loop on a made-up clock for what is timed, on its own threads for what is about threads.

mod capture;
mod default_mode;
mod drift;
mod empty_air;
mod faults;
mod free_motion;
mod glitch;
mod held;
mod in_place;
mod incident;
mod loose_hand;
mod matrix;
mod noise;
mod noisy_hand;
mod onset;
mod rig;
mod scripted;
mod several;
mod smooth;
mod stiffness;
mod threads;
mod turning;
mod unanswered;
mod whole_hand;
mod wrench;
