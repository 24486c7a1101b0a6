use super::*;
use std::fs;
use std::path::Path;

/// Every law and fixture of the repository that can be read.
fn texts() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folders = [
        "models/laws",
        "tests/fixtures/laws",
        "tests/fixtures/lang/pass",
        "tests/fixtures/lang/warn",
        "tests/fixtures/lang/fail",
        "pdlang/src",
    ];
    let mut texts = Vec::new();
    for folder in folders {
        for entry in fs::read_dir(root.join(folder))
            .into_iter()
            .flatten()
            .flatten()
        {
            let path = entry.path();
            if path.extension().is_some_and(|e| e == "pd") {
                let text = fs::read_to_string(&path).unwrap();
                texts.push((path.display().to_string(), text));
            }
        }
    }
    texts.sort();
    texts
}

/// What a text says, without where it says it; `None` when it cannot be read.
fn meaning(text: &str) -> Option<String> {
    let mut report = Vec::new();
    let file = parse::file(text, false, &mut report);
    let shown = format!("{file:?}");
    let places = shown
        .split("Span {")
        .map(|part| part.split_once('}').map_or(part, |(_, rest)| rest));
    report.is_empty().then(|| places.collect())
}

fn comments(text: &str) -> Vec<String> {
    let pieces = pieces::of(text, &parse::tokens(text));
    let comments = pieces.iter().filter(|piece| piece.comment);
    comments.map(|piece| piece.text.to_string()).collect()
}

#[track_caller]
fn survives(name: &str, text: &str) {
    let Some(before) = meaning(text) else { return };
    let formatted = format(text).unwrap_or_else(|e| panic!("{name}: {e:?}"));
    assert_eq!(
        meaning(&formatted),
        Some(before),
        "{name}\n{text}\n---\n{formatted}"
    );
    assert_eq!(
        comments(&formatted),
        comments(text),
        "{name}\n{text}\n---\n{formatted}"
    );
    let again = format(&formatted).unwrap();
    assert!(
        again == formatted,
        "{name} changes again\n{text}\n---\n{formatted}\n---\n{again}"
    );
}

#[test]
fn keeps_the_meaning_and_the_comments_of_every_fixture() {
    let texts = texts();
    assert!(
        texts
            .iter()
            .filter(|(_, text)| meaning(text).is_some())
            .count()
            > 40
    );
    for (name, text) in texts {
        survives(&name, &text);
    }
}

/// The same texts with white space, line ends and comments wherever they may stand.
#[test]
fn keeps_the_meaning_of_texts_laid_out_at_random() {
    let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
    let mut below = |n: u64| {
        seed ^= seed >> 12;
        seed ^= seed << 25;
        seed ^= seed >> 27;
        (seed.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) % n
    };
    for (name, text) in texts() {
        for _ in 0..6 {
            let (mut mixed, mut at) = (String::new(), 0);
            for token in parse::tokens(&text) {
                let gap = &text[at..token.start];
                let comment = gap.contains(['#', '/']);
                mixed.push_str(match below(12) {
                    _ if comment || gap.is_empty() && below(4) > 0 => gap,
                    0 => "\n",
                    1 => "\n\n\n",
                    2 => "  ",
                    3 => " # why = not, \"this\" {\n",
                    4 => "\n // above\n",
                    5 => "\t\n # twice\n\n # more\n ",
                    _ if gap.is_empty() => "",
                    _ => " ",
                });
                mixed.push_str(&text[token.clone()]);
                at = token.end;
            }
            survives(&name, &mixed);
        }
    }
}

/// `UPDATE_EXPECT` makes them so.
#[test]
fn laws_of_the_catalogue_are_canonical() {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        for (name, text) in texts() {
            if name.contains("models/laws") {
                fs::write(name, format(&text).unwrap()).unwrap();
            }
        }
    }
    let changed: Vec<String> = texts()
        .into_iter()
        .filter(|(name, text)| name.contains("models/laws") && format(text).unwrap() != *text)
        .map(|(name, text)| format!("{name}\n{}", format(&text).unwrap()))
        .collect();
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

#[test]
fn lays_out_a_law() {
    let text =
        "# head\nmodel m   \"Title\" cite \"A, eq. 1\"{ param K:pressure>0 \"modulus\" # first
param s0 : number = inf \"stretch\"


# below
 node m=sum( omega*x^2 ) # volume
 node theta = dim / m*sum(omega*x*e) #dilatation
influence omega = 1/x energy W = case flavour { bar : 1,
slab: 2 ,3d:3 } *
m break when s>-s0 or
  x > 1e-3 m
# end
}
probe";
    let text = text.trim_end_matches("\nprobe");
    let expected = "# head
model m \"Title\"
  cite \"A, eq. 1\"
{
  param K  : pressure > 0    \"modulus\"  # first
  param s0 : number = inf  \"stretch\"

  # below
  node m     = sum(omega*x^2)               # volume
  node theta = dim / m*sum(omega*x*e)       #dilatation
  influence omega = 1/x
  energy W = case flavour { bar: 1,
    slab: 2, 3d: 3 } *
    m
  break when s>-s0 or
    x > 1e-3 m
  # end
}
";
    let found = format(text).unwrap();
    for (a, b) in found.lines().zip(expected.lines()) {
        assert_eq!(
            a.split_whitespace().collect::<String>(),
            b.split_whitespace().collect::<String>(),
            "{found}"
        );
    }
    assert_eq!(found.lines().count(), expected.lines().count(), "{found}");
}
