//! PMB and frozen LPS as the generator emits them.
use pdlang_runtime::kernel::{
    Bond, CompiledKernel, Entries, Lane, Node, Streams, Sweep, norm_squared,
};
use pdlang_runtime::sweep_entries;

/// f = sum (c w) (1/x - 1/y) Y, broken where y^2 is above the limit; geometry (c w, limit), streams (c w, limit/x^2).
pub struct PmbForce;

impl Sweep<3> for PmbForce {
    type Pre<L: Lane> = [L; 0];
    type Acc<L: Lane> = [L; 3];
    const STREAMS: usize = 2;
    #[inline(always)]
    fn zero<L: Lane>(&self) -> [L; 3] {
        [L::splat(0.0); 3]
    }
    #[inline(always)]
    fn pre<L: Lane, N: Node<L>>(&self, _node: &N) -> [L; 0] {
        []
    }
    #[inline(always)]
    fn bond<L: Lane, B: Bond<L, 3>>(&self, _pre: &[L; 0], b: &mut B, acc: &mut [L; 3]) {
        let r0 = b.xi(0).add(b.eta(0));
        let r1 = b.xi(1).add(b.eta(1));
        let r2 = b.xi(2).add(b.eta(2));
        let r3 = r0.mul(r0);
        let r4 = r1.fma(r1, r3);
        let r5 = r2.fma(r2, r4);
        let r6 = r5.rsqrt();
        b.kill(b.geo(1).lt(r5));
        let r7 = b.ix().sub(r6);
        let r8 = b.geo(0).mul(r7);
        b.add(&mut acc[0], r8, r0);
        b.add(&mut acc[1], r8, r1);
        b.add(&mut acc[2], r8, r2);
    }
    #[inline(always)]
    fn post<L: Lane, N: Node<L>>(&self, _pre: &[L; 0], acc: &[L; 3], n: &mut N) {
        n.out(0, acc[0]);
        n.out(1, acc[1]);
        n.out(2, acc[2]);
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, 3> + Streams<L>>(&self, b: &B, k: usize) -> L {
        match k {
            0 => b.stream(0),
            _ => b.stream(1).mul(norm_squared([b.xi(0), b.xi(1), b.xi(2)])),
        }
    }
}

/// theta m / 3 = sum (omega w x^2) (y (1/x - 1/y)); geometry (omega w x^2, limit), streams (the same,
/// limit/x^2).
/// Own: 9 (3K - 5G) / m^2 for the first output A = (3K - 5G) theta / m.
pub struct LpsDilatation;

impl Sweep<3> for LpsDilatation {
    type Pre<L: Lane> = [L; 1];
    type Acc<L: Lane> = [L; 1];
    const STREAMS: usize = 2;
    #[inline(always)]
    fn zero<L: Lane>(&self) -> [L; 1] {
        [L::splat(0.0); 1]
    }
    #[inline(always)]
    fn pre<L: Lane, N: Node<L>>(&self, n: &N) -> [L; 1] {
        [n.own(0)]
    }
    #[inline(always)]
    fn bond<L: Lane, B: Bond<L, 3>>(&self, _pre: &[L; 1], b: &mut B, acc: &mut [L; 1]) {
        let r0 = b.xi(0).add(b.eta(0));
        let r1 = b.xi(1).add(b.eta(1));
        let r2 = b.xi(2).add(b.eta(2));
        let r3 = r0.mul(r0);
        let r4 = r1.fma(r1, r3);
        let r5 = r2.fma(r2, r4);
        let r6 = r5.rsqrt();
        b.kill(b.geo(1).lt(r5));
        let r7 = b.ix().sub(r6);
        let r8 = r5.mul(r6);
        let r9 = r8.mul(r7);
        b.add(&mut acc[0], b.geo(0), r9);
    }
    #[inline(always)]
    fn post<L: Lane, N: Node<L>>(&self, pre: &[L; 1], acc: &[L; 1], n: &mut N) {
        n.out(0, acc[0].mul(pre[0]));
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, 3> + Streams<L>>(&self, b: &B, k: usize) -> L {
        match k {
            0 => b.stream(0),
            _ => b.stream(1).mul(norm_squared([b.xi(0), b.xi(1), b.xi(2)])),
        }
    }
}

/// f = sum (omega w x) ((A_i + A_j) / y + (B_i + B_j) (1/x - 1/y)) Y; geometry (omega w x),
/// stream (omega w x^2).
pub struct LpsForce;

impl Sweep<3> for LpsForce {
    type Pre<L: Lane> = [L; 2];
    type Acc<L: Lane> = [L; 3];
    const STREAMS: usize = 1;
    #[inline(always)]
    fn zero<L: Lane>(&self) -> [L; 3] {
        [L::splat(0.0); 3]
    }
    #[inline(always)]
    fn pre<L: Lane, N: Node<L>>(&self, n: &N) -> [L; 2] {
        [n.own(0), n.own(1)]
    }
    #[inline(always)]
    fn bond<L: Lane, B: Bond<L, 3>>(&self, pre: &[L; 2], b: &mut B, acc: &mut [L; 3]) {
        let r0 = b.xi(0).add(b.eta(0));
        let r1 = b.xi(1).add(b.eta(1));
        let r2 = b.xi(2).add(b.eta(2));
        let r3 = r0.mul(r0);
        let r4 = r1.fma(r1, r3);
        let r5 = r2.fma(r2, r4);
        let r6 = r5.rsqrt();
        let r7 = b.ix().sub(r6);
        let r8 = pre[0].add(b.nbr(0));
        let r9 = pre[1].add(b.nbr(1));
        let r10 = r8.mul(r6);
        let r11 = r9.fma(r7, r10);
        let r12 = b.geo(0).mul(r11);
        b.add(&mut acc[0], r12, r0);
        b.add(&mut acc[1], r12, r1);
        b.add(&mut acc[2], r12, r2);
    }
    #[inline(always)]
    fn post<L: Lane, N: Node<L>>(&self, _pre: &[L; 2], acc: &[L; 3], n: &mut N) {
        n.out(0, acc[0]);
        n.out(1, acc[1]);
        n.out(2, acc[2]);
    }
    #[inline(always)]
    fn geo<L: Lane, B: Bond<L, 3> + Streams<L>>(&self, b: &B, _k: usize) -> L {
        b.stream(0).mul(b.ix())
    }
}

const PMB_FORCE: Entries = sweep_entries!(PmbForce, 3);
const LPS_DILATATION: Entries = sweep_entries!(LpsDilatation, 3);
const LPS_FORCE: Entries = sweep_entries!(LpsForce, 3);

/// Sweeps of [`super::tapes::pmb`].
pub static PMB: CompiledKernel = CompiledKernel {
    dim: 3,
    spec: "",
    sweeps: &[(0, PMB_FORCE)],
};

/// Sweeps of [`super::tapes::lps`]; the first, over the reference family, is interpreted.
pub static LPS: CompiledKernel = CompiledKernel {
    dim: 3,
    spec: "",
    sweeps: &[(1, LPS_DILATATION), (2, LPS_FORCE)],
};
