//! stub
use super::arguments::PublishedArguments;
use super::common::CommandResult;
pub fn run(_given: &PublishedArguments) -> CommandResult { Err("x".into()) }
