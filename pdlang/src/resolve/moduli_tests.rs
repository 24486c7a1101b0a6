//! The elastic conversions of the prelude against one material in closed form.

use crate::front;
use crate::units::Unit;

/// E = 5, nu = 1/4: G = 2, K = 10/3, lambda = 2, exactly so in every pair.
#[test]
fn any_two_constants_give_the_others() {
    let values = [
        ("E", 5.0),
        ("nu", 0.25),
        ("K", 10.0 / 3.0),
        ("G", 2.0),
        ("lambda", 2.0),
    ];
    let pascal = Unit::energy_density();
    let unit = |name: &str| {
        if name == "nu" {
            Unit::NUMBER
        } else {
            pascal.clone()
        }
    };
    let variables: Vec<(&str, Unit)> = values.iter().map(|(name, _)| (*name, unit(name))).collect();
    let mut count = 0;
    for (what, expected) in values {
        for (a, _) in values {
            for (b, _) in values {
                let text = format!("{what}_of_{a}_{b}({a}, {b})");
                // Each pair is written in one order.
                let Ok(found) = front::expression(&text, &variables, Some(&unit(what))) else {
                    continue;
                };
                let known = crate::probe::number::Known {
                    exprs: &found.exprs,
                    values: &values.map(|(_, value)| value),
                    flavour: crate::ir::Flavour::Solid,
                };
                let value = known.number(found.root).unwrap();
                assert!(
                    (value / expected - 1.0).abs() < 1e-14,
                    "{text} is {value}, not {expected}"
                );
                count += 1;
            }
        }
    }
    assert_eq!(count, 30);
}
