//! Figures as SVG or PNG: for the command line and for reports.
//!
//! A [`Figure`] is a stack of panels over one horizontal axis; what it shows is built
//! from the documents that everybody else gets, too.

mod design;
mod draw;
mod identification;
mod residual;

pub use design::design_figure;
pub use identification::{error_figure, parameter_figures, torque_figure};
pub use residual::{before_after_figure, finding_figure};

/// What cannot be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the figure could not be drawn: {0}")]
pub struct FigureError(pub String);

/// Panels over one another with a common horizontal axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Title above the figure.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x: String,
    /// Names of places 0, 1, … on the horizontal axis, where it is no number.
    pub places: Vec<String>,
    /// Diagrams, from top to bottom.
    pub panels: Vec<Panel>,
    /// Pixels.
    pub size: (u32, u32),
}

impl Figure {
    /// Whether a line of it is parted.
    pub fn has_gaps(&self) -> bool {
        let all = self.panels.iter().flat_map(|panel| &panel.series);
        all.flat_map(|series| &series.points).any(|point| point.0.is_nan())
    }
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Name and unit of the vertical axis.
    pub y: String,
    /// Curves and marks of the diagram.
    pub series: Vec<Series>,
}

/// One set of values; points that are not finite are left out, and part a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// In the legend; none if empty.
    pub name: String,
    /// How the points are drawn.
    pub mark: Mark,
    /// Number in the palette.
    pub colour: usize,
    /// Points (x, y), in the units of the axes.
    pub points: Vec<(f64, f64)>,
}

/// How a series is drawn.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// A line through all points, parted by those that are not finite.
    Line,
    /// A bar from zero to y; `of` bars stand beside each other, this is number `at`.
    Bar {
        /// Position of this bar among those beside it, from 0.
        at: usize,
        /// Number of bars beside each other.
        of: usize,
    },
    /// A dot, and whiskers of this length to both sides.
    Dot(Vec<f64>),
    /// A short stroke at y.
    Level,
    /// A small dot.
    Point,
}

/// Where a unit is written for people: `kg m^2` becomes `kg·m²`, and that of pure numbers nothing.
pub(super) fn unit(text: &str) -> String {
    if text == "1" {
        return String::new();
    }
    text.replace(' ', "·").replace("^2", "²").replace("^3", "³")
}
