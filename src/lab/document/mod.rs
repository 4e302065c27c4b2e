//! Result documents of the laboratory, their texts and their JSON Schemas. The documents that the page draws
//! as well are in `report`.

pub mod convergence;
pub mod hybrid;
pub mod loops;
pub mod matrices;
pub mod published;
mod published_text;
mod schema;
pub mod sensitivity;

pub use published_text::{published_markdown, published_text};
pub use schema::{SCHEMAS, schema};
