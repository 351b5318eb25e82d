use admire_syntax::CommandFile;
use admire_syntax::text::{Edit, Source, apply_edits};

/// Replaces each model that a command file names by the model `name`. If the file names no model, a command that reads `name` is put first.
pub fn commands_for_other_model(name: &str, source: &Source) -> Source {
    let file = CommandFile::parse(source.clone()).value;
    let mut edits = Vec::new();
    if let Some(head) = file.head() {
        edits.push(Edit::new(head.model, name));
    }
    let reading = file.commands().iter().filter(|c| c.kind() == Some("FILE"));
    for model in reading.filter_map(|command| command.argument("MODEL")) {
        edits.push(Edit::new(model.value_span(), name));
    }
    let bytes = if edits.is_empty() {
        let mut text = format!("\nfile/model={name}\n").into_bytes();
        text.extend(source.bytes());
        text
    } else {
        apply_edits(source.bytes(), &edits).unwrap_or_else(|_| source.bytes().to_vec())
    };
    Source::new(source.name(), bytes)
}
