//! Every lane type against `f64`, lane by lane.
use super::*;

const A: [f64; 8] = [1.5, -2.25, 3.0e-7, 4.0e12, 0.3, -1e-3, 7.0, 0.9];
const B: [f64; 8] = [0.5, 2.25, -3.0e-7, 5.0e11, 0.3, 1e-4, -7.5, 2.1];

/// Runs `f` on both arrays through the lanes of one type.
#[inline(always)]
fn through<L: Memory>(f: impl Fn(L, L) -> L) -> [f64; 8] {
    let mut out = [0.0; 8];
    let mut k = 0;
    while k < 8 {
        // SAFETY: k + W <= 8.
        unsafe {
            f(L::load(A[k..].as_ptr()), L::load(B[k..].as_ptr())).store(out[k..].as_mut_ptr())
        };
        k += L::W;
    }
    out
}

fn close(found: [f64; 8], expected: impl Fn(f64, f64) -> f64, tolerance: f64) {
    for k in 0..8 {
        let e = expected(A[k], B[k]);
        let same = found[k] == e || found[k].is_nan() && e.is_nan();
        assert!(
            same || (found[k] / e - 1.0).abs() <= tolerance,
            "lane {k}: {} is not {e}",
            found[k]
        );
    }
}

#[inline(always)]
fn check<L: Records>() {
    close(through(|a: L, b| a.add(b)), |a, b| a + b, 0.0);
    close(through(|a: L, b| a.sub(b)), |a, b| a - b, 0.0);
    close(through(|a: L, b| a.mul(b)), |a, b| a * b, 0.0);
    close(through(|a: L, b| a.div(b)), |a, b| a / b, 0.0);
    close(through(|a: L, b| a.min(b)), f64::min, 0.0);
    close(through(|a: L, b| a.max(b)), f64::max, 0.0);
    close(through(|a: L, _| a.neg()), |a, _| -a, 0.0);
    close(through(|a: L, _| a.abs()), |a, _| a.abs(), 0.0);
    close(
        through(|a: L, _| a.abs().sqrt()),
        |a, _| a.abs().sqrt(),
        0.0,
    );
    close(through(|a: L, _| a.exp()), |a, _| a.exp(), 0.0);
    close(through(|a: L, _| a.ln()), |a, _| a.ln(), 0.0);
    close(
        through(|a: L, b| a.abs().pow(b)),
        |a, b| a.abs().powf(b),
        0.0,
    );
    close(
        through(|a: L, b| a.fma(b, L::splat(1.0))),
        |a, b| a.mul_add(b, 1.0),
        1e-15,
    );
    close(through(|a: L, _| a.powi(3)), |a, _| a * (a * a), 0.0);
    close(through(|a: L, _| a.powi(-2)), |a, _| 1.0 / (a * a), 0.0);
    close(through(|a: L, _| a.powi(0)), |_, _| 1.0, 0.0);
    close(
        through(|a: L, b| L::select(a.lt(b), a, b)),
        |a, b| if a < b { a } else { b },
        0.0,
    );
    close(
        through(|a: L, b| L::select(L::not(b.le(a)), a, b)),
        |a, b| if b <= a { b } else { a },
        0.0,
    );
    let either = |a: L, b: L| L::or(a.lt(L::splat(0.0)), b.lt(L::splat(0.0)));
    close(
        through(|a: L, b| L::select(either(a, b), L::splat(1.0), L::splat(2.0))),
        |a, b| if a < 0.0 || b < 0.0 { 1.0 } else { 2.0 },
        0.0,
    );
    let nan = L::splat(f64::NAN);
    assert_eq!(L::bits(nan.lt(nan)) & ((1 << L::W) - 1), 0);
    // Two units in the last place over the range of squared lengths.
    for exponent in -200..200 {
        for m in [1.0, 1.1, 1.7, 2.3, 3.9] {
            let x = m * 2f64.powi(exponent);
            let y = L::splat(x).rsqrt().first();
            assert!((y * x.sqrt() - 1.0).abs() < 5e-16, "{x}");
        }
    }
    memory::<L>();
}

#[inline(always)]
fn memory<L: Records>() {
    let index = [3u32, 0, 7, 7, 2, 5, 1, 6];
    let records: Vec<Record> = A
        .iter()
        .zip(B)
        .map(|(&a, b)| Record([a, b, a + b, a - b]))
        .collect();
    let mut out = [0.0; 8];
    let mut parts = [[0.0; 8]; 4];
    let mut k = 0;
    while k < 8 {
        // SAFETY: k + W <= 8, and every index is below 8.
        unsafe {
            L::gather(A.as_ptr(), index[k..].as_ptr()).store(out[k..].as_mut_ptr());
            let all = L::gather_records(records.as_ptr(), index[k..].as_ptr());
            for (part, v) in parts.iter_mut().zip(all) {
                v.store(part[k..].as_mut_ptr());
            }
        }
        k += L::W;
    }
    for (k, &i) in index.iter().enumerate() {
        let (a, b) = (A[i as usize], B[i as usize]);
        assert_eq!(out[k], a);
        assert_eq!([0, 1, 2, 3].map(|c| parts[c][k]), [a, b, a + b, a - b]);
    }
    for bits in 0..1 << L::W {
        assert_eq!(L::bits(L::mask(bits)), bits);
    }
}

