//! The program as a user runs it, in one binary: `cargo test -p thenar-cli --test all sweep::` runs
//! a part. Apart stand `devices` and `touch`, which are timed.

#[cfg(unix)]
mod cache;
mod command_line;
mod compare;
mod documented;
mod inputs;
mod last_line;
mod outputs;
mod recording;
mod serving;
mod stage;
mod sweep;
