//! What layers and matching boundaries send back, beside a domain too large to reflect: on three waves, and against the
//! angle and the length of a wave. `pdlang bench waves` shows the same as tables and curves.

use pdlang_runtime::observe::Schedule;
use pdlang_runtime::simulate::Simulation;

use super::Tolerance::{AtMost, Off, Part};
use super::case::Case;
use super::{Measure, Study};

pub const STUDIES: &[Study] = &[
    Study {
        id: "waves-three",
        about: "Energy left inside of what was there at the start: a long hump (40 spacings) that meets an end straight on, the \
                waves of a push in a square, a short packet (10 spacings) that meets an end at 60 degrees. References: the same \
                in a body too large to reflect; 1, the energy that a free or a held end keeps.",
        long: false,
        measure: three,
    },
    Study {
        id: "waves-angle",
        about: "Amplitude that comes back of a packet of longitudinal waves (layer-packet): root of the energy of the \
                difference from a longer strip. References: 1 of a free end; (1 - cos a)/(1 + cos a) of a condition of order 1.",
        long: false,
        measure: angle,
    },
    Study {
        id: "waves-angle",
        about: "The same of longitudinal and transverse waves of 20 spacings at a layer of 20 planes; bounds are 0.6 of what a matching \
                boundary sends back of the same wave: the more a wave grazes, the less it is damped.",
        long: true,
        measure: angles,
    },
    Study {
        id: "waves-stable",
        about: "The square of the three waves with layers of 10 planes, 100,000 steps of 0.95 of the stable step: largest \
                energy of the second half over that of the start, and over the largest of the first half behind 10,000 steps.",
        long: true,
        measure: stable,
    },
];

/// What is stored in the bonds of a held edge, or not yet back [1].
const KEPT: f64 = 0.05;
/// Longitudinal speed of the scenes, of size 1.
const C: f64 = 1.095_445_115_010_332_3;
/// As many planes as the law reaches at its horizon of 2.8 spacings.
const PLANES: u32 = 4;

/// What stands at an end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    Held,
    Free,
    /// Planes of nodes; the rate in wave speeds over thicknesses, how it rises, and the part that damps along the side.
    Layer(u32, Damping),
    Matching(u32),
    /// The body goes on for as long as a wave travels.
    Far,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    pub rate: f64,
    pub profile: &'static str,
    pub across: f64,
}

/// What a scene gets that says no more than it must.
pub const USUAL: Damping = Damping {
    rate: 20.0,
    profile: "gaussian",
    across: 0.05,
};

impl End {
    /// Those of the three waves.
    pub const ALL: [End; 7] = [
        End::Held,
        End::Free,
        End::Matching(1),
        End::Layer(10, USUAL),
        End::Layer(20, USUAL),
        End::Layer(40, USUAL),
        End::Far,
    ];

    pub fn name(self) -> String {
        match self {
            End::Held => "held edge".into(),
            End::Free => "free edge".into(),
            End::Layer(planes, _) => format!("layer of {planes} planes"),
            End::Matching(order) => format!("matching, order {order}"),
            End::Far => "large domain".into(),
        }
    }

    /// Planes of nodes behind the interior; those of the far end are `far`.
    fn planes(self, far: u32) -> u32 {
        match self {
            End::Free => 0,
            End::Held => 3,
            End::Layer(planes, _) => planes,
            End::Matching(_) => PLANES,
            End::Far => far,
        }
    }

    fn law(self) -> &'static str {
        match self {
            End::Layer(..) => "absorbing",
            _ => "correspondence",
        }
    }

    /// What a scene says of its `sides`; `held` is the region of a held edge.
    fn section(self, sides: &str, dx: f64, held: &str) -> String {
        match self {
            End::Free | End::Far => String::new(),
            End::Held => format!("[[condition]]\nregion = {held}\ndisplacement = [0, 0]\n"),
            End::Matching(order) => format!("[[matching]]\nsides = {sides}\norder = {order}\n"),
            End::Layer(planes, damping) => {
                let thick = f64::from(planes) * dx;
                let Damping {
                    rate,
                    profile,
                    across,
                } = damping;
                let rate = rate * C / thick;
                format!(
                    "[[absorbing]]\nsides = {sides}\nthickness = {thick}\nrate = {rate}\nprofile = \"{profile}\"\n\
                     across = {across}\n"
                )
            }
        }
    }
}

/// A packet of waves that runs along a strip, or a hump.
#[derive(Clone, Copy, Debug)]
pub struct Packet {
    pub transverse: bool,
    /// To the normal of the end [degrees].
    pub angle: f64,
    /// In spacings, nearly: a whole number of them fits across the strip.
    pub length: f64,
    pub hump: bool,
}

