//! From a figure to pixels or SVG.

use super::{Figure, FigureError, Mark, Panel, Series};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::fmt::Display;
use std::io::Cursor;
use std::ops::Range;
use std::sync::Once;

/// Okabe and Ito's colours, which people with any kind of colour vision tell apart.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(179, 89, 155),
    RGBColor(176, 125, 0),
    RGBColor(58, 154, 209),
    RGBColor(34, 34, 34),
    RGBColor(110, 118, 126),
];
/// Latin, Greek σ and Δ, and the signs of units, from DejaVu Sans: pictures look alike on machines without fonts.
const FONT: &[u8] = include_bytes!("../fonts/DejaVuSans-subset.ttf");

type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

impl Figure {
    /// As SVG.
    ///
    /// # Errors
    /// What the library says.
    pub fn svg(&self) -> Result<String, FigureError> {
        let mut text = String::new();
        self.draw(&SVGBackend::with_string(&mut text, self.size).into_drawing_area())?;
        Ok(text)
    }

    /// As PNG.
    ///
    /// # Errors
    /// What the library says.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (width, height) = self.size;
        let mut pixels = vec![0; 3 * (width * height) as usize];
        self.draw(&BitMapBackend::with_buffer(&mut pixels, self.size).into_drawing_area())?;
        let picture = image::RgbImage::from_raw(width, height, pixels).ok_or_else(|| said(&"a picture of another size"))?;
        let mut file = Cursor::new(Vec::new());
        picture.write_to(&mut file, image::ImageFormat::Png).map_err(|e| said(&e))?;
        Ok(file.into_inner())
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), FigureError> {
        static FONTS: Once = Once::new();
        FONTS.call_once(|| drop(plotters::style::register_font("sans-serif", FontStyle::Normal, FONT)));
        area.fill(&WHITE).map_err(|e| said(&e))?;
        let area = match self.title.is_empty() {
            true => area.clone(),
            false => area.titled(&self.title, ("sans-serif", 17)).map_err(|e| said(&e))?,
        };
        let last = self.panels.len() - 1;
        // The lowest panel carries the names below the axis.
        let below = if self.places.is_empty() {
            46
        } else {
            30 + self.longest_place()
        };
        let each = (area.dim_in_pixel().1 as i32 - below) / self.panels.len() as i32;
        let cuts: Vec<i32> = (1..self.panels.len() as i32).map(|k| k * each).collect();
        let areas = area.split_by_breakpoints([] as [i32; 0], cuts.as_slice());
        let across = self.across();
        for (k, (panel, area)) in self.panels.iter().zip(&areas).enumerate() {
            self.panel(panel, area, across.clone(), (k == last).then_some(below))?;
        }
        area.present().map_err(|e| said(&e))
    }

    fn longest_place(&self) -> i32 {
        let longest = self.places.iter().map(|p| p.chars().count()).max().unwrap_or(0) as i32;
        if self.places.len() > 12 { 7 * longest } else { 16 }
    }

    fn across(&self) -> Range<f64> {
        if !self.places.is_empty() {
            return -0.6..self.places.len() as f64 - 0.4;
        }
        let lines = self.panels.iter().flat_map(|p| &p.series);
        let (low, high) = extremes(lines.flat_map(|s| s.points.iter().map(|p| p.0)));
        low..high
    }

    fn panel<DB: DrawingBackend>(
        &self,
        panel: &Panel,
        area: &DrawingArea<DB, Shift>,
        across: Range<f64>,
        below: Option<i32>,
    ) -> Result<(), FigureError> {
        let along = panel.range();
        let mut builder = ChartBuilder::on(area);
        builder.margin(6).margin_right(14).y_label_area_size(72);
        builder.x_label_area_size(below.unwrap_or(6));
        // Above the curves: it covers none of them.
        builder.margin_top(if panel.has_legend() { LEGEND } else { 6 });
        let mut chart = builder.build_cartesian_2d(across, along.clone()).map_err(|e| said(&e))?;
        let mut mesh = chart.configure_mesh();
        mesh.y_desc(&panel.y)
            .y_labels(5)
            .light_line_style(TRANSPARENT)
            .label_style(("sans-serif", 13));
        mesh.axis_desc_style(("sans-serif", 15)).y_label_formatter(&|v| shown(*v));
        if below.is_none() || !self.places.is_empty() {
            mesh.x_labels(0).disable_x_mesh();
        } else {
            mesh.x_desc(&self.x).x_labels(11).x_label_formatter(&|v| shown(*v));
        }
        mesh.draw().map_err(|e| said(&e))?;
        for series in &panel.series {
            draw_series(&mut chart, series)?;
        }
        if below.is_some() {
            self.name_places(&chart, area, along.start)?;
        }
        panel.legend(area)
    }

    /// Names under the axis: upright where many, and the axis' own name below them.
    fn name_places<DB: DrawingBackend>(
        &self,
        chart: &Chart<DB>,
        area: &DrawingArea<DB, Shift>,
        floor: f64,
    ) -> Result<(), FigureError> {
        let many = self.places.len() > 12;
        let (x0, y0) = area.get_base_pixel();
        let font = ("sans-serif", if many { 12 } else { 14 }).into_text_style(area);
        let style = match many {
            true => font
                .transform(FontTransform::Rotate270)
                .pos(Pos::new(HPos::Right, VPos::Center)),
            false => font.pos(Pos::new(HPos::Center, VPos::Top)),
        };
        for (k, name) in self.places.iter().enumerate() {
            let (x, y) = chart.plotting_area().map_coordinate(&(k as f64, floor));
            area.draw_text(name, &style, (x - x0, y - y0 + 7)).map_err(|e| said(&e))?;
        }
        if self.places.is_empty() {
            return Ok(());
        }
        let (width, height) = area.dim_in_pixel();
        let style = ("sans-serif", 13)
            .into_text_style(area)
            .pos(Pos::new(HPos::Center, VPos::Bottom));
        area.draw_text(&self.x, &style, (width as i32 / 2 + 30, height as i32 - 4))
            .map_err(|e| said(&e))
    }
}

