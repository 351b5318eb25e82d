use std::collections::{BTreeMap, VecDeque};
use std::fmt::Write as _;

use admire_syntax::{Dataset, ObjectId, Statement, Topology};

use super::escape;
use admire_syntax::text::printable;

/// Graph of bodies and the elements between them, drawn as SVG or as text for Graphviz.
#[derive(Clone, PartialEq, Debug)]
pub struct TopologyGraph {
    /// Title of the dataset.
    pub title: String,
    /// Bodies in the order of the dataset.
    pub bodies: Vec<GraphBody>,
    /// Links between two bodies, in the order of the dataset. An element on more than two bodies has a link from its first body to each
    /// other body.
    pub links: Vec<Link>,
}

/// Body of the graph: a part, a point mass or ground.
#[derive(Clone, PartialEq, Debug)]
pub struct GraphBody {
    /// Kind and id of the body's statement, such as `PART/4`.
    pub address: String,
    /// View name of the body. A body without a view name has its address as name.
    pub name: String,
    /// True for the ground body.
    pub ground: bool,
}

/// Link of the graph: an element between two bodies.
#[derive(Clone, PartialEq, Debug)]
pub struct Link {
    /// Indices of the two bodies in [`TopologyGraph::bodies`].
    pub ends: [usize; 2],
    /// Kind and id of the element's statement, such as `JOINT/3`.
    pub address: String,
    /// View name or address of the element, followed by its type if it has one: `front_ball (SPHERICAL)`.
    pub name: String,
    /// True for a constraint, false for a force.
    pub constraint: bool,
}

impl TopologyGraph {
    /// Creates the graph of a dataset, with printable names. Elements on a single body, measurements and graphics are left out.
    pub fn of(dataset: &Dataset) -> Self {
        let topology = Topology::of(dataset);
        let address = |statement: &Statement| {
            let kind = statement.kind().unwrap_or("statement");
            format!("{kind}/{}", statement.number().unwrap_or_default())
        };
        let name = |statement: &Statement| match statement.view_name {
            Some(name) => printable(&dataset.source().text(name)).into_owned(),
            None => address(statement),
        };
        let (mut bodies, mut places) = (Vec::new(), BTreeMap::<ObjectId, usize>::new());
        for statement in dataset.statements().iter().filter(|s| s.is_body()) {
            let Some(object) = statement.object() else {
                continue;
            };
            places.entry(object).or_insert_with(|| {
                bodies.push(GraphBody {
                    address: address(statement),
                    name: name(statement),
                    ground: statement.has("GROUND"),
                });
                bodies.len() - 1
            });
        }
        let mut links = Vec::new();
        for statement in dataset.statements() {
            let constraint = match statement.kind() {
                Some("JOINT" | "JPRIM" | "MOTION" | "PTCV" | "CVCV" | "UCON") => true,
                Some(
                    "BEAM" | "BUSHING" | "FIELD" | "SPRINGDAMPER" | "SFORCE" | "VFORCE" | "VTORQUE"
                    | "GFORCE" | "NFORCE" | "CONTACT" | "TIRE",
                ) => false,
                _ => continue,
            };
            let ends: Vec<usize> = topology
                .attached(statement)
                .iter()
                .filter_map(|body| places.get(body).copied())
                .collect();
            let kind = statement
                .arguments
                .iter()
                .filter_map(admire_syntax::Argument::kind)
                .find(|kind| TYPES.contains(kind));
            let label = match kind {
                Some(kind) => format!("{} ({kind})", name(statement)),
                None => name(statement),
            };
            if let [first, others @ ..] = ends.as_slice() {
                links.extend(others.iter().map(|other| Link {
                    ends: [*first, *other],
                    address: address(statement),
                    name: label.clone(),
                    constraint,
                }));
            }
        }
        Self {
            title: printable(&dataset.title()).into_owned(),
            bodies,
            links,
        }
    }

    /// Returns the graph in the Graphviz language. Bodies are identified by address, because names may repeat.
    pub fn dot(&self) -> String {
        let quoted =
            |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        let mut out = format!(
            "graph {} {{\n  overlap = false\n  node [shape = box, fontname = \"sans-serif\"]\n  edge [fontname = \"sans-serif\", fontsize = 10]\n",
            quoted(&self.title)
        );
        for body in &self.bodies {
            let style = if body.ground { ", style = filled" } else { "" };
            _ = writeln!(
                out,
                "  {} [label = {}{style}]",
                quoted(&body.address),
                quoted(&body.name)
            );
        }
        for link in &self.links {
            let [a, b] = link.ends.map(|end| quoted(&self.bodies[end].address));
            let style = if link.constraint { "solid" } else { "dashed" };
            _ = writeln!(
                out,
                "  {a} -- {b} [label = {}, tooltip = {}, style = {style}]",
                quoted(&link.name),
                quoted(&link.address)
            );
        }
        out.push_str("}\n");
        out
    }

