//! Dispersion curves as a picture: wave number times spacing against frequency, one panel beside the other.
//!
//! Longitudinal branches are drawn solid, transverse ones dashed; the continuum dotted in the same colour, the local wave
//! equation as thin grey lines. Modes without energy have a ring. SVG, or PNG on the canvas of the runtime's pictures.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::path::Path;

use super::pixels::{Pixels, canvas};
use super::{Moving, Study, frequency};

/// Pixels of a panel.
const WIDTH: u32 = 520;
const HEIGHT: u32 = 400;
/// Parts of a pixel that places are rounded to.
pub const FINE: u32 = 4;
/// Height of letters and of a line of the legend, pixels.
const LETTERS: u32 = 12;
const LINE: u32 = 17;
/// Colours that are told apart on white.
const COLORS: [RGBColor; 10] = [
    RGBColor(31, 119, 180),
    RGBColor(214, 39, 40),
    RGBColor(44, 160, 44),
    RGBColor(148, 103, 189),
    RGBColor(255, 127, 14),
    RGBColor(140, 86, 75),
    RGBColor(227, 119, 194),
    RGBColor(23, 190, 207),
    RGBColor(127, 127, 127),
    RGBColor(188, 189, 34),
];

fn shade(k: usize) -> RGBAColor {
    COLORS[k % COLORS.len()].to_rgba()
}

/// What can be drawn of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    Lattice,
    Continuum,
    Local,
}

impl Curve {
    pub const ALL: [Curve; 3] = [Curve::Lattice, Curve::Continuum, Curve::Local];

    pub fn name(self) -> &'static str {
        match self {
            Curve::Lattice => "lattice",
            Curve::Continuum => "continuum",
            Curve::Local => "local",
        }
    }
}

/// A study to draw.
pub struct Series {
    /// What distinguishes it from the others of a panel.
    pub label: String,
    /// Series with the same words share a panel, headed by them.
    pub panel: String,
    pub study: Study,
}

/// How a picture is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Svg,
    Png,
}

/// By the ending of a file.
///
/// # Errors
/// An ending that is no format, as a message calls it.
pub fn format(path: &Path) -> Result<Format, String> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("svg") => Ok(Format::Svg),
        Some("png") => Ok(Format::Png),
        Some(other) => Err(format!("a `.{other}`")),
        None => Err("a file without an ending".into()),
    }
}

/// Draws series to a file.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(
    path: &Path,
    format: Format,
    series: &[Series],
    curves: &[Curve],
) -> Result<(), Box<dyn Error>> {
    match format {
        Format::Svg => std::fs::write(path, svg(series, curves)?)?,
        Format::Png => {
            let mut canvas = canvas(size(series));
            {
                let root = Pixels(&mut canvas).into_drawing_area();
                panels(&root, series, curves)?;
            }
            canvas.save(path)?;
        }
    }
    Ok(())
}

/// The text of a drawing.
///
/// # Errors
/// When the back end draws nothing.
pub fn svg(series: &[Series], curves: &[Curve]) -> Result<String, Box<dyn Error>> {
    let size = size(series);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        panels(&root, series, curves)?;
        root.present()?;
    }
    // Shown in whole pixels, with places finer than that.
    let (width, height) = size;
    let fine = format!("width=\"{width}\" height=\"{height}\"");
    let shown = format!("width=\"{}\" height=\"{}\"", width / FINE, height / FINE);
    Ok(text.replacen(&fine, &shown, 1))
}

fn names(series: &[Series]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for s in series {
        if !names.contains(&s.panel.as_str()) {
            names.push(&s.panel);
        }
    }
    names
}

fn size(series: &[Series]) -> (u32, u32) {
    (FINE * WIDTH * names(series).len() as u32, FINE * HEIGHT)
}

fn panels<B: DrawingBackend>(
    root: &DrawingArea<B, Shift>,
    series: &[Series],
    curves: &[Curve],
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    root.fill(&WHITE)?;
    let names = names(series);
    for (area, name) in root.split_evenly((1, names.len())).iter().zip(&names) {
        let own: Vec<&Series> = series.iter().filter(|s| s.panel == *name).collect();
        panel(area, name, &own, curves)?;
    }
    Ok(())
}

