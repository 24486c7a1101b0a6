//! Units of measurement: exponents of the seven SI base units and of the opaque units of influence functions.

/// Product of powers. Exponents are in halves, so that square roots stay exact.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct Unit {
    /// Metre, kilogram, second, ampere, kelvin, mole, candela; twice the exponent.
    pub base: [i16; 7],
    /// (influence function of the law, twice the exponent), sorted, no zero exponents.
    pub opaque: Vec<(u32, i16)>,
}
