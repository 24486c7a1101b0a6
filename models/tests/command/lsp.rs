//! The language server from outside: a conversation with an editor.

use std::io::Write;
use std::process::Stdio;

use serde_json::{Value, json};

use super::{command, folder, mentions, write};

const URI: &str = "file:///nowhere/a.pd";

const LAW: &str = "model spring \"Spring of ω\" cite \"a, eq. 1\" { # ω
  param K : pressure > 0 \"bulk modulus\"
  let c = 2*dim^2*K/ball(x)
  energy W = c/4 * sum(x*s^2)
}
";

/// What the server says to all of this, until it is told to end, which it must do as it should.
fn session(messages: &[Value]) -> Vec<Value> {
    let open = [
        json!({ "jsonrpc": "2.0", "id": "first", "method": "initialize", "params": { "capabilities": {} } }),
        json!({ "jsonrpc": "2.0", "method": "initialized", "params": {} }),
    ];
    let close = [
        json!({ "jsonrpc": "2.0", "id": "last", "method": "shutdown" }),
        json!({ "jsonrpc": "2.0", "method": "exit" }),
    ];
    let mut server = command(&["lsp"]);
    server.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut server = server.stderr(Stdio::piped()).spawn().expect("it starts");
    let mut input = server.stdin.take().expect("a pipe");
    for message in open.iter().chain(messages).chain(&close) {
        let body = message.to_string();
        write!(input, "Content-Length: {}\r\n\r\n{body}", body.len()).expect("it listens");
    }
    drop(input);
    let output = server.wait_with_output().expect("it ends");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.is_empty(), "{errors}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let bodies = text.split("Content-Length: ").skip(1);
    let json = bodies.map(|part| part.split_once("\r\n\r\n").expect("a head").1);
    json.map(|body| serde_json::from_str(body).expect("JSON"))
        .collect()
}

fn opened(uri: &str, text: &str) -> Value {
    json!({ "jsonrpc": "2.0", "method": "textDocument/didOpen", "params": {
        "textDocument": { "uri": uri, "languageId": "pdlang", "version": 1, "text": text } } })
}

fn changed(text: &str) -> Value {
    json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": {
        "textDocument": { "uri": URI, "version": 2 }, "contentChanges": [{ "text": text }] } })
}

fn asked(id: i32, method: &str, line: u32, character: u32) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": {
        "textDocument": { "uri": URI }, "position": { "line": line, "character": character } } })
}

fn published(said: &[Value]) -> Vec<&Value> {
    let method = |m: &&Value| m["method"] == "textDocument/publishDiagnostics";
    let all = said.iter().filter(method);
    all.map(|m| &m["params"]["diagnostics"]).collect()
}

fn answer(said: &[Value], id: i32) -> &Value {
    let mut answers = said.iter().filter(|m| m["id"] == id);
    answers.next().expect("an answer")
}

#[test]
fn findings_come_with_codes_and_places_and_go_when_mended() {
    let wrong = LAW.replace("c/4", "q/4");
    let law = "model b \"𝛉 ω\" cite \"a, eq. 1\" { param K : pressure \"k\" energy W = q*K }";
    let said = session(&[opened(URI, &wrong), changed(LAW), changed(law), changed("")]);
    let all = published(&said);
    let first = &all[0][0];
    let place = json!({ "line": 3, "character": 13 });
    assert_eq!(first["range"]["start"], place);
    assert_eq!(first["severity"], 1);
    let code = first["code"].as_str().expect("a code");
    let errors = |one: &Value| {
        let all = one.as_array().expect("a list").clone();
        all.iter().filter(|f| f["severity"] == 1).count()
    };
    assert_eq!((errors(all[0]), errors(all[1])), (1, 0), "{:?}", all[1]);
    // The same finding as that of `pdlang check`.
    let file = write(folder("lsp").join("a.pd"), &wrong);
    let checked = super::pdlang(&["check", &file], 1);
    mentions(&checked, &[&format!("error[{code}]"), "a.pd:4:14"]);
    let message = first["message"].as_str().expect("a text");
    mentions(&checked, &[message.lines().next().expect("a line")]);
    // 𝛉 is two units, ω is one.
    let column = law.encode_utf16().count() - "q*K }".len();
    assert_eq!(all[2][0]["range"]["start"]["character"], column);
    assert_eq!(all[2][0]["range"]["end"]["character"], column + 1);
    assert_eq!(all[3], &json!([]));
}

#[test]
fn names_have_hovers_and_definitions() {
    let said = session(&[
        opened(URI, LAW),
        asked(1, "textDocument/hover", 3, 13),
        asked(2, "textDocument/definition", 3, 13),
        asked(3, "textDocument/hover", 2, 18),
        asked(4, "textDocument/definition", 3, 25),
        asked(5, "textDocument/hover", 3, 25),
        asked(6, "textDocument/hover", 900, 1),
        asked(7, "textDocument/hover", 0, 46),
    ]);
    let hover = |id| answer(&said, id)["result"]["contents"]["value"].to_string();
    mentions(&hover(1), &["let scalar c [", "ball("]);
    mentions(&hover(3), &["param scalar K [Pa]", "bulk modulus"]);
    mentions(&hover(5), &["bond scalar s [a pure number]"]);
    let place = &answer(&said, 2)["result"];
    assert_eq!(place["uri"], URI);
    assert_eq!(
        place["range"]["start"],
        json!({ "line": 2, "character": 6 })
    );
    for id in [4, 6, 7] {
        assert_eq!(answer(&said, id)["result"], Value::Null, "{id}");
    }
}

