use super::legend::Legend;
use super::{Bars, Chart, DrawingError, HeatMap, escape};

/// Picture on a page, with its title, caption and data.
#[derive(Clone, Debug)]
pub struct Figure {
    svg: String,
    pub(super) caption: String,
    pub(super) legend: Legend,
    name: String,
    csv: String,
}

impl Figure {
    /// Creates a figure from a chart, with a caption.
    ///
    /// # Errors
    /// [`DrawingError`] if the chart cannot be drawn.
    pub fn chart(chart: &Chart, caption: &str) -> Result<Self, DrawingError> {
        Ok(Self {
            svg: chart.svg()?,
            caption: caption.to_string(),
            legend: chart.legend(),
            name: chart.title.clone(),
            csv: chart.csv(),
        })
    }

    /// Creates a figure from a bar chart, with a caption.
    pub fn bars(bars: &Bars, caption: &str) -> Self {
        Self {
            svg: bars.svg(),
            caption: caption.to_string(),
            legend: Legend::default(),
            name: bars.title.clone(),
            csv: bars.csv(),
        }
    }

    /// Creates a figure from a heat map, with a caption.
    pub(crate) fn map(map: &HeatMap, caption: &str) -> Self {
        Self {
            svg: map.svg(),
            caption: caption.to_string(),
            legend: Legend::default(),
            name: map.title.clone(),
            csv: map.csv(),
        }
    }

    /// Returns the `<figure>` element. A link contains the data, so that the page remains a single file. Legend and caption can be left out if the
    /// page shows them elsewhere.
    pub(super) fn html(&self, with_legend: bool, with_caption: bool) -> String {
        let legend = if with_legend {
            self.legend.html()
        } else {
            String::new()
        };
        // On paper, a caption without a text is left out: there is no link either.
        let caption = if with_caption && !self.caption.is_empty() {
            format!("<span class=\"caption\">{}</span> ", escape(&self.caption))
        } else {
            String::new()
        };
        format!(
            "<figure><h4>{}</h4>{legend}{}<figcaption>{}<a download=\"{}.csv\" href=\"data:text/csv;charset=utf-8,{}\">Data (CSV)</a></figcaption></figure>\n",
            escape(&self.name),
            self.svg,
            caption,
            file_name(&self.name),
            percent(&self.csv)
        )
    }
}

/// Turns a title into a file name: letters and digits in lower case, words joined by hyphens.
fn file_name(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric());
    let name: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
    name.join("-").to_lowercase()
}

/// Percent-encodes all characters that a data URL may not contain literally.
fn percent(text: &str) -> String {
    let mut out = String::with_capacity(text.len() * 5 / 4);
    for byte in text.bytes() {
        if byte.is_ascii_alphanumeric() || b",.-_;:/()+*=".contains(&byte) {
            out.push(char::from(byte));
        } else {
            out.push_str(&format!("%{byte:02X}"));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_cannot_leave_their_link() {
        assert_eq!(percent("a,1\n\"<b>&'"), "a,1%0A%22%3Cb%3E%26%27");
        assert_eq!(file_name("Steer of \"A\" / <deg>"), "steer-of-a-deg");
    }
}
