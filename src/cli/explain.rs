use clap_complete::{ArgValueCompleter, CompletionCandidate};

use admire_guide::glossary::{self, Entry};
use admire_study::{CausePriors, Constant, schema};
use admire_syntax::describe::{self, minimal};
use admire_syntax::diagnostic::Code;
use admire_syntax::grammar::{
    FUNCTIONS, Lookup, Role, STATEMENTS, find_function, find_statement, nearest,
};

use super::Outcome;
use super::shell::{Exit, Shell};
use super::width::hanging;

/// Explain a word: a technical term, a statement, a command, a function, the code of a message, a key of study.toml, a cause of a
/// diagnosis, a field of a JSON output, a column.
#[derive(clap::Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    /// Word to explain, such as `camber`, `roll centre`, `BUSHING`, `simulate`, `AZ`, `undefined-id`, `marks.sigma`, `dry-friction`. Without a
    /// word, all words are listed.
    #[arg(add = ArgValueCompleter::new(complete))]
    word: Vec<String>,
    /// Print the JSON Schema of study.toml, for editors.
    #[arg(long, conflicts_with = "word")]
    schema: bool,
}

const EXAMPLES: &str = "Examples:
  admire explain bump steer
  admire explain BUSHING
  admire explain marks.sigma
  admire explain link-compliance
  admire explain priors
  admire explain --schema > study.schema.json";

/// Prints the explanation of a word.
pub(super) fn run(arguments: &Arguments, shell: &mut Shell) -> Outcome {
    if arguments.schema {
        let text = serde_json::to_string_pretty(&schema()).expect("a schema prints");
        shell.print(&(text + "\n"));
        return Ok(Exit::Fine);
    }
    if arguments.word.is_empty() {
        shell.page(&list());
        return Ok(Exit::Fine);
    }
    match page(&arguments.word.join(" ")) {
        Ok(text) => {
            shell.tell(&text);
            Ok(Exit::Fine)
        }
        Err(text) => {
            shell.tell(&text);
            Err(Exit::Findings)
        }
    }
}

/// Returns the completions of a word: keywords, functions, codes and terms of the guide.
fn complete(current: &std::ffi::OsStr) -> Vec<CompletionCandidate> {
    let typed = current.to_string_lossy();
    let statements = STATEMENTS.iter().map(|def| def.name);
    let functions = FUNCTIONS.iter().map(|def| def.name);
    let codes = Code::ALL.iter().map(|code| code.as_str());
    statements
        .chain(functions)
        .chain(codes)
        .map(str::to_string)
        .chain(glossary::entries().map(|entry| entry.term))
        .filter(|word| {
            word.get(..typed.len())
                .is_some_and(|start| start.eq_ignore_ascii_case(&typed))
        })
        .map(CompletionCandidate::new)
        .collect()
}

fn list() -> String {
    let mut out = String::from(
        "Statements and commands (the capital letters are the shortest abbreviation):\n",
    );
    for def in STATEMENTS {
        entry(&mut out, &minimal(def.name, def.minimum), def.doc);
    }
    out.push_str("\nFunctions:\n");
    for def in FUNCTIONS {
        entry(&mut out, def.name, def.doc);
    }
    out.push_str("\nMessage codes:\n");
    for code in Code::ALL {
        let first = code.explain().trim().lines().next().unwrap_or_default();
        entry(&mut out, code.as_str(), first.trim());
    }
    let mut section = None;
    for term in glossary::entries() {
        if section != Some((term.page, term.section)) {
            section = Some((term.page, term.section));
            line(
                &mut out,
                &format!("\n{} (page `{}`):", term.section, term.page),
            );
        }
        let meaning = term.cells.last().map_or("", |(_, text)| text.as_str());
        entry(&mut out, &term.term, meaning);
    }
    out
}

/// Adds a line with a word and its meaning to the list.
fn entry(out: &mut String, word: &str, meaning: &str) {
    out.push_str(&hanging(&format!("  {word:24} "), meaning));
}

/// Returns the explanation of a word, or an error message if the word is unknown.
fn page(word: &str) -> Result<String, String> {
    if word.eq_ignore_ascii_case("priors") {
        return Ok(priors());
    }
    if let Some(code) = Code::ALL
        .iter()
        .find(|code| code.as_str().eq_ignore_ascii_case(word))
    {
        let mut out = String::new();
        line(&mut out, code.as_str());
        for text in code.explain().lines() {
            line(&mut out, &format!("  {}", text.trim()));
        }
        return Ok(out);
    }
    let statement = find_statement(word.as_bytes(), Role::Both);
    let (words, others): (Vec<Entry>, Vec<Entry>) =
        glossary::find(word).into_iter().partition(Entry::is_word);
    let mut found: Vec<String> = words.iter().map(of_glossary).collect();
    if let Lookup::Found(def) = statement {
        found.push(describe::statement(def));
    }
    if let Some(def) = find_function(word.as_bytes()) {
        found.push(describe::function(def));
    }
    found.extend(others.iter().map(of_glossary));
    if !found.is_empty() {
        return Ok(found.join("\n"));
    }
    if let Lookup::Ambiguous(names) = statement {
        return Err(format!(
            "`{word}` is ambiguous: it abbreviates {}\n",
            names.join(", ")
        ));
    }
    let names = STATEMENTS
        .iter()
        .map(|def| def.name)
        .chain(FUNCTIONS.iter().map(|def| def.name))
        .chain(Code::ALL.iter().map(|code| code.as_str()));
    let entries: Vec<String> = glossary::entries().map(|entry| entry.term).collect();
    let names = names.chain(entries.iter().map(String::as_str));
    // Words are compared in capitals.
    let capitals: Vec<(String, &str)> = names
        .map(|name| (name.to_ascii_uppercase(), name))
        .collect();
    let near = nearest(word, capitals.iter().map(|(upper, _)| upper.as_str()))
        .and_then(|upper| capitals.iter().find(|(name, _)| name == upper))
        .or_else(|| {
            let begins = |name: &str| !word.is_empty() && name.starts_with(&word.to_uppercase());
            capitals.iter().find(|(name, _)| begins(name))
        });
    Err(match near {
        Some((_, name)) => format!("`{word}` is not a known word; did you mean `{name}`?\n"),
        None => format!("`{word}` is not a known word; `admire explain` lists all words\n"),
    })
}

