//! Colour scales: number in 0..1 to colour.

pub type Rgb = [u8; 3];

/// Which scale suits a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// From pale stone over fire to black: what is whole stays quiet, cracks stand out.
    Damage,
    /// From dark to bright with even steps of lightness (after viridis).
    Even,
    /// Blue, white, red about 0.
    Signed,
}

const DAMAGE: [Rgb; 6] = [
    [222, 224, 226],
    [247, 203, 131],
    [240, 130, 62],
    [199, 43, 46],
    [117, 11, 52],
    [30, 4, 24],
];
const EVEN: [Rgb; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];
const SIGNED: [Rgb; 7] = [
    [33, 60, 140],
    [67, 123, 191],
    [165, 201, 226],
    [243, 243, 243],
    [244, 176, 140],
    [214, 84, 70],
    [140, 16, 38],
];

impl Scale {
    /// Colour at `t`; outside 0..1 that of the nearer end, NaN is magenta.
    pub fn color(self, t: f64) -> Rgb {
        if t.is_nan() {
            return [255, 0, 255];
        }
        let stops: &[Rgb] = match self {
            Scale::Damage => &DAMAGE,
            Scale::Even => &EVEN,
            Scale::Signed => &SIGNED,
        };
        let at = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
        let k = (at as usize).min(stops.len() - 2);
        mix(stops[k], stops[k + 1], at - k as f64)
    }
}

/// From `a` (0) to `b` (1).
pub fn mix(a: Rgb, b: Rgb, t: f64) -> Rgb {
    std::array::from_fn(|c| {
        (f64::from(a[c]) + t * (f64::from(b[c]) - f64::from(a[c]))).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_met() {
        assert_eq!(Scale::Even.color(-1.0), EVEN[0]);
        assert_eq!(Scale::Even.color(1.0), EVEN[8]);
        assert_eq!(Scale::Signed.color(0.5), SIGNED[3]);
        assert_eq!(Scale::Damage.color(f64::NAN), [255, 0, 255]);
    }
}
