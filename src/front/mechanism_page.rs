//! Page that shows a mechanism in three dimensions, and the comparison of two results files.

use std::path::Path;

use admire_report::scene::motion;
use admire_report::{Page, Scene, VERSION};
use admire_results::{DifferenceFloor, ResultsError, Timestamp, Tolerance, compare_above};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::deck::Deck;
use super::error::{Error, ErrorKind};
use super::results::open;

fn refused(error: ResultsError) -> Error {
    Error::plain(ErrorKind::Input, &error.into_diagnostic())
}

impl Deck {
    /// Returns a page with the mechanism, moving through the steps of a results file if one is given. Objects with these addresses are
    /// highlighted.
    ///
    /// # Errors
    /// When the deck has errors, the results file cannot be read or moves no part of the deck, or an address names nothing that is drawn.
    pub(crate) fn mechanism_page(
        &self,
        results: Option<&Path>,
        highlight: &[String],
    ) -> Result<String, Error> {
        let (model, _) = self.model()?;
        let mut scene = Scene::of(&model, Some(self.dataset()));
        if scene.title.is_empty() {
            scene.title = self.name().to_string();
        }
        if let Some(path) = results {
            let mut reader = open(path)?;
            let found = motion(&scene, reader.as_mut()).map_err(refused)?;
            let bodies = scene.parts.iter().filter(|part| !part.ground).count();
            if bodies > 0 && found.missing.len() == bodies {
                let message = "the results contain no position of any part of the deck";
                let none = Diagnostic::error(Code::UndefinedId, message);
                return Err(Error::plain(ErrorKind::Input, &none));
            }
            scene.frames = found.frames;
        }
        for address in highlight {
            if !scene.highlight(address, address) {
                let message = format!("the view contains no part, joint or force `{address}`");
                let none = Diagnostic::error(Code::UndefinedId, message);
                return Err(Error::plain(ErrorKind::Usage, &none));
            }
        }
        let parts = scene.parts.iter().filter(|part| !part.ground).count();
        let lead = format!(
            "{parts} parts, {} joints and forces; lengths in {}",
            scene.objects.len(),
            scene.length
        );
        let time = Timestamp::now().date_time();
        let footer = format!("{} · admire {VERSION} · {time} UTC", self.name());
        Ok(Page::of_scene(&scene, &lead, &footer))
    }
}

/// Compares two results files. Returns the comparison as the JSON that `admire compare` prints, and whether the files agree. Differences up to
/// `share` of the largest value in their unit count as round-off.
///
/// # Errors
/// When one of the files cannot be read.
pub(crate) fn compared(
    a: &Path,
    b: &Path,
    tolerance: Tolerance,
    share: f64,
) -> Result<(String, bool), Error> {
    let mut floor = DifferenceFloor::new(share);
    if share > 0.0 {
        for path in [a, b] {
            floor.look(open(path)?.as_mut()).map_err(refused)?;
        }
    }
    let (mut first, mut second) = (open(a)?, open(b)?);
    let found = compare_above(first.as_mut(), second.as_mut(), tolerance, &floor);
    let found = found.map_err(refused)?;
    let text = serde_json::to_string(&found).expect("comparisons hold only names and numbers");
    Ok((text, found.agrees()))
}
