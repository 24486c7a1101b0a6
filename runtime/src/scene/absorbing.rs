//! `[[absorbing]]`: sides with a rim that takes waves in. A layer is no more than initial values of the law's damping
//! rates, one for every direction, which rise from its inner edge to the side; and its bonds hold.

use std::ops::Range;

use super::problem::Problem;
use super::section::Section;
use crate::body::Body;
use crate::conditions::{Condition, Expression, Quantity};
use crate::error::InputError;
use crate::language::Exponents;
use crate::language::dimension::{LENGTH, NUMBER};
use crate::matching::Side;
use crate::shape::Shape;
use crate::spec::{FieldSpec, Op, Spec, Tape};

const RATE: Exponents = [0, 0, -2, 0, 0, 0, 0];
/// Where a scene says nothing.
const ACROSS: f64 = 0.05;

/// A layer at one or more sides of the body.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    sides: Vec<Side>,
    /// From the inner edge to the outermost nodes [m].
    thickness: f64,
    /// Length over which the rate rises, from the inner edge [m].
    ramp: f64,
    /// The largest [1/s].
    rate: f64,
    profile: Profile,
    /// Part of the rate by which the layer damps along its side as well: 0 takes waves in without an echo, and grows where
    /// free sides run into it (Meza-Fajardo and Papageorgiou 2008).
    across: f64,
    /// The law's damping rates.
    field: String,
    pub span: Range<usize>,
}

/// How the rate rises, `s` being the part of the ramp behind.
#[derive(Clone, Copy, Debug)]
enum Profile {
    /// `exp(-ln(1e6) (1 - s)^2)`: Wildman and Gazonas.
    Gaussian,
    /// `s^2`.
    Quadratic,
}

const PROFILES: [(&str, Profile); 2] = [
    ("gaussian", Profile::Gaussian),
    ("quadratic", Profile::Quadratic),
];

pub(super) fn read(section: Section<'_>, spec: &Spec) -> Option<Layer> {
    let sides = super::matching::sides(&section, spec.dim);
    let sides = section.require("sides", sides, "[\"-x\", \"+x\"], or \"all\"");
    let thickness = section.positive("thickness", LENGTH);
    let thickness = section.require("thickness", thickness, "\"30*dx\"");
    let rate = section.positive("rate", RATE);
    let rate = section.require("rate", rate, "\"5 [1/us]\", the largest damping rate");
    let ramp = section.positive("ramp", LENGTH);
    let ramp = match (section.value("ramp"), ramp) {
        (None, _) => thickness.as_ref().map(|t| t.value),
        (Some(_), Some(ramp)) if thickness.as_ref().is_some_and(|t| ramp.value > t.value) => {
            let problem = Problem::new("`ramp` must not be longer than the layer is thick").at(
                ramp.span,
                format!("this is {}", section.reader.shown(ramp.value, LENGTH)),
            );
            section.reader.complain(problem);
            None
        }
        (Some(_), ramp) => ramp.map(|r| r.value),
    };
    let profile = match section.value("profile") {
        None => Some(Profile::Gaussian),
        Some(_) => section.choice("profile", &PROFILES),
    };
    let across = across(&section);
    let field = field(&section, spec);
    let span = section.span.clone();
    section.finish();
    Some(Layer {
        sides: sides?,
        thickness: thickness?.value,
        ramp: ramp?,
        rate: rate?.value,
        profile: profile?,
        across: across?,
        field: field?,
        span,
    })
}

fn across(section: &Section<'_>) -> Option<f64> {
    if section.value("across").is_none() {
        return Some(ACROSS);
    }
    let part = section.quantity("across", NUMBER)?;
    if (0.0..=1.0).contains(&part.value) {
        return Some(part.value);
    }
    let problem = Problem::new("`across` must be a part of the rate")
        .at(part.span, "expected a number from 0 to 1")
        .help(format!("{ACROSS} is usual; 0 damps across the layer alone"));
    section.reader.complain(problem);
    None
}

/// The only field that holds a rate for every direction and does not change by itself.
fn field(section: &Section<'_>, spec: &Spec) -> Option<String> {
    let stepped = |f: &FieldSpec| spec.rates.iter().any(|r| f.slots.contains(&r.field));
    let rates = |f: &&FieldSpec| {
        f.exponents == RATE
            && f.components.len() == spec.dim
            && !stepped(f)
            && !spec.force.is_empty()
    };
    let found: Vec<&FieldSpec> = spec.fields.iter().filter(rates).collect();
    if let [only] = found[..] {
        return Some(only.name.clone());
    }
    let problem = Problem::new(format!(
        "`{}` does not have a field of damping rates, so that no layer of it takes waves in",
        spec.law
    ))
    .at(section.span.clone(), "")
    .help("a layer takes the law `absorbing`; [[matching]] lets waves of other laws out");
    section.reader.complain(problem);
    None
}

/// What the layers of a body are to a run.
#[derive(Default)]
pub(super) struct Rim {
    /// The damping rates; none without a layer.
    pub rates: Option<Condition>,
    /// From the inner edges on. Bonds with an end here never break: what a layer remembers knows nothing of a crack that
    /// grows into it.
    pub holds: Vec<Shape>,
}

/// The layers on a body, and which of them is wrong where they do not fit.
pub(super) fn rim(layers: &[Layer], body: &Body) -> Result<Rim, (usize, InputError)> {
    let Some(first) = layers.first() else {
        return Ok(Rim::default());
    };
    let dim = body.flavour.dim();
    let walls: Vec<Wall> = (0..dim)
        .map(|axis| at_ends(layers, axis, body))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    Ok(Rim {
        rates: Some(rates(layers, first, &walls, dim)),
        holds: walls.iter().map(|w| w.region(layers)).collect(),
    })
}

