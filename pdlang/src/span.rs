//! Where in the text.

/// A byte range of one source: the law's own text, the prelude, or a file that is used.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default)]
pub struct Span {
    pub start: u32,
    pub end: u32,
    /// True for text of the prelude and of files that are used, which no diagnostic points at.
    pub prelude: bool,
}
