//! A horizon for every node, with a few materials: nodes of one material and one horizon are a material of the engine.
//!
//! Horizons that differ too much in number are rounded to levels in geometric steps; families, constants and pairs are
//! those of the rounded horizon throughout, so that the body is as consistent as any of several horizons.
use super::{Settings, SetupError};
use crate::body::Body;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Different horizons of the nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct Grading {
    /// Ascending [m].
    pub horizons: Vec<f64>,
    /// Largest change of a horizon by rounding, as a part of it.
    pub rounding: f64,
}

/// The body and the settings as the engine sees them: no node has a horizon of its own, its material has.
pub(super) struct Grouped<'a> {
    pub body: Cow<'a, Body>,
    pub settings: Cow<'a, Settings>,
    pub grading: Grading,
}

pub(super) fn group<'a>(body: &'a Body, settings: &'a Settings) -> Result<Grouped<'a>, SetupError> {
    if body.horizon.iter().all(|h| *h == 0.0) {
        return Ok(Grouped {
            body: Cow::Borrowed(body),
            settings: Cow::Borrowed(settings),
            grading: Grading {
                horizons: distinct(&settings.horizon),
                rounding: 0.0,
            },
        });
    }
    let own: Vec<f64> = body.horizon.iter().copied().filter(|h| *h > 0.0).collect();
    let levels = Levels::new(&distinct(&own), settings.horizon_levels);
    let mut rounding: f64 = 0.0;
    let mut key = |(node, wanted): (usize, &f64)| {
        let material = body.material.get(node).copied().unwrap_or(0);
        let horizon = match *wanted {
            0.0 => settings.met_horizon(material.into(), material.into()),
            wanted => levels.nearest(wanted),
        };
        if *wanted > 0.0 {
            rounding = rounding.max((horizon / wanted - 1.0).abs());
        }
        // Positive numbers are in the order of their bits.
        (material, horizon.to_bits())
    };
    let keys: Vec<(u8, u64)> = body.horizon.iter().enumerate().map(&mut key).collect();
    let mut materials: BTreeMap<(u8, u64), usize> = keys.iter().map(|k| (*k, 0)).collect();
    if materials.len() > 256 {
        return Err(SetupError::Settings(format!(
            "{} pairs of a material and a horizon (256 are possible): use fewer `horizon_levels`",
            materials.len()
        )));
    }
    for (position, (_, number)) in materials.iter_mut().enumerate() {
        *number = position;
    }
    let horizons: Vec<f64> = materials.keys().map(|k| f64::from_bits(k.1)).collect();
    let of = |k: &(u8, u64)| settings.materials[k.0 as usize].clone();
    Ok(Grouped {
        grading: Grading {
            horizons: distinct(&horizons),
            rounding,
        },
        settings: Cow::Owned(Settings {
            materials: materials.keys().map(of).collect(),
            horizon: horizons,
            ..settings.clone()
        }),
        body: Cow::Owned(Body {
            material: keys.iter().map(|k| materials[k] as u8).collect(),
            horizon: vec![],
            ..body.clone()
        }),
    })
}

fn distinct(values: &[f64]) -> Vec<f64> {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// The horizons that there may be, ascending.
struct Levels(Vec<f64>);

impl Levels {
    /// `wanted`: ascending and different, at least one.
    fn new(wanted: &[f64], most: usize) -> Levels {
        let (Some(&first), Some(&last), true) =
            (wanted.first(), wanted.last(), wanted.len() > most)
        else {
            return Levels(wanted.to_vec());
        };
        let share = |k: usize| match most {
            1 => 0.5,
            _ => k as f64 / (most - 1) as f64,
        };
        let level = |k: usize| first * (last / first).powf(share(k));
        Levels((0..most.max(1)).map(level).collect())
    }

    /// By ratio.
    fn nearest(&self, wanted: f64) -> f64 {
        let above = self.0.partition_point(|level| *level < wanted);
        let around = &self.0[above.saturating_sub(1)..(above + 1).min(self.0.len())];
        let off = |level: &f64| (level / wanted).ln().abs();
        let near = around.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        near.copied().unwrap_or(wanted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_horizons_are_kept() {
        let levels = Levels::new(&[1.0, 1.5, 4.0], 3);
        for h in [1.0, 1.5, 4.0] {
            assert_eq!(levels.nearest(h), h);
        }
    }

    #[test]
    fn many_are_rounded_by_half_a_step_at_most() {
        let wanted: Vec<f64> = (0..1000).map(|k| 1.0 + 0.003 * f64::from(k)).collect();
        let levels = Levels::new(&wanted, 17);
        assert_eq!(levels.0.len(), 17);
        let half = (wanted[999] / wanted[0]).powf(0.5 / 16.0) - 1.0;
        for h in &wanted {
            assert!((levels.nearest(*h) / h - 1.0).abs() <= half * (1.0 + 1e-12));
        }
        assert_eq!(levels.nearest(1.0), 1.0);
        // One level is the geometric mean of the ends.
        assert_eq!(Levels::new(&[1.0, 2.0, 4.0], 1).0, [2.0]);
    }
}
