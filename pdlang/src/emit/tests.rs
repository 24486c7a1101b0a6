use super::*;

const LAW: &str = "model m \"A test of 100 %\" cite \"Nobody, eq. 1\" {
  param K : pressure > 0 = 1 GPa \"modulus\"
  influence omega = 1/x
  node theta = dim*sum(omega*e)/sum(omega*x)
  bond z : vector = Y - xi*(1 + theta - theta')
  energy W = K_bb(K)*(theta + 1)^2/2
  break when s > 2 or norm(z) > -3 mm
}";

#[test]
fn every_stage_says_something() {
    for stage in Stage::ALL {
        let text = emit(LAW, stage, None).unwrap_or_else(|e| panic!("{e:?}"));
        assert!(text.lines().count() > 8, "{stage:?}: {text}");
    }
    assert!(emit("model m { }", Stage::Ast, None).is_err());
}

#[test]
fn trees_are_in_parentheses() {
    let ast = emit(LAW, Stage::Ast, None).unwrap();
    assert!(
        ast.contains("node theta = ((dim*sum((omega*e)))/sum((omega*x)))"),
        "{ast}"
    );
    assert!(
        ast.contains("break when ((s > 2) or (norm(z) > (-3 [mm])))"),
        "{ast}"
    );
}

#[test]
fn formulas_are_those_of_papers() {
    let page = emit(LAW, Stage::Markdown, Some("../a.pd")).unwrap();
    for part in [
        "# A test of 100 %",
        "[a.pd](../a.pd)",
        r"| $K$ | Pa | $> 0$ | $10^{9}$ | modulus |",
        r"\theta = \frac{\dim\,\sum_{j \in \mathcal{H}} \omega\,e\,V_j}{\sum_{j \in \mathcal{H}} \omega\,x\,V_j}",
        r"\mathbf{z} = \mathbf{Y} - \boldsymbol{\xi}\,\left(1 + \theta - {\theta}'\right)",
        r"\frac{K_{\mathrm{bb}}\left(K\right)\,{\left(\theta + 1\right)}^{2}}{2}",
        r"s > 2 \lor \lVert \mathbf{z} \rVert > -3\,\mathrm{mm}",
        r"K_{\mathrm{bb}}(K) = \begin{cases}",
    ] {
        assert!(page.contains(part), "{part}\n{page}");
    }
    let latex = emit(LAW, Stage::Latex, None).unwrap();
    assert!(
        latex.contains("\n\\section*{A test of 100 \\%}\n"),
        "{latex}"
    );
}

#[test]
fn kernels_say_what_they_read() {
    let in_2d = |stage, dim| {
        let request = Request {
            stage,
            kinematics: Kinematics::General,
            dim: Some(dim),
            link: None,
            more: &[],
        };
        emit_in(LAW, "", &mut files::nowhere, request)
    };
    let rust = in_2d(Stage::Rust, 2).unwrap();
    for part in [
        "/// `force`, at every force evaluation: intact bonds of `horizon`.",
        "pub mod d2 {",
        "let xi_x = bond.xi(0);",
        "let y_y = L::add(xi_y, eta_y);",
        " bytes of JSON\"",
    ] {
        assert!(rust.contains(part), "{part}\n{rust}");
    }
    let bar = LAW.replace("{\n  param K", "for bar {\n  param K");
    let request = Request {
        stage: Stage::Passes,
        kinematics: Kinematics::General,
        dim: Some(3),
        link: None,
        more: &[],
    };
    let refused = emit_in(&bar, "", &mut files::nowhere, request).unwrap_err();
    assert_eq!(refused[0].code, "PD092");
}

/// Descriptions are prose: what is a mark of LaTeX or of Markdown in them is a letter.
#[test]
fn words_of_a_law_are_no_marks() {
    let law = LAW.replace("\"modulus\"", "\"of 5 $ & a_b^2 \\\\ {c} | ~d # 3 %\"");
    let latex = emit(&law, Stage::Latex, None).unwrap();
    let row = r"of 5 \$ \& a\_b\textasciicircum{}2 ";
    assert!(latex.contains(row), "{latex}");
    assert!(
        latex.contains(r"\{c\} \textbar{} \textasciitilde{}d \# 3 \%"),
        "{latex}"
    );
    let markdown = emit(&law, Stage::Markdown, None).unwrap();
    assert!(markdown.contains(r"of 5 \$ & a_b^2"), "{markdown}");
    assert!(markdown.contains(r"{c} \| ~d"), "{markdown}");
}