    /// Draws the graph as SVG. Ground is at the bottom. The row of every other body is its number of links from ground.
    pub fn svg(&self) -> String {
        let places = self.places();
        let wide = |text: &str| 7.2 * text.chars().count() as f64;
        let width = places.iter().map(|p| p.0).fold(0.0, f64::max) + COLUMN;
        let height = places.iter().map(|p| p.1).fold(0.0, f64::max) + 70.0;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.0}\" height=\"{height:.0}\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text x=\"12\" y=\"22\" font-size=\"15\">{}</text>\n",
            escape(&self.title)
        );
        let mut labels = String::new();
        let mut seen: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for link in &self.links {
            let mut pair = link.ends;
            pair.sort_unstable();
            let count = seen.entry(pair).or_default();
            // Links between the same two bodies are bent alternately to both sides.
            let bend =
                if count.is_multiple_of(2) { 1.0 } else { -1.0 } * 34.0 * count.div_ceil(2) as f64;
            *count += 1;
            let [(x0, y0), (x1, y1)] = pair.map(|end| places[end]);
            let length = libm::hypot(x1 - x0, y1 - y0).max(1.0);
            let flat = if (y1 - y0).abs() < 1.0 { 46.0 } else { 0.0 };
            let (nx, ny) = (-(y1 - y0) / length, (x1 - x0) / length);
            let (cx, cy) = (
                f64::midpoint(x0, x1) + nx * (bend + flat) * 2.0,
                f64::midpoint(y0, y1) + ny * (bend + flat) * 2.0,
            );
            let (colour, dash) = if link.constraint {
                ("#1f4e79", "")
            } else {
                ("#b03a2e", " stroke-dasharray=\"6 3\"")
            };
            let tip = format!(
                "<title>{}: {}</title>",
                escape(&link.address),
                escape(&link.name)
            );
            _ = writeln!(
                out,
                "<path d=\"M{x0:.1},{y0:.1} Q{cx:.1},{cy:.1} {x1:.1},{y1:.1}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"{dash}>{tip}</path>"
            );
            // The label is at the middle of the curve.
            let (mx, my) = (0.25 * (x0 + 2.0 * cx + x1), 0.25 * (y0 + 2.0 * cy + y1));
            // The white outline is drawn separately, because not every viewer draws it below the letters.
            for edge in [" stroke=\"white\" stroke-width=\"3\"", ""] {
                _ = writeln!(
                    labels,
                    "<text x=\"{mx:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"10\" fill=\"{colour}\"{edge}>{}{tip}</text>",
                    my + 3.0,
                    escape(&shortened(&link.name, 28))
                );
            }
        }
        out += &labels;
        for (body, (x, y)) in self.bodies.iter().zip(&places) {
            let name = shortened(&body.name, 22);
            let half = f64::midpoint(wide(&name), 16.0);
            let fill = if body.ground { "#d5d8dc" } else { "#fdf6e3" };
            _ = writeln!(
                out,
                "<g><title>{}: {}</title><rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"26\" rx=\"4\" fill=\"{fill}\" stroke=\"black\"/>\
                 <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text></g>",
                escape(&body.address),
                escape(&body.name),
                x - half,
                y - 13.0,
                2.0 * half,
                y + 4.0,
                escape(&name)
            );
        }
        out.push_str("</svg>\n");
        out
    }

    /// Returns the positions of the bodies. The row of a body is its number of links from ground; within a row, a body is placed near its
    /// neighbours.
    fn places(&self) -> Vec<(f64, f64)> {
        let count = self.bodies.len();
        let mut near = vec![Vec::new(); count];
        for link in &self.links {
            let [a, b] = link.ends;
            near[a].push(b);
            near[b].push(a);
        }
        let mut row = vec![usize::MAX; count];
        let mut open: VecDeque<usize> = (0..count).filter(|at| self.bodies[*at].ground).collect();
        for at in &open {
            row[*at] = 0;
        }
        while let Some(at) = open.pop_front() {
            for &next in &near[at] {
                if row[next] == usize::MAX {
                    row[next] = row[at] + 1;
                    open.push_back(next);
                }
            }
        }
        let top = row
            .iter()
            .filter(|r| **r != usize::MAX)
            .max()
            .copied()
            .unwrap_or(0)
            + 1;
        // Bodies without a path to ground are placed above all others.
        let mut rows = vec![Vec::new(); top + 1];
        for (at, row) in row.iter_mut().enumerate() {
            *row = (*row).min(top);
            rows[*row].push(at);
        }
        let widest = rows.iter().map(Vec::len).max().unwrap_or(1).max(1);
        let mut x = vec![0.0; count];
        let spread = |x: &mut Vec<f64>, row: &[usize]| {
            let step = COLUMN * widest as f64 / row.len().max(1) as f64;
            for (k, at) in row.iter().enumerate() {
                x[*at] = (k as f64 + 0.5) * step;
            }
        };
        for row in &rows {
            spread(&mut x, row);
        }
        for _ in 0..SWEEPS {
            for row in &mut rows {
                let middle = |at: &usize| {
                    let all = &near[*at];
                    let sum: f64 = all.iter().map(|other| x[*other]).sum();
                    if all.is_empty() {
                        x[*at]
                    } else {
                        sum / all.len() as f64
                    }
                };
                let mut keyed: Vec<(f64, usize)> = row.iter().map(|at| (middle(at), *at)).collect();
                keyed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                *row = keyed.into_iter().map(|(_, at)| at).collect();
                spread(&mut x, row);
            }
        }
        let used = if rows[top].is_empty() { top } else { top + 1 };
        (0..count)
            .map(|at| {
                (
                    x[at] + 20.0,
                    60.0 + ROW * (used - 1 - row[at].min(used - 1)) as f64,
                )
            })
            .collect()
    }
}