/// What explains a law explains its names: the sweep of a definition is that of `pdlang explain`.
#[test]
fn hovers_say_when_a_definition_is_computed() {
    let law = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("laws/lps.pd");
    let text = String::from_utf8(super::bytes(super::shown(&law))).expect("text");
    let line = text.lines().position(|line| line.contains("node theta"));
    let line = line.expect("lps has a dilatation") as u32;
    let said = session(&[opened(URI, &text), asked(1, "textDocument/hover", line, 8)]);
    let hover = answer(&said, 1)["result"]["contents"]["value"].as_str();
    let hover = hover.expect("a text");
    let sweep = "theta: at every force evaluation, intact bonds of `horizon`";
    mentions(hover, &["node scalar theta", "\n\ndilatation\n\n", sweep]);
    mentions(&super::pdlang(&["explain", "lps"], 0), &[sweep]);
}

#[test]
fn words_and_laws_with_errors_have_hovers() {
    let wrong = LAW.replace("c/4 * sum(x*s^2)", "nothing + c*sum(x*s^2) +");
    let said = session(&[
        opened(URI, &wrong),
        asked(1, "textDocument/hover", 3, 3),
        asked(2, "textDocument/hover", 3, 26),
        asked(3, "textDocument/hover", 3, 23),
        asked(4, "textDocument/hover", 2, 18),
        asked(5, "textDocument/hover", 1, 12),
        asked(6, "textDocument/hover", 3, 14),
    ]);
    let hover = |id| answer(&said, id)["result"]["contents"]["value"].to_string();
    mentions(&hover(1), &["strain energy density of a node"]);
    mentions(&hover(2), &["the sum over the intact bonds"]);
    mentions(&hover(3), &["let scalar c ["]);
    mentions(&hover(4), &["param scalar K [Pa]", "bulk modulus"]);
    mentions(&hover(5), &["pressure [Pa]"]);
    assert_eq!(answer(&said, 6)["result"], Value::Null);
}

#[test]
fn a_text_is_formatted_as_the_command_does_it() {
    let loose = LAW.replace("  let c = ", "      let   c = ");
    let said = session(&[
        opened(URI, &loose),
        asked(1, "textDocument/formatting", 0, 0),
    ]);
    let new = answer(&said, 1)["result"][0]["newText"].as_str();
    let file = write(folder("lsp-fmt").join("a.pd"), &loose);
    super::pdlang(&["fmt", &file], 0);
    let formatted = std::fs::read_to_string(file).expect("a file");
    assert_eq!(new, Some(formatted.as_str()));
}

#[test]
fn strange_texts_and_requests_do_no_harm() {
    let strange = "model ω { \u{1F600} sum(((( \"\r\n } let = \0 fn f(f) = f(f) '";
    let mut messages = vec![opened("untitled:%zz", strange), opened(URI, strange)];
    for column in 0..60 {
        messages.push(asked(column, "textDocument/hover", 0, column as u32));
        messages.push(asked(column, "textDocument/definition", 1, column as u32));
    }
    messages.push(asked(100, "textDocument/rename", 0, 0));
    messages
        .push(json!({ "jsonrpc": "2.0", "id": 101, "method": "textDocument/hover", "params": [] }));
    messages.push(json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": 3 }));
    messages.push(json!({ "jsonrpc": "2.0", "method": "$/unknown", "params": {} }));
    let said = session(&messages);
    assert!(published(&said).iter().all(|one| one[0]["severity"] == 1));
    assert_eq!(answer(&said, 100)["error"]["code"], -32601);
    assert_eq!(answer(&said, 101)["result"], Value::Null);
}

/// VS Code sets its trace between the request to shut down and the end.
#[test]
fn what_comes_after_the_end_does_no_harm() {
    let said = session(&[
        json!({ "jsonrpc": "2.0", "id": 1, "method": "shutdown" }),
        json!({ "jsonrpc": "2.0", "method": "$/setTrace", "params": { "value": "off" } }),
        asked(2, "textDocument/hover", 0, 0),
    ]);
    assert_eq!(answer(&said, 1)["result"], Value::Null);
    assert_eq!(answer(&said, 2)["error"]["code"], -32600);
}

#[test]
fn who_is_no_editor_is_told() {
    let mut server = command(&["lsp"]);
    server.stdin(Stdio::null());
    let output = server.output().expect("it ends");
    assert!(!output.status.success());
    mentions(
        &String::from_utf8_lossy(&output.stderr),
        &["started by an editor"],
    );
}
