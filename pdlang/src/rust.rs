//! Spec -> Rust: the bodies of the sweeps as straight-line code, and the spec itself as text.
//!
//! Contract. The code names only the runtime's interface file. A sweep becomes a unit struct with its
//! functions (the last one says how a cloud forms the values of geometry from what it keeps of a bond). A register is
//! called after what it reads (`xi_x`, `own_theta`, `c0`), or by its number on the tape, so that `emit` and the
//! generated code can be read side by side. What runs once (reference quantities) stays in the spec.

use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};

use crate::explain;
use crate::formula::{axis, quantity};
use crate::spec::{SlotKind, Spec, Stage, SweepSpec};
use crate::tape::{Op, Tape};

/// Stages whose sweeps are compiled. What runs once runs from its tape.
pub fn is_compiled(stage: Stage) -> bool {
    !matches!(stage, Stage::Reference | Stage::Part)
}

/// A module named after the law, with `LAW`.
pub fn module(specs: &[Spec]) -> TokenStream {
    let Some(first) = specs.first() else {
        return TokenStream::new();
    };
    let name = Ident::new(&first.law, Span::call_site());
    let title = &first.title;
    let law = &first.law;
    let dims = specs.iter().map(dimension);
    let kernels = specs.iter().map(|s| {
        let module = format_ident!("d{}", s.dim);
        quote!(#module::KERNEL)
    });
    quote! {
        #[doc = #title]
        #[allow(unused_variables, clippy::all)]
        pub mod #name {
            #(#dims)*
            pub static LAW: ::pdlang_runtime::kernel::CompiledLaw =
                ::pdlang_runtime::kernel::CompiledLaw { name: #law, kernels: &[#(#kernels),*] };
        }
    }
}

fn dimension(spec: &Spec) -> TokenStream {
    let module = format_ident!("d{}", spec.dim);
    let json = spec.json();
    let dim = number(spec.dim);
    let compiled: Vec<(usize, &SweepSpec)> = spec
        .sweeps
        .iter()
        .enumerate()
        .filter(|(_, s)| is_compiled(s.stage))
        .collect();
    let sweeps = compiled.iter().map(|(k, s)| sweep(*k, s, spec));
    let entries = compiled.iter().map(|(k, s)| {
        let name = type_name(*k, s);
        let kind = match (s.stage, s.single) {
            (Stage::Step, false) => None,
            (Stage::Step, true) => Some(quote!(single)),
            _ => Some(quote!(rare)),
        };
        let k = number(*k);
        quote!((#k, ::pdlang_runtime::sweep_entries!(#kind #name, #dim)))
    });
    quote! {
        pub mod #module {
            use ::pdlang_runtime::kernel::{Bond, Lane, Node, Streams, Sweep};
            #(#sweeps)*
            pub const KERNEL: ::pdlang_runtime::kernel::CompiledKernel =
                ::pdlang_runtime::kernel::CompiledKernel { dim: #dim, spec: #json, sweeps: &[#(#entries),*] };
        }
    }
}

fn type_name(k: usize, s: &SweepSpec) -> Ident {
    let mut name = String::from("Sweep");
    name.push_str(&k.to_string());
    for word in s
        .name
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|w| !w.is_empty())
    {
        let (head, tail) = word.split_at(1);
        name.push_str(&head.to_uppercase());
        name.push_str(tail);
    }
    Ident::new(&name, Span::call_site())
}

fn sweep(k: usize, s: &SweepSpec, spec: &Spec) -> TokenStream {
    let name = type_name(k, s);
    let doc = explain::notes(s, spec);
    let dim = number(spec.dim);
    let (pres, accs) = (number(s.pre.outs.len()), number(s.accumulators as usize));
    let starts = (0..s.accumulators).map(|k| {
        let extreme = |op: &Op| matches!(op, Op::MaxTo(a, _) if *a == k);
        match s.bond.ops.iter().any(extreme) {
            true => quote!(f64::NEG_INFINITY),
            false => quote!(0.0),
        }
    });
    let names = |tape: &Tape, geo: &str| Names::of(tape, geo, s, spec);
    let (first, bonds, last) = (names(&s.pre, "g"), names(&s.bond, "g"), names(&s.post, "g"));
    let pre = statements(&s.pre, &first);
    let bond = statements(&s.bond, &bonds);
    let post = statements(&s.post, &last);
    let streams = number(s.streams.outs.len());
    let computed = |k: &&u32| matches!(spec.slots[**k as usize].kind, SlotKind::Computed(_));
    let far = match s.nbr.iter().take_while(computed).count() {
        0 => None,
        n => {
            let n = number(n);
            Some(quote!(const FORMED: usize = #n;))
        }
    };
    let kept = names(&s.from_streams, "stream");
    let formed = s.from_streams.ops.iter().enumerate();
    let formed = formed.map(|(k, op)| match op {
        Op::Geo(stream) => {
            let (r, stream) = (kept.of_register(k as u32), number(*stream as usize));
            quote!(let #r = bond.stream(#stream);)
        }
        _ => statement(k as u32, op, &kept),
    });
    let values = s.from_streams.outs.iter().enumerate().map(|(k, r)| {
        let (k, r) = (number(k), kept.of_register(*r));
        quote!(#k => #r,)
    });
    let handed = s.pre.outs.iter().map(|r| first.of_register(*r));
    let stores = s.post.outs.iter().enumerate().map(|(k, r)| {
        let (k, r) = (number(k), last.of_register(*r));
        quote!(node.out(#k, #r);)
    });
    quote! {
        #(#[doc = #doc])*
        #[derive(Clone, Copy)]
        pub struct #name;
        impl Sweep<#dim> for #name {
            type Pre<L: Lane> = [L; #pres];
            type Acc<L: Lane> = [L; #accs];
            const STREAMS: usize = #streams;
            #far
            #[inline(always)]
            fn zero<L: Lane>(&self) -> [L; #accs] {
                [#(L::splat(#starts)),*]
            }
            #[inline(always)]
            fn pre<L: Lane, N: Node<L>>(&self, node: &N) -> [L; #pres] {
                #pre
                [#(#handed),*]
            }
            #[inline(always)]
            fn bond<L: Lane, B: Bond<L, #dim>>(&self, pre: &[L; #pres], bond: &mut B, acc: &mut [L; #accs]) {
                #bond
            }
            #[inline(always)]
            fn post<L: Lane, N: Node<L>>(&self, pre: &[L; #pres], acc: &[L; #accs], node: &mut N) {
                #post
                #(#stores)*
            }
            #[inline(always)]
            fn geo<L: Lane, B: Bond<L, #dim> + Streams<L>>(&self, bond: &B, k: usize) -> L {
                #(#formed)*
                match k {
                    #(#values)*
                    _ => L::splat(0.0),
                }
            }
        }
    }
}

/// What the registers of a tape are called.
struct Names(Vec<Ident>);

impl Names {
    fn of(tape: &Tape, geo: &str, s: &SweepSpec, spec: &Spec) -> Names {
        let mut known = std::collections::BTreeSet::new();
        let name = |(k, op): (usize, &Op)| {
            let number = format!("r{k}");
            let read = read(op, &tape.ops, geo, s, spec).unwrap_or_else(|| number.clone());
            let free = known.insert(read.clone());
            Ident::new(if free { &read } else { &number }, Span::call_site())
        };
        Names(tape.ops.iter().enumerate().map(name).collect())
    }

    fn of_register(&self, r: u32) -> &Ident {
        &self.0[r as usize]
    }
}

/// The name of what an operation reads.
fn read(op: &Op, ops: &[Op], geo: &str, s: &SweepSpec, spec: &Spec) -> Option<String> {
    let slot = |end: &str, slots: &[u32], k: u32| {
        let name = quantity(spec, slots[k as usize]);
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        format!("{end}_{}", name.chars().map(plain).collect::<String>())
    };
    let at = |r: u32| &ops[r as usize];
    Some(match op {
        Op::Const(k) => format!("c{k}"),
        Op::Geo(k) => format!("{geo}{k}"),
        Op::Acc(k) => format!("sum{k}"),
        Op::Own(k) => slot("own", &s.own, *k),
        Op::Nbr(k) => slot("nbr", &s.nbr, *k),
        Op::Pre(k) => {
            let handed = &s.pre.ops[s.pre.outs[*k as usize] as usize];
            read(handed, &s.pre.ops, geo, s, spec).unwrap_or_else(|| format!("pre{k}"))
        }
        Op::Xi(a) => format!("xi_{}", axis(*a)),
        Op::Eta(a) => format!("eta_{}", axis(*a)),
        Op::Add(a, b) => match (at(*a), at(*b)) {
            (Op::Xi(a), Op::Eta(b)) if a == b => format!("y_{}", axis(*a)),
            _ => return None,
        },
        Op::Ix => "ix".into(),
        _ => return None,
    })
}

/// An index, without the suffix of its type.
fn number(n: usize) -> Literal {
    Literal::usize_unsuffixed(n)
}

fn statements(tape: &Tape, names: &Names) -> TokenStream {
    let lines = tape
        .ops
        .iter()
        .enumerate()
        .map(|(k, op)| statement(k as u32, op, names));
    quote!(#(#lines)*)
}

fn statement(k: u32, op: &Op, names: &Names) -> TokenStream {
    let register = |r: &u32| names.of_register(*r);
    let effect = match op {
        Op::Kill(m) => {
            let m = register(m);
            Some(quote!(bond.kill(#m);))
        }
        Op::AddTo(acc, a, b) => {
            let (acc, a, b) = (number(*acc as usize), register(a), register(b));
            Some(quote!(bond.add(&mut acc[#acc], #a, #b);))
        }
        Op::MaxTo(acc, v) => {
            let (acc, v) = (number(*acc as usize), register(v));
            Some(quote!(bond.max(&mut acc[#acc], #v);))
        }
        Op::PutHistory(h, v) => {
            let (h, v) = (number(*h as usize), register(v));
            Some(quote!(bond.put_history(#h, #v);))
        }
        _ => None,
    };
    effect.unwrap_or_else(|| {
        let r = register(&k);
        let value = value(op, names);
        quote!(let #r = #value;)
    })
}

fn value(op: &Op, names: &Names) -> TokenStream {
    let register = |r: u32| names.of_register(r);
    let call = |f: &str, args: &[u32]| {
        let f = Ident::new(f, Span::call_site());
        let args = args.iter().map(|r| register(*r));
        quote!(L::#f(#(#args),*))
    };
    let read = |object: &str, f: &str, k: usize| {
        let (object, f) = (
            Ident::new(object, Span::call_site()),
            Ident::new(f, Span::call_site()),
        );
        let k = number(k);
        quote!(#object.#f(#k))
    };
    match op {
        Op::Lit(v) => {
            let v = Literal::f64_unsuffixed(*v);
            quote!(L::splat(#v))
        }
        Op::Inf => quote!(L::splat(f64::INFINITY)),
        Op::Const(k) => read("node", "constant", *k as usize),
        Op::Own(k) => read("node", "own", *k as usize),
        Op::Pre(k) => {
            let k = number(*k as usize);
            quote!(pre[#k])
        }
        Op::Acc(k) => {
            let k = number(*k as usize);
            quote!(acc[#k])
        }
        Op::Nbr(k) => read("bond", "nbr", *k as usize),
        Op::Geo(k) => read("bond", "geo", *k as usize),
        Op::History(k) => read("bond", "history", *k as usize),
        Op::Reverse(k) => read("bond", "reverse", *k as usize),
        Op::Xi(a) => read("bond", "xi", *a as usize),
        Op::Eta(a) => read("bond", "eta", *a as usize),
        Op::Ix => quote!(bond.ix()),
        Op::Add(a, b) => call("add", &[*a, *b]),
        Op::Sub(a, b) => call("sub", &[*a, *b]),
        Op::Mul(a, b) => call("mul", &[*a, *b]),
        Op::Div(a, b) => call("div", &[*a, *b]),
        Op::Fma(a, b, c) => call("fma", &[*a, *b, *c]),
        Op::Neg(a) => call("neg", &[*a]),
        Op::Abs(a) => call("abs", &[*a]),
        Op::Min(a, b) => call("min", &[*a, *b]),
        Op::Max(a, b) => call("max", &[*a, *b]),
        Op::Sqrt(a) => call("sqrt", &[*a]),
        Op::Rsqrt(a) => call("rsqrt", &[*a]),
        Op::Exp(a) => call("exp", &[*a]),
        Op::Ln(a) => call("ln", &[*a]),
        Op::Sin(a) => call("sin", &[*a]),
        Op::Cos(a) => call("cos", &[*a]),
        Op::Tan(a) => call("tan", &[*a]),
        Op::Pow(a, b) => call("pow", &[*a, *b]),
        Op::Powi(a, n) => {
            let a = register(*a);
            quote!(L::powi(#a, #n))
        }
        Op::Lt(a, b) => call("lt", &[*a, *b]),
        Op::Le(a, b) => call("le", &[*a, *b]),
        Op::And(a, b) => call("and", &[*a, *b]),
        Op::Or(a, b) => call("or", &[*a, *b]),
        Op::Not(a) => call("not", &[*a]),
        Op::Select(m, a, b) => call("select", &[*m, *a, *b]),
        // Setup tapes only; never in a sweep.
        Op::Param(_)
        | Op::Var(_)
        | Op::Delta
        | Op::X
        | Op::Omega(_)
        | Op::Weight
        | Op::Case(_)
        | Op::Ball(_) => {
            quote!(L::splat(0.0))
        }
        Op::Kill(_) | Op::AddTo(..) | Op::MaxTo(..) | Op::PutHistory(..) => quote!(L::splat(0.0)),
    }
}