/// Keywords that state the type of an element.
const TYPES: [&str; 20] = [
    "SPHERICAL",
    "REVOLUTE",
    "TRANSLATIONAL",
    "CYLINDRICAL",
    "PLANAR",
    "FIXED",
    "HOOKE",
    "UNIVERSAL",
    "CONVEL",
    "SCREW",
    "RACKPIN",
    "ATPOINT",
    "INLINE",
    "INPLANE",
    "ORIENTATION",
    "PARALLEL_AXES",
    "PERPENDICULAR",
    "ROTATIONAL",
    "ACTIONONLY",
    "ROTATION",
];
const COLUMN: f64 = 190.0;
const ROW: f64 = 130.0;
const SWEEPS: usize = 12;

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_string();
    }
    let start: String = text.chars().take(most - 1).collect();
    format!("{start}\u{2026}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::Source;

    fn sample() -> TopologyGraph {
        let deck = "four\nPART/1, GROUND\nMARKER/1, PART=1\n! adams_view_name='crank \"a\"'\nPART/2, MASS=1, CM=20\nMARKER/20, PART=2\nMARKER/21, PART=2\n\
                    PART/3, MASS=1, CM=30\nMARKER/30, PART=3\nPART/4\nMARKER/40, PART=4\n! adams_view_name='<pin>'\nJOINT/1, REVOLUTE, I=20, J=1\n\
                    BUSHING/1, I=30, J=21\nREQUEST/1, DISP, I=30, J=1\nEND\n";
        TopologyGraph::of(&Dataset::parse(Source::new("a", deck.as_bytes())).value)
    }

    #[test]
    fn bodies_and_links_of_a_chain() {
        let graph = sample();
        assert_eq!(graph.bodies.len(), 4);
        let links: Vec<(&str, [usize; 2])> = graph
            .links
            .iter()
            .map(|link| (link.name.as_str(), link.ends))
            .collect();
        assert_eq!(links, [("<pin> (REVOLUTE)", [1, 0]), ("BUSHING/1", [2, 1])]);
        let y: Vec<f64> = graph.places().iter().map(|place| place.1).collect();
        assert!(y[0] > y[1] && y[1] > y[2] && y[2] > y[3], "{y:?}");
        let dot = graph.dot();
        assert!(
            dot.contains("\"PART/2\" [label = \"crank \\\"a\\\"\"]"),
            "{dot}"
        );
        assert!(
            dot.contains("\"PART/3\" -- \"PART/2\" [label = \"BUSHING/1\""),
            "{dot}"
        );
        let svg = graph.svg();
        assert!(svg.contains("&lt;pin&gt; (REVOLUTE)") && !svg.contains("<pin>"));
    }
}
