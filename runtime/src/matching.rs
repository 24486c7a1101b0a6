//! Boundaries that let waves out: sides of a lattice whose nodes follow the waves that leave instead of a force.
//!
//! On the outer `layers` planes of a side every component of the displacement obeys `sum c_j u'_j = sum b_j u_j`, over
//! the node itself (`j = 0`) and its `order` neighbours inwards. The coefficients are those for which a plane wave that
//! leaves along the normal fulfils the condition to the order `2 N` of its wave number (Nicely, Tang and Qian 2018, nonlocal
//! matching boundary conditions, eq. 45 to 51 and 60); they follow from the law's own dispersion on the lattice, one
//! chain of lattice planes for every component (`chain.rs`), and so serve any law. With as many layers as the law
//! reaches planes far, every node that moves by its force has whole families, and so have the nodes of these.
//!
//! Not every order is stable: `growth.rs` decides before a run. It sees waves along the normal. Those at an angle, along the
//! sides and in corners have nobody to judge them, and where a law's short waves run backwards, some grow: so in two and
//! three dimensions waves of few spacings lose their energy in a [`Strip`] of planes inside of the boundary.

mod chain;
mod coefficients;
mod growth;
mod strip;

pub use chain::Chain;
pub use coefficients::{Coefficients, Rule, Steps, root_series};
pub use growth::{Growth, growth};
pub use strip::Strip;

use crate::body::Body;
use crate::engine::{Law, Settings};
use crate::error::{About, InputError};
use crate::spec::{FieldSpec, Stage};

/// The highest order there is.
pub const MOST: usize = 4;
/// Growth up to this share of the largest frequency is none [1].
pub const STILL: f64 = 1e-8;
/// How far a law may look: the step of a closed bar is a dense matrix.
const MOST_PLANES: usize = 64;

/// A side of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Side {
    pub axis: usize,
    /// Whether it is the one of the largest coordinates.
    pub high: bool,
}

impl Side {
    pub const NAMES: [&str; 6] = ["-x", "+x", "-y", "+y", "-z", "+z"];

    pub fn name(self) -> &'static str {
        Side::NAMES[2 * self.axis + usize::from(self.high)]
    }

    pub fn opposite(self) -> Side {
        Side {
            high: !self.high,
            ..self
        }
    }

    /// All sides of a body of `dim` dimensions.
    pub fn all(dim: usize) -> impl Iterator<Item = Side> {
        (0..2 * dim).map(|k| Side {
            axis: k / 2,
            high: k % 2 == 1,
        })
    }
}

/// What the components of the displacement match.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Match {
    /// The normal one longitudinal waves, the others transverse ones.
    #[default]
    Own,
    /// Longitudinal and transverse waves, every component: waves that meet a side at an angle have all of both.
    Both,
    /// All longitudinal waves, as the paper has it: a control.
    Longitudinal,
}

/// What a scene says about matching boundaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Matching {
    pub sides: Vec<Side>,
    /// `N`, from 1 to [`MOST`].
    pub order: usize,
    /// Planes of nodes; `None`: as many as the law reaches.
    pub layers: Option<usize>,
    pub rule: Rule,
    pub waves: Match,
    /// Planes of the [`Strip`]; `None`: in two and three dimensions twice as many as the law looks far, in one none.
    pub smooth: Option<usize>,
    /// Whether an order that grows is run nevertheless.
    pub unstable: bool,
}

/// A side with all that its nodes need.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    pub side: Side,
    /// Coordinate of the outermost plane of cells.
    pub end: u32,
    pub layers: usize,
    pub rule: Rule,
    /// One per component of the displacement.
    pub components: Vec<Waves>,
    pub strip: Strip,
    /// Material of the side.
    pub material: usize,
}

