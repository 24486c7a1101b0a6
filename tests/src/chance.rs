//! Laws that nobody wrote: random and well-typed.

use crate::bodies::Random;

/// Writes expressions without a unit.
struct Author {
    random: Random,
    /// Named node values so far, and whether they may be read at the other end.
    nodes: Vec<(String, bool)>,
    /// Extremes and moving sums at the other end are allowed.
    free: bool,
    history: bool,
}

impl Author {
    fn below(&mut self, n: usize) -> usize {
        ((self.random.uniform() * n as f64) as usize).min(n - 1)
    }

    fn number(&mut self) -> String {
        // Short numbers: products of long ones outgrow exact arithmetic.
        ["0.25", "0.5", "1.5", "2", "3"][self.below(5)].to_string()
    }

    /// A bond value.
    fn bond(&mut self, depth: usize) -> String {
        if depth == 0 {
            return self.bond_leaf();
        }
        let a = self.bond(depth - 1);
        match self.below(14) {
            0 => format!("({a} + {})", self.bond(depth - 1)),
            1 => format!("({a} - {})", self.bond(depth - 1)),
            2 | 3 => format!("{a}*{}", self.bond(depth - 1)),
            4 => format!("{a}/(2 + ({})^2)", self.bond(depth - 1)),
            5 => format!("sqrt(1 + ({a})^2)"),
            6 => format!("exp(-({a})^2)"),
            7 => format!("sin({a})"),
            8 => format!("({a})^{}", 2 + self.below(2)),
            9 => format!("max({a}, {})", self.bond(depth - 1)),
            10 => format!(
                "select({a} > {}, {}, {a})",
                self.number(),
                self.bond(depth - 1)
            ),
            11 => format!("(1 + ({a})^2)^(-0.5)"),
            12 if self.free => format!("({a} + 0.1*s)'"),
            _ => format!("{}*{a}", self.number()),
        }
    }

    fn bond_leaf(&mut self) -> String {
        match self.below(9) {
            0 | 1 => "s".into(),
            2 => "x/delta".into(),
            3 => "e/delta".into(),
            4 => "dot(M, xi)/x".into(),
            5 => "Y.x/delta".into(),
            6 if self.history => if self.below(2) == 0 { "p" } else { "p'" }.into(),
            _ if self.nodes.is_empty() => format!("{}*s", self.number()),
            _ => {
                let k = self.below(self.nodes.len());
                let (name, far) = self.nodes[k].clone();
                let prime = far && self.below(2) == 0;
                format!("{name}{}", if prime { "'" } else { "" })
            }
        }
    }

    /// A node value; at least one reduction.
    fn node(&mut self, depth: usize) -> String {
        let b = self.bond(depth);
        let plain = format!("sum({b}*x/delta)/ball(1)");
        match self.below(10) {
            0 => format!("mean({b} + s)"),
            1 => format!("sum0({b}*x/delta)/ball(1)"),
            2 => format!(
                "{plain}*count({} < {})/count(x < delta)",
                self.bond(1),
                self.number()
            ),
            3 if self.free => format!("min({b} + s)"),
            4 if self.free => format!("max(x/delta*{b})"),
            5 => format!("tr(sum(outer(xi, Y))*sum(x/delta*outer(xi, xi)))/ball(x^2)^2*({plain})"),
            6 => format!("{plain}/(1 + {}^2)", self.node_leaf()),
            7 => format!("(tr(dev(sum(({b})*outer(xi, Y))))/ball(x^2) + {plain})"),
            8 => format!("({plain})^2"),
            _ => plain,
        }
    }

    fn node_leaf(&mut self) -> String {
        match self.nodes.is_empty() {
            true => self.number(),
            false => {
                let k = self.below(self.nodes.len());
                self.nodes[k].0.clone()
            }
        }
    }

    fn law(&mut self) -> String {
        let mut items = String::from("param K : pressure > 0 \"modulus\"\n");
        if self.history {
            items += "history p : number = 0.1 on bond \"memory\"\n";
        }
        for k in 0..self.below(3) {
            let (name, value) = (format!("n{k}"), self.node(1));
            items += &format!("node {name} = {value}\n");
            let free = self.free;
            self.nodes.push((name, free));
        }
        let bond = self.bond(2);
        items += &format!("bond b = {bond}\n");
        items += &match self.below(3) {
            0 if !self.history && !self.free => {
                format!("energy W = K*({})*{}\n", self.node(2), self.node(1))
            }
            _ if !self.free => format!("energy W = K*sum(b*s + {})/ball(1)\n", self.bond(2)),
            1 => format!("state t = K/(delta*ball(1))*(b + {})\n", self.bond(2)),
            _ => format!(
                "state t : vector = K/(delta*ball(1))*(b*M + {}*xi/delta)\n",
                self.bond(2)
            ),
        };
        if self.history {
            items += &format!("update p = p/2 + {}/4\n", self.bond(1));
        }
        if self.below(2) == 0 {
            let after = if self.below(2) == 0 { "" } else { "after " };
            items += &format!("break {after}when {} > {}\n", self.bond(1), self.number());
        }
        format!("model chance \"A law of chance\" cite \"This test, eq. 1\" {{\n{items}}}\n")
    }
}

/// A law; odd seeds read sums at the other end of a bond, every fourth law remembers.
pub fn law(seed: u64) -> String {
    let mut author = Author {
        random: Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xABCD),
        nodes: vec![],
        free: seed % 2 == 1,
        history: seed % 4 == 3,
    };
    author.law()
}
