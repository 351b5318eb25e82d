use super::Scene;
use crate::escape;

/// The client: drawing and controls.
pub(crate) const CLIENT: &str = include_str!("viewer.js");
/// Its style.
pub(crate) const CLIENT_STYLE: &str = include_str!("viewer.css");

impl Scene {
    /// The place of the picture in a page, with its data. `full` lets it fill the window.
    pub(crate) fn html(&self, full: bool) -> String {
        let data = serde_json::to_string(self).expect("a scene holds only names and numbers");
        // No `<` of a name can end the script.
        let data = data.replace('<', "\\u003c");
        format!(
            "<div class=\"scene{}\" role=\"group\" aria-label=\"{}\">\n<noscript>This picture needs JavaScript.</noscript>\n\
             <script type=\"application/json\">{data}</script>\n</div>\n",
            if full { " full" } else { "" },
            escape(&format!("Three-dimensional view: {}", self.title)),
        )
    }
}
