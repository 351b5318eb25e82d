//! Diagnostics in the formats of other programs: SARIF 2.1.0 for code scanning, and workflow commands of GitHub.

use serde_json::{Value, json};

use admire_session::Sources;
use admire_syntax::diagnostic::{Code, Diagnostic, Label, Severity};
use admire_syntax::text::{Source, Span};

/// Formats diagnostics as a SARIF log with one run. The rules of the run are the diagnostic codes that occur.
pub(super) fn sarif(diagnostics: &[Diagnostic], sources: &Sources) -> String {
    let mut codes: Vec<Code> = diagnostics.iter().map(|found| found.code).collect();
    codes.sort_unstable();
    codes.dedup();
    let rules: Vec<Value> = codes
        .iter()
        .map(|code| {
            let explained = code.explain().trim();
            let first = explained.split_inclusive(". ").next().unwrap_or(explained);
            json!({
                "id": code.as_str(),
                "shortDescription": { "text": first.trim() },
                "fullDescription": { "text": explained },
            })
        })
        .collect();
    let results: Vec<Value> = diagnostics
        .iter()
        .map(|found| result(found, &codes, sources))
        .collect();
    let log = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": {
                "name": "admire",
                "semanticVersion": env!("CARGO_PKG_VERSION"),
                "rules": rules,
            }},
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    serde_json::to_string_pretty(&log).expect("JSON values print") + "\n"
}

fn result(found: &Diagnostic, codes: &[Code], sources: &Sources) -> Value {
    let level = match found.severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Note => "note",
    };
    let text = match &found.help {
        Some(help) => format!("{}. {help}", found.message),
        None => found.message.clone(),
    };
    let mut result = json!({
        "ruleId": found.code.as_str(),
        "ruleIndex": codes.binary_search(&found.code).unwrap_or(0),
        "level": level,
        "message": { "text": text },
    });
    let places: Vec<Value> = found
        .labels
        .iter()
        .map(|label| location(label, sources))
        .collect();
    if let [first, others @ ..] = places.as_slice() {
        result["locations"] = json!([first]);
        if !others.is_empty() {
            result["relatedLocations"] = json!(others);
        }
    }
    if let (Some(fix), Some(label)) = (&found.fix, found.labels.first()) {
        let replacements: Vec<Value> = fix
            .edits
            .iter()
            .map(|edit| {
                let inserted: String = match std::str::from_utf8(&edit.replacement) {
                    Ok(text) => text.to_string(),
                    Err(_) => edit
                        .replacement
                        .iter()
                        .map(|&byte| char::from(byte))
                        .collect(),
                };
                let mut region = json!({});
                if let Some(source) = sources.get(&label.file) {
                    region = lines(source, edit.span);
                }
                region["byteOffset"] = json!(edit.span.start());
                region["byteLength"] = json!(edit.span.len());
                json!({ "deletedRegion": region, "insertedContent": { "text": inserted } })
            })
            .collect();
        result["fixes"] = json!([{
            "description": { "text": fix.title },
            "artifactChanges": [{
                "artifactLocation": { "uri": uri(&label.file) },
                "replacements": replacements,
            }],
        }]);
    }
    result
}

fn location(label: &Label, sources: &Sources) -> Value {
    let mut place = json!({ "artifactLocation": { "uri": uri(&label.file) } });
    if let Some(source) = sources.get(&label.file).filter(|_| !label.is_about_all()) {
        place["region"] = lines(source, label.span);
    }
    let mut location = json!({ "physicalLocation": place });
    if !label.message.is_empty() {
        location["message"] = json!({ "text": label.message });
    }
    location
}

/// Returns the start and end of a span as lines and columns, counted from 1. Columns count characters.
fn lines(source: &Source, span: Span) -> Value {
    let place = |offset: usize| {
        let at = source.line_column(offset);
        let start = offset.min(source.bytes().len()) + 1 - at.column;
        let before = source.text(Span::new(start, start + at.column - 1));
        (at.line, before.chars().count() + 1)
    };
    let ((line, column), (end_line, end_column)) = (place(span.start()), place(span.end()));
    json!({ "startLine": line, "startColumn": column, "endLine": end_line, "endColumn": end_column })
}

/// Encodes a path as a URI reference.
fn uri(path: &str) -> String {
    let mut out = String::new();
    for byte in path.replace('\\', "/").bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' | b'~' => {
                out.push(char::from(byte));
            }
            _ => out += &format!("%{byte:02X}"),
        }
    }
    out
}

/// Formats each diagnostic as one line: `::error file=a.adm,line=3,col=5,...::message`.
pub(super) fn github(diagnostics: &[Diagnostic], sources: &Sources) -> String {
    let mut out = String::new();
    for found in diagnostics {
        let level = match found.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "notice",
        };
        let mut properties = Vec::new();
        if let Some(label) = found.labels.first() {
            properties.push(format!("file={}", property(&label.file)));
            if let Some(source) = sources.get(&label.file).filter(|_| !label.is_about_all()) {
                let from = source.line_column(label.span.start());
                let to = source.line_column(label.span.end());
                properties.push(format!("line={},endLine={}", from.line, to.line));
                // GitHub ignores the columns of a range that extends over several lines.
                if from.line == to.line {
                    properties.push(format!("col={},endColumn={}", from.column, to.column));
                }
            }
        }
        properties.push(format!("title={}", property(found.code.as_str())));
        let mut text = found.message.clone();
        if let Some(help) = &found.help {
            text = format!("{text}\n{help}");
        }
        out += &format!("::{level} {}::{}\n", properties.join(","), data(&text));
    }
    out
}

fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> (Vec<Diagnostic>, Sources) {
        let mut sources = Sources::default();
        sources.add(Source::new("a b,c.adm", &b"title\n\xb7 MARKR/1\n"[..]));
        let found = Diagnostic::error(Code::UnknownStatement, "100% wrong")
            .label("a b,c.adm", Span::new(8, 13), "")
            .help("did you mean MARKER?")
            .fix(
                "write MARKER",
                vec![admire_syntax::text::Edit::new(Span::new(8, 13), "MARKER")],
                admire_syntax::diagnostic::Applicability::MaybeIncorrect,
            );
        (vec![found], sources)
    }

    #[test]
    fn github_reads_its_own_commands() {
        let (found, sources) = sample();
        assert_eq!(
            github(&found, &sources),
            "::error file=a b%2Cc.adm,line=2,endLine=2,col=3,endColumn=8,title=unknown-statement::100%25 wrong%0Adid you mean MARKER?\n"
        );
    }

    #[test]
    fn sarif_names_rule_place_and_fix() {
        let (found, sources) = sample();
        let log: Value = serde_json::from_str(&sarif(&found, &sources)).expect("JSON");
        let run = &log["runs"][0];
        let result = &run["results"][0];
        assert_eq!(log["version"], "2.1.0");
        assert_eq!(run["tool"]["driver"]["rules"][0]["id"], result["ruleId"]);
        let place = &result["locations"][0]["physicalLocation"];
        assert_eq!(place["artifactLocation"]["uri"], "a%20b%2Cc.adm");
        assert_eq!(
            place["region"],
            json!({ "startLine": 2, "startColumn": 3, "endLine": 2, "endColumn": 8 })
        );
        let change = &result["fixes"][0]["artifactChanges"][0]["replacements"][0];
        assert_eq!(change["insertedContent"]["text"], "MARKER");
    }
}