fn rates(layers: &[Layer], first: &Layer, walls: &[Wall], dim: usize) -> Condition {
    let rate = |axis: usize| {
        let mut tape = Builder::default();
        let mut sum = None;
        for wall in walls {
            let part = if wall.axis == axis {
                1.0
            } else {
                layers[wall.layer].across
            };
            let one = tape.layer(&layers[wall.layer], wall, part);
            sum = Some(match sum {
                None => one,
                Some(sum) => tape.push(Op::Add(sum, one)),
            });
        }
        sum.map(|out| Expression {
            text: "[[absorbing]]".into(),
            tape: Tape {
                ops: tape.ops,
                outs: vec![out],
            },
        })
    };
    Condition {
        region: Shape::All,
        quantity: Quantity::Field(first.field.clone()),
        value: (0..dim).map(rate).collect(),
        mirror: None,
        until: f64::INFINITY,
    }
}

/// A side with a layer.
#[derive(Clone, Copy)]
struct Wall {
    axis: usize,
    high: bool,
    /// Coordinate of the outermost nodes [m].
    at: f64,
    layer: usize,
}

impl Wall {
    fn region(&self, layers: &[Layer]) -> Shape {
        let (mut from, mut to) = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
        let thick = layers[self.layer].thickness;
        match self.high {
            true => from[self.axis] = self.at - thick,
            false => to[self.axis] = self.at + thick,
        }
        Shape::Box { from, to }
    }
}

/// The sides across an axis that have a layer, if the layers fit.
fn at_ends(layers: &[Layer], axis: usize, body: &Body) -> Result<Vec<Wall>, (usize, InputError)> {
    let along = || body.x.iter().map(|x| x[axis]);
    let low = along().fold(f64::INFINITY, f64::min);
    let high = along().fold(f64::NEG_INFINITY, f64::max);
    let mut walls: Vec<Wall> = Vec::new();
    for (k, layer) in layers.iter().enumerate() {
        for side in layer.sides.iter().filter(|s| s.axis == axis) {
            fits(layer, *side, high - low, body).map_err(|e| (k, e))?;
            if walls.iter().any(|w| w.high == side.high) {
                let what = format!("the side {} has two layers", side.name());
                return Err((k, InputError::new(what, "name a side once")));
            }
            walls.push(Wall {
                axis,
                high: side.high,
                at: if side.high { high } else { low },
                layer: k,
            });
        }
    }
    if let [a, b] = walls[..] {
        let both = layers[a.layer].thickness + layers[b.layer].thickness;
        if both >= high - low {
            return Err((b.layer, overlap(axis, both, high - low)));
        }
    }
    Ok(walls)
}

/// Whether there is such a side, and whether the body is as thick as its layer.
fn fits(layer: &Layer, side: Side, size: f64, body: &Body) -> Result<(), InputError> {
    let (name, axis) = (side.name(), ["x", "y", "z"][side.axis]);
    let thick = layer.thickness;
    if body.periodic[side.axis].is_some() {
        return Err(InputError::new(
            format!("the body is periodic along {axis}: it has no side {name}"),
            "a layer is at the end of a body: name other sides",
        ));
    }
    if thick >= size {
        return Err(InputError::new(
            format!(
                "the layer at the side {name} is {thick} m thick, and the body measures {size} m along {axis}"
            ),
            "make the layer thinner, or the body larger: waves need room in front of it",
        ));
    }
    if thick < body.spacing {
        return Err(InputError::new(
            format!(
                "the layer at the side {name} is {thick} m thick, less than the spacing of {} m",
                body.spacing
            ),
            "20 to 30 spacings are usual: thickness = \"30*dx\"",
        ));
    }
    Ok(())
}

fn overlap(axis: usize, both: f64, size: f64) -> InputError {
    let axis = ["x", "y", "z"][axis];
    InputError::new(
        format!(
            "the layers at the sides -{axis} and +{axis} are {both} m thick together, and the body measures {size} m: they overlap"
        ),
        "make the layers thinner, or the body larger: waves need room between them",
    )
}

/// Straight-line code of the damping rate of one direction.
#[derive(Default)]
struct Builder {
    ops: Vec<Op>,
}

impl Builder {
    fn push(&mut self, op: Op) -> u32 {
        self.ops.push(op);
        self.ops.len() as u32 - 1
    }

    fn number(&mut self, value: f64) -> u32 {
        self.push(Op::Lit(value))
    }

    /// A part of the rate of a layer: 0 in front of its inner edge.
    fn layer(&mut self, layer: &Layer, wall: &Wall, part: f64) -> u32 {
        let sign = if wall.high { 1.0 } else { -1.0 };
        let x = self.push(Op::Var(wall.axis as u32));
        // Depth below the inner edge over the ramp.
        let slope = self.number(sign / layer.ramp);
        let start = self.number((layer.thickness - sign * wall.at) / layer.ramp);
        let depth = self.push(Op::Fma(slope, x, start));
        let (zero, one) = (self.number(0.0), self.number(1.0));
        let share = self.push(Op::Min(depth, one));
        let rate = self.number(part * layer.rate);
        let shape = match layer.profile {
            Profile::Quadratic => self.push(Op::Powi(share, 2)),
            Profile::Gaussian => {
                let rest = self.push(Op::Sub(one, share));
                let square = self.push(Op::Powi(rest, 2));
                let fall = self.number(-(1e6_f64.ln()));
                let power = self.push(Op::Mul(fall, square));
                self.push(Op::Exp(power))
            }
        };
        let value = self.push(Op::Mul(rate, shape));
        let inside = self.push(Op::Lt(zero, depth));
        self.push(Op::Select(inside, value, zero))
    }
}
