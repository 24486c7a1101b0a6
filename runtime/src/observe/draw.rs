//! A canvas: rectangles, discs, lines, text; saved as PNG.

use super::color::{Rgb, mix};
use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use std::path::Path;

pub const BLACK: Rgb = [25, 25, 28];
pub const WHITE: Rgb = [255, 255, 255];

/// Pixels from the top left.
pub struct Canvas {
    pub width: i64,
    pub height: i64,
    pixels: Vec<Rgb>,
}

impl Canvas {
    pub fn new(width: i64, height: i64) -> Canvas {
        Canvas {
            width,
            height,
            pixels: vec![WHITE; (width.max(0) * height.max(0)) as usize],
        }
    }

    #[cfg(test)]
    pub fn pixel(&self, x: i64, y: i64) -> Rgb {
        self.pixels[(y * self.width + x) as usize]
    }

    /// Covers a share of a pixel; outside the canvas nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, color: Rgb, share: f64) {
        if x >= 0 && y >= 0 && x < self.width && y < self.height {
            let pixel = &mut self.pixels[(y * self.width + x) as usize];
            *pixel = mix(*pixel, color, share.clamp(0.0, 1.0));
        }
    }

    /// Whole pixels from `x0, y0` up to and without `x1, y1`.
    pub fn rectangle(&mut self, x0: i64, y0: i64, x1: i64, y1: i64, color: Rgb) {
        for y in y0.max(0)..y1.min(self.height) {
            for x in x0.max(0)..x1.min(self.width) {
                self.pixels[(y * self.width + x) as usize] = color;
            }
        }
    }

    pub fn frame(&mut self, x0: i64, y0: i64, x1: i64, y1: i64, color: Rgb) {
        self.rectangle(x0, y0, x1, y0 + 1, color);
        self.rectangle(x0, y1 - 1, x1, y1, color);
        self.rectangle(x0, y0, x0 + 1, y1, color);
        self.rectangle(x1 - 1, y0, x1, y1, color);
    }

    /// A smooth disc.
    pub fn disc(&mut self, cx: f64, cy: f64, radius: f64, color: Rgb) {
        for y in (cy - radius - 1.0) as i64..=(cy + radius + 1.0) as i64 {
            for x in (cx - radius - 1.0) as i64..=(cx + radius + 1.0) as i64 {
                let r = (x as f64 + 0.5 - cx).hypot(y as f64 + 0.5 - cy);
                self.blend(x, y, color, radius + 0.5 - r);
            }
        }
    }

    /// A smooth straight line.
    pub fn line(&mut self, a: (f64, f64), b: (f64, f64), width: f64, color: Rgb) {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let square = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        for y in (a.1.min(b.1) - width - 1.0) as i64..=(a.1.max(b.1) + width + 1.0) as i64 {
            for x in (a.0.min(b.0) - width - 1.0) as i64..=(a.0.max(b.0) + width + 1.0) as i64 {
                let (px, py) = (x as f64 + 0.5 - a.0, y as f64 + 0.5 - a.1);
                let t = ((px * dx + py * dy) / square).clamp(0.0, 1.0);
                let r = (px - t * dx).hypot(py - t * dy);
                self.blend(x, y, color, 0.5 * width + 0.5 - r);
            }
        }
    }

    /// Width of a text.
    pub fn measure(size: f64, text: &str) -> f64 {
        let advance = |font: FontRef| {
            let scaled = font.as_scaled(PxScale::from(size as f32));
            let ids: Vec<_> = text.chars().map(|c| scaled.glyph_id(c)).collect();
            let kerns = ids.windows(2).map(|w| scaled.kern(w[0], w[1]));
            kerns.sum::<f32>() + ids.iter().map(|id| scaled.h_advance(*id)).sum::<f32>()
        };
        font().map_or(0.0, |font| f64::from(advance(font)))
    }

    /// Text that begins at `x`, with its baseline at `y`; returns its width.
    pub fn text(&mut self, x: f64, y: f64, size: f64, color: Rgb, text: &str) -> f64 {
        let Some(font) = font() else { return 0.0 };
        let scaled = font.as_scaled(PxScale::from(size as f32));
        let mut pen = 0.0;
        let mut glyphs = Vec::new();
        let mut last = None;
        for c in text.chars() {
            let id = scaled.glyph_id(c);
            pen += last.map_or(0.0, |l| scaled.kern(l, id));
            glyphs.push((id, pen));
            pen += scaled.h_advance(id);
            last = Some(id);
        }
        let width = f64::from(pen);
        for (id, offset) in glyphs {
            let glyph =
                id.with_scale_and_position(scaled.scale(), point(x as f32 + offset, y as f32));
            if let Some(outline) = font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                outline.draw(|gx, gy, share| {
                    let (px, py) = (
                        corner.x as i64 + i64::from(gx),
                        corner.y as i64 + i64::from(gy),
                    );
                    self.blend(px, py, color, f64::from(share));
                });
            }
        }
        width
    }

    pub fn save(&self, path: &Path) -> std::io::Result<()> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header().map_err(std::io::Error::other)?;
        writer
            .write_image_data(self.pixels.as_flattened())
            .map_err(std::io::Error::other)?;
        writer.finish().map_err(std::io::Error::other)?;
        crate::checkpoint::replace(path, &bytes)
    }
}

/// The font is part of the program: pictures do not depend on what a machine has installed.
fn font() -> Option<FontRef<'static>> {
    FontRef::try_from_slice(dejavu::sans::regular()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_leaves_ink_and_stays_inside() {
        let mut c = Canvas::new(120, 30);
        let width = c.text(20.0, 20.0, 16.0, BLACK, "t = 1.5 µs");
        assert!(width > 50.0 && width < 98.0, "{width}");
        assert!((Canvas::measure(16.0, "t = 1.5 µs") - width).abs() < 1e-3);
        let ink = (0..120)
            .filter(|&x| (0..30).any(|y| c.pixel(x, y) != WHITE))
            .count();
        assert!(ink > 40 && c.pixel(1, 15) == WHITE);
        c.text(-500.0, 900.0, 40.0, BLACK, "outside");
        c.disc(-3.0, 1e4, 2.0, BLACK);
    }

    #[test]
    fn lines_and_discs_cover_their_pixels() {
        let mut c = Canvas::new(20, 20);
        c.line((2.0, 10.0), (18.0, 10.0), 2.0, BLACK);
        assert_eq!(c.pixel(10, 10), BLACK);
        assert_eq!(c.pixel(10, 15), WHITE);
        c.disc(5.0, 5.0, 2.0, [255, 0, 0]);
        assert_eq!(c.pixel(5, 4), [255, 0, 0]);
    }
}
