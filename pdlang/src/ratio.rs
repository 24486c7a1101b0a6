//! Exact coefficients. Sums cancel only if 3 times a third is one.

/// A rational number in lowest terms, denominator positive.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct Ratio {
    num: i128,
    den: i128,
}

fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Ratio {
    pub const ZERO: Ratio = Ratio { num: 0, den: 1 };
    pub const ONE: Ratio = Ratio { num: 1, den: 1 };

    pub fn int(n: i64) -> Ratio {
        Ratio {
            num: n as i128,
            den: 1,
        }
    }

    fn new(num: i128, den: i128) -> Option<Ratio> {
        if den == 0 {
            return None;
        }
        let g = gcd(num, den).max(1) * den.signum();
        Some(Ratio {
            num: num / g,
            den: den / g,
        })
    }

    /// The decimal that a person wrote, if it is short enough to be kept exactly.
    pub fn from_f64(v: f64) -> Option<Ratio> {
        if !v.is_finite() {
            return None;
        }
        let text = format!("{v:e}");
        let (mantissa, exponent) = text.split_once('e')?;
        let exponent: i32 = exponent.parse().ok()?;
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits: i128 = format!("{whole}{fraction}").parse().ok()?;
        let shift = exponent - fraction.len() as i32;
        if !(-15..=15).contains(&shift) {
            return None;
        }
        let power = 10i128.checked_pow(shift.unsigned_abs())?;
        if shift >= 0 {
            Ratio::new(digits.checked_mul(power)?, 1)
        } else {
            Ratio::new(digits, power)
        }
    }

    /// Numerator and denominator.
    pub fn parts(self) -> (i128, i128) {
        (self.num, self.den)
    }

    pub fn value(self) -> f64 {
        self.num as f64 / self.den as f64
    }

    pub fn is_zero(self) -> bool {
        self.num == 0
    }

    pub fn is_negative(self) -> bool {
        self.num < 0
    }

    pub fn is_one(self) -> bool {
        self == Ratio::ONE
    }

    pub fn as_int(self) -> Option<i32> {
        if self.den == 1 {
            i32::try_from(self.num).ok()
        } else {
            None
        }
    }

    /// Twice the number, if that is an integer.
    pub fn twice_int(self) -> Option<i32> {
        self.mul(Ratio::int(2))?.as_int()
    }

    pub fn neg(self) -> Ratio {
        Ratio {
            num: -self.num,
            den: self.den,
        }
    }

    pub fn add(self, b: Ratio) -> Option<Ratio> {
        let num = self
            .num
            .checked_mul(b.den)?
            .checked_add(b.num.checked_mul(self.den)?)?;
        Ratio::new(num, self.den.checked_mul(b.den)?)
    }

    pub fn mul(self, b: Ratio) -> Option<Ratio> {
        Ratio::new(self.num.checked_mul(b.num)?, self.den.checked_mul(b.den)?)
    }

    pub fn div(self, b: Ratio) -> Option<Ratio> {
        self.mul(Ratio::new(b.den, b.num)?)
    }

    pub fn powi(self, n: i32) -> Option<Ratio> {
        let mut r = Ratio::ONE;
        for _ in 0..n.unsigned_abs() {
            r = r.mul(self)?;
        }
        if n < 0 { Ratio::ONE.div(r) } else { Some(r) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_are_exact() {
        let third = Ratio::ONE.div(Ratio::int(3)).unwrap();
        assert_eq!(third.mul(Ratio::int(3)), Some(Ratio::ONE));
        assert_eq!(Ratio::from_f64(0.25), Ratio::new(1, 4));
        assert_eq!(Ratio::from_f64(14.9e9), Some(Ratio::int(14_900_000_000)));
        assert_eq!(Ratio::from_f64(1e-30), None);
        assert_eq!(Ratio::from_f64(f64::INFINITY), None);
    }
}
