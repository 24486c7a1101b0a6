//! Pictures of the body: nodes seen along an axis, coloured by a quantity, with scale, time and length.

use super::color::Scale;
use super::draw::{BLACK, Canvas};
use super::{Picture, Values, View, quantity};
use crate::conditions::nodes_in;
use crate::error::InputError;
use crate::simulate::Simulation;

/// The axes of a view: (axis, sign) to the right, up and towards the eye; right x up = eye.
fn axes(view: View) -> [(usize, f64); 3] {
    match view {
        View::Top => [(0, 1.0), (1, 1.0), (2, 1.0)],
        View::Bottom => [(0, 1.0), (1, -1.0), (2, -1.0)],
        View::Front => [(0, 1.0), (2, 1.0), (1, -1.0)],
        View::Side => [(1, 1.0), (2, 1.0), (0, 1.0)],
        View::Above => [(0, 1.0), (2, -1.0), (1, 1.0)],
    }
}

/// A bar is seen from above.
fn seen(sim: &Simulation, picture: &Picture) -> View {
    match sim.body.flavour.dim() {
        1 => View::Top,
        _ => picture.view,
    }
}

/// Refuses widths that make no picture, ranges that are empty and regions without nodes.
pub fn check(sim: &Simulation, picture: &Picture) -> Result<(), InputError> {
    let name = &picture.name;
    if name.is_empty() || name.contains(['/', '\\', '\0']) {
        return Err(InputError::new(
            format!("a picture cannot be called `{name}`"),
            "its name becomes a file name: use letters, digits and hyphens",
        ));
    }
    if !(100..=8000).contains(&picture.width) {
        return Err(InputError::new(
            format!("picture `{name}` is {} pixels wide", picture.width),
            "give a width between 100 and 8000 pixels",
        ));
    }
    if picture
        .range
        .is_some_and(|(low, high)| !(low < high && low.is_finite() && high.is_finite()))
    {
        return Err(InputError::new(
            format!("the colour range of picture `{name}` is empty"),
            "give two numbers, the smaller one first",
        ));
    }
    if picture
        .region
        .as_ref()
        .is_some_and(|r| nodes_in(&sim.body, r).is_empty())
    {
        return Err(InputError::new(
            format!("the region of picture `{name}` holds no node"),
            "move or enlarge the region",
        ));
    }
    Ok(())
}

/// Width of the profile of a bar over its height.
const PROFILE: f64 = 3.0;

/// Where things stand on the canvas.
struct Layout {
    /// Left, top, width, height of the drawing [pixels].
    left: f64,
    top: f64,
    width: f64,
    height: f64,
    /// Pixels per metre.
    scale: f64,
    /// Smallest coordinates to the right and up [m].
    corner: [f64; 2],
    /// Size of text [pixels].
    text: f64,
}

impl Layout {
    fn place(&self, right: f64, up: f64) -> (f64, f64) {
        (
            self.left + (right - self.corner[0]) * self.scale,
            self.top + self.height - (up - self.corner[1]) * self.scale,
        )
    }
}

/// Draws a picture at an accepted step.
///
/// Errors: as [`check`], and names that are no quantity.
pub fn draw(sim: &mut Simulation, picture: &Picture) -> Result<Canvas, InputError> {
    let values = quantity(sim, &picture.quantity)?;
    let numbers = values.scalar();
    let nodes = match &picture.region {
        Some(region) => nodes_in(&sim.body, region),
        None => (0..sim.body.x.len() as u32).collect(),
    };
    let (scale, low, high) = range(picture, &numbers, &nodes);
    let layout = layout(sim, picture, &nodes);
    let right = layout.text * 8.0;
    let mut canvas = Canvas::new(
        (layout.left + layout.width + right) as i64,
        (layout.top + layout.height + layout.text * 4.2) as i64,
    );
    let share = |value: f64| (value - low) / (high - low);
    let color = |node: u32| scale.color(share(numbers[node as usize]));
    if sim.body.flavour.dim() == 1 {
        let height = |node: u32| share(numbers[node as usize]);
        columns(
            &mut canvas,
            sim,
            &layout,
            &nodes,
            (share(0.0), &height),
            color,
        );
    } else {
        paint(&mut canvas, sim, picture, &layout, nodes, color);
    }
    colour_bar(&mut canvas, &layout, scale, low, high, &values);
    words(&mut canvas, &layout, sim, picture);
    Ok(canvas)
}

