//! The front half on real files: nothing is lost, nothing is misread.

mod common;
mod files {
    pub mod functions;
    pub mod lossless;
    pub mod lowering;
    pub mod results;
}
