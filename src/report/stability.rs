//! stub
use crate::error::Error;
use crate::stability::Map;
/// stub
pub fn page(_: &Map) -> Result<String, Error> { Ok(String::new()) }
