//! The laws of `tests/fixtures/laws` as machine code: a rate of a scalar field, a history of directed bonds
//! that is read from both ends, and fields of every shape.

use pdlang_runtime::kernel::CompiledLaw;

pdlang_macros::include_model!(
    "fixtures/laws/bond_heat.pd",
    "fixtures/laws/bond_memory.pd",
    "fixtures/laws/moving_fields.pd",
);

/// The kernels of a canary.
pub fn find(name: &str) -> Option<&'static CompiledLaw> {
    [&bond_heat::LAW, &bond_memory::LAW, &moving_fields::LAW]
        .into_iter()
        .find(|law| law.name == name)
}
