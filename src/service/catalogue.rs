//! The lab's catalogue of own effects: everybody reads it, and those who administrate all robots change it.

use super::access::Access;
use super::state::Service;
use super::store::Role;
use crate::app::{Code, Error};
use serde_json::Value;

impl Service {
    /// The definition of an effect of the catalogue.
    pub(super) async fn effect(&self, name: &str) -> Result<Value, Error> {
        self.store().effect(name).await?.ok_or_else(|| unknown_effect(name))
    }

    /// Keeps an effect under its name; `true` if it is new.
    pub(super) async fn put_effect(&self, name: &str, effect: &Value, access: &Access) -> Result<bool, Error> {
        let new = self.store().put_effect(name, effect).await?;
        self.note(access, "put_effect", "", name).await?;
        Ok(new)
    }

    pub(super) async fn remove_effect(&self, name: &str, access: &Access) -> Result<(), Error> {
        match self.store().remove_effect(name).await? {
            true => self.note(access, "delete_effect", "", name).await,
            false => Err(unknown_effect(name)),
        }
    }
}

impl Access {
    /// The catalogue is that of all robots: what one changes in it changes the models of all.
    ///
    /// # Errors
    /// The token's role is a lower one, or it is for some robots only.
    pub fn require_catalogue(&self) -> Result<(), Error> {
        self.require(Role::Admin)?;
        match self.robots() {
            None => Ok(()),
            Some(_) => {
                let detail = "the catalogue of effects is that of all robots, and the token is for some";
                Err(Error::new(Code::Forbidden, detail)
                    .with_hint("put the definition into `effects` of the robot or the request"))
            }
        }
    }
}

fn unknown_effect(name: &str) -> Error {
    Error::new(Code::UnknownEffect, format!("there is no effect `{name}` in the catalogue")).with_hint("GET /effects lists them")
}
