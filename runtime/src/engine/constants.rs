//! Constants of the law: parameters, case of the flavour, integrals over the horizon.
use super::meets::{Fractions, HALVES, Regions, Rule};
use super::{Settings, SetupError};
use crate::body::Body;
use crate::layout::{INCLUSIVE, partial_volume};
use crate::spec::Spec;
use crate::tape::{
    Code, Influence, Leaf, Leaves, Limits, Place, ball, length, length_squared, numbers,
};
use rayon::prelude::*;
use std::sync::OnceLock;

/// What every reference quantity reads.
pub(super) struct Materials<'a> {
    /// Number of materials.
    pub count: usize,
    /// Of a bond from material a to material b, at `a * count + b`.
    pub pairs: Vec<Pair>,
    maker: Maker<'a>,
    regions: Regions,
    /// What went wrong on a bond between two materials.
    failure: OnceLock<SetupError>,
}

/// What two materials have on the bonds between them, from both ends.
#[derive(Clone)]
pub(super) struct Pair {
    /// [m]
    pub horizon: f64,
    pub influences: Vec<Influence>,
    /// Where they depend on how much of a bond lies in either material, those of half in each.
    pub constants: Vec<f64>,
    by_lengths: Option<ByLengths>,
}

/// What is the same on all bonds of a pair whose constants are not.
#[derive(Clone)]
struct ByLengths {
    /// Integrals over the horizon, by position; `None` where the lengths count.
    balls: Vec<Option<f64>>,
    /// A full lattice family, where sums over it stand for integrals.
    lattice: Option<Vec<(f64, f64)>>,
}

impl<'a> Materials<'a> {
    pub fn new(
        spec: &'a Spec,
        body: &'a Body,
        settings: &'a Settings,
    ) -> Result<Materials<'a>, SetupError> {
        let maker = Maker::new(spec, body, settings)?;
        let count = settings.materials.len();
        let half: Vec<Pair> = (0..count * count)
            .into_par_iter()
            .filter(|pair| pair / count <= pair % count)
            .map(|pair| maker.pair(pair / count, pair % count))
            .collect::<Result<_, _>>()?;
        // Rows of a triangle, each shorter by one than the one before.
        let place = |a: usize, b: usize| a * count - a * (a + 1) / 2 + b;
        let pair = |k: usize| {
            let (a, b) = (k / count, k % count);
            half[place(a.min(b), a.max(b))].clone()
        };
        Ok(Materials {
            count,
            pairs: (0..count * count).map(pair).collect(),
            maker,
            regions: Regions::new(body),
            failure: OnceLock::new(),
        })
    }

    /// Constants of the nodes, material after material.
    pub fn own(&self) -> Vec<f64> {
        (0..self.count)
            .flat_map(|m| self.pairs[m * self.count + m].constants.clone())
            .collect()
    }

    /// Constants on a bond between a pair of materials, by the positions of its ends. `room` is for them where the bond
    /// has its own. What goes wrong is told by [`Materials::check`].
    pub fn on_bond<'r>(
        &'r self,
        pair: usize,
        ends: [[f64; 3]; 2],
        room: &'r mut Vec<f64>,
    ) -> &'r [f64] {
        let Some(by_lengths) = &self.pairs[pair].by_lengths else {
            return &self.pairs[pair].constants;
        };
        // From the end with the first material, so that both ends have the same bits.
        let (mut a, mut b) = (pair / self.count, pair % self.count);
        let [mut from, mut to] = ends;
        if a > b {
            (a, b, from, to) = (b, a, to, from);
        }
        let pair = &self.pairs[a * self.count + b];
        let params = self.maker.params(a, b, self.regions.fractions(from, to));
        let made = AtConstants {
            maker: &self.maker,
            horizon: pair.horizon,
            params: &params,
            influences: &pair.influences,
            lattice: by_lengths.lattice.as_deref(),
            balls: by_lengths.balls.clone(),
            failed: false,
        }
        .constants();
        *room = made.map_or_else(
            |error| {
                self.failure.get_or_init(|| error);
                pair.constants.clone()
            },
            |made| made.0,
        );
        room
    }

    /// Whether bonds of one pair may have constants of their own.
    pub fn by_lengths(&self) -> bool {
        self.pairs.iter().any(|pair| pair.by_lengths.is_some())
    }

    /// # Errors
    /// The first that [`Materials::on_bond`] met.
    pub fn check(&self) -> Result<(), SetupError> {
        self.failure.get().map_or(Ok(()), |e| Err(e.clone()))
    }
}

/// What the constants of all pairs are made of.
struct Maker<'a> {
    spec: &'a Spec,
    body: &'a Body,
    settings: &'a Settings,
    code: Code,
    /// How each parameter meets.
    rules: Vec<Rule>,
}