/// Widths in characters of the columns for the names and the values of constants.
const NAME_WIDTH: usize = 32;
const VALUE_WIDTH: usize = 14;

/// Returns the priors and settings of identification, diagnosis and design, with their values.
fn priors() -> String {
    let sections: [(&str, &[Constant]); 7] = [
        (
            "Priors of the causes of a diagnosis; `[priors]` of study.toml changes them",
            CausePriors::TABLE,
        ),
        (
            "Sizes of tolerances and noise: prior medians",
            admire_identify::priors::TABLE,
        ),
        (
            "Further priors of the diagnosis",
            admire_diagnosis::priors::TABLE,
        ),
        (
            "Settings of the identification",
            admire_identify::settings::TABLE,
        ),
        (
            "Settings of the diagnosis",
            admire_diagnosis::settings::TABLE,
        ),
        ("Settings of `admire plan`", admire_design::settings::TABLE),
        ("Settings of `admire tune`", admire_tune::settings::TABLE),
    ];
    let mut out = String::new();
    for (k, (heading, table)) in sections.into_iter().enumerate() {
        line(
            &mut out,
            &format!("{}{heading}:", if k == 0 { "" } else { "\n" }),
        );
        for constant in table {
            out.push_str(&of_constant(constant));
        }
    }
    out
}

/// Formats a constant: its name and value in columns, and its meaning. If the name or value is too long for its column, the meaning starts
/// on the next line.
fn of_constant(constant: &Constant) -> String {
    let name = format!("  {:NAME_WIDTH$} ", constant.name);
    let value = format!("{} {}", constant.value, constant.unit);
    let value = value.trim();
    let meaning = constant.meaning.trim();
    if value.len() <= VALUE_WIDTH && constant.name.len() <= NAME_WIDTH {
        return hanging(&format!("{name}{value:VALUE_WIDTH$} "), meaning);
    }
    let blanks = " ".repeat(2 + NAME_WIDTH + 1 + VALUE_WIDTH + 1);
    hanging(&name, value) + &hanging(&blanks, meaning)
}

/// Formats an entry of the glossary, which comes from a guide table: the term, the contents of each column, and the page with more
/// information.
fn of_glossary(entry: &Entry) -> String {
    let mut out = String::new();
    line(&mut out, &format!("{} ({})", entry.term, entry.section));
    for (head, text) in &entry.cells {
        line(&mut out, &format!("  {head}: {text}"));
    }
    if !entry.picture.is_empty() {
        line(
            &mut out,
            "  picture: `o` readings, `.` model, `*` both at the same place",
        );
        for row in &entry.picture {
            line(&mut out, &format!("    {row}"));
        }
    }
    line(&mut out, &format!("  more: admire guide {}", entry.read_on));
    out
}

fn line(out: &mut String, text: &str) {
    out.push_str(text.trim_end());
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_keep_to_the_width() {
        let text = page("priors").unwrap();
        for line in text.lines() {
            assert!(
                line.chars().count() <= 80 && line.trim_end() == line,
                "{line}"
            );
        }
        let place = |word: &str| text.find(word).unwrap_or_else(|| panic!("{word}\n{text}"));
        let words = [
            "  hardpoint_mm ",
            "\n\nSizes of tolerances and noise: prior medians:\n",
            "  HARDPOINT_MEDIAN_MM              0.2 mm ",
            "\n\nFurther priors of the diagnosis:\n",
            "[0.06, 0.15, 0.4, 1.0] of range\n",
            "  HUBER_THRESHOLD_SIGMA ",
            "  MINOR_MARKS_SIGMA ",
            "  MAX_LOAD_CASES ",
        ];
        assert!(words.map(place).is_sorted(), "{text}");
    }

    #[test]
    fn codes_have_their_page() {
        let text = page("Undefined-Id").unwrap();
        assert!(
            text.starts_with("undefined-id\n  A statement refers to an id"),
            "{text}"
        );
        assert!(
            page("marks.sigma")
                .unwrap()
                .contains("sd of one coordinate")
        );
        assert!(page("dry-friction").unwrap().contains("hysteresis"));
        assert!(
            page("roll center")
                .unwrap()
                .contains("more: admire guide kc")
        );
        // A term of the field takes precedence over a statement whose abbreviation it is.
        let text = page("mark").unwrap();
        assert!(text.starts_with("mark (Measuring)\n") && text.contains("\n\nMarker/id"));
        assert!(page("marks.sgma").unwrap_err().contains("`marks.sigma`"));
        assert!(
            page("undefined-ids")
                .unwrap_err()
                .contains("`undefined-id`")
        );
    }
}
