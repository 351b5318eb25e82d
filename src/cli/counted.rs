/// Formats a number of things with their name, which is in the plural unless the number is 1: `1 step`, `3 steps`.
pub(super) fn counted(count: usize, what: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{count} {what}{end}")
}
