//! A law as the engine takes it: data, and machine code where it was compiled.
use crate::engine::SetupError;
use crate::kernel::{CompiledKernel, CompiledLaw};
use crate::spec::Spec;

/// A law at one dimension.
#[derive(Clone)]
pub struct Law {
    pub spec: Spec,
    pub kernel: Option<&'static CompiledKernel>,
}

impl Law {
    /// Every sweep walks its tapes.
    pub fn interpreted(spec: Spec) -> Law {
        Law { spec, kernel: None }
    }

    /// The compiled law at dimension `dim`.
    ///
    /// # Errors
    /// The law was not compiled for this dimension, or its data is not readable.
    pub fn compiled(law: &'static CompiledLaw, dim: usize) -> Result<Law, SetupError> {
        let kernel = law.kernels.iter().find(|k| k.dim == dim);
        let kernel = kernel.ok_or_else(|| {
            SetupError::law(law.name, format!("it is not compiled for {dim} dimensions"))
        })?;
        let spec = serde_json::from_str(kernel.spec)
            .map_err(|e| SetupError::law(law.name, format!("unreadable data: {e}")))?;
        Ok(Law {
            spec,
            kernel: Some(kernel),
        })
    }
}