impl<'a> Maker<'a> {
    fn new(
        spec: &'a Spec,
        body: &'a Body,
        settings: &'a Settings,
    ) -> Result<Maker<'a>, SetupError> {
        let limits = Limits {
            params: spec.params.len(),
            influences: settings.influences.len(),
            ..Limits::default()
        };
        let code = Code::new(&spec.constants, Place::Constants, &limits, body.flavour)
            .map_err(|e| SetupError::law(&spec.law, format!("constants: {e}")))?;
        Ok(Maker {
            spec,
            body,
            settings,
            code,
            rules: Rule::all(spec)?,
        })
    }

    /// Parameters on a bond between two materials.
    fn params(&self, a: usize, b: usize, fractions: Fractions) -> Vec<f64> {
        let [a, b] = [a, b].map(|m| &self.settings.materials[m]);
        let ends = self.rules.iter().zip(a.iter().zip(b));
        ends.map(|(rule, (a, b))| rule.of(*a, *b, fractions))
            .collect()
    }

    fn pair(&self, a: usize, b: usize) -> Result<Pair, SetupError> {
        let settings = self.settings;
        let horizon = settings.met_horizon(a, b);
        let influences = settings.influences.iter();
        let influences: Vec<Influence> = influences
            .map(|(f, values)| Influence::new(f, values, horizon))
            .collect::<Result<_, _>>()
            .map_err(|e| SetupError::law(&self.spec.law, e))?;
        let lattice = match settings.lattice_constants {
            true => Some(full_family(self.body, horizon, settings.partial_volume)?),
            false => None,
        };
        let params = self.params(a, b, HALVES);
        let (constants, balls) = AtConstants {
            maker: self,
            horizon,
            params: &params,
            influences: &influences,
            lattice: lattice.as_deref(),
            balls: vec![None; self.code.balls.len()],
            failed: false,
        }
        .constants()?;
        let [p, q] = [a, b].map(|m| &settings.materials[m]);
        let varies = |k: usize| self.rules[k].by_lengths() && p[k] != q[k];
        let fixed = |(ball, value): (&Code, Option<f64>)| value.filter(|_| !ball.reads(&varies));
        let by_lengths = (0..params.len()).any(varies).then(|| ByLengths {
            balls: self.code.balls.iter().zip(balls).map(fixed).collect(),
            lattice,
        });
        Ok(Pair {
            horizon,
            influences,
            constants,
            by_lengths,
        })
    }
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
    maker: &'a Maker<'a>,
    horizon: f64,
    params: &'a [f64],
    influences: &'a [Influence],
    lattice: Option<&'a [(f64, f64)]>,
    /// Integrals, as far as they are known.
    balls: Vec<Option<f64>>,
    failed: bool,
}

impl AtConstants<'_> {
    /// The constants, and the integrals in them.
    fn constants(mut self) -> Result<(Vec<f64>, Vec<Option<f64>>), SetupError> {
        let fail = |m: String| SetupError::law(&self.maker.spec.law, m);
        let mut constants = vec![0.0; self.maker.code.outs.len()];
        numbers(&self.maker.code, &mut self, &mut constants);
        if self.failed {
            return Err(fail(
                "an integral over the horizon does not converge: choose another influence function"
                    .into(),
            ));
        }
        if let Some(k) = constants.iter().position(|c| c.is_nan()) {
            return Err(fail(format!(
                "constant {k} is not a number: check the parameters {:?}",
                self.params
            )));
        }
        Ok((constants, self.balls))
    }

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
        let body = self.maker.body;
        let dim = body.flavour.dim();
        ball(&mut at, dim, self.horizon, body.cross).unwrap_or_else(|| {
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
            Leaf::Ball => match self.balls[k] {
                Some(known) => known,
                None => {
                    let value = self.ball(&self.maker.code.balls[k]);
                    self.balls[k] = Some(value);
                    value
                }
            },
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
    pub constants: &'a [f64],
    pub influences: &'a [Influence],
    pub xi: [f64; 3],
    pub length: f64,
    pub weight: f64,
}

impl AtReferenceBond<'_> {
    #[inline(always)]
    pub fn value(&self, leaf: Leaf, k: usize) -> f64 {
        match leaf {
            Leaf::Const => self.constants[k],
            Leaf::Xi => self.xi[k],
            Leaf::X => self.length,
            Leaf::Omega => self.influences[k].at(self.length),
            Leaf::Weight => self.weight,
            _ => 0.0,
        }
    }
}

impl Leaves<f64> for AtReferenceBond<'_> {
    #[inline(always)]
    fn leaf(&mut self, leaf: Leaf, k: usize) -> f64 {
        self.value(leaf, k)
    }
}
