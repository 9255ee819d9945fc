//! Makes scenes ready on a thread of their own, one at a time; of several requests the last counts,
//! and ends what is being made for another.

use super::source::{Catalogue, LiveError, ReadyScene, SceneSpec};
use crate::hub::ClientId;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use thenar_rig::work::watched;

/// A request for another scene, and the client that made it.
#[derive(Clone, Debug, PartialEq)]
pub struct BuildRequest {
    /// To be told should it fail; `None` is the loop itself.
    pub client: Option<ClientId>,
    /// Description of what is built.
    pub spec: SceneSpec,
}

/// Outcome of a request.
pub type BuildResult = Result<Box<ReadyScene>, String>;

/// A scene in the making.
#[derive(Debug)]
struct BuildJob {
    request: BuildRequest,
    made: Receiver<BuildResult>,
    /// True when nobody waits for it any more.
    overtaken: Arc<AtomicBool>,
}

/// The thread, if it is at work, and what comes after.
#[derive(Debug)]
pub struct Builder {
    catalogue: Arc<Catalogue>,
    working: Option<BuildJob>,
    next: Option<BuildRequest>,
}

impl Builder {
    /// Nothing to do yet.
    pub fn new(catalogue: Catalogue) -> Self {
        Self { catalogue: Arc::new(catalogue), working: None, next: None }
    }

    /// The scenes there are.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Scene that was requested last, unless it is done.
    pub fn requested(&self) -> Option<&SceneSpec> {
        let working = self.working.as_ref().map(|work| &work.request);
        self.next.as_ref().or(working).map(|request| &request.spec)
    }

    /// Makes this instead of what is being made.
    pub fn request(&mut self, request: BuildRequest) {
        if let Some(work) = &self.working {
            work.overtaken.store(true, Ordering::Relaxed);
        }
        self.next = Some(request);
        self.begin();
    }

    /// Takes the scene made since the last call. One that another request has overtaken is dropped.
    pub fn take(&mut self) -> Option<(BuildRequest, BuildResult)> {
        let made = match self.working.as_ref()?.made.try_recv() {
            Ok(made) => made,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("the scene could not be made".into()),
        };
        let BuildJob { request, .. } = self.working.take()?;
        let overtaken = self.next.is_some();
        self.begin();
        (!overtaken).then_some((request, made))
    }

    fn begin(&mut self) {
        if self.working.is_some() {
            return;
        }
        let Some(request) = self.next.take() else { return };
        let (done, made) = channel();
        let overtaken = Arc::new(AtomicBool::new(false));
        let ended = overtaken.clone();
        let (catalogue, spec) = (self.catalogue.clone(), request.spec.clone());
        let work = move || {
            let wanted = move |_| !ended.load(Ordering::Relaxed);
            let make = || watched(wanted, || catalogue.make(&spec).map(Box::new));
            let made = match catch_unwind(AssertUnwindSafe(make)) {
                Ok(made) => made.map_err(|error: LiveError| error.to_string()),
                Err(_) => Err(format!("making the scene `{}` failed", spec.scene)),
            };
            // The loop may have ended meanwhile.
            let _ = done.send(made);
        };
        // Should no thread start, `done` is dropped and the request fails.
        let _ = std::thread::Builder::new().name("scene".into()).spawn(work);
        self.working = Some(BuildJob { request, made, overtaken });
    }
}
