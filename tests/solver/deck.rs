//! Decks to models.

use admire::model::Model;
use admire::syntax::Dataset;
use admire::text::Source;

pub fn read(text: &str) -> Model {
    let dataset = Dataset::parse(Source::new("test.adm", text.as_bytes().to_vec()));
    assert!(!dataset.has_errors(), "{:#?}", dataset.diagnostics);
    let model = Model::lower(&dataset.value);
    assert!(!model.has_errors(), "{:#?}", model.diagnostics);
    model.value
}
