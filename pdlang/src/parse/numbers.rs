//! Numbers, units and quantities.

use super::{Build, Failure, MAX_HEIGHT, Reader, Rule};
use crate::ast::{self, Name};
use pest::iterators::Pair;

impl<'t> Reader<'t> {
    pub(super) fn quantity(&self, pair: Pair<'t, Rule>) -> Build<ast::Quantity> {
        let mut quantity = ast::Quantity {
            value: 0.0,
            unit: None,
            span: self.span(&pair),
        };
        let mut sign = 1.0;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::minus => sign = -1.0,
                Rule::infinity => quantity.value = f64::INFINITY,
                Rule::literal => quantity.value = literal(&part)?,
                _ => quantity.unit = Some(self.unit(part)?),
            }
        }
        quantity.value *= sign;
        Ok(quantity)
    }

    /// From any rule that holds unit names: the product of their powers.
    pub(super) fn unit(&self, pair: Pair<'t, Rule>) -> Build<ast::UnitExpr> {
        let span = self.span(&pair);
        let mut factors = Vec::new();
        self.unit_factors(pair, 1.0, 0, &mut factors)?;
        Ok(ast::UnitExpr { factors, span })
    }

    pub(super) fn unit_factors(
        &self,
        pair: Pair<'t, Rule>,
        power: f64,
        height: usize,
        factors: &mut Vec<(Name, f64)>,
    ) -> Build<()> {
        if height > MAX_HEIGHT {
            return Err(Failure::TooHigh(self.span(&pair)));
        }
        let own = pair
            .clone()
            .into_inner()
            .find(|part| part.as_rule() == Rule::unit_power);
        let power = power * own.map_or(Ok(1.0), |part| unit_power(&part))?;
        let mut sign = 1.0;
        for part in pair.into_inner() {
            match part.as_rule() {
                Rule::unit_op => sign = if part.as_str() == "/" { -1.0 } else { 1.0 },
                Rule::unit_name => factors.push((
                    Name {
                        text: part.as_str().into(),
                        span: self.span(&part),
                    },
                    power,
                )),
                Rule::unit | Rule::unit_factor | Rule::unit_simple => {
                    self.unit_factors(part, sign * power, height + 1, factors)?;
                    sign = 1.0;
                }
                _ => {}
            }
        }
        Ok(())
    }
}

pub(super) fn literal(pair: &Pair<Rule>) -> Build<f64> {
    pair.as_str().parse().map_err(|_| Failure::Unexpected)
}

fn unit_power(pair: &Pair<Rule>) -> Build<f64> {
    match pair.as_str() {
        "²" => Ok(2.0),
        "³" => Ok(3.0),
        text => text
            .trim_start_matches('^')
            .trim()
            .parse()
            .map_err(|_| Failure::Unexpected),
    }
}