impl std::fmt::Display for Face {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let order = self
            .components
            .first()
            .and_then(|w| w.conditions.first())
            .map_or(0, Coefficients::order);
        let planes = if self.layers == 1 { "plane" } else { "planes" };
        write!(
            f,
            "side {}, order {order}, {} {planes} of nodes",
            self.side.name(),
            self.layers
        )?;
        match (self.strip.planes, self.strip.cramped) {
            (0, false) => {}
            (0, true) => write!(f, ", no room to damp short waves in")?,
            (planes, false) => write!(f, ", short waves damped in {planes} more")?,
            (planes, true) => write!(
                f,
                ", short waves damped in {planes} more, as many as there is room for"
            )?,
        }
        if let Some(normal) = self.components.get(self.side.axis) {
            if self.layers < normal.chain.looks {
                let looks = normal.chain.looks;
                write!(
                    f,
                    ", fewer than the {looks} that the law looks far: families are cut"
                )?;
            }
            let back = |n: f64| 100.0 * normal.reflection(2.0 * std::f64::consts::PI / n);
            write!(
                f,
                "; of waves of 10, 20, 40 spacings {:.2}, {:.2}, {:.3} % come back",
                back(10.0),
                back(20.0),
                back(40.0)
            )?;
        }
        Ok(())
    }
}

impl Waves {
    /// Amplitude of what comes back of a wave whose phase turns by `phase` from plane to plane, over its own.
    pub fn reflection(&self, phase: f64) -> f64 {
        let omega = self.chain.square(phase).max(0.0).sqrt();
        let each = self.conditions.iter().map(|c| c.reflection(phase, omega));
        each.product()
    }

    /// How many neighbours inwards the conditions read.
    pub fn deep(&self) -> usize {
        self.conditions.iter().map(Coefficients::order).sum()
    }
}

impl Face {
    /// How many neighbours inwards its conditions read.
    pub fn deep(&self) -> usize {
        self.components.iter().map(Waves::deep).max().unwrap_or(1)
    }

    /// Whether a node is in its layers.
    pub(crate) fn holds(&self, node: usize, body: &Body) -> bool {
        let cell = body.grid.as_ref().map(|g| g.cell[node]);
        cell.is_some_and(|c| self.depth(c) < self.layers)
    }

    /// Of a cell, in planes.
    fn depth(&self, cell: [u32; 3]) -> usize {
        cell[self.side.axis].abs_diff(self.end) as usize
    }

    /// Rate at which the node of a cell exchanges velocity with its neighbours [1/s].
    pub(crate) fn exchange(&self, cell: [u32; 3]) -> f64 {
        self.strip.rate(self.depth(cell).checked_sub(self.layers))
    }
}

/// What a component follows.
#[derive(Clone, Debug, PartialEq)]
pub struct Waves {
    /// One, or two that are taken one behind the other: the component's own first.
    pub conditions: Vec<Coefficients>,
    pub chain: Chain,
    pub growth: Growth,
}

/// Axis, material and components of a side.
type Known = (usize, usize, Vec<Waves>);

/// Coefficients and layers of every side, each once.
///
/// # Errors
/// A body without a grid, a side that is given twice, is periodic or no plane of the lattice, an order that cannot be had
/// or would grow.
pub(crate) fn faces(
    list: &[Matching],
    body: &Body,
    law: &Law,
    settings: &Settings,
    density: &[f64],
) -> Result<Vec<Face>, InputError> {
    let mut faces: Vec<Face> = Vec::new();
    for matching in list {
        // The waves of one side of an axis are those of the other.
        let mut known: Vec<Known> = Vec::new();
        for side in &matching.sides {
            let about = |e: InputError| e.about(About::Matching(*side));
            if faces.iter().any(|f| f.side == *side) {
                return Err(about(InputError::new(
                    format!("the side {} has two matching boundaries", side.name()),
                    "name every side once",
                )));
            }
            let both = list.iter().any(|m| m.sides.contains(&side.opposite()));
            let given = face(
                matching,
                (*side, both),
                body,
                law,
                settings,
                (density, &mut known),
            );
            faces.push(given.map_err(about)?);
        }
    }
    faces.sort_by_key(|f| f.side.axis);
    room(&faces, body)?;
    Ok(faces)
}

