//! Last lines of a command that fits a study.

use std::path::Path;

use admire_report::Summary;

use super::width::{WIDTH, hanging};

/// Largest number of lines at the end of `identify` and `diagnose`. Two more lines may name doubtful properties and notes of the study.
const MAX_LINES: usize = 13;
/// Largest number of lines for the verdict.
const MAX_VERDICT_LINES: usize = 4;
/// Largest number of lines for one finding.
const MAX_FINDING_LINES: usize = 2;
/// Largest number of lines for the gain on readings that were held out.
const MAX_GAIN_LINES: usize = 3;
/// Largest number of lines for the next step.
const MAX_NEXT_LINES: usize = 4;

/// Formats a summary in at most [`MAX_LINES`] lines, with the paths of the written files, each after its name. Text that does not fit is only in the
/// report.
pub(super) fn ending(summary: &Summary, written: &[(&str, &Path)]) -> String {
    let verdict = shortened("", &summary.verdict, MAX_VERDICT_LINES);
    let gain = shortened("held out: ", &summary.held_out, MAX_GAIN_LINES);
    let next = shortened("next: ", &summary.next, MAX_NEXT_LINES);
    let paths = written
        .iter()
        .map(|(what, path)| format!("{what}: {}\n", path.display()));
    let rest = gain + &next + &paths.collect::<String>();
    let taken = verdict.lines().count() + rest.lines().count();
    let found = items(&summary.items, MAX_LINES.saturating_sub(taken));
    verdict + &found + &rest
}

/// Lists the written files: the report, and the folder of the files for Adams/Car if there are any.
pub(super) fn written<'a>(report: &'a Path, for_car: Option<&'a Path>) -> Vec<(&'a str, &'a Path)> {
    let car = for_car.map(|folder| ("for Adams/Car", folder));
    car.into_iter().chain([("report", report)]).collect()
}

/// Formats items in at most `room` lines. Short items share a line if there are too many of them.
fn items(items: &[String], room: usize) -> String {
    let longest = items.iter().map(|item| item.chars().count()).max();
    let width = longest.unwrap_or(0);
    let blocks: Vec<String> = if items.len() > room && 2 * (width + 2) <= WIDTH {
        items
            .chunks(2)
            .map(|pair| match pair {
                [left, right] => format!("  {left:width$}  {right}\n"),
                _ => format!("  {}\n", pair.concat()),
            })
            .collect()
    } else {
        let block = |item: &String| shortened("  ", item, MAX_FINDING_LINES);
        items.iter().map(block).collect()
    };
    let lines = |blocks: &[String]| blocks.concat().lines().count();
    if lines(&blocks) <= room {
        return blocks.concat();
    }
    let fit = (0..blocks.len())
        .rev()
        .find(|shown| lines(&blocks[..*shown]) < room);
    let shown = fit.unwrap_or(0);
    let each = items.len().div_ceil(blocks.len());
    let more = items.len() - shown * each;
    blocks[..shown].concat() + &format!("  {more} more: see the report, or print them with -v\n")
}

/// Wraps a text as [`hanging`] does, and cuts it after a number of lines. Three points mark the cut.
fn shortened(head: &str, text: &str, lines: usize) -> String {
    if text.is_empty() {
        return String::new();
    }
    let whole = hanging(head, text);
    if whole.lines().count() <= lines {
        return whole;
    }
    let kept: Vec<&str> = whole.lines().take(lines).collect();
    let mut kept = kept.join("\n");
    let last = kept.rfind('\n').map_or(0, |at| at + 1);
    // The points need four columns of the last line.
    while kept[last..].chars().count() + 4 > WIDTH {
        match kept.rfind(' ').filter(|at| *at > last) {
            Some(at) => kept.truncate(at),
            None => break,
        }
    }
    kept + " ...\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(items: &[String]) -> Summary {
        let long = "word ".repeat(200);
        Summary {
            verdict: long.clone(),
            items: items.to_vec(),
            held_out: long.clone(),
            next: long,
        }
    }

    /// A summary has at most [`MAX_LINES`] lines, and no line is wider than the terminal, however long the texts are.
    #[test]
    fn a_summary_is_short() {
        let report = Path::new("out/report.html");
        for (count, words) in [(0, 0), (1, 90), (3, 30), (40, 4)] {
            let item = |k: usize| format!("{k} {}", "size ".repeat(words).trim_end());
            let items: Vec<String> = (0..count).map(item).collect();
            let text = ending(&summary(&items), &[("report", report)]);
            assert!(text.lines().count() <= MAX_LINES, "{text}");
            assert!(
                text.lines().all(|line| line.chars().count() <= WIDTH),
                "{text}"
            );
            assert!(text.ends_with("report: out/report.html\n"), "{text}");
        }
    }

    /// Items that are left out are counted. Short items share a line before any item is left out.
    #[test]
    fn what_is_left_out_is_counted() {
        let many: Vec<String> = (0..12).map(|k| format!("BUSHING/{k} 1 ± 2 N/mm")).collect();
        let text = items(&many, 6);
        assert_eq!(text.lines().count(), 6, "{text}");
        assert!(many.iter().all(|item| text.contains(item)), "{text}");
        let text = items(&many, 4);
        assert_eq!(text.lines().count(), 4, "{text}");
        assert!(text.contains("  6 more: "), "{text}");
    }
}
