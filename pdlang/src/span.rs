//! Where in the text.

/// A byte range of one source: the law's own text, or the prelude.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default)]
pub struct Span {
    pub start: u32,
    pub end: u32,
    /// True for text of the prelude, which no diagnostic points at.
    pub prelude: bool,
}
