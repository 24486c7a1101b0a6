//! Constants of the law: parameters, case of the flavour, integrals over the horizon.
use super::{Settings, SetupError};
use crate::body::{Body, Flavour};
use crate::layout::{INCLUSIVE, partial_volume};
use crate::spec::Spec;
use crate::tape::{
    Code, Influence, Leaf, Leaves, Limits, Place, ball, length, length_squared, numbers,
};

/// What every reference quantity reads.
pub(super) struct Materials {
    /// Number of materials.
    pub count: usize,
    /// Of a bond from material a to material b, at `a * count + b`.
    pub pairs: Vec<Pair>,
}

/// What two materials have on the bonds between them.
pub(super) struct Pair {
    /// [m]
    pub horizon: f64,
    pub influences: Vec<Influence>,
    pub constants: Vec<f64>,
}

impl Materials {
    /// Constants of the nodes of each material.
    pub fn own(&self) -> Vec<Vec<f64>> {
        (0..self.count)
            .map(|m| self.pairs[m * self.count + m].constants.clone())
            .collect()
    }
}

pub(super) fn materials(
    spec: &Spec,
    body: &Body,
    settings: &Settings,
) -> Result<Materials, SetupError> {
    let fail = |m: String| SetupError::law(&spec.law, m);
    let limits = Limits {
        params: spec.params.len(),
        influences: settings.influences.len(),
        ..Limits::default()
    };
    let code = Code::new(&spec.constants, Place::Constants, &limits, body.flavour)
        .map_err(|e| fail(format!("constants: {e}")))?;
    let count = settings.materials.len();
    let mut pairs = Vec::with_capacity(count * count);
    for (m, a) in settings.materials.iter().enumerate() {
        for (n, b) in settings.materials.iter().enumerate() {
            let horizon = settings.met_horizon(m, n);
            let influences = settings.influences.iter();
            let influences: Vec<Influence> = influences
                .map(|(f, values)| Influence::new(f, values, horizon))
                .collect::<Result<_, _>>()
                .map_err(|e| fail(e.to_string()))?;
            let lattice = match settings.lattice_constants {
                true => Some(full_family(body, horizon, settings.partial_volume)?),
                false => None,
            };
            let ends = spec.params.iter().zip(a.iter().zip(b));
            let params: Result<Vec<f64>, _> = ends.map(|(p, (a, b))| p.meet.of(*a, *b)).collect();
            let params = params.map_err(|e| fail(format!("how parameters meet: {e}")))?;
            let mut leaves = AtConstants {
                code: &code,
                body,
                horizon,
                params: &params,
                influences: &influences,
                lattice: lattice.as_deref(),
                failed: false,
            };
            let mut constants = vec![0.0; code.outs.len()];
            numbers(&code, &mut leaves, &mut constants);
            if leaves.failed {
                return Err(fail(
                    "an integral over the horizon does not converge: choose another influence function"
                        .into(),
                ));
            }
            if let Some(k) = constants.iter().position(|c| c.is_nan()) {
                return Err(fail(format!(
                    "constant {k} is not a number: check the parameters {params:?}"
                )));
            }
            pairs.push(Pair {
                horizon,
                influences,
                constants,
            });
        }
    }
    Ok(Materials { count, pairs })
}

/// Distances and weights of a full lattice family.
fn full_family(body: &Body, delta: f64, partial: bool) -> Result<Vec<(f64, f64)>, SetupError> {
    let Some(grid) = &body.grid else {
        let m = "constants from the lattice need a body on a regular grid: use the integrals over the horizon";
        return Err(SetupError::Settings(m.into()));
    };
    let (dx, dim) = (grid.spacing, body.flavour.dim());
    let h = (delta * INCLUSIVE / dx).floor() as i64;
    let reach = |a: usize| if a < dim { -h..=h } else { 0..=0 };
    let volume = dx.powi(dim as i32) * if dim == 3 { 1.0 } else { body.cross };
    let mut family = vec![];
    for i in reach(0) {
        for j in reach(1) {
            for k in reach(2) {
                let xi = [i, j, k].map(|c| c as f64 * dx);
                let r2 = length_squared(xi, dim);
                if r2 > 0.0 && r2 <= delta * delta * INCLUSIVE {
                    let r = length(xi, dim);
                    let fraction = if partial {
                        partial_volume(r, delta, dx)
                    } else {
                        1.0
                    };
                    family.push((r, fraction * volume));
                }
            }
        }
    }
    Ok(family)
}

struct AtConstants<'a> {
    code: &'a Code,
    body: &'a Body,
    horizon: f64,
    params: &'a [f64],
    influences: &'a [Influence],
    lattice: Option<&'a [(f64, f64)]>,
    failed: bool,
}

impl AtConstants<'_> {
    fn ball(&mut self, inner: &Code) -> f64 {
        let mut at = |r: f64| {
            let mut out = [0.0];
            let leaves = &mut AtDistance {
                params: self.params,
                delta: self.horizon,
                influences: self.influences,
                r,
            };
            numbers(inner, leaves, &mut out);
            out[0]
        };
        if let Some(family) = self.lattice {
            return family.iter().map(|&(r, weight)| at(r) * weight).sum();
        }
        let flavour: Flavour = self.body.flavour;
        ball(&mut at, flavour.dim(), self.horizon, self.body.cross).unwrap_or_else(|| {
            self.failed = true;
            0.0
        })
    }
}

impl Leaves<f64> for AtConstants<'_> {
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Param => self.params[k],
            Leaf::Delta => self.horizon,
            Leaf::Ball => self.ball(&self.code.balls[k]),
            _ => 0.0,
        }
    }
}

/// Inside an integral.
struct AtDistance<'a> {
    params: &'a [f64],
    delta: f64,
    influences: &'a [Influence],
    r: f64,
}

impl Leaves<f64> for AtDistance<'_> {
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Param => self.params[k],
            Leaf::Delta => self.delta,
            Leaf::X => self.r,
            Leaf::Omega => self.influences[k].at(self.r),
            _ => 0.0,
        }
    }
}

/// At a reference bond: what geometry and filter tapes read.
pub(super) struct AtReferenceBond<'a> {
    pub pair: &'a Pair,
    pub xi: [f64; 3],
    pub length: f64,
    pub weight: f64,
}

impl Leaves<f64> for AtReferenceBond<'_> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Const => self.pair.constants[k],
            Leaf::Xi => self.xi[k],
            Leaf::X => self.length,
            Leaf::Omega => self.pair.influences[k].at(self.length),
            Leaf::Weight => self.weight,
            _ => 0.0,
        }
    }
}
