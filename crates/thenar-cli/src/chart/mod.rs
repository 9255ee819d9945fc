//! Line charts as SVG: panels with axes and units in one self-contained file.
//!
//! Own code because colours here are CSS classes, so that one file suits light and dark pages;
//! the libraries for SVG charts write fixed colours into every element.

mod axis;
mod lines;
mod page;

pub use axis::Axis;
pub use lines::{Dash, Line, Reduced};
pub use page::page;

/// One pair of axes with lines.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Quantity that is shown, with its unit.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x_label: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Lines of the chart.
    pub lines: Vec<Line>,
    /// Vertical marks: place and words.
    pub marks: Vec<(f64, String)>,
}