/// A law may call something of its own `d`, as papers call the number of dimensions.
#[test]
fn the_number_of_dimensions_has_a_name_of_its_own() {
    let law = LAW.replace(
        "influence omega = 1/x",
        "influence omega = 1/x let d = 2*dim",
    );
    let latex = emit(&law, Stage::Latex, None).unwrap();
    assert!(latex.contains(r"\[ d = 2\,\dim \]"), "{latex}");
}

/// One page, three forms; a law that is not of the catalogue has its force as well.
#[test]
fn a_page_has_the_derived_force_in_every_form() {
    let latex = emit(LAW, Stage::Latex, None).unwrap();
    let terminal = emit(LAW, Stage::Terminal, None).unwrap();
    for (page, state, direction) in [
        (
            &latex,
            r"\underline{\mathbf{T}} =",
            r"\mathbf{M} = \frac{\mathbf{Y}}{y}",
        ),
        (&terminal, "T_state =", "M = Y/y"),
    ] {
        assert!(page.contains("The force"), "{page}");
        assert!(page.contains(direction), "{page}");
        assert!(page.contains(state), "{page}");
    }
}

/// Powers of determinants have thousands of terms, which the derivation once copied for each of them: this ran for minutes.
#[test]
fn powers_of_determinants_are_collected_or_refused() {
    let passes = |energy: &str| {
        let law = format!(
            "model m \"Powers\" cite \"Nobody, eq. 1\" {{
               param K : pressure > 0 \"modulus\"
               node S : symmetric = sum(outer(xi, xi))
               node F : tensor = sum(outer(Y, xi))*inverse(S)
               energy W = K*{energy}
             }}"
        );
        emit(&law, Stage::Passes, None).map_err(|found| found[0].code)
    };
    assert!(passes("ln(det(F))").is_ok());
    assert!(passes("det(F)^2").is_ok());
    assert_eq!(passes("tr(inverse(transpose(F)*F))"), Err("PD090"));
}

/// A law that calls its own what formulas call theirs has formulas: of other names, and with what it hides written out.
#[test]
fn formulas_have_names_that_the_law_does_not_have() {
    let page = |items: &str, stage| {
        let law = format!("model m \"Names\" cite \"Nobody, eq. 1\" {{ {items} }}");
        emit(&law, stage, None).unwrap()
    };
    let taken = "param d_e : pressure > 0 \"modulus\" node T_state = sum(s)/ball(1) energy W = d_e*T_state^2";
    let text = page(taken, Stage::Terminal);
    for part in [
        "T_state_ = 2*d_e*T_state/(ball(1)*x)*M",
        "d_e_ = dot(M, d_eta)",
        "d_T_state_ =",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let hidden = "param M : pressure > 0 \"modulus\" node e = sum(s)/ball(1) energy W = M*e^2";
    let text = page(hidden, Stage::Terminal);
    for part in [
        "T_state = 2*M*e/(ball(1)*x*y)*Y",
        "With the library's e, not that of the law:",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    // A parameter is no vector, whatever the prelude calls so.
    let latex = page(hidden, Stage::Latex);
    assert!(latex.contains("2\\,M\\,e"), "{latex}");
    assert!(!latex.contains("\\mathbf{M}"), "{latex}");
}

/// The slope of a product of n sums is n products, and the tangent has n times as many: they stand on a page while a reader has use
/// for them.
#[test]
fn formulas_that_fill_pages_are_left_out() {
    let page = |n: usize, stage| {
        let sums: Vec<String> = (1..=n)
            .map(|k| format!("sum(x^{k}*s^2)/ball(x^{k})"))
            .collect();
        let law = format!(
            "model m \"Product\" cite \"Nobody, eq. 1\" {{ param K : pressure > 0 \"modulus\" energy W = K*{} }}",
            sums.join("*")
        );
        emit(&law, stage, None).unwrap_or_else(|e| panic!("{n}: {e:?}"))
    };
    for (n, force, tangent) in [
        (1, true, true),
        (4, true, true),
        (5, true, false),
        (10, true, false),
        (14, false, false),
        (30, false, false),
    ] {
        let (text, latex) = (page(n, Stage::Terminal), page(n, Stage::Latex));
        let stands = (text.contains("T_state ="), text.contains("d_force ="));
        assert_eq!(stands, (force, tangent), "{n}: {text}");
        let said = text
            .replace("\n  ", " ")
            .contains("a length of pages keeps");
        assert_eq!(said, !tangent, "{n}: {text}");
        // Thirty had 3.5 million letters.
        assert!(latex.len() < 20_000, "{n}: {}", latex.len());
    }
}
