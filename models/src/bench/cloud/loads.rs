//! What kernels of a cloud read at the other ends of eight bonds.
use pdlang_runtime::pages::zeros;
use std::arch::x86_64::*;
use std::collections::HashMap;

/// Columns ahead at which slots and numbers of bonds are fetched.
const AHEAD: usize = 24;

/// Three components of a node in half a cache line.
#[derive(Clone)]
#[repr(C, align(32))]
pub struct Record(pub [f64; 4]);

/// Those of slots that are listed, eight by eight.
pub fn pack(v: &[Vec<f64>; 3], records: &mut [Record], listed: &[bool]) {
    let eight = records.chunks_mut(8).enumerate();
    for (block, records) in eight.filter(|(block, _)| listed[*block]) {
        for (slot, r) in (8 * block..).zip(records) {
            r.0 = [v[0][slot], v[1][slot], v[2][slot], 0.0];
        }
    }
}

/// Three numbers of every node, as arrays and as records.
pub struct Numbers<'a> {
    arrays: [*const f64; 3],
    records: *const Record,
    of: std::marker::PhantomData<&'a Record>,
}

impl<'a> Numbers<'a> {
    pub fn new((arrays, records): (&'a [Vec<f64>; 3], &'a Vec<Record>)) -> Numbers<'a> {
        Numbers {
            arrays: [0, 1, 2].map(|a| arrays[a].as_ptr()),
            records: records.as_ptr(),
            of: std::marker::PhantomData,
        }
    }

    /// Of the nodes from a slot on.
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub unsafe fn own(&self, at: usize) -> [__m512d; 3] {
        let mut v = [_mm512_setzero_pd(); 3];
        let mut a = 0;
        while a < 3 {
            v[a] = unsafe { _mm512_loadu_pd(self.arrays[a].add(at)) };
            a += 1;
        }
        v
    }

    #[inline]
    #[target_feature(enable = "avx512f")]
    unsafe fn at<const RUN: bool>(&self, index: *const u32) -> [__m512d; 3] {
        unsafe {
            if RUN {
                self.own(*index as usize)
            } else {
                let [x, y, z, _] = four(self.records, index);
                [x, y, z]
            }
        }
    }
}

/// Where the slots of a column stand, eight of them or the first; those some columns behind it are fetched.
#[inline]
pub fn fetch<const RUN: bool>(places: *const u32, row: usize) -> *const u32 {
    if RUN {
        places.wrapping_add(row)
    } else {
        let index = places.wrapping_add(8 * row);
        ahead(index);
        index
    }
}

/// Fetches what is read some columns later.
#[inline]
fn ahead<T>(p: *const T) {
    // SAFETY: a prefetch never faults.
    unsafe { _mm_prefetch::<_MM_HINT_NTA>(p.wrapping_add(8 * AHEAD).cast()) }
}

/// The four numbers of eight records.
#[inline]
#[target_feature(enable = "avx512f")]
pub unsafe fn four(v: *const Record, index: *const u32) -> [__m512d; 4] {
    unsafe {
        let mut r = [_mm512_setzero_pd(); 4];
        let mut k = 0;
        while k < 4 {
            let low = _mm256_load_pd(v.add(*index.add(k) as usize).cast());
            let high = _mm256_load_pd(v.add(*index.add(k + 4) as usize).cast());
            r[k] = _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high);
            k += 1;
        }
        let (even, even2) = (
            _mm512_unpacklo_pd(r[0], r[1]),
            _mm512_unpacklo_pd(r[2], r[3]),
        );
        let (odd, odd2) = (
            _mm512_unpackhi_pd(r[0], r[1]),
            _mm512_unpackhi_pd(r[2], r[3]),
        );
        let low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(even, low, even2),
            _mm512_permutex2var_pd(odd, low, odd2),
            _mm512_permutex2var_pd(even, high, even2),
            _mm512_permutex2var_pd(odd, high, odd2),
        ]
    }
}

/// Eight single values.
#[inline]
#[target_feature(enable = "avx512f,avx")]
pub unsafe fn single<const RUN: bool>(v: *const f64, index: *const u32) -> __m512d {
    unsafe {
        if RUN {
            return _mm512_loadu_pd(v.add(*index as usize));
        }
        let mut pair = [_mm_setzero_pd(); 4];
        let mut k = 0;
        while k < 4 {
            let low = _mm_load_sd(v.add(*index.add(2 * k) as usize));
            pair[k] = _mm_loadh_pd(low, v.add(*index.add(2 * k + 1) as usize));
            k += 1;
        }
        let low = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair[0]), pair[1]);
        let high = _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair[2]), pair[3]);
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    }
}