/// Of the strip in front of its end.
struct Strip {
    case: Case,
    /// Position of the last node that is not of the end.
    inside: f64,
    /// When what came back is where it was [s].
    until: f64,
}

impl Packet {
    pub fn of(transverse: bool, angle: f64, length: f64) -> Packet {
        Packet {
            transverse,
            angle,
            length,
            hump: false,
        }
    }

    fn rows(&self) -> f64 {
        match self.angle {
            0.0 => 8.0,
            angle => (self.length / angle.to_radians().sin()).round(),
        }
    }

    /// Length of the wave that the strip has [spacings].
    pub fn true_length(&self) -> f64 {
        match self.angle {
            0.0 => self.length,
            angle => self.rows() * angle.to_radians().sin(),
        }
    }

    fn strip(&self, end: End) -> Result<Strip, String> {
        let text = include_str!("../../../examples/layer-packet.toml");
        let k = 2.0 * std::f64::consts::PI / self.true_length();
        let (k_x, k_y) = (
            k * self.angle.to_radians().cos(),
            k * self.angle.to_radians().sin(),
        );
        let width = match self.hump {
            true => self.length / 2.0,
            false => 3.0 * std::f64::consts::PI / k_x,
        };
        let inside = (7.0 * width).round();
        let c = if self.transverse { 0.4_f64.sqrt() } else { C };
        let until = 7.0 * width * k / (c * k_x);
        let rim = end.planes(inside as u32 + 40);
        let case = Case::new("layer-packet", text)
            .with("rows = 40 ", &format!("rows = {} ", self.rows()))?
            .with("k_y = \"2*pi/rows\"", &format!("k_y = {k_y}"))?
            .with("k_x = \"k_y/tan(angle)\"", &format!("k_x = {k_x}"))?
            .with("width = \"3*pi/k_x\"", &format!("width = {width}"))?
            .with("L = \"7*width\"", &format!("L = {inside}"))?
            .with("rim = 20 ", &format!("rim = {rim} "))?
            .with("until = \"7*width*k/(c*k_x)\"", &format!("until = {until}"))?
            .with(
                "model = \"absorbing\"",
                &format!("model = \"{}\"", end.law()),
            )?;
        let held = format!(
            "{{ box = {{ from = [{}, 0], to = [{}, 1e4] }} }}",
            inside + 0.5,
            inside + 9.0
        );
        let case = instead_of_layer(&case, &end.section("[\"+x\"]", 1.0, &held))?;
        let case = case.with("fields = [\"displacement\", \"phi\"]\n", "")?;
        let case = match self.transverse {
            false => case,
            true => case
                .with("along = \"k_x/k\"", "along = \"-k_y/k\"")?
                .with("across = \"k_y/k\"", "across = \"k_x/k\"")?
                .with("c = \"sqrt(1.2)\"", "c = \"sqrt(0.4)\"")?,
        };
        let case = match self.hump {
            false => case,
            true => case.with("phase = \"k_x*s + k_y*y\"", "phase = \"0*k_x*s\"")?,
        };
        Ok(Strip {
            case,
            inside,
            until,
        })
    }

    /// Displacements in front of the end, at the start and when what came back is there.
    fn ends(&self, end: End) -> Result<[Vec<f64>; 2], String> {
        let strip = self.strip(end)?;
        let seen = strip
            .case
            .watch(Schedule::Ends, |sim| Ok(inner(sim, strip.inside)))?;
        seen.try_into()
            .map_err(|_| "a run has a start and an end".to_string())
    }

    /// Amplitude of what comes back of it from some ends, over its own.
    ///
    /// # Errors
    /// Why a run stopped.
    pub fn reflections(&self, ends: &[End]) -> Result<Vec<f64>, String> {
        let [start, far] = self.ends(End::Far)?;
        let norm = |u: &mut dyn Iterator<Item = f64>| u.map(|u| u * u).sum::<f64>().sqrt();
        let whole = norm(&mut start.iter().copied());
        ends.iter()
            .map(|end| {
                let [_, back] = self.ends(*end)?;
                Ok(norm(&mut back.iter().zip(&far).map(|(a, b)| a - b)) / whole)
            })
            .collect()
    }
}

/// Displacements of the nodes up to a place, ordered by theirs.
fn inner(sim: &Simulation, up_to: f64) -> Vec<f64> {
    let mut nodes: Vec<(usize, &[f64; 3])> = sim.body.x.iter().enumerate().collect();
    nodes.retain(|(_, x)| x[0] < up_to + 0.25);
    nodes.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let slots = nodes.iter().map(|(n, _)| sim.engine.slot(*n));
    slots
        .flat_map(|s| [sim.state.u[0][s], sim.state.u[1][s]])
        .collect()
}