fn layout(sim: &Simulation, picture: &Picture, nodes: &[u32]) -> Layout {
    let a = sim.body.spacing;
    let [(r, rs), (u, us), _] = axes(seen(sim, picture));
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for &node in nodes {
        let x = sim.body.x[node as usize];
        for (k, c) in [rs * x[r], us * x[u]].into_iter().enumerate() {
            low[k] = low[k].min(c);
            high[k] = high[k].max(c);
        }
    }
    // Deformed bodies get room to move.
    let room = if picture.deformed {
        0.08 * (high[0] - low[0]).max(high[1] - low[1])
    } else {
        0.0
    };
    let low = low.map(|c| c - 0.5 * a - room);
    let extent = [0, 1].map(|k| high[k] + 0.5 * a + room - low[k]);
    let fit = f64::from(picture.width) / extent[0];
    // Whole pixels per node where there are enough: lattices then tile without seams.
    let scale = if fit * a >= 2.0 {
        (fit * a).floor() / a
    } else {
        fit
    };
    let scale = scale.min(12_000.0 / extent[1]);
    let width = (extent[0] * scale).ceil();
    let height = match sim.body.flavour.dim() {
        1 => (width / PROFILE).ceil(),
        _ => (extent[1] * scale).ceil().max(1.0),
    };
    let text = (0.021 * f64::from(picture.width)).clamp(11.0, 40.0).round();
    Layout {
        left: (text * 1.5).round(),
        top: (text * 3.4).round(),
        width,
        height,
        scale,
        corner: low,
        text,
    }
}

/// A bar: a column at every node from zero to its value, by the numbers of the colour bar beside it.
fn columns(
    canvas: &mut Canvas,
    sim: &Simulation,
    layout: &Layout,
    nodes: &[u32],
    (zero, share): (f64, &dyn Fn(u32) -> f64),
    color: impl Fn(u32) -> [u8; 3],
) {
    let up = |share: f64| layout.top + layout.height * (1.0 - share.clamp(0.0, 1.0));
    let half = 0.5 * sim.body.spacing * layout.scale;
    for &node in nodes.iter().filter(|n| share(**n).is_finite()) {
        let (x, _) = layout.place(sim.body.x[node as usize][0], 0.0);
        let (left, right) = ((x - half).round() as i64, (x + half).round() as i64);
        let (from, to) = (up(zero), up(share(node)));
        let (top, bottom) = (from.min(to).floor() as i64, from.max(to).ceil() as i64);
        canvas.rectangle(left, top, right.max(left + 1), bottom, color(node));
    }
    let base = up(zero);
    let end = layout.left + layout.width;
    canvas.line((layout.left, base), (end, base), 1.0, BLACK);
}