/// A line of a panel.
struct Line {
    points: Vec<(f64, f64)>,
    label: Option<String>,
    color: RGBAColor,
    stroke: Stroke,
}

impl Line {
    fn style(&self) -> ShapeStyle {
        let width = if self.stroke == Stroke::Thin { 1 } else { 2 };
        self.color.stroke_width(FINE * width)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Stroke {
    Solid,
    Dashed,
    Dotted,
    Thin,
}

impl Stroke {
    /// Length of its dashes in pixels.
    fn dash(self) -> u32 {
        match self {
            Stroke::Solid | Stroke::Thin => u32::from(u8::MAX),
            Stroke::Dashed => 7,
            Stroke::Dotted => 2,
        }
    }
}

fn panel<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    name: &str,
    series: &[&Series],
    curves: &[Curve],
) -> Result<(), Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    let mut lines: Vec<Line> = Vec::new();
    let mut rings: Vec<((f64, f64), RGBAColor)> = Vec::new();
    for (k, s) in series.iter().enumerate() {
        let color = shade(k);
        lines.extend(lines_of(s, color, series.len() == 1, curves));
        let at =
            |z: &super::ZeroMode| z.k.iter().map(|c| c * c).sum::<f64>().sqrt() * s.study.spacing;
        if curves.contains(&Curve::Lattice) {
            rings.extend(s.study.zero.iter().map(|z| ((at(z), 0.0), color)));
        }
    }
    // Local lines leave at the top.
    let local = lines.iter().all(|l| l.stroke == Stroke::Thin);
    let inside = (lines.iter()).filter(|l| local || l.stroke != Stroke::Thin);
    let highest = inside
        .flat_map(|l| &l.points)
        .fold(0.0_f64, |m, p| m.max(p.1));
    let top = if highest > 0.0 { 1.06 * highest } else { 1.0 };
    let right = (lines.iter().flat_map(|l| &l.points)).fold(0.0_f64, |m, p| m.max(p.0));
    // In thousands, millions, ..: `1e6 rad/s` for frequencies of 3e6.
    let power = 3 * ((top.log10() / 3.0).floor() as i32);
    let power = if (-3..3).contains(&power) { 0 } else { power };
    let unit = match (series.first().map(|s| s.study.moving), power) {
        (Some(Moving::Field(_)), 0) => "rate of decay [1/s]".into(),
        (Some(Moving::Field(_)), p) => format!("rate of decay [1e{p}/s]"),
        (_, 0) => "Omega [rad/s]".into(),
        (_, p) => format!("Omega [1e{p} rad/s]"),
    };
    let scale = 10.0_f64.powi(power);
    let heading = match name {
        "" => unit,
        name => format!("{unit}, {name}"),
    };
    let letters = |size: u32| ("sans-serif", FINE * size).into_font();
    area.draw(&Text::new(heading, fine(14, 6), letters(LETTERS + 2)))?;
    let rows = legend(area, &lines)?;
    let mut chart = ChartBuilder::on(area)
        .margin_top(FINE * (30 + LINE * rows))
        .margin_right(FINE * 18)
        .margin_bottom(FINE * 6)
        .margin_left(FINE * 4)
        .x_label_area_size(FINE * 38)
        .y_label_area_size(FINE * 44)
        .build_cartesian_2d(0.0..right, 0.0..top / scale)?;
    chart
        .configure_mesh()
        .x_desc("k dx")
        .label_style(letters(LETTERS))
        .axis_style(BLACK.stroke_width(FINE))
        .set_all_tick_mark_size(FINE * 4)
        .max_light_lines(0)
        .bold_line_style(RGBAColor(0, 0, 0, 0.08).stroke_width(FINE))
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    for line in &lines {
        let shown = clipped(&line.points, top);
        let points = shown.iter().map(|(x, y)| (*x, y / scale));
        let (style, dash) = (line.style(), FINE * line.stroke.dash());
        match line.stroke {
            Stroke::Solid | Stroke::Thin => chart.draw_series(LineSeries::new(points, style))?,
            _ => chart.draw_series(DashedLineSeries::new(points, dash, FINE * 4, style))?,
        };
    }
    let ring = |(at, color): &((f64, f64), RGBAColor)| {
        Circle::new(*at, FINE * 5, color.stroke_width(FINE * 2))
    };
    chart.draw_series(rings.iter().map(ring))?;
    Ok(())
}

