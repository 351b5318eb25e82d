//! Hover text: the grammar's description of an item. For an object, its statement and facts from the model are added.

use std::fmt::Write as _;
use std::path::Path;

use lsp_types::{Hover, HoverContents, HoverParams, MarkupContent, MarkupKind};

use super::cursor::{Cursor, Thing, cursor, locate_request};
use super::document::Document;
use super::excerpt::{Depth, Excerpt};
use super::position::range;
use super::workspace::Workspace;
use admire_solver::mechanics::psi_theta_phi;
use admire_solver::model::Model;
use admire_syntax::grammar::{ArgumentDef, StatementDef};
use admire_syntax::text::Span;
use admire_syntax::units::{Dimension, Units};
use admire_syntax::{Argument, ObjectId, describe};

/// Largest number of lines of a statement that are shown.
const MOST_LINES: usize = 12;
/// Largest number of statements in the excerpt from which the facts about an object are taken.
const MOST_STATEMENTS: usize = 2000;

pub(super) fn hover(workspace: &mut Workspace, params: &HoverParams) -> Option<Hover> {
    let (path, _, offset) = locate_request(workspace, &params.text_document_position_params)?;
    if let Some(deck) = workspace.deck_of(&path, offset) {
        workspace.read(&deck);
    }
    let file = workspace.file(&path)?;
    let found = cursor(&file.document, offset)?;
    let value = match found.thing {
        Thing::Object(object) => of_object(workspace, &path, &found, object, offset)?,
        Thing::Statement(def) => format!("```text\n{}```", describe::statement(def)),
        Thing::Argument(def, argument) => of_argument(&file.document, def, argument),
        Thing::Function(def) => format!("```text\n{}```", describe::function(def)),
        Thing::Deck => workspace.deck_of(&path, offset)?.display().to_string(),
    };
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent {
            kind: MarkupKind::Markdown,
            value,
        }),
        range: Some(range(file.document.pieces(), found.span)),
    })
}

fn of_argument(document: &Document, def: &StatementDef, argument: &ArgumentDef) -> String {
    let mut out = format!(
        "**{}**{} of {}\n\n{}\n",
        argument.name,
        describe::value(argument),
        def.name,
        argument.doc
    );
    let mut details = describe::details(argument);
    if argument.dimension != Dimension::NONE {
        let units = units(document);
        details.push(format!("in {}", units.name(argument.dimension)));
    }
    if !details.is_empty() {
        _ = write!(out, "\n{}\n", details.join("; "));
    }
    _ = write!(
        out,
        "\n{}\n\nSource: {}",
        describe::solved(def.solved),
        def.source
    );
    out
}

/// Returns the units of a document, or the default units of ADAMS if the document has no UNITS statement.
fn units(document: &Document) -> Units {
    let stated = document
        .statements()
        .find(|(_, _, s)| s.kind() == Some("UNITS"));
    let excerpt = Excerpt::of(document, stated.map(|(place, _, _)| place), Depth::One);
    Model::lower(&excerpt.dataset).value.units
}

fn of_object(
    workspace: &Workspace,
    path: &Path,
    found: &Cursor,
    object: ObjectId,
    offset: usize,
) -> Option<String> {
    let own = &workspace.file(path)?.document;
    let deck = if own.is_command_file() {
        workspace.deck_of(path, offset)
    } else {
        Some(path.to_path_buf())
    };
    let document = deck.and_then(|deck| Some(&workspace.file(&deck)?.document));
    let defined =
        document.and_then(|document| Some((document, *document.definitions(object).first()?)));
    let Some((document, place)) = defined else {
        // The object is not defined. It is named by a command that redefines it, or by a reference.
        let def = own.statement(found.place?).def?;
        return Some(format!(
            "{}/{} is not defined\n\n{}",
            object.0.to_uppercase(),
            object.1,
            def.doc
        ));
    };
    let statement = document.statement(place);
    let def = statement.def?;
    let source = document.pieces().pieces()[place.0].source();
    let mut out = format!("**{}/{}**", def.name, object.1);
    if let Some(name) = statement.view_name {
        _ = write!(out, " {}", source.text(name));
    }
    _ = write!(out, "\n\n{}\n", def.doc);
    for line in facts(document, place, object) {
        _ = write!(out, "\n{line}\n");
    }
    let text = source.text(statement.span);
    let lines: Vec<&str> = text.lines().collect();
    let shown = lines[..lines.len().min(MOST_LINES)].join("\n");
    let more = if lines.len() > MOST_LINES {
        "\n..."
    } else {
        ""
    };
    _ = write!(
        out,
        "\n```adams\n{shown}{more}\n```\n\n{}",
        describe::solved(def.solved)
    );
    Some(out)
}