fn paint(
    canvas: &mut Canvas,
    sim: &Simulation,
    picture: &Picture,
    layout: &Layout,
    mut nodes: Vec<u32>,
    color: impl Fn(u32) -> [u8; 3],
) {
    let [(r, rs), (u, us), (d, ds)] = axes(picture.view);
    let slots = sim.engine.slots();
    let position = |node: u32| {
        let mut x = sim.body.x[node as usize];
        if picture.deformed {
            let s = slots[node as usize] as usize;
            x.iter_mut().zip(&sim.state.u).for_each(|(x, u)| *x += u[s]);
        }
        x
    };
    // Farthest first, so that the node nearest to the eye is painted last.
    nodes.sort_by(|&a, &b| (ds * position(a)[d]).total_cmp(&(ds * position(b)[d])));
    let size = sim.body.spacing * layout.scale;
    for node in nodes {
        let x = position(node);
        let (cx, cy) = layout.place(rs * x[r], us * x[u]);
        let inside = cx >= layout.left && cx <= layout.left + layout.width;
        if !(inside && cy >= layout.top && cy <= layout.top + layout.height) {
            continue;
        }
        if sim.body.grid.is_some() && !picture.deformed {
            let edge = |c: f64| {
                (
                    (c - 0.5 * size).round() as i64,
                    (c + 0.5 * size).round() as i64,
                )
            };
            let ((x0, x1), (y0, y1)) = (edge(cx), edge(cy));
            canvas.rectangle(x0, y0, x1.max(x0 + 1), y1.max(y0 + 1), color(node));
        } else {
            canvas.disc(cx, cy, (0.72 * size).max(0.7), color(node));
        }
    }
}

/// Colour scale and its ends.
fn range(picture: &Picture, numbers: &[f64], nodes: &[u32]) -> (Scale, f64, f64) {
    let damage = picture.quantity == "damage";
    let finite = || {
        nodes
            .iter()
            .map(|&n| numbers[n as usize])
            .filter(|v| v.is_finite())
    };
    let (low, high) = match picture.range {
        Some(range) => range,
        None if damage => (0.0, 1.0),
        None => (
            finite().fold(f64::INFINITY, f64::min),
            finite().fold(f64::NEG_INFINITY, f64::max),
        ),
    };
    let (low, high) = if low.is_finite() && high.is_finite() {
        (low, high)
    } else {
        (0.0, 1.0)
    };
    let signed = low < 0.0 && high > 0.0;
    let (low, high) = match (picture.range, signed) {
        (None, true) => (-high.max(-low), high.max(-low)),
        _ if low == high => (
            low - 0.5 * low.abs().max(1.0),
            low + 0.5 * low.abs().max(1.0),
        ),
        _ => (low, high),
    };
    let scale = if damage {
        Scale::Damage
    } else if signed {
        Scale::Signed
    } else {
        Scale::Even
    };
    (scale, low, high)
}

fn colour_bar(
    canvas: &mut Canvas,
    layout: &Layout,
    scale: Scale,
    low: f64,
    high: f64,
    values: &Values,
) {
    let (x0, x1) = ((layout.left + layout.width + 1.6 * layout.text) as i64, 0);
    let x1 = x1 + x0 + layout.text as i64;
    let (y0, y1) = (
        layout.top as i64,
        (layout.top + layout.height.max(60.0)) as i64,
    );
    for y in y0..y1 {
        let t = (y1 - 1 - y) as f64 / (y1 - 1 - y0).max(1) as f64;
        canvas.rectangle(x0, y, x1, y + 1, scale.color(t));
    }
    canvas.frame(x0, y0, x1, y1, BLACK);
    // Powers of a thousand stand at the label, so that the numbers stay short.
    let power = ((low.abs().max(high.abs()).log10() / 3.0).floor() * 3.0) as i32;
    let power = if (0..3).contains(&power) || (power == -3 && high.abs() >= 0.09) {
        0
    } else {
        power
    };
    let unit = 10_f64.powi(power);
    let room = ((y1 - y0) as f64 / (3.0 * layout.text)).clamp(2.0, 6.0);
    for tick in ticks(low / unit, high / unit, room) {
        let y = y1 as f64 - 0.5 - (tick * unit - low) / (high - low) * (y1 - 1 - y0) as f64;
        canvas.line(
            (x1 as f64, y),
            (x1 as f64 + 0.3 * layout.text, y),
            1.0,
            BLACK,
        );
        let label = number(tick);
        canvas.text(
            x1 as f64 + 0.5 * layout.text,
            y + 0.36 * layout.text,
            layout.text,
            BLACK,
            &label,
        );
    }
    let times = if power == 0 {
        String::new()
    } else {
        format!("10{} ", superscript(power))
    };
    let label = format!(
        "{}{times}{}",
        if values.unit.is_empty() && power == 0 {
            ""
        } else {
            "× "
        },
        values.unit
    );
    let label = if power == 0 {
        values.unit.clone()
    } else {
        label
    };
    canvas.text(
        x0 as f64,
        layout.top - 0.6 * layout.text,
        layout.text,
        BLACK,
        label.trim(),
    );
}

