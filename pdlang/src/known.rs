//! The checks of `pdlang verify`, by the names that `known` may call.
//!
//! What a check does is written in `models/src/verify`; here is what a law may say about itself.

/// Name, and what is checked.
pub const CHECKS: [(&str, &str); 20] = [
    ("text", "the law can be read, and every output has its unit"),
    ("probes", "values that the law states in closed form"),
    ("linear_momentum", "forces sum to nothing"),
    ("angular_momentum", "moments of the forces sum to nothing"),
    (
        "objectivity",
        "a turn of the whole body turns the forces and changes nothing else",
    ),
    ("gradient", "the force is minus the slope of the energy"),
    ("tangent", "the tangent is the slope of the force"),
    (
        "symmetry",
        "the tangent is symmetric: the force has a potential",
    ),
    (
        "purity",
        "an evaluation repeats itself, and depends on no order of the nodes",
    ),
    (
        "constants",
        "constants of the continuum are the declared parameters",
    ),
    (
        "lattice_constants",
        "constants of a lattice are near those of the continuum",
    ),
    (
        "fracture_energy",
        "the energy to open a surface is the declared one",
    ),
    (
        "release",
        "breaking bonds of an expanded body releases energy",
    ),
    (
        "zero_energy",
        "no displacement but that of a rigid body is without force",
    ),
    (
        "speeds",
        "long waves on a lattice run at the speeds of its constants",
    ),
    ("step", "waves have real frequencies, and a step is stable"),
    (
        "limits",
        "answers stay finite where families are degenerate",
    ),
    (
        "conservation",
        "what flows along bonds is neither made nor lost",
    ),
    ("dissipation", "what flows, flows downhill"),
    (
        "coupling",
        "the heat of deformation belongs to the thermal stress",
    ),
];
