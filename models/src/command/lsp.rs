//! `pdlang lsp`: the language server that editors start. What it says comes from the library; here is the protocol.

use std::collections::HashMap;

use clap::{ArgMatches, Command};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use pdlang::diag::{Diagnostic, Severity};
use pdlang::span::Span;
use pdlang::{at, fmt, front, probe};
use pdlang_models::files;
use serde_json::{Value, json};

use super::{Failure, Outcome};

pub fn command() -> Command {
    Command::new("lsp").about(
        "Serve editors over stdio: findings while one types, hover, go to definition, format",
    )
}

pub fn execute(_: &ArgMatches) -> Outcome {
    let (connection, threads) = Connection::stdio();
    serve(&connection)?;
    // The writing thread ends when nobody can send any more.
    drop(connection);
    threads.join().map_err(Failure::plain)
}

fn serve(connection: &Connection) -> Outcome {
    let capabilities = json!({
        "textDocumentSync": { "openClose": true, "change": 1, "save": true },
        "hoverProvider": true,
        "definitionProvider": true,
        "documentFormattingProvider": true,
    });
    connection.initialize(capabilities).map_err(|error| {
        Failure::plain(format!(
            "`pdlang lsp` is started by an editor, and none began to speak: {error}"
        ))
    })?;
    let mut texts = HashMap::new();
    let mut over = false;
    for message in &connection.receiver {
        let answers = match message {
            Message::Request(request) if request.method == "shutdown" => {
                over = true;
                vec![Message::Response(Response::new_ok(request.id, ()))]
            }
            // What an editor still says before it is the rest of what it was about.
            Message::Notification(told) if told.method == "exit" => break,
            Message::Request(request) if over => {
                let (code, what) = (ErrorCode::InvalidRequest as i32, "the server is shut down");
                vec![Message::Response(Response::new_err(
                    request.id,
                    code,
                    what.into(),
                ))]
            }
            Message::Request(request) => vec![Message::Response(answer(request, &texts))],
            Message::Notification(told) => listen(&told, &mut texts),
            Message::Response(_) => vec![],
        };
        for answer in answers {
            connection.sender.send(answer).map_err(Failure::plain)?;
        }
    }
    Ok(())
}

type Texts = HashMap<String, String>;

/// Takes the text that an editor has, and says what is wrong with it.
fn listen(told: &Notification, texts: &mut Texts) -> Vec<Message> {
    let document = &told.params["textDocument"];
    let Some(uri) = document["uri"].as_str() else {
        return vec![];
    };
    let text = match told.method.as_str() {
        "textDocument/didOpen" => document["text"].as_str(),
        // Changes come as whole texts; the last one is what the editor has.
        "textDocument/didChange" => {
            let changes = told.params["contentChanges"].as_array();
            changes.and_then(|all| all.last()?["text"].as_str())
        }
        "textDocument/didClose" => {
            texts.remove(uri);
            return vec![published(uri, vec![])];
        }
        _ => None,
    };
    if let Some(text) = text {
        texts.insert(uri.into(), text.into());
    }
    // A file that others use is read from the disk: when it is saved, they may be wrong.
    let concerned = |open: &&String| told.method == "textDocument/didSave" || *open == uri;
    let open = texts.keys().filter(concerned);
    open.map(|uri| published(uri, findings(uri, texts)))
        .collect()
}

fn published(uri: &str, findings: Vec<Value>) -> Message {
    let params = json!({ "uri": uri, "diagnostics": findings });
    Message::Notification(Notification::new(
        "textDocument/publishDiagnostics".into(),
        params,
    ))
}

/// What `pdlang check` says.
fn findings(uri: &str, texts: &Texts) -> Vec<Value> {
    let text = &texts[uri];
    let checked = front::file_in(text, &path(uri), &mut files::read);
    let probed = checked.laws.iter().flat_map(probe::findings);
    let all: Vec<Diagnostic> = checked.diagnostics.iter().cloned().chain(probed).collect();
    all.iter().map(|one| finding(one, uri, text)).collect()
}

