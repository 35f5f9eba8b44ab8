//! One type for listed effects and those that a user defined.

use super::{Effect, OwnEffect};
use std::ops::Deref;
use std::sync::Arc;

/// An effect of [`all`](super::all) or an own one, shared by all terms and candidates that name it.
#[derive(Clone)]
pub enum AnyEffect {
    /// Of the list.
    Listed(&'static dyn Effect),
    /// Defined in a request or a robot.
    Own(Arc<OwnEffect>),
}

impl AnyEffect {
    /// The own effect, where it is one.
    pub fn own(&self) -> Option<&OwnEffect> {
        match self {
            Self::Listed(_) => None,
            Self::Own(own) => Some(own),
        }
    }
}

impl Deref for AnyEffect {
    type Target = dyn Effect;

    fn deref(&self) -> &(dyn Effect + 'static) {
        match self {
            Self::Listed(effect) => *effect,
            Self::Own(own) => &**own,
        }
    }
}

impl From<&'static dyn Effect> for AnyEffect {
    fn from(effect: &'static dyn Effect) -> Self {
        Self::Listed(effect)
    }
}

impl From<Arc<OwnEffect>> for AnyEffect {
    fn from(own: Arc<OwnEffect>) -> Self {
        Self::Own(own)
    }
}