/// Height of the line that names the series.
const LEGEND: i32 = 22;

impl Panel {
    fn has_legend(&self) -> bool {
        self.series.iter().any(|s| !s.name.is_empty())
    }

    /// Names of the series with their colours, from the right end of a line above the plot.
    fn legend<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<(), FigureError> {
        let style = ("sans-serif", 13)
            .into_text_style(area)
            .pos(Pos::new(HPos::Right, VPos::Center));
        let mut right = area.dim_in_pixel().0 as i32 - 16;
        for series in self.series.iter().rev().filter(|s| !s.name.is_empty()) {
            let colour = PALETTE[series.colour % PALETTE.len()];
            area.draw_text(&series.name, &style, (right, LEGEND / 2))
                .map_err(|e| said(&e))?;
            right -= area.estimate_text_size(&series.name, &style).map_err(|e| said(&e))?.0 as i32 + 6;
            let stroke = PathElement::new([(right - 20, LEGEND / 2), (right, LEGEND / 2)], colour.stroke_width(4));
            area.draw(&stroke).map_err(|e| said(&e))?;
            right -= 36;
        }
        Ok(())
    }

    /// The values with a twentieth of their span to spare; from zero where there are bars.
    fn range(&self) -> Range<f64> {
        let values = self.series.iter().flat_map(|s| {
            let whisker = |i: usize| if let Mark::Dot(lengths) = &s.mark { lengths[i] } else { 0.0 };
            s.points
                .iter()
                .enumerate()
                .flat_map(move |(i, p)| [p.1 - whisker(i), p.1 + whisker(i)])
        });
        let bars = self.series.iter().any(|s| matches!(s.mark, Mark::Bar { .. }));
        let (low, high) = extremes(values.chain(bars.then_some(0.0)));
        let spare = 0.06 * (high - low);
        (if bars { low } else { low - spare })..high + spare
    }
}

/// Lowest and highest finite value, apart.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    match low < high {
        true => (low, high),
        false if low.is_finite() => (low - 0.5, low + 0.5),
        false => (0.0, 1.0),
    }
}

/// Numbers at ticks: as short as they can be.
fn shown(value: f64) -> String {
    // Rounding of sums like 0.1 + 0.2 does not belong on an axis.
    let rounded = (value * 1e9).round() / 1e9;
    if rounded == 0.0 {
        return "0".into();
    }
    if rounded.abs() < 1e-3 || rounded.abs() >= 1e5 {
        return format!("{value:.0e}");
    }
    format!("{rounded}").replace('-', "−")
}

