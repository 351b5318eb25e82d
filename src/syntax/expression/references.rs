use super::{Expression, Node};

/// Returns, for each argument of a function, the id space of the objects it refers to, or `None` if the argument is a plain value.
///
/// The last entry applies to all further arguments. Id spaces are named as in the grammar. Functions that are not listed here take only
/// plain values.
fn argument_spaces(function: &str) -> &'static [Option<&'static str>] {
    const MARKER: Option<&str> = Some("marker");
    const MARKERS: &[Option<&str>] = &[MARKER];
    match function {
        "DX" | "DY" | "DZ" | "DM" | "VX" | "VY" | "VZ" | "VM" | "VR" | "ACCX" | "ACCY" | "ACCZ"
        | "ACCM" | "WX" | "WY" | "WZ" | "WM" | "WDTX" | "WDTY" | "WDTZ" | "WDTM" | "AX" | "AY"
        | "AZ" | "PSI" | "THETA" | "PHI" | "YAW" | "PITCH" | "ROLL" | "INCANG" | "FX" | "FY"
        | "FZ" | "FM" | "TX" | "TY" | "TZ" | "TM" | "DXYZ" | "VXYZ" | "ACCXYZ" | "WXYZ"
        | "WDTXYZ" | "FXYZ" | "TXYZ" | "UVX" | "UVY" | "UVZ" => MARKERS,
        "TRANS" => &[None, MARKER],
        "ORIENT" => &[None, None, MARKER],
        "AKISPL" | "CUBSPL" | "INTERP" => &[None, None, Some("spline"), None],
        "INVPSD" => &[None, Some("spline"), None],
        "DELAY" => &[None, None, None, Some("array")],
        "Q" | "QDOT" | "QDDOT" => &[Some("flex_body"), None],
        "CURVE" => &[None, None, None, Some("curve"), None],
        "VARVAL" => &[Some("variable"), None],
        "ARYVAL" => &[Some("array"), None],
        "DIF" | "DIF1" => &[Some("diff"), None],
        "PINVAL" => &[Some("pinput"), None],
        "POUVAL" => &[Some("poutput"), None],
        "SENVAL" => &[Some("sensor"), None],
        "BEAM" => &[Some("beam"), None, None, MARKER],
        "BUSH" => &[Some("bushing"), None, None, MARKER],
        "FIELD" => &[Some("field"), None, None, MARKER],
        "GFORCE" => &[Some("gforce"), None, None, MARKER],
        "SFORCE" => &[Some("sforce"), None, None, MARKER],
        "SPDP" => &[Some("springdamper"), None, None, MARKER],
        "VFORCE" => &[Some("vforce"), None, None, MARKER],
        "VTORQ" => &[Some("vtorque"), None, None, MARKER],
        "NFORCE" => &[Some("nforce"), MARKER, None, MARKER],
        "FRICTION" => &[Some("friction"), None],
        "CONTACT" => &[Some("contact"), None, None, MARKER],
        "JOINT" => &[Some("joint"), None, None, MARKER],
        "JPRIM" => &[Some("jprim"), None, None, MARKER],
        "MOTION" => &[Some("motion"), None, None, MARKER],
        "PTCV" => &[Some("ptcv"), None, None, MARKER],
        "CVCV" => &[Some("cvcv"), None, None, MARKER],
        "UCON" => &[Some("ucon"), None, None, MARKER],
        _ => &[None],
    }
}

/// Returns the id space of the objects to which argument `at` (from 0) of a function refers, or `None` for a plain value.
pub fn argument_space(function: &str, at: usize) -> Option<&'static str> {
    let spaces = argument_spaces(function);
    spaces[at.min(spaces.len() - 1)]
}

impl Expression {
    /// Returns the literals that are ids, as pairs (id space, index in [`literals`](Expression::literals)) in order of appearance.
    ///
    /// A literal 0 means ground and is left out.
    pub fn references(&self) -> Vec<(&'static str, usize)> {
        let mut found = Vec::new();
        for node in self.root.walk() {
            let Node::Call {
                function,
                arguments,
                ..
            } = node
            else {
                continue;
            };
            let spaces = argument_spaces(function.name);
            for (k, argument) in arguments.iter().enumerate() {
                if let (Some(space), Node::Literal(literal)) =
                    (spaces[k.min(spaces.len() - 1)], argument)
                    && self.literals[*literal].value != 0.0
                {
                    found.push((space, *literal));
                }
            }
        }
        found.sort_by_key(|(_, literal)| *literal);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_told_from_values() {
        let text =
            "DX(11,1,0)*2 + IF(VARVAL(3): AKISPL(DM(7,8),0,9,1), ORIENT(27,1,5), BUSH(4,1,2,6))";
        let expression = Expression::parse_str(text).unwrap();
        let found: Vec<_> = expression
            .references()
            .into_iter()
            .map(|(space, literal)| (space, expression.literals[literal].value))
            .collect();
        assert_eq!(
            found,
            [
                ("marker", 11.0),
                ("marker", 1.0),
                ("variable", 3.0),
                ("marker", 7.0),
                ("marker", 8.0),
                ("spline", 9.0),
                ("marker", 5.0),
                ("bushing", 4.0),
                ("marker", 6.0),
            ]
        );
    }

    #[test]
    fn vectors_along_other_axes_name_markers() {
        let expression = Expression::parse_str("MAG(TRANS(VXYZ(1,2,3),4,3))").unwrap();
        let markers = expression.references();
        assert!(markers.iter().all(|(space, _)| *space == "marker"));
        assert_eq!(markers.len(), 5);
    }

    #[test]
    fn every_space_is_one_of_the_grammar() {
        for function in crate::grammar::FUNCTIONS {
            for space in argument_spaces(function.name).iter().flatten() {
                assert!(
                    crate::grammar::STATEMENTS
                        .iter()
                        .any(|statement| statement.id == Some(*space)),
                    "{}: {space}",
                    function.name
                );
            }
        }
    }
}
