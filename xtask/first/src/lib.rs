//! What building the page needs, and other commands too: other programs, the workspace, the toolchain and Node.js.

pub mod node;
pub mod page;
pub mod process;
pub mod toolchain;
pub mod workspace;
