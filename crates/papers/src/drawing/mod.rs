//! Pictures and a page that compare the papers' figures with ours: plain data in, SVG and HTML out.

mod chart;
mod page;

pub use chart::{Chart, Curve, Scale, Style, charts};
pub use page::{Comparison, Page, Picture, Section, Table, files, page};
