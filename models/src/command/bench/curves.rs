//! Curves of accuracy studies as a picture: values as dots or lines, references as a grey line.

use std::error::Error;
use std::path::Path;

use pdlang_models::accuracy::{Along, Measure, Study};
use plotters::coord::Shift;
use plotters::prelude::*;

/// Pixels of a panel.
const WIDTH: u32 = 560;
const HEIGHT: u32 = 420;
const COLORS: [RGBColor; 4] = [
    RGBColor(31, 119, 180),
    RGBColor(214, 39, 40),
    RGBColor(44, 160, 44),
    RGBColor(148, 103, 189),
];

/// A panel for every pair of axes.
pub fn draw(path: &Path, found: &[(&Study, Vec<Measure>)]) -> Result<(), Box<dyn Error>> {
    let rows = found.iter().flat_map(|(_, rows)| rows);
    let mut panels: Vec<Vec<(Along, &Measure)>> = Vec::new();
    for (along, row) in rows.filter_map(|row| Some((row.along?, row))) {
        match panels.iter_mut().find(|p| p[0].0.axes == along.axes) {
            Some(panel) => panel.push((along, row)),
            None => panels.push(vec![(along, row)]),
        }
    }
    if panels.is_empty() {
        return Err("these studies have no curves, as paper-pml-3b-fit has".into());
    }
    let size = (WIDTH * panels.len() as u32, HEIGHT);
    let root = SVGBackend::new(path, size).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((1, panels.len()));
    for (area, panel) in areas.iter().zip(&panels) {
        draw_panel(area, panel)?;
    }
    root.present()?;
    Ok(())
}

fn draw_panel(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    rows: &[(Along, &Measure)],
) -> Result<(), Box<dyn Error>> {
    let across = ends(rows.iter().map(|(along, _)| along.at));
    let up = ends(rows.iter().flat_map(|(_, row)| [row.value, row.reference]));
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d(across.0..across.1, up.0..up.1)?;
    chart
        .configure_mesh()
        .x_desc(rows[0].0.axes[0])
        .y_desc(rows[0].0.axes[1])
        .max_light_lines(0)
        .draw()?;
    let mut known: Vec<(f64, f64)> = rows.iter().map(|(a, row)| (a.at, row.reference)).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let grey = RGBColor(110, 110, 110).stroke_width(2);
    chart
        .draw_series(LineSeries::new(known, grey))?
        .label("reference")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], grey));
    let mut names: Vec<&str> = rows.iter().map(|(along, _)| along.name).collect();
    names.dedup();
    for (k, name) in names.into_iter().enumerate() {
        let own = || rows.iter().filter(move |(along, _)| along.name == name);
        let points = own().map(|(along, row)| (along.at, row.value));
        let color = COLORS[k % COLORS.len()].to_rgba();
        if own().any(|(along, _)| along.line) {
            chart
                .draw_series(LineSeries::new(points, color.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color));
        } else {
            chart
                .draw_series(points.map(|point| Circle::new(point, 3, color.filled())))?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 8, y), 3, color.filled()));
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()?;
    Ok(())
}

/// The least and the largest, and a little room.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let around = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), around);
    let room = 0.05 * (high - low);
    (low - room, high + room)
}