/// One of the three waves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wave {
    Long,
    Square,
    Short,
}

impl Wave {
    pub const ALL: [Wave; 3] = [Wave::Long, Wave::Square, Wave::Short];

    pub fn name(self) -> &'static str {
        match self {
            Wave::Long => "long, straight on",
            Wave::Square => "all angles",
            Wave::Short => "short, at 60 degrees",
        }
    }

    fn packet(self) -> Option<Packet> {
        match self {
            Wave::Square => None,
            Wave::Long => Some(Packet {
                transverse: false,
                angle: 0.0,
                length: 40.0,
                hump: true,
            }),
            Wave::Short => Some(Packet::of(false, 60.0, 10.0)),
        }
    }

    /// The scene, and when it ends.
    ///
    /// # Errors
    /// When the example has changed.
    pub fn case(self, end: End) -> Result<(Case, f64), String> {
        match self.packet() {
            Some(packet) => packet.strip(end).map(|s| (s.case, s.until)),
            None => square(end).map(|case| (case, SQUARE_UNTIL)),
        }
    }

    /// Energy inside over that of the start, at some times.
    ///
    /// # Errors
    /// Why a run stopped.
    pub fn energies(self, end: End, samples: u32) -> Result<Vec<(f64, f64)>, String> {
        let (case, until) = self.case(end)?;
        let inside = match self.packet() {
            Some(packet) => [-0.25, packet.strip(end)?.inside + 0.25],
            None => [INNER[0] - 0.0025, INNER[1] + 0.0025],
        };
        let axes = if self == Wave::Square { 2 } else { 1 };
        let name = if end.law() == "absorbing" {
            "W"
        } else {
            "energy"
        };
        let period = until / f64::from(samples);
        let seen = case.watch(Schedule::Period(period), |sim| {
            let now = sim.state.time;
            Ok((now, energy(sim, name, inside, axes)?))
        })?;
        let first = seen.first().map_or(0.0, |s| s.1);
        Ok(seen
            .into_iter()
            .map(|(t, e)| (t / until, e / first))
            .collect())
    }

    /// Nodes that the end takes, over those inside.
    ///
    /// # Errors
    /// What is wrong with the scene.
    pub fn spent(self, end: End) -> Result<f64, String> {
        let nodes = |end| Ok::<_, String>(self.case(end)?.0.simulation()?.body.x.len() as f64);
        let inside = nodes(End::Free)?;
        Ok(nodes(end)? / inside - 1.0)
    }
}

/// Kinetic and strain energy between two coordinates of the first `axes` axes.
fn energy(sim: &mut Simulation, name: &str, inside: [f64; 2], axes: usize) -> Result<f64, String> {
    let w = pdlang_runtime::observe::quantity(sim, name)
        .map_err(|e| e.to_string())?
        .scalar();
    let one = |(n, x): (usize, &[f64; 3])| {
        if x[..axes].iter().any(|x| *x < inside[0] || *x > inside[1]) {
            return 0.0;
        }
        let slot = sim.engine.slot(n);
        let v: f64 = sim.state.v.iter().map(|v| v[slot] * v[slot]).sum();
        sim.body.volume[n] * (w[n] + 0.5 * v)
    };
    Ok(sim.body.x.iter().enumerate().map(one).sum())
}

/// The scene with another section, or none, in the place of its layer.
fn instead_of_layer(case: &Case, section: &str) -> Result<Case, String> {
    let text = case.text();
    let start = text.find("[[absorbing]]").ok_or("the scene has no layer")?;
    let stop = text[start..]
        .find("\n\n")
        .map_or(text.len(), |n| start + n + 1);
    case.with(&text[start..stop], section)
}

/// The square in the middle of that of absorbing-layer, and when its waves have crossed it thrice [s].
const INNER: [f64; 2] = [0.2, 0.8];
const SQUARE_UNTIL: f64 = 2.0;