/// A place in pixels of the picture.
fn fine(x: u32, y: u32) -> (i32, i32) {
    ((FINE * x) as i32, (FINE * y) as i32)
}

/// What the lines of a panel are, below its heading; how many rows that takes.
fn legend<B: DrawingBackend>(
    area: &DrawingArea<B, Shift>,
    lines: &[Line],
) -> Result<u32, Box<dyn Error>>
where
    B::ErrorType: 'static,
{
    const SAMPLE: u32 = 24;
    let (mut x, mut row) = (14, 0);
    for line in lines {
        let Some(label) = &line.label else {
            continue;
        };
        // Letters are about 0.6 of their height.
        let width = SAMPLE + 22 + label.chars().count() as u32 * LETTERS * 3 / 5;
        if x > 14 && x + width > WIDTH {
            (x, row) = (14, row + 1);
        }
        let y = 28 + LINE * row;
        let mut from = 0;
        while from < SAMPLE {
            let to = (from + line.stroke.dash()).min(SAMPLE);
            let ends = vec![
                fine(x + from, y + LETTERS / 2),
                fine(x + to, y + LETTERS / 2),
            ];
            area.draw(&PathElement::new(ends, line.style()))?;
            from = to + 4;
        }
        let font = ("sans-serif", FINE * LETTERS).into_font();
        area.draw(&Text::new(label.clone(), fine(x + SAMPLE + 6, y), font))?;
        x += width;
    }
    Ok(if x > 14 { row + 1 } else { 0 })
}

/// The curves of a study. Of one alone branches have colours of their own.
fn lines_of(series: &Series, color: RGBAColor, alone: bool, curves: &[Curve]) -> Vec<Line> {
    let study = &series.study;
    let mut lines = Vec::new();
    let words = |what: &str| match series.label.as_str() {
        "" => what.to_string(),
        label => format!("{label}, {what}"),
    };
    for curve in Curve::ALL.iter().rev().filter(|c| curves.contains(c)) {
        let first = *curve == *curves.first().unwrap_or(curve);
        for (b, branch) in study.branches.iter().enumerate() {
            let value = |row: &super::Row| match curve {
                Curve::Lattice => row.lattice.get(b).map(|w| w.squared),
                Curve::Continuum => row.continuum.as_ref().and_then(|c| c.get(b).copied()),
                Curve::Local => row.local.as_ref().and_then(|c| c.get(b).copied()),
            };
            let at = |row: &super::Row| {
                value(row).map(|v| (row.k * study.spacing, frequency(study.moving, v).max(0.0)))
            };
            let found: Vec<(f64, f64)> = study.rows.iter().filter_map(at).collect();
            if found.is_empty() {
                continue;
            }
            let points = [(0.0, 0.0)].into_iter().chain(found).collect();
            let own = if alone { shade(b) } else { color };
            let (color, stroke) = match (curve, b) {
                (Curve::Local, _) => (RGBAColor(120, 120, 120, 0.9), Stroke::Thin),
                (Curve::Continuum, _) if curves.contains(&Curve::Lattice) => (own, Stroke::Dotted),
                (_, 0) => (own, Stroke::Solid),
                _ => (own, Stroke::Dashed),
            };
            let label = match (curve, alone) {
                (Curve::Local, _) => None,
                (Curve::Lattice, true) => Some(words(&branch.name)),
                (_, true) => Some(words(&format!("{}, {}", branch.name, curve.name()))),
                (_, false) if first && b == 0 => Some(if series.label.is_empty() {
                    branch.name.clone()
                } else {
                    series.label.clone()
                }),
                _ => None,
            };
            lines.push(Line {
                points,
                label,
                color,
                stroke,
            });
        }
    }
    lines
}

/// A curve up to where it leaves the panel at the top.
fn clipped(points: &[(f64, f64)], top: f64) -> Vec<(f64, f64)> {
    let mut shown: Vec<(f64, f64)> = Vec::new();
    for p in points {
        if p.1 <= top {
            shown.push(*p);
            continue;
        }
        if let Some(last) = shown.last().copied() {
            let share = (top - last.1) / (p.1 - last.1);
            shown.push((last.0 + share * (p.0 - last.0), top));
        }
        break;
    }
    shown
}

/// A tick without superfluous zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}
