//! The final schedule as text that a person can read.

use std::fmt;

use crate::spec::{Spec, SweepSpec};
use crate::tape::{Op, Tape};

impl fmt::Display for Spec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "law {} in {}D{}",
            self.law,
            self.dim,
            if self.pairwise { ", pairwise" } else { "" }
        )?;
        lines(f, "constants", &self.constants)?;
        for s in &self.sweeps {
            self.sweep(f, s)?;
        }
        Ok(())
    }
}

impl Spec {
    fn sweep(&self, f: &mut fmt::Formatter<'_>, s: &SweepSpec) -> fmt::Result {
        let names = |slots: &[u32]| {
            let names: Vec<&str> = slots
                .iter()
                .map(|k| self.slots[*k as usize].name.as_str())
                .collect();
            names.join(" ")
        };
        let over = if s.reference {
            "reference family"
        } else {
            "intact bonds"
        };
        let family = &self.families[s.family as usize].name;
        let kills = if s.kills { ", breaks bonds" } else { "" };
        writeln!(
            f,
            "\nsweep {} ({:?}, {over} of {family}{kills})",
            s.name, s.stage
        )?;
        writeln!(
            f,
            "  reads [{}], at the other end [{}]",
            names(&s.own),
            names(&s.nbr)
        )?;
        writeln!(f, "  writes [{}]", names(&s.out))?;
        for (title, tape) in [
            ("geometry", &s.geometry),
            ("streams of a cloud", &s.streams),
            ("geometry from streams", &s.from_streams),
            ("prologue", &s.pre),
            ("bond", &s.bond),
            ("epilogue", &s.post),
        ] {
            lines(f, title, tape)?;
        }
        Ok(())
    }
}

fn lines(f: &mut fmt::Formatter<'_>, title: &str, tape: &Tape) -> fmt::Result {
    if tape.ops.is_empty() {
        return Ok(());
    }
    writeln!(f, "  {title}")?;
    for (k, op) in tape.ops.iter().enumerate() {
        match op {
            Op::Kill(m) => writeln!(f, "    break where %{m}")?,
            Op::MaxTo(a, p) => writeln!(f, "    sum{a} max= %{p}")?,
            Op::AddTo(a, p, q) => writeln!(f, "    sum{a} += %{p} * %{q}")?,
            Op::PutHistory(h, v) => writeln!(f, "    history{h} := %{v}")?,
            op => writeln!(f, "    %{k} = {}", text(op))?,
        }
    }
    if !tape.outs.is_empty() {
        let outs: Vec<String> = tape.outs.iter().map(|r| format!("%{r}")).collect();
        writeln!(f, "    -> {}", outs.join(", "))?;
    }
    Ok(())
}

fn text(op: &Op) -> String {
    let two = |sign: &str, a: &u32, b: &u32| format!("%{a} {sign} %{b}");
    match op {
        Op::Lit(v) => format!("{v}"),
        Op::Add(a, b) => two("+", a, b),
        Op::Sub(a, b) => two("-", a, b),
        Op::Mul(a, b) => two("*", a, b),
        Op::Div(a, b) => two("/", a, b),
        Op::Lt(a, b) => two("<", a, b),
        Op::Le(a, b) => two("<=", a, b),
        Op::Fma(a, b, c) => format!("%{a} * %{b} + %{c}"),
        Op::Ball(inner) => {
            let ops: Vec<String> = inner
                .ops
                .iter()
                .enumerate()
                .map(|(k, o)| format!("%{k} = {}", text(o)))
                .collect();
            format!("ball {{ {} }}", ops.join("; "))
        }
        other => format!("{other:?}").to_lowercase(),
    }
}