/// `both`: whether the other end of the body has a boundary as well.
fn face(
    matching: &Matching,
    (side, both): (Side, bool),
    body: &Body,
    law: &Law,
    settings: &Settings,
    (density, known): (&[f64], &mut Vec<Known>),
) -> Result<Face, InputError> {
    let name = side.name();
    if law.spec.force.is_empty() {
        return Err(InputError::new(
            format!(
                "`{}` has no force, so that no wave of it can be matched",
                law.spec.law
            ),
            "matching boundaries are for laws that move",
        ));
    }
    if body.periodic[side.axis].is_some() {
        return Err(InputError::new(
            format!("the body is periodic across its side {name}"),
            "a matching boundary is the end of a body: name another side",
        ));
    }
    let stepped = |f: &&FieldSpec| law.spec.rates.iter().any(|r| f.slots.contains(&r.field));
    let read = law.spec.read_by(Stage::Tangent);
    let decides = |f: &&FieldSpec| f.slots.iter().any(|s| read.contains(s)) && !stepped(f);
    if let Some(field) = law.spec.fields.iter().find(decides) {
        return Err(InputError::new(
            format!(
                "`{}` has the field `{}`, which a scene sets, and waves depend on it",
                law.spec.law, field.name
            ),
            "a matching boundary takes laws without such fields: use an absorbing layer",
        ));
    }
    let (end, material) = outermost(side, body)?;
    let own = settings.met_horizon(material, material);
    if settings.horizon.iter().any(|h| *h > own) || !body.horizon.is_empty() {
        return Err(InputError::new(
            "a matching boundary takes one horizon, and other nodes of this body have longer ones",
            "give a constant horizon",
        ));
    }
    let dim = body.flavour.dim();
    let chains = (0..dim)
        .map(|a| {
            let chain = chain::of_law(body, law, settings, material, side.axis, a)?;
            Ok(chain.over(density[material]))
        })
        .collect::<Result<Vec<Chain>, InputError>>()?;
    let looks = chains.iter().map(|c| c.looks).max().unwrap_or(1);
    if looks > MOST_PLANES {
        return Err(InputError::new(
            format!(
                "the law looks {looks} planes of nodes far, more than the {MOST_PLANES} that can be matched"
            ),
            "a horizon of a few spacings is usual",
        ));
    }
    let layers = matching.layers.unwrap_or(looks);
    let usual = if dim > 1 { 2 * looks } else { 0 };
    let thick = thickness(side.axis, body);
    // In the middle of the body a plane is left as it is.
    let own = if both { (thick - 1) / 2 } else { thick - 1 };
    let fits = own.saturating_sub(layers);
    let planes = matching.smooth.unwrap_or(usual.min(fits));
    if planes > fits {
        return Err(InputError::new(
            format!(
                "the strip inside of the side {name} is to have {planes} planes of nodes, and the body is {thick} planes thick: \
                 it would be damped as a whole"
            ),
            match fits {
                0 => "there is no room for a strip: smooth = 0".to_string(),
                _ => format!("at most {fits} fit: smooth = {fits}"),
            },
        ));
    }
    let mut strip = Strip::new(planes, dim, &chains[side.axis]);
    strip.cramped = matching.smooth.is_none() && planes < usual;
    one_material(side, (end, layers.saturating_add(looks.max(planes))), body)?;
    let same = known.iter().find(|k| (k.0, k.1) == (side.axis, material));
    let components = match same {
        Some((_, _, components)) => components.clone(),
        None => {
            let components = (0..dim)
                .map(|a| waves(matching, side, a, &chains, &strip))
                .collect::<Result<Vec<Waves>, InputError>>()?;
            known.push((side.axis, material, components.clone()));
            components
        }
    };
    Ok(Face {
        side,
        end,
        layers,
        rule: matching.rule,
        components,
        strip,
        material,
    })
}