/// A number of every bond: eight per row, or, where few rows differ, eight for each of these and a place per row.
#[derive(Default)]
pub struct Stream {
    pub values: Vec<f64>,
    rows: Vec<u32>,
}

/// Rows that must share eight numbers on average for them to be kept apart.
const SHARED: usize = 16;

impl Stream {
    /// Once all numbers are there. What stands in lanes without a bond is masked everywhere: like another of the row, it makes
    /// no row that differs.
    pub fn keep(&mut self, bits: &[u8]) {
        let (mut found, mut values) = (HashMap::new(), vec![]);
        let mut rows: Vec<u32> = zeros(bits.len());
        for ((row, bits), place) in self.values.chunks_exact(8).zip(bits).zip(&mut rows) {
            let there = row[bits.trailing_zeros() as usize % 8];
            let number = |lane: usize| {
                if bits >> lane & 1 == 1 {
                    row[lane]
                } else {
                    there
                }
            };
            let row: [f64; 8] = std::array::from_fn(number);
            *place = *found.entry(row.map(f64::to_bits)).or_insert_with(|| {
                values.extend(row);
                (values.len() / 8 - 1) as u32
            });
            if values.len() / 8 * SHARED > self.values.len() / 8 {
                self.values = in_large_pages(&self.values);
                return;
            }
        }
        (self.values, self.rows) = (values, rows);
    }

    fn row(&self, row: usize) -> usize {
        self.rows.get(row).map_or(row, |place| *place as usize)
    }

    pub fn number(&self, row: usize, lane: usize) -> f64 {
        self.values[8 * self.row(row) + lane]
    }

    /// Eight numbers of a row, the ones that come later fetched ahead.
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub unsafe fn at(&self, row: usize) -> __m512d {
        unsafe {
            let p = self.values.as_ptr();
            if self.rows.is_empty() {
                ahead(p.add(8 * row));
                return _mm512_loadu_pd(p.add(8 * row));
            }
            _mm512_loadu_pd(p.add(8 * *self.rows.as_ptr().add(row) as usize))
        }
    }
}

pub fn in_large_pages<T: Copy + Default>(v: &[T]) -> Vec<T> {
    let mut copy = zeros(v.len());
    copy.copy_from_slice(v);
    copy
}

/// Eight bonds, with |Y|^2 and |xi|^2.
pub struct Bonds {
    pub xi: [__m512d; 3],
    pub eta: [__m512d; 3],
    pub y: [__m512d; 3],
    pub square: __m512d,
    pub reference: __m512d,
}

impl Bonds {
    #[inline]
    #[target_feature(enable = "avx512f")]
    pub unsafe fn new<const RUN: bool>(
        x: &Numbers,
        u: &Numbers,
        xi: &[__m512d; 3],
        ui: &[__m512d; 3],
        index: *const u32,
    ) -> Bonds {
        let (xj, uj) = unsafe { (x.at::<RUN>(index), u.at::<RUN>(index)) };
        let (mut xi, mut eta, mut y) = (*xi, *ui, *ui);
        let mut a = 0;
        while a < 3 {
            xi[a] = _mm512_sub_pd(xj[a], xi[a]);
            eta[a] = _mm512_sub_pd(uj[a], ui[a]);
            y[a] = _mm512_add_pd(xi[a], eta[a]);
            a += 1;
        }
        let (square, reference) = (norm(&y), norm(&xi));
        Bonds {
            xi,
            eta,
            y,
            square,
            reference,
        }
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn norm(v: &[__m512d; 3]) -> __m512d {
    let two = _mm512_fmadd_pd(v[1], v[1], _mm512_mul_pd(v[0], v[0]));
    _mm512_fmadd_pd(v[2], v[2], two)
}

/// Y = xi + eta, |Y|^2, |xi|^2.
#[inline]
#[target_feature(enable = "avx512f")]
pub unsafe fn deformed<const RUN: bool>(
    x: &Numbers,
    u: &Numbers,
    xi: &[__m512d; 3],
    ui: &[__m512d; 3],
    index: *const u32,
) -> ([__m512d; 3], __m512d, __m512d) {
    let bond = unsafe { Bonds::new::<RUN>(x, u, xi, ui, index) };
    (bond.y, bond.square, bond.reference)
}