/// Title, time, length scale and axes.
fn words(canvas: &mut Canvas, layout: &Layout, sim: &Simulation, picture: &Picture) {
    let (size, left) = (layout.text, layout.left);
    let title = if sim.title.is_empty() {
        sim.spec.title.as_str()
    } else {
        sim.title.as_str()
    };
    canvas.text(left, 1.5 * size, 1.15 * size, BLACK, title);
    let what = format!(
        "{}, t = {}",
        picture.quantity,
        quantity_text(sim.state.time, "s")
    );
    canvas.text(left, 2.85 * size, size, BLACK, &what);
    let base = layout.top + layout.height + 1.6 * size;
    let length = nice_below(0.3 * layout.width / layout.scale);
    let end = left + length * layout.scale;
    canvas.line((left, base), (end, base), (0.14 * size).max(1.5), BLACK);
    for x in [left, end] {
        canvas.line(
            (x, base - 0.3 * size),
            (x, base + 0.3 * size),
            (0.1 * size).max(1.0),
            BLACK,
        );
    }
    canvas.text(
        end + 0.6 * size,
        base + 0.36 * size,
        size,
        BLACK,
        &quantity_text(length, "m"),
    );
    compass(canvas, layout, sim, picture, base);
}

/// The two axes of the view, at the right end below the drawing.
fn compass(canvas: &mut Canvas, layout: &Layout, sim: &Simulation, picture: &Picture, base: f64) {
    let size = layout.text;
    let name = |(axis, sign): (usize, f64)| {
        format!(
            "{}{}",
            if sign < 0.0 { "−" } else { "" },
            ["x", "y", "z"][axis]
        )
    };
    let [right, up, _] = axes(seen(sim, picture));
    let shown = sim.body.flavour.dim().min(2);
    let origin = (layout.left + layout.width - 3.2 * size, base + 0.9 * size);
    let arrows = [((1.6 * size, 0.0), right), ((0.0, -1.6 * size), up)];
    for (tip, axis) in arrows.into_iter().take(shown) {
        let end = (origin.0 + tip.0, origin.1 + tip.1);
        canvas.line(origin, end, (0.1 * size).max(1.0), BLACK);
        let back = (end.0 - 0.22 * tip.0, end.1 - 0.22 * tip.1);
        let side = (0.1 * tip.1, 0.1 * tip.0);
        canvas.line(
            end,
            (back.0 + side.0, back.1 + side.1),
            (0.1 * size).max(1.0),
            BLACK,
        );
        canvas.line(
            end,
            (back.0 - side.0, back.1 - side.1),
            (0.1 * size).max(1.0),
            BLACK,
        );
        let (dx, dy) = if tip.1 == 0.0 { (0.3, 0.3) } else { (0.7, 0.4) };
        canvas.text(
            end.0 + dx * size,
            end.1 + dy * size,
            size,
            BLACK,
            &name(axis),
        );
    }
}

/// Round numbers in a range, about `count` of them.
fn ticks(low: f64, high: f64, count: f64) -> Vec<f64> {
    let within = |step: f64| {
        (
            (low / step - 1e-9).ceil() as i64,
            (high / step + 1e-9).floor() as i64,
        )
    };
    let mut step = nice_above((high - low) / count);
    if within(step).1 - within(step).0 < 2 {
        step = nice_below(0.5 * step);
    }
    let (first, last) = within(step);
    (first..=last.min(first + 20))
        .map(|k| k as f64 * step)
        .collect()
}

