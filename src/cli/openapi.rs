//! `dynident openapi`.

use super::{Ending, files};
use crate::app::Error;
use crate::service::openapi_json;

pub fn run() -> Result<Ending, Error> {
    files::print(&openapi_json())?;
    Ok(Ending::Done)
}
