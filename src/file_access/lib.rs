//! Access to files and text from outside: bounded reading, creation of files that follows no link, what may be
//! replaced, escaping of hidden characters.

mod create;
mod number;
mod printable;
mod read;
mod target;

pub use create::{create_exclusive, open_lock};
pub use number::{LARGEST_NUMBER, SMALLEST_NUMBER, is_physical, unfilled};
pub use printable::{escape_json, is_hidden, one_line, printable, shortened};
pub use read::{
    MOST_DOCUMENT_BYTES, MOST_STREAM_BYTES, MOST_TABLE_BYTES, MOST_TEXT_BYTES, ReadFault, is_inside,
    open_file, read_file, read_replaced, read_text, read_unchanged,
};
pub use target::{Existing, Run, TargetFault, check_targets};
