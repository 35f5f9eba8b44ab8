//! `Prefer: wait=N` (RFC 7240).

use axum::extract::FromRequestParts;
use axum::http::{HeaderMap, request::Parts};
use std::convert::Infallible;
use std::time::Duration;

/// How long the client would wait for the result rather than get its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PreferWait(pub Option<Duration>);

impl PreferWait {
    /// Preferences that are not understood are ignored, as the RFC asks.
    fn read(headers: &HeaderMap) -> Self {
        let values = headers.get_all("prefer").iter().filter_map(|v| v.to_str().ok());
        let seconds = values.flat_map(|v| v.split(',')).find_map(|preference| {
            let (name, value) = preference.split(';').next()?.split_once('=')?;
            let is_wait = name.trim().eq_ignore_ascii_case("wait");
            is_wait.then(|| value.trim().trim_matches('"').parse::<u32>().ok())?
        });
        Self(seconds.map(|s| Duration::from_secs(s.into())))
    }

    /// Value of `Preference-Applied`.
    pub fn applied(&self) -> Option<String> {
        self.0.map(|wait| format!("wait={}", wait.as_secs()))
    }
}

impl<S: Send + Sync> FromRequestParts<S> for PreferWait {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        Ok(Self::read(&parts.headers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wait_is_found_among_preferences() {
        let wait = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert("prefer", value.parse().unwrap());
            PreferWait::read(&headers).0.map(|d| d.as_secs())
        };
        assert_eq!(wait("wait=30"), Some(30));
        assert_eq!(wait("respond-async, Wait = 5; foo"), Some(5));
        assert_eq!(wait("respond-async"), None);
        assert_eq!(wait("wait=-1"), None);
        assert_eq!(wait("wait"), None);
    }
}
