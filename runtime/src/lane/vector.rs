//! What the vector types have alike, each by its own instructions.

/// A register, and its numbers one by one.
macro_rules! vector {
    ($(#[$doc:meta])* $lane:ident($register:ident), [$number:ident; $width:literal], $load:ident, $store:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $lane($register);

        impl $lane {
            #[inline(always)]
            fn to_array(self) -> [$number; $width] {
                let mut a = [0.0; $width];
                unsafe { $store(a.as_mut_ptr(), self.0) };
                a
            }
            #[inline(always)]
            fn from_array(a: [$number; $width]) -> Self {
                Self(unsafe { $load(a.as_ptr()) })
            }
        }

        impl Sealed for $lane {}
    };
}

/// Functions of [`crate::kernel::Lane`]; those that have no instruction go lane by lane through the standard library.
macro_rules! arithmetic {
    (
        $($two:ident: $by:ident),*;
        fma: $fma:ident, sqrt: $sqrt:ident, xor: $xor:ident, andnot: $andnot:ident,
        splat: $splat:ident of $number:ident
    ) => {
        #[inline(always)]
        fn splat(v: f64) -> Self {
            Self(unsafe { $splat(v as $number) })
        }
        $(
            #[inline(always)]
            fn $two(self, b: Self) -> Self {
                Self(unsafe { $by(self.0, b.0) })
            }
        )*
        #[inline(always)]
        fn fma(self, b: Self, c: Self) -> Self {
            Self(unsafe { $fma(self.0, b.0, c.0) })
        }
        #[inline(always)]
        fn neg(self) -> Self {
            Self(unsafe { $xor(self.0, $splat(-0.0)) })
        }
        #[inline(always)]
        fn abs(self) -> Self {
            Self(unsafe { $andnot($splat(-0.0), self.0) })
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { $sqrt(self.0) })
        }
        $crate::lane::vector::lane_by_lane!(exp, ln, sin, cos, tan);
        #[inline(always)]
        fn pow(self, b: Self) -> Self {
            let (mut a, b) = (self.to_array(), b.to_array());
            let mut k = 0;
            while k < Self::W {
                a[k] = a[k].powf(b[k]);
                k += 1;
            }
            Self::from_array(a)
        }
        #[inline(always)]
        fn powi(self, n: i32) -> Self {
            powi(self, n)
        }
    };
}

macro_rules! lane_by_lane {
    ($($name:ident),*) => {$(
        #[inline(always)]
        fn $name(self) -> Self {
            let mut a = self.to_array();
            let mut k = 0;
            while k < Self::W {
                a[k] = a[k].$name();
                k += 1;
            }
            Self::from_array(a)
        }
    )*};
}

pub(super) use {arithmetic, lane_by_lane, vector};
