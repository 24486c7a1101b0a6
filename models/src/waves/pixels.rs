//! What draws curves on the canvas of the runtime's pictures, for PNG files in the font that ships with the program.

use pdlang_runtime::observe::Canvas;
use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;

use super::plot::FINE;

/// A canvas of two pixels for each of the picture's, so that lines and letters are fine. The picture's places are finer
/// still.
pub struct Pixels<'a>(pub &'a mut Canvas);

/// Pixels of the canvas for a step of the picture's places.
const STEP: f64 = 2.0 / FINE as f64;

/// A canvas for a picture of this size.
pub fn canvas((width, height): (u32, u32)) -> Canvas {
    Canvas::new(whole(width as i32), whole(height as i32))
}

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// A place of the picture on the canvas.
fn place(p: BackendCoord) -> (f64, f64) {
    (STEP * f64::from(p.0), STEP * f64::from(p.1))
}

/// The nearest pixel.
fn whole(c: i32) -> i64 {
    (STEP * f64::from(c)).round() as i64
}

/// On white, which all of a picture stands on.
fn mixed(color: BackendColor) -> [u8; 3] {
    let (r, g, b) = color.rgb;
    let share = color.alpha.clamp(0.0, 1.0);
    [r, g, b].map(|c| (255.0 + share * (f64::from(c) - 255.0)).round() as u8)
}

impl DrawingBackend for Pixels<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        [self.0.width, self.0.height]
            .map(|n| (n as f64 / STEP) as u32)
            .into()
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, p: BackendCoord, color: BackendColor) -> Drawn {
        let (x, y) = place(p);
        self.0.blend(x as i64, y as i64, mixed(color), STEP * STEP);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, a: BackendCoord, b: BackendCoord, s: &S) -> Drawn {
        let width = STEP * f64::from(s.stroke_width());
        self.0.line(place(a), place(b), width, mixed(s.color()));
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        for pair in points.windows(2) {
            self.draw_line(pair[0], pair[1], style)?;
        }
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let [x0, y0, x1, y1] = [from.0, from.1, to.0 + 1, to.1 + 1].map(whole);
        let color = mixed(style.color());
        match fill {
            // What covers in part is the ground of a legend: white.
            true => self.0.rectangle(x0, y0, x1, y1, color),
            false => self.0.frame(x0, y0, x1, y1, color),
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let ((x, y), r) = (place(center), STEP * f64::from(radius));
        let color = mixed(style.color());
        if fill {
            self.0.disc(x, y, r, color);
            return Ok(());
        }
        let at = |k: i32| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
            (x + r * cos, y + r * sin)
        };
        let width = STEP * f64::from(style.stroke_width());
        (0..24).for_each(|k| self.0.line(at(k), at(k + 1), width, color));
        Ok(())
    }

    fn draw_text<T: BackendTextStyle>(&mut self, text: &str, style: &T, p: BackendCoord) -> Drawn {
        let size = STEP * style.size();
        let width = Canvas::measure(size, text);
        let (x, y) = (STEP * f64::from(p.0), STEP * f64::from(p.1));
        let left = match style.anchor().h_pos {
            HPos::Left => x,
            HPos::Center => x - 0.5 * width,
            HPos::Right => x - width,
        };
        // Capitals are 0.73 of the height of a line.
        let base = match style.anchor().v_pos {
            VPos::Top => y + 0.8 * size,
            VPos::Center => y + 0.3 * size,
            VPos::Bottom => y - 0.2 * size,
        };
        self.0.text(left, base, size, mixed(style.color()), text);
        Ok(())
    }

    fn estimate_text_size<T: BackendTextStyle>(
        &self,
        text: &str,
        style: &T,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let size = style.size();
        Ok((
            Canvas::measure(size, text).ceil() as u32,
            size.ceil() as u32,
        ))
    }
}