/// The conditions of a component.
fn waves(
    matching: &Matching,
    side: Side,
    component: usize,
    chains: &[Chain],
    strip: &Strip,
) -> Result<Waves, InputError> {
    let (normal, chain) = (side.axis, &chains[component]);
    // The first direction across the normal stands for all.
    let across = (0..chains.len()).find(|a| *a != normal);
    let followed = match (matching.waves, across) {
        (Match::Longitudinal, _) => vec![normal],
        (Match::Both, Some(across)) if component == normal => vec![normal, across],
        (Match::Both, Some(_)) => vec![component, normal],
        _ => vec![component],
    };
    let of = |order: usize| -> Option<Vec<Coefficients>> {
        let each = followed.iter().map(|a| {
            let chain = &chains[*a];
            Coefficients::of(&chain.series(order), order, chain.spacing)
        });
        each.collect()
    };
    let named = ["x", "y", "z"][component];
    let why = |what: &str| {
        let others = |n: &usize| *n != matching.order;
        let holds = |n: &usize| {
            of(*n).is_some_and(|c| growth(chain, &c, matching.rule, strip).rate <= STILL)
        };
        let largest = (1..=MOST).rev().filter(others).find(holds);
        InputError::new(
            format!(
                "a matching boundary of order {} on the side {} {what} (component {named})",
                matching.order,
                side.name()
            ),
            match (largest, matching.waves) {
                (Some(order), _) => format!("the largest order that works here is {order}"),
                (None, Match::Both) => "leave `waves` out, or use an absorbing layer".into(),
                (None, _) => "no order works here: use an absorbing layer".into(),
            },
        )
    };
    if chain.reach() == 0 {
        return Err(why("has no wave to match: nothing resists a motion"));
    }
    let Some(conditions) = of(matching.order) else {
        return Err(
            match followed.iter().any(|a| chains[*a].series(1).is_empty()) {
                true => why("has no wave to match: nothing resists a motion"),
                false => why("has no coefficients: their equations are singular"),
            },
        );
    };
    let growth = growth(chain, &conditions, matching.rule, strip);
    if growth.rate > STILL && !matching.unstable {
        return Err(why(&growth.sentence(chain, &conditions)));
    }
    Ok(Waves {
        conditions,
        chain: chain.clone(),
        growth,
    })
}

/// Coordinate and material of the outermost plane of cells.
fn outermost(side: Side, body: &Body) -> Result<(u32, usize), InputError> {
    let Some(grid) = &body.grid else {
        return Err(InputError::new(
            "matching boundaries are planes of a lattice, and the nodes of this body are not on one",
            "give the body by its shape and spacing, or use an absorbing layer",
        ));
    };
    let along = || grid.cell.iter().map(|c| c[side.axis]);
    let end = if side.high {
        along().max()
    } else {
        along().min()
    }
    .unwrap_or(0);
    let outer = along().position(|c| c == end).unwrap_or(0);
    let material = body.material.get(outer).copied().unwrap_or(0);
    Ok((end, material.into()))
}

/// Refuses a side that has several materials as deep as nodes of its boundary look.
fn one_material(side: Side, (end, deep): (u32, usize), body: &Body) -> Result<(), InputError> {
    let Some(grid) = &body.grid else {
        return Ok(());
    };
    let near = |(_, c): &(usize, &[u32; 3])| (c[side.axis].abs_diff(end) as usize) < deep;
    let near = grid.cell.iter().enumerate().filter(near);
    let mut materials = near.map(|(node, _)| body.material.get(node).copied().unwrap_or(0));
    let first = materials.next();
    match materials.all(|m| Some(m) == first) {
        true => Ok(()),
        false => Err(InputError::new(
            format!(
                "the side {} has several materials within {deep} planes of nodes",
                side.name()
            ),
            "a matching boundary takes one",
        )),
    }
}

/// Whether the body is thick enough for what stands on two opposite sides.
fn room(faces: &[Face], body: &Body) -> Result<(), InputError> {
    for axis in 0..body.flavour.dim() {
        let of_axis: Vec<&Face> = faces.iter().filter(|f| f.side.axis == axis).collect();
        let Some(first) = of_axis.first() else {
            continue;
        };
        let inner = of_axis.iter().map(|f| f.deep()).max().unwrap_or(1);
        let needed = of_axis
            .iter()
            .fold(inner, |sum, f| sum.saturating_add(f.layers));
        let planes = thickness(axis, body);
        if planes < needed {
            return Err(InputError::new(
                format!(
                    "the body is {planes} planes of nodes thick across its side {}, and matching boundaries need {needed}",
                    first.side.name()
                ),
                "make the body thicker, or the horizon shorter",
            )
            .about(About::Matching(first.side)));
        }
    }
    Ok(())
}

/// Planes of nodes from one side of a lattice to the other.
fn thickness(axis: usize, body: &Body) -> usize {
    let along = || (body.grid.iter()).flat_map(|g| g.cell.iter().map(move |c| c[axis]));
    let (low, high) = (along().min().unwrap_or(0), along().max().unwrap_or(0));
    (high - low) as usize + 1
}
