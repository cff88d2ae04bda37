//! Pictures and a page that put the papers' figures beside ours: plain data in, SVG and HTML out.

mod chart;
mod page;

pub use chart::{Band, Chart, Curve, Scale, Style, charts};
pub use page::{Comparison, Page, Picture, Section, Table, files, page};