/// 1, 2 or 5 times a power of ten, at most `x`.
fn nice_below(x: f64) -> f64 {
    let power = 10_f64.powf(x.log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|m| m * power)
        .find(|v| *v <= x * (1.0 + 1e-9))
        .unwrap_or(power)
}

fn nice_above(x: f64) -> f64 {
    let power = 10_f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|v| *v >= x * (1.0 - 1e-9))
        .unwrap_or(power)
}

/// Up to six digits without rounding noise.
fn number(x: f64) -> String {
    let text = format!("{x:.6}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    (if short == "-0" { "0" } else { short }).replace('-', "−")
}

fn superscript(power: i32) -> String {
    let digit = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        _ => char::from_u32('⁰' as u32 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    power.to_string().chars().map(digit).collect()
}

/// `2.5e-5, "s"` is `25 µs`; four digits.
fn quantity_text(x: f64, unit: &str) -> String {
    const PREFIXES: [(&str, f64); 7] = [
        ("G", 1e9),
        ("M", 1e6),
        ("k", 1e3),
        ("", 1.0),
        ("m", 1e-3),
        ("µ", 1e-6),
        ("n", 1e-9),
    ];
    let found = PREFIXES.iter().find(|(_, f)| x.abs() >= 0.99995 * f);
    let (prefix, factor) = if x == 0.0 {
        ("", 1.0)
    } else {
        found.copied().unwrap_or(("n", 1e-9))
    };
    let scaled = x / factor;
    let digits = 3 - (scaled.abs().max(1.0).log10().floor() as i32).clamp(0, 3);
    let text = format!("{scaled:.*}", digits as usize);
    let short = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    format!("{short} {prefix}{unit}")
}

#[cfg(test)]
mod tests {
    use super::super::draw::WHITE;
    use super::*;
    use crate::body::Flavour;
    use crate::simulate::End;

    #[test]
    fn numbers_read_well() {
        assert_eq!(quantity_text(1e-4, "s"), "100 µs");
        assert_eq!(quantity_text(0.01, "m"), "10 mm");
        assert_eq!(quantity_text(1.23456e-5, "s"), "12.35 µs");
        assert_eq!(quantity_text(0.0, "s"), "0 s");
        assert_eq!(quantity_text(5e-13, "s"), "0.001 ns");
        assert_eq!(superscript(-12), "⁻¹²");
        assert_eq!(number(0.1 + 0.2), "0.3");
    }

    #[test]
    fn ticks_are_round() {
        let t: Vec<String> = ticks(0.0, 1.0, 6.0).into_iter().map(number).collect();
        assert_eq!(t, ["0", "0.2", "0.4", "0.6", "0.8", "1"]);
        assert_eq!(ticks(-3.2, 7.9, 5.0), [-2.0, 0.0, 2.0, 4.0, 6.0]);
        assert_eq!(ticks(-48.0, 48.0, 2.4), [-40.0, -20.0, 0.0, 20.0, 40.0]);
        assert_eq!(nice_below(0.0222), 0.02);
    }

    #[test]
    fn lattices_tile_without_seams() {
        let mut setup = crate::run::tests::block([17.0, 11.0, 1.0], Flavour::PlaneStress, 1.0);
        setup.end = End::Steps(0);
        let mut sim = Simulation::new(setup).unwrap();
        sim.run(&mut ()).unwrap();
        for width in 300..340 {
            let picture = Picture {
                name: "top".into(),
                quantity: "damage".into(),
                view: View::Top,
                range: None,
                width,
                deformed: false,
                region: None,
            };
            let layout = layout(&sim, &picture, &(0..187).collect::<Vec<u32>>());
            let canvas = draw(&mut sim, &picture).unwrap();
            let (left, top) = (layout.left as i64, layout.top as i64);
            let (right, bottom) = (left + layout.width as i64, top + layout.height as i64);
            let gap = (left..right).any(|x| (top..bottom).any(|y| canvas.pixel(x, y) == WHITE));
            assert!(!gap, "{width}");
        }
    }
}