fn finding(one: &Diagnostic, uri: &str, text: &str) -> Value {
    let related = one.labels.iter().skip(1).map(|(span, label)| {
        json!({ "location": { "uri": uri, "range": range(text, *span) }, "message": label })
    });
    let label = one.labels.first().map(|(_, label)| label.clone());
    let help = one.help.as_ref().map(|help| format!("help: {help}"));
    let parts = [Some(one.message.clone()), label, help];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    json!({
        "range": range(text, one.span()),
        "severity": if one.severity == Severity::Error { 1 } else { 2 },
        "code": one.code,
        "source": "pdlang",
        "message": parts.iter().filter(|p| !p.is_empty()).cloned().collect::<Vec<_>>().join("\n"),
        "relatedInformation": related.collect::<Vec<_>>(),
    })
}

fn answer(request: Request, texts: &Texts) -> Response {
    let Request { id, method, params } = request;
    let asked = params["textDocument"]["uri"].as_str().unwrap_or("");
    let result = match method.as_str() {
        "textDocument/hover" => hover(asked, &params["position"], texts),
        "textDocument/definition" => definition(asked, &params["position"], texts),
        "textDocument/formatting" => formatted(asked, texts),
        _ => {
            let code = ErrorCode::MethodNotFound as i32;
            return Response::new_err(id, code, format!("`{method}` is not served"));
        }
    };
    Response::new_ok(id, result.unwrap_or(Value::Null))
}

fn named(uri: &str, position: &Value, texts: &Texts) -> Option<at::Named> {
    let text = texts.get(uri)?;
    let offset = offset(text, position)?;
    at::at(text, &path(uri), &mut files::read, offset)
}

fn hover(uri: &str, position: &Value, texts: &Texts) -> Option<Value> {
    let named = named(uri, position, texts)?;
    let mut parts = vec![format!("```pdlang\n{}\n```", named.is), named.doc];
    parts.extend(named.computed.iter().map(|sweep| format!("Sweep {sweep}")));
    parts.retain(|part| !part.is_empty());
    Some(json!({
        "contents": { "kind": "markdown", "value": parts.join("\n\n") },
        "range": range(&texts[uri], named.span),
    }))
}

fn definition(uri: &str, position: &Value, texts: &Texts) -> Option<Value> {
    let span = named(uri, position, texts)?.definition?;
    Some(json!({ "uri": uri, "range": range(&texts[uri], span) }))
}

fn formatted(uri: &str, texts: &Texts) -> Option<Value> {
    let text = texts.get(uri)?;
    let formatted = fmt::format(text).ok().filter(|new| new != text)?;
    let whole = Span {
        start: 0,
        end: text.len() as u32,
        prelude: false,
    };
    Some(json!([{ "range": range(text, whole), "newText": formatted }]))
}

fn range(text: &str, span: Span) -> Value {
    json!({ "start": position(text, span.start as usize), "end": position(text, span.end as usize) })
}

/// Line and column of a byte, from zero; columns are in units of UTF-16, as the protocol has them.
fn position(text: &str, offset: usize) -> Value {
    let offset = (0..=offset.min(text.len())).rev();
    let offset = offset.into_iter().find(|k| text.is_char_boundary(*k));
    let before = &text[..offset.unwrap_or(0)];
    let line = before.rfind('\n').map_or(0, |k| k + 1);
    json!({
        "line": before.matches('\n').count(),
        "character": before[line..].encode_utf16().count(),
    })
}

/// The byte at a position; one behind the end of its line is that end.
fn offset(text: &str, position: &Value) -> Option<usize> {
    let number = |key: &str| usize::try_from(position[key].as_u64()?).ok();
    let (wanted, column) = (number("line")?, number("character")?);
    let line = text.split_inclusive('\n').chain([""]).nth(wanted)?;
    let start: usize = text.split_inclusive('\n').take(wanted).map(str::len).sum();
    let mut units = 0;
    for (k, c) in line.char_indices() {
        if units >= column || c == '\n' || c == '\r' {
            return Some(start + k);
        }
        units += c.len_utf16();
    }
    Some(start + line.len())
}

/// The path of a `file:` address, for files that a law uses; of others, what stands in it.
fn path(uri: &str) -> String {
    let written = uri.strip_prefix("file://").unwrap_or(uri).as_bytes();
    let mut bytes = Vec::with_capacity(written.len());
    let mut k = 0;
    while k < written.len() {
        let digits = written
            .get(k + 1..k + 3)
            .and_then(|d| std::str::from_utf8(d).ok());
        match digits.and_then(|d| u8::from_str_radix(d, 16).ok()) {
            Some(byte) if written[k] == b'%' => {
                bytes.push(byte);
                k += 3;
            }
            _ => {
                bytes.push(written[k]);
                k += 1;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
