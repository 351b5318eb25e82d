use super::Scene;
use crate::escape;

/// Script that draws the three-dimensional view and handles its controls.
pub(crate) const CLIENT: &str = include_str!("viewer.js");
/// Style sheet of the three-dimensional view.
pub(crate) const CLIENT_STYLE: &str = include_str!("viewer.css");

impl Scene {
    /// Returns the HTML element of the view with its data. If `full` is set, the view fills the window.
    pub(crate) fn html(&self, full: bool) -> String {
        let data = serde_json::to_string(self).expect("a scene holds only names and numbers");
        // Without any `<` in the data, a name cannot close the script element.
        let data = data.replace('<', "\\u003c");
        format!(
            "<div class=\"scene{}\" role=\"group\" aria-label=\"{}\">\n<noscript>This picture needs JavaScript.</noscript>\n\
             <script type=\"application/json\">{data}</script>\n</div>\n",
            if full { " full" } else { "" },
            escape(&format!("Three-dimensional view: {}", self.title)),
        )
    }
}