fn draw_series<DB: DrawingBackend>(chart: &mut Chart<DB>, series: &Series) -> Result<(), FigureError> {
    let colour = PALETTE[series.colour % PALETTE.len()];
    let points: Vec<(usize, (f64, f64))> = series
        .points
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, p)| is_finite(p))
        .collect();
    let plain = || points.iter().map(|p| p.1);

    match &series.mark {
        Mark::Line => {
            for run in series.points.split(|p| !is_finite(p)) {
                let line = LineSeries::new(run.iter().copied(), colour.stroke_width(1));
                chart.draw_series(line).map_err(|e| said(&e))?;
            }
            return Ok(());
        }
        Mark::Bar { at, of } => {
            let width = 0.8 / *of as f64;
            let left = |x: f64| x - 0.4 + width * *at as f64;
            chart.draw_series(plain().map(|(x, y)| Rectangle::new([(left(x), 0.0), (left(x) + width, y)], colour.filled())))
        }
        Mark::Level => {
            chart.draw_series(plain().map(|(x, y)| PathElement::new([(x - 0.4, y), (x + 0.4, y)], colour.stroke_width(3))))
        }
        Mark::Point => chart.draw_series(plain().map(|p| Circle::new(p, 1, colour.filled()))),
        Mark::Dot(lengths) => {
            let whisker = |(i, (x, y)): &(usize, (f64, f64))| {
                ErrorBar::new_vertical(*x, y - lengths[*i], *y, y + lengths[*i], colour.filled(), 7)
            };
            chart.draw_series(points.iter().map(whisker)).map_err(|e| said(&e))?;
            chart.draw_series(plain().map(|p| Circle::new(p, 3, colour.filled())))
        }
    }
    .map(drop)
    .map_err(|e| said(&e))
}

fn is_finite(point: &(f64, f64)) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

fn said(e: &impl Display) -> FigureError {
    FigureError(e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure() -> Figure {
        let points = vec![(0.0, 1.0), (1.0, f64::NAN), (2.0, 3.0)];
        let series = |mark| Series {
            name: "a & b".into(),
            mark,
            colour: 1,
            points: points.clone(),
        };
        let marks = [
            Mark::Bar { at: 0, of: 2 },
            Mark::Level,
            Mark::Dot(vec![0.1; 3]),
            Mark::Line,
            Mark::Point,
        ];
        Figure {
            title: "title".into(),
            x: "joint".into(),
            places: vec!["A1".into(), "A<2".into(), "A3".into()],
            panels: vec![Panel {
                y: "torque (N m)".into(),
                series: marks.into_iter().map(series).collect(),
            }],
            size: (400, 300),
        }
    }

    #[test]
    fn a_figure_is_well_formed_svg_with_its_words_escaped() {
        let text = figure().svg().unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let words: Vec<&str> = document
            .descendants()
            .filter_map(|n| n.text())
            .map(str::trim)
            .filter(|t| !t.is_empty())
            .collect();
        for word in ["title", "A1", "A<2", "A3", "torque (N m)", "joint", "a & b"] {
            assert!(words.contains(&word), "{word} not among {words:?}");
        }
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn a_line_is_parted_where_a_point_is_no_number() {
        let lines = |points: Vec<(f64, f64)>| {
            let series = Series {
                name: String::new(),
                mark: Mark::Line,
                colour: 0,
                points,
            };
            let mut figure = figure();
            figure.panels[0].series = vec![series];
            figure.svg().unwrap().matches("<polyline").count()
        };
        let whole = vec![(0.0, 1.0), (1.0, 2.0), (2.0, 3.0), (3.0, 1.0)];
        let mut parted = whole.clone();
        parted.insert(2, (f64::NAN, f64::NAN));
        assert_eq!(lines(parted), lines(whole) + 1);
    }

    #[test]
    fn a_figure_is_a_png_with_ink_on_it() {
        let file = figure().png().unwrap();
        let picture = image::load_from_memory(&file).unwrap().to_rgb8();
        assert_eq!(picture.dimensions(), (400, 300));
        assert!(picture.pixels().filter(|p| p.0 != [255, 255, 255]).count() > 1000);
    }

    #[test]
    fn figures_without_values_have_axes() {
        let mut empty = figure();
        empty.panels[0].series.iter_mut().for_each(|s| s.points.clear());
        empty.panels[0].series.retain(|s| !matches!(s.mark, Mark::Dot(_)));
        assert!(empty.svg().is_ok());
    }
}
