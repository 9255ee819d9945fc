//! Replies: files of the page, refusals, and the headers that fence the page in.

use super::guard::{self, Refusal};
use super::site::{Access, Site};
use crate::page::{self, Asset};
use bytes::Bytes;
use http_body_util::Full;
use hyper::header::{
    ACCEPT_ENCODING, ALLOW, CACHE_CONTROL, CONNECTION, CONTENT_ENCODING, CONTENT_SECURITY_POLICY,
    CONTENT_TYPE, ETAG, HeaderName, HeaderValue, IF_NONE_MATCH, LOCATION, SET_COOKIE, VARY,
};
use hyper::http::request::Parts;
use hyper::{HeaderMap, Response, StatusCode};

/// A whole reply.
pub type Reply = Response<Full<Bytes>>;

/// Headers of every reply. Isolation lets the page use threads in WebAssembly and keeps other
/// sites from holding it; no other origin may embed or read anything.
const FENCE: [(HeaderName, &str); 6] = [
    (HeaderName::from_static("x-content-type-options"), "nosniff"),
    (HeaderName::from_static("referrer-policy"), "no-referrer"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-embedder-policy"), "require-corp"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    (
        HeaderName::from_static("permissions-policy"),
        "camera=(self), xr-spatial-tracking=(self), microphone=(), geolocation=(), payment=(), usb=()",
    ),
];

/// A short text.
pub fn text(status: StatusCode, text: &str) -> Reply {
    let mut reply = Response::new(Full::from(format!("{text}\n")));
    *reply.status_mut() = status;
    let headers = reply.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8"));
    headers.insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    reply
}

/// A refusal ends the connection.
pub fn refuse(refusal: &Refusal) -> Reply {
    let mut reply = text(refusal.0, refusal.1);
    reply.headers_mut().insert(CONNECTION, HeaderValue::from_static("close"));
    reply
}

/// Nothing is changed over HTTP.
pub fn wrong_method() -> Reply {
    let wrong = Refusal(StatusCode::METHOD_NOT_ALLOWED, "Only GET and HEAD are answered here.");
    let mut reply = refuse(&wrong);
    reply.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
    reply
}

/// Hands over the cookie and leads to the page without the token in its address.
pub fn pair(access: &Access) -> Reply {
    let mut reply = text(StatusCode::SEE_OTHER, "Paired.");
    reply.headers_mut().insert(LOCATION, HeaderValue::from_static("/"));
    if let Access::Lan { token, cookie, .. } = access {
        let cookie =
            format!("{cookie}={}; Path=/; HttpOnly; SameSite=Strict; Secure", token.text());
        if let Ok(cookie) = HeaderValue::try_from(cookie) {
            reply.headers_mut().insert(SET_COOKIE, cookie);
        }
    }
    reply
}

/// A file of the page. Paths are looked up as they are, so none leads anywhere else.
pub fn file(site: &Site, request: &Parts) -> Reply {
    let Some(asset) = site.assets.get(request.uri.path()) else {
        return text(StatusCode::NOT_FOUND, "There is no such file.");
    };
    let mut reply = match lists(&request.headers, IF_NONE_MATCH, &asset.tag) {
        true => {
            let mut reply = Reply::default();
            *reply.status_mut() = StatusCode::NOT_MODIFIED;
            reply
        }
        false => whole(site, asset, request),
    };
    let headers = reply.headers_mut();
    headers.insert(
        CACHE_CONTROL,
        HeaderValue::from_static(match asset.lasting {
            true => "private, max-age=31536000, immutable",
            false => "no-cache",
        }),
    );
    if let Ok(tag) = HeaderValue::try_from(&asset.tag) {
        headers.insert(ETAG, tag);
    }
    if asset.gzipped {
        headers.insert(VARY, HeaderValue::from_name(ACCEPT_ENCODING));
    }
    reply
}

fn whole(site: &Site, asset: &Asset, request: &Parts) -> Reply {
    let gzip = asset.gzipped && lists(&request.headers, ACCEPT_ENCODING, "gzip");
    let bytes = match asset.names_socket {
        true => naming_socket(site, asset, request),
        false if gzip => Bytes::from_static(asset.bytes),
        // Programs that are no browsers.
        false => asset.plain(),
    };
    let mut reply = Response::new(Full::from(bytes));
    let headers = reply.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(asset.media_type));
    if gzip {
        headers.insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    reply
}

/// The plain page, told where the visitor finds the socket.
fn naming_socket(site: &Site, asset: &Asset, request: &Parts) -> Bytes {
    let scheme = if matches!(site.access, Access::Loopback) { "ws" } else { "wss" };
    let host = guard::host(&request.headers).unwrap_or_default();
    let text = String::from_utf8_lossy(asset.bytes);
    text.replace(page::SOCKET, &format!("{scheme}://{host}/live")).into()
}

/// True if a header with a list names this, and does not rule it out.
fn lists(headers: &HeaderMap, name: HeaderName, wanted: &str) -> bool {
    let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    values.flat_map(|value| value.split(',')).any(|item| {
        let (item, quality) = item.split_once(';').unwrap_or((item, ""));
        let ruled_out = quality.trim().strip_prefix("q=").is_some_and(|q| q.parse() == Ok(0.0));
        item.trim().trim_start_matches("W/").eq_ignore_ascii_case(wanted) && !ruled_out
    })
}

/// Puts the fence around a reply.
pub fn protect(reply: &mut Reply, request: &HeaderMap) {
    let headers = reply.headers_mut();
    for (name, value) in FENCE {
        headers.insert(name, HeaderValue::from_static(value));
    }
    // Named apart: older browsers do not count sockets to `'self'`.
    let sockets = guard::host(request).map_or(String::new(), |h| format!(" ws://{h} wss://{h}"));
    let policy = format!(
        "default-src 'none'; script-src 'self' 'wasm-unsafe-eval' blob:; worker-src 'self' blob:; \
         style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; media-src 'self' blob:; \
         font-src 'self'; manifest-src 'self'; connect-src 'self' blob: data:{sockets}; \
         base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    if let Ok(policy) = HeaderValue::try_from(policy) {
        headers.insert(CONTENT_SECURITY_POLICY, policy);
    }
}