/// Returns facts about an object from the model: the position of a marker in ground, numbers with their units, and the connected bodies.
fn facts(document: &Document, place: (usize, usize), object: ObjectId) -> Vec<String> {
    let units = document
        .statements()
        .find(|(_, _, s)| s.kind() == Some("UNITS"));
    let asked = units.map(|(place, _, _)| place).into_iter().chain([place]);
    let excerpt = Excerpt::of(document, asked, Depth::All(MOST_STATEMENTS));
    let dataset = &excerpt.dataset;
    let model = Model::lower(dataset).value;
    let mut facts = Vec::new();
    let statement = document.statement(place);
    let def = statement.def;
    if object.0 == "marker"
        && let Some(index) = model.marker(object.1)
    {
        let marker = &model.markers[index.0];
        let part = &model.parts[marker.part.0];
        match model.marker_pose(index) {
            Some(pose) => {
                let [x, y, z] = [pose.p.x, pose.p.y, pose.p.z].map(short);
                facts.push(format!(
                    "Position in ground: {x}, {y}, {z} {}",
                    model.units.length.word
                ));
                let angles =
                    psi_theta_phi(&pose.R).map(|angle| format!("{}D", short(angle.to_degrees())));
                facts.push(format!(
                    "Orientation in ground: REULER = {}",
                    angles.join(", ")
                ));
            }
            None => facts.push("The marker has no fixed position".to_string()),
        }
        facts.push(format!("On part {} {}", part.header.id, part.header.name));
    }
    // Numbers with a dimension, such as stiffnesses, masses and lengths, are shown with their units.
    for argument in &statement.arguments {
        let Some(own) = argument.def.filter(|_| object.0 != "marker") else {
            continue;
        };
        let unit = model.units.name(own.dimension_of(0));
        if unit.is_empty() || argument.numbers().is_empty() || argument.numbers().len() > 12 {
            continue;
        }
        let number = |number: &admire_syntax::Number| {
            if own.dimension == Dimension::ANGLE {
                format!("{}D", short(number.value.to_degrees()))
            } else {
                short(number.value)
            }
        };
        let values: Vec<String> = Argument::numbers(argument).iter().map(number).collect();
        let unit = if own.dimension == Dimension::ANGLE {
            String::new()
        } else {
            format!(" {unit}")
        };
        facts.push(format!(
            "{} = {}{unit}: {}",
            own.name,
            values.join(", "),
            own.doc
        ));
    }
    let on: Vec<String> = dataset
        .position(def.map_or("", |def| def.name), Some(object.1))
        .map(|at| admire_syntax::Topology::of(dataset).attached(&dataset.statements()[at]))
        .unwrap_or_default()
        .iter()
        .filter_map(|(space, id)| {
            let body = document.definitions((space, *id)).first().copied()?;
            let name = document.statement(body).view_name;
            let name = name.map(|name: Span| {
                document.pieces().pieces()[body.0]
                    .source()
                    .text(name)
                    .into_owned()
            });
            Some(
                format!("{}/{id} {}", space.to_uppercase(), name.unwrap_or_default())
                    .trim()
                    .to_string(),
            )
        })
        .collect();
    if on.len() > 1 {
        facts.push(format!("Between {}", on.join(" and ")));
    }
    facts
}

/// Formats a number with six significant digits, which hides rounding noise.
fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}").parse::<f64>().unwrap_or(value);
    if rounded == 0.0 || (1e-4..1e7).contains(&rounded.abs()) {
        format!("{}", rounded + 0.0)
    } else {
        format!("{rounded:e}")
    }
}