fn square(end: End) -> Result<Case, String> {
    let text = include_str!("../../../examples/absorbing-layer.toml");
    let case = Case::new("absorbing-layer", text);
    let rim = f64::from(end.planes(120)) * 0.01;
    let [from, to] = [INNER[0] - rim, INNER[1] + rim];
    let case = case.with(
        "{ box = { from = [0, 0], to = [1, 1] } }",
        &format!("{{ box = {{ from = [{from}, {from}], to = [{to}, {to}] }} }}"),
    )?;
    let case = case
        .with("\"3.71692*0.011\"", "\"2.8 dx\"")?
        .with("gaussian(l = 11 mm)", "gaussian(l = 0.75*dx)")?
        .with(
            "model = \"absorbing\"",
            &format!("model = \"{}\"", end.law()),
        )?
        .with("until = 1 ", &format!("until = {SQUARE_UNTIL} "))?
        .with(
            "fields = [\"displacement\", \"velocity\", \"W\", \"phi\", \"drag\"]\n",
            "",
        )?;
    let [a, b] = [INNER[0] - 0.005, INNER[1] + 0.005];
    let held = format!(
        "{{ difference = [{{ box = {{ from = [-9, -9], to = [9, 9] }} }}, {{ box = {{ from = [{a}, {a}], to = [{b}, {b}] }} }}] }}"
    );
    instead_of_layer(&case, &end.section("\"all\"", 0.01, &held))
}

fn three() -> Result<Vec<Measure>, String> {
    let mut rows = Vec::new();
    for wave in Wave::ALL {
        let left = |end: End| -> Result<f64, String> {
            let seen = wave.energies(end, 1)?;
            seen.last().map(|s| s.1).ok_or("no end".into())
        };
        let far = left(End::Far)?;
        for end in [End::Held, End::Free] {
            let quantity = format!("{}: {}", wave.name(), end.name());
            rows.push(Measure::new(quantity, left(end)?, 1.0, Off(KEPT)));
        }
        let quantity = |end: End| format!("{}: {}", wave.name(), end.name());
        let [one, layer] = [End::Matching(1), End::Layer(20, USUAL)];
        let row = |end: End, reference: f64, tolerance| {
            Ok::<_, String>(Measure::new(
                quantity(end),
                left(end)?,
                reference,
                tolerance,
            ))
        };
        rows.extend(match wave {
            Wave::Long => [row(one, far, Off(1e-5))?, row(layer, far, Off(1e-5))?],
            Wave::Square => [row(one, far, Off(5e-4))?, row(layer, far, Off(1e-5))?],
            // (1 - cos a)/(1 + cos a) of the amplitude is a third, of which the strip takes its part.
            Wave::Short => [row(one, 1.0 / 9.0, AtMost)?, row(layer, far, Off(1e-3))?],
        });
    }
    Ok(rows)
}

fn angle() -> Result<Vec<Measure>, String> {
    let mut rows = Vec::new();
    for degrees in [0.0, 45.0_f64] {
        let packet = Packet::of(false, degrees, 20.0);
        let ends = [End::Free, End::Matching(1), End::Layer(20, USUAL)];
        let found = packet.reflections(&ends)?;
        let cos = degrees.to_radians().cos();
        let of = |end: End| format!("{}, {degrees} degrees", end.name());
        rows.push(Measure::new(of(ends[0]), found[0], 1.0, Part(0.02)));
        if degrees > 0.0 {
            let known = (1.0 - cos) / (1.0 + cos);
            rows.push(Measure::new(of(ends[1]), found[1], known, Part(0.1)));
        }
        rows.push(Measure::new(of(ends[2]), found[2], 0.1 * found[1], AtMost));
    }
    Ok(rows)
}

fn angles() -> Result<Vec<Measure>, String> {
    let mut rows = Vec::new();
    for transverse in [false, true] {
        for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 75.0] {
            let packet = Packet::of(transverse, degrees, 20.0);
            let found = packet.reflections(&[End::Matching(1), End::Layer(20, USUAL)])?;
            let kind = if transverse {
                "transverse"
            } else {
                "longitudinal"
            };
            let quantity = format!("{kind}, {degrees} degrees");
            rows.push(Measure::new(quantity, found[1], 0.6 * found[0], AtMost));
        }
    }
    Ok(rows)
}

fn stable() -> Result<Vec<Measure>, String> {
    let case = square(End::Layer(10, USUAL))?
        .with("dt = 0.004 ", "safety = 0.95 ")?
        .with(&format!("until = {SQUARE_UNTIL} "), "steps = 100000 ")?;
    let seen = case.watch(Schedule::Steps(1000), |sim| {
        energy(sim, "W", [-9.0, 9.0], 2)
    })?;
    let most = |energies: &[f64]| energies.iter().fold(0.0_f64, |m, e| m.max(*e));
    let (first, late) = (most(&seen[10..50]), most(&seen[50..]));
    Ok(vec![
        Measure::new("of the start", late / seen[0], 1e-9, AtMost),
        Measure::new("of the first half", late / first, 1.0, AtMost),
    ])
}
