//! Forces that last only while the page that armed them is there.
//!
//! A page that arms is asked four times a second, by the report on its devices, whether it still
//! lives, and answers each with `hold`. Its socket's end, or its silence, ends the forces: a
//! page that nobody can press Stop on any more is no page. All of this happens beside the
//! simulation, which may stand still.

use crate::hub::ClientId;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use thenar_link::haptic_loop::{Remote, Status};

/// A page that says nothing for so long has gone.
pub const SILENCE_MAX: Duration = Duration::from_secs(3);

/// The client that armed, and when it was heard last.
#[derive(Clone, Copy, Debug)]
struct Holder {
    client: ClientId,
    heard: Instant,
}

/// Arms and stops devices for clients; cheap to clone.
#[derive(Clone, Debug)]
pub struct DeadMan {
    remote: Remote,
    holder: Arc<Mutex<Option<Holder>>>,
}

impl DeadMan {
    /// Over the loop that this is the remote of.
    pub fn new(remote: Remote) -> Self {
        Self { remote, holder: Arc::default() }
    }

    /// Arms for this client; with `keep` beyond its leaving.
    pub fn arm(&self, client: ClientId, keep: bool, now: Instant) {
        let mut holder = self.holder();
        *holder = (!keep).then_some(Holder { client, heard: now });
        self.remote.arm();
    }

    /// Stops at once, whoever armed.
    pub fn stop(&self) {
        let mut holder = self.holder();
        *holder = None;
        self.remote.stop();
    }

    /// This client is still there.
    pub fn hold(&self, client: ClientId, now: Instant) {
        if let Some(holder) = self.holder().as_mut().filter(|holder| holder.client == client) {
            holder.heard = now;
        }
    }

    /// This client has left: if it armed, forces fade.
    pub fn leave(&self, client: ClientId) {
        self.let_go_if(|holder| holder.client == client, Remote::abandon);
    }

    /// If who armed has been silent for too long, forces fade.
    pub fn look(&self, now: Instant) {
        let silent = |holder: &Holder| now.saturating_duration_since(holder.heard) > SILENCE_MAX;
        self.let_go_if(silent, Remote::unanswered);
    }

    /// The client whose presence the forces need.
    pub fn armed_by(&self) -> Option<ClientId> {
        self.holder().map(|holder| holder.client)
    }

    /// Status of the devices.
    pub fn status(&self) -> Status {
        self.remote.status()
    }

    fn let_go_if(&self, gone: impl Fn(&Holder) -> bool, tell: impl Fn(&Remote)) {
        let mut holder = self.holder();
        if holder.as_ref().is_some_and(gone) {
            *holder = None;
            tell(&self.remote);
        }
    }

    /// Locks the holder; after a panic too, as its contents are always whole.
    fn holder(&self) -> MutexGuard<'_, Option<Holder>> {
        self.holder.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_link::haptic_loop::{ManualLoop, Settings};

    const A: ClientId = ClientId(1);
    const B: ClientId = ClientId(2);

    /// A loop without devices: it knows all the same whether it was stopped, and why.
    struct Bench {
        clock: ManualLoop,
        switch: DeadMan,
        begun: Instant,
        ticks: u64,
    }

    impl Bench {
        fn new() -> Self {
            let clock = ManualLoop::new(&Settings::default(), Vec::new(), Vec::new()).unwrap();
            let switch = DeadMan::new(clock.remote());
            Self { clock, switch, begun: Instant::now(), ticks: 0 }
        }

        fn at(&self, seconds: f64) -> Instant {
            self.begun + Duration::from_secs_f64(seconds)
        }

        /// Why forces are stopped now, if they are.
        fn stopped(&mut self) -> Option<String> {
            self.ticks += 1;
            self.clock.tick(self.ticks * 1_000_000);
            self.clock.core(|core| core.tripped().map(|reason| reason.to_string()))
        }
    }

    fn told(reason: Option<String>, text: &str) -> bool {
        reason.is_some_and(|reason| reason.starts_with(text))
    }

    #[test]
    fn forces_end_with_the_client_that_armed_and_no_other() {
        let mut bench = Bench::new();
        bench.switch.arm(A, false, bench.begun);
        bench.switch.leave(B);
        assert_eq!((bench.stopped(), bench.switch.armed_by()), (None, Some(A)));
        bench.switch.leave(A);
        assert!(
            told(bench.stopped(), "whoever armed it has gone") && bench.switch.armed_by().is_none()
        );
        // Whoever arms next takes it over.
        bench.switch.arm(B, false, bench.begun);
        bench.switch.leave(A);
        assert_eq!((bench.stopped(), bench.switch.armed_by()), (None, Some(B)));
    }

    #[test]
    fn silence_ends_them_and_only_who_armed_can_break_it() {
        let mut bench = Bench::new();
        bench.switch.arm(A, false, bench.begun);
        for tenth in 1..100 {
            let now = bench.at(0.1 * f64::from(tenth));
            if tenth <= 50 {
                bench.switch.hold(A, now);
            }
            bench.switch.hold(B, now);
            bench.switch.look(now);
            let silent = told(bench.stopped(), "whoever armed it no longer answers");
            assert_eq!(silent, tenth > 80, "{tenth}");
        }
    }

    #[test]
    fn who_keeps_them_on_may_go() {
        let mut bench = Bench::new();
        bench.switch.arm(A, true, bench.begun);
        bench.switch.look(bench.at(60.0));
        bench.switch.leave(A);
        assert_eq!((bench.stopped(), bench.switch.armed_by()), (None, None));
        bench.switch.stop();
        assert_eq!(bench.stopped().as_deref(), Some("stop was asked for"));
    }

    #[test]
    fn leaving_after_a_stop_changes_nothing() {
        let mut bench = Bench::new();
        bench.switch.arm(A, false, bench.begun);
        assert_eq!(bench.stopped(), None);
        bench.switch.stop();
        bench.switch.leave(A);
        assert_eq!(bench.stopped().as_deref(), Some("stop was asked for"));
    }
}