#[test]
fn scalar_lane() {
    check::<f64>();
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx2_lane() {
    #[target_feature(enable = "avx2,fma")]
    fn inside() {
        check::<Avx2>();
    }
    if Isa::Avx2.available() {
        // SAFETY: the processor has the instruction set.
        unsafe { inside() }
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn avx512_lane() {
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    fn inside() {
        check::<Avx512>();
    }
    if Isa::Avx512.available() {
        // SAFETY: the processor has the instruction set.
        unsafe { inside() }
    }
}

/// Lanes of single precision against `f32`, with memory of both precisions and masks of one or two chunks.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn check_single<L: Memory<Near = f32>>() {
    let a: [f64; 16] = std::array::from_fn(|k| A[k % 8] * (1.0 + k as f64 / 16.0));
    let b: [f64; 16] = std::array::from_fn(|k| B[k % 8] * (1.0 - k as f64 / 32.0));
    let near = a.map(|v| v as f32);
    let close = |f: fn(L, L) -> L, expected: fn(f32, f32) -> f32| {
        let mut out = [0.0; 16];
        // SAFETY: arrays have as many numbers as the widest lane.
        unsafe { f(L::near(near.as_ptr()), L::load(b.as_ptr())).store(out.as_mut_ptr()) };
        for k in 0..L::W {
            let e = expected(a[k] as f32, b[k] as f32);
            let same = out[k] as f32 == e || out[k].is_nan() && e.is_nan();
            assert!(same, "lane {k}: {} is not {e}", out[k]);
        }
    };
    close(|a, b| a.add(b), |a, b| a + b);
    close(|a, b| a.sub(b), |a, b| a - b);
    close(|a, b| a.mul(b), |a, b| a * b);
    close(|a, b| a.div(b), |a, b| a / b);
    close(|a, b| a.min(b), f32::min);
    close(|a, b| a.max(b), f32::max);
    close(|a, b| a.fma(b, L::spread(1.0)), |a, b| a.mul_add(b, 1.0));
    close(|a, _| a.neg(), |a, _| -a);
    close(|a, _| a.abs().sqrt(), |a, _| a.abs().sqrt());
    close(|a, _| a.abs().rsqrt(), |a, _| 1.0 / a.abs().sqrt());
    close(|a, _| a.exp(), |a, _| a.exp());
    close(|a, b| a.abs().pow(b), |a, b| a.abs().powf(b));
    close(|a, _| a.powi(-2), |a, _| 1.0 / (a * a));
    close(
        |a, b| L::select(a.lt(b), a, b),
        |a, b| if a < b { a } else { b },
    );
    close(
        |a, b| L::select(L::and(a.le(b), L::not(b.lt(L::splat(0.0)))), a, b),
        |a, b| if a <= b && b >= 0.0 { a } else { b },
    );
    let index: [u32; 16] = std::array::from_fn(|k| (5 * k as u32 + 3) % 16);
    let mut out = [0.0; 16];
    // SAFETY: as above, and every index is below 16.
    unsafe { L::gather(a.as_ptr(), index.as_ptr()).store(out.as_mut_ptr()) };
    for k in 0..L::W {
        assert_eq!(out[k] as f32, a[index[k] as usize] as f32);
    }
    for bits in 0..=u16::MAX >> (16 - L::W) {
        let mask = L::mask(bits);
        assert_eq!(L::bits(mask), bits);
        let mut out = [7.0; 16];
        // SAFETY: as above.
        unsafe { L::splat(1.5).store_where(mask, out.as_mut_ptr()) };
        for (k, v) in out.iter().enumerate() {
            let set = bits >> k & 1 == 1;
            assert_eq!(*v, if set { 1.5 } else { 7.0 });
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[test]
fn single_lanes() {
    #[target_feature(enable = "avx2,fma")]
    fn eight() {
        check_single::<Single>();
    }
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
    fn sixteen() {
        check_single::<Wide>();
    }
    if Isa::Avx2.available() {
        // SAFETY: the processor has the instruction set.
        unsafe { eight() }
    }
    if Isa::Avx512.available() {
        // SAFETY: as above.
        unsafe { sixteen() }
    }
}
